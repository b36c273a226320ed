"""Repeats of a condition: what the rejection rule keeps, mean and scatter with and without the rest."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError, Problem
from ropefric.friction.condition import condition_groups
from ropefric.shown import Shown
from ropefric.trials.campaign_model import Campaign
from ropefric.trials.outliers import RULES, OutlierRule, scaled
from ropefric.trials.result import SUMMARISED, ConditionSummary, Extraction, TrialResult

NOT_ABOVE = "F_A is not above F_B"
"""Why a trial is set aside that no friction law can explain."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Trimming:
    """What a rule does to clean normal series of n values."""

    ratio: float
    bias: float
    share: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Repeatability(Shown):
    """The repeatability of one condition.

    Attributes
    ----------
    rule : str
        Name of the outlier rule.
    n, n_kept : int
        Number of values, and of those kept.
    rejected : tuple of int
        Indices of the rejected values, from 0.
    mean_all, std_all : float
        Mean and sample standard deviation (divisor n − 1) of all values, in their unit; NaN where there are too
        few for one, 1 and 2.
    mean_kept, std_kept : float
        The same of the kept values.
    warnings : tuple of str
        RF310: why the rule could not reject anything.
    notes : tuple of str
        What rejection does to the scatter, if something was rejected.
    """

    _said = ("rule", "n", "n_kept", "rejected", "mean_kept", "std_kept", "mean_all", "std_all", "warnings")

    rule: str
    n: int
    n_kept: int
    rejected: tuple[int, ...]
    mean_all: float
    std_all: float
    mean_kept: float
    std_kept: float
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def problems(self) -> tuple[Problem, ...]:
        """Return the warnings as problems with code RF310."""
        return tuple(Problem(code="RF310", message=text, severity="warning") for text in self.warnings)


def summarise(values: npt.ArrayLike, rule: OutlierRule | str = "two-sigma") -> Repeatability:
    """Return mean and scatter of a series, with and without the values that a rule rejects in one pass."""
    if isinstance(rule, str):
        rule = RULES[rule]
    everything, rejected = scaled(values), rule.flag(values)
    kept = scaled(np.asarray(values, dtype=np.float64)[~rejected])
    n, n_kept = rejected.size, kept.deviations.size
    warning = rule.warning(n)
    return Repeatability(
        rule=rule.name,
        n=n,
        n_kept=n_kept,
        rejected=tuple(int(index) for index in np.flatnonzero(rejected)),
        mean_all=everything.mean(),
        std_all=everything.std(),
        mean_kept=kept.mean(),
        std_kept=kept.std(),
        warnings=(warning,) if warning else (),
        notes=(_trimming_note(n, rule),) if n_kept < n and rule.trimming else (),
    )


def trimming_bias(n: int, rule: OutlierRule | str = "two-sigma") -> Trimming:
    """Return what a rule does to clean normal series: how low s reads, and how often a good value is lost.

    Interpolated in 1/n from the rule's table of simulated values, which holds 3 to 100 values; above 100 the last
    entry stands.
    """
    if n < 2:
        raise InputError(f"a series of {n} has no scatter", code="RF313", fix="ask for two values or more")
    if isinstance(rule, str):
        rule = RULES[rule]
    # E[s]/σ of untrimmed normal series (c4 of control charts): s itself reads low for few values.
    untrimmed = math.sqrt(2.0 / (n - 1)) * math.exp(math.lgamma(n / 2.0) - math.lgamma((n - 1) / 2.0))
    if not rule.trimming or not rule.can_reject(n):
        return Trimming(ratio=untrimmed, bias=0.0, share=0.0)
    sizes, ratios, shares = (np.array(column) for column in zip(*reversed(rule.trimming), strict=True))
    ratio = float(np.interp(1.0 / n, 1.0 / sizes, ratios))
    return Trimming(
        ratio=ratio, bias=ratio / untrimmed - 1.0, share=float(np.interp(1.0 / n, 1.0 / sizes, shares))
    )


def _trimming_note(n: int, rule: OutlierRule) -> str:
    clean = trimming_bias(n, rule)
    return (
        f"{rule.label} takes a good value from {100 * clean.share:.0f} % of clean normal series of n = {n}, and s "
        f"of what it keeps reads {-100 * clean.bias:.0f} % low on average"
    )


def summarised(campaign: Campaign, trials: Sequence[TrialResult], n_reused: int = 0) -> Extraction:
    """Return trials as the extraction of their campaign: by condition, with what its rule rejects marked."""
    marked, conditions, doubts = summarise_conditions(trials, campaign.rejection)
    of_trials = (problem for trial in marked for problem in trial.problems)
    return Extraction(
        name=campaign.name,
        trials=marked,
        conditions=conditions,
        problems=(*campaign.warnings, *of_trials, *doubts),
        n_reused=n_reused,
    )


def set_aside_impossible(extraction: Extraction, campaign: Campaign) -> Extraction:
    """Return the extraction without kept trials whose tight side does not pull harder than the slack side.

    Such a trial has exchanged sides, units or cells; a fit refuses it. It stays in the tables with the reason, and
    the means of its condition are formed without it.
    """
    impossible = [trial.usable and trial.peak_N <= trial.end_tension_N for trial in extraction.trials]
    if not any(impossible):
        return extraction
    marked = [
        replace(trial, kept=False, excluded=NOT_ABOVE) if wrong else trial
        for trial, wrong in zip(extraction.trials, impossible, strict=True)
    ]
    return summarised(campaign, marked, extraction.n_reused)


def summarise_conditions(
    trials: Sequence[TrialResult], rule: str
) -> tuple[tuple[TrialResult, ...], tuple[ConditionSummary, ...], tuple[Problem, ...]]:
    """Return the trials with the rejected ones marked, a summary per condition, and warnings.

    A condition is a wheel radius, rope radius, wrap angle and known tension, grouped by
    `condition_groups`. The rule runs once over the measured forces of the usable trials of a condition; nothing is
    deleted.
    """
    keys = [_key(trial) for trial in trials]
    numbers = condition_groups(*zip(*keys, strict=True)) if keys else ()
    groups: dict[int, list[int]] = {}
    for index, number in enumerate(numbers):
        groups.setdefault(int(number), []).append(index)
    marked = list(trials)
    conditions, problems = [], []
    for members in sorted(groups.values(), key=lambda members: keys[members[0]]):
        summary, rejected, warnings = _summarise([trials[i] for i in members], rule)
        conditions.append(summary)
        problems.extend(warnings)
        for place in rejected:
            index = members[place]
            marked[index] = replace(trials[index], kept=False, rejected_by=rule)
    return tuple(marked), tuple(conditions), tuple(problems)


def _key(trial: TrialResult) -> tuple[float, ...]:
    return (
        trial.wheel_radius_m,
        trial.rope_radius_m,
        trial.wrap_angle_rad,
        np.nan_to_num(trial.known_N).item(),
    )


def _summarise(
    trials: Sequence[TrialResult], rule: str
) -> tuple[ConditionSummary, tuple[int, ...], list[Problem]]:
    first = trials[0]
    usable = [place for place, trial in enumerate(trials) if trial.usable]
    measured_N = np.array([trials[place].measured_N for place in usable], dtype=np.float64)
    series = summarise(measured_N, rule)
    rejected = tuple(usable[place] for place in series.rejected)
    known_N = first.known_N
    end_N, lift_N = (series.mean_kept, known_N) if first.measures_slack else (known_N, series.mean_kept)
    where = (
        f"R_w = {1000 * first.wheel_radius_m:.4g} mm, wrap {np.degrees(first.wrap_angle_rad):.4g} deg, "
        f"{'F_A' if first.measures_slack else 'F_B'} = {known_N:.4g} N"
    )
    problems = [replace(p, message=f"{where}: {p.message}") for p in series.problems]
    summary = ConditionSummary(
        wheel_radius_m=first.wheel_radius_m,
        rope_radius_m=first.rope_radius_m,
        wrap_angle_rad=first.wrap_angle_rad,
        end_tension_N=end_N,
        lift_force_N=lift_N,
        n_recorded=len(trials),
        n=series.n,
        n_kept=series.n_kept,
        rejected=tuple(trials[place].trial for place in rejected),
        mean_all_N=series.mean_all,
        std_all_N=series.std_all,
        mean_kept_N=series.mean_kept,
        std_kept_N=series.std_kept,
        rule=rule,
        notes=(*series.warnings, *series.notes),
        trials=tuple(trial.trial for trial in trials),
        of_kept=_of_kept([trials[place] for place in usable if place not in rejected]),
    )
    return summary, rejected, problems


def _of_kept(trials: Sequence[TrialResult]) -> dict[str, tuple[float, float, int]]:
    """Return mean, sample standard deviation and number of what else was measured, of what was at all."""
    found = {}
    for name in SUMMARISED:
        values = np.array([trial.measured(name) for trial in trials], dtype=np.float64)
        series = scaled(values[np.isfinite(values)])
        found[name] = (series.mean(), series.std(), series.deviations.size)
    return found
