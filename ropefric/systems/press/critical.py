"""What has to change until a roller slips: preload, speed, load or friction.

Tensions are linear in preload, load and speed squared, but for belts between fixed centres, whose level follows from
their length at each point of the way. So the change is a root of the reserve of friction along the way.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import SolverError
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.centres import at_kept_lengths_N
from ropefric.systems.press.slip import NO_TORQUE, SlipTable, contacts_of
from ropefric.systems.press.statics import Statics, TakeUp, speed_shift_kg_m
from ropefric.systems.roots import roots_of_cases

CHANGES = {
    "preload": "all preloads fall together [N]",
    "speed": "speed of the belts rises [m/s]",
    "load": "all load torques rise together [factor]",
    "friction": "average coefficient over the roller's wrap falls [-]",
}
"""Settings that may be changed until a roller slips."""

_USUAL = {"preload": "falls", "speed": "rises", "load": "rises", "friction": "falls"}
"""The way in which slip is looked for first."""
_OTHER = {"falls": "rises", "rises": "falls"}

_PLACES = np.concatenate([np.linspace(0.0, 1.0, 129)[:-1], 1.0 - 0.5 ** np.arange(8.0, 41.0), [1.0]])
"""Where the reserve of friction is looked at on the way from today to the end."""


_MAX_STEPS = 100
_ROUNDING = 1e-8
"""Changes of a coefficient below this that no longer fall are what rounding leaves of a stiff belt's length."""


class Critical(NamedTuple):
    """The change from the present state to the first slip or, if rollers slip already, to the end of the last one.

    `by_roller` has of each roller that holds where it slips on that way (on the usual one where others slip), of each
    that slips where it stops; None where it does neither.
    """

    state: Literal["holds", "slips"]
    direction: str | None
    roller: str | None
    value: float | None
    by_roller: dict[str, float | None]


@dataclass(frozen=True, kw_only=True)
class _Change:
    """The tensions as one setting changes from what it is now: linear, but for belts between fixed centres."""

    statics: Statics
    friction: float | WrapFriction
    name: str
    tensioner: TakeUp
    regressors: frozenset[str]
    now: float
    linear_N: FloatArray
    slope: FloatArray

    def tension_N(self, amount: npt.ArrayLike, start_N: FloatArray | float = 0.0) -> FloatArray:
        """Return T' of all spans, shape (..., n_spans); NaN where no tensions keep the lengths of fixed belts."""
        press, by = self.statics.press, np.asarray(amount, dtype=np.float64) - self.now
        pretensions_N = press.preload_N[len(press.tensioners) :]
        v_squared = (press.speed_m_s**2 + by * (self.name == "speed")) * (self.tensioner != "floating")
        return at_kept_lengths_N(
            press,
            self.statics.by_preload,
            self.linear_N + by[..., np.newaxis] * self.slope,
            circling_N=np.multiply.outer(v_squared, press.density_kg_m),
            friction=self.friction,
            regressors=self.regressors,
            pretension_N=pretensions_N + by[..., np.newaxis] * (self.name == "preload"),
            start_N=start_N,
            strict=False,
        )

    def followed(self) -> Callable[[FloatArray], FloatArray]:
        """Return `tension_N` as a function that begins each search where its last one ended."""
        start_N: FloatArray | float = 0.0

        def tension_N(amount: FloatArray) -> FloatArray:
            nonlocal start_N
            found_N = self.tension_N(amount, start_N)
            start_N = np.nan_to_num(
                found_N - self.linear_N - (amount - self.now)[..., np.newaxis] * self.slope
            )
            return found_N

        return tension_N

    @cached_property
    def idle(self) -> BoolArray:
        """Return which rollers carry no torque all the way, shape (n_rollers,)."""
        here, more = (contacts_of(self.statics.press, one) for one in (self.linear_N, self.slope))
        largest_N = np.maximum(here.upstream_N, here.downstream_N)
        sizes = np.abs(more.upstream_N) + np.abs(more.downstream_N)
        return np.asarray((here.pull_N <= NO_TORQUE * largest_N) & (more.pull_N <= NO_TORQUE * sizes))

    def reserve_N(self, tension_N: FloatArray) -> FloatArray:
        """Return the friction that is left on each roller, shape (..., n_rollers); inf where it carries no torque."""
        lost = np.isnan(tension_N).any(axis=-1, keepdims=True)
        there = contacts_of(self.statics.press, np.where(lost, 1.0, tension_N))
        left_N = there.slack_N * np.expm1(there.exponent(self.friction, self.regressors)) - there.pull_N
        return np.where(lost, np.nan, np.where(self.idle, np.inf, left_N))

    def _end(self, way: str) -> float:
        """Return where the way ends: at no load, speed or preload, or where a span goes slack that is not."""
        press, today_N = self.statics.press, self.tension_N(self.now)
        taut, sign = today_N > 0.0, 1.0 if way == "rises" else -1.0
        with np.errstate(divide="ignore"):
            amounts = -sign * today_N / np.where((self.slope != 0.0) & taut, self.slope, np.nan)
        most = np.inf
        if way == "falls":
            most = self.now if self.name != "preload" else press.preload_N.min(initial=self.now)
        elif press.fixed_belts:  # no elastic belt is pulled to twice its length
            most = min(belt.axial_stiffness_N or np.inf for belt in press.fixed_belts)
        far = min(np.nanmin(np.where(amounts > 0.0, amounts, np.inf), initial=np.inf), most)
        far = self._to_slack(far, most, sign, taut) if press.fixed_belts else far
        return float(self.now + sign * far)

    def _to_slack(self, far: float, most: float, sign: float, taut: BoolArray) -> float:
        """Return how far the way goes until a span goes slack, `most` at most, from that of the linear tensions on."""
        tension_N = self.followed()

        def lowest_N(far: float) -> float:
            lowest = tension_N(np.array(self.now + sign * far))[taut].min()
            return -1.0 if np.isnan(lowest) else float(lowest)

        near = 0.0
        while (lowest := lowest_N(far)) > 0.0 and far < most:
            near, far = far, min(_FURTHER * far, most)
        return far if lowest > 0.0 else float(brentq(lowest_N, near, far, xtol=1e-9 * far, rtol=1e-9))

    def _margins_N(self, tension_N: FloatArray) -> FloatArray:
        """Return the reserve of each roller and the least of them, shape (..., n_rollers + 1)."""
        left_N = self.reserve_N(tension_N)
        return np.append(left_N, left_N.min(axis=-1, keepdims=True), axis=-1)

    def crossings(self, way: str) -> FloatArray:
        """Return where each margin first changes its sign on the way, shape (n_rollers + 1,); NaN where it does not."""
        end = self._end(way)
        far = max(self.now, 1.0) * (_PLACES[:-1] / (1.0 - _PLACES[:-1]))
        places = self.now + (_PLACES * (end - self.now) if np.isfinite(end) else far)
        margins_N = self._margins_N(self.tension_N(places))
        known = int(np.argmax(np.append(np.isnan(margins_N).any(axis=-1), True)))
        signs = margins_N[:known] >= 0.0
        changed = (signs != signs[:1]).any(axis=0)
        found = np.full(changed.size, np.nan)
        if changed.any():
            which, after = np.flatnonzero(changed), np.argmax(signs != signs[:1], axis=0)[changed]
            low, high = places[after - 1], places[after]
            tension_N = self.followed()

            def margin_N(amounts: FloatArray) -> FloatArray:
                # Where no tensions keep the lengths, a roller has slipped before.
                own_N = self._margins_N(tension_N(amounts))[np.arange(which.size), which]
                return np.nan_to_num(own_N, nan=-1.0, posinf=np.inf)

            roots = roots_of_cases(margin_N, low, high)
            # A margin that rounding leaves without a change of sign has its root at the nearer end.
            ends_N = np.abs(margins_N[[after - 1, after], which])
            found[changed] = np.where(np.isnan(roots), np.where(ends_N[0] < ends_N[1], low, high), roots)
        return found

    def shown(self, amount: float) -> float | None:
        """Return the setting as people know it, the speed and not its square; None where there is none."""
        if np.isnan(amount):
            return None
        return float(np.sqrt(amount) if self.name == "speed" else amount)


_FURTHER = 1.25
"""Beyond the slack of the linear tensions, step by step, where that of kept lengths is searched for."""


def critical(
    statics: Statics,
    friction: float | WrapFriction,
    change: str,
    *,
    tensioner: TakeUp = "locked",
    regressors: frozenset[str] = EVERYTHING,
) -> Critical:
    """Return where the first roller slips as one thing changes from what it is today, or the last one stops.

    All preloads change by the same amount; the value is their mean. Every way ends where a span goes slack.
    """
    press = statics.press
    slopes = {
        "preload": statics.by_preload.sum(axis=1),
        "load": statics.by_load_N,
        "speed": speed_shift_kg_m(statics, tensioner),
    }
    linear_N = statics.given_N + statics.by_preload @ press.preload_N + statics.by_load_N
    linear_N = linear_N + press.speed_m_s**2 * slopes["speed"]
    if change == "friction":
        return _by_friction(statics, friction, linear_N, tensioner, regressors)
    preload_N = float(press.preload_N.mean()) if press.preload_N.size else 0.0
    now = {"preload": preload_N, "load": 1.0, "speed": press.speed_m_s**2}[change]
    path_of = _Change(
        statics=statics,
        friction=friction,
        name=change,
        tensioner=tensioner,
        regressors=regressors,
        now=now,
        linear_N=linear_N,
        slope=slopes[change],
    )
    names = [roller.name for roller in press.rollers]
    slips, usual = path_of.reserve_N(path_of.tension_N(now)) < 0.0, _USUAL[change]
    ways = [_OTHER[usual], usual] if slips.any() else [usual, _OTHER[usual]]
    crossings = cache(path_of.crossings)
    way = next((one for one in ways if not np.isnan(crossings(one)[-1])), None)
    value = np.nan if way is None else crossings(way)[-1]
    stops, usually = crossings(way or ways[0]), crossings(usual)
    each = np.where(slips == slips.any(), stops[:-1], usually[:-1])
    first = (
        None if way is None else names[int(np.argmin(np.abs(path_of.reserve_N(path_of.tension_N(value)))))]
    )
    by_roller = dict(zip(names, map(path_of.shown, each.tolist()), strict=True))
    return Critical("slips" if slips.any() else "holds", way, first, path_of.shown(value), by_roller)


def _grips(logs: FloatArray) -> FloatArray:
    """Return the shares of the friction that are needed, 1 where no share of it is enough or none is needed."""
    return np.where(np.isfinite(logs) & (logs > 0.0), logs, 1.0)


def _by_friction(
    statics: Statics,
    friction: float | WrapFriction,
    linear_N: FloatArray,
    tensioner: TakeUp,
    regressors: frozenset[str],
) -> Critical:
    """Return where slip begins or ends as all coefficients change in proportion."""
    press = statics.press

    def slip_at(grip: FloatArray | float) -> SlipTable:
        """Return the slip at the tensions for a factor on all coefficients; one for each roller, row by row."""
        rows = np.broadcast_to(linear_N, (*np.shape(grip), len(press.spans)))
        share = np.asarray(grip)[..., np.newaxis] if np.ndim(grip) else grip
        kept_N = at_kept_lengths_N(
            press,
            statics.by_preload,
            rows,
            circling_N=press.speed_m_s**2 * press.density_kg_m * (tensioner != "floating"),
            friction=friction,
            regressors=regressors,
            grip=share,
        )
        return SlipTable(press, kept_N, friction, regressors=regressors)

    slip = slip_at(1.0)
    required, ranks = slip.mu_required, slip.log if slip.exponent.all() else slip.mu_required
    if press.fixed_belts:
        # Where a belt slips over a roller's arc changes its tensions, and these what is needed.
        grips, change = _grips(slip.log), np.inf
        for _ in range(_MAX_STEPS):
            each, before, last = slip_at(grips), grips, change
            grips = _grips(np.diagonal(each.log))
            change = float(np.abs(grips / before - 1.0).max())
            if last <= change < _ROUNDING:
                break
        else:
            raise SolverError(
                "the coefficient at which a roller slips does not settle", code="RF500", key="friction"
            )
        required, ranks = np.diagonal(each.mu_required), grips
    grips_at = slip.contacts.pull_N > NO_TORQUE * (slip.contacts.slack_N + slip.contacts.pull_N)
    needed = {
        name: float(mu) if grip and np.isfinite(mu) else None
        for name, mu, grip in zip(slip.rollers, required, grips_at, strict=True)
    }
    state: Literal["holds", "slips"] = "slips" if (slip.utilisation > 1.0).any() else "holds"
    first = slip.rollers[int(np.argmax(np.where(grips_at, ranks, 0.0)))]
    if needed[first] is None:  # nothing is gripped, or no coefficient holds a belt that has lifted off
        return Critical(state, None, None, None, needed)
    return Critical(state, "falls" if state == "holds" else "rises", first, needed[first], needed)
