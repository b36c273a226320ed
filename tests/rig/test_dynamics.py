"""The second rig's integration against laws, limits, energy and an independent solver."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from thinned import slow

from ropefric.rig.dynamics import Slider, simulate

SPEED, FORCE = 1e-3, 100.0
STIFFNESS = FORCE / SPEED  # one second of climb


def slider(**changed):
    k = STIFFNESS * 1.1
    mass = k / (2 * np.pi * 60.0) ** 2
    ordinary = {
        "stiffness_N_m": k, "mass_kg": mass, "damping_N_s_m": 0.2 * np.sqrt(k * mass), "wheel_kg": 10 * mass,
        "motor_N_m": 10 * k, "motor_damping_N_s_m": 6.0 * np.sqrt(k * mass), "slack_N": 30.0, "wrap_rad": 4.7,
        "mu": 0.3, "a": 0.008, "b": 0.014, "slip_m": 5e-6, "speed_m_s": SPEED, "hold_s": 3.0,
        "profile": ((0.5, 0.0), (0.6, SPEED)), "end_s": 3.0,
    }  # fmt: skip
    return Slider(**(ordinary | changed))


BRISTLES = {"law": "lugre", "b": 0.004, "excess": 0.02, "stribeck_m_s": 5e-3, "bristle_1_m": 1.5e4,
            "bristle_damping_s_m": 5.0, "viscous_s_m": 2.0}  # fmt: skip


STEADY = {
    f"{law} {speed:g}": {
        "law": law, "a": 0.02, "b": 0.01, "profile": ((0.2, 0.0), (0.3, speed)), "end_s": 0.3 + 3e-3 / speed
    } for law in ("ageing", "slip") for speed in (5e-4, 2e-3)
}  # fmt: skip
STIFF = {
    "stiffness_N_m": 3e7, "mass_kg": 1.0, "damping_N_s_m": 3e3, "motor_N_m": 3e9, "motor_damping_N_s_m": 1e5,
    "wheel_kg": 1.0, "a": 0.02, "b": 0.03, "slip_m": 1e-4, "profile": ((0.1, 0.0), (0.1001, SPEED)), "end_s": 0.6,
}  # fmt: skip
VISCOUS = BRISTLES | {"viscous_s_m": 20.0, "b": 0.0, "excess": 0.0}
CHANGED = {"rate and state": {}, "bristles": BRISTLES, "partial": {"partial": ((0.2, 5e-5, 0.01),)},
    "viscous": VISCOUS}  # fmt: skip
SLIDERS = {name: slider(**changed) for name, changed in (CHANGED | {"stiff": STIFF} | STEADY).items()}


@pytest.fixture(scope="module")
def motions():
    """The motions of all, which one integration makes at little more than the cost of one."""
    return dict(zip(SLIDERS, simulate([*SLIDERS.values()]), strict=True))


def by_radau(one, end_s):
    """The same equations, state by state, as plain as they are printed, by an implicit method of scipy's."""

    def motor(t):
        (t0, _), (t1, top) = one.profile
        slope = top / (t1 - t0)
        ramp = min(max(t - t0, 0.0), t1 - t0)
        return 0.5 * slope * ramp**2 + top * max(t - t1, 0.0), slope * ramp

    def rates(t, y):
        x, u, wheel, motion, log_theta, z = y
        theta = np.exp(log_theta)
        v = motion - u if one.law == "lugre" else np.exp(motion)
        if one.law == "lugre":
            g = one.mu + one.b * np.log(1 + one.speed_m_s * theta / one.slip_m)
            g += one.excess * np.exp(-((v / one.stribeck_m_s) ** 2))
            dz = v - one.bristle_1_m * abs(v) * z / g
            mu = one.bristle_1_m * z + one.bristle_damping_s_m * dz + one.viscous_s_m * v
        else:
            strength = (one.mu + one.b * np.log(one.speed_m_s * theta / one.slip_m)) / one.a
            mu, dz = one.a * np.arcsinh(0.5 * np.exp(motion - np.log(one.speed_m_s) + strength)), 0.0
        aged = v * theta / one.slip_m
        d_log = -(aged * np.log(aged)) / theta if one.law == "slip" else (1.0 - abs(aged)) / theta
        pull = one.slack_N * np.expm1(mu * one.wrap_rad)
        way, speed = motor(t)
        du = (pull - one.stiffness_N_m * x - one.damping_N_s_m * u) / one.mass_kg
        turn = u + v
        dturn = (
            one.motor_N_m * (way - wheel) + one.motor_damping_N_s_m * (speed - turn) - pull
        ) / one.wheel_kg
        return [u, du, turn, dturn if one.law == "lugre" else (dturn - du) / v, d_log, dz]

    # The motion that is integrated: the wheel's speed, or the logarithm of the slip speed, which spans 30 decades.
    strength = (one.mu + one.b * np.log(one.speed_m_s * one.hold_s / one.slip_m)) / max(one.a, 1e-9)
    slow = np.log(2.0 * one.speed_m_s * np.sinh(one.start_mu / max(one.a, 1e-9))) - strength
    start_N = one.slack_N * np.expm1(one.start_mu * one.wrap_rad)
    motion = 0.0 if one.law == "lugre" else slow
    start = [start_N / one.stiffness_N_m, 0.0, -start_N / one.motor_N_m, motion, np.log(one.hold_s)]
    with np.errstate(all="ignore"):  # its numerical Jacobian enlarges steps that change nothing without end
        solved = solve_ivp(
    rates, (0.0, end_s), [*start, one.start_mu / one.bristle_1_m], "Radau" if one.law == "slip" else "BDF", rtol=1e-7,
            atol=[1e-12, 1e-11, 1e-12, 1e-11 if one.law == "lugre" else 1e-8, 1e-9, 1e-13], dense_output=True,
        )  # fmt: skip
    assert solved.success, solved.message
    return solved


@pytest.mark.parametrize("changed", [slow({}), slow({"law": "slip"}), slow({"slip_m": 1e-4, "a": 0.012}),
    BRISTLES], ids=["ageing", "slip", "slow weakening", "bristles"])  # fmt: skip
def test_the_first_break_is_that_of_an_independent_solver(changed):
    one = slider(**changed, start_mu=0.05, end_s=2.1)
    motion = simulate([one])[0]
    peak_s = motion.time_s[motion.force_N.argmax()]
    exact = by_radau(one, peak_s + 0.05)
    times = np.linspace(0.0, peak_s + 0.05, 20_001)
    exact_N = one.stiffness_N_m * exact.sol(times)[0]
    assert motion.force_N.max() == pytest.approx(exact_N.max(), rel=3e-4)
    assert peak_s == pytest.approx(times[exact_N.argmax()], abs=4e-3)
    before = times < peak_s - 0.005
    assert np.abs(motion.spring_N(times) - exact_N)[before].max() < 1e-3 * FORCE


def test_steady_sliding_is_the_law(motions):
    for name, changed in STEADY.items():
        one, motion, speed = SLIDERS[name], motions[name], changed["profile"][1][1]
        steady = one.mu + (one.a - one.b) * np.log(speed / one.speed_m_s)
        assert motion.mu[-1] == pytest.approx(steady, rel=1e-5), name
        assert motion.force_N[-1] == pytest.approx(one.slack_N * np.expm1(steady * one.wrap_rad), rel=1e-4), (
            name
        )
    one = SLIDERS["viscous"]
    assert motions["viscous"].mu[-1] == pytest.approx(one.mu + one.viscous_s_m * SPEED, rel=1e-4)


def test_before_the_slip_the_force_climbs_at_the_springs_in_series(motions):
    one, motion = SLIDERS["rate and state"], motions["rate and state"]
    rate = (motion.spring_N(np.array([1.2])) - motion.spring_N(np.array([0.9])))[0] / 0.3
    assert rate == pytest.approx(SPEED / (1 / one.stiffness_N_m + 1 / one.motor_N_m), rel=2e-3)


def test_a_stiff_machine_shows_static_friction_and_its_decay(motions):
    """A slider that follows its motor has μ = μ_0 + b ln(v θ/D_c) + a ln(v/v_0), with θ ageing at constant v."""
    one, motion = SLIDERS["stiff"], motions["stiff"]
    times = np.linspace(0.15, 0.55, 9)
    slid = np.interp(times, motion.time_s, motion.slip_m)
    left = np.exp(-slid / one.slip_m)
    theta = (one.hold_s + 0.1) * left + one.slip_m / SPEED * (1 - left)
    law = one.mu + one.b * np.log(SPEED * theta / one.slip_m)
    assert np.interp(times, motion.time_s, motion.mu) == pytest.approx(law, abs=2e-3)


@pytest.mark.parametrize("name", ["rate and state", "bristles"])
def test_energy_is_kept(motions, name):
    """What the motor gives is in springs and masses, or was lost in dampers and sliding."""
    one, m = SLIDERS[name], motions[name]
    fine = np.linspace(0.0, one.end_s, 400_001)
    wheel, turn = np.interp(fine, m.time_s, m.wheel_m), np.interp(fine, m.time_s, m.wheel_m_s)
    rope, mu = np.interp(fine, m.time_s, m.rope_m_s), np.interp(fine, m.time_s, m.mu)
    (t0, _), (t1, top) = one.profile
    ramp = np.clip(fine - t0, 0.0, t1 - t0)
    way = 0.5 * top / (t1 - t0) * ramp**2 + top * np.maximum(fine - t1, 0.0)
    speed = top / (t1 - t0) * ramp
    drive = one.motor_N_m * (way - wheel) + one.motor_damping_N_s_m * (speed - turn)
    given = np.trapezoid(drive * speed, fine)
    friction = one.slack_N * np.expm1(mu * one.wrap_rad) * (turn - rope)
    lost = np.trapezoid(
        friction + one.damping_N_s_m * rope**2 + one.motor_damping_N_s_m * (speed - turn) ** 2, fine
    )
    kept = 0.5 * m.force_N[-1] ** 2 / one.stiffness_N_m + 0.5 * one.motor_N_m * (way[-1] - wheel[-1]) ** 2
    kept += 0.5 * one.mass_kg * rope[-1] ** 2 + 0.5 * one.wheel_kg * turn[-1] ** 2
    assert given == pytest.approx(lost + kept, rel=5e-3)


def test_a_partial_slip_takes_its_way_off_the_springs(motions):
    plain, partial = motions["rate and state"], motions["partial"]
    at = np.array([plain.time_s[np.argmax(plain.mu >= 0.2)] + 0.05])
    series = 1 / (1 / plain.stiffness_N_m + 1 / SLIDERS["partial"].motor_N_m)
    assert (plain.spring_N(at) - partial.spring_N(at))[0] == pytest.approx(5e-5 * series, rel=0.02)


def test_sliders_side_by_side_are_each_alone(motions):
    for name in ("slip 0.002", "bristles"):
        assert np.array_equal(simulate([SLIDERS[name]])[0].force_N, motions[name].force_N)
