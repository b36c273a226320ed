"""Measurement equations of a force and of the average coefficient of friction that two forces give."""

import math
from dataclasses import dataclass, replace

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.fitting.gum.model import MeasurementModel
from ropefric.fitting.gum.quantity import Quantity, limit_of_error

GRAVITY_LIMIT = 0.0027
"""Half the range of the acceleration of gravity at sea level, 9.780 to 9.832 m/s², over its mean [-]."""

_STANDARD_GRAVITY_M_S2 = 9.80665


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceSide:
    """One of the two forces on a rope, and what it is made up of."""

    symbol: str
    quantities: tuple[Quantity, ...]
    is_product: bool = False

    @property
    def force_N(self) -> float:
        """Return the force [N]."""
        return float(self.of(np.array([[item.estimate for item in self.quantities]]))[0])

    def of(self, inputs: FloatArray) -> FloatArray:
        """Return the force [N] of inputs of shape (m, k), shape (m,)."""
        return np.asarray(inputs.prod(axis=1) if self.is_product else inputs.sum(axis=1))

    def slopes(self) -> FloatArray:
        """Return the derivative of the force by each quantity at the estimates, shape (k,)."""
        estimates = np.array([item.estimate for item in self.quantities])
        return self.force_N / estimates if self.is_product else np.ones_like(estimates)


def weights(
    symbol: str, force_N: float, *, tolerance: float = 0.0005, gravity_limit: float = GRAVITY_LIMIT
) -> ForceSide:
    """Return the force of dead weights, m g: its uncertainty is that of mass and gravity, not of a converter."""
    if not (math.isfinite(force_N) and force_N > 0.0):
        raise InputError(f"{symbol} = {force_N:g} N is not positive", key=symbol)
    mass_kg = force_N / _STANDARD_GRAVITY_M_S2
    gravity = limit_of_error(
        "acceleration of gravity",
        "g",
        "m/s2",
        gravity_limit * _STANDARD_GRAVITY_M_S2,
        estimate=_STANDARD_GRAVITY_M_S2,
    )
    if gravity_limit == GRAVITY_LIMIT:
        gravity = replace(gravity, assumed="how well the local g is known (--gravity, gravity_limit)")
    return ForceSide(
        symbol=symbol,
        quantities=(
            limit_of_error(
                f"mass of the weights of {symbol}", "m", "kg", tolerance * mass_kg, estimate=mass_kg
            ),
            gravity,
        ),
        is_product=True,
    )


def force_model(side: ForceSide) -> MeasurementModel:
    """Return the measurement equation of a force."""
    return MeasurementModel(
        name="force",
        symbol=side.symbol,
        unit="N",
        quantities=side.quantities,
        evaluate=side.of,
        sensitivities=side.slopes(),
    )


def coefficient_model(
    lift: ForceSide, end: ForceSide, wrap: Quantity, *, gain_limit: float = 0.0
) -> MeasurementModel:
    """Return the measurement equation of the average coefficient, μ̄ = ln(F_A/F_B)/φ, eq. (2).

    ∂μ̄/∂F_A = 1/(φ F_A), ∂μ̄/∂F_B = −1/(φ F_B), ∂μ̄/∂φ = −μ̄/φ; by the gain (a factor 1 + ε) 1/φ for a measured
    F_A, −1/φ for a measured F_B, and so 0 for both.
    """
    phi, F_A, F_B = wrap.estimate, lift.force_N, end.force_N
    if not phi > 0.0:
        raise InputError(f"over a wrap of {phi:g} rad there is no average coefficient", key="wrap_angle_rad")
    if not F_A > F_B > 0.0:
        raise InputError(
            f"F_A = {F_A:.6g} N does not exceed F_B = {F_B:.6g} N: friction holds nothing",
            key="lift_force_N",
            fix="check which side is which",
        )
    mu = math.log(F_A / F_B) / phi
    n_A, n_B = len(lift.quantities), len(end.quantities)
    gain = limit_of_error("gain of the measuring chain", "ε", "-", gain_limit)
    with_gain = (*lift.quantities, *end.quantities, wrap, *((gain,) if gain_limit > 0.0 else ()))

    def evaluate(inputs: FloatArray) -> FloatArray:
        factor = 1.0 + inputs[:, -1] if gain_limit > 0.0 else 1.0
        A = lift.of(inputs[:, :n_A]) * (1.0 if lift.is_product else factor)
        B = end.of(inputs[:, n_A : n_A + n_B]) * (1.0 if end.is_product else factor)
        angle = inputs[:, n_A + n_B]
        answered = (A > 0.0) & (B > 0.0) & (angle > 0.0)
        ratio = np.divide(A, B, out=np.ones_like(A), where=answered)
        return np.divide(np.log(ratio), angle, out=np.full_like(angle, np.nan), where=answered)

    by_gain = (0.0 if lift.is_product else 1.0) - (0.0 if end.is_product else 1.0)
    parts = [lift.slopes() / (phi * F_A), -end.slopes() / (phi * F_B), np.array([-mu / phi])]
    parts += [np.array([by_gain / phi])] if gain_limit > 0.0 else []
    return MeasurementModel(
        name="average coefficient of friction",
        symbol="μ̄",
        unit="-",
        quantities=with_gain,
        evaluate=evaluate,
        sensitivities=np.concatenate(parts),
    )
