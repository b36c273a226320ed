"""What an extraction hands to a fit: no pull in which friction would have helped the rope along."""

from dataclasses import replace

from ropefric.trials.campaign_model import Campaign
from ropefric.trials.conditions import summarise_conditions
from ropefric.trials.result import Extraction, TrialResult

REASON = "F_A is not above F_B"
"""Why a trial is set aside that no friction law can explain."""


def set_aside_impossible(extraction: Extraction, campaign: Campaign) -> Extraction:
    """Return the extraction without kept trials whose tight side does not pull harder than the slack side.

    Such a trial has exchanged sides, units or cells; a fit refuses it. It stays in the tables with the reason, and
    the means of its condition are formed without it.
    """
    if not any(_impossible(trial) for trial in extraction.trials):
        return extraction
    marked = [
        replace(trial, kept=False, excluded=REASON) if _impossible(trial) else trial
        for trial in extraction.trials
    ]
    trials, conditions, doubts = summarise_conditions(marked, campaign.rejection)
    problems = [*campaign.warnings]
    for trial in trials:
        problems.extend(trial.problems)
    return replace(extraction, trials=trials, conditions=conditions, problems=(*problems, *doubts))


def _impossible(trial: TrialResult) -> bool:
    return trial.usable and trial.peak_N <= trial.end_tension_N
