"""A press with elastic belts as arrays: stiffness and damping of the spans, masses at the rims, what friction holds."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.machine import Press, missing_elasticity, missing_masses, refuse_missing
from ropefric.systems.press.slip import available_pull_N, contacts_of, grip_on
from ropefric.systems.press.statics import (
    carried_belts,
    has_balance,
    incidence,
    load_torques_N_m,
    pull_matrix,
    radii_m,
    span_density_kg_m,
)

MOVING = frozenset({"belt-inertia", "belt-damping", "tensioner-damping", "arc-inertia"})
"""What a start-up may contain beside elastic belts and turning rollers; what is left out is never computed."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ElasticPress:
    """A press ready to be moved. Rollers are described at their rims: s = Rθ [m], mass J/R² [kg], load M/R [N]."""

    press: Press
    incidence: FloatArray
    pull: FloatArray
    stiffness_N_m: FloatArray
    damping_N_s_m: FloatArray
    density_kg_m: FloatArray
    preload_N: FloatArray
    roller_mass_kg: FloatArray
    arc_mass_kg: FloatArray
    load_N: FloatArray
    driven: npt.NDArray[np.intp]
    drivers: npt.NDArray[np.intp]
    overspeed: FloatArray
    tensioner_mass_kg: FloatArray
    tensioner_damping_N_s_m: FloatArray
    spring_N_m: FloatArray

    @property
    def into(self) -> FloatArray:
        """Return 1 where a span arrives at a roller, shape (n_rollers, n_spans)."""
        return np.maximum(-self.incidence, 0.0)

    @property
    def out_of(self) -> FloatArray:
        """Return 1 where a span leaves a roller, shape (n_rollers, n_spans)."""
        return np.maximum(self.incidence, 0.0)


def standstill_tension_N(press: Press) -> FloatArray:
    """Return the tensions of a press that stands still and unloaded, shape (n_spans,) [N].

    Without torques each belt has one tension all around, and the tensioners' balance k1 x + F = P T says which.
    """
    belts_in = carried_belts(press)
    by_belt = pull_matrix(press) @ belts_in.T
    force_N = np.array([part.spring_N_m * part.travel_m + part.force_N for part in press.take_ups])
    if np.linalg.matrix_rank(by_belt) < len(press.belts) or len(force_N) > len(press.belts):
        raise InputError(
            f"{len(force_N)} tensioners do not settle the standstill tensions of {len(press.belts)} belts",
            code="RF521",
            key="preload_N",
            fix="give each belt one tensioner; in Python, give the tension of every span at rest (preload_N)",
        )
    level_N = np.linalg.solve(by_belt, force_N)
    if not (level_N > 0.0).all():
        slack = press.belts[int(np.argmin(level_N))].name
        raise InputError(
            f"belt '{slack}' is slack at rest: {level_N.min():.6g} N",
            code="RF523",
            fix="raise the tensioner's force or travel",
        )
    return np.asarray(level_N @ belts_in)


def elastic_press(
    press: Press, *, effects: Collection[str] = MOVING, preload_N: npt.ArrayLike | None = None
) -> ElasticPress:
    """Return a press with elastic belts as arrays."""
    refuse_missing("a start-up", [*missing_elasticity(press), *missing_masses(press)], fix="give them")
    preload = standstill_tension_N(press) if preload_N is None else np.array(preload_N, dtype=np.float64)
    if preload.shape != (len(press.spans),) or not (np.isfinite(preload) & (preload > 0.0)).all():
        raise InputError(
            f"the preload needs one positive tension for each of {len(press.spans)} spans", key="preload_N"
        )
    index = {(span.start, span.end): i for i, span in enumerate(press.spans)}
    stiffness, damping = np.zeros(len(index)), np.zeros(len(index))
    for belt in press.belts:
        for step, length_m in zip(belt.steps, belt.span_lengths_m or (), strict=True):
            own = (belt.axial_stiffness_N or 0.0) / length_m
            stiffness[index[step]] += own
            damping[index[step]] += own * belt.damping_s
    arcs = [
        sum(belt.linear_density_kg_m for belt in press.belts_on(roller))
        * roller.radius_m
        * roller.wrap_angle_rad
        for roller in press.rollers
    ]
    balanced, radius = has_balance(press), radii_m(press)
    drivers = np.flatnonzero(~balanced)
    return ElasticPress(
        press=press,
        incidence=incidence(press),
        pull=pull_matrix(press),
        stiffness_N_m=stiffness,
        damping_N_s_m=damping * ("belt-damping" in effects),
        density_kg_m=span_density_kg_m(press) * ("belt-inertia" in effects),
        preload_N=preload,
        roller_mass_kg=np.array([roller.inertia_kg_m2 or 0.0 for roller in press.rollers]) / radius**2,
        arc_mass_kg=np.array(arcs) * ("arc-inertia" in effects),
        load_N=load_torques_N_m(press) / radius,
        driven=np.flatnonzero(balanced),
        drivers=drivers,
        overspeed=np.array([press.rollers[i].overspeed or 0.0 for i in drivers]),
        tensioner_mass_kg=np.array([part.mass_kg or 0.0 for part in press.take_ups]),
        tensioner_damping_N_s_m=np.array([part.damping_N_s_m for part in press.take_ups])
        * ("tensioner-damping" in effects),
        spring_N_m=np.array([part.spring_N_m for part in press.take_ups]),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrictionLimit:
    """What gross slip on each roller is governed by: e^M, and κ, see `motion`; each (n_rollers,)."""

    growth: FloatArray
    share: FloatArray


_LEAST_GRIP = 1e-7
"""A thousand times what `exact.guards_of` takes for zero, as a share of the tension."""


def friction_limit(model: ElasticPress, friction: float | WrapFriction) -> FrictionLimit:
    """Return what gross slip on each roller is governed by."""
    press = model.press
    growth, share = np.empty(len(press.rollers)), np.empty(len(press.rollers))
    spin = 1.0 / radii_m(press)
    for i, contact in enumerate(contacts_of(press, model.preload_N, angular_acceleration_rad_s2=spin)):
        grip = grip_on(contact, friction)
        growth[i] = np.exp(grip.exponent)
        if growth[i] - 1.0 < _LEAST_GRIP:
            raise InputError(
                f"roller {press.rollers[i].name} holds the belt by e^(μφ) − 1 = {growth[i] - 1.0:.3g} of its tension:"
                f" a start-up with slip cannot tell less than {_LEAST_GRIP:g} from no friction at all",
                code="RF523",
                key="friction",
                fix="give a larger coefficient or wrap angle, or write slip = false",
            )
        still = float(contact.slack_N) * np.expm1(float(grip.exponent))
        # What the acceleration of 1 m/s² alone adds to the friction that can be borne.
        added = float(available_pull_N(contact, grip)) - still
        arc_N = float(contact.inertia_towards_tight_N) * contact.wrap_angle_rad
        share[i] = 1.0 / (1.0 + added / arc_N) if arc_N else float(grip.exponent) / (growth[i] - 1.0)
    return FrictionLimit(growth=growth, share=share)


def friction_utilisation(
    limit: FrictionLimit,
    *,
    friction_N: FloatArray,
    upstream_N: FloatArray,
    downstream_N: FloatArray,
    arc_force_N: FloatArray,
) -> FloatArray:
    """Return required over available friction of every roller, shape (..., n_rollers) [-].

    U = |F| / (T'_slack (e^M − 1) ± m b'' (1/κ − 1)): 0 without friction, 1 in gross slip, and without acceleration
    the utilisation of `ropefric.systems.press.slip`. Infinite where friction acts on a belt that has lifted off.
    """
    forward = friction_N >= 0.0
    slack_N = np.where(forward, upstream_N, downstream_N)
    towards_N = np.where(forward, arc_force_N, -arc_force_N)
    available_N = slack_N * (limit.growth - 1.0) + towards_N * (1.0 / limit.share - 1.0)
    required_N = np.abs(friction_N)
    ratio = np.where(required_N > 0.0, np.inf, 0.0)
    np.divide(required_N, available_N, out=ratio, where=available_N > 0.0)
    return ratio
