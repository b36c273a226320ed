"""Eq. (14): the local coefficient falls exponentially with the wrap angle."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.special import exprel

from ropefric.arrays import FloatArray
from ropefric.friction import law
from ropefric.friction.condition import Conditions
from ropefric.friction.integral import exponential_start_rad, exprel_slope
from ropefric.friction.law import FROM_ZERO, Columns, FrictionLaw, Parameter, Refusal, Sheet, Slopes
from ropefric.friction.laws.constant import LAW as CONSTANT
from ropefric.friction.laws.wrap_power import integral_by_hand, plateau_parameter


def exponential_rise(
    start_rad: FloatArray, wrap_rad: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray
) -> FloatArray:
    """Return ∫ (a e^{bφ} + c) dφ over [start, start + wrap]."""
    return (a * np.exp(b * start_rad) * exprel(b * wrap_rad) + c) * wrap_rad


def _rise_slopes(start_rad: FloatArray, wrap_rad: FloatArray, a: FloatArray, b: FloatArray) -> Slopes:
    """Return the derivative of that integral by a, b and c."""
    first, grown = np.exp(b * start_rad) * wrap_rad, exprel(b * wrap_rad)
    by_b = a * first * (start_rad * grown + wrap_rad * exprel_slope(b * wrap_rad))
    return first * grown, by_b, wrap_rad


@dataclass(frozen=True, slots=True, kw_only=True)
class ExponentialWrap:
    """The physics of μ(φ) = a e^{bφ} + c integrated over [φ0, φ0 + φ]."""

    equivalence: bool

    def rise(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return a e^{bφ0} φ exprel(bφ) + c φ."""
        return exponential_rise(self._start(columns, conditions), conditions.wrap_angle_rad, *columns)

    def rise_and_slopes(self, columns: Columns, conditions: Conditions) -> tuple[FloatArray, Slopes]:
        """Return the rise and ∂ by a, b, c: that of the wrap itself and that of the shift of φ0."""
        a, b, c = columns
        p, phi = self._start(columns, conditions), conditions.wrap_angle_rad
        slopes = _rise_slopes(p, phi, a, b)
        if self.equivalence:
            # Each slope of φ0 weighs 1 − μ(p + φ)/μ(p).
            falling = a * np.exp(b * p)
            local = falling + c
            share = np.where(local > 0.0, falling / np.where(local > 0.0, local, 1.0), 0.0)
            shift, before = -np.expm1(b * phi) * share, _rise_slopes(np.zeros_like(p), p, a, b)
            slopes = tuple(own + shift * start for own, start in zip(slopes, before, strict=True))
        return exponential_rise(p, phi, a, b, c), slopes

    def condition_slopes(self, columns: Columns, conditions: Conditions) -> Slopes:
        """Return ∂ ln F_A by R_w, φ and ln F_B; the last is μ(φ0 + φ)/μ(φ0)."""
        a, b, c = columns
        phi = conditions.wrap_angle_rad
        p = self._start(columns, conditions)
        before, after = a * np.exp(b * p) + c, a * np.exp(b * (p + phi)) + c
        if not self.equivalence:
            return np.array(0.0), after, np.array(1.0)
        # The quotient itself: 1 − shift has no digits left where nearly all of μ(φ0) is lost.
        return np.array(0.0), after, np.where(before > 0.0, after / np.where(before > 0.0, before, 1.0), 1.0)

    def refusals(self, columns: Columns, conditions: Conditions) -> Iterable[Refusal]:
        """Yield where φ0 does not exist or μ is negative."""
        a, b, c = columns
        yield law.negative(a, "a is {value}, negative: μ would rise with the wrap")
        what = "b is {value}, positive: μ would grow without limit"
        yield Refusal(b > 0.0, b, what, "keep it at zero or below")
        yield law.negative(c, "c is {value}, negative: μ turns negative at a large wrap")
        if self.equivalence:
            y = conditions.log_end_tension
            yield law.below_reference(conditions)
            yield Refusal((c == 0.0) & (y > 0.0) & (-b * y >= a), y + 0.0 * c,
                         "with c = 0 the integral of μ never reaches a/|b|, but ln F_B is {value}; no wrap angle"
                         " stands for it", f"give a positive c, or {FROM_ZERO}")  # fmt: skip

    def _start(self, columns: Columns, conditions: Conditions) -> FloatArray:
        if not self.equivalence:
            return np.array(0.0)
        return exponential_start_rad(conditions.log_end_tension, *columns)


def _candidates(mu: float, conditions: Conditions, _log_lift: FloatArray) -> FloatArray:
    turn = float(conditions.wrap_angle_rad.max()) or 1.0
    return law.combinations(
        mu * np.array([0.3, 1.0, 3.0]),
        np.array([-6.0, -2.0, -0.7, -0.2]) / turn,
        mu * np.array([0.2, 0.6, 0.9]),
    )


def _by_hand(sheet: Sheet) -> float:
    start_rad = None
    if "end-tension" in sheet.effects and sheet["y"] > 0.0:
        start_rad = float(exponential_start_rad(sheet["y"], sheet["a"], sheet["b"], sheet["c"]))
        sheet.say("phi_0, the wrap that F_B stands for, solves a/b (exp(b phi_0) - 1) + c phi_0 = ln F_B:")
    if sheet["b"] == 0.0:
        if start_rad is not None:
            sheet.given("phi_0", start_rad, "phi_0 [rad]")
        # A constant coefficient is the same wherever the wrap starts.
        return sheet.line("integral of mu", "(a + c) * phi")
    return integral_by_hand(sheet, "a/b * (exp(b * {0}) - 1) + c * {0}", start_rad)


LAW = law.with_variant(
    FrictionLaw(
        name="wrap-exponential",
        equation="mu(phi) = a exp(b phi) + c; F_A = F_B exp(integral of mu from phi0 to phi0 + phi)",
        source="PRTH friction and lift-force model, eqs. (14), (17)",
        parameters=(
            Parameter("a", "-", 0.1, 0.0, 5.0,
                      "part of the local μ at zero wrap that falls; with one load it is confounded with F_0"),
            Parameter("b", "1/rad", -0.2, -20.0, 0.0, "rate of the fall"),
            # A trace of a plateau, because with none at all the integral saturates and a large F_B has no φ0.
            plateau_parameter("c", lower=1e-6),
        ),
        coefficient="local",
        effects=frozenset({"wrap-dependence", "end-tension"}),
        weakens=True,
        physics=ExponentialWrap(equivalence=True),
        candidates=_candidates,
        special_cases=(CONSTANT,),
        arithmetic=_by_hand,
    )
)  # fmt: skip
