"""The conditions a plan may choose from: those the law has an answer for and the cell takes, not tested before."""

import math

import numpy as np

from ropefric.arrays import BoolArray
from ropefric.fitting.planning.limits import FACTORS, RigLimits
from ropefric.fitting.planning.precision import PlannedLaw
from ropefric.friction.condition import Conditions, condition_groups


def allowed_conditions(
    planned: PlannedLaw, limits: RigLimits, grid: Conditions
) -> tuple[BoolArray, list[str]]:
    """Return which combinations can be tested, shape (N,), and what is left out, in words."""
    law, theta = planned.law, planned.theta
    allowed, notes = law.answers(theta, grid), []
    refused = ~allowed
    if refused.any():
        notes.append(
            f"{int(refused.sum())} of {len(grid)} settings are left out: {law.name} has no answer there"
        )
    if allowed.any():
        log_lift = np.full(len(grid), -np.inf)
        log_lift[allowed] = law.log_lift(theta, grid.select(allowed))
        over = log_lift > math.log(limits.largest_force_N)
        if over.any():
            notes.append(
                f"{int(over.sum())} of {len(grid)} settings are left out: F_A would exceed the "
                f"{limits.largest_force_N:.4g} N of the cell"
            )
        allowed &= ~over
    return allowed, notes


def tested_before(planned: PlannedLaw, grid: Conditions) -> BoolArray:
    """Return which combinations were tested before, shape (N,): a condition set up again is no new one."""
    if planned.tested is None:
        return np.zeros(len(grid), dtype=bool)
    names = (*FACTORS, "rope_radius_m")
    group = condition_groups(
        *(np.append(getattr(planned.tested, name), getattr(grid, name)) for name in names)
    )
    n_tested = len(planned.tested)
    return np.isin(group[n_tested:], group[:n_tested])
