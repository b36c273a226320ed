"""What was measured, as tables: a row a condition, and a row for each trial that does not count."""

import math

from ropefric.glossary import counted
from ropefric.pipeline.evidence import Evidence
from ropefric.report.section import Section, Table, plain
from ropefric.traces.breakaway import Status
from ropefric.trials.outliers import RULES
from ropefric.trials.result import ConditionSummary, Extraction, TrialResult, count_trials, outcome_words


def conditions_section(extraction: Extraction, evidence: Evidence) -> Section:
    """Return all conditions: how many trials, their mean force, scatter and uncertainty, and which do not count."""
    slack = any(trial.measures_slack for trial in extraction.trials)
    known, measured = ("F_A", "F_B") if slack else ("F_B", "F_A")
    budgets = {item.condition.number: item for item in evidence.measured}
    by_name = {trial.trial: trial for trial in extraction.trials}
    rows = []
    for number, item in enumerate(extraction.conditions, start=1):
        stated = budgets.get(number)
        gone = [name for name in item.trials if not by_name[name].kept]
        rows.append(
            (
                str(number),
                plain(1e3 * item.wheel_radius_m),
                plain(math.degrees(item.wrap_angle_rad)),
                plain(item.lift_force_N if slack else item.end_tension_N),
                f"{item.n_kept} of {item.n_recorded}",
                plain(item.mean_kept_N),
                plain(item.std_kept_N, ".2g"),
                "–" if stated is None else plain(stated.budget.combined, ".2g"),
                "–" if stated is None else f"{100 * stated.relative:.2g} %",
                ""
                if stated is None
                else f"{stated.budget.lines[0].label} ({100 * stated.budget.lines[0].share:.0f} %)",
                ", ".join(gone),
            )
        )
    headings = (
        *("no.", "R_w [mm]", "φ [deg]", f"{known} [N]", "kept", f"mean {measured} [N]", "s [N]"),
        *("u_c [N]", "u_c/mean", "largest part of u_c ", "not kept "),
    )
    note = (
        f"mean {measured} and s: of the trials kept; u_c: standard uncertainty of that mean, repeats and measuring "
        "chain; every trial stands in trials.csv"
    )
    return Section(
        title="Conditions", table=Table(headings=headings, rows=tuple(rows), left=0), notes=(note,)
    )


def set_aside_section(extraction: Extraction) -> Section:
    """Return all trials that do not count: their condition, what became of them, and why."""
    gone = [trial for trial in extraction.trials if not trial.kept]
    place = {name: summary for summary in extraction.conditions for name in summary.trials}
    counts = count_trials(extraction)
    title = f"Trials not kept (of {counted(counts['n_trials'], 'trial')}: {outcome_words(counts)})"
    if not gone:
        return Section(title=title, lines=("Every trial gave a force and counts.",))
    rows = tuple(
        (
            trial.trial,
            _verdict(trial),
            plain(1e3 * trial.wheel_radius_m),
            plain(math.degrees(trial.wrap_angle_rad)),
            plain(trial.peak_N if trial.measures_slack else trial.end_tension_N),
            plain(trial.measured_N),
            _why(trial, place.get(trial.trial)),
        )
        for trial in gone
    )
    slack = any(trial.measures_slack for trial in extraction.trials)
    known, measured = ("F_A", "F_B") if slack else ("F_B", "F_A")
    headings = ("trial", "verdict", "R_w [mm]", "φ [deg]", f"{known} [N]", f"{measured} [N]", "why ")
    return Section(title=title, table=Table(headings=headings, rows=rows, left=2))


def _verdict(trial: TrialResult) -> str:
    return str(trial.breakaway.status) if trial.outcome == "without a force" else trial.outcome


def _why(trial: TrialResult, summary: ConditionSummary | None) -> str:
    if trial.excluded:
        return trial.excluded
    if trial.breakaway.status is not Status.OK:
        return trial.breakaway.detail
    rule = RULES[trial.rejected_by].label if trial.rejected_by in RULES else trial.rejected_by
    if summary is None:
        return rule
    return f"{rule}; mean of all {plain(summary.mean_all_N)} N, s = {plain(summary.std_all_N, '.2g')} N"
