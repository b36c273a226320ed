"""What is known of a rope on a wheel, and its mechanics: one exponential, with what does not press set apart."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, SolverError
from ropefric.systems.checks import Rule, refuse_out_of_scale, side_by_side
from ropefric.systems.effect import Model
from ropefric.systems.friction import WrapFriction

GRAVITY_M_S2 = 9.80665
"""Standard acceleration of gravity [m/s2]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HoistProblem:
    """A rope on a wheel, n cases side by side; scalars are spread."""

    friction: WrapFriction
    wheel_radius_m: FloatArray
    rope_radius_m: FloatArray
    wrap_angle_rad: FloatArray
    end_tension_N: FloatArray
    speed_m_s: FloatArray | None = None
    linear_density_kg_m: FloatArray | None = None
    hanging_length_m: FloatArray | None = None
    bending_stiffness_N_m2: FloatArray | None = None
    payload_kg: FloatArray | None = None

    def __post_init__(self) -> None:
        for name, array in side_by_side({name: getattr(self, name) for name in _RULES}, _RULES).items():
            refuse_out_of_scale(name, array, may_vanish=name not in _DIVIDES)
            object.__setattr__(self, name, array)

    @property
    def n(self) -> int:
        """Return how many cases there are."""
        return self.wheel_radius_m.size

    @property
    def circling_N(self) -> FloatArray:
        """Return c = ρv² [N]; zero where the scene does not give it."""
        if self.linear_density_kg_m is None or self.speed_m_s is None:
            return np.zeros(self.n)
        return self.linear_density_kg_m * self.speed_m_s**2

    @property
    def bending_N(self) -> FloatArray:
        """Return E = EI/(2R²) at the centreline's R = R_w + R_r [N]; zero where the scene does not give it."""
        if self.bending_stiffness_N_m2 is None:
            return np.zeros(self.n)
        return self.bending_stiffness_N_m2 / (2.0 * (self.wheel_radius_m + self.rope_radius_m) ** 2)

    @property
    def weight_N(self) -> FloatArray:
        """Return the weight ρgh of the hanging rope [N]; zero where the scene does not give it."""
        if self.linear_density_kg_m is None or self.hanging_length_m is None:
            return np.zeros(self.n)
        return self.linear_density_kg_m * GRAVITY_M_S2 * self.hanging_length_m


_DIVIDES = {"wheel_radius_m", "rope_radius_m", "end_tension_N"}
_RULES: dict[str, Rule] = {
    **dict.fromkeys(("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N"), "positive"),
    "speed_m_s": "any",
    **dict.fromkeys(("linear_density_kg_m", "hanging_length_m", "bending_stiffness_N_m2"), "zero or more"),
    "payload_kg": "positive",
}


_LARGEST = float(np.log(np.finfo(np.float64).max))
_MAX_STEPS = 400


TOLD = {"wrap-dependence": "wrap", "end-tension": "end-tension", "size": "size"}
"""What of a contact each of the law's own effects tells it."""


class HoistModel(Model[HoistProblem]):
    """A rope on a wheel with the effects that are in it; without any F_A = F_B e^{μφ}, light, limp and at rest.

    A tension F presses the rope onto the wheel only by F − c − E: c = ρv² keeps its mass on the circle, and
    E = EI/(2R²) keeps it bent. What presses grows as P_A = P_B e^M over the arc that is in contact.
    """

    @cached_property
    def end_tension_N(self) -> FloatArray:
        """Return F_B with the weight of the rope that hangs from it [N]."""
        end_N = self.problem.end_tension_N
        return end_N + self.problem.weight_N if "rope-weight" in self.effects else end_N

    @cached_property
    def circling_N(self) -> FloatArray:
        """Return c [N]."""
        return self.problem.circling_N if "centrifugal" in self.effects else np.zeros(self.problem.n)

    @cached_property
    def bending_N(self) -> FloatArray:
        """Return E [N]."""
        return self.problem.bending_N if "bending-stiffness" in self.effects else np.zeros(self.problem.n)

    def exponent(self, contact_rad: FloatArray, pressing_N: FloatArray) -> FloatArray:
        """Return M over the arc in contact, as the law sees it."""
        return self.problem.friction.exponent(
            wheel_radius_m=self.problem.wheel_radius_m,
            rope_radius_m=self.problem.rope_radius_m,
            wrap_angle_rad=contact_rad,
            slack_tension_N=pressing_N,
            told=frozenset(TOLD[name] for name in self.effects & TOLD.keys()),
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Lift:
    """What a rope on a wheel lifts."""

    log_lift: FloatArray
    exponent: FloatArray
    contact_rad: FloatArray
    end_tension_N: FloatArray

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


def lifted_arc_rad(bending_N: FloatArray | float, bent_by_N: FloatArray | float) -> FloatArray:
    """Return the arc arccos(1 − E/F) by which a stiff rope leaves the wheel early at one end [rad]."""
    # arccos(1 - e) loses the digits of a small e.
    return 2.0 * np.arcsin(np.sqrt(0.5 * np.asarray(bending_N) / bent_by_N))


def solve_lift(model: HoistModel) -> Lift:
    """Return the lift force of a model, F_A = c + E + (F_B − c − E) e^M, eq. (17) with (1)'s inertia."""
    idle_N = model.circling_N + model.bending_N
    # In this order, because their sum would round away a small E beside a large c.
    pressing_N = (model.end_tension_N - model.circling_N) - model.bending_N
    _refuse_floating(model, pressing_N)
    contact = _contact_arc(model, pressing_N) if model.bending_N.any() else model.problem.wrap_angle_rad
    exponent = model.exponent(contact, pressing_N)
    log_lift = np.log(pressing_N) + exponent
    if idle_N.any():
        with np.errstate(divide="ignore"):
            log_lift = np.logaddexp(np.log(idle_N), log_lift)
    return Lift(log_lift=log_lift, exponent=exponent, contact_rad=contact, end_tension_N=model.end_tension_N)


def _refuse_floating(model: HoistModel, pressing_N: FloatArray) -> None:
    circling_N, bending_N = model.circling_N, model.bending_N
    floating = model.end_tension_N <= circling_N
    if floating.any():
        first = int(np.argmax(floating))
        raise InputError(
            f"rho v^2 = {circling_N[first]:.6g} N is not below the end tension of "
            f"{model.end_tension_N[first]:.6g} N: the rope lifts off the wheel",
            code="RF510",
            key="speed_m_s",
            fix="raise the end tension or lower the speed",
        )
    if (pressing_N <= 0.0).any():
        first = int(np.argmax(pressing_N <= 0.0))
        pulling_N = model.end_tension_N[first] - circling_N[first]
        raise InputError(
            f"EI/(2 R^2) = {bending_N[first]:.6g} N is not below the {pulling_N:.6g} N that pull the rope round the "
            "wheel: it is too stiff to follow it",
            code="RF510",
            key="bending_stiffness_N_m2",
            fix="raise the end tension or the wheel radius",
        )


def _contact_arc(model: HoistModel, pressing_N: FloatArray) -> FloatArray:
    """Return φ − θ_A − θ_B; θ_A falls with the lift force that it helps to set, so it is iterated from above."""
    slack = lifted_arc_rad(model.bending_N, pressing_N + model.bending_N)
    wrap_rad = model.problem.wrap_angle_rad
    contact = wrap_rad - 2.0 * slack
    if (contact < 0.0).any():
        first = int(np.argmax(contact < 0.0))
        raise InputError(
            f"a wrap of {wrap_rad[first]:.6g} rad is less than the {2.0 * slack[first]:.6g} rad by which "
            "this stiff rope stands off the wheel: it never touches",
            code="RF510",
            key="wrap_angle_rad",
            fix="raise the wrap or the end tension",
        )
    for _ in range(_MAX_STEPS):
        # ln F_A may exceed what a float holds; the ratio E/F_A then is zero to every digit.
        growth = np.exp(-model.exponent(contact, pressing_N))
        tight = lifted_arc_rad(model.bending_N * growth, pressing_N + model.bending_N * growth)
        longer = wrap_rad - slack - tight
        if (np.abs(longer - contact) <= 1e-14 * wrap_rad).all():
            return longer
        contact = longer
    raise SolverError(
        "the arc over which this stiff rope stands off the wheel does not settle: the friction is too high for the "
        "lifted arc to have one solution",
        code="RF500",
        fix="lower the coefficient or leave out bending-stiffness",
    )
