"""A tolerance means the tensions, which people read, and not only the states that carry them."""

import numpy as np
import pytest
from thinned import thinned

TIMES_S = np.array([0.1, 0.3, 0.7, 1.2])
BELTS = {"pliant": (2e6, 1e-3), "stiff": (1e7, 1e-2)}
ADAPTIVE = ("dop853", "radau", "lsoda")


@pytest.fixture(scope="module")
def start_up(kit):
    """A function: a start-up by name of its belt, and its tensions by the exact solution."""
    made = {}

    def of(name):
        if name not in made:
            EA_N, eta_s = BELTS[name]
            problem = kit.problem(kit.small(EA_N=EA_N, eta_s=eta_s), kit.run_up("s-curve", 1.0, 0.5))
            made[name] = problem, tensions(problem, kit.solve(problem, TIMES_S))
        return made[name]

    return of


def tensions(problem, states):
    return np.hstack([states[:, : problem.n_state], problem.inputs.at(TIMES_S)]) @ problem.motion.tension_N.T


@pytest.mark.parametrize("belt", list(BELTS))
@pytest.mark.parametrize("name", ADAPTIVE)
@pytest.mark.parametrize("tolerance", thinned([1e-4, 1e-6]))
def test_tensions_are_within_some_times_the_tolerance(kit, start_up, belt, name, tolerance):
    """Steps are controlled one by one and add up; the order of magnitude is what a tolerance can promise.

    With tolerances on ways and speeds alone, DOP853 is off by 4000 times the tolerance on the stiff belt.
    """
    problem, exact = start_up(belt)
    found = tensions(problem, kit.solve(problem, TIMES_S, name, tolerance=tolerance))
    assert np.abs(found / exact - 1.0).max() <= 10.0 * tolerance
