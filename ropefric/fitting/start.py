"""Where a fit starts: the best of a few candidates of the law, brought near the data by the engine of every fit."""

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.fitting.levenberg import batched_fit
from ropefric.fitting.problem import FitProblem
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw

# Enough to tell the candidates apart; a start needs no more.
_MAX_CONDITIONS = 400
_FINALISTS = 12
_STEPS = 40
# In standard errors: starts further off (0.01) lead some laws into another place of their valley.
_NEAR = 1e-4


def mean_mu(conditions: Conditions, log_lift: FloatArray) -> float:
    """Return the median average coefficient of the data, at least 0.001, which one bad trial cannot move far."""
    wrapped = conditions.wrap_angle_rad > 0.0
    if not wrapped.any():
        return 0.2
    rise = (log_lift - conditions.log_end_tension)[wrapped]
    return max(float(np.median(rise / conditions.wrap_angle_rad[wrapped])), 1e-3)


def guess(law: FrictionLaw, conditions: Conditions, log_lift: npt.ArrayLike) -> FloatArray:
    """Return parameters to start a fit of any law from, shape (p,), inside its bounds.

    They are its typical values where no number of the data, measured ln(F_A / 1 N) of shape (n,), leads to better ones.
    """
    data = np.asarray(log_lift, dtype=np.float64)
    if data.shape != (len(conditions),) or not np.isfinite(data).all():
        raise InputError(
            f"{law.name}: {data.shape} finite values of ln F_A are needed for {len(conditions)} conditions",
            key="log_lift",
        )
    typical = np.array([parameter.start for parameter in law.parameters])
    if data.size > _MAX_CONDITIONS:
        rows = np.linspace(0, data.size - 1, _MAX_CONDITIONS).round().astype(np.int64)
        conditions, data = conditions.select(rows), data[rows]
    problem = FitProblem(
        law=law, conditions=conditions, log_lift=data, std=np.ones_like(data), group=np.arange(data.size), start=typical,
        lower=law.lower, upper=law.upper, vary=np.array([not parameter.fixed for parameter in law.parameters]),
    )  # fmt: skip
    try:
        # Data at the ends of what a float holds overflow on the way.
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            found = _searched(problem)
    except (InputError, np.linalg.LinAlgError):
        found = typical
    return np.clip(found if np.isfinite(found).all() else typical, law.lower, law.upper)


def _searched(problem: FitProblem) -> FloatArray:
    law, conditions, log_lift = problem.law, problem.conditions, problem.log_lift
    candidates = law.candidates(mean_mu(conditions, log_lift), conditions, log_lift)
    theta = np.clip(np.asarray(candidates, dtype=np.float64), law.lower, law.upper)
    theta = theta[law.admissible(theta, conditions)]
    if not len(theta):
        return problem.start
    misfit = np.abs(law.log_lift(theta, conditions) - log_lift).sum(axis=-1)
    best = theta[np.argsort(misfit, kind="stable")[:_FINALISTS]]
    best = batched_fit(problem, starts=best, tolerance=_NEAR, max_iterations=_STEPS).theta
    return np.asarray(best[np.argmin(np.abs(law.log_lift(best, conditions) - log_lift).sum(axis=-1))])
