"""The assembled equations against the paper's own, written out span by span, and against the energies' gradients."""

import math

import numpy as np
import pytest

from ropefric.errors import InputError
from ropefric.systems.press.transient.motion import (
    MOVING,
    ElasticPress,
    elastic_energy_J,
    kinetic_energy_J,
    standstill_tension_N,
)


def written_out(kit, press, model, *, way_m, speed_m_s, travel_m, travel_speed, v, g):
    """T of spans 1-14 and all accelerations, from the page's list of elongations; arrays count from roller 1."""
    s, ds = dict(enumerate(way_m, 1)), dict(enumerate(speed_m_s, 1))
    cb, cg = math.cos(kit.beta), math.cos(kit.gamma)

    def stretch(s, up, down):
        e = {i: s[i + 1] - s[i] for i in (1, 4, 5, 6, 7, 8)}
        e |= {2: s[3] - s[2] - up, 3: s[4] - s[3] - up * cb, 9: s[1] - s[9], 10: s[10] - s[9]}
        e |= {11: s[11] - s[10], 12: s[12] - s[11], 13: s[13] - s[12] - down * cg, 14: s[5] - s[13] - down}
        return e

    EA, eta = press.belts[0].axial_stiffness_N, press.belts[0].damping_s
    e, de = stretch(s, *travel_m), stretch(ds, *travel_speed)
    count = {i: 2 if 5 <= i <= 8 else 1 for i in range(1, 15)}
    T0 = dict(enumerate(model.preload_N, 1))
    T = {i: T0[i] + count[i] * EA / kit.lengths_m[i] * (e[i] + eta * de[i]) for i in e}
    into = {i: [i - 1] for i in range(2, 10)} | {5: [4, 14], 11: [11], 12: [12], 13: [13]}
    out = {i: [i] for i in range(2, 9)} | {9: [9, 10], 11: [12], 12: [13], 13: [14]}
    acceleration = {}
    for i in into:
        roller = press.rollers[i - 1]
        R, belts = roller.radius_m, 2 if 5 <= i <= 9 else 1
        J = roller.inertia_kg_m2 + belts * 15.0 * R**3 * roller.wrap_angle_rad
        torque = R * (sum(T[j] for j in out[i]) - sum(T[j] for j in into[i])) - g * roller.torque_N_m
        acceleration[i] = R * torque / J
    k1, C1, m, c = 2e4, 500.0, 121.0, 15.0 * v**2
    x = [0.03 + part for part in travel_m]
    pulls = [T[2] - c + (T[3] - c) * cb - 2000.0, T[14] - c + (T[13] - c) * cg - 2000.0]
    travel = [(pull - C1 * dx - k1 * at) / m for pull, at, dx in zip(pulls, x, travel_speed, strict=True)]
    return T, acceleration, travel


def test_the_papers_press_span_by_span(kit, random_state):
    press = kit.paper()
    problem = kit.problem(press)
    motion, model = problem.motion, problem.model
    rng = random_state
    names = [span.name for span in press.spans]
    assert names == [str(i) for i in range(1, 15)]
    for _ in range(5):
        n_q = motion.n_coordinates
        y = np.concatenate([1e-3 * rng.standard_normal(n_q), 0.1 * rng.standard_normal(n_q)])
        v, a, g = rng.uniform(0.1, 1.0, 3)
        u = np.zeros(motion.n_inputs)
        u[:5] = 1.0, g, v, a, v**2
        w = np.concatenate([y, u])
        way, rim = motion.relative_way_m @ w, motion.rim_speed_m_s @ w
        assert way[0] == way[9] == 0.0
        np.testing.assert_allclose(rim[[0, 9]], v, rtol=1e-15)
        T, acceleration, travel = written_out(
            kit, press, model, way_m=way, speed_m_s=rim, travel_m=motion.travel_m @ w,
            travel_speed=motion.travel_speed_m_s @ w, v=v, g=g,
        )  # fmt: skip
        np.testing.assert_allclose(motion.tension_N @ w, [T[i] for i in range(1, 15)], rtol=1e-12)
        mine = motion.rim_acceleration_m_s2 @ w
        np.testing.assert_allclose(
            mine[[i - 1 for i in acceleration]], list(acceleration.values()), rtol=1e-9
        )
        np.testing.assert_allclose(mine[[0, 9]], a)
        np.testing.assert_allclose(motion.travel_acceleration_m_s2 @ w, travel, rtol=1e-9)
        np.testing.assert_allclose((motion.derivative @ w)[:n_q], y[n_q:])


def test_undamped_forces_are_the_gradient_of_the_energy(kit, random_state):
    problem = kit.problem(kit.paper(), effects={"arc-inertia"})
    motion = problem.motion
    n_q = motion.n_coordinates
    u = np.zeros(motion.n_inputs)
    u[0] = 1.0
    q, h = 1e-5 * random_state.standard_normal(n_q), 1e-6  # small enough that no span goes slack

    def energy(q, dq):
        w = np.concatenate([q, dq, u])
        return float(elastic_energy_J(motion, w)), float(kinetic_energy_J(motion, w))

    mass = np.array([2.0 * energy(q, row)[1] for row in np.eye(n_q)])
    rows = h * np.eye(n_q)
    force = [(energy(q - row, 0 * q)[0] - energy(q + row, 0 * q)[0]) / (2.0 * h) for row in rows]
    acceleration = (motion.derivative @ np.concatenate([q, 0 * q, u]))[n_q:]
    np.testing.assert_allclose(mass * acceleration, force, rtol=1e-6, atol=1e-2)


def test_standstill_is_at_rest_and_balances_the_tensioners(kit):
    press = kit.paper()
    preload = standstill_tension_N(press)
    upper = (2e4 * 0.03 + 2000.0) / (1.0 + math.cos(kit.beta))
    lower = (2e4 * 0.03 + 2000.0) / (1.0 + math.cos(kit.gamma))
    np.testing.assert_allclose(preload, [upper] * 4 + [upper + lower] * 4 + [upper] + [lower] * 5, rtol=1e-14)
    problem = kit.problem(press)
    assert np.abs(problem.start).max() < 1e-15
    assert np.abs(problem.rate(problem.start, problem.inputs.at(0.0))).max() < 1e-9


def test_what_is_left_out_is_absent(kit):
    for part in sorted(MOVING):
        model = ElasticPress(kit.paper(), effects=MOVING - {part})
        whole = ElasticPress(kit.paper())
        fields = {"arc-inertia": "arc_mass_kg", "belt-damping": "damping_N_s_m",
                  "tensioner-damping": "tensioner_damping_N_s_m", "belt-inertia": "density_kg_m"}  # fmt: skip
        for name, field in fields.items():
            assert getattr(model, field).any() == (name != part), part
            assert getattr(whole, field).all(), part
        assert model.arc_mass_kg[5] == 0.0 or model.arc_mass_kg[5] == pytest.approx(
            2 * 15 * 0.2 * math.radians(131.8)
        ), part


def test_missing_data_is_named(paper_press):
    with pytest.raises(InputError) as caught:
        ElasticPress(paper_press)
    keys = {problem.key for problem in caught.value.problems}
    assert {"belts.upper.axial_stiffness_N", "belts.lower.span_lengths_m", "rollers.2.inertia_kg_m2"} <= keys
    assert "rollers.3.tensioner.mass_kg" in keys
    assert "rollers.1.inertia_kg_m2" not in keys


def test_an_unsettled_standstill_is_refused(kit):
    with pytest.raises(InputError, match="slack at rest"):
        ElasticPress(kit.small(force_N=0.0, k1=0.0))
