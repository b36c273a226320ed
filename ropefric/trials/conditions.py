"""Trials grouped by condition, and what the rejection rule keeps of each."""

from collections.abc import Sequence
from dataclasses import replace
from math import isnan, nan

import numpy as np

from ropefric.errors import Problem
from ropefric.friction.condition import condition_groups
from ropefric.trials.repeatability import summarise
from ropefric.trials.result import ConditionSummary, TrialResult


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


def _known_N(trial: TrialResult) -> float:
    return trial.peak_N if trial.measures_slack else trial.end_tension_N


def _key(trial: TrialResult) -> tuple[float, ...]:
    return (trial.wheel_radius_m, trial.rope_radius_m, trial.wrap_angle_rad, _known_N(trial))


def _summarise(
    trials: Sequence[TrialResult], rule: str
) -> tuple[ConditionSummary, tuple[int, ...], list[Problem]]:
    first = trials[0]
    usable = [place for place, trial in enumerate(trials) if trial.usable]
    measured_N = np.array([trials[place].measured_N for place in usable], dtype=np.float64)
    series = summarise(measured_N, rule)
    rejected = tuple(usable[place] for place in series.rejected)
    known_N = _known_N(first)
    mean_N = series.mean_kept if series.n_kept else nan
    end_N, lift_N = (mean_N, known_N) if first.measures_slack else (known_N, mean_N)
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
        mean_kept_N=mean_N,
        std_kept_N=series.std_kept if not isnan(mean_N) else nan,
        rule=rule,
        notes=(*series.warnings, *series.notes),
        trials=tuple(trial.trial for trial in trials),
    )
    return summary, rejected, problems
