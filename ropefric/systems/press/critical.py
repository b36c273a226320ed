"""Over preload, speed, load and friction: tensions and slip, and the value at which each roller begins to slip."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError, UnknownNameError
from ropefric.registry import did_you_mean
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.slip import (
    Contact,
    SlipTable,
    available_pull_N,
    contacts_of,
    grip_on,
    slip_table,
    steady_contacts,
)
from ropefric.systems.press.statics import Statics
from ropefric.systems.press.steady import speed_shift_kg_m, steady_state


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PressSweep:
    """A press at every pair of preload and speed; without preloads at the machine's own."""

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


def sweep_press(
    statics: Statics,
    friction: float | WrapFriction,
    *,
    preload_N: npt.ArrayLike | None = None,
    speed_m_s: npt.ArrayLike | None = None,
    tensioner: Literal["locked", "elastic"] = "locked",
    told: frozenset[str] = EVERYTHING,
) -> PressSweep:
    """Return tensions and slip at every pair of preloads of all tensioners and speeds; what is not given stays.

    Over the speed alone the arrays behind figures 4 and 5, over the preload figure 6, over both figure 7 and the map.
    """
    preloads = np.empty(0) if preload_N is None else _row("preload_N", preload_N)
    speeds = _row("speed_m_s", [statics.press.speed_m_s] if speed_m_s is None else speed_m_s)
    state = steady_state(
        statics,
        preload_N=preloads[:, None] if preloads.size else None,
        speed_m_s=speeds[None, :],
        tensioner=tensioner,
        on_slack="flag",
    )
    slip = slip_table(steady_contacts(state), friction, told=told)
    return PressSweep(
        preload_N=preloads,
        speed_m_s=speeds,
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


Change = Literal["preload", "speed", "load", "friction"]

CHANGES = {
    "preload": "preload of all tensioners falls [N]",
    "speed": "speed of the belts rises [m/s]",
    "load": "all load torques rise together [factor]",
    "friction": "average coefficient over the roller's wrap falls [-]",
}
"""What may be changed until a roller slips."""

_GRID = 129
_MAX_DOUBLINGS = 40
# A pull this small beside the tension is rounding: the roller carries no torque.
_NO_TORQUE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class FirstSlip:
    """The first roller to slip under one change."""

    roller: str
    change: str
    value: float


def critical_values(
    statics: Statics,
    friction: float | WrapFriction,
    change: Change,
    *,
    tensioner: Literal["locked", "elastic"] = "locked",
    told: frozenset[str] = EVERYTHING,
) -> dict[str, float | None]:
    """Return for every roller the value at which it begins to slip; everything else stays as the press has it."""
    if change not in CHANGES:
        fix = did_you_mean(change, CHANGES)
        raise UnknownNameError(f"nothing is known of the change '{change}'", key="change", fix=fix)
    press = statics.press
    if change == "friction":
        contacts = steady_contacts(steady_state(statics, tensioner=tensioner))
        required = slip_table(contacts, friction, told=told).mu_required
        return {
            contact.roller: float(mu) if abs(contact.friction_pull_N) > _NO_TORQUE * contact.tight_N else None
            for contact, mu in zip(contacts, required, strict=True)
        }
    # Tensions are linear in preload, load and speed squared.
    slopes = {
        "preload": statics.by_preload.sum(axis=1),
        "load": statics.by_load_N,
        "speed": speed_shift_kg_m(statics, tensioner),
    }
    own_N = {
        "preload": statics.by_preload @ [part.force_N for part in press.take_ups],
        "load": statics.by_load_N,
        "speed": press.speed_m_s**2 * slopes["speed"],
    }
    slope = slopes.pop(change)
    at_zero_N = statics.given_N + sum(own_N[name] for name in slopes)
    found: dict[str, float | None] = {}
    for contact, each in zip(contacts_of(press, at_zero_N), contacts_of(press, slope), strict=True):

        def reserve_N(amount: npt.ArrayLike, contact: Contact = contact, each: Contact = each) -> FloatArray:
            amounts = np.asarray(amount, dtype=np.float64)
            there = replace(
                contact,
                upstream_N=contact.upstream_N + amounts * each.upstream_N,
                downstream_N=contact.downstream_N + amounts * each.downstream_N,
            )
            return available_pull_N(there, grip_on(there, friction, told=told)) - abs(there.friction_pull_N)

        pull_N = abs(contact.friction_pull_N + each.friction_pull_N)
        largest_N = max(
            abs(contact.upstream_N + each.upstream_N), abs(contact.downstream_N + each.downstream_N)
        )
        if change != "preload" and pull_N <= _NO_TORQUE * largest_N:
            found[contact.roller] = None
            continue
        root = _crossing(reserve_N, at_zero_N, slope, falling=change == "preload")
        found[contact.roller] = root if root is None or change != "speed" else float(np.sqrt(root))
    return found


def first_to_slip(values: Mapping[str, float | None], change: Change) -> FirstSlip | None:
    """Return the roller that slips first as one thing changes, or None where none ever does."""
    slipping = {name: value for name, value in values.items() if value is not None}
    if not slipping:
        return None
    foremost = max if change in {"preload", "friction"} else min
    roller = foremost(slipping, key=slipping.__getitem__)
    return FirstSlip(roller=roller, change=change, value=slipping[roller])


def _crossing(
    reserve_N: Callable[[npt.ArrayLike], FloatArray],
    at_zero_N: FloatArray,
    slope: FloatArray,
    *,
    falling: bool,
) -> float | None:
    """Return where the reserve of friction first falls to zero on the way from the safe end, if it does.

    The way ends where a span goes slack; where the amount falls, it starts from as much as is safe.
    """
    if falling:
        rising = slope > 0.0
        end = float((-at_zero_N[rising] / slope[rising]).max(initial=0.0))
        tried = max(2.0 * end, 1.0) * 2.0 ** np.arange(_MAX_DOUBLINGS)
        safe = next((amount for amount in tried.tolist() if reserve_N(amount) > 0.0), np.inf)
    else:
        sinking = slope < 0.0
        safe, end = 0.0, float((at_zero_N[sinking] / -slope[sinking]).min(initial=np.inf))
    if not np.isfinite([safe, end]).all():
        return None
    grid = np.linspace(safe, end, _GRID)
    reserve = reserve_N(grid)
    if reserve[0] <= 0.0:
        return None if falling else 0.0
    below = np.flatnonzero(reserve < 0.0)
    if not below.size:
        return None
    bracket = grid[below[0] - 1], grid[below[0]]
    return float(brentq(lambda amount: float(reserve_N(amount)), *bracket, xtol=1e-12, rtol=1e-14))
