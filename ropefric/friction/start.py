"""Where a fit starts: the best of a few candidates, brought near the data by damped Gauss-Newton steps."""

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw

# Enough to tell the candidates apart; a start needs no more.
_MAX_CONDITIONS = 400
_FINALISTS = 12
_STEPS = 40
# A set is settled when the next step would lower its sum of squares by less than this part of it,
_SETTLED = 1e-6
# or of the data's: ln F_A is then met to ten digits.
_NOTHING = 1e-20


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
    try:
        # Data at the ends of what a float holds overflow on the way.
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            found = _searched(law, conditions, data)
    except (InputError, np.linalg.LinAlgError):
        found = typical
    return np.clip(found if np.isfinite(found).all() else typical, law.lower, law.upper)


def _searched(
    law: FrictionLaw,
    conditions: Conditions,
    log_lift: FloatArray,
) -> FloatArray:
    if len(conditions) > _MAX_CONDITIONS:
        rows = np.linspace(0, len(conditions) - 1, _MAX_CONDITIONS).round().astype(np.int64)
        conditions, log_lift = conditions.select(rows), log_lift[rows]
    candidates = law.candidates(mean_mu(conditions, log_lift), conditions, log_lift)
    theta = np.clip(np.asarray(candidates, dtype=np.float64), law.lower, law.upper)
    theta = theta[law.admissible(theta, conditions)]
    if not len(theta):
        return np.array([parameter.start for parameter in law.parameters])
    misfit = np.abs(law.log_lift(theta, conditions) - log_lift).sum(axis=-1)
    best = theta[np.argsort(misfit, kind="stable")[:_FINALISTS]]
    best, misfit = _approach(law, conditions, log_lift, best)
    chosen: FloatArray = best[int(np.argmin(misfit))]
    return chosen


def _approach(
    law: FrictionLaw, conditions: Conditions, log_lift: FloatArray, theta: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the sets after damped steps inside the bounds, all at once, and their sums of absolute residuals."""
    theta, misfit = theta.copy(), np.empty(len(theta))
    rows = np.arange(len(theta))
    damping = np.full(len(theta), 1e-2)
    near, residual, J = theta, *_seen(law, conditions, log_lift, theta)
    nothing = _NOTHING * float(log_lift @ log_lift)
    for _ in range(_STEPS):
        step, fall = _damped_step(law, near, J, residual, damping)
        square = (residual**2).sum(axis=-1)
        going = ~((fall <= _SETTLED * square + nothing) & (damping <= 1.0))
        if not going.all():
            theta[rows[~going]], misfit[rows[~going]] = near[~going], np.abs(residual[~going]).sum(axis=-1)
            rows, near, residual, J = rows[going], near[going], residual[going], J[going]
            step, square, damping = step[going], square[going], damping[going]
            if not rows.size:
                return theta, misfit
        trial = np.clip(near + step, law.lower, law.upper)
        trial = np.where(law.admissible(trial, conditions)[:, np.newaxis], trial, near)
        try:
            trial_residual, trial_J = _seen(law, conditions, log_lift, trial)
        except InputError:
            # In a corner of the bounds a slope may overflow where the law itself still answers.
            answered = [_answers(law, conditions, one) for one in trial]
            trial = np.where(np.array(answered)[:, np.newaxis], trial, near)
            trial_residual, trial_J = _seen(law, conditions, log_lift, trial)
        better = (trial_residual**2).sum(axis=-1) < square
        near = np.where(better[:, np.newaxis], trial, near)
        residual = np.where(better[:, np.newaxis], trial_residual, residual)
        J = np.where(better[:, np.newaxis, np.newaxis], trial_J, J)
        damping = np.clip(np.where(better, damping * 0.2, damping * 5.0), 1e-12, 1e8)
    theta[rows], misfit[rows] = near, np.abs(residual).sum(axis=-1)
    return theta, misfit


def _answers(law: FrictionLaw, conditions: Conditions, theta: FloatArray) -> bool:
    try:
        law.log_lift_and_jacobian(theta, conditions)
    except InputError:
        return False
    return True


def _seen(
    law: FrictionLaw, conditions: Conditions, log_lift: FloatArray, theta: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the residuals of the sets, shape (m, n), and the slopes of the law."""
    values, J = law.log_lift_and_jacobian(theta, conditions)
    return log_lift - values, J


def _damped_step(
    law: FrictionLaw, theta: FloatArray, J: FloatArray, residual: FloatArray, damping: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the steps, bounds not looked at, and how far they should lower the sums of squares."""
    normal = J.swapaxes(1, 2) @ J
    downhill = (J.swapaxes(1, 2) @ residual[:, :, np.newaxis])[:, :, 0]
    # A parameter that presses against its bound is out of the step, or it would spoil the others'.
    held = ((theta <= law.lower) & (downhill < 0.0)) | ((theta >= law.upper) & (downhill > 0.0))
    held |= np.array([parameter.fixed for parameter in law.parameters])
    normal = np.where(held[:, :, np.newaxis] | held[:, np.newaxis, :], 0.0, normal)
    downhill = np.where(held, 0.0, downhill)
    size = np.einsum("mii->mi", normal)
    scale = np.where(size > 0.0, size, 1.0)
    extra = damping[:, np.newaxis] * scale + (size <= 0.0)
    system = normal + np.eye(theta.shape[1]) * extra[:, np.newaxis]
    step = np.linalg.solve(system, downhill[..., np.newaxis])[..., 0]
    # (N + E) s = g makes the fall 2 gᵀs − sᵀN s = gᵀs + sᵀE s, where nothing cancels.
    return step, (step * (downhill + extra * step)).sum(axis=-1)
