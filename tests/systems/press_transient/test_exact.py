"""The exact solution: against mpmath, against any grid, in its limits, and with its energies."""

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ropefric.errors import InputError
from ropefric.systems.press.statics import solve_statics, speed_shift_kg_m
from ropefric.systems.press.transient.exact import HybridSolver, Propagator
from ropefric.systems.press.transient.motion import MOVING, ElasticPress, settled
from ropefric.systems.press.transient.start_up import Energies, start_up


def tensions(problem, states, times_s):
    w = np.hstack([states, problem.inputs.at(times_s)])
    return w @ problem.motion.tension_N.T


def balance(problem, times_s):
    _, states, works = HybridSolver(problem.model, problem.inputs, None, drags=False).run(times_s)
    return Energies(problem.motion, np.hstack([states, problem.inputs.at(times_s)]), works)


@pytest.mark.parametrize("rate", [1e-3, 1.0, 1e4, 1e8])
def test_a_step_of_one_equation_by_hand(rate):
    """dy/dt = −λ y + λ t² has y = t² − 2t/λ + 2/λ² + (y0 − 2/λ²) e^(−λt)."""
    made = Propagator(np.array([[-rate]]), np.array([[rate]]), np.array([[0.0, 0.0, 2.0]]))
    t, y0 = 0.7, 0.4
    z = made.step(t) @ made.lift(np.array([y0]), 0.0)
    with mp.workdps(40):
        x = mp.mpf(rate)
        t_, y_ = mp.mpf(t), mp.mpf(y0)
        exact = t_**2 - 2 * t_ / x + 2 / x**2 + (y_ - 2 / x**2) * mp.exp(-x * t_)
        square = mp.quad(lambda s: (s**2 - 2 * s / x + 2 / x**2 + (y_ - 2 / x**2) * mp.exp(-x * s)) ** 2,
                         [0, min(1 / x, t_ / 2), min(20 / x, t_ / 1.5), min(200 / x, t_ / 1.2), t_])  # fmt: skip
    assert z[0] == pytest.approx(float(exact), rel=1e-13 if rate < 1e6 else 1e-11)
    form = np.zeros((1, 2, 2))
    form[0, 0, 0] = 1.0
    start = made.lift(np.array([y0]), 0.0)
    assert start @ made.integrals(form, t)[0] @ start == pytest.approx(float(square), rel=1e-8)


@given(st.lists(st.floats(0.01, 4.0), min_size=2, max_size=6, unique=True))
@settings(max_examples=10, deadline=None)
def test_the_answer_does_not_depend_on_the_grid(kit, times):
    problem = kit.problem(kit.small(), kit.run_up("ramp", 1.0, 1.5))
    times_s = np.sort(times)
    together, alone = kit.solve(problem, times_s), kit.solve(problem, times_s[-1:])
    scale = np.abs(together).max()
    np.testing.assert_allclose(together[-1], alone[0], rtol=1e-9, atol=1e-12 * scale)


def test_energies_add_up(kit):
    for law in ["s-curve", "ramp", "constant"]:
        for EA_N, eta_s in [(2e6, 0.0), (2e6, 1e-3), (1e8, 0.1), (1e10, 1e-3)]:
            problem = kit.problem(kit.paper(EA_N=EA_N, eta_s=eta_s), kit.run_up(law))
            times_s = np.linspace(0.0, 5.0, 101)
            found = balance(problem, times_s)
            assert found.relative_residual < 1e-8, (law, EA_N)
            for name in ("belt", "tensioner"):
                assert (np.diff(getattr(found, name)) >= -1e-9 * found.drive[-1]).all(), (law, EA_N)
            assert not found.slip.any(), (law, EA_N)
            later = balance(problem, times_s[40:])
            assert later.relative_residual < 1e-8, (law, EA_N)


@pytest.mark.parametrize(("EA_N", "eta_s"), [(2e6, 1e-2), (1e8, 0.1)])
def test_a_start_up_ends_in_the_steady_run(kit, EA_N, eta_s):
    press = kit.paper(EA_N=EA_N, eta_s=eta_s)
    problem = kit.problem(press)
    settled_N = settled(problem.model, kit.speed_m_s).tension_N
    states = kit.solve(problem, [60.0])
    np.testing.assert_allclose(tensions(problem, states, np.array([60.0]))[0], settled_N, rtol=1e-9)
    net = press.incidence @ settled_N
    loads = press.rim_load_N
    np.testing.assert_allclose(net[press.is_driven], loads[press.is_driven], atol=1e-8)
    motion = problem.motion
    w = np.concatenate([states[0], problem.inputs.at(60.0)])
    np.testing.assert_allclose(motion.rim_speed_m_s @ w, kit.speed_m_s, rtol=1e-9)


def test_the_steady_run_is_that_of_the_paper_s_equations(kit):
    """(33), (34) at the travels that the elastic model finds, and every balance; the closure is the belts' own."""
    press = kit.paper()
    found = start_up(press, speed=kit.run_up(), time_s=[0.0, 300.0])
    T, x = found.tension_N[-1], found.travel_m[-1]
    c = 15.0 * kit.speed_m_s**2
    up = T[1] - c + (T[2] - c) * math.cos(kit.beta) - 2000.0
    down = T[13] - c + (T[12] - c) * math.cos(kit.gamma) - 2000.0
    np.testing.assert_allclose(2e4 * x, [up, down], rtol=1e-9)
    assert T[8] + T[9] - T[7] == pytest.approx(16.8 / 0.1, rel=1e-9)
    assert T[4] - T[3] - T[13] == pytest.approx(99.0 / 0.25, rel=1e-9)
    np.testing.assert_allclose(T[[10, 11]], T[12], rtol=1e-9)
    np.testing.assert_allclose(found.settled.tension_N, T, rtol=1e-9)


@pytest.mark.parametrize("k1", [1e3, 2e4, 1e9])
def test_what_speed_does_to_the_tensions(kit, k1):
    """dT' = −ρAv²/(1 + s) with the belt's stiffness from its free spans, which is what the model stretches."""
    press = kit.small(k1=k1)
    model = ElasticPress(press)
    still, run = (settled(model, v).tension_N for v in (0.0, 2.0))
    c = 8.0 * 4.0
    s = 4.0 * (2e5 / (0.8 + 1.0 + 1.3)) / k1
    np.testing.assert_allclose(run - c - still, -c / (1.0 + s), rtol=1e-6)
    # With the arcs' length in the belt the statics say nearly the same, and in the limit of a stiff spring the same.
    shift = speed_shift_kg_m(solve_statics(press), "elastic") * 4.0
    np.testing.assert_allclose(shift, run - c - still, rtol=0.25 if k1 < 1e6 else 1e-3)


def test_stiff_tensioners_stay_and_stiff_belts_move_as_one(kit):
    locked = start_up(kit.paper(k1=1e14, travel_m=0.0), speed=kit.run_up(), time_s=np.linspace(0, 4, 41))
    assert np.abs(locked.travel_m).max() < 1e-9
    rigid = start_up(kit.paper(EA_N=1e12, eta_s=1e-4), speed=kit.run_up(), time_s=np.linspace(0, 4, 41))
    assert np.abs(rigid.relative_angle_rad[:, :2]).max() < 1e-6
    rims = rigid.roller_speed_rad_s * kit.paper().radius_m
    np.testing.assert_allclose(rims - rigid.drive_speed_m_s[:, None], 0.0, atol=2e-3)


def test_loads_from_the_start_begin_in_balance_with_them(kit):
    found = start_up(kit.paper(), speed=kit.run_up(), time_s=[0.0, 1e-9], loads="constant")
    net = found.tension_N[0] @ kit.paper().incidence.T
    loads = kit.paper().rim_load_N
    balanced = kit.paper().is_driven
    np.testing.assert_allclose(net[balanced], loads[balanced], atol=1e-8)
    unloaded = start_up(kit.paper(), speed=kit.run_up(), time_s=[0.0, 1e-9])
    np.testing.assert_allclose(unloaded.tension_N[0] @ kit.paper().incidence.T, 0.0, atol=1e-9)


@pytest.mark.parametrize(("arguments", "said"),
                         [({"time_s": [0.5, 1.0, 0.7]}, "rise"), ({"time_s": [-1.0, 0.5]}, "rise"),
                          ({"time_s": []}, "finite times"),
                          ({"friction": 0.3, "effects": MOVING - {"arc-inertia"}}, "own mass"),
                          ({"friction": -0.3}, "positive")])  # fmt: skip
def test_bad_questions_are_refused(kit, arguments, said):
    whole = {"speed": kit.run_up(), "time_s": [0.0, 1.0]} | arguments
    with pytest.raises(InputError, match=said):
        start_up(kit.small(), **whole)


def test_drivers_of_different_speed_settle_nowhere(kit):
    press = kit.paper(overspeed=1e-3)
    assert settled(ElasticPress(press), 1.0) is None
    found = start_up(press, speed=kit.run_up(), time_s=np.linspace(0.0, 5.0, 51))
    assert found.settled is None
    assert found.energy.relative_residual < 1e-8
    # The faster driver takes span 10's load over from driver 1: 1 mm/s over belts of some 1e6 N/m.
    assert found.tension_N[-1, 9] - found.tension_N[-1, 8] > 1000.0
