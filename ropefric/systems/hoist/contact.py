"""A rope on a wheel, and its mechanics: one exponential, with the tension that does not press taken apart."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError, SolverError
from ropefric.friction.condition import Conditions
from ropefric.friction.laws.bending import bending_N, lifted_arc_rad
from ropefric.systems.checks import AnyNumber, Cases, Positive, ZeroOrMore, lean, refuse
from ropefric.systems.effect import Model
from ropefric.systems.friction import WrapFriction, own_regressors

GRAVITY_M_S2 = 9.80665
"""Standard acceleration of gravity [m/s2]."""

_LARGEST = float(np.log(np.finfo(np.float64).max))
_MAX_STEPS = 400


@dataclass(frozen=True, kw_only=True, eq=False)
class HoistProblem(Cases):
    """A rope on a wheel, n cases side by side."""

    friction: WrapFriction
    wheel_radius_m: Positive
    rope_radius_m: Positive
    wrap_angle_rad: Positive
    end_tension_N: Positive
    speed_m_s: AnyNumber | None = None
    linear_density_kg_m: ZeroOrMore | None = None
    hanging_length_m: ZeroOrMore | None = None
    bending_stiffness_N_m2: ZeroOrMore | None = None
    payload_kg: Positive | None = None

    @property
    def circling_N(self) -> FloatArray:
        """Return c = ρv² [N]; zero where the scene does not give it."""
        return self.product("linear_density_kg_m", "speed_m_s", "speed_m_s")

    @property
    def bending_N(self) -> FloatArray:
        """Return E = EI/(2R²) at the centreline's R = R_w + R_r [N]; zero where the scene does not give it."""
        radius_m = lean(self.wheel_radius_m) + lean(self.rope_radius_m)
        return np.broadcast_to(bending_N(lean(self.product("bending_stiffness_N_m2")), radius_m), (self.n,))

    @property
    def weight_N(self) -> FloatArray:
        """Return the weight ρgh of the hanging rope [N]; zero where the scene does not give it."""
        return GRAVITY_M_S2 * self.product("linear_density_kg_m", "hanging_length_m")


HoistModel = Model[HoistProblem]
"""A rope on a wheel with the effects that are in it; without any F_A = F_B e^{μφ}, light, limp and at rest."""


class Lift(NamedTuple):
    """The lift force of a rope on a wheel."""

    model: HoistModel
    log_lift: FloatArray
    exponent: FloatArray
    contact_rad: FloatArray
    end_tension_N: FloatArray

    @property
    def logs(self) -> FloatArray:
        """Return the logarithms of all numbers, shape (4, n)."""
        with np.errstate(divide="ignore"):
            return np.stack([self.log_lift, *np.log((self.average_mu, self.contact_rad, self.end_tension_N))])

    @property
    def lift_force_N(self) -> FloatArray:
        """Return F_A [N], shape (n,)."""
        beyond = self.log_lift > _LARGEST
        if beyond.any():
            raise InputError(
                f"ln F_A = {self.log_lift[beyond][0]:.6g}: a force above e^{_LARGEST:.1f} N is no number",
                code="RF420",
                fix="use fewer turns; in Python, log_lift stays finite",
            )
        return np.exp(self.log_lift)

    @property
    def average_mu(self) -> FloatArray:
        """Return the average coefficient over the arc in contact, shape (n,); 0 where nothing touches."""
        touching = self.contact_rad > 0.0
        return np.divide(self.exponent, self.contact_rad, out=np.zeros_like(self.exponent), where=touching)


def solve_lift(model: HoistModel) -> Lift:
    """Return the lift force of a model, F_A = c + E + (F_B − c − E) e^M, eq. (17) with (1)'s inertia.

    A tension F presses the rope onto the wheel only by F − c − E: c = ρv² keeps its mass on the circle, and
    E = EI/(2R²) keeps it bent. What presses grows as P_A = P_B e^M over the arc that is in contact.
    """
    problem = model.problem
    end_N = problem.end_tension_N + model.part("rope-weight", problem.weight_N)
    circling_N = model.part("centrifugal", problem.circling_N)
    stiff_N = model.part("bending-stiffness", problem.bending_N)
    # In this order, because their sum would round away a small E beside a large c.
    pressing_N = (end_N - circling_N) - stiff_N
    refuse(
        end_N <= circling_N,
        "rho v^2 = {circling_N:.6g} N is not below the end tension of {end_N:.6g} N: the rope lifts off the wheel",
        code="RF510",
        key="speed_m_s",
        fix="raise the end tension or lower the speed",
        circling_N=circling_N,
        end_N=end_N,
    )
    refuse(
        pressing_N <= 0.0,
        "EI/(2 R^2) = {stiff_N:.6g} N is not below the {pulling_N:.6g} N that pull the rope round the wheel: it is too "
        "stiff to follow it",
        code="RF510",
        key="bending_stiffness_N_m2",
        fix="raise the end tension or the wheel radius",
        stiff_N=stiff_N,
        pulling_N=end_N - circling_N,
    )
    exponent_over = partial(
        problem.friction.exponent,
        problem.wheel_radius_m,
        problem.rope_radius_m,
        slack_tension_N=pressing_N,
        regressors=own_regressors(model.effects),
    )
    contact, idle_N = problem.wrap_angle_rad, circling_N + stiff_N
    if stiff_N.any():
        contact = contact_arc_rad(contact, stiff_N, pressing_N, exponent_over)
    exponent = exponent_over(wrap_angle_rad=contact)
    log_lift = np.log(pressing_N) + exponent
    if idle_N.any():
        with np.errstate(divide="ignore"):
            log_lift = np.logaddexp(np.log(idle_N), log_lift)
    return Lift(model, log_lift, exponent, contact, end_N)


def contact_arc_rad(
    wrap_rad: FloatArray,
    stiff_N: FloatArray,
    pressing_N: FloatArray,
    exponent_over: Callable[..., FloatArray],
) -> FloatArray:
    """Return φ − θ_A − θ_B; θ_A falls with the lift force that it helps to set, so it is iterated from above."""
    slack = lifted_arc_rad(stiff_N / (pressing_N + stiff_N))
    contact = wrap_rad - 2.0 * slack
    refuse(
        contact < 0.0,
        "a wrap of {wrap_rad:.6g} rad is less than the {lifted_rad:.6g} rad by which this stiff rope lifts off the "
        "wheel: it never touches",
        code="RF510",
        key="wrap_angle_rad",
        fix="raise the wrap or the end tension",
        wrap_rad=wrap_rad,
        lifted_rad=2.0 * slack,
    )
    for _ in range(_MAX_STEPS):
        # ln F_A may exceed what a float holds; the ratio E/F_A then is zero to every digit.
        left_N = stiff_N * np.exp(-exponent_over(wrap_angle_rad=contact))
        longer = wrap_rad - slack - lifted_arc_rad(left_N / (pressing_N + left_N))
        if (np.abs(longer - contact) <= 1e-14 * wrap_rad).all():
            return longer
        contact = longer
    raise SolverError(
        "the arc over which this stiff rope lifts off the wheel has no solution: the friction is too high for the "
        "lifted arc to have one solution",
        code="RF500",
        fix="lower the coefficient or leave out bending-stiffness",
    )


def answerable(problem: HoistProblem) -> BoolArray:
    """Return for which of n cases there is an answer with all effects in, shape (n,).

    The rope has to press on the wheel and touch it, and the law to have an answer to what presses.
    """
    pressing_N = problem.end_tension_N - problem.circling_N - problem.bending_N
    possible = pressing_N > 0.0
    share = problem.bending_N / np.where(possible, pressing_N + problem.bending_N, np.inf)
    possible &= problem.wrap_angle_rad > 2.0 * lifted_arc_rad(share)
    if "end-tension" not in problem.friction.law.effects and problem.friction.theta.ndim == 1:
        return possible
    names = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad")
    contacts = {name: getattr(problem, name) for name in names}
    contacts["end_tension_N"] = np.where(possible, pressing_N, 1.0)
    return possible & problem.friction.has_answer(Conditions(**contacts))
