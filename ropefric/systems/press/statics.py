"""The steady equations (23)-(34) solved once: tensions as a linear map of preloads, loads and speed squared.

The balances of a press, assembled from its graph: matrices that every steady and transient solution shares.

With the incidence matrix D (+1 where a span leaves a roller, −1 where it arrives) and the pull matrix P of the
tensioners the equations (10)-(22) are, for all rollers and tensioners at once,

    J θ̈ = diag(R) D T − M,        m ẍ + C1 ẋ + k1 x = P T' − F,        T' = T − v² w,

with w the mass per length of all belts of a span; the drivers' rows of the first give the torque their motors must
supply. By virtual work the same matrices give what a span is stretched by: e = −Dᵀ (R θ) − Pᵀ x.

Examples
--------
>>> from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
>>> drive = Roller(name="drive", radius_m=0.1, wrap_angle_rad=3.0, role="driver")
>>> load = Roller(name="load", radius_m=0.2, wrap_angle_rad=3.0, role="tensioner", gravity_torque_N_m=5.0,
...     tensioner=Tensioner(spring_N_m=0.0, travel_m=0.0, force_N=1000.0))
>>> belt = Belt(name="belt", loop=("drive", "load"), linear_density_kg_m=15, thickness_m=0.005, width_m=1)
>>> press = Press(rollers=(drive, load), belts=(belt,), speed_m_s=1.0)
>>> spans_out_of(press).tolist(), spans_into(press).tolist()
([[1.0, 0.0], [0.0, 1.0]], [[0.0, 1.0], [1.0, 0.0]])
>>> incidence(press).tolist(), pull_matrix(press).tolist(), carried_belts(press).tolist()
([[1.0, -1.0], [-1.0, 1.0]], [[1.0, 1.0]], [[1.0, 1.0]])
>>> radii_m(press).tolist(), load_torques_N_m(press).tolist(), has_balance(press).tolist()
([0.1, 0.2], [0.0, 5.0], [False, True])
>>> span_density_kg_m(press).tolist()
[15.0, 15.0]
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.systems.press.closures import CLOSURES, Closure
from ropefric.systems.press.machine import Press


def spans_into(press: Press) -> FloatArray:
    """Return 1 where a span arrives at a roller, else 0; shape (n_rollers, n_spans)."""
    return np.array([[float(span.end == roller.name) for span in press.spans] for roller in press.rollers])


def spans_out_of(press: Press) -> FloatArray:
    """Return 1 where a span leaves a roller, else 0; shape (n_rollers, n_spans)."""
    return np.array([[float(span.start == roller.name) for span in press.spans] for roller in press.rollers])


def incidence(press: Press) -> FloatArray:
    """Return D, shape (n_rollers, n_spans): D T is the net pull of the belts on each roller's rim [N]."""
    return spans_out_of(press) - spans_into(press)


def pull_matrix(press: Press) -> FloatArray:
    """Return P, shape (n_tensioners, n_spans): P T' is the belts' pull along each travel, eqs. (21), (22) [N]."""
    which = [roller.tensioner is not None for roller in press.rollers]
    arriving = np.array([[math.cos(part.upstream_angle_rad)] for part in press.take_ups])
    leaving = np.array([[math.cos(part.downstream_angle_rad)] for part in press.take_ups])
    return (
        arriving.reshape(-1, 1) * spans_into(press)[which]
        + leaving.reshape(-1, 1) * spans_out_of(press)[which]
    )


def carried_belts(press: Press) -> FloatArray:
    """Return 1 where a belt runs in a span, else 0; shape (n_belts, n_spans)."""
    return np.array([[float(belt.name in span.belts) for span in press.spans] for belt in press.belts])


def span_density_kg_m(press: Press) -> FloatArray:
    """Return w, shape (n_spans,): mass per length of all belts in each span [kg/m]; v² w is their ρAv²."""
    return np.array([belt.linear_density_kg_m for belt in press.belts]) @ carried_belts(press)


def radii_m(press: Press) -> FloatArray:
    """Return R, shape (n_rollers,) [m]."""
    return np.array([roller.radius_m for roller in press.rollers])


def load_torques_N_m(press: Press) -> FloatArray:
    """Return M = M_G + M_F, shape (n_rollers,) [N m]."""
    return np.array([roller.torque_N_m for roller in press.rollers])


def has_balance(press: Press) -> BoolArray:
    """Return which rollers obey a torque balance, shape (n_rollers,): all but the drivers."""
    return np.array([roller.role != "driver" for roller in press.rollers])


# The entries are cosines and ones, so singular values are of order one or zero by rounding.
_TINY = 1e-9


def matrix_rank(matrix: FloatArray) -> int:
    """Return the rank of a matrix of balances."""
    return int(np.linalg.matrix_rank(matrix, tol=_TINY)) if matrix.size else 0


def free_motions(matrix: FloatArray) -> FloatArray:
    """Return a sparse basis of the null space, shape (deficiency, n): what no row of the matrix sees.

    The basis is in reduced echelon form: each vector begins with a 1 where all others are 0.
    """
    rank = matrix_rank(matrix)
    basis = np.linalg.svd(matrix)[2][rank:].copy()
    row = 0
    for column in range(basis.shape[1]):
        if row == len(basis):
            break
        pivot = row + int(np.argmax(np.abs(basis[row:, column])))
        if abs(basis[pivot, column]) < _TINY:
            continue
        basis[[row, pivot]] = basis[[pivot, row]]
        basis[row] /= basis[row, column]
        others = np.arange(len(basis)) != row
        basis[others] -= np.outer(basis[others, column], basis[row])
        row += 1
    basis[np.abs(basis) < _TINY] = 0.0
    return basis


def in_words(motion: FloatArray, names: Sequence[str]) -> str:
    """Return a combination of tensions as words."""
    parts = [(name, value) for name, value in zip(names, motion, strict=True) if value != 0.0]
    if all(abs(abs(value) - 1.0) < _TINY for _, value in parts):
        rising = ", ".join(f"T{name}" for name, value in parts if value > 0.0)
        falling = ", ".join(f"T{name}" for name, value in parts if value < 0.0)
        if falling:
            return f"{rising} may rise while {falling} falls as much"
        return f"{rising} may rise together"
    return "may change together: " + ", ".join(f"{value:+.4g} T{name}" for name, value in parts)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Statics:
    """What sets the tensions of a press at rest, one share each.

    At rest T = given + load_factor · by_load + by_preload @ F.
    """

    press: Press
    closure: str
    rank: int
    undetermined: tuple[str, ...]
    given_N: FloatArray
    by_load_N: FloatArray
    by_preload: FloatArray


def solve_statics(press: Press, *, closure: str = "share") -> Statics:
    """Return the linear solution of the steady equations, eqs. (23)-(34)."""
    named = CLOSURES[closure]
    spans = [span.name for span in press.spans]
    balances = np.vstack([incidence(press)[has_balance(press)], pull_matrix(press)])
    rank = matrix_rank(balances)
    _refuse_contradiction(press, balances, rank)
    right = _right_hand_side(press, len(balances))
    words = tuple(in_words(motion, spans) for motion in free_motions(balances))
    if words:
        rows, values_N = named.equations(press)
        _refuse_other_than_open(named, balances, rows, spans, words)
        balances = np.vstack([balances, rows])
        right = np.vstack([right, np.pad(values_N[:, None], ((0, 0), (0, right.shape[1] - 1)))])
    shares: FloatArray = np.asarray(np.linalg.solve(balances, right), dtype=np.float64)
    return Statics(
        press=press,
        closure=named.name if words else "",
        rank=rank,
        undetermined=words,
        given_N=shares[:, 0],
        by_load_N=shares[:, 1],
        by_preload=shares[:, 2:],
    )


def _right_hand_side(press: Press, n_equations: int) -> FloatArray:
    """Return what stands against the balances, a column each: springs, loads, one newton of each preload."""
    loads_N = (load_torques_N_m(press) / radii_m(press))[has_balance(press)]
    right = np.zeros((n_equations, 2 + len(press.take_ups)))
    right[: len(loads_N), 1] = loads_N
    right[len(loads_N) :, 0] = [part.spring_N_m * part.travel_m for part in press.take_ups]
    right[len(loads_N) :, 2:] = np.eye(len(press.take_ups))
    return right


def _refuse_contradiction(press: Press, balances: FloatArray, rank: int) -> None:
    if rank == len(balances):
        return
    names = [f"torque of roller {roller.name}" for roller in press.rollers if roller.role != "driver"]
    names += [f"travel of tensioner {roller.name}" for roller in press.tensioners]
    tied = [
        name
        for name, weights in zip(names, free_motions(balances.T).T, strict=True)
        if np.abs(weights).max() > 0.0
    ]
    raise InputError(
        f"these balances repeat each other, so that their loads would have to agree by chance: {', '.join(tied)}",
        code="RF522",
        fix="keep one tensioner a belt (let the other roller be driven), and give every machine a driver",
    )


def _refuse_other_than_open(
    closure: Closure, balances: FloatArray, rows: FloatArray, spans: list[str], words: tuple[str, ...]
) -> None:
    closed = np.vstack([balances, rows])
    rank = matrix_rank(closed)
    if rank < len(spans):
        left = "; ".join(in_words(motion, spans) for motion in free_motions(closed))
        raise InputError(
            f"the balances leave {len(words)} thing(s) open and the closure '{closure.name}' does not settle: {left}",
            code="RF522",
            fix="give every belt a tensioner, or choose another closure",
        )
    if len(rows) > len(words):
        raise InputError(
            f"the closure '{closure.name}' makes {len(rows)} statements where {len(words)} are open: "
            + "; ".join(words),
            code="RF522",
            fix="choose another closure",
        )
