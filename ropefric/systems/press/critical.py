"""The preload, load, speed and friction at which each roller begins to slip, and which roller is first."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from ropefric.arrays import FloatArray
from ropefric.errors import UnknownNameError
from ropefric.registry import did_you_mean
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.slip import available_pull_N, grip_on, slip_table, steady_contacts
from ropefric.systems.press.statics import Statics
from ropefric.systems.press.steady import SteadyState, steady_state

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
    if change == "friction":
        contacts = steady_contacts(steady_state(statics, tensioner=tensioner))
        required = slip_table(contacts, friction, told=told).mu_required
        return {
            contact.roller: float(mu) if abs(contact.friction_pull_N) > _NO_TORQUE * contact.tight_N else None
            for contact, mu in zip(contacts, required, strict=True)
        }

    def run(values: npt.ArrayLike) -> SteadyState:
        amount = np.asarray(values, dtype=np.float64)
        if change == "preload":
            return steady_state(statics, preload_N=amount, tensioner=tensioner, on_slack="flag")
        if change == "load":
            return steady_state(statics, load_factor=amount, tensioner=tensioner, on_slack="flag")
        return steady_state(statics, speed_m_s=np.sqrt(amount), tensioner=tensioner, on_slack="flag")

    def reserve_N(values: npt.ArrayLike, index: int) -> FloatArray:
        contact = steady_contacts(run(values))[index]
        return available_pull_N(contact, grip_on(contact, friction, told=told)) - abs(contact.friction_pull_N)

    found: dict[str, float | None] = {}
    for index, roller in enumerate(statics.press.rollers):
        root = _crossing(run, reserve_N, index, falling=change == "preload")
        found[roller.name] = root if root is None or change != "speed" else float(np.sqrt(root))
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
    run: Callable[[npt.ArrayLike], SteadyState],
    reserve_N: Callable[[npt.ArrayLike, int], FloatArray],
    index: int,
    *,
    falling: bool,
) -> float | None:
    """Return where the reserve of friction first falls to zero on the way from the safe end, if it does."""
    contact = steady_contacts(run(1.0))[index]
    if not falling and abs(contact.friction_pull_N) <= _NO_TORQUE * abs(contact.tight_N):
        return None
    safe, end = _range(run, reserve_N, index, falling=falling)
    if not np.isfinite([safe, end]).all():
        return None
    grid = np.linspace(safe, end, _GRID)
    reserve = reserve_N(grid, index)
    if reserve[0] <= 0.0:
        return None if falling else 0.0
    below = np.flatnonzero(reserve < 0.0)
    if not below.size:
        return None
    bracket = grid[below[0] - 1], grid[below[0]]
    return float(brentq(lambda value: float(reserve_N(value, index)), *bracket, xtol=1e-12, rtol=1e-14))


def _range(
    run: Callable[[npt.ArrayLike], SteadyState],
    reserve_N: Callable[[npt.ArrayLike, int], FloatArray],
    index: int,
    *,
    falling: bool,
) -> tuple[float, float]:
    """Return the safe end and the end where a preload is zero or a span goes slack."""
    # Tensions are linear in preload, load and speed squared, so two points tell where each reaches zero.
    at_zero, slope = run(0.0).effective_tension_N, np.diff(run([0.0, 1.0]).effective_tension_N, axis=0)[0]
    if not falling:
        sinking = slope < 0.0
        return 0.0, float((at_zero[sinking] / -slope[sinking]).min(initial=np.inf))
    rising = slope > 0.0
    end = float((-at_zero[rising] / slope[rising]).max(initial=0.0))
    safe = max(2.0 * end, 1.0)
    for _ in range(_MAX_DOUBLINGS):
        if reserve_N(safe, index) > 0.0:
            return safe, end
        safe *= 2.0
    return np.inf, end
