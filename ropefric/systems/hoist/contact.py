"""The mechanics of a rope on a wheel: one exponential, with what does not press set apart from what does."""

from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, SolverError
from ropefric.systems.friction import WrapFriction

_LARGEST = float(np.log(np.finfo(np.float64).max))
_MAX_STEPS = 400


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HoistModel:
    """A rope on a wheel as assembled from its effects.

    A tension F presses the rope onto the wheel only by F − c − E: c = ρv² keeps its mass on the circle, and
    E = EI/(2R²) keeps it bent. What presses grows as P_A = P_B e^M over the arc that is in contact.
    """

    friction: WrapFriction
    told: frozenset[str]
    wheel_radius_m: FloatArray
    rope_radius_m: FloatArray
    wrap_angle_rad: FloatArray
    end_tension_N: FloatArray
    circling_N: FloatArray | float = 0.0
    bending_N: FloatArray | float = 0.0


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
    idle_N = np.asarray(model.circling_N + model.bending_N)
    # In this order, because their sum would round away a small E beside a large c.
    pressing_N = np.asarray((model.end_tension_N - model.circling_N) - model.bending_N)
    _refuse_floating(model, pressing_N)
    contact = _contact_arc(model, pressing_N) if np.any(model.bending_N) else model.wrap_angle_rad
    exponent = _exponent(model, contact, pressing_N)
    log_lift = np.log(pressing_N) + exponent
    if np.any(idle_N):
        with np.errstate(divide="ignore"):
            log_lift = np.logaddexp(np.log(idle_N), log_lift)
    return Lift(
        log_lift=log_lift,
        exponent=exponent,
        contact_rad=contact,
        end_tension_N=np.asarray(model.end_tension_N),
    )


def _exponent(model: HoistModel, contact_rad: FloatArray, pressing_N: FloatArray) -> FloatArray:
    return model.friction.exponent(
        wheel_radius_m=model.wheel_radius_m,
        rope_radius_m=model.rope_radius_m,
        wrap_angle_rad=contact_rad,
        slack_tension_N=pressing_N,
        told=model.told,
    )


def _refuse_floating(model: HoistModel, pressing_N: FloatArray) -> None:
    circling_N = np.broadcast_to(model.circling_N, pressing_N.shape)
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
        bending_N = np.broadcast_to(model.bending_N, pressing_N.shape)
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
    contact = model.wrap_angle_rad - 2.0 * slack
    if (contact < 0.0).any():
        first = int(np.argmax(contact < 0.0))
        raise InputError(
            f"a wrap of {model.wrap_angle_rad[first]:.6g} rad is less than the {2.0 * slack[first]:.6g} rad by which "
            "this stiff rope stands off the wheel: it never touches",
            code="RF510",
            key="wrap_angle_rad",
            fix="raise the wrap or the end tension",
        )
    for _ in range(_MAX_STEPS):
        # ln F_A may exceed what a float holds; the ratio E/F_A then is zero to every digit.
        growth = np.exp(-_exponent(model, contact, pressing_N))
        tight = lifted_arc_rad(model.bending_N * growth, pressing_N + model.bending_N * growth)
        longer = model.wrap_angle_rad - slack - tight
        if (np.abs(longer - contact) <= 1e-14 * model.wrap_angle_rad).all():
            return longer
        contact = longer
    raise SolverError(
        "the arc over which this stiff rope stands off the wheel does not settle: the friction is too high for the "
        "lifted arc to have one solution",
        code="RF500",
        fix="lower the coefficient or leave out bending-stiffness",
    )
