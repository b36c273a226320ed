"""Friction on every roller of a start-up: what gross slip needs, and how near to it a moment is."""

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.slip import available_pull_N, contacts_of, grip_on
from ropefric.systems.press.transient.model import ElasticPress
from ropefric.systems.press.transient.motion import FrictionLimit

_LEAST_GRIP = 1e-7
"""A thousand times what `guards.guards_of` takes for zero, as a share of the tension."""


def friction_limit(
    model: ElasticPress, friction: float | WrapFriction, *, told: frozenset[str] = EVERYTHING
) -> FrictionLimit:
    """Return what gross slip on each roller is governed by."""
    press = model.press
    growth, share = np.empty(len(press.rollers)), np.empty(len(press.rollers))
    spin = np.array([1.0 / roller.radius_m for roller in press.rollers])
    for i, contact in enumerate(contacts_of(press, model.preload_N, angular_acceleration_rad_s2=spin)):
        grip = grip_on(contact, friction, told=told)
        growth[i] = np.exp(grip.exponent)
        if growth[i] - 1.0 < _LEAST_GRIP:
            raise InputError(
                f"roller {press.rollers[i].name} holds the belt by e^(μφ) − 1 = {growth[i] - 1.0:.3g} of its tension:"
                f" a start-up with slip cannot tell less than {_LEAST_GRIP:g} from no friction at all",
                code="RF523",
                key="friction",
                fix="give a larger coefficient or wrap angle, or write slip = false",
            )
        still = float(contact.slack_N) * np.expm1(float(grip.exponent))
        # What the acceleration of 1 m/s² alone adds to the friction that can be borne.
        added = float(available_pull_N(contact, grip)) - still
        arc_N = float(contact.inertia_towards_tight_N) * contact.wrap_angle_rad
        share[i] = 1.0 / (1.0 + added / arc_N) if arc_N else float(grip.exponent) / (growth[i] - 1.0)
    return FrictionLimit(growth=growth, share=share)


def friction_utilisation(
    limit: FrictionLimit,
    *,
    friction_N: FloatArray,
    upstream_N: FloatArray,
    downstream_N: FloatArray,
    arc_force_N: FloatArray,
) -> FloatArray:
    """Return required over available friction of every roller, shape (..., n_rollers) [-].

    U = |F| / (T'_slack (e^M − 1) ± m b'' (1/κ − 1)): 0 without friction, 1 in gross slip, and without acceleration
    the utilisation of `ropefric.systems.press.slip`. Infinite where friction acts on a belt that has lifted off.
    """
    forward = friction_N >= 0.0
    slack_N = np.where(forward, upstream_N, downstream_N)
    towards_N = np.where(forward, arc_force_N, -arc_force_N)
    available_N = slack_N * (limit.growth - 1.0) + towards_N * (1.0 / limit.share - 1.0)
    required_N = np.abs(friction_N)
    ratio = np.where(required_N > 0.0, np.inf, 0.0)
    np.divide(required_N, available_N, out=ratio, where=available_N > 0.0)
    return ratio
