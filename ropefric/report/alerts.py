"""What to know before a campaign's result is used, gravest first."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from ropefric.glossary import counted
from ropefric.pipeline.evidence import Evidence
from ropefric.pipeline.run import CampaignRun
from ropefric.report.chapter import Alert
from ropefric.traces.breakaway import ADVICE, Status
from ropefric.trials.outliers import RULES
from ropefric.trials.result import TrialResult

if TYPE_CHECKING:
    from ropefric.errors import Problem


_NAMED = 8
_SAID = 3
_GRADES = ("stop", "doubt", "note")


def alerts_of(run: CampaignRun, evidence: Evidence) -> tuple[Alert, ...]:
    """Return what stands against a result, or ought to be kept in mind; gravest first, empty if nothing."""
    found = [*_of_fit(run), *_of_prediction(run, evidence), *_of_trials(run), *_of_problems(run)]
    return tuple(sorted(found, key=lambda alert: _GRADES.index(alert.grade)))


def _of_fit(run: CampaignRun) -> Iterable[Alert]:
    verdict, law = run.answer.verdict, run.answer.fit.law
    if not verdict.supported:
        yield Alert(grade="stop", title=f"The law {law} is {verdict.word}", text=verdict.reason)
    for doubt in run.answer.doubts:
        if doubt not in verdict.reasons:
            yield Alert(grade="doubt", title="About the law", text=doubt)


def _of_prediction(run: CampaignRun, evidence: Evidence) -> Iterable[Alert]:
    prediction = run.answer.prediction
    if prediction is not None:
        outside = bool(prediction.extrapolated[0])
        for note in prediction.notes():
            grade = "doubt" if outside else "note"
            title = "The design lies outside what was tested" if outside else "About the lift force"
            yield Alert(grade=grade, title=title, text=note)  # type: ignore[arg-type]
    elif run.campaign.design is None:
        yield Alert(
            grade="note",
            title="No lift force",
            text="The campaign names no wheel: add [design] with wheel_radius, wrap_angle and end_tension to it.",
        )
    for stated, what in ((evidence.lift, "the lift force"), (evidence.typical, "a typical measured force")):
        if stated is not None and not stated.trustworthy:
            title = f"About the uncertainty of {what}: {stated.status}"
            yield Alert(grade="doubt", title=title, text=stated.status.advice)
    for text in evidence.missing:
        yield Alert(grade="note", title="Left out of this report", text=text)


def _of_trials(run: CampaignRun) -> Iterable[Alert]:
    trials = run.extraction.trials
    for status in Status:
        if status is not Status.OK and (
            flagged := [t for t in trials if t.outcome == "without a force" and t.breakaway.status is status]
        ):
            title = f"{counted(len(flagged), 'trial')} without a force: {status}"
            yield Alert(grade="doubt", title=title, text=f"{_named(flagged)}. {_advice(status, flagged)}")
    by_rule: dict[str, list[TrialResult]] = {}
    by_reason: dict[str, list[TrialResult]] = {}
    for trial in trials:
        if trial.outcome == "rejected":
            by_rule.setdefault(trial.rejected_by, []).append(trial)
        elif trial.excluded:
            by_reason.setdefault(trial.excluded, []).append(trial)
    for rule, rejected in by_rule.items():
        label = RULES[rule].label if rule in RULES else rule
        title = f"{counted(len(rejected), 'trial')} rejected by the rule {rule} ({label})"
        text = f"{_named(rejected)}. They take no part in the law; look for a physical reason."
        yield Alert(grade="note", title=title, text=text)
    for reason, excluded in by_reason.items():
        yield Alert(
            grade="note",
            title=f"{counted(len(excluded), 'trial')} excluded: {reason}",
            text=f"{_named(excluded)}.",
        )


def _of_problems(run: CampaignRun) -> Iterable[Alert]:
    """Return what else was wrong or doubtful, by kind; what a flagged recording says of itself is said already."""
    said = {
        problem
        for trial in run.extraction.trials
        if trial.breakaway.status is not Status.OK
        for problem in trial.problems
    }
    by_code: dict[str, list[Problem]] = {}
    for problem in run.extraction.problems:
        if problem not in said:
            by_code.setdefault(problem.code, []).append(problem)
    for code, alike in by_code.items():
        messages = [problem.message for problem in alike[:_SAID]]
        if len(alike) > _SAID:
            messages.append(f"{len(alike) - _SAID} more like these, listed in problems.csv")
        fixes = dict.fromkeys(problem.fix for problem in alike[:_SAID] if problem.fix)
        text = "; ".join(messages) + "." + (f" To do: {'; '.join(fixes)}." if fixes else "")
        grave = any(problem.severity == "error" for problem in alike)
        yield Alert(grade="doubt" if grave else "note", title=f"About the recordings ({code})", text=text)


def _advice(status: Status, flagged: Sequence[TrialResult]) -> str:
    """Return what to do about a status; for a file that could not be read, the reader's own words."""
    if status is not Status.UNREADABLE:
        return ADVICE[status]
    fixes = dict.fromkeys(problem.fix for trial in flagged for problem in trial.problems if problem.fix)
    details = dict.fromkeys(trial.breakaway.detail for trial in flagged)
    return f"{'; '.join([*details][:_SAID])}. To do: {'; '.join([*fixes][:_SAID]) or 'record again'}."


def _named(trials: Sequence[TrialResult]) -> str:
    names = ", ".join(trial.trial for trial in trials[:_NAMED])
    rest = len(trials) - _NAMED
    return f"{names} and {rest} more" if rest > 0 else names
