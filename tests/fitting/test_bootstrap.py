"""The bootstrap against the covariance of a linear problem, its two levels of scatter, and its failures."""

import numpy as np
import pytest

from ropefric.errors import FitError, InputError
from ropefric.fitting.intervals import bootstrap
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import LAWS


def spread(found):
    return found.theta.std(axis=0, ddof=1)


def test_scatter_between_conditions_does_not_average_out_over_repeats(bench_problem):
    """For one coefficient and m repeats: var = Σ φ²(b² + w²/m)/(Σ φ²)², exactly."""
    problem = bench_problem(LAWS["constant"], repeats=6)
    found = bootstrap(problem, [0.2], n=4000, scatter=(0.01, 0.03), seed=1)
    phi = problem.conditions.wrap_angle_rad[::6]
    assert spread(found)[0] == pytest.approx(np.sqrt((0.03**2 + 0.01**2 / 6) / (phi**2).sum()), rel=0.05)


def test_no_refit_at_all_is_an_error(bench_problem):
    with pytest.raises(InputError, match="no spread"):
        bootstrap(bench_problem(LAWS["constant"]), [0.2], n=1)
    plan = Conditions(wheel_radius_m=0.02, rope_radius_m=0.005, wrap_angle_rad=[3.0, 4, 5], end_tension_N=2)
    problem = bench_problem(LAWS["bending"], [0.2, 1e-4], plan=plan, upper=np.array([3.0, 5.0]))
    with pytest.raises((FitError, InputError)):
        bootstrap(problem, [0.2, 4.0], n=10)
