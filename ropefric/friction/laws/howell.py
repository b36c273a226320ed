"""Howell's power law: friction per length grows as a power below one of the contact force per length."""

from collections.abc import Iterable

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.condition import Conditions
from ropefric.friction.integral import log1prel, log1prel_slope
from ropefric.friction.law import Columns, FrictionLaw, Parameter, Refusal, Sheet, Slopes
from ropefric.friction.laws.uniform import CONSTANT


class Howell:
    """The physics of friction A N^n per length, N = T/R with R = R_w + R_r.

    T^{1−n} = F_B^{1−n} + (1 − n) A R^{1−n} φ; with K = A (R/F_B)^{1−n}, the local coefficient at the slack end,
    and z = (1 − n) K φ it reads ln F_A = ln F_B + K φ log1p(z)/z, which is Euler's equation at n = 1.
    """

    def rise(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return K φ log1p(z)/z."""
        K, z = _scales(columns, conditions)
        return K * conditions.wrap_angle_rad * log1prel(z)

    def rise_and_slopes(self, columns: Columns, conditions: Conditions) -> tuple[FloatArray, Slopes]:
        """Return the rise and ∂ by A and n."""
        A, _n = columns
        K, z = _scales(columns, conditions)
        grown = K * conditions.wrap_angle_rad
        by_log_K = grown / (1.0 + z)
        by_q = by_log_K * _log_lever(conditions) + grown**2 * log1prel_slope(z)
        return grown * log1prel(z), (by_log_K / A, -by_q)

    def condition_slopes(self, columns: Columns, conditions: Conditions) -> Slopes:
        """Return ∂ ln F_A by R_w, φ and ln F_B."""
        K, z = _scales(columns, conditions)
        local = K / (1.0 + z)
        by_radius = (1.0 - columns[1]) * local * conditions.wrap_angle_rad / conditions.centreline_radius_m
        return by_radius, local, 1.0 / (1.0 + z)

    def refusals(self, columns: Columns, conditions: Conditions) -> Iterable[Refusal]:
        """Yield where A is not positive or the tension would grow beyond all bounds."""
        A, n = columns
        yield Refusal(A <= 0.0, A, "A is {value}; friction needs it positive", "give a positive A")
        _K, z = _scales((np.maximum(A, 1e-300), n), conditions)
        yield Refusal(z <= -1.0, z, "for n > 1 the tension is infinite before the wrap ends:"
                     " (1 - n) A (R/F_B)^(1-n) phi = {value} <= -1", "use n <= 1")  # fmt: skip


def _log_lever(conditions: Conditions) -> FloatArray:
    """Return ln(R/F_B) in SI units."""
    return np.log(conditions.centreline_radius_m) - conditions.log_end_tension


def _scales(columns: Columns, conditions: Conditions) -> tuple[FloatArray, FloatArray]:
    """Return K and z."""
    A, n = columns
    K = A * np.exp((1.0 - n) * _log_lever(conditions))
    return K, (1.0 - n) * K * conditions.wrap_angle_rad


def _candidates(mu: float, conditions: Conditions, log_lift: FloatArray) -> FloatArray:
    n = np.array([0.5, 0.7, 0.85, 0.95, 1.0])
    tension = 0.5 * (log_lift + conditions.log_end_tension)
    lever = float(np.mean(np.log(conditions.centreline_radius_m) - tension))
    return np.column_stack([mu * np.exp((n - 1.0) * lever), n])


def _by_hand(sheet: Sheet) -> float:
    if sheet["n"] == 1.0:
        return sheet.line("mu phi", "A * phi")
    sheet.line("q", "1 - n")
    sheet.line("R", "R_w + R_r")
    sheet.line("K", "A * exp(q * (ln(R) - y))")
    return sheet.line("ln(F_A/F_B)", "ln(1 + q * K * phi)/q")


LAW = FrictionLaw(
    name="howell",
    equation="F_A^(1-n) = F_B^(1-n) + (1 - n) A R^(1-n) phi, R = R_w + R_r; local mu = A (R/T)^(1-n)",
    source="Howell 1953, friction per length f = A N^n",
    parameters=(
        Parameter("A", "(N/m)^(1-n)", 0.5, 1e-6, 1e5, "friction per length at a contact force of 1 N/m"),
        Parameter("n", "-", 0.9, 0.0, 1.0, "exponent of the contact force per length; 1 is Euler's equation"),
    ),
    coefficient="local",
    effects=frozenset({"size", "wrap-dependence", "end-tension"}),
    weakens=True,
    physics=Howell(),
    candidates=_candidates,
    special_cases=(CONSTANT,),
    arithmetic=_by_hand,
)
