"""What an extraction hands to a fit: no pull in which friction would have helped the rope along."""

from dataclasses import replace

from ropefric.trials.campaign_model import Campaign
from ropefric.trials.conditions import summarise_conditions
from ropefric.trials.result import Extraction, TrialResult

__all__ = ["REASON", "set_aside_impossible"]

REASON = "F_A is not above F_B"
"""Why a trial is set aside that no friction law can explain."""


def set_aside_impossible(extraction: Extraction, campaign: Campaign) -> Extraction:
    """Return the extraction without kept trials whose tight side does not pull harder than the slack side.

    Such a trial has exchanged sides, units or cells; a fit refuses it. It stays in the tables with the reason, and
    the means of its condition are formed without it.

    Parameters
    ----------
    extraction : Extraction
        What came out of the recordings.
    campaign : Campaign
        Where they came from, for its rejection rule.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> from ropefric.traces.breakaway import Breakaway, Status
    >>> pull = TrialResult(trial="a", file="a.csv", wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=3.0,
    ...     end_tension_N=20.0, peak_N=15.0, kept=True, breakaway=Breakaway(status=Status.OK, peak_N=15.0))
    >>> found = Extraction(name="", trials=(pull,), conditions=(), problems=())
    >>> campaign = SimpleNamespace(rejection="none", warnings=())
    >>> set_aside_impossible(found, campaign).trials[0].excluded
    'F_A is not above F_B'
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
