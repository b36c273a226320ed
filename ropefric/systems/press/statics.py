"""The steady equations (23)-(34) solved once: tensions as a linear map of preloads, loads and speed squared.

The balances of a press, assembled from its graph: matrices that every steady and transient solution shares.

With the incidence matrix D (+1 where a span leaves a roller, −1 where it arrives) and the pull matrix P of the
tensioners the equations (10)-(22) are, for all rollers and tensioners at once,

    J θ̈ = diag(R) D T − M,        m ẍ + C1 ẋ + k1 x = P T' − F,        T' = T − v² w,

with w the mass per length of all belts of a span; the drivers' rows of the first give the torque their motors must
supply. By virtual work the same matrices give what a span is stretched by: e = −Dᵀ (R θ) − Pᵀ x.

How belts share a pull that no balance divides is settled by a closure. Steady creep: in a steady run as much belt
passes every place, so its speed is v_b (1 + T/EA) with one v_b for each belt. It sticks to a roller where it arrives.
So at a driver V = v_b (1 + T_in/EA), and where two belts meet on one roller the same V stands for both. With v_b and
the speed of that roller eliminated, to first order in the strain,

    (T_d − T_m)_1 / EA_1 − (T_d − T_m)_2 / EA_2 = (V_1 − V_2)/v

for belts 1 and 2 that meet in the spans m and reach their drivers in the spans d; and for two drivers of one belt
(T_1 − T_2)/EA = (V_1 − V_2)/v.

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
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.registry import Registry
from ropefric.systems.press.machine import Press, Span, refuse_missing

Statement = tuple[dict[str, float], float]
"""One linear equation between tensions: the factor of each span's tension by the span's name, and their sum [N]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Closure:
    """A named assumption about the split.

    Attributes
    ----------
    name : str
        Its name in scenes.
    rule : str
        What it says of the tensions, as a formula.
    basis : str
        What the machine must be like for it to hold.
    statements : callable
        `statements(press)` returns its equations.
    """

    name: str
    rule: str
    basis: str
    statements: Callable[[Press], list[Statement]]

    def equations(self, press: Press) -> tuple[FloatArray, FloatArray]:
        """Return the statements as a matrix, shape (k, n_spans), and its right-hand side, shape (k,) [N]."""
        statements = self.statements(press)
        matrix = [[factors.get(span.name, 0.0) for span in press.spans] for factors, _ in statements]
        values = np.array([value_N for _, value_N in statements], dtype=np.float64)
        return np.array(matrix).reshape(len(values), len(press.spans)), values


def arriving(press: Press, roller: str, belt: str) -> str:
    """Return the name of the span in which a belt reaches a roller."""
    return next(span.name for span in press.spans if span.end == roller and belt in span.belts)


def _leaving(press: Press, roller: str, belt: str) -> str:
    """Return the name of the span in which a belt leaves a roller."""
    return next(span.name for span in press.spans if span.start == roller and belt in span.belts)


def _drivers(press: Press) -> dict[str, list[str]]:
    """Return the drivers in each belt's loop; a belt without one is dragged along by another."""
    drivers = {roller.name for roller in press.rollers if roller.role == "driver"}
    return {belt.name: [name for name in belt.loop if name in drivers] for belt in press.belts}


def _alone(press: Press, end: Callable[[Span], str]) -> list[tuple[str, str, str]]:
    """Return (roller, belt, next belt) wherever belts of one roller are alone in their spans at one end of these."""
    alone = {(end(span), span.belts) for span in press.spans}
    return [
        (roller.name, first, second)
        for roller in press.rollers
        for first, second in pairwise(
            belt.name for belt in press.belts if (roller.name, (belt.name,)) in alone
        )
    ]


def meetings(press: Press) -> list[tuple[str, str, str]]:
    """Return (roller, belt, next belt) wherever belts arrive at one roller each alone."""
    return _alone(press, lambda span: span.end)


def creep_statements(
    press: Press, *, axial_stiffness_N: Mapping[str, float], overspeed: Mapping[str, float]
) -> list[Statement]:
    """Return what steady creep says about the tensions."""
    drivers, stated = _drivers(press), []
    for roller, first, second in meetings(press):
        if drivers[first] and drivers[second]:
            one, other = drivers[first][0], drivers[second][0]
            softness = axial_stiffness_N[first] / axial_stiffness_N[second]
            factors = {
                arriving(press, one, first): 1.0,
                arriving(press, roller, first): -1.0,
                arriving(press, other, second): -softness,
                arriving(press, roller, second): softness,
            }
            stated.append((factors, axial_stiffness_N[first] * (overspeed[one] - overspeed[other])))
    for belt, names in drivers.items():
        for other in names[1:]:
            factors = {arriving(press, names[0], belt): 1.0, arriving(press, other, belt): -1.0}
            stated.append((factors, axial_stiffness_N[belt] * (overspeed[names[0]] - overspeed[other])))
    return stated


def _share(press: Press) -> list[Statement]:
    return creep_statements(
        press,
        axial_stiffness_N={belt.name: 1.0 for belt in press.belts},
        overspeed={roller.name: 0.0 for roller in press.rollers if roller.role == "driver"},
    )


def _equal(press: Press) -> list[Statement]:
    return [
        ({_leaving(press, roller, first): 1.0, _leaving(press, roller, second): -1.0}, 0.0)
        for roller, first, second in _alone(press, lambda span: span.start)
    ]


def _equal_torque(press: Press) -> list[Statement]:
    belt_of = {name: belt.name for belt in press.belts for name in belt.loop}
    stated = []
    for first, second in pairwise(roller for roller in press.rollers if roller.role == "driver"):
        factors: dict[str, float] = {}
        for driver, lever in ((first, 1.0), (second, -second.radius_m / first.radius_m)):
            into = arriving(press, driver.name, belt_of[driver.name])
            out_of = _leaving(press, driver.name, belt_of[driver.name])
            factors[into] = factors.get(into, 0.0) + lever
            factors[out_of] = factors.get(out_of, 0.0) - lever
        stated.append((factors, 0.0))
    return stated


def _speed_ratio(press: Press) -> list[Statement]:
    stiffness = {belt.name: belt.axial_stiffness_N for belt in press.belts}
    overspeed = {roller.name: roller.overspeed for roller in press.rollers if roller.role == "driver"}
    missing = [f"belts.{name}.axial_stiffness_N" for name, value in stiffness.items() if value is None]
    missing += [f"rollers.{name}.overspeed" for name, value in overspeed.items() if value is None]
    refuse_missing(
        "the closure 'speed-ratio'",
        missing,
        fix="give EA of every belt and (V - v)/v of every driver, or choose the closure 'share'",
    )
    return creep_statements(
        press,
        axial_stiffness_N={name: value for name, value in stiffness.items() if value is not None},
        overspeed={name: value for name, value in overspeed.items() if value is not None},
    )


CLOSURES: Registry[Closure] = Registry(
    "closure",
    [
        Closure(
            name="share",
            rule="each belt gains the same tension from where the belts meet to its driver: T9 - T4 = T10 - T14",
            basis="steady creep with equal surface speed of the drivers and equal EA of the belts",
            statements=_share,
        ),
        Closure(
            name="equal",
            rule="belts leave the roller where they part with the same tension: T9 = T10",
            basis="an even split, whatever the drivers do",
            statements=_equal,
        ),
        Closure(
            name="equal-torque",
            rule="every driver turns its belt with the same torque: R1 (T9 - T1) = R10 (T10 - T11)",
            basis="drives that hold the torque, such as inverters sharing their load",
            statements=_equal_torque,
        ),
        Closure(
            name="speed-ratio",
            rule="(T9 - T4)/EA_upper - (T10 - T14)/EA_lower = (V1 - V10)/v",
            basis="steady creep with known EA of the belts and known surface speeds of the drivers",
            statements=_speed_ratio,
        ),
    ],
)
"""The closures; the first is the default."""


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
