"""The bootstrap against the covariance of a linear problem, its two levels of scatter, and its failures."""

import numpy as np
import pytest

from ropefric.errors import FitError, InputError
from ropefric.fitting.intervals import bootstrap
from ropefric.fitting.problem import batched_fit
from ropefric.fitting.statistics import two_level_scatter
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import ALL_LAWS, LAWS


def solved(problem):
    return batched_fit(problem).theta[0]


def spread(found):
    return found.theta.std(axis=0, ddof=1)


def test_parametric_spread_is_the_covariance_of_a_linear_law(bench_problem):
    problem = bench_problem(LAWS["constant-offset"])
    found = bootstrap(problem, solved(problem), n=4000, scatter=(0.01, 0.0), seed=3)
    best = solved(problem)
    J = problem.law.jacobian(best, problem.conditions)
    exact = 0.01 * np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
    assert np.allclose(spread(found), exact, rtol=0.05)  # 4000 draws know a standard deviation to 1.1 %
    expected = best[:, None] + 1.96 * exact[:, None] * [-1, 1]
    assert np.allclose(found.interval(), expected, atol=0.25 * exact.max())
    assert len(found.theta) == 4000
    assert found.notes == ()


def test_scatter_between_conditions_does_not_average_out_over_repeats(bench_problem):
    """For one coefficient and m repeats: var = Σ φ²(b² + w²/m)/(Σ φ²)², exactly."""
    problem = bench_problem(LAWS["constant"], repeats=6)
    found = bootstrap(problem, [0.2], n=4000, scatter=(0.01, 0.03), seed=1)
    phi = problem.conditions.wrap_angle_rad[::6]
    assert spread(found)[0] == pytest.approx(np.sqrt((0.03**2 + 0.01**2 / 6) / (phi**2).sum()), rel=0.05)


def test_two_level_scatter_is_recovered_and_used(bench_problem):
    levels = [
        two_level_scatter(problem, solved(problem))
        for problem in (bench_problem(LAWS["wrap-power"], between=0.02, repeats=5, seed=s) for s in range(40))
    ]
    assert np.mean([within for within, _ in levels]) == pytest.approx(0.01, rel=0.03)
    assert np.mean([between**2 for _, between in levels]) == pytest.approx(0.02**2, rel=0.08)
    problem = bench_problem(LAWS["constant"], between=0.02, repeats=5)
    own = two_level_scatter(problem, solved(problem))
    found, given = (bootstrap(problem, solved(problem), n=50, scatter=scatter) for scatter in (None, own))
    assert found.theta.tobytes() == given.theta.tobytes()
    alone = bench_problem(LAWS["constant"])
    within, between = two_level_scatter(alone, solved(alone))
    assert (within, between) == (pytest.approx(0.01, rel=0.3), 0.0)


@pytest.mark.parametrize("kind", ["parametric", "clustered"])
def test_every_law_is_bootstrapped_without_a_failure(bench_problem, kind):
    for law in ALL_LAWS.values():
        problem = bench_problem(law, std=0.005, repeats=2)
        found = bootstrap(problem, solved(problem), kind=kind, n=100)
        assert found.theta.shape[0] >= 99
        assert np.isfinite(found.theta).all()
        assert (spread(found)[problem.vary] > 0).all()
        assert (np.ptp(found.theta[:, ~problem.vary], axis=0) == 0).all()
        assert (found.interval()[:, 0] <= found.interval()[:, 1]).all()
        assert (found.interval() >= problem.lower[:, None])[problem.vary].all()


def test_the_seed_decides_and_nothing_else(bench_problem):
    problem = bench_problem(LAWS["size-exponential"], repeats=2)
    theta = solved(problem)
    for kind in ("parametric", "clustered"):
        first, again, other = (bootstrap(problem, theta, kind=kind, n=50, seed=s) for s in (7, 7, 8))
        assert first.theta.tobytes() == again.theta.tobytes()
        assert (first.theta != other.theta).any()


def test_clustered_keeps_repeats_together(bench_problem):
    """If repeats of a condition are copies, drawing conditions gives the same as if each were there once."""
    single = bench_problem(LAWS["constant"])
    double = bench_problem(LAWS["constant"], repeats=2, log_lift=np.repeat(single.log_lift, 2))
    a, b = (bootstrap(problem, [0.2], kind="clustered", n=100, seed=4) for problem in (single, double))
    assert np.allclose(a.theta, b.theta, rtol=1e-9)


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
