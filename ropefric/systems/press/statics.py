"""The steady equations (23)-(34) solved once: tensions as a linear map of preloads, loads and speed squared."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError
from ropefric.systems.press.closures import CLOSURES, Closure
from ropefric.systems.press.determinacy import free_motions, in_words, matrix_rank
from ropefric.systems.press.equations import has_balance, incidence, load_torques_N_m, pull_matrix, radii_m
from ropefric.systems.press.machine import Press

__all__ = ["Statics", "solve_statics"]

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Statics:
    """What sets the tensions of a press at rest, one share each.

    At rest T = given + load_factor · by_load + by_preload @ F.

    Attributes
    ----------
    press : Press
        The machine.
    closure : str
        The closure that was used, "" where the balances determine everything by themselves.
    rank : int
        Rank of the balances; there are `len(press.spans)` tensions.
    undetermined : tuple of str
        What the balances leave open and the closure settles, one sentence for each missing equation.
    given_N : ndarray, shape (n_spans,)
        Share of the springs' travel k1 x and of the closure's own force [N].
    by_load_N : ndarray, shape (n_spans,)
        Share of the load torques [N].
    by_preload : ndarray, shape (n_spans, n_tensioners)
        dT/dF [-].
    """

    press: Press
    closure: str
    rank: int
    undetermined: tuple[str, ...]
    given_N: FloatArray
    by_load_N: FloatArray
    by_preload: FloatArray


def solve_statics(press: Press, *, closure: str = "share") -> Statics:
    """Return the linear solution of the steady equations, eqs. (23)-(34).

    Parameters
    ----------
    press : Press
        The machine.
    closure : str
        Name of a member of `CLOSURES`; used only where the balances leave something open.

    Returns
    -------
    Statics
        The shares.

    Raises
    ------
    UnknownNameError
        For a closure that is not known.
    InputError
        If the closure lacks data or does not settle exactly what is open, or if balances contradict each other, as
        those of two tensioners on one belt do.

    Examples
    --------
    >>> from ropefric.systems.press.machine import Belt, Roller, Tensioner
    >>> drive = Roller(name="drive", radius_m=0.1, wrap_angle_rad=3.0, role="driver")
    >>> load = Roller(name="load", radius_m=0.1, wrap_angle_rad=3.0, role="tensioner", gravity_torque_N_m=5.0,
    ...     tensioner=Tensioner(spring_N_m=0.0, travel_m=0.0, force_N=1000.0))
    >>> belt = Belt(name="belt", loop=("drive", "load"), linear_density_kg_m=1, thickness_m=0.005, width_m=1)
    >>> statics = solve_statics(Press(rollers=(drive, load), belts=(belt,), speed_m_s=1.0))
    >>> statics.rank, statics.by_load_N.round(6).tolist(), statics.by_preload.round(6).tolist()
    (2, [-25.0, 25.0], [[0.5], [0.5]])
    """
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
    data = [roller.tensioner for roller in press.rollers if roller.tensioner is not None]
    right = np.zeros((n_equations, 2 + len(data)))
    right[: len(loads_N), 1] = loads_N
    right[len(loads_N) :, 0] = [part.spring_N_m * part.travel_m for part in data]
    right[len(loads_N) :, 2:] = np.eye(len(data))
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
