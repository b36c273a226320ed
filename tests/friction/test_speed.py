"""The closed forms against root finding and quadrature: the same answers, and what each costs."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from ropefric.friction.condition import Conditions
from ropefric.friction.laws import LAWS

THETA = [0.2, -0.2, -0.3, -0.4, 0.05]


def lift_force_N(law, theta, conditions):
    return np.exp(law.log_lift(theta, conditions))


def designs(n):
    rng = np.random.default_rng(11)
    return Conditions(
        wheel_radius_m=rng.uniform(0.02, 0.1, n),
        rope_radius_m=0.005,
        wrap_angle_rad=rng.uniform(1, 12, n),
        end_tension_N=rng.uniform(1.5, 200, n),
    )


def one_by_one(conditions):
    mu_inf, a, b, c, d = THETA
    forces = []
    for r, phi, tension in zip(
        conditions.size_ratio, conditions.wrap_angle_rad, conditions.end_tension_N, strict=True
    ):
        strength = mu_inf * (1 - np.exp(a * r + b))

        def mu(angle, strength=strength):
            return strength * angle**c + d

        def short(angle, mu=mu, tension=tension):
            return quad(mu, 0, angle)[0] - np.log(tension)

        start = brentq(short, 1e-9, 200)
        forces.append(tension * np.exp(quad(mu, start, start + phi)[0]))
    return np.array(forces)


def test_coupled_agrees_with_root_finding_and_quadrature():
    conditions = designs(40)
    assert np.allclose(lift_force_N(LAWS["coupled"], THETA, conditions), one_by_one(conditions), rtol=1e-9)


@pytest.mark.benchmark(group="lift force")
def test_a_million_lift_forces(benchmark):
    conditions = designs(1_000_000)
    forces = benchmark(lift_force_N, LAWS["coupled"], THETA, conditions)
    assert len(forces) == 1_000_000


@pytest.mark.benchmark(group="lift force")
def test_a_hundred_lift_forces_by_root_finding_and_quadrature(benchmark):
    assert len(benchmark(one_by_one, designs(100))) == 100
