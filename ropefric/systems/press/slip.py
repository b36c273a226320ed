"""How near each roller is to gross slip, by the paper's factor and by measures that are 1 at the limit.

At constant speed a belt slips on a whole roller where T'_tight = T'_slack e^M, M = ∫ μ dφ over the wrap. What holds
while it gains speed is in `transient.motion`.
"""

from collections.abc import Callable
from functools import cached_property
from operator import itemgetter
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.checks import checked
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.machine import Press
from ropefric.systems.press.statics import Statics, TakeUp, speed_shift_kg_m

# Below 1 N no wrap stands for the slack side, and the law's angle starts from zero.
LEAST_SLACK_N = 1.0
_LARGEST_EXPONENT = 500.0


class Contacts(NamedTuple):
    """All rollers with what their belts do to them: arrays over rollers, T' at any number of operating points."""

    roller: npt.NDArray[np.str_]
    radius_m: FloatArray
    wrap_angle_rad: FloatArray
    half_thickness_m: FloatArray
    upstream_N: FloatArray
    downstream_N: FloatArray

    @property
    def slack_N(self) -> FloatArray:
        """Return T' on the slack side, shape (..., n_rollers)."""
        return np.minimum(self.upstream_N, self.downstream_N)

    @property
    def pull_N(self) -> FloatArray:
        """Return the friction that is needed, shape (..., n_rollers)."""
        return np.abs(self.downstream_N - self.upstream_N)

    def exponent(
        self,
        friction: float | WrapFriction,
        told: frozenset[str] = EVERYTHING,
        share: float | FloatArray = 1.0,
    ) -> FloatArray:
        """Return M over a share of the wrap from the slack side on, shape (..., n_rollers)."""
        if not isinstance(friction, WrapFriction):
            friction = WrapFriction.constant(float(checked("mu", friction)))
        # A law that looks at nothing is the same at every operating point.
        slack_N = np.maximum(self.slack_N, LEAST_SLACK_N) if friction.law.effects else 1.0
        wrap_rad = self.wrap_angle_rad * share
        exponent = friction.exponent(
            self.radius_m, self.half_thickness_m, wrap_rad, slack_N, told=told, places=1
        )
        bad = ~((exponent >= 0.0) & (exponent < _LARGEST_EXPONENT))
        if bad.any():
            wrong, roller = (np.broadcast_to(one, bad.shape)[bad][0] for one in (exponent, self.roller))
            raise InputError(
                f"M = {wrong:.4g} is more than {_LARGEST_EXPONENT:g}, and e^M no number to reckon with",
                code="RF420",
                key=f"roller {roller}",
                fix="check the coefficient or the law's parameters",
                cases=bad.any(axis=-1),
            )
        return exponent


def contacts_of(press: Press, effective_tension_N: npt.ArrayLike) -> Contacts:
    """Return the contacts of all rollers from T' of all spans, shape (..., n_spans)."""
    tension = np.asarray(effective_tension_N, dtype=np.float64)
    belts = [press.belts_on(roller.name) for roller in press.rollers]
    return Contacts(
        np.array([roller.name for roller in press.rollers]),
        press.radius_m,
        np.array([roller.wrap_angle_rad for roller in press.rollers]),
        np.array([0.5 * sum(belt.thickness_m for belt in on) / len(on) for on in belts]),
        tension @ press.into.T,
        tension @ press.out_of.T,
    )


MEASURES = {
    "utilisation": "required over available friction pull; 0 without torque, 1 at gross slip",
    "log": "share of the friction that is needed (of the wrap that creeps, if μ is constant); 1 at gross slip",
    "mu_required": "average coefficient at which the roller begins to slip",
    "as_printed": "eq. (38): T'_up / (T'_down (e^M - 1)); not 1 at gross slip, and not 0 without torque",
    "as_plotted": "the inverted ratio T'_down / (T'_up (e^M - 1)), which the paper's own statements fit",
}
"""Meaning of each measure of slip."""


class SlipTable:
    """Every measure of slip of every roller, shape (..., n_rollers), from T' of all spans, shape (..., n_spans).

    They are infinite where a belt has lifted off (T' ≤ 0 beside the roller).

    For constant μ and the closures "share" and "equal-torque" utilisation never rises with the preload of all
    tensioners and never falls with the factor on all loads: the pull then is λP with P fixed by the loads, the slack
    tension is S + λs with S > 0 growing with every preload, and λP/(S + λs) grows with λ and falls with S. It does
    not hold for a single load (which may tighten another roller's slack side), nor with the closure "equal" (where
    preload moves load from one driver to the other), nor for a law whose μ falls with the tension.
    """

    def __init__(
        self,
        press: Press,
        effective_tension_N: npt.ArrayLike,
        friction: float | WrapFriction,
        *,
        told: frozenset[str] = EVERYTHING,
    ) -> None:
        self.contacts = contacts_of(press, effective_tension_N)
        self.rollers = tuple(self.contacts.roller.tolist())
        self.exponent = self.contacts.exponent(friction, told)

    @cached_property
    def utilisation(self) -> FloatArray:
        """Return U = (T'_tight − T'_slack) / (T'_slack (e^M − 1))."""
        return self._held(_ratio(self.contacts.pull_N, self.contacts.slack_N * np.expm1(self.exponent)))

    def _held(self, measure: FloatArray) -> FloatArray:
        """Return a measure that is 0 where neither a torque nor friction is there."""
        here = self.contacts
        idle = (self.exponent == 0.0) & (here.slack_N > 0.0) & (here.pull_N <= _NO_TORQUE * here.slack_N)
        return np.where(idle, 0.0, measure)

    @cached_property
    def log(self) -> FloatArray:
        """Return ln(T'_tight/T'_slack)/M."""
        logs = np.log1p(_ratio(self.contacts.pull_N, self.contacts.slack_N))
        return self._held(_ratio(logs, np.broadcast_to(self.exponent, logs.shape)))

    @cached_property
    def mu_required(self) -> FloatArray:
        """Return the coefficient needed."""
        logs = np.log1p(_ratio(self.contacts.pull_N, self.contacts.slack_N))
        return np.asarray(logs / self.contacts.wrap_angle_rad)

    @cached_property
    def as_printed(self) -> FloatArray:
        """Return Λ of eq. (38)."""
        return _ratio(self.contacts.upstream_N, self.contacts.downstream_N * np.expm1(self.exponent))

    @cached_property
    def as_plotted(self) -> FloatArray:
        """Return Λ with the tensions exchanged."""
        return _ratio(self.contacts.downstream_N, self.contacts.upstream_N * np.expm1(self.exponent))

    def of(self, roller: str, measure: str = "utilisation") -> FloatArray:
        """Return one measure of one roller, shape (...)."""
        values: FloatArray = getattr(self, measure)
        return values[..., self.rollers.index(roller)]


def factor_in_motion(
    upstream_N: FloatArray, downstream_N: FloatArray, exponent: FloatArray, arc_force_N: FloatArray
) -> FloatArray:
    """Return Λ of eq. (37): (38) with ρAR²θ''/μ added to both T'; the arc's mass takes the force ρAR²θ'' α."""
    over_mu_N = np.divide(arc_force_N, exponent, out=np.zeros_like(arc_force_N), where=exponent > 0.0)
    return _ratio(upstream_N + over_mu_N, (downstream_N + over_mu_N) * np.expm1(exponent))


def _ratio(above: FloatArray, below: FloatArray) -> FloatArray:
    """Return above/below where below is positive, infinity elsewhere."""
    ratio = np.full(np.shape(below), np.inf)
    np.divide(above, below, out=ratio, where=below > 0.0)
    return ratio


CHANGES = {
    "preload": "preload of all tensioners falls [N]",
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
# A pull this small beside the tension is rounding: the roller carries no torque.
_NO_TORQUE = 1e-9


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
    sizes = (
        np.maximum(here.upstream_N, here.downstream_N),
        np.abs(more.upstream_N) + np.abs(more.downstream_N),
    )
    idle = (here.pull_N <= _NO_TORQUE * sizes[0]) & (more.pull_N <= _NO_TORQUE * sizes[1])

    def reserve_N(amount: npt.ArrayLike) -> FloatArray:
        by = np.asarray(amount, dtype=np.float64)[..., np.newaxis] - now
        there = here._replace(
            upstream_N=here.upstream_N + by * more.upstream_N,
            downstream_N=here.downstream_N + by * more.downstream_N,
        )
        left_N = there.slack_N * np.expm1(there.exponent(friction, told)) - there.pull_N
        return np.where(idle, np.inf, left_N)

    def crossing(way: str, margin: Callable[[FloatArray], FloatArray]) -> float | None:
        """Return where a margin first changes its sign on a path, as the changed value."""
        far = max(now, 1.0) * (_PLACES[:-1] / (1.0 - _PLACES[:-1]))
        places = now + (_PLACES * (ends[way] - now) if np.isfinite(ends[way]) else far)
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
    ranks = slip.log if slip.exponent.all() else slip.mu_required
    first = slip.rollers[int(np.argmax(np.where(grips, ranks, 0.0)))]
    if needed[first] is None:  # nothing is gripped, or no coefficient holds a belt that has lifted off
        return Critical(state, None, None, None, needed)
    return Critical(state, "falls" if state == "holds" else "rises", first, needed[first], needed)
