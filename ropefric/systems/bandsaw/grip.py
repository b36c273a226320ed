"""Whether the driving wheel can pull the blade: the tensions of both sides against the wrap integral."""

import numpy as np

from ropefric.friction.condition import FloatArray
from ropefric.systems.bandsaw.span import Span
from ropefric.systems.friction import WrapFriction

__all__ = ["grip_utilisation"]


def grip_utilisation(
    tight: Span,
    slack: Span,
    friction: WrapFriction,
    *,
    wheel_radius_m: FloatArray,
    half_thickness_m: float,
    wrap_angle_rad: float,
) -> FloatArray:
    """Return required over available friction pull of the driving wheel, shape (m,) [-]; 1 at gross slip.

    U = (F_tight − F_slack) / ((F_slack − ρAv²)(e^M − 1)): what keeps the blade on its circle presses nothing.

    Parameters
    ----------
    tight, slack : Span
        The two sides, m cases each.
    friction : WrapFriction
        Between blade and wheel; half the blade's thickness stands for the rope's radius.
    wheel_radius_m : ndarray, shape (m,)
        R [m].
    half_thickness_m, wrap_angle_rad : float
        Half the blade's thickness [m], and the wrap on the wheel [rad].

    Returns
    -------
    ndarray, shape (m,)
        Infinite where the slack side presses nothing.

    Examples
    --------
    >>> tight, slack = (Span(free_span_m=1.6, linear_density_kg_m=0.6, preload_N=3412, pull_N=pull)
    ...     for pull in (105.5, -105.5))
    >>> grip_utilisation(tight, slack, WrapFriction.constant(0.2), wheel_radius_m=np.array([0.35]),
    ...     half_thickness_m=4.5e-4, wrap_angle_rad=3.14).round(4).tolist()
    [0.073]
    """
    # Part by part: a small pull is lost in the difference of two large tensions.
    needed_N = (
        (tight.preload_N - slack.preload_N)
        + (tight.pull_N - slack.pull_N)
        + (_wheels_N(tight) - _wheels_N(slack))
    )
    pressing_N = slack.net_tension_N
    touching = pressing_N > 0.0
    if not touching.any():
        return np.where(needed_N > 0.0, np.inf, 0.0)
    exponent = friction.exponent(
        wheel_radius_m=wheel_radius_m,
        rope_radius_m=half_thickness_m,
        wrap_angle_rad=wrap_angle_rad,
        slack_tension_N=np.where(touching, pressing_N, 1.0),
    )
    # Both times e^{−M}: e^M itself may be beyond floats.
    available_N = np.where(touching, -pressing_N * np.expm1(-exponent), 0.0)
    share: FloatArray = np.divide(
        needed_N * np.exp(-exponent), available_N, out=np.full_like(needed_N, np.inf), where=available_N > 0.0
    )
    return share


def _wheels_N(span: Span) -> FloatArray:
    """Return κ ρA v_w² [N]."""
    return span.mounting_factor * span.linear_density_kg_m * span.wheel_speed_m_s**2
