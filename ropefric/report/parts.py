"""A section for each kind of result: a fit, a comparison, a diagnosis, a prediction; a scene's answer and its plan."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import accumulate, product
from typing import TYPE_CHECKING, Any

import numpy as np

from ropefric.fitting.compare import Comparison
from ropefric.fitting.diagnose import WORDS, Diagnosis
from ropefric.fitting.next_tests import LabPlan
from ropefric.fitting.predict import EXTRAPOLATED, REGRESSORS, Prediction
from ropefric.fitting.result import FitResult, Verdict
from ropefric.friction.condition import Conditions
from ropefric.glossary import answer_label, counted
from ropefric.section import WIDTH, Section, percent, plain, plus_minus, shorthand, to_error
from ropefric.trials.result import ConditionSummary
from ropefric.uncertainty.budget import DISAGREEMENT, BudgetLine, Statement

if TYPE_CHECKING:
    from ropefric.scenes.draws import Draws
    from ropefric.scenes.explain import Explanation
    from ropefric.scenes.plan import Decision, Plan
    from ropefric.scenes.solve import Solution, Uncertain
    from ropefric.scenes.sweep import Sweep

LEAST_SHARE = 0.001
"""Of the variance: in a report, sources below are named and have no line."""


def ends(of: Iterable[float], std: float) -> str:
    """Return an interval whose ends have as many digits as the value with this standard deviation."""
    return " … ".join(to_error(float(end), std) for end in of)


def fit_section(fit: FitResult, title: str = "", *, short: bool = False) -> Section:
    """Return a fitted law with its parameters and their 95 % intervals; in `short`, values as 0.1192(12)."""
    law, found = fit.friction_law, fit.statistics
    between = f"between conditions {percent(found.scatter_between)}"
    kinetic = ("fitted to the kinetic force: F_A is the mean force while sliding",)
    lines = (
        f"{law.name}: {law.equation}",
        *(kinetic if fit.of == "kinetic" else ()),
        f"{counted(found.n, 'trial')} of {counted(found.n_conditions, 'condition')}",
        f"scatter between repeats {percent(found.scatter_within)}, {between}",
        f"status {fit.status}: {fit.status.advice}",
    )
    rows = []
    for item, declared in zip(fit.parameters, law.parameters, strict=True):
        unit = "" if declared.unit == "-" else f" [{declared.unit}]"
        value, known = plain(item.value, ".5g"), found.interval_dof != 0.0
        if item.vary and not item.at_bound:
            std = span = "not known"
            if known:
                value, _, std = plus_minus(item.value, item.std).partition(" ± ")
                span = ends(item.ci95, item.std)
            in_short = shorthand(item.value, item.std) if known else value
        else:
            std, span = ("at its bound" if item.vary else "fixed"), "–"
            in_short = f"{value} at its bound" if item.at_bound else value
        values = (in_short,) if short else (value, std or "–")
        rows.append((f"{item.name}{unit}", *values, span, declared.meaning))
    told = ("value(standard error)",) if short else ("value", "standard error")
    headings = ("parameter", *told, "95 % interval", "meaning ")
    return Section(title or f"The law: {law.name}", lines, headings, rows)


def notes_sections(fit: FitResult) -> tuple[Section, ...]:
    """Return the doubts about a fit, and how it was made, as far as there are notes."""
    doubts = tuple(dict.fromkeys((*(text for _, text in fit.doubts or fit.untested()), *fit.advice)))
    both = Section("Doubts", notes=doubts), Section("How the law was fitted", notes=fit.notes)
    return tuple(one for one in both if one.notes)


def origin_section(fit: FitResult) -> Section:
    """Return the data of a fit, and the range of its conditions."""
    source, versions = fit.provenance.get("input", {}), versions_in_words(fit.provenance.get("versions", {}))
    lines = (f"from {source.get('path') or 'no file'}, with {versions or 'unknown versions'}", "tested:")
    return Section("Origin and tested range", lines, notes=tested_ranges(fit))


def versions_in_words(versions: Mapping[str, str]) -> str:
    """Return the programs that something was made with; the method of its errors is none."""
    return ", ".join(f"{name} {number}" for name, number in sorted(versions.items()) if name != "errors")


def verdict_section(verdict: Verdict, title: str) -> Section:
    """Return a verdict in a word, and why."""
    return Section(title, (f"{verdict.word}: {verdict.reason}",))


def comparison_section(comparison: Comparison) -> Section:
    """Return the laws by AICc; a dash where a law has no such number."""
    rows: list[tuple[str, ...]] = []
    left_out: dict[str, list[str]] = {}
    for entry in comparison.ranking:
        numbers = (
            (plain(entry.delta_aicc, ".1f"), plain(entry.weight, ".3f")) if entry.counted else ("–", "–")
        )
        rows.append((entry.law, *numbers, percent(entry.loco_error), entry.status))
        if entry.note:
            left_out.setdefault(entry.note, []).append(entry.law)
    headings = ("law", "ΔAICc", "weight", "error at unseen conditions", "status ")
    why = [f"{', '.join(laws)} not ranked: {note}" for note, laws in left_out.items()]
    return Section("Comparison", headings=headings, rows=rows, notes=(*comparison.notes, *why))


def diagnosis_section(diagnosis: Diagnosis, *, full: bool = False) -> Section:
    """Return why the rope does not obey the capstan equation: supported causes with evidence, the others by name.

    With `full`, all causes with their evidence and the tests that would decide them.
    """
    if full:
        return Section(lines=diagnosis.text.splitlines())
    names: dict[str, list[str]] = {"yes": [], "no": [], "cannot-tell": []}
    for one in diagnosis.causes:
        names[one.supported].append(one.cause)
    notes = [f"{one.cause}: {one.evidence}" for one in diagnosis.causes if one.supported == "yes"]
    others = (
        ("no", ""),
        ("cannot-tell", "; `ropefric diagnose` names the tests that decide"),
    )
    notes += [f"{WORDS[kind]}: {', '.join(names[kind])}{more}" for kind, more in others if names[kind]]
    return Section("Does it obey the capstan equation?", (diagnosis.summary,), notes=notes)


def prediction_section(prediction: Prediction) -> Section:
    """Return the lift force of the first condition with both its intervals."""
    level = f"{100 * prediction.level:g} %"
    std_N = float(prediction.std_N[0])
    lift = to_error(float(prediction.lift_force_N[0]), std_N)
    is_kinetic = prediction.of == "kinetic"
    title, symbol = ("Kinetic force", "F_A while sliding") if is_kinetic else ("Lift force", "F_A")
    lines = [
        f"{_where(prediction.conditions, 0, rope=True)}:",
        f"{symbol} = {lift} N by {prediction.law}, standard error {_newtons(std_N)}",
        f"{level} confidence interval of the mean: {_span(prediction.interval_N[0], std_N)}",
    ]
    wide = prediction.prediction_interval_N[0]
    if not math.isnan(float(wide[0])):
        lines.append(f"{level} prediction interval of one pull with a new rope: {ends(wide, std_N)} N")
    if prediction.rope_interval_N is not None:
        lines.append(
            f"{level} interval of the mean of one new rope: {_span(prediction.rope_interval_N[0], std_N)}"
        )
    verdict = prediction.verdict
    lines.append(f"{verdict.word}: {verdict.reason}")
    notes = [note for note in prediction.notes() if note not in verdict.reasons]
    if not verdict.supported and prediction.spread_N is not None:
        low, high = prediction.spread_N
        lines.append(f"the laws that the data cannot distinguish predict {plain(low)} … {plain(high)} N:")
        for one in reversed(prediction.candidates):
            error = f"standard error {_newtons(one.std_N)}, interval {_span(one.interval_N, one.std_N)}"
            notes.insert(0, f"{one.law}: {to_error(one.lift_force_N, one.std_N)} N, {error}")
    return Section(title, lines, notes=notes)


def setting_cells(wheel_m: float, wrap_rad: float, known_N: float) -> tuple[str, ...]:
    """Return a condition's wheel radius [mm], wrap [deg] and known force [N] as cells."""
    return plain(1e3 * wheel_m), plain(math.degrees(wrap_rad)), plain(known_N)


def condition_cells(item: ConditionSummary, *, slack: bool) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the settings of a condition as cells, and mean and scatter of the trials kept."""
    known_N = item.lift_force_N if slack else item.end_tension_N
    settings = setting_cells(item.wheel_radius_m, item.wrap_angle_rad, known_N)
    return settings, (plain(item.mean_kept_N), plain(item.std_kept_N, ".2g"))


def _where(at: Conditions, i: int, *, rope: bool = False) -> str:
    wheel, wrap, end = setting_cells(at.wheel_radius_m[i], at.wrap_angle_rad[i], at.end_tension_N[i])
    of_rope = f"rope of {plain(2e3 * at.rope_radius_m[i])} mm, " if rope else ""
    return f"R_w = {wheel} mm, {of_rope}wrap {wrap} deg, F_B = {end} N"


def _newtons(value: float) -> str:
    return f"{to_error(value, value)} N" if math.isfinite(value) else "not known"


def _span(of: Sequence[float], std: float) -> str:
    return f"{ends(of, std)} N" if all(math.isfinite(end) for end in of) else "not known"


def tested_ranges(fit: FitResult) -> tuple[str, ...]:
    """Return the tested range of each regressor in words, in the unit people set it in."""
    found = []
    for name, (title, unit, factor) in REGRESSORS.items():
        if name in fit.validity:
            low, high = (plain(factor * end) for end in fit.validity[name])
            found.append(f"{title} {low} {unit}" if low == high else f"{title} {low} to {high} {unit}")
    return tuple(found)


def plan_sections(plan: LabPlan) -> tuple[Section, ...]:
    """Return a plan as sections: its conditions, and the wanted predictions before and after."""
    rows = []
    for row in plan.rows():
        settings = setting_cells(
            *(row[name] for name in ("wheel_radius_m", "wrap_angle_rad", "end_tension_N"))
        )
        expected = plain(row["expected_lift_force_N"]), f"{100 * row['cell_use']:.0f} %"
        rows.append((str(row["condition"]), *settings, str(row["repeats"]), *expected))
    conditions, pulls = counted(len(plan), "condition"), counted(len(plan) * plan.repeats, "pull")
    law, scatter = plan.planned.law, plan.planned.scatter
    values = law.as_mapping(plan.planned.theta)
    within, between = 100 * scatter.within, 100 * scatter.between
    scattered = f"between repeats {within:.2g} %, between conditions {between:.2g} %"
    stds = plan.expected_parameter_std().items()
    expected_values = ", ".join(f"{name} = {plus_minus(values[name], std)}" for name, std in stds)
    lines = (
        f"{law.name}; scatter {scattered}",
        f"expected: {expected_values}",
    )
    title = f"{conditions} to test, {pulls}, the best for the wanted prediction"
    headings = ("no.", "R_w [mm]", "wrap [deg]", "F_B [N]", "repeats", "expected F_A [N]", "of the limit")
    what = Section(title, lines, headings, rows, notes=plan.notes)
    return what, *(_worth_section(plan, i) for i in range(len(plan.wanted)))


def _worth_section(plan: LabPlan, i: int) -> Section:
    lift_N = float(np.exp(plan.wanted_log_lift[i]))
    rows = []
    for name, outlook in (("before", plan.before), ("with this plan", plan.after)):
        half, std_N = float(outlook.half_width_log[i]), lift_N * float(outlook.std_log[i])
        both = (lift_N * math.exp(side * half) for side in (-1.0, 1.0))
        span = ends(both, std_N) if half < 50.0 else "not determined"
        rows.append((name, plain(std_N, ".2g"), span, plain(float(outlook.dof[i]), ".3g")))
    headings = ("tests", "standard error [N]", f"{100 * plan.level:g} % interval of the mean [N]", "dof")
    notes = (
        "These numbers hold for the parameters and the scatter known today. Plan again after the first tests.",
    )
    title = f"Effect of the plan on F_A = {plain(lift_N)} N"
    return Section(title, (_where(plan.wanted, i),), headings, rows, notes=notes)


_BUDGET = (
    *("source", "symbol", "estimate", "stated", "divisor", "u(x)", "unit ", "type, distribution "),
    *("sensitivity", "|c| u", "share", "dof"),
)
_DIVISORS = {math.sqrt(3.0): "√3", math.sqrt(12.0): "√12", 1.0: "1"}


def uncertainty_sections(stated: Statement, title: str, *, least_share: float = 0.0) -> tuple[Section, ...]:
    """Return a statement of uncertainty as sections: budget with the check by draws, and measures to reduce it.

    Sources with less than `least_share` of the variance are named in a note, and have no line.
    """
    found = stated.budget
    unit = "" if stated.model.unit == "-" else f" {stated.model.unit}"
    y, U = to_error(found.estimate, found.expanded), to_error(found.expanded, found.expanded)
    factors = f"ν_eff = {plain(found.effective_dof, '.3g')}, k = {plain(found.coverage_factor, '.3g')}"
    combined = f"u_c = {plain(found.combined, '.3g')}{unit}"
    lines = (
        f"{stated.model.symbol} = {y} ± {U}{unit} ({100 * found.level:g} %)",
        f"{combined}, {factors}: U = {plain(found.expanded, '.3g')}{unit}",
    )
    small = [line for line in found.lines if line.share < least_share]
    below = [f"below {percent(least_share)} of the variance: {', '.join(line.label for line in small)}"]
    notes = (*below[: len(small)], *_draws_notes(stated, unit), *stated.notes)
    rows = [_budget_row(line) for line in found.lines if line not in small]
    smaller = [
        (item.action, plain(item.expanded, ".3g"), f"{100 * item.saving:.0f} %")
        for item in stated.improvements
    ]
    headings = ("measure ", f"U [{stated.model.unit}]", "smaller by")
    reduce = Section("How to reduce the uncertainty", (), headings, smaller)
    return (Section(title, lines, _BUDGET, rows, 2, notes), reduce)[: 2 if smaller else 1]


def _budget_row(line: BudgetLine) -> tuple[str, ...]:
    item = line.source
    of_answer = plain(line.contribution, ".2g"), f"{100 * line.share:.1f} %", plain(item.dof, ".3g")
    divisor = next((text for value, text in _DIVISORS.items() if math.isclose(value, item.divisor)), "")
    divisor = divisor or (f"√{item.repeats}" if item.repeats else plain(item.divisor, ".3g"))
    numbers = plain(item.estimate, ".5g"), plain(item.stated, ".2g"), divisor, plain(item.std, ".2g")
    words = item.unit, f"{item.type}, {item.distribution}"
    return (line.label, item.symbol, *numbers, *words, plain(line.sensitivity, ".3g"), *of_answer)


def _draws_notes(stated: Statement, unit: str) -> Iterator[str]:
    """Yield the verdict, and how far the ends of y ± U are from those of the draws."""
    drawn, found = stated.drawn, stated.budget
    yield f"{stated.status}: {stated.status.advice}"
    gap, word = max(drawn.gaps), "agree" if drawn.agrees else "do not agree"
    of_draws = ends(drawn.symmetric_interval, found.combined)
    yield (
        f"{drawn.draws} draws (seed {drawn.seed}) {word} with y ± U = {ends(found.interval, found.combined)}{unit}: "
        f"{of_draws}{unit}. The ends differ by up to "
        f"{float(f'{100 * gap / found.expanded:.2g}'):g} % of U; {100 * DISAGREEMENT:g} % are allowed."
    )
    if drawn.unanswered:
        yield f"{drawn.unanswered} draws have no answer."


_NAMED = 4
_SHOWN_POINTS = 20
_FATES = {"simulated": "yes", "left out": "no"}
_SHOWN = {"rad]": ("deg]", math.degrees(1.0)), "m]": ("mm]", 1e3)}


def solution_sections(solution: "Solution", tree: Mapping[str, Any]) -> list[Section]:
    """Return a scene's answer, its uncertainty and the simulated effects; `tree` is its `to_dict()`."""
    scene, plan = solution.scene, solution.plan
    lines = [] if scene.source is None else [f"friction: {scene.source.origin}"]
    # What belongs to one of many rollers or sides stands in that machine's own tables.
    whole = [quantity for quantity in solution.quantities if "." not in quantity.name]
    headings, rows = _quantities(whole, solution.level, scene.kind.words) if whole else ((), ())
    title = f"{scene.kind.name}: {scene.document.path}"
    bound = _bound(plan.error_bound, "at most ")
    beyond = "; ".join(scene.kind.beyond[name] for name in solution.beyond_bound)
    simulated = [
        f"effects: {', '.join(plan.simulated) or 'none'}",
        f"left out: {', '.join(plan.left_out) or 'none'}",
        f"method: {_method(plan)}",
        f"relative difference to the full simulation: {bound} (wanted: {plan.accuracy:g})",
        *(
            f"bound of {name}: {to_error(one, 0.0)}"
            for name, one in solution.own_bounds.items()
            if "." not in name
        ),
        *([f"without a bound, by the effects simulated: {beyond}"] if beyond else []),
    ]
    whole_machine = Section(title, lines, headings, rows, notes=solution.warnings)
    return [whole_machine, *scene.kind.sections(tree), Section("Simulated", simulated)]


def _quantities(
    quantities: Sequence["Uncertain"], level: float, words: Mapping[str, str]
) -> tuple[Sequence[str], Sequence[Sequence[str]]]:
    """Return headings and rows of the numbers of an answer, with their uncertainty if any has one."""
    uncertain = any(quantity.std[0] != 0.0 for quantity in quantities)
    rows = []
    for quantity in quantities:
        label, factor = _in_units(words.get(quantity.name) or answer_label(quantity.name))
        std = factor * float(quantity.std[0])
        cells = [label, to_error(factor * float(quantity.value[0]), std)]
        if uncertain:
            known = math.isfinite(std)
            ends = " … ".join(to_error(factor * float(end), std) for end in quantity.interval[0])
            cells += [f"{std:.2g}", ends] if known else ["not known", ""]
        rows.append(cells)
    headings = ("quantity", "value", "standard error", f"{100 * level:g} % interval ")
    return headings[: 4 if uncertain else 2], rows


def _in_units(label: str) -> tuple[str, float]:
    """Return a label with the unit people set such a quantity in, and the factor to it from SI."""
    head, bracket, unit = label.rpartition("[")
    shown, factor = _SHOWN.get(unit, (unit, 1.0))
    return f"{head}{bracket}{shown}", factor


def _bound(value: float, words: str = "") -> str:
    return "not known" if math.isinf(value) else f"{words}{value:.2g}"


def _method(plan: "Plan") -> str:
    settings = ", ".join(f"{name} {value:g}" for name, value in plan.method.settings.items())
    return f"{plan.method.name} ({settings})" if settings else plan.method.name


def explanation_sections(told: "Explanation") -> list[Section]:
    """Return the table of effects and the method, with measured times if there are any."""
    plan = told.plan
    rows = [[one.name, _FATES.get(one.fate, one.fate), _worth(one)] for one in plan.decisions]
    bound = _bound(plan.error_bound)
    lines = [
        f"accuracy wanted {plan.accuracy:g}; relative difference to the full simulation at most {bound}",
        f"method: {_method(plan)}: {plan.method.why}",
    ]
    if told.is_measured:
        for row, one in zip(rows, plan.decisions, strict=True):
            row.append(_takes(one))
        saved = f"the difference is below what the clock resolves here, {_time(told.spread_s)}"
        if abs(told.saved_s) > told.spread_s:
            what = "saves" if told.saved_s > 0.0 else "costs"
            saved = f"which {what} {_time(abs(told.saved_s))} (± {_time(0.5 * told.spread_s)})"
        times = f"{_time(told.planned_s)} as planned, {_time(told.all_s)} with everything"
        lines.append(f"measured: difference {told.difference:.2g}; {times}; {saved}")
    headings = ("effect", "used ", "largest influence", "time")
    reasons: dict[str, list[str]] = {}
    for one in plan.decisions:
        reasons.setdefault(_why(one), []).append(one.name)
    notes = [f"{', '.join(names)}: {why}" for why, names in reasons.items()]
    return [
        Section(
            f"Effects of this {told.system} scene",
            lines,
            headings[: 4 if told.is_measured else 3],
            rows,
            2,
            notes,
        )
    ]


def _worth(decision: "Decision") -> str:
    """Return by how much leaving an effect out, or putting it in, changes any number of the answer."""
    if decision.fate == "not applicable":
        return "–"
    words = {math.isinf: "another answer", math.isnan: "no answer"}
    return next((said for is_so, said in words.items() if is_so(decision.worth)), f"{decision.worth:.2g}")


def _takes(decision: "Decision") -> str:
    if math.isnan(decision.time_spread_s):
        return "–"
    spread = _time(decision.time_spread_s)
    return (
        f"less than {spread}"
        if math.isnan(decision.time_s)
        else f"{_time(decision.time_s)} ± {_time(0.5 * decision.time_spread_s)}"
    )


def _why(decision: "Decision") -> str:
    """Return the reason for an effect's fate; of a long list of missing keys the first ones."""
    missing = decision.missing
    if len(missing) <= _NAMED:
        return decision.why
    return f"the scene does not give {', '.join(missing[:_NAMED])} and {len(missing) - _NAMED} more"


def _time(seconds: float) -> str:
    return f"{1e6 * seconds:.0f} µs" if seconds < 1e-3 else f"{1e3 * seconds:.3g} ms"


def _simulated(found: "Draws | Sweep") -> str:
    bound = f"at most {found.error_bound:.2g} (wanted: {found.accuracy:g})"
    return (
        f"effects: {', '.join(found.simulated) or 'none'}; relative difference to the full simulation {bound}"
    )


def draws_sections(drawn: "Draws", words: Mapping[str, str]) -> list[Section]:
    """Return the result of draws of a scene's uncertain quantities: mean, standard deviation and quantiles."""
    lines = [
        f"uncertain inputs: {', '.join(drawn.drawn)}",
        _simulated(drawn),
        *(f"{name} left out in {count} draws" for name, count in drawn.left_out.items()),
        *(f"in {100.0 * share:.3g} % of the draws {what}" for what, share in drawn.shares.items()),
    ]
    rows = []
    for name, one in drawn.numbers.items():
        label, factor = _in_units(words.get(name) or answer_label(name))
        told = [to_error(factor * each, factor * one.std) for each in (one.value, one.mean, *one.quantiles)]
        rows.append([label, *told, f"{factor * one.std:.2g}"])
    tail = 50.0 * (1.0 - drawn.level)
    ends = (f"{tail:g} %", "median", f"{100.0 - tail:g} %")
    headings = ("quantity", "as given", "mean", *ends, "standard deviation")
    title = f"{drawn.system}: {drawn.count} draws (seed {drawn.seed})"
    return [Section(title, lines, headings, rows, notes=[*drawn.doubts, *drawn.unanswered])]


def sweep_sections(sweep: "Sweep") -> list[Section]:
    """Return the result of a sweep: its points if they are few, otherwise the range of every number.

    Numbers that change have a column, as many as fit the width; the CSV has all.
    """
    total = math.prod(sweep.shape)
    title = f"{' × '.join(axis.key for axis in sweep.axes)}: {total} points"
    # Numbers of the whole machine before those of its parts.
    names = sorted(sweep.columns, key=lambda name: name.count("."))
    # Of those that are numbers.
    ranges = {name: (np.fmin.reduce(one), np.fmax.reduce(one)) for name, one in sweep.columns.items()}
    # To the last bits, which differ from machine to machine.
    still = [name for name in names if math.isclose(*ranges[name], rel_tol=1e-9)]
    moving = [name for name in names if name not in still]
    lines = [*_sweep_lines(sweep, {name: ranges[name] for name in still if name != EXTRAPOLATED})]
    if total > _SHOWN_POINTS:
        ends = [_in_its_unit(name, ranges[name]) for name in moving]
        rows = [(label, *cells) for label, cells in ends]
        return [Section(title, lines, ("quantity", "lowest", "highest"), rows, notes=sweep.warnings)]
    columns = _columns_of_points(sweep, moving)
    widths = [2 + max(map(len, (*label.split(), *cells))) for label, cells in columns]  # headings are folded
    n = max(sum(reach <= WIDTH for reach in accumulate(widths)), len(sweep.axes) + 1)
    if n < len(columns):
        more = counted(len(columns) - n, "column")
        lines.append(f"{more} more: --out FOLDER writes all to sweep.csv")
    labels, cells = zip(*columns[:n], strict=True)
    return [Section(title, lines, labels, [*zip(*cells, strict=True)], left=0, notes=sweep.warnings)]


def _columns_of_points(sweep: "Sweep", moving: Sequence[str]) -> list[tuple[str, list[str]]]:
    """Return the swept quantities and the numbers that change with them: a label, and a cell for each point."""
    points = zip(*product(*((axis.values / axis.factor).tolist() for axis in sweep.axes)), strict=True)
    swept = [(axis.label, [f"{x:.5g}" for x in xs]) for axis, xs in zip(sweep.axes, points, strict=True)]
    return [*swept, *(_in_its_unit(name, sweep.columns[name].tolist()) for name in moving)]


def _sweep_lines(sweep: "Sweep", still: Mapping[str, tuple[float, float]]) -> Iterator[str]:
    """Yield the simulated effects of a sweep, its points without an answer, and the numbers that do not change."""
    yield _simulated(sweep)
    yield from (f"{name} left out at {count} points" for name, count in sweep.left_out.items())
    if sweep.failed:
        yield f"{sweep.failed} points have no answer; the first says: {sweep.first_failure}"
    if still:
        shown = [_in_its_unit(name, still[name]) for name in [*still][:_NAMED]]
        same = "; ".join(f"{label} = {cells[0]}" for label, cells in shown)
        more = f"; and {len(still) - _NAMED} more" if len(still) > _NAMED else ""
        yield f"the same at every point: {same}{more}"


def _in_its_unit(name: str, values: Iterable[float]) -> tuple[str, list[str]]:
    """Return the label of a number and its values as cells, in the unit people read it in."""
    label, factor = _in_units(answer_label(name))
    return label, [f"{factor * value:.5g}" for value in values]
