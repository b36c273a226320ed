"""Changes met inside the steps of a grid: the answer of the search for exact moments, at a fraction of its time."""

from dataclasses import replace

import numpy as np
import pytest
from thinned import thinned

from ropefric.systems.press.transient import capture
from ropefric.systems.press.transient import start_up as module
from ropefric.systems.press.transient.capture import GridSolver
from ropefric.systems.press.transient.drives import DRIVE_LAWS
from ropefric.systems.press.transient.exact import lowest_between
from ropefric.systems.press.transient.start_up import GRID_ERROR, largest_difference, start_up


@pytest.fixture
def solvers(monkeypatch):
    """What was solved, in turn, on a grid or not."""
    solved = []
    for solver in (GridSolver, module.HybridSolver):
        run = solver.run

        def noted(self, times_s, run=run):
            solved.append(self)
            return run(self, times_s)

        monkeypatch.setattr(solver, "run", noted)
    return solved


@pytest.mark.parametrize(
    "seed", [4, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 3, 12, 18, 19, 20, 23, 29, 31))]
)
def test_a_grid_gives_the_answer_of_the_exact_moments(kit, seed, solvers):
    press, question = kit.random(seed)
    found, exact = (start_up(press, exact_switching=one, **question) for one in (False, True))
    on_grid, searched = solvers
    assert isinstance(on_grid, GridSolver)
    assert [(one.what, one.place, one.direction) for _, one in on_grid.changes] == [
        (one.what, one.place, one.direction) for _, one in searched.changes
    ]
    moments = [[time_s for time_s, _ in one.changes] for one in solvers]
    np.testing.assert_allclose(*moments, atol=1e-6)
    assert largest_difference(found, exact) <= 1e-5
    worst = np.abs(found.tension_N - exact.tension_N).max(axis=0) / exact.tension_N.max(axis=0)
    assert worst.max() <= 1e-5
    assert found.energy.relative_residual <= 1e-5


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


def test_what_no_grid_is_fine_enough_for_is_solved_at_its_exact_moments(kit, solvers, monkeypatch):
    monkeypatch.setattr(capture, "_UNITS", 2)
    press = kit.small(load_N_m=40.0)
    question = {"speed": kit.run_up("ramp", 1.0, 0.3), "time_s": np.linspace(0.0, 0.5, 51), "friction": 0.2}
    found = start_up(press, exact_switching=False, **question)
    assert [isinstance(one, GridSolver) for one in solvers] == [True, False]
    np.testing.assert_array_equal(found.tension_N, start_up(press, **question).tension_N)


@pytest.mark.parametrize("apart", thinned([1e-4, 1e-6, 1e-8]))
def test_a_roller_on_the_verge_of_slip_is_decided_as_at_the_exact_moments(kit, apart):
    question = {"speed": kit.run_up("ramp", 1.0, 0.3), "time_s": np.linspace(0.0, 0.5, 51)}
    low, high = 0.2, 5.0
    while high - low > 0.5 * apart:
        middle = 0.5 * (low + high)
        held = not start_up(kit.small(), friction=middle, **question).slips
        low, high = (low, middle) if held else (middle, high)
    for mu in (low - apart, low, high, high + apart):
        found, exact = (
            start_up(kit.small(), friction=mu, exact_switching=one, **question) for one in (False, True)
        )
        assert bool(found.slips) == bool(exact.slips) == (mu <= low)
        assert largest_difference(found, exact) <= 1e-6


def test_a_held_roller_stands_where_the_drive_s_law_changes(kit):
    """A piece of the drive ends between two places of the grid; what stands there goes on standing."""
    speed = kit.run_up("ramp", duration_s=0.2161)
    question = {"speed": speed, "time_s": np.linspace(0.0, 0.6, 61), "friction": 0.2}
    press = kit.paper(force_N=1100.0)
    found, exact = (start_up(press, exact_switching=one, **question) for one in (False, True))
    standing = np.abs(exact.roller_speed_rad_s[-1]) < 1e-9
    assert standing[press.is_driven].any()
    assert np.abs(found.roller_speed_rad_s[-1, standing]).max() < 1e-9
    assert largest_difference(found, exact) <= GRID_ERROR


def test_uneven_times_have_no_grid(kit, solvers):
    question = {"speed": kit.run_up("ramp", 1.0, 0.3), "time_s": [0.0, 0.1, 0.15], "friction": 0.2}
    start_up(kit.small(), exact_switching=False, **question)
    assert not any(isinstance(one, GridSolver) for one in solvers)


def test_other_rollers_that_slip_are_no_small_difference(kit):
    question = {"speed": kit.run_up("ramp", 1.0, 0.3), "time_s": np.linspace(0.0, 0.5, 51)}
    slippery, held = (start_up(kit.small(), friction=mu, **question) for mu in (0.2, 5.0))
    assert np.isinf(largest_difference(slippery, held))
    assert largest_difference(held, held) == 0.0


def test_a_span_that_is_slack_all_along_is_compared_by_where_it_settles(kit):
    found = start_up(kit.small(load_N_m=0.0), speed=kit.run_up("s-curve", 1.0, 0.3),
                     time_s=np.linspace(0.0, 0.5, 51), friction=0.5)  # fmt: skip
    slack, moved = (replace(found, tension_N=found.tension_N * [0.0, 1.0, 1.0]) for _ in range(2))
    assert largest_difference(slack, moved) == 0.0
    settled = moved.settled._replace(tension_N=moved.settled.tension_N * (1.0 + 1e-9))
    assert 0.0 < largest_difference(slack, replace(moved, settled=settled)) <= 1.1e-9
    assert largest_difference(found, slack) > 1e9
