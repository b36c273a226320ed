"""Drag opposes motion and holds at rest: against a regularised machine coded by itself; a press never drives itself."""

import numpy as np
import pytest
from paper import density_on_rollers
from scipy.integrate import solve_ivp

from ropefric.errors import SolverError
from ropefric.systems.press.transient.drives import DRIVE_LAWS
from ropefric.systems.press.transient.start_up import start_up


def drive_of(law, speed_m_s=1.0, duration_s=0.3):
    if law == "constant":
        return DRIVE_LAWS[law](speed_m_s=speed_m_s)
    if law == "table":
        times = np.array([0.0, 0.1, 0.25, 0.4])
        return DRIVE_LAWS[law](time_s=times, speed_m_s=speed_m_s * np.array([0.0, 0.6, 0.3, 1.0]))
    return DRIVE_LAWS[law](speed_m_s=speed_m_s, duration_s=duration_s)


CREEP_M_S, STILL_M_S = 4e-6, 1e-5


def regularised(press, speed, loads, times_s, mu, rtol=1e-7):  # noqa: PLR0917  (facts of one machine)
    """A machine on its own graph, whose friction and drag grow with the speed up to their limits, as a tanh.

    Return positions of belts, then their speeds, those of the driven rims, travels and their speeds.
    """
    D, P, into, out_of = press.incidence, press.pull, press.into, press.out_of
    driven, R = press.is_driven, press.radius_m
    n, m, k = len(R), int(driven.sum()), len(press.tensioners)
    wrap = np.array([r.wrap_angle_rad for r in press.rollers])
    J = np.array([r.inertia_kg_m2 for r in press.rollers])
    stiff = np.zeros(len(press.spans))
    for belt in press.belts:
        for step, length in zip(belt.steps, belt.span_lengths_m, strict=True):
            place = [(s.start, s.end) for s in press.spans].index(step)
            stiff[place] += belt.axial_stiffness_N / length
    eta = press.belts[0].damping_s
    parts = list(press.tensioners.values())
    spring, mass, damper = (
        np.array([getattr(one, name) for one in parts]) for name in ("spring_N_m", "mass_kg", "damping_N_s_m")
    )
    level = np.linalg.solve(P @ press.carried.T, [p.spring_N_m * p.travel_m + p.force_N for p in parts])
    T0 = level @ press.carried
    density = density_on_rollers(press)
    arc, E = density * R * wrap, np.exp(mu * wrap)
    kappa = mu * wrap / (E - 1.0)
    load, final = press.rim_load_N, float(speed(speed.x[-2]))

    def rate(t, y, end):
        b, db, x, dx = y[:n], y[n : 2 * n], y[2 * n + m : 2 * n + m + k], y[2 * n + m + k :]
        v_drive = float(speed(min(t, np.nextafter(end, 0.0))))
        v = np.full(n, v_drive)
        v[driven] = y[2 * n : 2 * n + m]
        e, de = (-D.T @ way - P.T @ travel for way, travel in ((b, x), (db, dx)))
        T = np.maximum(T0 + stiff * (e + eta * de), 0.0)
        pressed = np.maximum(T - press.density_kg_m * v_drive**2, 0.0)
        before, behind = into @ pressed, out_of @ pressed
        fast = db - v
        tight, slack = np.where(fast > 0.0, behind, before), np.where(fast > 0.0, before, behind)
        F = ((1.0 - kappa) * tight + (kappa * E - 1.0) * slack) * np.tanh(fast / CREEP_M_S)
        factor = 1.0 if loads == "constant" else v_drive / final
        roll = (F - factor * load * np.tanh(v / STILL_M_S)) * R**2 / J
        push = P @ (T - T0 - press.density_kg_m * v_drive**2) - damper * dx - spring * x
        return np.concatenate([db, (D @ T - F) / arc, roll[driven], dx, push / mass])

    found, y = [], np.zeros(2 * n + m + 2 * k)
    y[n : 2 * n][~driven] = float(speed(0.0))  # what lies on a driver goes with it
    starts = [one for one in speed.x[:-1] if one < times_s[-1]]
    for start, end in zip(starts, [*starts[1:], times_s[-1]], strict=True):
        inside = times_s[(times_s > start) & (times_s <= end)]
        stops = np.unique(np.append(inside, end))
        made = solve_ivp(
            rate, (start, end), y, method="LSODA", t_eval=stops, rtol=rtol, atol=0.01 * rtol, args=(end,)
        )
        found.append(made.y[:, : inside.size])
        y = made.y[:, -1]
    return np.hstack(found).T


def random_case(seed):
    rng = np.random.default_rng(seed)
    return {"law": ("constant", "ramp", "s-curve", "table")[seed % 4],
            "loads": ("with-speed", "constant")[seed // 4 % 2], "mu": rng.uniform(0.05, 0.3),
            "load_N_m": rng.uniform(5.0, 60.0), "k1": 10.0 ** rng.uniform(3.0, 5.0)}  # fmt: skip


def account_is_physical(found):
    energy = found.energy
    assert energy.relative_residual < 1e-5
    for taken in (energy.load, energy.slip, energy.belt, energy.tensioner):
        assert (np.diff(taken) >= -1e-6 * energy.scale_J).all()


@pytest.mark.parametrize("case",
                         [{"law": "ramp", "loads": "with-speed", "mu": 0.12, "load_N_m": 40.0},
                          *(pytest.param(random_case(seed), marks=pytest.mark.slow) for seed in range(24))])  # fmt: skip
def test_a_machine_coded_by_itself_slips_and_holds_alike(kit, case):
    press = kit.small(load_N_m=case["load_N_m"], k1=case.get("k1", 1e4))
    speed, times_s = drive_of(case["law"]), np.linspace(0.0, 1.0, 101)
    wanted = regularised(press, speed, case["loads"], times_s[1:], case["mu"])
    found = start_up(press, speed=speed, time_s=times_s, friction=case["mu"], loads=case["loads"])
    account_is_physical(found)
    assert found.slips
    rims = found.roller_speed_rad_s * [roller.radius_m for roller in press.rollers]
    assert rims[:, 1].min() > -1e-9 or case["law"] != "ramp"
    np.testing.assert_allclose(rims[1:, 1:], wanted[:, 6:8], atol=0.01)
    np.testing.assert_allclose(found.travel_m[1:, 0] - 0.01, wanted[:, 8], atol=2e-4)
    np.testing.assert_allclose((rims + found.slip_speed_m_s)[1:, 1:], wanted[:, 4:6], atol=0.01)


@pytest.mark.parametrize(("mu", "loads"),
                         [(0.2, "with-speed"), pytest.param(0.15, "constant", marks=pytest.mark.slow),
                          pytest.param(0.15, "with-speed", marks=pytest.mark.slow),
                          pytest.param(0.2, "constant", marks=pytest.mark.slow)])  # fmt: skip
def test_a_press_that_its_drivers_cannot_pull_stands(kit, mu, loads):
    """Rolled along by drags that never change their sign, it would run backward for ever."""
    press = kit.paper(force_N=1100.0)
    found = start_up(
        press, speed=kit.run_up(duration_s=1.0), time_s=np.linspace(0.0, 3.0, 61), friction=mu, loads=loads
    )
    account_is_physical(found)
    # A roller may swing back and forth on its belts, but none is carried away backward.
    turned = found.relative_angle_rad * press.radius_m + np.trapezoid(found.drive_speed_m_s, found.time_s)
    assert found.roller_speed_rad_s[-1].min() > -1e-6
    assert turned[-1].min() > -0.01


def test_an_account_in_which_loads_drive_the_press_is_refused_and_the_time_named(kit):
    question = {"speed": kit.run_up("ramp", 1.0, 0.1), "time_s": np.linspace(0.0, 0.5, 51), "friction": 5.0}
    found = start_up(kit.small(load_N_m=60.0), **question)
    found.energy.check(found.time_s, loads_take=True)
    found.energy.load = np.where(found.time_s > 0.25, 0.0, found.energy.load)
    with pytest.raises(SolverError, match=r"the loads drive the press: from t = 0\.26 s on") as caught:
        found.energy.check(found.time_s, loads_take=True)
    assert caught.value.problem.code == "RF524"


@pytest.mark.slow
@pytest.mark.parametrize(("law", "loads", "mu"),
                         [("table", "with-speed", 0.3), ("ramp", "with-speed", 0.2),
                          ("s-curve", "constant", 0.15), ("constant", "with-speed", 0.25)])  # fmt: skip
def test_the_paper_s_machine_coded_on_its_graph_slips_and_holds_alike(kit, law, loads, mu):
    press, times_s = kit.paper(force_N=1100.0), np.linspace(0.0, 0.28, 15)
    speed = drive_of(law, kit.speed_m_s, 0.25)
    wanted = regularised(press, speed, loads, times_s[1:], mu, rtol=1e-6)
    found = start_up(press, speed=speed, time_s=times_s, friction=mu, loads=loads)
    account_is_physical(found)
    assert len({slip.roller for slip in found.slips}) >= 2
    rims = found.roller_speed_rad_s * press.radius_m
    n, m = len(press.rollers), int(press.is_driven.sum())
    np.testing.assert_allclose(rims[1:, press.is_driven], wanted[:, 2 * n : 2 * n + m], atol=0.01)
    np.testing.assert_allclose((rims + found.slip_speed_m_s)[1:], wanted[:, n : 2 * n], atol=0.02)
