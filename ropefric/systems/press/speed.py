"""What speed does to the tensions: tensioners that keep their place, and tensioners that give way."""

from typing import Literal

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError, Problem, UnknownNameError
from ropefric.systems.press.equations import carried_belts, pull_matrix, span_density_kg_m
from ropefric.systems.press.machine import Press
from ropefric.systems.press.statics import Statics

__all__ = ["loop_lengths_m", "speed_shift_kg_m"]

FloatArray = npt.NDArray[np.float64]


def loop_lengths_m(press: Press) -> FloatArray:
    """Return the length of every belt, free spans and arcs, shape (n_belts,) [m].

    Raises
    ------
    InputError
        If a belt does not give its span lengths.
    """
    missing = [f"belts.{belt.name}.span_lengths_m" for belt in press.belts if belt.span_lengths_m is None]
    _refuse_missing(missing)
    arcs_m = {roller.name: roller.radius_m * roller.wrap_angle_rad for roller in press.rollers}
    return np.array(
        [sum(belt.span_lengths_m or ()) + sum(arcs_m[name] for name in belt.loop) for belt in press.belts]
    )


def speed_shift_kg_m(statics: Statics, tensioner: Literal["locked", "elastic"]) -> FloatArray:
    """Return dT'/d(v²) of every span, shape (n_spans,) [kg/m]: T' = T'(0) + v² times this.

    A running belt needs ρAv² to keep its path. If the tensioners keep their place its length cannot change, T stays
    and T' falls by all of it: the limit of a stiff spring. In general the level z_b of T' in belt b follows from the
    belt's length and the springs' balance,

        (L/EA)_b (z_b + ρA_b v²) = −Σ_j G_jb dx_j,      k_j dx_j = Σ_b G_jb z_b,

    with G the pull of one newton in each belt along each travel: for one tensioner dT' = −ρAv²/(1 + s),
    s = (cos + cos)² k_b/k1, k_b = EA/L. A spring of no stiffness keeps T'.

    Parameters
    ----------
    statics : Statics
        The press, solved once.
    tensioner : {"locked", "elastic"}
        Which of the two.

    Raises
    ------
    InputError
        If "elastic" is asked for and a belt lacks EA or its span lengths; every missing key is named.
    UnknownNameError
        For anything but these two.
    """
    press = statics.press
    locked = -span_density_kg_m(press)
    if tensioner == "locked":
        return locked
    if tensioner != "elastic":
        raise UnknownNameError(
            f"tensioner = '{tensioner}' is unknown", key="tensioner", fix="locked or elastic"
        )
    stiffness = [belt.axial_stiffness_N for belt in press.belts]
    missing = [
        f"belts.{belt.name}.axial_stiffness_N" for belt in press.belts if belt.axial_stiffness_N is None
    ]
    missing += [f"belts.{belt.name}.span_lengths_m" for belt in press.belts if belt.span_lengths_m is None]
    _refuse_missing(missing)
    give = np.diag(loop_lengths_m(press) / np.array(stiffness, dtype=np.float64))
    density = np.array([belt.linear_density_kg_m for belt in press.belts])
    pull = pull_matrix(press) @ carried_belts(press).T
    springs = np.diag([part.tensioner.spring_N_m for part in press.tensioners if part.tensioner is not None])
    # One system in z and dx, so that a spring of no stiffness needs no division by zero.
    system = np.block([[give, pull.T], [pull, -springs]])
    right = np.concatenate([-give @ density, np.zeros(len(springs))])
    level = np.linalg.solve(system, right)[: len(density)]
    return np.asarray(locked + statics.by_preload @ (pull @ (level + density)))


def _refuse_missing(keys: list[str]) -> None:
    if keys:
        raise InputError(
            f"the elastic tensioner needs {', '.join(keys)}",
            code="RF521",
            key=keys[0],
            fix="give them, or take tensioner='locked'",
            problems=[
                Problem(code="RF521", key=key, message=f"the elastic tensioner needs {key}") for key in keys
            ],
        )
