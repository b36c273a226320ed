"""The conditions of an extraction as inputs of a budget, the measuring chain taken apart."""

from collections.abc import Sequence

import numpy as np

from ropefric.fitting.gum.forces import GRAVITY_LIMIT, ForceSide, weights
from ropefric.fitting.gum.instrument import instrument_quantities
from ropefric.fitting.gum.mean import mean_force, pooled_scatter
from ropefric.fitting.gum.measured import MeasuredCondition
from ropefric.trials.conditions import trimming_bias
from ropefric.trials.result import ConditionSummary, Extraction, TrialResult


def conditions_of_extraction(
    extraction: Extraction, *, weights_tolerance: float = 0.0, gravity_limit: float = GRAVITY_LIMIT
) -> tuple[MeasuredCondition, ...]:
    """Return the conditions of an extraction that have a force, with the measuring chain taken apart.

    The repeatability is s/√n of the trials kept, s divided by what the rejection rule leaves of it on average. What
    differs from trial to trial (the cell's repeatability, a tare and a picked peak of each trial's own) is part of it
    and not counted again; what all trials share (linearity, hysteresis, transmitter, calibration line, resolution,
    bias of the smoothing) does not average out and is.
    """
    by_name = {trial.trial: trial for trial in extraction.trials}
    pooled = pooled_scatter([_relative(summary) for summary in extraction.conditions])
    found = []
    for number, summary in enumerate(extraction.conditions, start=1):
        kept = [by_name[name] for name in summary.trials if by_name[name].kept]
        if kept:
            known = (weights_tolerance, gravity_limit)
            found.append(_of_trials(number, summary, kept, pooled, known))
    return tuple(found)


def _of_trials(
    number: int,
    summary: ConditionSummary,
    kept: Sequence[TrialResult],
    pooled: tuple[float, float],
    known: tuple[float, float],
) -> MeasuredCondition:
    slack = kept[0].measures_slack
    symbols = ("F_B", "F_A") if slack else ("F_A", "F_B")
    measured_N = np.array([trial.measured_N for trial in kept])
    ratio = 1.0 + trimming_bias(summary.n, summary.rule).bias if len(kept) > 1 else 1.0
    mean, notes = mean_force(symbols[0], measured_N, pooled, ratio)
    chain, more = instrument_quantities(kept)
    tolerance, gravity_limit = known
    if not tolerance:
        notes += ("the mass of the weights is assumed to be exact: state weights.tolerance",)
    known_N = summary.lift_force_N if slack else summary.end_tension_N
    other = weights(symbols[1], known_N, tolerance=tolerance, gravity_limit=gravity_limit)
    side = ForceSide(symbol=symbols[0], quantities=(mean, *chain))
    lift, end = (other, side) if slack else (side, other)
    return MeasuredCondition(
        number=number,
        wheel_radius_m=summary.wheel_radius_m,
        rope_radius_m=summary.rope_radius_m,
        wrap_angle_rad=summary.wrap_angle_rad,
        wrap_std_rad=0.0,
        lift=lift,
        end=end,
        measures_slack=slack,
        n=len(kept),
        has_scatter=bool(mean.stated),
        notes=(*notes, *more),
    )


def _relative(summary: ConditionSummary) -> tuple[float, int]:
    if summary.n_kept < 2:
        return 0.0, 0
    ratio = 1.0 + trimming_bias(summary.n, summary.rule).bias
    return summary.std_kept_N / summary.mean_kept_N / ratio, summary.n_kept - 1
