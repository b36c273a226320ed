"""A press with elastic belts as arrays: stiffness and damping of the spans, masses at the rims, what is at rest."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, Problem
from ropefric.systems.press.machine import Press
from ropefric.systems.press.statics import (
    carried_belts,
    has_balance,
    incidence,
    load_torques_N_m,
    pull_matrix,
    radii_m,
    span_density_kg_m,
)
from ropefric.systems.press.transient.ingredients import Ingredients


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ElasticPress:
    """A press ready to be moved. Rollers are described at their rims: s = Rθ [m], mass J/R² [kg], load M/R [N]."""

    press: Press
    ingredients: Ingredients
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


def standstill_tension_N(press: Press) -> FloatArray:
    """Return the tensions of a press that stands still and unloaded, shape (n_spans,) [N].

    Without torques each belt has one tension all around, and the tensioners' balance k1 x + F = P T says which.
    """
    belts_in = carried_belts(press)
    by_belt = pull_matrix(press) @ belts_in.T
    held = [part.tensioner for part in press.tensioners if part.tensioner is not None]
    force_N = np.array([part.spring_N_m * part.travel_m + part.force_N for part in held])
    if np.linalg.matrix_rank(by_belt) < len(press.belts) or len(held) > len(press.belts):
        raise InputError(
            f"{len(held)} tensioners do not settle the standstill tensions of {len(press.belts)} belts",
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
    press: Press,
    *,
    ingredients: Ingredients | None = None,
    preload_N: npt.ArrayLike | None = None,
) -> ElasticPress:
    """Return a press with elastic belts as arrays."""
    parts = Ingredients() if ingredients is None else ingredients
    _refuse_missing(press)
    preload = standstill_tension_N(press) if preload_N is None else np.array(preload_N, dtype=np.float64)
    if preload.shape != (len(press.spans),) or not (np.isfinite(preload) & (preload > 0.0)).all():
        raise InputError(
            f"the preload needs one positive tension for each of {len(press.spans)} spans", key="preload_N"
        )
    stiffness, damping = _spans(press)
    radius = radii_m(press)
    tensioners = [part.tensioner for part in press.tensioners if part.tensioner is not None]
    balanced = has_balance(press)
    drivers = np.flatnonzero(~balanced)
    arcs = [
        sum(belt.linear_density_kg_m for belt in press.belts if roller.name in belt.loop)
        * roller.radius_m
        * roller.wrap_angle_rad
        for roller in press.rollers
    ]
    return ElasticPress(
        press=press,
        ingredients=parts,
        incidence=incidence(press),
        pull=pull_matrix(press),
        stiffness_N_m=stiffness,
        damping_N_s_m=damping * parts.belt_damping,
        density_kg_m=span_density_kg_m(press) * parts.centrifugal,
        preload_N=preload,
        roller_mass_kg=np.array([roller.inertia_kg_m2 or 0.0 for roller in press.rollers]) / radius**2,
        arc_mass_kg=np.array(arcs) * parts.arc_inertia,
        load_N=load_torques_N_m(press) / radius,
        driven=np.flatnonzero(balanced),
        drivers=drivers,
        overspeed=np.array([press.rollers[i].overspeed or 0.0 for i in drivers]),
        tensioner_mass_kg=np.array([part.mass_kg or 0.0 for part in tensioners]),
        tensioner_damping_N_s_m=np.array([part.damping_N_s_m for part in tensioners])
        * parts.tensioner_damping,
        spring_N_m=np.array([part.spring_N_m for part in tensioners]),
    )


def _spans(press: Press) -> tuple[FloatArray, FloatArray]:
    index = {(span.start, span.end): i for i, span in enumerate(press.spans)}
    stiffness, damping = np.zeros(len(index)), np.zeros(len(index))
    for belt in press.belts:
        steps = zip(belt.loop, belt.loop[1:] + belt.loop[:1], strict=True)
        for step, length_m in zip(steps, belt.span_lengths_m or (), strict=True):
            own = (belt.axial_stiffness_N or 0.0) / length_m
            stiffness[index[step]] += own
            damping[index[step]] += own * belt.damping_s
    return stiffness, damping


def _refuse_missing(press: Press) -> None:
    keys = [f"belts.{belt.name}.axial_stiffness_N" for belt in press.belts if belt.axial_stiffness_N is None]
    keys += [f"belts.{belt.name}.span_lengths_m" for belt in press.belts if belt.span_lengths_m is None]
    keys += [
        f"rollers.{part.name}.inertia_kg_m2"
        for part in press.rollers
        if part.inertia_kg_m2 is None and part.role != "driver"
    ]
    keys += [
        f"rollers.{part.name}.tensioner.mass_kg"
        for part in press.tensioners
        if part.tensioner is not None and part.tensioner.mass_kg is None
    ]
    if keys:
        raise InputError(
            f"a start-up needs {', '.join(keys)}",
            code="RF521",
            key=keys[0],
            fix="give them",
            problems=[Problem(code="RF521", key=key, message=f"a start-up needs {key}") for key in keys],
        )
