"""What ends a mode: each guard is a row that stays above zero as long as its contact or span keeps its state."""

from dataclasses import dataclass, replace
from typing import Literal, TypeVar

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.systems.press.transient.inputs import LOAD
from ropefric.systems.press.transient.mode import BACKWARD, FORWARD, STICK, Mode
from ropefric.systems.press.transient.motion import Motion

What = Literal["slip", "stick", "hold", "release", "pressed", "taut", "strained"]
T = TypeVar("T")

_FORCE_SHARE = 1e-10
"""A guard on a force has fired when it is below zero by this share of the preload."""
_SPEED_M_S = 1e-11


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Guard:
    """One condition of a mode."""

    row: FloatArray
    tolerance: float
    what: What
    place: int
    direction: int = 0


def guards_of(motion: Motion) -> list[Guard]:
    """Return the guards of a mode."""
    force_N = _FORCE_SHARE * float(motion.model.preload_N.max())
    mode = motion.mode
    found: list[Guard] = []
    for i in range(motion.n_rollers):
        found += _contact_guards(motion, i, force_N) + _turning_guards(motion, i, force_N)
    bits: tuple[tuple[What, FloatArray, tuple[bool, ...]], ...] = (
        ("pressed", motion.pressing_N, mode.pressed),
        ("taut", motion.unclipped_N, mode.taut),
        ("strained", motion.spring_N, mode.strained),
    )
    for what, rows, states in bits:
        for i, is_so in enumerate(states):
            found.append(Guard(row=rows[i] if is_so else -rows[i], tolerance=force_N, what=what, place=i))
    return found


def _contact_guards(motion: Motion, i: int, force_N: float) -> list[Guard]:
    contact = motion.mode.contact[i]
    if contact != STICK:
        row = contact * motion.slip_speed_m_s[i]
        return [Guard(row=row, tolerance=_SPEED_M_S, what="stick", place=i)]
    forward, backward = motion.limit_N[0][i], motion.limit_N[1][i]
    rows = {FORWARD: forward - motion.friction_N[i], BACKWARD: backward + motion.friction_N[i]}
    return [
        Guard(row=row, tolerance=force_N, what="slip", place=i, direction=way) for way, row in rows.items()
    ]


def _turning_guards(motion: Motion, i: int, force_N: float) -> list[Guard]:
    turning, load_N = motion.mode.turning[i], float(motion.model.load_N[i])
    if i in motion.model.drivers or load_N <= 0.0:
        return []
    if turning == 0:
        most_N = load_N * motion.input(LOAD)
        return [
            Guard(
                row=most_N - way * motion.friction_N[i],
                tolerance=force_N,
                what="release",
                place=i,
                direction=way,
            )
            for way in (1, -1)
        ]
    if turning > 0 and motion.mode.contact[i] == STICK:
        # The load of a roller that the belt takes along is as given, as in the linear model.
        return []
    return [Guard(row=turning * motion.rim_speed_m_s[i], tolerance=_SPEED_M_S, what="hold", place=i)]


def switched(motion: Motion, guard: Guard, y: FloatArray, u: FloatArray) -> tuple[Mode, FloatArray]:
    """Return the mode after a guard has fired, and the state with the speeds that the new mode ties set equal."""
    mode, place = motion.mode, guard.place
    state = y.copy()
    speed_m_s = (
        float(motion.rim_speed_m_s[place] @ np.concatenate([y, u])) if guard.what in _OF_ROLLERS else 0.0
    )
    if guard.what == "slip":
        contact, turning = _put(mode.contact, place, guard.direction), mode.turning
        if turning[place] and speed_m_s < -_SPEED_M_S:
            turning = _put(turning, place, -1)
        return replace(mode, contact=contact, turning=turning), state
    if guard.what == "stick":
        state[len(state) - motion.n_rollers + place] = 0.0
        return replace(mode, contact=_put(mode.contact, place, STICK)), state
    if guard.what in {"hold", "release"}:
        if guard.what == "hold":
            row = int(np.flatnonzero(motion.model.driven == place)[0])
            state[motion.n_coordinates + row] -= speed_m_s
        return replace(mode, turning=_put(mode.turning, place, guard.direction)), state
    states: tuple[bool, ...] = getattr(mode, guard.what)
    return replace(mode, **{guard.what: _put(states, place, not states[place])}), state


_OF_ROLLERS = frozenset({"slip", "hold"})


def _put(states: tuple[T, ...], place: int, value: T) -> tuple[T, ...]:
    return (*states[:place], value, *states[place + 1 :])
