"""Changes met inside the steps of a grid: the same moments on any grid, and nothing overlooked between two steps."""

from dataclasses import replace

import numpy as np
import pytest

from ropefric.systems.press.transient.drives import DRIVE_LAWS
from ropefric.systems.press.transient.exact import lowest_between
from ropefric.systems.press.transient.start_up import largest_difference, start_up


@pytest.mark.parametrize(
    "seed", [4, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 3, 12, 19, 23, 31))]
)
def test_another_grid_gives_the_same_answer(kit, seed):
    """A grid of steps between a fifth and a half as long."""
    press, question = kit.random(seed)
    end_s = float(question["time_s"][-1])
    found, fine = (start_up(press, **question | {"time_s": np.linspace(0.0, end_s, n)}) for n in (501, 13001))
    assert [slip[::3] for slip in found.slips] == [slip[::3] for slip in fine.slips]
    moments = [[slip[1:3] for slip in one.slips] for one in (found, fine)]
    np.testing.assert_allclose(*moments, atol=1e-6)
    np.testing.assert_allclose(found.tension_N, fine.tension_N[::26], atol=1e-5 * fine.tension_N.max())
    assert found.energy.drive[-1] == pytest.approx(fine.energy.drive[-1], rel=1e-6)
    assert max(found.energy.relative_residual, fine.energy.relative_residual) <= 1e-5


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
    press, asked_s = kit.small(load_N_m=0.0), np.linspace(0.0, 0.6, 61)
    found = start_up(press, speed=speed, time_s=asked_s, friction=5.0)
    problem = kit.problem(press, speed)
    exact = np.hstack([kit.solve(problem, asked_s), problem.inputs.at(asked_s)])
    np.testing.assert_allclose(found.tension_N, exact @ problem.motion.tension_N.T, rtol=1e-9)
    rims_m_s = found.roller_speed_rad_s * press.radius_m
    np.testing.assert_allclose(rims_m_s, exact @ problem.motion.rim_speed_m_s.T, atol=1e-9)


def test_a_held_roller_stands_where_the_drive_s_law_changes(kit):
    """A piece of the drive ends between two places of the grid; what stands there goes on standing."""
    speed, press = kit.run_up("ramp", duration_s=0.2161), kit.paper(force_N=1100.0)
    found = start_up(press, speed=speed, time_s=np.linspace(0.0, 0.6, 61), friction=0.2)
    standing = found.at_end == "stands"
    assert standing[press.is_driven].any()
    assert np.abs(found.roller_speed_rad_s[-1, standing]).max() < 1e-9


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
