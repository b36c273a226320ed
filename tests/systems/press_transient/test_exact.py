"""The exact solution: against mpmath, against any grid, in its limits, and with its energies."""

import math

import mpmath as mp
import numpy as np
import pytest

from ropefric.errors import InputError
from ropefric.systems.press.statics import solve_statics, speed_shift_kg_m
from ropefric.systems.press.transient.exact import Propagator
from ropefric.systems.press.transient.motion import MOVING, ElasticPress, settled
from ropefric.systems.press.transient.start_up import start_up


def tensions(problem, states, times_s):
    w = np.hstack([states, problem.inputs.at(times_s)])
    return w @ problem.motion.tension_N.T


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
    assert z[0] == pytest.approx(float(exact), rel=1e-13 if rate < 1e6 else 1e-11)


def test_energies_add_up(kit):
    for law, EA_N, eta_s in [("ramp", 2e6, 0.0), ("s-curve", 1e8, 0.1), ("ramp", 1e8, 1e-3)]:
        press, times_s = kit.paper(EA_N=EA_N, eta_s=eta_s), np.linspace(0.0, 2.5, 51)
        found = start_up(press, speed=kit.run_up(law), time_s=times_s, friction=1.2).energy
        assert found.relative_residual < 1e-6, (law, EA_N)
        for name in ("belt", "tensioner"):
            assert (np.diff(getattr(found, name)) >= -1e-6 * found.drive[-1]).all(), (law, EA_N)


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
    T, _, x = settled(ElasticPress(kit.paper()), kit.speed_m_s)
    c = 15.0 * kit.speed_m_s**2
    up = T[1] - c + (T[2] - c) * math.cos(kit.beta) - 2000.0
    down = T[13] - c + (T[12] - c) * math.cos(kit.gamma) - 2000.0
    np.testing.assert_allclose(2e4 * x, [up, down], rtol=1e-9)
    assert T[8] + T[9] - T[7] == pytest.approx(16.8 / 0.1, rel=1e-9)
    assert T[4] - T[3] - T[13] == pytest.approx(99.0 / 0.25, rel=1e-9)
    np.testing.assert_allclose(T[[10, 11]], T[12], rtol=1e-9)


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
    times_s = np.linspace(0, 4, 41)

    def moved(**parts):
        problem = kit.problem(kit.paper(**parts))
        return problem.motion, np.hstack([kit.solve(problem, times_s), problem.inputs.at(times_s)])

    locked, w = moved(k1=1e14, travel_m=0.0)
    assert np.abs(w @ locked.travel_m.T).max() < 1e-9
    rigid, w = moved(EA_N=1e12, eta_s=1e-4)
    assert np.abs((w @ rigid.relative_way_m.T)[:, :2]).max() < 1e-7
    np.testing.assert_allclose((w @ (rigid.rim_speed_m_s - rigid.rim_speed_m_s[0]).T), 0.0, atol=2e-3)


def test_a_start_begins_with_the_belts_at_rest(kit):
    for loads in ("with-speed", "constant"):
        found = start_up(kit.paper(), speed=kit.run_up(), time_s=[0.0, 1e-9], friction=5.0, loads=loads)
        np.testing.assert_allclose(found.tension_N[0] @ kit.paper().incidence.T, 0.0, atol=1e-9)


@pytest.mark.parametrize(("arguments", "said"),
                         [({"time_s": [0.0, 1.0, 0.7]}, "rise"), ({"time_s": [0.5, 1.0]}, "rise"),
                          ({"time_s": [0.0, 0.1, 0.3]}, "evenly"), ({"time_s": []}, "finite times"),
                          ({"effects": MOVING - {"arc-inertia"}}, "own mass"),
                          ({"friction": -0.3}, "positive")])  # fmt: skip
def test_bad_questions_are_refused(kit, arguments, said):
    whole = {"speed": kit.run_up(), "time_s": [0.0, 1.0], "friction": 0.3} | arguments
    with pytest.raises(InputError, match=said):
        start_up(kit.small(), **whole)


def test_drivers_of_different_speed_settle_nowhere(kit):
    press = kit.paper(overspeed=1e-3)
    assert settled(ElasticPress(press), 1.0) is None
    found = start_up(press, speed=kit.run_up(), time_s=np.linspace(0.0, 5.0, 51), friction=4.0)
    assert found.settled is None
    assert found.energy.relative_residual < 1e-6
    # The faster driver takes span 10's load over from driver 1: 1 mm/s over belts of some 1e6 N/m.
    assert found.tension_N[-1, 9] - found.tension_N[-1, 8] > 1000.0
