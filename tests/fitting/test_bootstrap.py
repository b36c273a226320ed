"""The bootstrap against the covariance of a linear problem, its two levels of scatter, and its failures."""

import numpy as np
import pytest

from ropefric.errors import FitError, InputError
from ropefric.fitting.intervals import bootstrap
from ropefric.fitting.problem import batched_fit
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import LAWS


def solved(problem):
    return batched_fit(problem).theta[0]


def spread(found):
    return found.theta.std(axis=0, ddof=1)


def test_scatter_between_conditions_does_not_average_out_over_repeats(bench_problem):
    """For one coefficient and m repeats: var = Σ φ²(b² + w²/m)/(Σ φ²)², exactly."""
    problem = bench_problem(LAWS["constant"], repeats=6)
    found = bootstrap(problem, [0.2], n=4000, scatter=(0.01, 0.03), seed=1)
    phi = problem.conditions.wrap_angle_rad[::6]
    assert spread(found)[0] == pytest.approx(np.sqrt((0.03**2 + 0.01**2 / 6) / (phi**2).sum()), rel=0.05)


def test_the_seed_decides_and_nothing_else(bench_problem):
    problem = bench_problem(LAWS["size-exponential"], repeats=2)
    theta = solved(problem)
    for kind in ("parametric", "clustered"):
        first, again, other = (bootstrap(problem, theta, kind=kind, n=50, seed=s) for s in (7, 7, 8))
        assert first.theta.tobytes() == again.theta.tobytes()
        assert (first.theta != other.theta).any()


def test_resamples_that_cannot_hold_the_parameters_are_counted(bench_problem):
    plan = Conditions(
        wheel_radius_m=0.04,
        rope_radius_m=0.005,
        wrap_angle_rad=[2.0, 4, 7, 9],
        end_tension_N=[2.0, 8, 30, 90],
    )
    problem = bench_problem(LAWS["wrap-power"], plan=plan)
    found = bootstrap(problem, problem.start, kind="clustered", n=300)
    # four draws from four have fewer than three distinct ones in (4 + 6·14)/256 = 34 %
    assert 300 - len(found.theta) == pytest.approx(0.344 * 300, abs=35)
    assert "could not be refitted" in found.notes[0]


def test_no_refit_at_all_is_an_error(bench_problem):
    with pytest.raises(InputError, match="no spread"):
        bootstrap(bench_problem(LAWS["constant"]), [0.2], n=1)
    plan = Conditions(wheel_radius_m=0.02, rope_radius_m=0.005, wrap_angle_rad=[3.0, 4, 5], end_tension_N=2)
    problem = bench_problem(LAWS["bending"], [0.2, 1e-4], plan=plan, upper=np.array([3.0, 5.0]))
    with pytest.raises((FitError, InputError)):
        bootstrap(problem, [0.2, 4.0], n=10)
