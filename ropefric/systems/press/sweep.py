"""Tensions and slip over preload and speed: the arrays behind the paper's figures 4-7 and the slip map."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.slip import SlipTable, slip_table, steady_contacts
from ropefric.systems.press.statics import Statics
from ropefric.systems.press.steady import steady_state


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PressSweep:
    """A press at every pair of preload and speed."""

    preload_N: FloatArray
    speed_m_s: FloatArray
    spans: tuple[str, ...]
    rollers: tuple[str, ...]
    effective_tension_N: FloatArray
    slack: BoolArray
    slip: SlipTable

    @property
    def margin(self) -> FloatArray:
        """Return the largest utilisation of all rollers, shape (n_preloads or 1, n_speeds); slip begins at 1."""
        return np.asarray(self.slip.utilisation.max(axis=-1))


def rim_speed_m_s(turns_per_minute: npt.ArrayLike, radius_m: npt.ArrayLike) -> FloatArray:
    """Return the rim speed v = 2π n R / 60 of a roller [m/s]."""
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
    """Return tensions and slip over the speed, at the press's own preloads: figures 4 and 5."""
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
    """Return tensions and slip at every pair of preload and speed: figure 7 and the slip map."""
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
