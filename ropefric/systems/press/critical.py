"""What has to change until a roller slips: preload, speed, load or friction.

Tensions are linear in preload, load and speed squared, but for belts between fixed centres, whose level follows from
their length at each point of the way. So the change is a root of the reserve of friction along the way.
"""

from typing import Literal, NamedTuple

import numpy as np
from scipy.optimize import brentq

from ropefric.arrays import FloatArray
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.centres import at_kept_lengths_N
from ropefric.systems.press.slip import NO_TORQUE, contacts_of
from ropefric.systems.press.statics import Statics, TakeUp, speed_shift_kg_m

CHANGES = {
    "preload": "all preloads fall together [N]",
    "speed": "speed of the belts rises [m/s]",
    "load": "all load torques rise together [factor]",
    "friction": "average coefficient over the roller's wrap falls [-]",
}
"""Settings that may be changed until a roller slips."""

_WAYS = {"preload": "falls", "speed": "rises", "load": "rises", "friction": "falls"}
"""The way in which slip is looked for; where rollers slip already, they stop on the other."""
_OTHER = {"falls": "rises", "rises": "falls"}

_PLACES = np.concatenate([np.linspace(0.0, 1.0, 129)[:-1], 1.0 - 0.5 ** np.arange(8.0, 41.0)])
"""Where the reserve of friction is looked at on the way from today to the end."""
_AT_ONCE = 16
_LARGEST = 700.0
"""Exponent beyond which e^M is no float: the belt is as good as tied to the roller."""


class Critical(NamedTuple):
    """The change from the present state to the first slip or, if rollers slip already, to the end of the last one."""

    state: Literal["holds", "slips"]
    direction: str | None
    roller: str | None
    value: float | None


class _Way(NamedTuple):
    """The tensions as one setting changes from what it is now: linear, but for belts between fixed centres."""

    statics: Statics
    friction: float | WrapFriction
    name: str
    tensioner: TakeUp
    regressors: frozenset[str]
    now: float
    linear_N: FloatArray
    slope: FloatArray

    def at(self, amounts: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the friction that is left on each roller, and M of each; shape (n, n_rollers).

        Nothing is left where no tensions keep the lengths of fixed belts; a roller without torque never slips.
        """
        press, by = self.statics.press, (amounts - self.now)[:, np.newaxis]
        grip = amounts[:, np.newaxis] if self.name == "friction" else 1.0
        v_squared = press.speed_m_s**2 + by * (self.name == "speed")
        tension_N = at_kept_lengths_N(
            press,
            self.statics.by_preload,
            self.linear_N + by * self.slope,
            circling_N=v_squared * (self.tensioner != "floating") * press.density_kg_m,
            friction=self.friction,
            regressors=self.regressors,
            pretension_N=press.preload_N[len(press.tensioners) :] + by * (self.name == "preload"),
            grip=grip,
            strict=False,
        )
        lost = np.isnan(tension_N).any(axis=-1, keepdims=True)
        there = contacts_of(press, np.where(lost, 1.0, tension_N))
        exponent = grip * there.exponent(self.friction, self.regressors)
        left_N = there.slack_N * np.expm1(np.minimum(exponent, _LARGEST)) - there.pull_N
        here, more = (contacts_of(press, one) for one in (self.linear_N, self.slope))
        idle = here.pull_N <= NO_TORQUE * np.maximum(here.upstream_N, here.downstream_N)
        idle &= more.pull_N <= NO_TORQUE * (np.abs(more.upstream_N) + np.abs(more.downstream_N))
        left_N = np.where(lost, -1.0, np.where(idle, np.inf, left_N))
        return left_N, np.broadcast_to(exponent, left_N.shape)

    def least_N(self, amount: float) -> float:
        """Return the least friction that is left on any roller."""
        return float(self.at(np.array([amount]))[0].min())

    def turn(self, way: str) -> float | None:
        """Return the setting at which the least reserve first changes its sign; None where it never does."""
        press, far = self.statics.press, max(self.now, 1.0) * (_PLACES / (1.0 - _PLACES))
        if way == "falls":
            far = _PLACES * (press.preload_N.min(initial=self.now) if self.name == "preload" else self.now)
        places = self.now + far * {"rises": 1.0, "falls": -1.0}[way]
        holds = self.least_N(self.now) >= 0.0
        for begin in range(0, places.size - 1, _AT_ONCE):
            some = places[begin : begin + _AT_ONCE + 1]
            turned = np.flatnonzero((self.at(some)[0].min(axis=-1) >= 0.0) != holds)
            if turned.size:
                low, high = some[turned[0] - 1], some[turned[0]]
                return float(brentq(self.least_N, low, high, xtol=1e-300, rtol=1e-15))
        return None


def critical(
    statics: Statics,
    friction: float | WrapFriction,
    change: str,
    *,
    tensioner: TakeUp = "locked",
    regressors: frozenset[str] = EVERYTHING,
) -> Critical:
    """Return where the first roller slips as one thing changes from what it is today, or the last one stops.

    All preloads change by the same amount, and the value is their mean; all coefficients change in proportion, and the
    value is the average over the roller's wrap.
    """
    press = statics.press
    slopes = {
        "preload": statics.by_preload.sum(axis=1),
        "load": statics.by_load_N,
        "speed": speed_shift_kg_m(statics, tensioner),
        "friction": np.zeros(len(press.spans)),
    }
    preload_N = float(press.preload_N.mean()) if press.preload_N.size else 0.0
    now = {"preload": preload_N, "load": 1.0, "speed": press.speed_m_s**2, "friction": 1.0}
    linear_N = statics.given_N + statics.by_preload @ press.preload_N + statics.by_load_N
    linear_N = linear_N + press.speed_m_s**2 * slopes["speed"]
    one = _Way(statics, friction, change, tensioner, regressors, now[change], linear_N, slopes[change])
    slips = one.least_N(one.now) < 0.0
    way = _OTHER[_WAYS[change]] if slips else _WAYS[change]
    found = one.turn(way)
    if found is None:
        return Critical("slips" if slips else "holds", None, None, None)
    left_N, exponent = one.at(np.array([found]))
    first = int(np.argmin(np.abs(left_N[0])))
    value = {"speed": np.sqrt(found), "friction": exponent[0, first] / press.wrap_angle_rad[first]}.get(
        change, found
    )
    return Critical("slips" if slips else "holds", way, press.rollers[first].name, float(value))
