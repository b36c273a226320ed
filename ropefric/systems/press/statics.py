"""The steady equations (23)-(34) solved once: tensions as a linear map of preloads, loads and speed squared.

How belts share a pull that no balance divides is settled by a closure, a named assumption about the split:

- "share": each belt gains the same tension from where the belts meet to its driver, T9 - T4 = T10 - T14; steady creep
  with equal surface speed of the drivers and equal EA of the belts.
- "equal": belts leave the roller where they part with the same tension, T9 = T10, whatever the drivers do.
- "equal-torque": every driver turns its belt with the same torque, R1 (T9 - T1) = R10 (T10 - T11); drives that hold
  the torque, such as inverters sharing their load.
- "speed-ratio": (T9 - T4)/EA_upper - (T10 - T14)/EA_lower = (V1 - V10)/v; steady creep with known EA of the belts and
  known surface speeds of the drivers.

Steady creep: in a steady run as much belt passes every place, so its speed is v_b (1 + T/EA) with one v_b for each
belt. It sticks to a roller where it arrives. So at a driver V = v_b (1 + T_in/EA), and where two belts meet on one
roller the same V holds for both. With v_b and the speed of that roller eliminated, to first order in the strain,

    (T_d − T_m)_1 / EA_1 − (T_d − T_m)_2 / EA_2 = (V_1 − V_2)/v

for belts 1 and 2 that meet in the spans m and reach their drivers in the spans d; and for two drivers of one belt
(T_1 − T_2)/EA = (V_1 − V_2)/v.

A tensioner sets the level of its belt's tensions by a balance. A belt between fixed centres keeps its unstretched
length instead: `centres` raises its level, on which the tensions depend linearly, until it does.
"""

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError, SolverError
from ropefric.systems.checks import checked
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.centres import at_kept_lengths_N, level_rows
from ropefric.systems.press.creep import belts_alone, tension_row
from ropefric.systems.press.machine import Press, refuse_missing

Statement = tuple[FloatArray, float]
"""One linear equation between tensions: the factor of each span's, and their sum [N]."""


def _creep(press: Press, stiffness_N: Mapping[str, float], overspeed: Mapping[str, float]) -> list[Statement]:
    """Return what steady creep says about the tensions; a belt without driver is dragged along by another."""
    drivers = {belt.name: [name for name in belt.loop if name in overspeed] for belt in press.belts}
    stated = []

    def state(row: FloatArray, belt: str, one: str, other: str) -> None:
        stated.append((row, stiffness_N[belt] * (overspeed[one] - overspeed[other])))

    for roller, first, second in belts_alone(press):
        if drivers[first] and drivers[second]:
            ends = [(belt, drivers[belt][0]) for belt in (first, second)]
            gains = [
                tension_row(press, driver, belt) - tension_row(press, roller, belt) for belt, driver in ends
            ]
            softness = stiffness_N[first] / stiffness_N[second]
            state(gains[0] - softness * gains[1], first, *(driver for _, driver in ends))
    for belt, names in drivers.items():
        for other in names[1:]:
            row = tension_row(press, names[0], belt) - tension_row(press, other, belt)
            state(row, belt, names[0], other)
    return stated


def _share(press: Press) -> list[Statement]:
    return _creep(
        press, {belt.name: 1.0 for belt in press.belts}, {roller.name: 0.0 for roller in press.drivers}
    )


def _equal(press: Press) -> list[Statement]:
    return [
        (tension_row(press, roller, first, "start") - tension_row(press, roller, second, "start"), 0.0)
        for roller, first, second in belts_alone(press, "start")
    ]


def _equal_torque(press: Press) -> list[Statement]:
    pulls, radius_m = press.incidence, press.radius_m
    drivers = np.flatnonzero(~press.is_driven)
    return [(radius_m[j] / radius_m[i] * pulls[j] - pulls[i], 0.0) for i, j in pairwise(drivers)]


def _speed_ratio(press: Press) -> list[Statement]:
    missing = [f"belts.{one.name}.axial_stiffness_N" for one in press.belts if one.axial_stiffness_N is None]
    missing += [f"rollers.{one.name}.overspeed" for one in press.drivers if one.overspeed is None]
    refuse_missing(
        "the closure 'speed-ratio'",
        missing,
        fix="give EA of every belt and (V - v)/v of every driver, or choose the closure 'share'",
    )
    stiffness_N = {one.name: one.axial_stiffness_N or 0.0 for one in press.belts}
    return _creep(press, stiffness_N, {one.name: one.overspeed or 0.0 for one in press.drivers})


CLOSURES: dict[str, Callable[[Press], list[Statement]]] = {
    "share": _share,
    "equal": _equal,
    "equal-torque": _equal_torque,
    "speed-ratio": _speed_ratio,
}
"""Statement of each closure; the first is the default."""

# The entries are cosines and ones, so singular values are of order one or zero by rounding.
_TINY = 1e-9


def _rank(matrix: FloatArray) -> int:
    return int(np.linalg.matrix_rank(matrix, tol=_TINY)) if matrix.size else 0


def _free_motions(matrix: FloatArray) -> FloatArray:
    """Return a sparse basis of the null space, shape (deficiency, n): what no row of the matrix sees.

    The basis is in reduced echelon form: each vector begins with a 1 where all others are 0.
    """
    basis = np.linalg.svd(matrix)[2][_rank(matrix) :].copy()
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


def _open(matrix: FloatArray, names: Sequence[str]) -> tuple[str, ...]:
    """Return what the rows of a matrix leave open, in words."""
    words = []
    for motion in _free_motions(matrix):
        parts = [(f"T{name}", value) for name, value in zip(names, motion, strict=True) if value != 0.0]
        rising, falling = (", ".join(name for name, one in parts if way * one > 0.0) for way in (1.0, -1.0))
        alike = f"{rising} may rise " + (f"while {falling} falls as much" if falling else "together")
        each = "may change together: " + ", ".join(f"{value:+.4g} {name}" for name, value in parts)
        words.append(each if any(abs(abs(value) - 1.0) >= _TINY for _, value in parts) else alike)
    return tuple(words)


class Statics(NamedTuple):
    """The parts of the tensions of a press at rest, one share each.

    At rest T = given + load_factor · by_load + by_preload @ F, with F as in `Press.preload_N`; for a belt between fixed
    centres it is the mean of its tension along its length.
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
    names, carriers = [span.name for span in press.spans], press.tensioners
    balances = np.vstack([press.incidence[press.is_driven], press.pull, level_rows(press)])
    rank, loads_N = _rank(balances), press.rim_load_N[press.is_driven]
    if rank < len(balances):
        _refuse_repeated(press, balances)
    # The right-hand sides of the balances, a column each: springs, loads, one newton of each preload.
    n, n_preloads = len(loads_N), len(press.preload_N)
    right = np.zeros((rank, 2 + n_preloads))
    right[n : n + len(carriers), 0] = [part.spring_N_m * part.travel_m for part in carriers.values()]
    right[:n, 1] = loads_N
    right[n:, 2:] = np.eye(n_preloads)
    undetermined = _open(balances, names)
    if undetermined:
        statements = CLOSURES[closure](press)
        balances = np.vstack([balances, *(row for row, _ in statements)])
        _refuse_unsettled(balances, names, undetermined, closure, len(statements))
        right = np.pad(right, ((0, len(statements)), (0, 0)))
        right[rank:, 0] = [value_N for _, value_N in statements]
    shares: FloatArray = np.asarray(np.linalg.solve(balances, right), dtype=np.float64)
    known = (press, closure if undetermined else "", rank, undetermined)
    return Statics(*known, shares[:, 0], shares[:, 1], shares[:, 2:])


def _refuse_repeated(press: Press, balances: FloatArray) -> None:
    said = [f"torque of roller {roller.name}" for roller in press.rollers if roller.role != "driver"]
    said += [f"travel of tensioner {name}" for name in press.tensioners]
    said += [f"level of belt {belt.name}" for belt in press.fixed_belts]
    weights = np.abs(_free_motions(balances.T)).max(axis=0)
    tied = [one for one, weight in zip(said, weights, strict=True) if weight > 0.0]
    raise InputError(
        f"these balances repeat each other, so that their loads would have to agree by chance: {', '.join(tied)}",
        code="RF522",
        fix="keep one tensioner a belt (let the other roller be driven), and give every machine a driver",
    )


def _refuse_unsettled(
    balances: FloatArray, names: Sequence[str], undetermined: Sequence[str], closure: str, n_statements: int
) -> None:
    """Refuse a closure that, beside the balances, makes too few or too many statements."""
    if _rank(balances) < len(names):
        problem = f"the balances leave {len(undetermined)} thing(s) open and the closure '{closure}' does not settle: "
        problem += "; ".join(_open(balances, names))
    elif n_statements > len(undetermined):
        problem = (
            f"the closure '{closure}' makes {n_statements} statements where {len(undetermined)} are open: "
        )
        problem += "; ".join(undetermined)
    else:
        return
    raise InputError(
        problem, code="RF522", fix="give every belt a tensioner or a pretension, or choose another closure"
    )


TakeUp: TypeAlias = Literal["locked", "elastic", "floating"]
"""Tensioners when the belts run: they keep their place, so that T stays and T' = T − ρAv² (eq. (39)), whether or
not the belts stretch; give way on their springs as the belts stretch; or keep T', since the belts have no mass or do
not stretch, which leaves tensioners on springs where they are."""


def speed_shift_kg_m(statics: Statics, tensioner: TakeUp) -> FloatArray:
    """Return dT'/d(v²) of every span, shape (n_spans,) [kg/m]: T' = T'(0) + v² times this.

    A running belt needs ρAv² to keep its path. If the tensioners keep their place its length cannot change, T stays
    and T' falls by all of it: the limit of a stiff spring. In general the level z_b of T' in belt b follows from the
    belt's length and the springs' balance,

        (L/EA)_b (z_b + ρA_b v²) = −Σ_j G_jb dx_j,      k_j dx_j = Σ_b G_jb z_b,

    with G the pull of one newton in each belt along each travel: for one tensioner dT' = −ρAv²/(1 + s),
    s = (cos + cos)² k_b/k1, k_b = EA/L. A spring of no stiffness keeps T'.
    """
    press = statics.press
    if tensioner != "elastic":
        return -press.density_kg_m * (tensioner == "locked")
    fix = "give them, or take tensioner='locked'"
    refuse_missing("the elastic tensioner", press.missing_elasticity, fix=fix)
    arcs_m = dict(
        zip([one.name for one in press.rollers], press.radius_m * press.wrap_angle_rad, strict=True)
    )
    lengths_m = [
        sum(belt.span_lengths_m or ()) + sum(arcs_m[name] for name in belt.loop) for belt in press.belts
    ]
    give = np.diag(lengths_m / np.array([belt.axial_stiffness_N for belt in press.belts], dtype=np.float64))
    density = np.array([belt.linear_density_kg_m for belt in press.belts])
    pull = press.pull @ press.carried.T
    springs = np.diag([part.spring_N_m for part in press.tensioners.values()])
    # One system in z and dx, so that a spring of no stiffness needs no division by zero.
    system = np.block([[give, pull.T], [pull, -springs]])
    right = np.concatenate([-give @ density, np.zeros(len(springs))])
    level = np.linalg.solve(system, right)[: len(density)]
    by_force = statics.by_preload[:, : len(springs)]
    return np.asarray(by_force @ (pull @ (level + density)) - press.density_kg_m)


class SteadyState(NamedTuple):
    """Tensions T' of a press that runs steadily, at any number of operating points."""

    press: Press
    speed_m_s: FloatArray
    load_factor: FloatArray
    effective_tension_N: FloatArray
    slack: BoolArray

    @property
    def tension_N(self) -> FloatArray:
        """Return T [N], shape (..., n_spans): with the part ρAv² of every belt that keeps it on its path."""
        return self.effective_tension_N + np.multiply.outer(self.speed_m_s**2, self.press.density_kg_m)

    @property
    def drive_power_W(self) -> FloatArray:
        """Return the power of all drivers together [W], shape (...): the loads Σ M/R times the speed.

        It is computed from the loads: creep, bearings and bending are not part of the model.
        """
        return np.asarray(self.press.rim_load_N.sum() * self.load_factor * self.speed_m_s)


def steady_state(
    statics: Statics,
    *,
    preload_N: npt.ArrayLike | None = None,
    speed_m_s: npt.ArrayLike | None = None,
    load_factor: npt.ArrayLike = 1.0,
    tensioner: TakeUp = "locked",
    on_slack: Literal["refuse", "flag"] = "refuse",
    friction: float | WrapFriction | None = None,
    regressors: frozenset[str] = EVERYTHING,
) -> SteadyState:
    """Return the tensions of a steady run, eqs. (23)-(36) and (39); a preload given is that of all tensioners.

    Friction is needed where belts run between fixed centres.
    """
    press = statics.press
    shared = press.is_shared * (preload_N is not None)
    asked = {
        "speed_m_s": press.speed_m_s if speed_m_s is None else speed_m_s,
        "load_factor": load_factor,
        "preload_N": 0.0 if preload_N is None else preload_N,
    }
    speed, load, preload = (checked(name, values, "zero or more") for name, values in asked.items())
    shape = np.broadcast_shapes(speed.shape, load.shape, preload.shape)
    base_N = statics.given_N + statics.by_preload @ (press.preload_N * ~shared)
    shares = [
        (statics.by_load_N, load),
        (speed_shift_kg_m(statics, tensioner), speed**2),
        (statics.by_preload @ shared, preload),
    ]
    spans = (-1, *(1,) * len(shape))
    by_span = np.broadcast_to(base_N.reshape(spans), (len(base_N), *shape))
    for share, acting in shares:
        by_span = by_span + share.reshape(spans) * acting
    moving = speed**2 * (tensioner != "floating")
    kept_N = at_kept_lengths_N(
        press,
        statics.by_preload,
        np.moveaxis(by_span, 0, -1),
        circling_N=np.multiply.outer(np.broadcast_to(moving, shape), press.density_kg_m),
        friction=friction,
        regressors=regressors,
    )
    by_span = np.moveaxis(kept_N, -1, 0)
    slack = by_span.min(axis=0, initial=np.inf) <= 0.0
    if on_slack == "refuse" and slack.any():
        flat = by_span.reshape(len(base_N), -1)
        span, point = np.unravel_index(int(np.argmin(flat)), flat.shape)
        place = f" at point {point} of {flat.shape[1]}" if flat.shape[1] > 1 else ""
        worst = press.spans[int(span)]
        raise SolverError(
            f"span {worst.name} (roller {worst.start} to {worst.end}) goes slack{place}: "
            f"T' = {flat[span, point]:.6g} N, and a belt cannot push",
            code="RF523",
            key=f"span {worst.name}",
            fix="raise the preload of the tensioners or lower the loads (in Python, on_slack='flag' marks such points)",
        )
    speed, load = (np.broadcast_to(one, shape) for one in (speed, load))
    return SteadyState(press, speed, load, kept_N, slack)
