"""Tensions and slip over preload and speed: the arrays behind the paper's figures 4-7 and the slip map."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.slip import SlipTable, slip_table, steady_contacts
from ropefric.systems.press.statics import Statics
from ropefric.systems.press.steady import steady_state

__all__ = [
    "PressSweep",
    "over_preload",
    "over_preload_and_speed",
    "over_speed",
    "rim_speed_m_s",
]

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PressSweep:
    """A press at every pair of preload and speed.

    Attributes
    ----------
    preload_N : ndarray, shape (n_preloads,)
        Preload of all tensioners [N]; empty where each keeps its own.
    speed_m_s : ndarray, shape (n_speeds,)
        Belt speed [m/s].
    spans, rollers : tuple of str
        Names along the last axis of the two below.
    effective_tension_N : ndarray, shape (n_preloads or 1, n_speeds, n_spans)
        T' [N].
    slack : ndarray of bool, shape (n_preloads or 1, n_speeds)
        Where a span has T' ≤ 0.
    slip : SlipTable
        Its arrays have shape (n_preloads or 1, n_speeds, n_rollers).
    """

    preload_N: FloatArray
    speed_m_s: FloatArray
    spans: tuple[str, ...]
    rollers: tuple[str, ...]
    effective_tension_N: FloatArray
    slack: npt.NDArray[np.bool_]
    slip: SlipTable

    @property
    def margin(self) -> FloatArray:
        """Return the largest utilisation of all rollers, shape (n_preloads or 1, n_speeds); slip begins at 1."""
        return np.asarray(self.slip.utilisation.max(axis=-1))


def rim_speed_m_s(turns_per_minute: npt.ArrayLike, radius_m: npt.ArrayLike) -> FloatArray:
    """Return the rim speed v = 2π n R / 60 of a roller [m/s].

    Examples
    --------
    >>> float(rim_speed_m_s(50, 0.175).round(6))
    0.916298
    """
    turns, R = np.asarray(turns_per_minute, dtype=np.float64), np.asarray(radius_m, dtype=np.float64)
    return np.asarray(2.0 * np.pi / 60.0 * turns * R)


def over_speed(
    statics: Statics,
    friction: float | WrapFriction,
    *,
    speed_m_s: npt.ArrayLike,
    tensioner: Literal["locked", "elastic"] = "locked",
    told: frozenset[str] = EVERYTHING,
) -> PressSweep:
    """Return tensions and slip over the speed, at the press's own preloads: figures 4 and 5.

    Parameters
    ----------
    statics : Statics
        The press, solved once.
    friction : float or WrapFriction
        Constant μ, or a law.
    speed_m_s : array_like, shape (n_speeds,)
        Belt speeds [m/s].
    tensioner, told
        As in `steady_state` and `utilisation`.

    Raises
    ------
    InputError
        If the speeds are not one row of numbers of zero or more; else as `steady_state`.

    Examples
    --------
    See `over_preload_and_speed`.
    """
    return _sweep(
        statics,
        friction,
        preload_N=np.empty(0),
        speed_m_s=_row("speed_m_s", speed_m_s),
        tensioner=tensioner,
        told=told,
    )


def over_preload(
    statics: Statics,
    friction: float | WrapFriction,
    *,
    preload_N: npt.ArrayLike,
    tensioner: Literal["locked", "elastic"] = "locked",
    told: frozenset[str] = EVERYTHING,
) -> PressSweep:
    """Return tensions and slip over the preload of all tensioners, at the press's own speed: figure 6.

    Arguments and refusals are those of `over_preload_and_speed`.

    Examples
    --------
    See `over_preload_and_speed`.
    """
    return _sweep(
        statics,
        friction,
        preload_N=_row("preload_N", preload_N),
        speed_m_s=np.array([statics.press.speed_m_s]),
        tensioner=tensioner,
        told=told,
    )


def over_preload_and_speed(
    statics: Statics,
    friction: float | WrapFriction,
    *,
    preload_N: npt.ArrayLike,
    speed_m_s: npt.ArrayLike,
    tensioner: Literal["locked", "elastic"] = "locked",
    told: frozenset[str] = EVERYTHING,
) -> PressSweep:
    """Return tensions and slip at every pair of preload and speed: figure 7 and the slip map.

    Parameters
    ----------
    statics : Statics
        The press, solved once.
    friction : float or WrapFriction
        Constant μ, or a law.
    preload_N : array_like, shape (n_preloads,)
        Preload of all tensioners [N].
    speed_m_s : array_like, shape (n_speeds,)
        Belt speeds [m/s].
    tensioner, told
        As in `steady_state` and `utilisation`.

    Raises
    ------
    InputError
        If the preloads or speeds are not one row of numbers of zero or more.

    Examples
    --------
    >>> from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
    >>> from ropefric.systems.press.statics import solve_statics
    >>> drive = Roller(name="drive", radius_m=0.1, wrap_angle_rad=3.0, role="driver")
    >>> load = Roller(name="load", radius_m=0.1, wrap_angle_rad=2.0, role="tensioner", gravity_torque_N_m=5.0,
    ...     tensioner=Tensioner(spring_N_m=0.0, travel_m=0.0, force_N=1000.0))
    >>> belt = Belt(name="belt", loop=("drive", "load"), linear_density_kg_m=1, thickness_m=0.005, width_m=1)
    >>> statics = solve_statics(Press(rollers=(drive, load), belts=(belt,), speed_m_s=2.0))
    >>> sweep = over_preload_and_speed(statics, 0.5, preload_N=[100, 1000], speed_m_s=[0, 2])
    >>> sweep.margin.round(3).tolist()
    [[1.164, 1.386], [0.061, 0.062]]
    >>> over_speed(statics, 0.5, speed_m_s=[0, 2]).margin.round(3).tolist()
    [[0.061, 0.062]]
    >>> over_preload(statics, 0.5, preload_N=[100, 1000]).margin.round(3).tolist()
    [[1.386], [0.062]]
    """
    return _sweep(
        statics,
        friction,
        preload_N=_row("preload_N", preload_N),
        speed_m_s=_row("speed_m_s", speed_m_s),
        tensioner=tensioner,
        told=told,
    )


def _sweep(
    statics: Statics,
    friction: float | WrapFriction,
    *,
    preload_N: FloatArray,
    speed_m_s: FloatArray,
    tensioner: Literal["locked", "elastic"],
    told: frozenset[str],
) -> PressSweep:
    state = steady_state(
        statics,
        preload_N=preload_N[:, None] if preload_N.size else None,
        speed_m_s=speed_m_s[None, :],
        tensioner=tensioner,
        on_slack="flag",
    )
    slip = slip_table(steady_contacts(state), friction, told=told)
    return PressSweep(
        preload_N=preload_N,
        speed_m_s=speed_m_s,
        spans=tuple(span.name for span in statics.press.spans),
        rollers=slip.rollers,
        effective_tension_N=state.effective_tension_N,
        slack=state.slack,
        slip=slip,
    )


def _row(name: str, values: npt.ArrayLike) -> FloatArray:
    row = np.asarray(values, dtype=np.float64)
    if row.ndim != 1 or not row.size:
        raise InputError(f"{name} has the shape {row.shape}; one row of numbers is needed", key=name)
    return row
