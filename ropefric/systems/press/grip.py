"""What friction can hold on a roller: the limit of the belt element dT/dφ = ρAR²θ̈ − F over the whole wrap.

Counted from the slack side, with a = ρAR²θ̈ towards the tight side and F' = T − ρAR²θ̇², gross slip is

    F'_tight = F'_slack e^M(α) + a ∫₀^α e^(M(α) − M(s)) ds,      M(s) = ∫₀^s μ dφ,

for driven and driving rollers alike; for constant μ it is (37)'s limit with a/μ added where friction brakes the belt
and taken away where it drives it. The friction that this takes is the rise of F' less a α.
"""

from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.contact import Contact

__all__ = ["Friction", "Grip", "available_pull_N", "available_pull_slope_N", "grip_on"]

FloatArray = npt.NDArray[np.float64]
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
    """The friction of one contact.

    Attributes
    ----------
    exponent : ndarray, shape (...) or ()
        M over the whole wrap [-].
    remaining : ndarray, shape (..., n), optional
        M(α) − M(s) at the nodes of the integral above, for a belt that is accelerated.
    """

    exponent: FloatArray
    remaining: FloatArray | None = None


def grip_on(contact: Contact, friction: Friction, *, told: frozenset[str] = EVERYTHING) -> Grip:
    """Return the friction of one contact.

    Parameters
    ----------
    contact : Contact
        Roller and tensions.
    friction : float, ndarray of shape (...) or WrapFriction
        A constant μ, one for all points or one for each, or a law. Its wrap is counted from the angle that stands
        for the slack side's tension, and half the belt's thickness stands for the rope's radius.
    told : frozenset of str
        What of the contact the law is told, see `WrapFriction.exponent`.

    Raises
    ------
    InputError
        If μ is not positive and finite, or the law has no answer or gives no friction.

    Examples
    --------
    >>> contact = Contact(roller="2", radius_m=0.075, wrap_angle_rad=0.5, half_thickness_m=0.0025,
    ...     upstream_N=np.array(800.0), downstream_N=np.array(900.0))
    >>> float(grip_on(contact, 1.2).exponent)
    0.6
    """
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
    """Return M where e^M is a number that means something.

    Raises
    ------
    InputError
        If M is not positive, or so large that floats overflow.
    """
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
    """Return the friction pull at impending gross slip, from the slack side's tension, shape (...) [N].

    Parameters
    ----------
    contact : Contact
        Roller and tensions.
    grip : Grip
        Its friction.
    share : array_like, shape (...)
        Factor on the coefficient [-].

    Examples
    --------
    >>> contact = Contact(roller="2", radius_m=0.075, wrap_angle_rad=0.5, half_thickness_m=0.0025,
    ...     upstream_N=np.array(800.0), downstream_N=np.array(900.0))
    >>> float(available_pull_N(contact, grip_on(contact, 1.2)).round(3))
    657.695
    """
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
