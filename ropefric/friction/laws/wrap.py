"""Laws of a coefficient that falls with the wrap: eqs. (14) to (17).

A local one as a power of the wrap angle, exponentially, and with the size, the end tension counted as wrap; and an
average one as a power of the wrap.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.special import exprel

from ropefric.arrays import FloatArray
from ropefric.friction import law
from ropefric.friction.condition import Conditions
from ropefric.friction.integral import PowerSpan, exponential_start_rad, exprel_slope, power_log_start
from ropefric.friction.law import Columns, FrictionLaw, Parameter, Refusal, Sheet, Slopes
from ropefric.friction.laws.uniform import (
    CONSTANT,
    MU_R,
    SIZE_EXPONENTIAL,
    ExponentialSize,
    Uniform,
    size_candidates,
)

# Below this φ0 is left out by hand: its power is ln F_B/(…) only, and a calculator shows zero.
_TINY_RAD = 1e-90


def exponent_parameter(name: str, start: float = -0.4) -> Parameter:
    """Return the exponent of φ as a parameter; its bounds stay clear of −1, where ∫ φ^k from 0 diverges."""
    return Parameter(name, "-", start, -0.999, 0.0, "exponent of the wrap angle in rad")


def plateau_parameter(name: str, *, lower: float = 0.0) -> Parameter:
    """Return the constant part of the local coefficient as a parameter."""
    return Parameter(name, "-", 0.05, lower, 5.0, "local coefficient after very many turns")


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerWrap:
    """The physics of μ(φ) = m φ^k + d integrated over [φ0, φ0 + φ], eq. (17).

    The last two parameters of the law are k and d; those before them make up m, the `mu` of its strength.
    """

    strength: Uniform
    equivalence: bool

    def rise(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return ∫ μ over the wrap."""
        m, _, d, phi, span = self._parts(columns, conditions)
        return m * span.integral() * (phi > 0.0) + d * phi

    def rise_and_slopes(self, columns: Columns, conditions: Conditions) -> tuple[FloatArray, Slopes]:
        """Return the rise and ∂ by each parameter: that of the wrap itself and that of the shift of φ0."""
        m, k, d, phi, span = self._parts(columns, conditions)
        some = phi > 0.0
        integral = span.integral()
        rise = m * integral * some + d * phi
        by_m, by_k, by_d = integral * some, m * span.slope() * some, phi + 0.0 * m
        if self.equivalence:
            u, s = span.log_start, span.s
            shift = -np.expm1(k * span.length) * _power_share(m, k, d, u) * some
            below = np.exp(s * u) / s
            by_m = by_m + shift * below
            by_k = by_k + shift * m * below * (u - 1.0 / s)
            by_d = by_d + shift * np.exp(u)
        return rise, (*(slope * by_m for slope in self.strength.mu_slopes(columns, conditions)), by_k, by_d)

    def condition_slopes(self, columns: Columns, conditions: Conditions) -> Slopes:
        """Return ∂ ln F_A by R_w, φ and ln F_B; the last is μ(φ0 + φ)/μ(φ0)."""
        m, k, d, phi, span = self._parts(columns, conditions)
        some = phi > 0.0
        by_m, by_tension = span.integral() * some, np.ones_like(phi + m)
        if self.equivalence:
            u = span.log_start
            share = _power_share(m, k, d, u)
            shift = -np.expm1(k * span.length) * share * some
            by_m = by_m + shift * np.exp(span.s * u) / span.s
            # Not 1 − shift, which loses its digits for F_B → F_0, where μ(φ0) is very large.
            by_tension = np.where(some, _plateau_share(m, k, d, u) + np.exp(k * span.length) * share, 1.0)
        with np.errstate(divide="ignore"):
            at = np.logaddexp(self._log_start(m, k, d, conditions), np.log(phi))
        return self.strength.mu_by_radius(columns, conditions) * by_m, _local(m, k, d, at), by_tension

    def refusals(self, columns: Columns, conditions: Conditions) -> Iterable[Refusal]:
        """Yield where ∫ μ has no value or μ is negative."""
        m, (k, d) = self.strength.mu(columns, conditions), columns[-2:]
        yield Refusal(k <= -1.0, k, "the exponent of φ is {value}, and ∫ φ^k from 0 diverges for k <= -1;"
                     " there is no such wrap", "keep the exponent above -1")  # fmt: skip
        yield law.negative(m, f"the coefficient of φ^k is {{value}}, negative: {self.strength.why_negative}",
                       "change the parameters, or leave out wheels this small")  # fmt: skip
        yield law.negative(d, "the constant part of μ is {value}, negative: μ turns negative at a large wrap")
        if self.equivalence:
            y = conditions.log_end_tension
            yield law.below_reference(conditions)
            yield Refusal((m + d <= 0.0) & (y > 0.0), m + 0.0 * y,
                         "μ is zero everywhere, so no wrap angle is equivalent to the end tension",
                         "give a positive coefficient")  # fmt: skip

    def _log_start(self, m: FloatArray, k: FloatArray, d: FloatArray, conditions: Conditions) -> FloatArray:
        if not self.equivalence:
            return np.array(-np.inf)
        return power_log_start(conditions.log_end_tension, m, k, d)

    def _parts(
        self, columns: Columns, conditions: Conditions
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, PowerSpan]:
        """Return m, k, d, the wrap and its span."""
        m, (k, d), phi = self.strength.mu(columns, conditions), columns[-2:], conditions.wrap_angle_rad
        start = self._log_start(m, k, d, conditions)
        return m, k, d, phi, PowerSpan(start, np.where(phi > 0.0, phi, 1.0), k)


def _local(m: FloatArray, k: FloatArray, d: FloatArray, log_angle: FloatArray) -> FloatArray:
    """Return m φ^k + d; infinite at φ = 0 for m > 0, k < 0."""
    with np.errstate(invalid="ignore", over="ignore"):
        power = m * np.exp(np.where(k == 0.0, 0.0, k * log_angle))
    return np.where(m > 0.0, power, 0.0) + d


def _power_share(m: FloatArray, k: FloatArray, d: FloatArray, u: FloatArray) -> FloatArray:
    """Return m p^k/(m p^k + d), the part of μ(p) that falls with the wrap."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        share = 1.0 / (1.0 + d / m * np.exp(-k * u))
    return np.where(m > 0.0, share, 0.0)


def _plateau_share(m: FloatArray, k: FloatArray, d: FloatArray, u: FloatArray) -> FloatArray:
    """Return d/(m p^k + d), the part of μ(p) that stays."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        share = np.where(d > 0.0, 1.0 / (1.0 + m / d * np.exp(k * u)), 0.0)
    return np.where(m > 0.0, share, 1.0)


class _First(Uniform):
    why_negative = "a must be zero or more"


def integral_by_hand(sheet: Sheet, formula: str, start_rad: float | None) -> float:
    """Write ∫μ over the wrap, counted from the start where there is one; the formula is that from zero to `{0}`."""

    def integral(name: str, to: str, symbol: str = "") -> float:
        return sheet.line(name, formula.format(to), symbol)

    if start_rad is None:
        return integral("integral of mu from 0", "phi")
    if start_rad < _TINY_RAD:
        sheet.say("phi_0 is too small for a calculator, so the integral up to it is ln F_B itself")
        integral("integral up to phi_0 + phi", "phi", "far")
        return sheet.line("integral of mu", "far - y")
    sheet.given("phi_0", start_rad, "phi_0 [rad]")
    integral("integral up to phi_0", "phi_0", "near")
    sheet.line("phi_0 + phi", "phi_0 + phi", "end")
    integral("integral up to phi_0 + phi", "end", "far")
    return sheet.line("integral of mu", "far - near")


def power_by_hand(sheet: Sheet, m: str, k: str, d: str) -> float:
    """Write ∫μ of m φ^k + d, whose symbols on the sheet are given."""
    sheet.line("s", f"1 + {k}")
    start_rad = None
    if "end-tension" in sheet.effects and sheet["y"] != 0.0:
        start_rad = float(np.exp(power_log_start(sheet["y"], sheet[m], sheet[k], sheet[d])))
        sheet.say("phi_0, the wrap equivalent to F_B, solves m/s phi_0^s + d phi_0 = ln F_B:")
    return integral_by_hand(sheet, f"{m}/s * {{0}}^s + {d} * {{0}}", start_rad)


WRAP_POWER = law.with_variant(
    FrictionLaw(
        name="wrap-power",
        equation="mu(phi) = a phi^b + c; F_A = F_B exp(integral of mu from phi0 to phi0 + phi)",
        source="PRTH friction and lift-force model, eqs. (15), (17)",
        parameters=(
            Parameter("a", "-", 0.2, 0.0, 5.0, "part of the local μ at 1 rad that falls with the wrap"),
            exponent_parameter("b"),
            plateau_parameter("c"),
        ),
        coefficient="local",
        effects=frozenset({"wrap-dependence", "end-tension"}),
        weakens=True,
        physics=PowerWrap(strength=_First(), equivalence=True),
        candidates=lambda mu, _at, _log_lift: law.combinations(
            mu * np.array([0.3, 1.0, 3.0]), [-0.9, -0.6, -0.3, -0.1], mu * np.array([0.05, 0.4, 0.8])
        ),
        special_cases=(CONSTANT,),
        arithmetic=lambda sheet: power_by_hand(sheet, "a", "b", "c"),
    )
)


class AverageWrap:
    """The physics of an average coefficient μ̄ = a φ^b over the wrap, whatever the end tension."""

    def rise(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return a φ^{1 + b}."""
        a, b = columns
        return a * conditions.wrap_angle_rad ** (1.0 + b)

    def rise_and_slopes(self, columns: Columns, conditions: Conditions) -> tuple[FloatArray, Slopes]:
        """Return the rise and ∂ by a and b."""
        phi, rise = conditions.wrap_angle_rad, self.rise(columns, conditions)
        power = phi ** (1.0 + columns[1])
        return rise, (power, rise * np.log(np.where(phi > 0.0, phi, 1.0)))

    def condition_slopes(self, columns: Columns, conditions: Conditions) -> Slopes:
        """Return ∂ ln F_A by R_w, φ and ln F_B."""
        a, b = columns
        return np.array(0.0), a * (1.0 + b) * conditions.wrap_angle_rad**b, np.array(1.0)

    def refusals(self, columns: Columns, _conditions: Conditions) -> Iterable[Refusal]:
        """Yield where the coefficient is negative, or the force does not grow with the wrap."""
        a, b = columns
        yield law.negative(a, "a is {value}, negative: friction cannot push the rope forward")
        yield Refusal(
            b <= -1.0, b, "b is {value}: at -1 and below more wrap lifts no more", "keep b above -1"
        )


WRAP_AVERAGE = FrictionLaw(
    name="wrap-average",
    equation="F_A = F_B exp(a phi^(1 + b)); average mu = a phi^b",
    source="eq. (2) with an average coefficient that is a power of the wrap",
    parameters=(
        Parameter("a", "-", 0.2, 0.0, 5.0, "average coefficient over a wrap of 1 rad"),
        exponent_parameter("b", start=-0.2),
    ),
    coefficient="average",
    effects=frozenset({"wrap-dependence"}),
    weakens=True,
    physics=AverageWrap(),
    candidates=lambda mu, _at, _log_lift: law.combinations(
        mu * np.array([1.0, 1.5, 2.5]), [-0.5, -0.2, -0.05, -0.01]
    ),
    special_cases=(CONSTANT,),
    arithmetic=lambda sheet: sheet.line("ln(F_A/F_B)", "a * phi^(1 + b)"),
)


def _coupled_by_hand(sheet: Sheet) -> float:
    sheet.line("r", "R_w/R_r")
    sheet.line("mu_R", MU_R)
    return power_by_hand(sheet, "mu_R", "c", "d")


COUPLED = law.with_variant(
    FrictionLaw(
        name="coupled",
        equation="mu(phi) = mu_R phi^c + d, mu_R = mu_inf (1 - exp(a R_w/R_r + b)); "
        "F_A = F_B exp(integral of mu from phi0 to phi0 + phi)",
        source="PRTH friction and lift-force model, eqs. (16), (17), in the bracket of eq. (4)",
        parameters=(*SIZE_EXPONENTIAL.parameters, exponent_parameter("c"), plateau_parameter("d")),
        coefficient="local",
        effects=frozenset({"size", "wrap-dependence", "end-tension"}),
        weakens=True,
        physics=PowerWrap(strength=ExponentialSize(), equivalence=True),
        candidates=lambda mu, conditions, _log_lift: law.combinations(
            mu * np.array([1.0, 2.0, 4.0]),
            *size_candidates(conditions),
            [-0.75, -0.4, -0.1],
            mu * np.array([0.1, 0.6]),
        ),
        special_cases=(CONSTANT, SIZE_EXPONENTIAL, WRAP_POWER),
        arithmetic=_coupled_by_hand,
    )
)


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
                         " gives it", f"give a positive c, or {law.FROM_ZERO}")  # fmt: skip

    def _start(self, columns: Columns, conditions: Conditions) -> FloatArray:
        if not self.equivalence:
            return np.array(0.0)
        return exponential_start_rad(conditions.log_end_tension, *columns)


def _exponential_by_hand(sheet: Sheet) -> float:
    start_rad = None
    if "end-tension" in sheet.effects and sheet["y"] > 0.0:
        start_rad = float(exponential_start_rad(sheet["y"], sheet["a"], sheet["b"], sheet["c"]))
        sheet.say("phi_0, the wrap equivalent to F_B, solves a/b (exp(b phi_0) - 1) + c phi_0 = ln F_B:")
    if sheet["b"] == 0.0:
        if start_rad is not None:
            sheet.given("phi_0", start_rad, "phi_0 [rad]")
        # A constant coefficient is the same wherever the wrap starts.
        return sheet.line("integral of mu", "(a + c) * phi")
    return integral_by_hand(sheet, "a/b * (exp(b * {0}) - 1) + c * {0}", start_rad)


WRAP_EXPONENTIAL = law.with_variant(
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
        candidates=lambda mu, conditions, _log_lift: law.combinations(
            mu * np.array([0.3, 1.0, 3.0]),
            np.array([-6.0, -2.0, -0.7, -0.2]) / (float(conditions.wrap_angle_rad.max()) or 1.0),
            mu * np.array([0.2, 0.6, 0.9]),
        ),
        special_cases=(CONSTANT,),
        arithmetic=_exponential_by_hand,
    )
)  # fmt: skip
