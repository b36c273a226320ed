"""How near each roller is to gross slip, by the paper's factor and by measures that are 1 at the limit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.errors import SolverError, UnknownNameError
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.contact import Contact
from ropefric.systems.press.grip import Friction, Grip, available_pull_N, available_pull_slope_N, grip_on

__all__ = ["MEASURES", "SlipTable", "slip_table", "utilisation"]

FloatArray = npt.NDArray[np.float64]

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
    """Every measure of slip for every roller; infinite where a belt has lifted off (T' ≤ 0 beside the roller).

    Attributes
    ----------
    rollers : tuple of str
        The rollers, in the order of the last axis.
    utilisation, log, mu_required, as_printed, as_plotted : ndarray, shape (..., n_rollers)
        See `MEASURES`.
    exponent : ndarray, shape (..., n_rollers)
        M = ∫μ dφ over the wrap [-].
    """

    rollers: tuple[str, ...]
    utilisation: FloatArray
    log: FloatArray
    mu_required: FloatArray
    as_printed: FloatArray
    as_plotted: FloatArray
    exponent: FloatArray

    def of(self, roller: str, measure: str = "utilisation") -> FloatArray:
        """Return one measure of one roller, shape (...).

        Raises
        ------
        UnknownNameError
            For a roller or measure that is not there.
        """
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
    `ropefric.systems.press.grip`. It is 0 without torque and exactly 1 at impending gross slip.

    For constant μ and the closures "share" and "equal-torque" it never rises with the preload of all tensioners and
    never falls with the factor on all loads: the pull then is λP with P fixed by the loads, the slack tension is
    S + λs with S > 0 growing with every preload, and λP/(S + λs) grows with λ and falls with S. It does not hold for
    a single load (which may tighten another roller's slack side), nor with the closure "equal" (where preload moves
    load from one driver to the other), nor for a law whose μ falls with the tension.

    Parameters
    ----------
    contacts : sequence of Contact
        The rollers.
    friction : float, ndarray of shape (...) or WrapFriction
        Constant μ, one for all points or one for each, or a law.
    told : frozenset of str
        What of the contact the law is told, see `WrapFriction.exponent`.

    Raises
    ------
    InputError
        As `grip_on`.

    Examples
    --------
    >>> contact = Contact(roller="2", radius_m=0.075, wrap_angle_rad=1.0, half_thickness_m=0.0025,
    ...     upstream_N=np.array([800.0, 800.0]), downstream_N=np.array([800.0, 800.0 * np.exp(1.2)]))
    >>> utilisation([contact], 1.2).round(12).tolist()
    [[0.0], [1.0]]
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
    """Return every measure of slip side by side; arguments and refusals are those of `utilisation`.

    Examples
    --------
    >>> contact = Contact(roller="2", radius_m=0.075, wrap_angle_rad=0.4904, half_thickness_m=0.0025,
    ...     upstream_N=np.array(808.788), downstream_N=np.array(1158.122))
    >>> table = slip_table([contact], 1.2)
    >>> [float(table.of("2", name).round(3)) for name in ("utilisation", "log", "as_printed", "as_plotted")]
    [0.539, 0.61, 0.872, 1.787]
    """
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
    contact: Contact, grip: Grip, required_N: FloatArray, share: FloatArray, pressed: npt.NDArray[np.bool_]
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
