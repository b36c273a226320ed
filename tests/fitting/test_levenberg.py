"""The batched fit against scipy, against known truth, at bounds, and on data that cannot be fitted."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

from ropefric.fitting.fit import guess
from ropefric.fitting.problem import batched_fit
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import ALL_LAWS, LAWS


def scipy_fit(problem, log_lift, start):
    """Bounded trust-region fit of one data set, from a start moved off the bounds."""
    free = problem.vary

    def whole(part):
        theta = problem.start.copy()
        theta[free] = part
        return theta

    low, high = problem.lower[free], problem.upper[free]
    found = least_squares(lambda part: (problem.law.log_lift(whole(part),
        problem.conditions) - log_lift) / problem.std, np.clip(start[free], low + 1e-9, high - 1e-9),
        lambda part: problem.jacobian(whole(part))[:, free], bounds=(low, high), x_scale="jac", xtol=1e-15,
        ftol=1e-15, gtol=1e-15)  # fmt: skip
    return whole(found.x), 2 * found.cost


def test_many_resamples_agree_with_scipy(bench_problem):
    for law in ALL_LAWS.values():
        problem = bench_problem(law, std=0.005)
        rng = np.random.default_rng(5)
        data = problem.log_lift + 0.005 * rng.standard_normal((60, problem.n_points))
        fit = batched_fit(problem, data)
        assert fit.converged.all()
        free = problem.vary
        for i in range(0, 60, 20):
            theta, chi2 = scipy_fit(problem, data[i], fit.theta[i])
            assert fit.chi2[i] <= chi2 * (1 + 1e-12)
            inside = (fit.theta[i] > problem.lower) & (fit.theta[i] < problem.upper) & free
            J = problem.jacobian(fit.theta[i])[:, free]
            std = np.sqrt(np.diag(np.linalg.pinv(J.T @ J)))
            if (inside == free).all():  # an interior-point method only comes near a bound
                # scipy stops where a step changes χ² in the 15th digit only: 3e-8·√χ² standard errors, and its next
                # steps shrink slowly where the model bends; our own gradient is held to less below
                far = np.abs(fit.theta[i] - theta)[free]
                assert (far <= 1e-8 * np.abs(theta[free]) + 3e-6 * std).all()
            gradient = problem.jacobian(fit.theta[i]).T @ ((law.log_lift(fit.theta[i],
                problem.conditions) - data[i]) / problem.std)  # fmt: skip
            spread = np.linalg.norm(problem.jacobian(fit.theta[i]), axis=0)
            assert (np.abs(gradient[inside]) < 1e-7 * spread[inside]).all()
            at_lower, at_upper = (free & (fit.theta[i] <= problem.lower),
                free & (fit.theta[i] >= problem.upper))  # fmt: skip
            assert (gradient[at_lower] >= 0).all()
            assert (gradient[at_upper] <= 0).all()


def test_clean_data_give_the_truth_from_the_guess(bench_problem):
    for law in ALL_LAWS.values():
        problem = bench_problem(law, std=0.0)
        truth = problem.start
        fit = batched_fit(problem, starts=guess(law, problem.conditions, problem.log_lift))
        assert fit.converged.all()
        assert np.allclose(fit.theta[0], truth, rtol=1e-8, atol=1e-10)
        assert fit.chi2[0] < 1e-16


def test_multiplicity_zero_is_absence(bench_problem):
    problem = bench_problem(LAWS["size-exponential"])
    counts = np.ones(64)
    counts[:10] = 0.0
    left_out = batched_fit(problem, multiplicity=counts)
    rest = {name: getattr(problem, name)[10:] for name in ("log_lift", "std", "group")}
    shorter = replace(problem, conditions=problem.conditions.select(np.arange(10, 64)), **rest)
    assert np.allclose(left_out.theta, batched_fit(shorter).theta, rtol=1e-9)


def test_together_is_one_by_one_whatever_the_company(bench_problem):
    problem = bench_problem(LAWS["coupled"])
    data = problem.log_lift + 0.01 * np.random.default_rng(1).standard_normal((30, 64))
    starts = problem.start * np.random.default_rng(2).uniform(0.8, 1.0, (30, 5))
    together = batched_fit(problem, data, starts)
    alone = [batched_fit(problem, y, start) for y, start in zip(data, starts, strict=True)]
    assert np.allclose(together.theta, [fit.theta[0] for fit in alone], rtol=1e-7)


def test_a_bound_in_the_way_is_kept_and_the_others_are_fitted_around_it(bench_problem):
    law = LAWS["constant-offset"]
    problem = bench_problem(law, [0.2, 0.1], upper=np.array([5.0, 0.05]))
    fit = batched_fit(problem)
    assert fit.converged[0]
    assert fit.theta[0, 1] == 0.05
    held = batched_fit(problem, starts=[0.3, 0.05], vary=[True, False])
    assert np.allclose(fit.theta, held.theta, rtol=1e-10)


def test_fixed_parameters_stay_where_they_are_even_outside_the_bounds(bench_problem):
    problem = bench_problem(LAWS["constant-offset"], upper=np.array([5.0, 0.0]))
    starts = np.array([[0.2, 0.3], [0.1, -0.2], [0.2, 0.0]])
    vary = np.array([[True, False], [True, False], [False, False]])
    fit = batched_fit(problem, starts=starts, vary=vary)
    assert (fit.theta[:, 1].tolist(), fit.theta[2].tolist()) == ([0.3, -0.2, 0.0], [0.2, 0.0])
    assert fit.converged.all()


def test_an_inadmissible_step_is_turned_down(bench_problem):
    """Rigidity so large that the rope cannot bend: full steps from here leave where the law has an answer."""
    law = LAWS["bending"]
    problem = bench_problem(law, [0.2, 3e-4])
    edge = 2 * (0.02 + 0.0049) ** 2 * 2.0
    fit = batched_fit(problem, starts=[[0.9, 0.28 * edge], [0.05, 1e-8]])
    assert np.allclose(fit.theta, batched_fit(problem).theta, rtol=1e-6)
    assert fit.converged.all()


def test_an_inadmissible_start_falls_back_and_a_hopeless_one_is_flagged(bench_problem):
    law = LAWS["bending"]
    problem = bench_problem(law)
    fit = batched_fit(problem, starts=[[0.2, 9.0], problem.start])
    assert np.allclose(fit.theta[0], fit.theta[1], rtol=1e-8)
    stuck = batched_fit(replace(problem, start=np.array([0.2, 9.0])))
    assert not stuck.converged[0]
    assert np.isinf(stuck.chi2[0])
    assert np.isfinite(stuck.theta).all()


@settings(max_examples=60, deadline=None)
@given(law=st.sampled_from(list(ALL_LAWS.values())), seed=st.integers(0, 10**6),
    noise=st.sampled_from([0.0, 0.1, 2.0]))  # fmt: skip
def test_no_nan_whatever_the_data(bench_problem, law, seed, noise):
    rng = np.random.default_rng(seed)
    problem = bench_problem(law)
    span = np.where(np.isfinite(problem.upper), problem.upper, 1.0) - problem.lower
    starts = problem.lower + span * rng.uniform(0, 1, (6, len(span)))
    data = problem.log_lift + noise * rng.standard_normal((6, 64))
    fit = batched_fit(problem, data, starts, max_iterations=40)
    assert np.isfinite(fit.theta).all()
    assert not np.isnan(fit.chi2).any()
    assert not fit.converged[np.isinf(fit.chi2)].any()
    free = problem.vary
    assert (fit.theta >= problem.lower)[:, free].all()
    assert (fit.theta <= problem.upper)[:, free].all()


def test_one_wheel_only_still_answers(bench_problem):
    """(4) cannot be told from a constant on one wheel; the fit says a minimum, and no number is NaN."""
    plan = Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=np.arange(1, 9),
        end_tension_N=20)  # fmt: skip
    problem = bench_problem(LAWS["size-exponential"], plan=plan)
    fit = batched_fit(problem)
    constant = batched_fit(bench_problem(LAWS["constant"], plan=plan, log_lift=problem.log_lift))
    assert np.isfinite(fit.theta).all()
    assert fit.chi2[0] == pytest.approx(constant.chi2[0], rel=1e-9)


def test_giving_up_is_flagged(bench_problem):
    problem = bench_problem(LAWS["coupled"])
    fit = batched_fit(problem, starts=[1.0, -5.0, -3.0, -0.9, 1.0], max_iterations=2)
    assert not fit.converged[0]
