"""An extraction told to people: conditions in the rig's units, and the recordings that need a look."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

from ropefric.cli.tables import make_table, number
from ropefric.errors import Problem
from ropefric.glossary import counted
from ropefric.traces.breakaway import ADVICE, Status

if TYPE_CHECKING:
    from rich.console import Console

    from ropefric.trials.result import ConditionSummary, Extraction, TrialResult


MAX_ALIKE = 3
"""Problems of one code that are said in full; the others are counted."""

# The advice for these says something about the measurement; an unreadable file has advice of its own.
_FLAGS = (Status.NO_BREAKAWAY, Status.NO_PEAK, Status.SATURATED, Status.TOO_SHORT)


def show_extraction(extraction: "Extraction", console: "Console") -> None:
    """Print a row a condition, then the recordings without a usable force and what to do about them."""
    slack = any(trial.measures_slack for trial in extraction.trials)
    known, measured = ("F_A", "F_B") if slack else ("F_B", "F_A")
    headings = (
        *("R_w [mm]", "φ [deg]", f"{known} [N]", "trials", "kept"),
        *(f"mean {measured} [N]", "s [N]", "rejected "),
    )
    rows = [_condition_row(condition, slack=slack) for condition in extraction.conditions]
    console.print(make_table(headings, rows, left=0))
    flagged = _flagged(extraction)
    if not flagged:
        return
    console.print(f"\n{len(flagged)} of {len(extraction.trials)} trials are without a force:\n")
    console.print(make_table(("trial", "status", "why "), [_flagged_row(trial) for trial in flagged], left=3))
    console.print()
    for status in dict.fromkeys(
        trial.breakaway.status for trial in flagged if trial.breakaway.status in _FLAGS
    ):
        console.print(f"{status}: {ADVICE[status]}", markup=False)


def other_problems(extraction: "Extraction") -> list[Problem]:
    """Return what else was wrong or doubtful, beside the flagged recordings that the summary lists.

    Many problems of one kind are said a few times and then counted.
    """
    listed = {problem for trial in _flagged(extraction) for problem in trial.problems}
    others = [problem for problem in extraction.problems if problem not in listed]
    by_code: dict[str, list[Problem]] = {}
    for problem in others:
        by_code.setdefault(problem.code, []).append(problem)
    said: list[Problem] = []
    for alike in by_code.values():
        said += alike[:MAX_ALIKE]
        rest = alike[MAX_ALIKE:]
        if rest:
            worst = next((problem for problem in rest if problem.severity == "error"), rest[0])
            text = f"{len(rest)} more like these"
            said.append(Problem(code=worst.code, message=text, severity=worst.severity))
    return said


def end_line(extraction: "Extraction", problems_file: Path) -> str:
    """Return the last word on a run: what became of the trials, and where the reasons are listed."""
    from ropefric.trials.result import count_trials, outcome_words  # noqa: PLC0415  (quick start-up)

    trials = extraction.trials
    n_recordings = len({(trial.file, trial.sample) for trial in trials})
    what = counted(len(trials), "trial")
    if n_recordings != len(trials):
        what += f" in {counted(n_recordings, 'recording')}"
    tally = outcome_words(count_trials(extraction))
    reused = f" ({extraction.n_reused} unchanged, not extracted again)" if extraction.n_reused else ""
    return f"{what}: {tally}{reused} → {problems_file}"


def _flagged(extraction: "Extraction") -> "list[TrialResult]":
    return [trial for trial in extraction.trials if trial.outcome == "without a force"]


def _condition_row(condition: "ConditionSummary", *, slack: bool) -> tuple[str, ...]:
    return (
        number(1e3 * condition.wheel_radius_m),
        number(math.degrees(condition.wrap_angle_rad)),
        number(condition.lift_force_N if slack else condition.end_tension_N),
        str(condition.n_recorded),
        str(condition.n_kept),
        number(condition.mean_kept_N),
        number(condition.std_kept_N, ".2g"),
        ", ".join(condition.rejected),
    )


def _flagged_row(trial: "TrialResult") -> tuple[str, str, str]:
    why = trial.breakaway.detail
    if trial.breakaway.status not in _FLAGS:
        why = "; ".join([why, *(problem.fix for problem in trial.problems if problem.fix)])
    return trial.trial, str(trial.breakaway.status), why
