"""A lift on its traction sheave: the tensions of its load cases, the friction of its grooves, and what would do."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.systems.checks import Cases, Positive, ZeroOrMore, refuse
from ropefric.systems.effect import Model
from ropefric.systems.friction import WrapFriction, refuse_no_ratio, regressors_of
from ropefric.systems.roots import roots_of_cases

GRAVITY_M_S2 = 9.81
CASES = ("loading", "braking-up", "braking-down", "stalled")
"""In the first three the ropes must hold; stalled they must slip."""
GROOVES = ("semicircular", "undercut", "v", "v-hardened")
_BRAKING, _STALLED = slice(1, 3), slice(3, 4)
_OVERLOAD = 1.25
_MU_LOADING, _MU_STALLED = 0.1, 0.2
_SPEED_SCALE_M_S = 10.0
"""Of mu = 0.1/(1 + v/10)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TractionProblem(Cases):
    """A lift and its sheave, n cases side by side. Without friction the standard's holds."""

    friction: WrapFriction | None = None
    groove: str = "undercut"
    car_kg: Positive
    rated_load_kg: Positive
    counterweight_kg: Positive
    travel_m: ZeroOrMore
    wheel_radius_m: Positive
    wrap_angle_rad: Positive
    groove_angle_rad: Positive
    rope_radius_m: Positive
    rope_count: Positive
    undercut_rad: ZeroOrMore = field(default_factory=lambda: np.zeros(1))
    above_car_m: ZeroOrMore = field(default_factory=lambda: np.zeros(1))
    above_counterweight_m: ZeroOrMore = field(default_factory=lambda: np.zeros(1))
    linear_density_kg_m: ZeroOrMore | None = None
    speed_m_s: ZeroOrMore | None = None
    deceleration_m_s2: ZeroOrMore | None = None
    car_pulley_kg: ZeroOrMore | None = None
    counterweight_pulley_kg: ZeroOrMore | None = None

    def __post_init__(self) -> None:
        Cases.__post_init__(self)
        for name, low in (("groove_angle_rad", 1e-3), ("undercut_rad", -1.0)):
            angle = getattr(self, name)
            wrong = (angle <= low) | (angle >= np.pi)
            refuse(wrong, f"{name} is {{angle:g}}, no angle of a groove", key=name, angle=angle)
        refuse(
            self.is_round & (self.undercut_rad >= np.pi - self.groove_angle_rad),
            "the undercut and the groove angle together are 180 deg or more: nothing is left to carry the rope",
            key="undercut_rad",
            fix="make the undercut smaller; the standard ends at 106 deg",
        )

    @property
    def is_round(self) -> bool:
        """Return whether the groove is semicircular, undercut or not."""
        return self.groove in {"semicircular", "undercut"}


TractionModel = Model[TractionProblem]
"""A lift with the effects that are simulated."""


class TractionAnswer(NamedTuple):
    """Tensions and friction in the four load cases, arrays of shape (4, n).

    Attributes
    ----------
    tight_N, slack_N : ndarray
        T1 and T2 [N].
    mu : ndarray
        Coefficient of rope on sheave [-].
    friction_factor : ndarray
        f, the coefficient with what the groove makes of it [-].
    log_capacity : ndarray
        f α, the logarithm of the ratio that friction holds.
    utilisation : ndarray
        T1/T2 over e^(f α), stalled the other way round; above 1 the case is not passed.
    wrap_limit_rad, undercut_limit_rad : ndarray
        The wrap and the undercut at which the utilisation is 1, all else as it is; a lower limit, stalled an upper one.
        NaN where there is none.
    """

    tight_N: FloatArray
    slack_N: FloatArray
    mu: FloatArray
    friction_factor: FloatArray
    log_capacity: FloatArray
    utilisation: FloatArray
    wrap_limit_rad: FloatArray
    undercut_limit_rad: FloatArray

    @property
    def needed_wrap_rad(self) -> FloatArray:
        """Return the smallest wrap that passes loading and braking, shape (n,)."""
        return np.asarray(self.wrap_limit_rad[:3].max(axis=0))

    @property
    def needed_undercut_rad(self) -> FloatArray:
        """Return the smallest undercut that passes loading and braking, shape (n,); NaN where none does."""
        return np.asarray(self.undercut_limit_rad[:3].max(axis=0))

    @property
    def logs(self) -> FloatArray:
        """Return the logarithms of all numbers, shape (k, 4, n)."""
        numbers = (self.tight_N, self.slack_N, self.friction_factor, self.utilisation)
        with np.errstate(divide="ignore"):
            return np.stack(
                [self.log_capacity, *np.log((*numbers, self.wrap_limit_rad, self.undercut_limit_rad))]
            )


def round_factor(groove_angle_rad: FloatArray, undercut_rad: FloatArray) -> FloatArray:
    """Return f/μ of a semicircular groove, undercut by β or not: 4(cos γ/2 − sin β/2)/(π − β − γ − sin β + sin γ)."""
    gamma, beta = groove_angle_rad, undercut_rad
    bed = np.pi - beta - gamma - np.sin(beta) + np.sin(gamma)
    return np.asarray(4.0 * (np.cos(0.5 * gamma) - np.sin(0.5 * beta)) / bed)


def wedge_factor(groove_angle_rad: FloatArray) -> FloatArray:
    """Return f/μ of a rope wedged into a V groove: 1/sin(γ/2)."""
    return np.asarray(1.0 / np.sin(0.5 * groove_angle_rad))


def groove_factors(problem: TractionProblem) -> FloatArray:
    """Return f/μ in the four load cases, shape (4, n); a V groove that is not hardened wears, but not while stalled."""
    gamma, beta = problem.groove_angle_rad, problem.undercut_rad
    if problem.is_round:
        return np.stack([round_factor(gamma, beta)] * 4)
    hard = wedge_factor(gamma)
    if problem.groove == "v-hardened":
        return np.stack([hard] * 4)
    worn = round_factor(np.zeros_like(gamma), beta)
    return np.stack([worn, worn, worn, hard])


def solve_traction(model: TractionModel) -> TractionAnswer:
    """Return T1/T2 against e^(f α) in the four load cases."""
    problem, alpha = model.problem, model.problem.wrap_angle_rad
    car_N, counterweight_N = tensions_N(model)
    tight_N, slack_N = np.maximum(car_N, counterweight_N), np.minimum(car_N, counterweight_N)
    # Stalled, the counterweight's side is the slack one, however much rope hangs there.
    tight_N[_STALLED], slack_N[_STALLED] = car_N[_STALLED], counterweight_N[_STALLED]
    mu, factors = _coefficients(model, tight_N, slack_N), groove_factors(problem)
    friction_factor = mu * factors
    refuse_no_ratio(friction_factor * alpha)
    with np.errstate(divide="ignore"):
        log_ratio = np.log(tight_N / slack_N)
    utilisation = np.exp(log_ratio - friction_factor * alpha)
    utilisation[_STALLED] = np.exp(friction_factor[_STALLED] * alpha - log_ratio[_STALLED])
    # Stalled, the rope on the slack side can outweigh the car: no wrap lets the ropes slip then.
    with np.errstate(divide="ignore", invalid="ignore"):  # without friction no wrap is enough
        wrap_limit = np.where(log_ratio >= 0.0, log_ratio / friction_factor, np.nan)
        undercut_limit = _undercut_rad(problem, log_ratio / (mu * alpha))
    loads, grips = (tight_N, slack_N), (mu, friction_factor, friction_factor * alpha, utilisation)
    return TractionAnswer(*loads, *grips, wrap_limit, undercut_limit)


def tensions_N(model: TractionModel) -> tuple[FloatArray, FloatArray]:
    """Return the tensions on the car's and on the counterweight's side in the four load cases, shape (4, n) each."""
    problem = model.problem
    rope_kg_m = problem.rope_count * model.part("rope-weight", problem.linear_density_kg_m)
    a = model.part("deceleration", problem.deceleration_m_s2)
    pulleys_N = [
        a * model.part("pulley-inertia", one)
        for one in (problem.car_pulley_kg, problem.counterweight_pulley_kg)
    ]
    short_kg, long_kg = (
        [rope_kg_m * (above + over) for above in (problem.above_car_m, problem.above_counterweight_m)]
        for over in (0.0, problem.travel_m)
    )
    g = GRAVITY_M_S2
    car, load, counterweight = problem.car_kg, problem.rated_load_kg, problem.counterweight_kg
    car_N = np.stack(
        [
            (car + _OVERLOAD * load + long_kg[0]) * g,
            (car + short_kg[0]) * (g - a) - pulleys_N[0],
            (car + load + long_kg[0]) * (g + a) + pulleys_N[0],
            (car + short_kg[0]) * g,
        ]
    )
    counterweight_N = np.stack(
        [
            (counterweight + short_kg[1]) * g,
            (counterweight + long_kg[1]) * (g + a) + pulleys_N[1],
            (counterweight + short_kg[1]) * (g - a) - pulleys_N[1],
            long_kg[1] * g,
        ]
    )
    refuse(
        np.any(np.minimum(car_N, counterweight_N)[_BRAKING] <= 0.0, axis=0),
        "a deceleration this hard leaves a side of the ropes without tension",
        code="RF510",
        key="deceleration_m_s2",
        fix="lower the deceleration, or check its unit",
    )
    return car_N, counterweight_N


def _coefficients(model: TractionModel, tight_N: FloatArray, slack_N: FloatArray) -> FloatArray:
    """Return μ in the four load cases, shape (4, n); of the standard, or of a law for one of the ropes."""
    problem, friction = model.problem, model.problem.friction
    if friction is None:
        mu = np.full_like(tight_N, _MU_LOADING)
        mu[_STALLED] = _MU_STALLED
    else:
        # Where nothing pulls on the slack side, what pulls on the tight side presses.
        pressing_N = np.where(slack_N > 0.0, slack_N, tight_N) / problem.rope_count
        contact = (problem.wheel_radius_m, problem.rope_radius_m, problem.wrap_angle_rad, pressing_N)
        mu = friction.exponent(*contact, regressors=regressors_of(model.effects)) / problem.wrap_angle_rad
    mu[_BRAKING] /= 1.0 + model.part("speed", problem.speed_m_s) / _SPEED_SCALE_M_S
    return mu


def _undercut_rad(problem: TractionProblem, factor: FloatArray) -> FloatArray:
    """Return the undercut whose f/μ is `factor`, shape (4, n); NaN where none from 0 to 180° − γ has it.

    It is 0 where ropes that must hold do so without any.
    """
    if not problem.is_round:
        return np.full_like(factor, np.nan)
    gamma = problem.groove_angle_rad
    plain = round_factor(gamma, np.zeros_like(gamma))
    possible = (factor >= plain) & (factor < wedge_factor(gamma))
    undercut = np.where(factor < plain, 0.0, np.nan)
    undercut[_STALLED] = np.nan
    gamma, factor = np.broadcast_to(gamma, factor.shape)[possible], factor[possible]
    # Where the wedge begins nothing is left of the bed to divide by.
    largest = (1.0 - 1e-12) * (np.pi - gamma)
    undercut[possible] = roots_of_cases(
        lambda beta: round_factor(gamma, beta) - factor, np.zeros_like(gamma), largest
    )
    return undercut


def answerable(problem: TractionProblem) -> BoolArray:
    """Return for which of n cases no side of the ropes loses its tension, shape (n,)."""
    a = problem.product("deceleration_m_s2")
    sides = (("car_kg", "car_pulley_kg"), ("counterweight_kg", "counterweight_pulley_kg"))
    held = [
        getattr(problem, mass) * (GRAVITY_M_S2 - a) > a * problem.product(pulley) for mass, pulley in sides
    ]
    return np.asarray(held[0] & held[1])
