"""Contacts that change their state on a grid: the answer of the exact moments, at a fraction of its time."""

import logging
import time
from statistics import median

import numpy as np
import pytest

from ropefric.scenes.plan import make_plan
from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.answer import PressProblem
from ropefric.systems.press.effects import SYSTEM
from ropefric.systems.press.transient import start_up as module
from ropefric.systems.press.transient.capture import GridSolver
from ropefric.systems.press.transient.drives import DRIVE_LAWS, final_value
from ropefric.systems.press.transient.exact import lowest_between
from ropefric.systems.press.transient.start_up import GRID_ERROR, largest_difference, start_up


@pytest.fixture
def solvers(monkeypatch):
    """What was solved: on which grids, and whether the exact moments were searched for after all."""
    solved = []
    for solver in (GridSolver, module.HybridSolver):
        run = solver.run

        def noted(self, times_s, run=run):
            solved.append(getattr(self, "steps", None))
            return run(self, times_s)

        monkeypatch.setattr(solver, "run", noted)
    return solved


@pytest.mark.parametrize("seed", [12, 19, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (3, 31))])
def test_a_grid_gives_the_answer_of_the_exact_moments(kit, seed, solvers):
    press, question = kit.random(seed)
    found = start_up(press, exact_switching=False, **question)
    assert len(solvers) >= 2, "a grid is compared with one of half the step"
    assert None not in solvers
    exact = start_up(press, **question)
    assert largest_difference(found, exact) <= GRID_ERROR
    worst = np.abs(found.tension_N - exact.tension_N).max(axis=0) / exact.tension_N.max(axis=0)
    assert worst.max() <= GRID_ERROR
    assert found.energy.relative_residual <= 1e-3


@pytest.mark.parametrize(
    "seed", [4, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 18, 20, 23, 29))]
)
def test_where_only_drags_let_go_one_grid_is_enough_and_its_bound_holds(kit, seed, solvers, monkeypatch):
    """What drags that let go a little late change in any tension is below what their wrong forces' work allows."""
    used = []
    monkeypatch.setattr(
        module,
        "_is_near",
        lambda solver, found, own=module._is_near: used.append(solver) or own(solver, found),
    )
    press, question = kit.random(seed)
    found = start_up(press, exact_switching=False, **question)
    assert len(solvers) == len(used) == 1
    exact = start_up(press, **question)
    released = [guard.what for _, guard in used[0].changes]
    assert set(released) == {"release"}
    bound_N = used[0].late_tension_N
    assert 0.0 < np.abs(found.tension_N - exact.tension_N).max() <= bound_N
    assert bound_N < 0.01 * exact.tension_N.min()
    assert largest_difference(found, exact) <= GRID_ERROR


def test_between_two_steps_a_guard_is_looked_at_through_its_slopes():
    """The lowest point of (x − 0.3)² (x + 2) + 1 between 0 and 1."""
    (x,), (low,) = lowest_between(
        np.array([1.18]), np.array([0.49 * 3.0 + 1.0]), np.array([0.09 - 1.2]), np.array([0.49 + 1.4 * 3.0])
    )
    assert x == pytest.approx(0.3)
    assert low == pytest.approx(1.0)


def test_the_drive_changes_its_law_between_two_places_of_the_grid(kit):
    """Where no contact changes, a grid is exact whatever the drive's pieces are: also two within a part of a step."""
    times_s = [0.0, 0.10003, 0.100031, 0.4321, 0.43219]
    speed = DRIVE_LAWS["table"](time_s=times_s, speed_m_s=[0.0, 0.1, 0.1, 0.5, 0.5])
    question = {"speed": speed, "time_s": np.linspace(0.0, 0.6, 61), "friction": 5.0}
    press = kit.small(load_N_m=0.0)
    found, exact = (start_up(press, exact_switching=one, **question) for one in (False, True))
    np.testing.assert_allclose(found.tension_N, exact.tension_N, rtol=1e-9)
    np.testing.assert_allclose(found.roller_speed_rad_s, exact.roller_speed_rad_s, atol=1e-9)


def test_what_no_grid_settles_is_solved_at_its_exact_moments(kit, solvers, monkeypatch):
    monkeypatch.setattr(module, "largest_difference", lambda *_: 1.0)
    press = kit.small(load_N_m=40.0)
    question = {"speed": kit.run_up("ramp", 1.0, 0.3), "time_s": np.linspace(0.0, 0.5, 51), "friction": 0.2}
    found = start_up(press, exact_switching=False, **question)
    assert solvers[-1] is None
    np.testing.assert_array_equal(found.tension_N, start_up(press, **question).tension_N)


def test_a_roller_on_the_verge_of_slip_is_decided_at_the_exact_moments(kit, solvers):
    """Whether it slips at all is never left to a grid."""
    question = {"speed": kit.run_up("ramp", 1.0, 0.3), "time_s": np.linspace(0.0, 0.5, 51)}
    low, high = 0.2, 5.0
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        held = not start_up(kit.small(), friction=middle, **question).slips
        low, high = (low, middle) if held else (middle, high)
    solvers.clear()
    found = start_up(kit.small(), friction=high, exact_switching=False, **question)
    assert solvers[-1] is None
    assert not found.slips


def test_a_held_roller_stands_where_the_drive_s_law_changes(kit):
    """A piece of the drive ends between two places of the grid; what stands there goes on standing."""
    speed = kit.run_up("ramp", duration_s=0.4321)
    question = {"speed": speed, "time_s": np.linspace(0.0, 1.0, 101), "friction": 0.2}
    press = kit.paper(force_N=1100.0)
    found, exact = (start_up(press, exact_switching=one, **question) for one in (False, True))
    standing = np.abs(exact.roller_speed_rad_s[-1]) < 1e-9
    assert standing[press.is_driven].any()
    assert np.abs(found.roller_speed_rad_s[-1, standing]).max() < 1e-9
    assert largest_difference(found, exact) <= GRID_ERROR


def test_uneven_times_have_no_grid(kit, solvers):
    question = {"speed": kit.run_up("ramp", 1.0, 0.3), "time_s": [0.0, 0.1, 0.15], "friction": 0.2}
    start_up(kit.small(), exact_switching=False, **question)
    assert solvers == [None]


def test_other_rollers_that_slip_are_no_small_difference(kit):
    question = {"speed": kit.run_up("ramp", 1.0, 0.3), "time_s": np.linspace(0.0, 0.5, 51)}
    slippery, held = (start_up(kit.small(), friction=mu, **question) for mu in (0.2, 5.0))
    assert np.isinf(largest_difference(slippery, held))
    assert largest_difference(held, held) == 0.0


def planned(kit, seed, effects, accuracy=0.02):
    """Return the answer to a random press at 2 %, and how long it took, planning included."""
    press, question = kit.random(seed)
    mu, speed_m_s = question.pop("friction"), final_value(question["speed"])
    problem = PressProblem(
        press=press, closure="share", friction=WrapFriction.constant(mu), start_up=question | {"slip": True},
        speed_m_s=np.array([speed_m_s]), load_factor=np.array([1.0]),
    )  # fmt: skip
    begun = time.perf_counter()
    plan, model = make_plan(SYSTEM, problem, accuracy=accuracy, effects=effects)
    answer = SYSTEM.solve(model, plan.method)
    return plan, answer, time.perf_counter() - begun


@pytest.mark.slow
def test_thirty_random_presses_keep_the_promise_at_two_percent(kit):
    """The ratio of the times is logged (--log-cli-level=INFO), never asserted: it is the clock's."""
    ratios = []
    for seed in range(30):
        plan, found, quick_s = planned(kit, seed, "auto")
        _, exact, whole_s = planned(kit, seed, "all")
        assert "exact-switching" in plan.left_out
        assert SYSTEM.distance(found, exact, exact) <= plan.error_bound <= 0.02
        ratios.append(whole_s / quick_s)
    told = "auto is %.1f times as fast as all in the median, %.1f at least"
    logging.getLogger(__name__).info(told, median(ratios), min(ratios))
