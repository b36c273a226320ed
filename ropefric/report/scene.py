"""A scene's answer and its plan, told to people."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ropefric.glossary import GLOSSARY
from ropefric.report.section import Section, Table

if TYPE_CHECKING:
    from ropefric.scenes.kind import Part
    from ropefric.scenes.plan import Decision, Explanation
    from ropefric.scenes.solve import Solution, Uncertain
    from ropefric.scenes.sweep import Sweep


_NAMED = 4


def solution_sections(solution: "Solution", tree: Mapping[str, Any]) -> list[Section]:
    """Return what a scene's answer is, how sure, and what was simulated for it; `tree` is its `to_dict()`."""
    scene = solution.scene
    lines = [] if scene.source is None else [f"friction: {scene.source.origin}"]
    # What belongs to one of many rollers or sides stands in that machine's own tables.
    whole = [quantity for quantity in solution.quantities if "." not in quantity.name]
    answer = Section(
        title=f"{scene.kind.name}: {scene.document.path}",
        lines=tuple(lines),
        table=quantities_table(whole, solution.level, scene.kind.words) if whole else None,
        notes=solution.warnings,
    )
    return [
        answer,
        *map(_section, scene.kind.sections(tree)),
        Section(title="Simulated", lines=plan_lines(solution)),
    ]


def _section(part: "Part") -> Section:
    table = Table(headings=part.headings, rows=part.rows, left=part.left) if part.headings else None
    return Section(title=part.title, lines=part.lines, table=table, notes=part.notes)


def quantities_table(quantities: Sequence["Uncertain"], level: float, words: Mapping[str, str]) -> Table:
    """Return the numbers of an answer with their uncertainty, if any has one."""
    uncertain = any(quantity.std[0] != 0.0 for quantity in quantities)
    headings: tuple[str, ...] = ("quantity", "value") + (
        ("standard error", f"{100 * level:g} % interval ") if uncertain else ()
    )
    rows = []
    for quantity in quantities:
        cells = [words.get(quantity.name) or _label(quantity.name), f"{quantity.value[0]:.6g}"]
        if uncertain:
            low, high = quantity.interval[0]
            spread = math.isfinite(quantity.std[0])
            cells += [f"{quantity.std[0]:.2g}", f"{low:.5g} … {high:.5g}"] if spread else ["not known", ""]
        rows.append(tuple(cells))
    return Table(headings=headings, rows=tuple(rows))


def _label(name: str) -> str:
    path, _, last = name.rpartition(".")
    if last not in GLOSSARY:
        return name
    term = GLOSSARY[last]
    words = term.meaning.partition(";")[0] + (f" [{term.unit}]" if term.unit not in {"", "-"} else "")
    return f"{path}: {words}" if path else words


def plan_lines(solution: "Solution") -> tuple[str, ...]:
    """Return in words what was simulated, what was not, and how far that may be from everything."""
    plan = solution.plan
    bound = "not known" if math.isinf(plan.error_bound) else f"at most {plan.error_bound:.2g}"
    return (
        f"effects: {', '.join(plan.simulated) or 'none'}",
        f"left out: {', '.join(plan.left_out) or 'none'}",
        f"method: {plan.method.name}{_settings(plan.method.settings)}",
        f"relative difference to simulating everything: {bound} (wanted: {plan.accuracy:g})",
    )


def _settings(settings: Mapping[str, float]) -> str:
    if not settings:
        return ""
    return " (" + ", ".join(f"{name} {value:g}" for name, value in settings.items()) + ")"


def explanation_sections(told: "Explanation") -> list[Section]:
    """Return the table of effects and the method, with what was measured if anything was."""
    headings: tuple[str, ...] = ("effect", "fate ", "worth at most")
    if told.is_measured:
        headings += ("measured worth", "share of time")
    rows = []
    for decision in told.plan.decisions:
        cells = [decision.name, decision.fate, _bound(decision)]
        if told.is_measured:
            cells += _measured(decision)
        rows.append(tuple(cells))
    plan = told.plan
    bound = "not known" if math.isinf(plan.error_bound) else f"{plan.error_bound:.2g}"
    lines = [
        f"accuracy wanted {plan.accuracy:g}; difference to simulating everything at most {bound}",
        f"method: {plan.method.name}{_settings(plan.method.settings)}: {plan.method.why}",
    ]
    if told.is_measured:
        lines.append(
            f"measured: difference {told.difference:.2g}; {_time(told.planned_s)} as planned, "
            f"{_time(told.all_s)} with everything"
        )
    notes = tuple(f"{one.name}: {_why(one)}" for one in plan.decisions)
    return [
        Section(
            title=f"Effects of this {told.system} scene",
            lines=tuple(lines),
            table=Table(headings=headings, rows=tuple(rows), left=2),
            notes=notes,
        )
    ]


def _why(decision: "Decision") -> str:
    """Return the reason for an effect's fate; of a long list of missing keys the first ones."""
    missing = decision.missing
    if len(missing) <= _NAMED:
        return decision.why
    return f"the scene does not give {', '.join(missing[:_NAMED])} and {len(missing) - _NAMED} more"


def _bound(decision: "Decision") -> str:
    if decision.fate == "not applicable":
        return "–"
    if math.isinf(decision.bound):
        return "not known"
    return "0" if decision.bound == 0.0 else f"{decision.bound:.2g}"


def _measured(worth: "Decision") -> list[str]:
    return [
        "–" if math.isnan(worth.worth) else f"{worth.worth:.2g}",
        "–" if math.isnan(worth.time_share) else f"{100 * worth.time_share:.0f} %",
    ]


def _time(seconds: float) -> str:
    return f"{1e6 * seconds:.0f} µs" if seconds < 1e-3 else f"{1e3 * seconds:.3g} ms"


_SHOWN_POINTS = 20


def sweep_sections(sweep: "Sweep") -> list[Section]:
    """Return what a sweep found: its points where they are few, else the range of every number."""
    names = ", ".join(sweep.simulated) or "none"
    bound = f"at most {sweep.error_bound:.2g} (wanted: {sweep.accuracy:g})"
    lines = [f"effects: {names}; relative difference to everything {bound}"]
    if sweep.failed:
        lines.append(f"{sweep.failed} points have no answer; the first says: {sweep.first_failure}")
    total = math.prod(sweep.shape)
    title = f"{' × '.join(axis.key for axis in sweep.axes)}: {total} points"
    if total <= _SHOWN_POINTS:
        return [Section(title=title, lines=tuple(lines), table=_points(sweep), notes=sweep.warnings)]
    rows = []
    for name, values in sweep.columns.items():
        found = values[~np.isnan(values)]
        rows.append((_label(name), f"{found.min():.6g}", f"{found.max():.6g}"))
    return [
        Section(
            title=title,
            lines=tuple(lines),
            table=Table(headings=("quantity", "lowest", "highest"), rows=tuple(rows)),
            notes=sweep.warnings,
        )
    ]


def _points(sweep: "Sweep") -> Table:
    headings = [f"{axis.key} [{axis.unit}]" if axis.unit else axis.key for axis in sweep.axes]
    rows = []
    for place in range(math.prod(sweep.shape)):
        cells, rest = [], place
        for axis in reversed(sweep.axes):
            rest, own = divmod(rest, axis.values.size)
            cells.append(f"{axis.values[own] / axis.factor:.6g}")
        cells.reverse()
        cells += [f"{values[place]:.6g}" for values in sweep.columns.values()]
        rows.append(tuple(cells))
    return Table(headings=(*headings, *(_label(name) for name in sweep.columns)), rows=tuple(rows), left=0)
