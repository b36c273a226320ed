"""Tensions and slip over preloads and speeds, and what has to change until a roller slips, or the last one stops."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.answer import PressAnswer, take_up
from ropefric.systems.press.slip import Contacts, SlipTable, contacts_of
from ropefric.systems.press.statics import Statics, solve_statics
from ropefric.systems.press.steady import TakeUp, speed_shift_kg_m, steady_state


class PressSweep:
    """Tensions and slip at every pair of preloads of all tensioners and speeds; what is not given stays.

    Over the speed alone the arrays behind figures 4 and 5, over the preload figure 6, over both figure 7 and the map.
    `margin` is the largest utilisation of all rollers, shape (n_preloads or 1, n_speeds); slip begins at 1.
    """

    def __init__(
        self,
        statics: Statics,
        friction: float | WrapFriction,
        *,
        preload_N: npt.ArrayLike | None = None,
        speed_m_s: npt.ArrayLike | None = None,
    ) -> None:
        press = statics.press
        self.preload_N = np.empty(0) if preload_N is None else _row("preload_N", preload_N)
        self.speed_m_s = _row("speed_m_s", [press.speed_m_s] if speed_m_s is None else speed_m_s)
        state = steady_state(
            statics,
            preload_N=self.preload_N[:, None] if self.preload_N.size else None,
            speed_m_s=self.speed_m_s[None, :],
            on_slack="flag",
        )
        self.effective_tension_N, self.slack = state.effective_tension_N, state.slack
        self.slip = SlipTable(press, self.effective_tension_N, friction)
        self.spans, self.rollers = tuple(span.name for span in press.spans), self.slip.rollers
        self.margin = self.slip.utilisation.max(axis=-1)


def _row(name: str, values: npt.ArrayLike) -> FloatArray:
    row = np.asarray(values, dtype=np.float64)
    if row.ndim != 1 or not row.size:
        raise InputError(f"{name} has the shape {row.shape}; one row of numbers is needed", key=name)
    return row


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


def critical_values(
    statics: Statics,
    friction: float | WrapFriction,
    change: str,
    *,
    tensioner: TakeUp = "locked",
    told: frozenset[str] = EVERYTHING,
) -> dict[str, float | None]:
    """Return for every roller the value at which it begins to slip; everything else stays as the press has it."""
    press = statics.press
    if change == "friction":
        tension_N = steady_state(statics, tensioner=tensioner).effective_tension_N
        slip = SlipTable(press, tension_N, friction, told=told)
        grips = slip.contacts.pull_N > _NO_TORQUE * (slip.contacts.slack_N + slip.contacts.pull_N)
        return {
            name: float(mu) if grip else None
            for name, mu, grip in zip(slip.rollers, slip.mu_required, grips, strict=True)
        }
    # Tensions are linear in preload, load and speed squared.
    slopes = {
        "preload": statics.by_preload.sum(axis=1),
        "load": statics.by_load_N,
        "speed": speed_shift_kg_m(statics, tensioner),
    }
    own_N = {
        "preload": statics.by_preload @ [part.force_N for part in press.tensioners.values()],
        "load": statics.by_load_N,
        "speed": press.speed_m_s**2 * slopes["speed"],
    }
    slope = slopes.pop(change)
    at_zero_N = statics.given_N + sum(own_N[name] for name in slopes)
    base, each, both = (contacts_of(press, part) for part in (at_zero_N, slope, at_zero_N + slope))
    idle = both.pull_N <= _NO_TORQUE * np.maximum(abs(both.upstream_N), abs(both.downstream_N))
    values: dict[str, float | None] = {}
    for i, name in enumerate(base.roller.tolist()):
        here, more = base.of(i), each.of(i)

        def reserve_N(amount: npt.ArrayLike, here: Contacts = here, more: Contacts = more) -> FloatArray:
            sides = np.multiply.outer([more.upstream_N, more.downstream_N], amount)
            there = here._replace(
                upstream_N=here.upstream_N + sides[0], downstream_N=here.downstream_N + sides[1]
            )
            return np.asarray(there.slack_N * np.expm1(there.exponent(friction, told)) - there.pull_N)

        root = None
        if change == "preload" or not idle[i]:
            root = _crossing(reserve_N, at_zero_N, slope, falling=change == "preload")
        values[name] = root if root is None or change != "speed" else float(np.sqrt(root))
    return values


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


def first_to_slip(values: Mapping[str, float | None], change: str) -> tuple[str, float] | None:
    """Return the roller that slips first as one thing changes, and where; None where none ever does."""
    slipping = {name: value for name, value in values.items() if value is not None}
    foremost = max if change in {"preload", "friction"} else min
    return foremost(slipping.items(), key=lambda one: one[1], default=None)


def slip_margins(answer: PressAnswer) -> dict[str, Any]:
    """Return which roller is nearest to slip, and what would make the first one slip, as plain data.

    Where rollers slip already, each value is the one at which the last of them stops, and lies the other way.
    """
    model, rollers, use = answer.model, answer.slip.rollers, answer.slip.utilisation[0]
    slips = [name for name, share in zip(rollers, use, strict=True) if share > 1.0]
    statics = solve_statics(model.as_operated, closure=model.problem.closure)
    critical: dict[str, Any] = {}
    for change, words in CHANGES.items():
        # What a higher speed does is the belts' mass, whether or not it matters at this one.
        tensioner = take_up(model.effects | ({"belt-inertia"} if change == "speed" else set()))
        values = critical_values(
            statics, model.problem.friction, change, tensioner=tensioner, told=model.told
        )
        slipping = {name: values[name] for name in slips}
        first = first_to_slip(slipping or values, change)
        if None in slipping.values():
            first = None  # nothing of this kind holds that roller
        falls = (change in {"preload", "friction"}) != bool(slipping)
        # A slipping roller that slips at rest and without load too has no way out there.
        nowhere = first is None or (bool(slipping) and first[1] == 0.0)
        critical[change] = {
            "state": "slips" if slipping else "holds",
            "direction": None if nowhere else "falls" if falls else "rises",
            "roller": None if first is None else first[0],
            "value": None if first is None else first[1],
            "unit": words.rpartition("[")[2].rstrip("]"),
            "by_roller": values,
        }
    nearest = rollers[int(np.argmax(use))] if use.any() else None
    return {"first_to_slip": nearest, "slips": slips, "critical": critical}
