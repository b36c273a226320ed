"""Slip and slack: never beyond e^M, never a pushing belt, the same as a regularised machine coded by itself."""

import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from paper import density_on_rollers, law_of
from scipy.integrate import solve_ivp
from thinned import slow, thinned

from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.transient.motion import (
    ElasticPress,
    friction_limit,
    friction_utilisation,
    settled,
)
from ropefric.systems.press.transient.start_up import start_up

MU = 0.3


@pytest.fixture(scope="module")
def hard_start(kit):
    """Half a second to full speed with little friction: both drivers and roller 2 slip."""
    return start_up(
        kit.paper(), speed=kit.run_up("ramp", duration_s=0.5), time_s=np.linspace(0, 1.2, 481), friction=MU
    )


@pytest.fixture(scope="module")
def slack_start(kit):
    """Full speed at once: spans behind the drivers go slack."""
    speed = kit.run_up("constant", 1.0)
    return start_up(kit.small(), speed=speed, time_s=np.linspace(0.0, 0.6, 2401), friction=0.6)


def sides(found):
    """T' before and behind each roller, the belt's acceleration there, and the mass of the belt on it."""
    press = found.press
    density = density_on_rollers(press)
    c = density * found.drive_speed_m_s[:, None] ** 2
    T = found.tension_N
    arc = density * np.array([r.radius_m * r.wrap_angle_rad for r in press.rollers])
    acceleration = (T @ press.incidence.T - found.friction_N) / arc
    return T @ press.into.T - c, T @ press.out_of.T - c, acceleration, arc


@pytest.mark.parametrize("name", ["hard_start", "slack_start"])
def test_no_tension_ratio_is_beyond_euler_at_any_time(request, name):
    """Ahead (T'_out + q)/(T'_in + q) ≤ e^M, behind (T'_in − q)/(T'_out − q), q = ρAR²θ''/μ; equal where it slips."""
    found, mu = request.getfixturevalue(name), {"hard_start": MU, "slack_start": 0.6}[name]
    into, out, acceleration, arc = sides(found)
    wraps = np.array([roller.wrap_angle_rad for roller in found.press.rollers])
    q = arc * acceleration / (mu * wraps)
    pressed = (into > 1e-3) & (out > 1e-3)
    assert pressed.mean() > 0.8
    growth = np.exp(mu * wraps)
    for tight, slack in ((out + q, into + q), (into - q, out - q)):
        whole = pressed & (slack > 0.0)
        assert (tight - slack * growth <= 1e-6 * np.abs(tight))[whole].all()
    forward, backward = pressed & (found.contact == 1), pressed & (found.contact == -1)
    np.testing.assert_allclose(((out + q) - (into + q) * growth)[forward], 0.0, atol=1e-5)
    np.testing.assert_allclose(((into - q) - (out - q) * growth)[backward], 0.0, atol=1e-5)
    assert forward.any()
    assert backward.any()
    assert found.utilisation[pressed].max() <= 1.0 + 1e-7


def test_what_slips_when(hard_start):
    assert set(hard_start.summary()["first_slip_s"]) == {"1", "2", "10"}
    times = list(hard_start.summary()["first_slip_s"].values())
    assert times == sorted(times)
    assert 0.0 < times[0] < times[-1] < 0.5
    assert {slip.direction for slip in hard_start.slips if slip.roller in {"1", "10"}} == {-1}
    assert {slip.direction for slip in hard_start.slips if slip.roller == "2"} == {1}
    summary = hard_start.summary()
    assert summary["peak_utilisation"]["2"] == pytest.approx(1.0, abs=1e-7)
    assert summary["peak_utilisation"]["6"] < 0.5
    assert summary["slipping_s"]["2"] > 0.8
    rows = {roller.name: i for i, roller in enumerate(hard_start.press.rollers)}
    for slip in hard_start.slips:
        inside = (hard_start.time_s > slip.start_s) & (hard_start.time_s < slip.end_s)
        assert (hard_start.contact[inside, rows[slip.roller]] == slip.direction).all()
        assert (slip.direction * hard_start.slip_speed_m_s[inside, rows[slip.roller]] >= 0.0).all()
    stuck = hard_start.contact == 0
    assert np.abs(hard_start.slip_speed_m_s[stuck]).max() < 1e-9


def test_a_roller_left_behind_stops_and_is_not_driven_backward(hard_start):
    rim = hard_start.roller_speed_rad_s[:, 1]
    assert rim.max() > 1.0
    assert np.abs(rim[-1]) < 1e-9
    assert rim.min() > -1e-9
    first = int(np.flatnonzero((hard_start.time_s > 0.3) & (np.abs(rim) < 1e-9))[0])
    assert np.abs(rim[first:]).max() < 1e-9


def test_belts_do_not_push(slack_start, hard_start):
    assert slack_start.tension_N.min() == 0.0
    assert (slack_start.tension_N == 0.0).sum() > 10
    assert (hard_start.tension_N > 0.0).all()


@pytest.mark.parametrize("name", ["hard_start", "slack_start"])
def test_energies_add_up_with_slip(request, name):
    found = request.getfixturevalue(name)
    assert found.energy.relative_residual < 1e-5
    assert found.energy.slip[-1] > 0.01 * found.energy.drive[-1]
    for part in (found.energy.slip, found.energy.belt, found.energy.tensioner, found.energy.load):
        assert (np.diff(part) >= -1e-6 * found.energy.drive[-1]).all() or part is found.energy.load


@pytest.mark.parametrize(("load", "rtol"), [slow((0.0, 1e-8)), (1.0, 2e-5)])
def test_friction_that_suffices_leaves_the_linear_press(kit, load, rtol):
    """But for the first moments, in which drag holds the rollers that the linear model's loads push backward."""
    press, times_s = kit.paper(load=load), np.linspace(0.0, 2.5, 51)
    found = start_up(press, speed=kit.run_up(), time_s=times_s, friction=1.2)
    assert found.slips == ()
    problem = kit.problem(press)
    linear = np.hstack([kit.solve(problem, times_s), problem.inputs.at(times_s)])
    np.testing.assert_allclose(found.tension_N, linear @ problem.motion.tension_N.T, rtol=rtol)
    if load:
        # The page: with μ = 1.2 no roller slips, and roller 2 is the first to come near it.
        used = found.summary()["peak_utilisation"]
        assert max(used, key=used.get) == "2"
        assert 0.5 < used["2"] < 0.7


@pytest.mark.parametrize(("factor", "slips"), [(1.02, False), (0.98, True)])
def test_the_threshold_of_slip_in_a_slow_start(kit, factor, slips):
    """Slow enough, roller 2 slips just where the steady run needs more than its friction: ln(T2'/T1')/α."""
    press = kit.paper(eta_s=1e-2)
    settled_N = settled(ElasticPress(press), kit.speed_m_s).tension_N - 15.0 * kit.speed_m_s**2
    needed = math.log(settled_N[1] / settled_N[0]) / press.rollers[1].wrap_angle_rad
    found = start_up(
        press, speed=kit.run_up(duration_s=6.0), time_s=np.linspace(0.0, 6.5, 14), friction=factor * needed
    )
    assert list(found.summary()["first_slip_s"]) == (["2"] if slips else [])
    if slips:
        assert found.summary()["first_slip_s"]["2"] > 3.0


def test_the_limit_of_a_constant_coefficient(kit):
    model = ElasticPress(kit.paper())
    limit = friction_limit(model, 0.4)
    M = 0.4 * np.array([roller.wrap_angle_rad for roller in model.press.rollers])
    np.testing.assert_allclose(limit.growth, np.exp(M), rtol=1e-14)
    np.testing.assert_allclose(limit.share, M / np.expm1(M), rtol=1e-9)


LAW = law_of("wrap-power", [0.5, -0.8, 0.1], (0.1, 0.0025, 2.0, 500.0))


def local_mu(friction, slack_N):
    """Return μ(s) of the law by the derivative of its own ∫μ."""
    if not isinstance(friction, WrapFriction):
        return lambda s: friction
    a, b, c = friction.theta
    # φ0 from ∫₀^φ0 μ = ln F_B, independent of the package.
    phi0 = float(mpmath.findroot(lambda p: a * p ** (b + 1) / (b + 1) + c * p - mpmath.log(slack_N), 5.0))
    return lambda s: a * (phi0 + s) ** b + c


def test_utilisation_is_one_at_the_limit_of_the_belt_element(kit):
    """The belt element dT/dφ = ρAR²θ'' − F with F at its greatest everywhere, integrated directly."""
    for friction in [0.8, LAW]:
        for inertia_N in [0.0, -3.0, 60.0]:
            for alpha in [0.5, 5.0]:
                model = ElasticPress(kit.small(wrap_rad=alpha))
                slack_N = float(model.preload_N[0])
                mu = local_mu(friction, slack_N)
                limit = friction_limit(model, friction)
                # Friction brakes the belt, or drives it; the angle counts from the slack side.
                for way in (1.0, -1.0):
                    run = solve_ivp(
                        lambda s, T, way=way, mu=mu, inertia_N=inertia_N: way * inertia_N + mu(s) * T,
                        (0.0, alpha), [slack_N], method="DOP853", rtol=1e-13, atol=1e-12
                    )  # fmt: skip
                    sides = [slack_N, float(run.y[0, -1])][:: int(way)]
                    found = friction_utilisation(
                        limit, friction_N=np.full(3, sides[1] - sides[0] - inertia_N * alpha),
                        upstream_N=np.full(3, sides[0]), downstream_N=np.full(3, sides[1]),
                        arc_force_N=np.full(3, inertia_N * alpha)
                    )  # fmt: skip
                    assert found[1] == pytest.approx(1.0, abs=1e-9), (friction, inertia_N, alpha)


@pytest.mark.parametrize("b", [-0.3, -0.7, -0.95])
def test_the_share_of_inertia_is_exact_where_the_coefficient_is_steep(kit, b):
    """With a slack side of 1 N the wrap counts from zero, where μ = a φ^b is infinite."""
    friction, alpha = replace(LAW, theta=np.array([0.2, b, 0.05])), 2.0
    small = kit.small(wrap_rad=alpha, k1=1e-3, force_N=2.0 - 1e-5)

    def M(s):
        return 0.2 * s ** (b + 1) / (b + 1) + 0.05 * s

    with mpmath.workdps(30):
        swell = mpmath.quad(lambda u: 20 * u**19 * (mpmath.exp(M(alpha) - M(alpha * u**20)) - 1), [0, 0.5, 1])
    model = ElasticPress(small)
    assert model.preload_N[0] == pytest.approx(1.0, rel=1e-12)
    assert friction_limit(model, friction).share[1] == pytest.approx(float(1 / (1 + swell)), rel=1e-9)


@pytest.mark.parametrize("seed", thinned(range(18), 6))
def test_any_start_keeps_to_physics(kit, seed):
    """Random machines, drives and friction: energy adds up, belts do not push, friction stays within its limit."""
    rng = np.random.default_rng(seed)
    if seed % 4 == 0:
        press = kit.paper(force_N=rng.uniform(500.0, 3000.0), EA_N=10.0 ** rng.uniform(6.0, 7.0),
                          load=rng.uniform(0.2, 1.5))  # fmt: skip
    else:
        press = kit.small(EA_N=10.0 ** rng.uniform(5.0, 8.0), eta_s=rng.choice([1e-4, 1e-3, 1e-2, 0.1]),
                          load_N_m=rng.uniform(0.0, 60.0), k1=10.0 ** rng.uniform(2.0, 6.0))  # fmt: skip
    drive = kit.run_up(rng.choice(["s-curve", "ramp", "constant"]), 0.9, 10.0 ** rng.uniform(-1.5, 0.0))
    found = start_up(press, speed=drive, time_s=np.linspace(0.0, 0.3, 61), friction=rng.uniform(0.05, 1.0),
                     loads=str(rng.choice(["with-speed", "constant"])))  # fmt: skip
    assert found.energy.relative_residual < 1e-4
    assert found.tension_N.min() >= 0.0
    assert found.utilisation.max() <= 1.0 + 1e-6
    for taken in (found.energy.slip, found.energy.load, found.energy.belt, found.energy.tensioner):
        assert (np.diff(taken) >= -1e-4 * found.energy.scale_J).all()
