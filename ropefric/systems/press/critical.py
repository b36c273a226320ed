"""Tensions and slip over preloads and speeds, and what has to change until a roller slips, or the last one stops."""

from collections.abc import Callable
from operator import itemgetter
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.answer import PressAnswer, take_up
from ropefric.systems.press.slip import SlipTable, contacts_of
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

_USUAL = {"preload": "falls", "speed": "rises", "load": "rises", "friction": "falls"}
"""The way in which slip is looked for first."""
_OTHER = {"falls": "rises", "rises": "falls"}

_PLACES = np.concatenate([np.linspace(0.0, 1.0, 129)[:-1], 1.0 - 0.5 ** np.arange(8.0, 41.0), [1.0]])
"""Where the reserve of friction is looked at on the way from today to the end."""
# A pull this small beside the tension is rounding: the roller carries no torque.
_NO_TORQUE = 1e-9


class Critical(NamedTuple):
    """What leads from today's state to the first slip, or where rollers slip already to the end of the last one.

    `by_roller` has of each roller that holds where it slips on that way (on the usual one where others slip), of each
    that slips where it stops; None where it does neither.
    """

    state: Literal["holds", "slips"]
    direction: str | None
    roller: str | None
    value: float | None
    by_roller: dict[str, float | None]


def critical(
    statics: Statics,
    friction: float | WrapFriction,
    change: str,
    *,
    tensioner: TakeUp = "locked",
    told: frozenset[str] = EVERYTHING,
) -> Critical:
    """Return where the first roller slips as one thing changes from what it is today, or the last one stops.

    All preloads change by the same amount; the value is their mean. Every way ends where a span goes slack.
    """
    press = statics.press
    forces_N = np.array([part.force_N for part in press.tensioners.values()])
    # Tensions are linear in preload, load and speed squared.
    slopes = {
        "preload": statics.by_preload.sum(axis=1),
        "load": statics.by_load_N,
        "speed": speed_shift_kg_m(statics, tensioner),
    }
    today_N = statics.given_N + statics.by_preload @ forces_N + statics.by_load_N
    today_N = today_N + press.speed_m_s**2 * slopes["speed"]
    if change == "friction":
        return _by_friction(SlipTable(press, today_N, friction, told=told))
    slope = slopes[change]
    now = {"preload": forces_N.mean() if forces_N.size else 0.0, "load": 1.0, "speed": press.speed_m_s**2}[
        change
    ]
    least = now - forces_N.min(initial=now) if change == "preload" else 0.0
    with np.errstate(divide="ignore"):
        # By how much until each span goes slack that is not.
        amounts = -today_N / np.where((slope != 0.0) & (today_N > 0.0), slope, np.nan)
    ends = {
        "falls": max(least, now + np.nanmax(np.where(amounts < 0.0, amounts, -np.inf), initial=-np.inf)),
        "rises": now + np.nanmin(np.where(amounts > 0.0, amounts, np.inf), initial=np.inf),
    }
    here, more = contacts_of(press, today_N), contacts_of(press, slope)
    pulls = [np.abs(one.downstream_N - one.upstream_N) for one in (here, more)]
    size_N = np.maximum(here.upstream_N, here.downstream_N)
    idle = (pulls[0] <= _NO_TORQUE * size_N) & (
        pulls[1] <= _NO_TORQUE * (np.abs(more.upstream_N) + np.abs(more.downstream_N))
    )

    def reserve_N(amount: npt.ArrayLike) -> FloatArray:
        by = np.asarray(amount, dtype=np.float64)[..., np.newaxis] - now
        there = here._replace(
            upstream_N=here.upstream_N + by * more.upstream_N,
            downstream_N=here.downstream_N + by * more.downstream_N,
        )
        left_N = there.slack_N * np.expm1(there.exponent(friction, told)) - there.pull_N
        return np.where(idle, np.inf, left_N)

    def along(way: str) -> FloatArray:
        end = ends[way]
        steps = _PLACES * (end - now) if np.isfinite(end) else _PLACES[:-1] / (1.0 - _PLACES[:-1])
        return np.asarray(now + (steps if np.isfinite(end) else max(now, 1.0) * steps))

    def crossing(way: str, margin: Callable[[FloatArray], FloatArray]) -> float | None:
        """Return where a margin first changes its sign on a way, as what is changed."""
        places = along(way)
        signs = margin(reserve_N(places)) >= 0.0
        changed = np.flatnonzero(signs != signs[0])
        if not changed.size:
            return None
        bracket = places[changed[0] - 1], places[changed[0]]
        root = brentq(lambda one: float(margin(reserve_N(one))), *bracket, xtol=1e-12, rtol=1e-14)
        return float(np.sqrt(root)) if change == "speed" else float(root)

    reserve, names = reserve_N(now), here.roller.tolist()
    slips, usual = reserve < 0.0, _USUAL[change]
    ways = [_OTHER[usual], usual] if slips.any() else [usual, _OTHER[usual]]
    found = ((way, crossing(way, lambda left_N: left_N.min(axis=-1))) for way in ways)
    way, value = next(((way, one) for way, one in found if one is not None), (None, None))
    by_roller = {
        name: crossing((way or ways[0]) if slips.any() == is_in else usual, itemgetter((..., i)))
        for i, (name, is_in) in enumerate(zip(names, slips, strict=True))
    }
    first = None
    if value is not None:
        amount = value**2 if change == "speed" else value
        first = names[int(np.argmin(np.abs(reserve_N(amount))))]
    return Critical("slips" if slips.any() else "holds", way, first, value, by_roller)


def _by_friction(slip: SlipTable) -> Critical:
    """Return where slip begins or ends as all coefficients change in proportion."""
    grips = slip.contacts.pull_N > _NO_TORQUE * (slip.contacts.slack_N + slip.contacts.pull_N)
    needed = {
        name: float(mu) if grip and np.isfinite(mu) else None
        for name, mu, grip in zip(slip.rollers, slip.mu_required, grips, strict=True)
    }
    state: Literal["holds", "slips"] = "slips" if (slip.utilisation > 1.0).any() else "holds"
    if not grips.any():
        return Critical(state, None, None, None, needed)
    first = slip.rollers[int(np.argmax(np.where(grips, slip.log, 0.0)))]
    if needed[first] is None:  # no coefficient holds a belt that has lifted off
        return Critical(state, None, None, None, needed)
    return Critical(state, "falls" if state == "holds" else "rises", first, needed[first], needed)


def slip_margins(answer: PressAnswer) -> dict[str, Any]:
    """Return which roller is nearest to slip, and what would make the first one slip or the last one stop, as data."""
    model, rollers, use = answer.model, answer.slip.rollers, answer.slip.utilisation[0]
    statics = solve_statics(model.as_operated, closure=model.problem.closure)
    told: dict[str, Any] = {}
    for change, words in CHANGES.items():
        # What a higher speed does is the belts' mass, whether or not it matters at this one.
        tensioner = take_up(model.effects | ({"belt-inertia"} if change == "speed" else set()))
        found = critical(statics, model.problem.friction, change, tensioner=tensioner, told=model.told)
        told[change] = found._asdict() | {"unit": words.rpartition("[")[2].rstrip("]")}
    return {
        "first_to_slip": rollers[int(np.argmax(use))] if use.any() else None,
        "slips": [name for name, share in zip(rollers, use, strict=True) if share > 1.0],
        "critical": told,
    }
