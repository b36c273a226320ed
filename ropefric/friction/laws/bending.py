"""Bending rigidity: part of the tension only holds the rope round the wheel, and the rope leaves it early."""

import math
from collections.abc import Iterable

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction import law
from ropefric.friction.condition import Conditions
from ropefric.friction.laws.uniform import CONSTANT

_MAX_STEPS = 100


class Bending:
    """The physics of (F_A − E) = (F_B − E) e^{μ φ_c}, E = EI/(2R²), R = R_w + R_r.

    The contact arc φ_c is the wrap shortened at each end by θ(F) = arccos(1 − E/F), at the tight end with F_A
    itself. So the rise h = ln(F_A/F_B) is the root of

    h + ln((1 − e_A)/(1 − e_B)) + μ (θ_A + θ_B − φ) = 0,   e_B = E/F_B, e_A = e_B e^{−h}.
    """

    def rise(self, columns: law.Columns, conditions: Conditions) -> FloatArray:
        """Return h."""
        mu, e = columns[0], _ratio(columns, conditions)
        return _solve(mu, e, conditions.wrap_angle_rad)

    def rise_and_slopes(self, columns: law.Columns, conditions: Conditions) -> tuple[FloatArray, law.Slopes]:
        """Return h and ∂ by μ and EI; the latter grows as 1/√EI towards EI = 0, where it is refused."""
        h = self.rise(columns, conditions)
        contact, by_log_E, _by_tension, slope = _partials(columns, conditions, h)
        return h, (contact / slope, by_log_E / slope / columns[1])

    def condition_slopes(self, columns: law.Columns, conditions: Conditions) -> law.Slopes:
        """Return ∂ ln F_A by R_w, φ and ln F_B."""
        h = self.rise(columns, conditions)
        _contact, by_log_E, by_tension, slope = _partials(columns, conditions, h)
        by_radius = -2.0 * by_log_E / slope / conditions.centreline_radius_m
        return by_radius, columns[0] / slope, by_tension / slope

    def refusals(self, columns: law.Columns, conditions: Conditions) -> Iterable[law.Refusal]:
        """Yield where the tension cannot bend the rope round the wheel, or the rope never touches it."""
        mu, rigidity = columns
        yield law.negative(mu, "the coefficient is {value}, negative")
        yield law.Refusal(mu > 3.0, mu, "the coefficient is {value}; above 3 the lifted arc has several solutions",
                     "keep it at 3 or below")  # fmt: skip
        yield law.negative(rigidity, "the bending rigidity is {value} N m2, negative", "give it positive")
        e = _ratio(columns, conditions)
        yield law.Refusal(e >= 1.0, e * conditions.end_tension_N, "EI/(2 R^2) = {value} N is not below F_B: the end"
                     " tension cannot bend the rope round the wheel", "raise F_B or the wheel radius")  # fmt: skip
        need = 2.0 * lifted_arc_rad(np.minimum(e, 1.0))
        yield law.Refusal((conditions.wrap_angle_rad < need) & (e < 1.0), need,
                     "the rope is too stiff to touch the wheel: it needs a wrap above {value} rad",
                     "raise the wrap or the end tension")  # fmt: skip


def _ratio(columns: law.Columns, conditions: Conditions) -> FloatArray:
    """Return e_B = EI/(2 R² F_B)."""
    return bending_N(columns[1], conditions.centreline_radius_m) / conditions.end_tension_N


def bending_N(rigidity_N_m2: FloatArray, centreline_radius_m: FloatArray) -> FloatArray:
    """Return E = EI/(2 R²), the part of the tension that keeps a stiff rope bent [N]."""
    return rigidity_N_m2 / (2.0 * centreline_radius_m**2)


def lifted_arc_rad(e: FloatArray) -> FloatArray:
    """Return θ = arccos(1 − e), e = E/F, by which a stiff rope leaves the wheel early; exact for small e, too."""
    return 2.0 * np.arcsin(np.sqrt(0.5 * e))


def _lifted_slope(e: FloatArray) -> FloatArray:
    """Return dθ/d ln e."""
    return np.sqrt(e / (2.0 - e))


def _solve(mu: FloatArray, e: FloatArray, phi: FloatArray) -> FloatArray:
    lifted = lifted_arc_rad(e)
    low = np.zeros(np.broadcast_shapes(mu.shape, e.shape, phi.shape))
    h = high = low + mu * np.maximum(phi - lifted, 0.0)
    for _ in range(_MAX_STEPS):
        tight = e * np.exp(-h)
        value = h + np.log1p(-e * np.expm1(-h) / (1.0 - e)) + mu * (lifted_arc_rad(tight) + lifted - phi)
        low, high = np.where(value < 0.0, h, low), np.where(value < 0.0, high, h)
        new = h - value / (1.0 / (1.0 - tight) - mu * _lifted_slope(tight))
        # A Newton step that leaves the bracket is replaced by halving it.
        new = np.where((new < low) | (new > high), 0.5 * (low + high), new)
        moved = np.abs(new - h) > 1e-15 * h
        h = new
        if not moved.any():
            break
    return h


def _partials(
    columns: law.Columns, conditions: Conditions, h: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return φ_c, −∂f/∂ln E, −∂f/∂ln F_B and ∂f/∂h of the equation f = 0 at its root h."""
    mu, e = columns[0], _ratio(columns, conditions)
    tight = e * np.exp(-h)
    contact = conditions.wrap_angle_rad - lifted_arc_rad(tight) - lifted_arc_rad(e)
    s_A, s_B = _lifted_slope(tight), _lifted_slope(e)
    gain_A, gain_B = 1.0 / (1.0 - tight), 1.0 / (1.0 - e)
    by_log_E = (tight * gain_A - e * gain_B) - mu * (s_A + s_B)
    return contact, by_log_E, gain_B + mu * s_B, gain_A - mu * s_A


def _candidates(mu: float, conditions: Conditions, _log_lift: FloatArray) -> FloatArray:
    # The weakest pull over the smallest wheel limits what any law may assume of the rope.
    limit = float((2.0 * conditions.centreline_radius_m**2 * conditions.end_tension_N).min())
    return law.combinations(mu * np.array([1.0, 1.3]), limit * np.array([1e-4, 1e-2, 0.1, 0.4]))


def _by_hand(sheet: law.Sheet) -> float:
    """Write the equation for F_A with its solution put in: there is no closed form, but the check is by hand."""
    sheet.line("F_B [N]", "exp(y)", "F_B")
    sheet.line("R", "R_w + R_r")
    sheet.line("E", "rigidity_N_m2/(2 * R^2)")
    e = np.array(sheet["E"] / sheet["F_B"])
    rise = float(_solve(np.array(sheet["mu"]), e, np.array(sheet["phi"])))
    sheet.given("F", sheet["F_B"] * math.exp(rise), "F, the lift force that solves the law [N]")
    sheet.line("theta_A", "acos(1 - E/F)")
    sheet.line("theta_B", "acos(1 - E/F_B)")
    sheet.line("phi_c", "phi - theta_A - theta_B")
    sheet.line("F from the law", "E + (F_B - E) * exp(mu * phi_c)", "F")
    return sheet.line("ln(F/F_B)", "ln(F/F_B)")


LAW = law.FrictionLaw(
    name="bending",
    equation="F_A - E = (F_B - E) exp(mu phi_c), E = EI/(2 R^2), R = R_w + R_r; "
    "phi_c = phi - arccos(1 - E/F_A) - arccos(1 - E/F_B)",
    source="after Stuart 1961, Br. J. Appl. Phys. 12:559",
    parameters=(
        law.Parameter("mu", "-", 0.2, 0.0, 3.0, "friction coefficient"),
        law.Parameter("rigidity_N_m2", "N m2", 1e-4, 1e-9, 10.0,
                  "bending rigidity EI of the rope; every F_B must exceed EI/(2 (R_w + R_r)^2)"),
    ),
    coefficient="local",
    effects=frozenset({"size", "end-tension", "bending-stiffness"}),
    physics=Bending(),
    candidates=_candidates,
    special_cases=(CONSTANT,),
    arithmetic=_by_hand,
)  # fmt: skip
