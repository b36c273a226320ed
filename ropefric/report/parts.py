"""The parts of a summary, each from one result: a fit, a comparison, a diagnosis, a prediction."""

import math
from collections.abc import Iterable

from ropefric.fitting.compare import Comparison
from ropefric.fitting.diagnose import Diagnosis
from ropefric.fitting.predict import REGRESSORS, Candidate, Prediction
from ropefric.fitting.result import FitResult
from ropefric.fitting.verdict import Verdict
from ropefric.glossary import counted
from ropefric.report.section import Section, Table, interval, plain, shorthand

_VERDICTS = {"yes": "supported", "no": "not supported", "cannot-tell": "cannot be told"}


def fit_section(fit: FitResult, title: str = "", *, short: bool = False) -> Section:
    """Return a fitted law with its parameters and their 95 % intervals; in `short`, values as 0.1192(12)."""
    law, found = fit.friction_law, fit.statistics
    between = f"between conditions {_percent(found.scatter_between)}"
    lines = (
        f"{law.name}: {law.equation}",
        f"{counted(found.n, 'trial')} of {counted(found.n_conditions, 'condition')}",
        f"scatter between repeats {_percent(found.scatter_within)}, {between}",
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
    ranges = tuple(tested_range(name, fit.validity[name]) for name in REGRESSORS if name in fit.validity)
    made = ", ".join(f"{name} {number}" for name, number in sorted(versions.items()))
    lines = (f"from {source.get('path') or 'no file'}, with {made or 'unknown versions'}", "tested:")
    return Section(title="Where it comes from, and where it holds", lines=lines, notes=ranges)


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
            _percent(entry.loco_error),
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
    lines = [
        f"{where}:",
        f"F_A = {lift} N by {prediction.law}, standard error {_newtons(prediction.std_N[index])}",
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
        title="Lift force", lines=tuple(lines), notes=tuple(n for n in notes if n not in verdict.reasons)
    )


def _candidate(item: Candidate) -> str:
    error = f"standard error {_newtons(item.std_N)}, interval {_span(item.interval_N)}"
    return f"{item.law}: {plain(item.lift_force_N, '.5g')} N, {error}"


def _newtons(value: float) -> str:
    return f"{plain(value, '.2g')} N" if math.isfinite(value) else "not known"


def _span(ends: Iterable[float]) -> str:
    ends = tuple(ends)
    return f"{interval(ends)} N" if all(math.isfinite(end) for end in ends) else "not known"


def _percent(value: float) -> str:
    return f"{100 * value:.2g} %" if math.isfinite(value) else "–"


def tested_range(name: str, ends: tuple[float, float]) -> str:
    """Return the range of a regressor in words, in the unit people set it in."""
    title, unit, factor = REGRESSORS[name]
    low, high = (plain(factor * end) for end in ends)
    return f"{title} {low} {unit}" if low == high else f"{title} {low} to {high} {unit}"
