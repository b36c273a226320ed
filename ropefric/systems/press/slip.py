"""How near each roller is to gross slip, by the paper's factor and by measures that are 1 at the limit.

What friction can hold on a roller: the limit of the belt element dT/dφ = ρAR²θ̈ − F over the whole wrap.

Counted from the slack side, with a = ρAR²θ̈ towards the tight side and F' = T − ρAR²θ̇², gross slip is

    F'_tight = F'_slack e^M(α) + a ∫₀^α e^(M(α) − M(s)) ds,      M(s) = ∫₀^s μ dφ,

for driven and driving rollers alike; for constant μ it is (37)'s limit with a/μ added where friction brakes the belt
and taken away where it drives it. The friction that this takes is the rise of F' less a α.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError, SolverError, UnknownNameError
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.machine import Press
from ropefric.systems.press.statics import spans_into, spans_out_of
from ropefric.systems.press.steady import SteadyState


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Contact:
    """A roller with what its belts do to it, at any number of operating points."""

    roller: str
    radius_m: float
    wrap_angle_rad: float
    half_thickness_m: float
    upstream_N: FloatArray
    downstream_N: FloatArray
    inertia_N: FloatArray | float = 0.0

    def flat_part(self, shape: tuple[int, ...], block: slice) -> "Contact":
        """Return a block of the operating points, spread to a shape and counted through its axes in C order."""
        inertia: FloatArray | float = 0.0
        if self.is_accelerated:
            inertia = np.broadcast_to(self.inertia_N, shape).reshape(-1)[block]
        return replace(
            self,
            upstream_N=np.broadcast_to(self.upstream_N, shape).reshape(-1)[block],
            downstream_N=np.broadcast_to(self.downstream_N, shape).reshape(-1)[block],
            inertia_N=inertia,
        )

    @property
    def is_accelerated(self) -> bool:
        """Return whether the belt on the roller gains or loses speed anywhere."""
        return bool(np.any(self.inertia_N))

    @property
    def friction_pull_N(self) -> FloatArray:
        """Return what the roller holds the belt back with, shape (...) [N]; negative where it drives the belt.

        It is the belt's T_out − T_in less what its own mass on the arc takes, from dT/dφ = ρAR²θ̈ − F.
        """
        pull_N = self.downstream_N - self.upstream_N
        return pull_N - self.inertia_N * self.wrap_angle_rad if self.is_accelerated else pull_N

    @property
    def slack_N(self) -> FloatArray:
        """Return T − ρAR²θ̇² on the side that friction pulls less, shape (...) [N]."""
        if self.is_accelerated:
            return np.where(self.friction_pull_N >= 0.0, self.upstream_N, self.downstream_N)
        return np.minimum(self.upstream_N, self.downstream_N)

    @property
    def tight_N(self) -> FloatArray:
        """Return T − ρAR²θ̇² on the other side, shape (...) [N]."""
        if self.is_accelerated:
            return np.where(self.friction_pull_N >= 0.0, self.downstream_N, self.upstream_N)
        return np.maximum(self.upstream_N, self.downstream_N)

    @property
    def inertia_towards_tight_N(self) -> FloatArray | float:
        """Return ρAR²θ̈, counted positive where it adds to the tension from the slack side on [N]."""
        if not self.is_accelerated:
            return 0.0
        return np.where(self.friction_pull_N >= 0.0, self.inertia_N, -np.asarray(self.inertia_N))


def contacts_of(
    press: Press,
    tension_N: npt.ArrayLike,
    *,
    rim_speed_m_s: npt.ArrayLike = 0.0,
    angular_acceleration_rad_s2: npt.ArrayLike = 0.0,
) -> tuple[Contact, ...]:
    """Return the contact of every roller, from tensions that need not be steady."""
    tension = np.asarray(tension_N, dtype=np.float64)
    if tension.ndim == 0 or tension.shape[-1] != len(press.spans):
        raise InputError(
            f"tensions of shape {tension.shape} for {len(press.spans)} spans",
            key="tension_N",
            fix="let the last axis be that of the spans",
        )
    speed, acceleration = (
        np.asarray(value, dtype=np.float64) for value in (rim_speed_m_s, angular_acceleration_rad_s2)
    )
    for name, array in (("tension_N", tension), ("rim_speed_m_s", speed), ("θ̈", acceleration)):
        if not _all_finite(array):
            raise InputError(f"{name} must be finite", key=name)
    by_roller = np.broadcast_to(speed, np.broadcast_shapes(speed.shape, (len(press.rollers),)))
    spin = np.broadcast_to(acceleration, np.broadcast_shapes(acceleration.shape, (len(press.rollers),)))
    into, out_of = spans_into(press), spans_out_of(press)
    contacts = []
    for i, roller in enumerate(press.rollers):
        belts = [belt for belt in press.belts if roller.name in belt.loop]
        density_kg_m = sum(belt.linear_density_kg_m for belt in belts)
        circling_N = density_kg_m * by_roller[..., i] ** 2 if speed.any() else 0.0
        contacts.append(
            Contact(
                roller=roller.name,
                radius_m=roller.radius_m,
                wrap_angle_rad=roller.wrap_angle_rad,
                half_thickness_m=0.5 * sum(belt.thickness_m for belt in belts) / len(belts),
                upstream_N=_sum_of(tension, into[i]) - circling_N,
                downstream_N=_sum_of(tension, out_of[i]) - circling_N,
                inertia_N=density_kg_m * roller.radius_m**2 * spin[..., i] if spin.any() else 0.0,
            )
        )
    return tuple(contacts)


def steady_contacts(
    state: SteadyState, *, angular_acceleration_rad_s2: npt.ArrayLike = 0.0
) -> tuple[Contact, ...]:
    """Return the contact of every roller in a steady run."""
    return contacts_of(
        state.press, state.effective_tension_N, angular_acceleration_rad_s2=angular_acceleration_rad_s2
    )


def _all_finite(array: FloatArray) -> bool:
    # A sum needs no array of its own, which sweeps feel; only where it is not finite the numbers are looked at.
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(array.sum()) or np.isfinite(array).all())


def _sum_of(tension: FloatArray, chosen: FloatArray) -> FloatArray:
    """Return the sum of the chosen spans; of one span a view, which sweeps of a million points feel."""
    first, *others = np.flatnonzero(chosen)
    total = tension[..., first]
    for other in others:
        total = total + tension[..., other]
    return total


Friction: TypeAlias = float | FloatArray | WrapFriction
"""A constant μ, one for each operating point, or a law."""

# Below 1 N no wrap stands for the slack side, and the law's angle starts from zero.
_LEAST_SLACK_N = 1.0
_NODES = 48
_LARGEST_EXPONENT = 500.0


def _graded_rule() -> tuple[FloatArray, FloatArray]:
    """Return nodes in (0, 1) and weights of ∫₀¹, crowded near 0, where a falling μ is steepest."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    u = 0.5 * (nodes + 1.0)
    return u**4, 0.5 * weights * 4.0 * u**3


_FRACTIONS, _WEIGHTS = _graded_rule()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Grip:
    """The friction of one contact."""

    exponent: FloatArray
    remaining: FloatArray | None = None


def grip_on(contact: Contact, friction: Friction, *, told: frozenset[str] = EVERYTHING) -> Grip:
    """Return the friction of one contact."""
    accelerated = contact.is_accelerated
    if isinstance(friction, WrapFriction):
        slack_N = np.maximum(contact.slack_N, _LEAST_SLACK_N)
        law = partial(
            friction.exponent,
            wheel_radius_m=contact.radius_m,
            rope_radius_m=contact.half_thickness_m,
            told=told,
        )
        alpha = contact.wrap_angle_rad
        whole = _usable(law(wrap_angle_rad=alpha, slack_tension_N=slack_N), contact.roller)
        if not accelerated:
            return Grip(exponent=whole)
        reached = law(wrap_angle_rad=alpha * _FRACTIONS, slack_tension_N=slack_N[..., None])
        return Grip(exponent=whole, remaining=whole[..., None] - reached)
    mu = np.asarray(friction, dtype=np.float64)
    bad = ~((mu > 0.0) & (mu < np.inf))
    if bad.any():
        raise InputError(
            f"the friction coefficient is {mu[bad].ravel()[0]:g}; it must be positive and finite", key="mu"
        )
    exponent = _usable(mu * contact.wrap_angle_rad, contact.roller)
    return Grip(
        exponent=exponent, remaining=exponent[..., None] * (1.0 - _FRACTIONS) if accelerated else None
    )


def _usable(exponent: FloatArray, roller: str) -> FloatArray:
    """Return M where e^M is a number that means something."""
    if not ((exponent > 0.0) & (exponent < _LARGEST_EXPONENT)).all():
        wrong = exponent[~((exponent > 0.0) & (exponent < _LARGEST_EXPONENT))].ravel()[0]
        if wrong <= 0.0:
            what = "there is no friction at all"
        else:
            what = f"M = {wrong:.4g} is more than {_LARGEST_EXPONENT:g}, and e^M no number to reckon with"
        raise InputError(
            what,
            code="RF420",
            key=f"roller {roller}",
            fix="check the coefficient or the law's parameters",
        )
    return exponent


def available_pull_N(contact: Contact, grip: Grip, *, share: npt.ArrayLike = 1.0) -> FloatArray:
    """Return the friction pull at impending gross slip, from the slack side's tension, shape (...) [N]."""
    share = np.asarray(share, dtype=np.float64)
    pull_N = contact.slack_N * np.expm1(share * grip.exponent)
    if grip.remaining is None:
        return np.asarray(pull_N)
    swell = np.expm1(share[..., None] * grip.remaining) @ _WEIGHTS
    return np.asarray(pull_N + contact.inertia_towards_tight_N * contact.wrap_angle_rad * swell)


def available_pull_slope_N(contact: Contact, grip: Grip, *, share: npt.ArrayLike) -> FloatArray:
    """Return the derivative of `available_pull_N` by `share`, shape (...) [N]."""
    share = np.asarray(share, dtype=np.float64)
    slope_N = contact.slack_N * grip.exponent * np.exp(share * grip.exponent)
    if grip.remaining is None:
        return np.asarray(slope_N)
    swell = (grip.remaining * np.exp(share[..., None] * grip.remaining)) @ _WEIGHTS
    return np.asarray(slope_N + contact.inertia_towards_tight_N * contact.wrap_angle_rad * swell)


MEASURES = {
    "utilisation": "required over available friction pull; 0 without torque, 1 at gross slip",
    "log": "share of the friction that is needed (of the wrap that creeps, if μ is constant); 1 at gross slip",
    "mu_required": "average coefficient at which the roller begins to slip",
    "as_printed": "eq. (38): T'_up / (T'_down (e^M - 1)); not 1 at gross slip, and not 0 without torque",
    "as_plotted": "the inverted ratio T'_down / (T'_up (e^M - 1)), which the paper's own statements fit",
}
"""What each measure of slip says."""

_MAX_STEPS = 80
_BLOCK = 1 << 15
"""Points worked on at a time: a sweep's intermediate results then stay in the processor's cache."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SlipTable:
    """Every measure of slip for every roller; infinite where a belt has lifted off (T' ≤ 0 beside the roller)."""

    rollers: tuple[str, ...]
    utilisation: FloatArray
    log: FloatArray
    mu_required: FloatArray
    as_printed: FloatArray
    as_plotted: FloatArray
    exponent: FloatArray

    def of(self, roller: str, measure: str = "utilisation") -> FloatArray:
        """Return one measure of one roller, shape (...)."""
        if roller not in self.rollers or measure not in MEASURES:
            raise UnknownNameError(
                f"no measure '{measure}' of a roller '{roller}'",
                fix=f"measures: {', '.join(MEASURES)}; rollers: {', '.join(self.rollers)}",
            )
        values: FloatArray = getattr(self, measure)
        return values[..., self.rollers.index(roller)]


def utilisation(
    contacts: Sequence[Contact], friction: Friction, *, told: frozenset[str] = EVERYTHING
) -> FloatArray:
    """Return required over available friction pull of every roller, shape (..., n_rollers) [-].

    U = (T'_tight − T'_slack) / (T'_slack (e^M − 1)) at constant speed; what an angular acceleration adds is in
    `ropefric.systems.press.slip`. It is 0 without torque and exactly 1 at impending gross slip.

    For constant μ and the closures "share" and "equal-torque" it never rises with the preload of all tensioners and
    never falls with the factor on all loads: the pull then is λP with P fixed by the loads, the slack tension is
    S + λs with S > 0 growing with every preload, and λP/(S + λs) grows with λ and falls with S. It does not hold for
    a single load (which may tighten another roller's slack side), nor with the closure "equal" (where preload moves
    load from one driver to the other), nor for a law whose μ falls with the tension.
    """
    law = friction if isinstance(friction, WrapFriction) else np.asarray(friction, dtype=np.float64)
    own = () if isinstance(law, WrapFriction) else law.shape
    shape = np.broadcast_shapes(own, *(contact.upstream_N.shape for contact in contacts))
    size = int(np.prod(shape))
    by_roller = np.empty((len(contacts), size))
    for start in range(0, size, _BLOCK):
        block = slice(start, start + _BLOCK)
        here = law if isinstance(law, WrapFriction) else _flat_part(law, shape, block)
        for i, contact in enumerate(contacts):
            part = contact.flat_part(shape, block)
            by_roller[i, block] = _utilisation(part, grip_on(part, here, told=told))
    return np.moveaxis(by_roller.reshape(len(contacts), *shape), 0, -1)


def slip_table(
    contacts: Sequence[Contact], friction: Friction, *, told: frozenset[str] = EVERYTHING
) -> SlipTable:
    """Return every measure of slip side by side; arguments and refusals are those of `utilisation`."""
    columns = [_measures(contact, grip_on(contact, friction, told=told)) for contact in contacts]
    stacked = {name: _stacked([column[name] for column in columns]) for name in columns[0]}
    return SlipTable(rollers=tuple(contact.roller for contact in contacts), **stacked)


def _flat_part(mu: FloatArray, shape: tuple[int, ...], block: slice) -> FloatArray:
    return mu if mu.ndim == 0 else np.broadcast_to(mu, shape).reshape(-1)[block]


def _measures(contact: Contact, grip: Grip) -> dict[str, FloatArray]:
    exponent = grip.exponent
    # (37) shifts both tensions by ρAR²θ̈/μ on every roller, which is right for a driven one only.
    shift_N = contact.inertia_N * contact.wrap_angle_rad / exponent
    upstream_N, downstream_N = contact.upstream_N + shift_N, contact.downstream_N + shift_N
    share = _needed_share(contact, grip)
    return {
        "utilisation": _utilisation(contact, grip),
        "log": share,
        "mu_required": share * exponent / contact.wrap_angle_rad,
        "as_printed": _ratio(upstream_N, downstream_N * np.expm1(exponent)),
        "as_plotted": _ratio(downstream_N, upstream_N * np.expm1(exponent)),
        "exponent": np.broadcast_to(exponent, np.shape(share)),
    }


def _utilisation(contact: Contact, grip: Grip) -> FloatArray:
    required_N, available_N = np.abs(contact.friction_pull_N), available_pull_N(contact, grip)
    if contact.is_accelerated:
        # Where T' falls below zero before the limit is reached, the belt lifts off and friction ends.
        end_N = contact.slack_N + available_N + contact.inertia_towards_tight_N * contact.wrap_angle_rad
        available_N = np.where((contact.slack_N > 0.0) & (end_N > 0.0), available_N, 0.0)
    return _ratio(required_N, available_N)


def _ratio(above: FloatArray, below: FloatArray) -> FloatArray:
    """Return above/below where below is positive, infinity elsewhere."""
    above, below = np.asarray(above), np.asarray(below)
    if below.min(initial=np.inf) > 0.0:
        return np.asarray(above / below)
    whole = np.full(np.broadcast_shapes(above.shape, below.shape), np.inf)
    np.divide(above, below, out=whole, where=below > 0.0)
    return whole


def _needed_share(contact: Contact, grip: Grip) -> FloatArray:
    """Return the factor on μ at which the roller would begin to slip: ln(T'_tight/T'_slack)/M at constant speed."""
    required_N, slack_N = np.abs(contact.friction_pull_N), contact.slack_N
    pressed = slack_N > 0.0
    share = np.log1p(np.where(pressed, required_N / np.where(pressed, slack_N, 1.0), 0.0)) / grip.exponent
    if contact.is_accelerated:
        pressed = pressed & np.isfinite(_utilisation(contact, grip))
        share = _newton(contact, grip, required_N, share, pressed)
    return np.where(pressed, share, np.inf)


def _newton(
    contact: Contact, grip: Grip, required_N: FloatArray, share: FloatArray, pressed: BoolArray
) -> FloatArray:
    """Return the root; the available pull is convex in the share, so after one step all others go one way."""
    for _ in range(_MAX_STEPS):
        excess_N = available_pull_N(contact, grip, share=share) - required_N
        slope_N = available_pull_slope_N(contact, grip, share=share)
        step = np.where(pressed, excess_N / np.where(pressed, slope_N, 1.0), 0.0)
        share = share - step
        # Newton's method squares the error: after a step this small nothing is left to gain.
        if (np.abs(step) <= 1e-10 * (1.0 + share)).all():
            return share
    raise SolverError(
        f"roller {contact.roller}: no coefficient holds the accelerated belt",
        key=f"roller {contact.roller}",
        fix="check the angular acceleration, in rad/s²",
    )


def _stacked(columns: Sequence[FloatArray]) -> FloatArray:
    by_roller = np.empty((len(columns), *np.broadcast_shapes(*(np.shape(column) for column in columns))))
    for i, column in enumerate(columns):
        by_roller[i] = column
    return np.moveaxis(by_roller, 0, -1)
