"""How near each roller is to gross slip, by the paper's factor and by measures that are 1 at the limit.

At constant speed a belt slips on a whole roller where T'_tight = T'_slack e^M, M = ∫ μ dφ over the wrap. What holds
while it gains speed is in `transient.motion`.
"""

from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.systems.checks import checked
from ropefric.systems.friction import EVERYTHING, WrapFriction, refuse_no_ratio
from ropefric.systems.press.machine import Press

# Below 1 N no wrap stands for the slack side, and the law's angle starts from zero.
LEAST_SLACK_N = 1.0
NO_TORQUE = 1e-9
"""A pull this small beside the tension is rounding: the roller carries no torque."""


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
        regressors: frozenset[str] = EVERYTHING,
        share: float | FloatArray = 1.0,
    ) -> FloatArray:
        """Return M over a share of the wrap from the slack side on, shape (..., n_rollers)."""
        if not isinstance(friction, WrapFriction):
            friction = WrapFriction.constant(float(checked("mu", friction)))
        # A law that looks at nothing is the same at every operating point.
        slack_N = np.maximum(self.slack_N, LEAST_SLACK_N) if friction.law.effects else 1.0
        wrap_rad = self.wrap_angle_rad * share
        exponent = friction.exponent(
            self.radius_m, self.half_thickness_m, wrap_rad, slack_N, regressors=regressors, places=1
        )
        largest = np.argmax(exponent) % len(self.roller)
        refuse_no_ratio(exponent, key=f"roller {self.roller[largest]}", places=1)
        return exponent


def contacts_of(press: Press, effective_tension_N: npt.ArrayLike) -> Contacts:
    """Return the contacts of all rollers from T' of all spans, shape (..., n_spans)."""
    tension = np.asarray(effective_tension_N, dtype=np.float64)
    return Contacts(
        np.array([roller.name for roller in press.rollers]),
        press.radius_m,
        press.wrap_angle_rad,
        press.half_thickness_m,
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
        regressors: frozenset[str] = EVERYTHING,
    ) -> None:
        self.contacts = contacts_of(press, effective_tension_N)
        self.rollers = tuple(self.contacts.roller.tolist())
        self.exponent = self.contacts.exponent(friction, regressors)

    @cached_property
    def utilisation(self) -> FloatArray:
        """Return U = (T'_tight − T'_slack) / (T'_slack (e^M − 1))."""
        return self._held(_ratio(self.contacts.pull_N, self.contacts.slack_N * np.expm1(self.exponent)))

    def _held(self, measure: FloatArray) -> FloatArray:
        """Return a measure that is 0 where neither a torque nor friction is there."""
        here = self.contacts
        idle = (self.exponent == 0.0) & (here.slack_N > 0.0) & (here.pull_N <= NO_TORQUE * here.slack_N)
        return np.where(idle, 0.0, measure)

    @cached_property
    def _logs(self) -> FloatArray:
        """Return ln(T'_tight/T'_slack)."""
        return np.log1p(_ratio(self.contacts.pull_N, self.contacts.slack_N))

    @cached_property
    def log(self) -> FloatArray:
        """Return ln(T'_tight/T'_slack)/M."""
        return self._held(_ratio(self._logs, np.broadcast_to(self.exponent, self._logs.shape)))

    @cached_property
    def mu_required(self) -> FloatArray:
        """Return the coefficient needed."""
        return np.asarray(self._logs / self.contacts.wrap_angle_rad)

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
