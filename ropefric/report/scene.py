"""A scene's answer and its plan, told to people."""

import math
from collections.abc import Mapping, Sequence
from itertools import accumulate, product
from typing import TYPE_CHECKING, Any

from ropefric.glossary import GLOSSARY, counted
from ropefric.section import Section, plain, to_error

if TYPE_CHECKING:
    from ropefric.scenes.draws import Draws
    from ropefric.scenes.plan import Decision, Explanation, Plan
    from ropefric.scenes.solve import Solution, Uncertain
    from ropefric.scenes.sweep import Sweep


_NAMED = 4
_SHOWN_POINTS = 20
_ROOM = 200
_SHOWN = {"rad]": ("deg]", math.degrees(1.0)), "m]": ("mm]", 1e3)}


def solution_sections(solution: "Solution", tree: Mapping[str, Any]) -> list[Section]:
    """Return what a scene's answer is, how sure, and what was simulated for it; `tree` is its `to_dict()`."""
    scene, plan = solution.scene, solution.plan
    lines = [] if scene.source is None else [f"friction: {scene.source.origin}"]
    # What belongs to one of many rollers or sides stands in that machine's own tables.
    whole = [quantity for quantity in solution.quantities if "." not in quantity.name]
    headings, rows = _quantities(whole, solution.level, scene.kind.words) if whole else ((), ())
    title = f"{scene.kind.name}: {scene.document.path}"
    bound = "not known" if math.isinf(plan.error_bound) else f"at most {plan.error_bound:.2g}"
    beyond = "; ".join(scene.kind.beyond[name] for name in solution.beyond_bound)
    simulated = [
        f"effects: {', '.join(plan.simulated) or 'none'}",
        f"left out: {', '.join(plan.left_out) or 'none'}",
        f"method: {_method(plan)}",
        f"relative difference to simulating everything: {bound} (wanted: {plan.accuracy:g})",
        *(f"bound of {name}: {to_error(one, 0.0)}" for name, one in solution.own_bounds.items()),
        *([f"not bounded, but of the effects simulated: {beyond}"] if beyond else []),
    ]
    return [
        Section(title, lines, headings, rows, notes=solution.warnings),
        *scene.kind.sections(tree),
        Section("Simulated", simulated),
    ]


def _quantities(
    quantities: Sequence["Uncertain"], level: float, words: Mapping[str, str]
) -> tuple[Sequence[str], Sequence[Sequence[str]]]:
    """Return headings and rows of the numbers of an answer, with their uncertainty if any has one."""
    uncertain = any(quantity.std[0] != 0.0 for quantity in quantities)
    rows = []
    for quantity in quantities:
        label, factor = _in_units(words.get(quantity.name) or _label(quantity.name))
        std = factor * float(quantity.std[0])
        cells = [label, to_error(factor * float(quantity.value[0]), std)]
        if uncertain:
            known = math.isfinite(std)
            ends = " … ".join(to_error(factor * float(end), std) for end in quantity.interval[0])
            cells += [f"{std:.2g}", ends] if known else ["not known", ""]
        rows.append(cells)
    headings = ("quantity", "value", "standard error", f"{100 * level:g} % interval ")
    return headings[: 4 if uncertain else 2], rows


def _label(name: str) -> str:
    path, _, last = name.rpartition(".")
    if last not in GLOSSARY:
        return name
    term = GLOSSARY[last]
    words = term.meaning.partition(";")[0] + (f" [{term.unit}]" if term.unit not in {"", "-"} else "")
    return f"{path}: {words}" if path else words


def _in_units(label: str) -> tuple[str, float]:
    """Return a label with the unit people set such a quantity in, and the factor to it from SI."""
    head, bracket, unit = label.rpartition("[")
    shown, factor = _SHOWN.get(unit, (unit, 1.0))
    return f"{head}{bracket}{shown}", factor


def _method(plan: "Plan") -> str:
    settings = ", ".join(f"{name} {value:g}" for name, value in plan.method.settings.items())
    return f"{plan.method.name} ({settings})" if settings else plan.method.name


def explanation_sections(told: "Explanation") -> list[Section]:
    """Return the table of effects and the method, with what was measured if anything was."""
    plan = told.plan
    rows = []
    for one in plan.decisions:
        known = "not known" if math.isinf(one.bound) else f"{one.bound:.2g}"
        rows.append([one.name, one.fate, "–" if one.fate == "not applicable" else known])
    bound = "not known" if math.isinf(plan.error_bound) else f"{plan.error_bound:.2g}"
    lines = [
        f"accuracy wanted {plan.accuracy:g}; difference to simulating everything at most {bound}",
        f"method: {_method(plan)}: {plan.method.why}",
    ]
    if told.is_measured:
        for row, one in zip(rows, plan.decisions, strict=True):
            share = "–" if math.isnan(one.time_share) else f"{100 * one.time_share:.0f} %"
            row += [plain(one.worth, ".2g"), "–" if math.isnan(one.time_s) else _time(one.time_s), share]
        times = f"{_time(told.planned_s)} as planned, {_time(told.all_s)} with everything"
        saved = f", which saves {_time(told.saved_s)}" if plan.left_out and told.saved_s > 0.0 else ""
        lines.append(f"measured: difference {told.difference:.2g}; {times}{saved}")
    headings = ("effect", "fate ", "worth at most", "measured worth", "takes", "share of time")
    shown = headings[: 6 if told.is_measured else 3]
    notes = [f"{one.name}: {_why(one)}" for one in plan.decisions]
    return [Section(f"Effects of this {told.system} scene", lines, shown, rows, 2, notes)]


def _why(decision: "Decision") -> str:
    """Return the reason for an effect's fate; of a long list of missing keys the first ones."""
    missing = decision.missing
    if len(missing) <= _NAMED:
        return decision.why
    return f"the scene does not give {', '.join(missing[:_NAMED])} and {len(missing) - _NAMED} more"


def _time(seconds: float) -> str:
    return f"{1e6 * seconds:.0f} µs" if seconds < 1e-3 else f"{1e3 * seconds:.3g} ms"


def draws_sections(drawn: "Draws", words: Mapping[str, str]) -> list[Section]:
    """Return what draws of a scene's uncertain quantities lead to: mean, standard deviation and quantiles."""
    bound = f"at most {drawn.error_bound:.2g} (wanted: {drawn.accuracy:g})"
    lines = [
        f"drawn: {', '.join(drawn.inputs)}",
        f"effects: {', '.join(drawn.simulated) or 'none'}; relative difference to everything {bound}",
        *(f"{name} left out in {count} draws" for name, count in drawn.left_out.items()),
        *(f"in {100.0 * share:.3g} % of the draws {what}" for what, share in drawn.shares.items()),
    ]
    rows = []
    for name, one in drawn.numbers.items():
        label, factor = _in_units(words.get(name) or _label(name))
        told = [to_error(factor * each, factor * one.std) for each in (one.value, one.mean, *one.quantiles)]
        rows.append([label, *told, f"{factor * one.std:.2g}"])
    tail = 50.0 * (1.0 - drawn.level)
    ends = (f"{tail:g} %", "median", f"{100.0 - tail:g} %")
    headings = ("quantity", "as given", "mean", *ends, "standard deviation")
    title = f"{drawn.system}: {drawn.count} draws (seed {drawn.seed})"
    return [Section(title, lines, headings, rows, notes=[*drawn.doubts, *drawn.unanswered])]


def sweep_sections(sweep: "Sweep", width: int | None = None) -> list[Section]:
    """Return what a sweep found: its points where they are few, else the range of every number.

    Only what changes from point to point has a column, as many as there is room for; the CSV has all.
    """
    names = ", ".join(sweep.simulated) or "none"
    bound = f"at most {sweep.error_bound:.2g} (wanted: {sweep.accuracy:g})"
    lines = [f"effects: {names}; relative difference to everything {bound}"]
    lines += [f"{name} left out at {count} points" for name, count in sweep.left_out.items()]
    if sweep.failed:
        lines.append(f"{sweep.failed} points have no answer; the first says: {sweep.first_failure}")
    total = math.prod(sweep.shape)
    title = f"{' × '.join(axis.key for axis in sweep.axes)}: {total} points"
    # Numbers of the whole machine before those of its parts.
    ranges = sorted(sweep.ranges.items(), key=lambda item: item[0].count("."))
    # To the last bits, which differ from machine to machine.
    still = [name for name, ends in ranges if math.isclose(*ends, rel_tol=1e-9)]
    told = {name: _in_units(_label(name)) for name, _ in ranges}
    if still:
        same = [f"{told[name][0]} {told[name][1] * sweep.ranges[name][0]:.5g}" for name in still[:_NAMED]]
        more = f", and {len(still) - _NAMED} more" if len(still) > _NAMED else ""
        lines.append(f"the same at every point: {', '.join(same)}{more}")
    moving = [(name, *told[name]) for name, _ in ranges if name not in still]
    rows: list[tuple[str, ...]]
    if total > _SHOWN_POINTS:
        rows = [
            (label, *(f"{factor * end:.5g}" for end in sweep.ranges[name])) for name, label, factor in moving
        ]
        headings: Sequence[str] = ("quantity", "lowest", "highest")
        return [Section(title, lines, headings, rows, notes=sweep.warnings)]
    points = product(*((axis.values / axis.factor).tolist() for axis in sweep.axes))
    columns = [
        (axis.label, [f"{value:.5g}" for value in values])
        for axis, values in zip(sweep.axes, zip(*points, strict=True), strict=True)
    ]
    for name, label, factor in moving:
        columns.append((label, [f"{factor * value:.5g}" for value in sweep.columns[name].tolist()]))
    room = (width or _ROOM) - 2
    widths = [2 + max(map(len, (*label.split(), *cells))) for label, cells in columns]
    n = max(sum(reach <= room + 2 for reach in accumulate(widths)), len(sweep.axes) + 1)
    if n < len(columns):
        more = counted(len(columns) - n, "column")
        lines.append(f"{more} more with what changes: --out FOLDER writes all to sweep.csv")
    rows = [*zip(*(cells for _, cells in columns[:n]), strict=True)]
    return [Section(title, lines, [label for label, _ in columns[:n]], rows, left=0, notes=sweep.warnings)]
