"""The start-up mode by mode: its closed form, and what modes are worth that are left out, against the whole answer."""

from types import SimpleNamespace

import numpy as np
import pytest

from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS
from ropefric.scenes.plan import make_plan
from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.answer import FAST_ERROR, PressProblem, swinging_of
from ropefric.systems.press.effects import EFFECTS, SYSTEM
from ropefric.systems.press.transient.drives import DRIVE_LAWS, final_value, press_inputs
from ropefric.systems.press.transient.start_up import start_up, swinging_start_up


def wide_start(kit, seed, *, slip=True):
    """A press from soft to hard belts, hardly to heavily loaded, and a run-up from hasty to slow."""
    rng = np.random.default_rng([78, seed])
    press = kit.paper(
        EA_N=10 ** rng.uniform(5.5, 8), eta_s=10 ** rng.uniform(-4, -1.5), C1=10 ** rng.uniform(1, 4),
        k1=10 ** rng.uniform(3, 5), force_N=rng.uniform(800, 5000), load=rng.choice([0.0, rng.uniform(0.01, 1.2)]),
        density=rng.uniform(1.0, 30.0),
    )  # fmt: skip
    speed_m_s, duration_s = 10 ** rng.uniform(-1, 0.3), 10 ** rng.uniform(0, 1 if slip else 2)
    law = str(rng.choice(["s-curve", "s-curve", "ramp", "table"]))
    if law == "table":
        times_s, speeds = [0.0, 0.4 * duration_s, duration_s], [0.0, 0.7 * speed_m_s, speed_m_s]
        drive = DRIVE_LAWS[law](time_s=times_s, speed_m_s=speeds)
    else:
        drive = kit.run_up(law, speed_m_s, duration_s)
    return press, {
        "speed": drive,
        "time_s": np.linspace(0.0, 1.3 * duration_s, 301 if slip else 1501),
        "friction": 10 ** rng.uniform(-0.7, 0.3),
        "slip": slip,
    }


def problem_of(press, question):
    friction = question["friction"]
    return PressProblem(
        press=press,
        closure="share",
        friction=friction if isinstance(friction, WrapFriction) else WrapFriction.constant(friction),
        start_up={name: one for name, one in question.items() if name != "friction"},
        speed_m_s=np.array([final_value(question["speed"])]),
        load_factor=np.array([1.0]),
    )


def checked(press, question, accuracies):
    """Return how often something was left out, after each plan's answer was held against the whole one."""
    problem, left = problem_of(press, question), 0
    if swinging_of(problem, frozenset(EFFECTS)) is None:
        return 0
    _, full = make_plan(SYSTEM, problem, accuracy=1.0, effects="all")
    whole = SYSTEM.solve(full, SYSTEM.method(full, 1.0))
    assert whole.start_up.slips == ()
    for accuracy in accuracies:
        plan, model = make_plan(SYSTEM, problem, accuracy=accuracy, effects="auto")
        assert SYSTEM.distance(SYSTEM.solve(model, plan.method), whole, whole) <= plan.error_bound
        assert plan.error_bound <= accuracy
        left += "fast-modes" in plan.left_out
    return left


ACCURACIES = (0.2, 0.05, 0.02, 0.005)


@pytest.mark.slow
def test_what_swings_of_random_presses_are_worth_is_below_its_bound(kit):
    """Without slip; in some half of the start-ups modes are left out."""
    left = [checked(*wide_start(kit, seed, slip=False), ACCURACIES) for seed in range(8)]
    assert sum(one > 0 for one in left) >= 4


@pytest.mark.parametrize("seed", [7, pytest.param(27, marks=pytest.mark.slow)])
def test_a_press_that_may_slip_and_does_not_is_quasi_static_at_two_percent(kit, seed):
    press, question = kit.random(seed)
    problem = problem_of(press, question | {"slip": True})
    plan, _ = make_plan(SYSTEM, problem, accuracy=0.02, effects="auto")
    assert {"exact-switching", "fast-modes", "slow-modes"} <= set(plan.left_out)
    assert checked(press, question, [0.02]) == 1


@pytest.mark.slow
@pytest.mark.parametrize("slip", [False, True])
def test_what_swings_of_many_presses_are_worth_is_below_its_bound(kit, slip):
    left = [checked(*wide_start(kit, seed, slip=slip), ACCURACIES) for seed in range(100, 200)]
    assert sum(one > 0 for one in left) >= 30


@pytest.fixture
def swinging(kit):
    press, question = kit.random(27)
    return SimpleNamespace(of=swinging_start_up(press, **question), press=press, **question)


def test_all_modes_together_are_the_linear_start_up(kit, swinging):
    """By the matrix exponential, which knows neither paths nor modes."""
    short = swinging_start_up(
        swinging.press, speed=swinging.speed, time_s=np.linspace(0.0, 0.3, 31), friction=1.2
    )
    states, works = short.run(np.linspace(0.0, 0.3, 31), short.every)
    whole = kit.solve(kit.problem(swinging.press, swinging.speed), np.linspace(0.0, 0.3, 31))
    n = states.shape[1]
    np.testing.assert_allclose(states, whole[:, :n], atol=1e-9 * np.abs(whole[:, :n]).max(axis=0).max())
    np.testing.assert_allclose(works, whole[:, n:], atol=1e-8 * np.abs(whole[:, n:]).max())


def test_the_path_solves_the_equations_of_motion_and_swings_nowhere(swinging):
    times_s = np.linspace(0.0, swinging.time_s[-1], 20_001)
    states, _ = swinging.of.run(times_s, ~swinging.of.every)
    inputs = press_inputs(np.zeros(2), swinging.speed, "with-speed")
    rates = np.gradient(states, times_s, axis=0)
    inside = np.abs(times_s - inputs.starts_s[1]) > 1e-3
    inside[[0, -1]] = False
    w = np.hstack([states, inputs.at(times_s)])
    apart = np.abs(rates - w @ swinging.of.motion.derivative.T)[inside].max(axis=0)
    assert (apart <= 1e-4 * (1e-6 + np.abs(rates).max(axis=0))).all()


def test_the_slower_the_run_up_the_nearer_to_rest(kit):
    """An s-curve begins and ends with jumps of da/dt = 6 v/t²: swings are worth that, and so are their bounds."""
    press = kit.small(load_N_m=0.0)
    worth = []
    for duration_s in (10.0, 20.0, 40.0):
        question = {
            "speed": kit.run_up("s-curve", 1.0, duration_s),
            "time_s": [0.0, duration_s],
            "friction": 1.0,
        }
        found = swinging_start_up(press, **question)
        worth.append(found.bound(found.every))
    assert worth[0] < 0.05
    np.testing.assert_allclose(worth[:-1], 4.0 * np.array(worth[1:]), rtol=0.05)


def test_a_belt_that_is_stiff_enough_is_rigid(kit):
    """All its modes are fast; what is left is at most the tensioner on its spring."""
    found = [
        swinging_start_up(
            kit.small(EA_N=EA_N, load_N_m=1.0),
            speed=kit.run_up("s-curve", 1.0, 3.0),
            time_s=[0.0, 4.0],
            friction=1.0,
        )
        for EA_N in (2e4, 2e8)
    ]
    assert [one.fewest(FAST_ERROR) > 0 for one in found] == [True, False]
    assert [one.rigid_belts(FAST_ERROR) for one in found] == [(), ("belt",)]


def test_where_a_belt_may_slip_nothing_is_said_of_modes(kit):
    """Just where the whole answer has a roller that slips, and a little before."""
    question = {"speed": kit.run_up("s-curve", 1.0, 1.0), "time_s": np.linspace(0.0, 1.5, 51)}
    low, high = 0.05, 5.0
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        slips = bool(start_up(kit.small(), friction=middle, **question).slips)
        low, high = (middle, high) if slips else (low, middle)
    said = [
        swinging_start_up(kit.small(), friction=mu * high, **question) for mu in (0.5, 0.999, 1.0, 1.001, 1.2)
    ]
    assert [one is None for one in said] == [True, True, True, True, False]


def test_friction_that_follows_the_tensions_keeps_the_bound(kit):
    friction = WrapFriction(
        law=ALL_LAWS["wrap-power"],
        theta=np.array([0.3, -0.3, 0.2]),
        reference=one_condition(0.1, 0.0025, 2.0, 500.0),
    )
    question = {
        "speed": kit.run_up("s-curve", 0.5, 4.0), "time_s": np.linspace(0.0, 5.0, 101), "friction": friction,
        "slip": True,
    }  # fmt: skip
    assert checked(kit.small(load_N_m=10.0), question, [0.2, 0.05]) == 2


def test_loads_that_are_there_from_the_start_are_left_to_the_grid(kit):
    question = {"speed": kit.run_up(), "time_s": [0.0, 3.0], "friction": 2.0}
    assert swinging_start_up(kit.paper(), loads="constant", **question) is None
    assert swinging_start_up(kit.paper(load=0.0), loads="constant", **question) is not None


def test_no_bound_without_the_exact_integrator(kit):
    question = {"speed": kit.run_up(), "time_s": [0.0, 3.0], "friction": 2.0}
    assert swinging_start_up(kit.paper(), integrator="rk4", **question) is None
