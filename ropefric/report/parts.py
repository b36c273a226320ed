"""The parts of a summary, each from one result: a fit, a comparison, a diagnosis, a prediction."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from ropefric.fitting.compare import Comparison
from ropefric.fitting.diagnose import Diagnosis
from ropefric.fitting.next_tests import LabPlan, Outlook
from ropefric.fitting.predict import REGRESSORS, Candidate, Prediction
from ropefric.fitting.result import FitResult, Verdict
from ropefric.glossary import counted
from ropefric.report.section import Section, Table, interval, percent, plain, shorthand
from ropefric.uncertainty.budget import DISAGREEMENT, BudgetLine, Statement, numerical_tolerance
from ropefric.uncertainty.quantity import Quantity

_VERDICTS = {"yes": "supported", "no": "not supported", "cannot-tell": "cannot be told"}


def fit_section(fit: FitResult, title: str = "", *, short: bool = False) -> Section:
    """Return a fitted law with its parameters and their 95 % intervals; in `short`, values as 0.1192(12)."""
    law, found = fit.friction_law, fit.statistics
    between = f"between conditions {percent(found.scatter_between)}"
    lines = (
        f"{law.name}: {law.equation}",
        *(
            ("fitted to the kinetic force: F_A is the mean force while sliding",)
            if fit.of == "kinetic"
            else ()
        ),
        f"{counted(found.n, 'trial')} of {counted(found.n_conditions, 'condition')}",
        f"scatter between repeats {percent(found.scatter_within)}, {between}",
        f"status {fit.status}: {fit.status.advice}",
    )
    rows: list[tuple[str, ...]] = []
    for item, declared in zip(fit.parameters, law.parameters, strict=True):
        unit = "" if declared.unit == "-" else f" [{declared.unit}]"
        known = found.interval_dof != 0.0
        if not item.vary:
            std, span = "fixed", "–"
        elif item.at_bound:
            std, span = "at its bound", "–"
        else:
            std, span = (plain(item.std, ".2g"), interval(item.ci95)) if known else ("not known", "not known")
        if short:
            found_value = shorthand(item.value, item.std) if item.vary and known else plain(item.value, ".5g")
            values: tuple[str, ...] = (
                found_value if not item.at_bound else f"{plain(item.value, '.5g')} at its bound",
            )
        else:
            values = (plain(item.value, ".5g"), std)
        rows.append((f"{item.name}{unit}", *values, span, declared.meaning))
    told = ("value(standard error)",) if short else ("value", "standard error")
    headings = ("parameter", *told, "95 % interval", "meaning ")
    return Section(
        title=title or f"The law: {law.name}", lines=lines, table=Table(headings=headings, rows=tuple(rows))
    )


def notes_sections(fit: FitResult) -> tuple[Section, Section]:
    """Return what is doubtful about a fit, and how it was made."""
    doubts = tuple(dict.fromkeys((*(text for _, text in fit.doubts), *fit.advice)))
    return (
        Section(title="Doubts", notes=doubts or ("nothing was found",)),
        Section(title="How it was made", notes=fit.notes),
    )


def origin_section(fit: FitResult) -> Section:
    """Return what a fit was made from, and the range of the conditions it holds for."""
    source, versions = fit.provenance.get("input", {}), fit.provenance.get("versions", {})
    made = ", ".join(f"{name} {number}" for name, number in sorted(versions.items()))
    lines = (f"from {source.get('path') or 'no file'}, with {made or 'unknown versions'}", "tested:")
    return Section(title="Where it comes from, and where it holds", lines=lines, notes=tested_ranges(fit))


def verdict_section(verdict: Verdict, title: str) -> Section:
    """Return a verdict in a word, and why."""
    return Section(title=title, lines=(f"{verdict.word}: {verdict.reason}",))


def comparison_section(comparison: Comparison) -> Section:
    """Return the laws by AICc; a dash where a law has no such number."""
    rows = tuple(
        (
            entry.law,
            plain(entry.delta_aicc, ".1f") if entry.counted else "–",
            plain(entry.weight, ".3f") if entry.counted else "–",
            percent(entry.loco_error),
            entry.status,
        )
        for entry in comparison.ranking
    )
    headings = ("law", "ΔAICc", "weight", "error at unseen conditions", "status ")
    left_out = tuple(
        f"{entry.law} is not counted: {entry.note}" for entry in comparison.ranking if entry.note
    )
    table = Table(headings=headings, rows=rows)
    return Section(title="Comparison", table=table, notes=comparison.notes + left_out)


def diagnosis_section(diagnosis: Diagnosis, *, full: bool = False) -> Section:
    """Return why the rope does not obey the capstan equation: the verdicts with their evidence.

    With `full`, the experiments that would decide as well.
    """
    if full:
        return Section(title="", lines=tuple(diagnosis.text.splitlines()))
    notes = tuple(
        f"{cause.cause}: {_VERDICTS[cause.supported]}; {cause.evidence}" for cause in diagnosis.causes
    )
    return Section(title="Does it obey the capstan equation?", lines=(diagnosis.summary,), notes=notes)


def prediction_section(prediction: Prediction, index: int = 0) -> Section:
    """Return the lift force of one condition with both its intervals."""
    at, level = prediction.conditions, f"{100 * prediction.level:g} %"
    where = (
        f"R_w = {plain(1e3 * at.wheel_radius_m[index])} mm, rope of {plain(2e3 * at.rope_radius_m[index])} mm, "
        f"wrap {plain(math.degrees(at.wrap_angle_rad[index]))} deg, F_B = {plain(at.end_tension_N[index])} N"
    )
    lift = plain(prediction.lift_force_N[index], ".5g")
    title, symbol = (
        ("Kinetic force", "F_A while sliding") if prediction.of == "kinetic" else ("Lift force", "F_A")
    )
    lines = [
        f"{where}:",
        f"{symbol} = {lift} N by {prediction.law}, standard error {_newtons(prediction.std_N[index])}",
        f"{level} confidence interval of the mean: {_span(prediction.interval_N[index])}",
    ]
    wide = prediction.prediction_interval_N[index]
    if not math.isnan(float(wide[0])):
        lines.append(f"{level} prediction interval of one pull with a new rope: {interval(wide)} N")
    verdict = prediction.verdict(index)
    lines.append(f"{verdict.word}: {verdict.reason}")
    notes = prediction.notes(index)
    if not verdict.supported and prediction.spread_N is not None:
        low, high = prediction.spread_N
        lines.append(f"laws that the data do not tell apart answer {plain(low)} … {plain(high)} N:")
        notes = (*(_candidate(item) for item in prediction.candidates), *notes)
    return Section(
        title=title,
        lines=tuple(lines),
        notes=tuple(n for n in notes if n not in verdict.reasons),
    )


def _candidate(item: Candidate) -> str:
    error = f"standard error {_newtons(item.std_N)}, interval {_span(item.interval_N)}"
    return f"{item.law}: {plain(item.lift_force_N, '.5g')} N, {error}"


def _newtons(value: float) -> str:
    return f"{plain(value, '.2g')} N" if math.isfinite(value) else "not known"


def _span(ends: Iterable[float]) -> str:
    ends = tuple(ends)
    return f"{interval(ends)} N" if all(math.isfinite(end) for end in ends) else "not known"


def tested_ranges(fit: FitResult) -> tuple[str, ...]:
    """Return the tested range of each regressor in words, in the unit people set it in."""
    found = []
    for name, (title, unit, factor) in REGRESSORS.items():
        if name in fit.validity:
            low, high = (plain(factor * end) for end in fit.validity[name])
            found.append(f"{title} {low} {unit}" if low == high else f"{title} {low} to {high} {unit}")
    return tuple(found)


_GOALS = {"v": "the wanted prediction", "d": "the parameters"}


def plan_sections(plan: LabPlan) -> tuple[Section, ...]:
    """Return a plan as sections: its conditions, and the wanted predictions before and after."""
    n = len(plan)
    rows = tuple(
        (
            str(row["condition"]),
            plain(1e3 * row["wheel_radius_m"]),
            plain(math.degrees(row["wrap_angle_rad"])),
            plain(row["end_tension_N"]),
            str(row["repeats"]),
            plain(row["expected_lift_force_N"]),
            f"{100 * row['cell_use']:.0f} %",
        )
        for row in plan.rows()
    )
    headings = ("no.", "R_w [mm]", "wrap [deg]", "F_B [N]", "repeats", "expected F_A [N]", "of the cell")
    pulls = counted(n * plan.repeats, "pull")
    title = f"{counted(n, 'condition')} to test, {pulls}, the best for {_GOALS[plan.criterion]}"
    scatter = plan.planned.scatter
    values = plan.planned.law.as_mapping(plan.planned.theta)
    expected = ", ".join(
        f"{name} = {plain(values[name], '.3g')} ± {plain(std, '.1g')}"
        for name, std in plan.expected_parameter_std().items()
    )
    means = (
        f"{plan.planned.law.name}; scatter between repeats "
        f"{100 * scatter.within:.2g} %, between conditions {100 * scatter.between:.2g} %, measuring chain "
        f"{plain(scatter.instrument_N, '.2g')} N"
    )
    search = (
        f"the best of {plan.n_candidates} possible conditions; {plan.agreeing_starts} of {plan.starts} starts of "
        "the search came out as good"
    )
    what = Section(
        title=title,
        lines=(means, f"standard errors to expect: {expected}", search),
        table=Table(headings=headings, rows=rows),
        notes=plan.notes,
    )
    return what, *(_worth_section(plan, i) for i in range(len(plan.wanted)))


def _worth_section(plan: LabPlan, i: int) -> Section:
    at, lift_N = plan.wanted, float(np.exp(plan.wanted_log_lift[i]))
    where = (
        f"R_w = {plain(1e3 * at.wheel_radius_m[i])} mm, wrap {plain(math.degrees(at.wrap_angle_rad[i]))} deg, "
        f"F_B = {plain(at.end_tension_N[i])} N"
    )
    cases = (
        ("before", plan.before),
        ("with this plan", plan.after),
        ("one factor at a time about the middle", plan.one_factor),
        ("one factor at a time about the wanted condition", plan.one_factor_at_target),
    )
    rows = tuple(_outlook_row(name, outlook, lift_N, i) for name, outlook in cases)
    headings = ("tests", "standard error [N]", f"{100 * plan.level:g} % interval of the mean [N]", "dof")
    gain = (
        f"intervals {plain(plan.gain, '.3g')} times as narrow as one factor at a time about the middle, "
        f"{plain(plan.gain_at_target, '.3g')} times as about the wanted condition"
    )
    caution = "expected for these parameters and this scatter; plan again when the first tests have told them better"
    return Section(
        title=f"Worth of the plan: F_A = {plain(lift_N)} N",
        lines=(where,),
        table=Table(headings=headings, rows=rows),
        notes=(gain, caution),
    )


def _outlook_row(name: str, outlook: Outlook, lift_N: float, i: int) -> tuple[str, ...]:
    half = float(outlook.half_width_log[i])
    span = interval((lift_N * math.exp(-half), lift_N * math.exp(half))) if half < 50.0 else "cannot be told"
    return name, plain(lift_N * float(outlook.std_log[i]), ".2g"), span, str(outlook.dof)


_BUDGET = (
    "source",
    "symbol",
    "estimate",
    "stated",
    "divisor",
    "u(x)",
    "unit ",
    "type ",
    "distribution ",
    "sensitivity",
    "|c| u",
    "share",
    "dof",
)
_DIVISORS = {math.sqrt(3.0): "√3", math.sqrt(12.0): "√12", 1.0: "1"}


def uncertainty_sections(stated: Statement, title: str) -> tuple[Section, ...]:
    """Return a statement of uncertainty as sections: budget, check, what would shrink it, what is not in it."""
    found = stated.budget
    unit = "" if stated.model.unit == "-" else f" {stated.model.unit}"
    rows = tuple(_budget_row(line) for line in found.lines)
    answer = (
        f"{stated.model.symbol} = {plain(found.estimate, '.5g')}{unit} ± {plain(found.expanded, '.2g')}{unit} "
        f"({100 * found.level:g} %)"
    )
    sums = (
        f"u_c = {plain(found.combined, '.3g')}{unit}, ν_eff = {plain(found.effective_dof, '.3g')}, "
        f"k = {plain(found.coverage_factor, '.3g')}: U = {plain(found.expanded, '.3g')}{unit}"
    )
    budget = Section(
        title=title,
        lines=(answer, sums),
        table=Table(headings=_BUDGET, rows=rows, left=2),
        notes=(f"{stated.status}: {stated.status.advice}", *stated.notes),
    )
    return budget, _draws_section(stated, unit), _improvements_section(stated, unit)


def budgets_section(stated: Sequence[tuple[int, str, Statement]], title: str) -> Section:
    """Return many statements as one table: number, condition in words, answer, U, and what dominates."""
    rows = tuple(
        (
            str(number),
            words,
            plain(item.budget.estimate, ".5g"),
            plain(item.budget.combined, ".2g"),
            plain(item.budget.effective_dof, ".3g"),
            plain(item.budget.expanded, ".2g"),
            f"{100 * item.budget.expanded / abs(item.budget.estimate):.2g} %",
            f"{item.budget.lines[0].label} ({100 * item.budget.lines[0].share:.0f} %)",
            str(item.status),
        )
        for number, words, item in stated
    )
    headings = (
        "no.",
        "condition ",
        "estimate",
        "u_c",
        "ν_eff",
        "U",
        "U/estimate",
        "largest part ",
        "status ",
    )
    return Section(title=title, table=Table(headings=headings, rows=rows, left=2))


def _budget_row(line: BudgetLine) -> tuple[str, ...]:
    share, dof = f"{100 * line.share:.1f} %", plain(line.dof, ".3g")
    if not isinstance(line.source, Quantity):
        return (line.name, "θ", "–", "–", "–", "–", "", line.type, "joint, with covariance", "–",
                plain(line.contribution, ".2g"), share, dof)  # fmt: skip
    item = line.source
    divisor = next((text for value, text in _DIVISORS.items() if math.isclose(value, item.divisor)), "")
    if not divisor:
        divisor = f"√{item.repeats}" if item.repeats else plain(item.divisor, ".3g")
    return (
        line.label,
        item.symbol,
        plain(item.estimate, ".5g"),
        plain(item.stated, ".2g"),
        divisor,
        plain(item.std, ".2g"),
        item.unit,
        item.type,
        item.distribution,
        plain(line.sensitivity, ".3g"),
        plain(line.contribution, ".2g"),
        share,
        dof,
    )


def _draws_section(stated: Statement, unit: str) -> Section:
    drawn, found = stated.drawn, stated.budget
    half_68 = f"{plain(drawn.half_68, '.3g')}{unit}"
    lines = (
        f"y ± U: {interval(found.interval, '.5g')}{unit}",
        f"symmetric: {interval(drawn.symmetric, '.5g')}{unit}; shortest: {interval(drawn.shortest, '.5g')}{unit}",
        f"half the central 68.27 %: {half_68} against u_c = {plain(found.combined, '.3g')}{unit}",
        _agreement(stated, unit),
        _strict_test(stated, unit),
    )
    return Section(title=f"Check by {drawn.draws} draws (seed {drawn.seed})", lines=lines)


def _agreement(stated: Statement, unit: str) -> str:
    """Return how far the ends of y ± U are from those of the draws, and whether that counts as agreement."""
    drawn, expanded = stated.drawn, stated.budget.expanded
    gap = max(drawn.low_gap, drawn.high_gap)
    word = "agrees" if drawn.agrees else "does not agree"
    left_out = f"; {drawn.unanswered} draws have no answer" if drawn.unanswered else ""
    return (
        f"the budget {word} with the draws: the ends differ by up to {plain(gap, '.2g')}{unit}, "
        f"{100 * gap / expanded:.2g} % of U ({100 * DISAGREEMENT:g} % count as agreement){left_out}"
    )


def _strict_test(stated: Statement, unit: str) -> str:
    """Return to how many digits the stricter test of JCGM 101 holds."""
    digits, u_c = stated.drawn.digits, stated.budget.combined
    allowed = f"{plain(numerical_tolerance(u_c, max(digits, 1)), '.2g')}{unit}"
    if digits:
        count = {1: "one digit", 2: "two digits"}[digits]
        return f"the stricter test of JCGM 101, 8.1, holds to {count} of u_c, for which {allowed} are allowed"
    return f"the stricter test of JCGM 101, 8.1, is not passed: to one digit of u_c {allowed} are allowed"


def _improvements_section(stated: Statement, unit: str) -> Section:
    notes = tuple(
        f"{item.action}: U = {plain(item.expanded, '.3g')}{unit}, {100 * item.saving:.0f} % smaller"
        for item in stated.improvements
    )
    return Section(title="What would make it smaller", notes=notes)
