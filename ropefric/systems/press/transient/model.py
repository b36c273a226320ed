"""A press with elastic belts as arrays: stiffness and damping of the spans, masses at the rims, what is at rest."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

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
from ropefric.systems.press.transient.polynomial import FloatArray

__all__ = ["ElasticPress", "elastic_press", "standstill_tension_N"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ElasticPress:
    """A press ready to be moved. Rollers are described at their rims: s = Rθ [m], mass J/R² [kg], load M/R [N].

    Attributes
    ----------
    press : Press
        The machine.
    ingredients : Ingredients
        What was put in.
    incidence : ndarray, shape (n_rollers, n_spans)
        D: D T is the belts' net pull on each rim; spans are stretched by e = −Dᵀ s − Pᵀ ξ.
    pull : ndarray, shape (n_tensioners, n_spans)
        P: pull on each tensioner along its travel.
    stiffness_N_m, damping_N_s_m : ndarray, shape (n_spans,)
        k = Σ EA/L and Σ η EA/L over the belts of each span.
    density_kg_m : ndarray, shape (n_spans,)
        Mass per length of all belts of each span; zero where the centrifugal force is left out.
    preload_N : ndarray, shape (n_spans,)
        Tension T_0 at e = 0, with the tensioners at their travel at rest.
    roller_mass_kg, arc_mass_kg, load_N : ndarray, shape (n_rollers,)
        J/R², ρA R α of all belts on the roller (zero if left out), and M/R.
    driven : ndarray of int, shape (n_driven,)
        Rollers that obey a torque balance; the others are drivers.
    drivers : ndarray of int, shape (n_drivers,)
        The drivers; the first is the reference of all relative angles.
    overspeed : ndarray, shape (n_drivers,)
        Surface speed of each driver against the drive's speed, less one.
    tensioner_mass_kg, tensioner_damping_N_s_m, spring_N_m : ndarray, shape (n_tensioners,)
        m, C1 and k1.
    """

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

    Raises
    ------
    InputError
        If the tensioners do not settle the tension of every belt, or one would be slack.

    Examples
    --------
    >>> from ropefric.systems.press.machine import Belt, Roller, Tensioner
    >>> drive = Roller(name="drive", radius_m=0.1, wrap_angle_rad=3.0, role="driver")
    >>> load = Roller(name="load", radius_m=0.1, wrap_angle_rad=3.0, role="tensioner",
    ...     tensioner=Tensioner(spring_N_m=0.0, travel_m=0.0, force_N=1000.0))
    >>> belt = Belt(name="belt", loop=("drive", "load"), linear_density_kg_m=1, thickness_m=0.005, width_m=1)
    >>> standstill_tension_N(Press(rollers=(drive, load), belts=(belt,), speed_m_s=1.0)).tolist()
    [500.0, 500.0]
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
    """Return a press with elastic belts as arrays.

    Parameters
    ----------
    press : Press
        The machine; belts need EA and span lengths, rollers J, tensioners m.
    ingredients : Ingredients, optional
        What to put in; everything by default.
    preload_N : array_like, shape (n_spans,), optional
        Tensions at rest [N]; by default those of an unloaded standstill. Travels count from the place that balances
        them.

    Raises
    ------
    InputError
        If data is missing (every missing key is named), or the preload has not one positive tension for each span.
    """
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
