"""Posterior sampling against closed forms and profiles, and what it says of a chain that is too short."""

import sys

import numpy as np
import pytest

from ropefric.errors import FitError, InputError
from ropefric.fitting.levenberg import batched_fit
from ropefric.fitting.mcmc import ChainStatus, mcmc
from ropefric.fitting.profile import profile_intervals
from ropefric.friction.laws import LAWS


def test_a_missing_package_says_what_to_install(bench_problem, monkeypatch):
    monkeypatch.setitem(sys.modules, "emcee", None)
    with pytest.raises(FitError, match=r'pip install "ropefric\[mcmc\]"'):
        mcmc(bench_problem(LAWS["constant"]), [0.2])


@pytest.fixture
def emcee():
    return pytest.importorskip("emcee")


@pytest.mark.slow
def test_known_scatter_gives_the_normal_posterior_of_a_linear_law(bench_problem, emcee):
    problem = bench_problem(LAWS["constant-offset"])
    found = mcmc(problem, problem.start, n_steps=2500, n_burn=200, absolute_std=True, seed=1)
    J = problem.jacobian(problem.start)
    std = np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
    error = 1 / np.sqrt(found.effective_draws)
    assert found.status is ChainStatus.OK
    assert found.advice == ()
    assert found.effective_draws > 300
    assert np.allclose(found.std, std, rtol=4 * error)
    assert np.allclose(found.theta.mean(axis=0), batched_fit(problem).theta[0], atol=4 * error * std.max())


def test_a_nonlinear_law_agrees_with_its_profile(bench_problem, emcee):
    problem = bench_problem(LAWS["size-exponential"], std=0.005)
    best = batched_fit(problem).theta[0]
    found = mcmc(problem, best, n_steps=1500, n_burn=200)
    profile = profile_intervals(problem, best).ci
    assert np.allclose(found.ci95, profile, atol=0.12 * np.ptp(profile, axis=1)[:, None])


@pytest.mark.slow
def test_scale_widens_by_its_root(bench_problem, emcee):
    problem = bench_problem(LAWS["constant"])
    plain, scaled = (
        mcmc(problem, [0.2], n_steps=1000, n_burn=100, absolute_std=True, scale=s).std[0] for s in (1.0, 4.0)
    )
    assert scaled / plain == pytest.approx(2.0, rel=0.12)


def test_a_short_chain_is_said_to_be_short(bench_problem, emcee):
    problem = bench_problem(LAWS["coupled"], std=0.005)
    found = mcmc(problem, batched_fit(problem).theta[0], n_steps=60, n_burn=0)
    assert found.status is ChainStatus.TOO_SHORT
    assert "autocorrelation times; take at least" in found.advice[0]


def test_one_step_is_no_chain_but_an_answer(bench_problem, emcee):
    found = mcmc(bench_problem(LAWS["constant"]), [0.2], n_steps=1, n_burn=0)
    assert found.theta.shape == (32, 1)
    assert found.status is not ChainStatus.OK
    assert np.isfinite(found.autocorrelation_steps).all()


def test_bounds_fixed_parameters_seed_and_progress(bench_problem, emcee):
    problem = bench_problem(
        LAWS["wrap-power"],
        [0.2, -0.4, 0.0],
        lower=np.array([0.0, -0.999, 0.0]),
        vary=np.array([True, False, True]),
    )
    best = batched_fit(problem).theta[0]
    calls = []
    first = mcmc(
        problem,
        best,
        n_steps=100,
        n_burn=10,
        seed=5,
        progress=lambda done, total: calls.append((done, total)),
    )
    again = mcmc(problem, best, n_steps=100, n_burn=10, seed=5)
    other = mcmc(problem, best, n_steps=100, n_burn=10, seed=6)
    assert first.theta.tobytes() == again.theta.tobytes()
    assert (first.theta != other.theta).any()
    assert (first.theta[:, 1] == -0.4).all()
    assert first.std[1] == 0.0
    assert (first.theta[:, 2] >= 0.0).all()
    assert calls[-1] == (110, 110)
    assert len(calls) == 110


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n_steps": 0}, "are no chain"),
        ({"n_walkers": 3}, "3 walkers cannot move in 1 dimensions"),
        ({"scale": -1.0}, "scale is -1"),
        ({"theta": [0.2, 0.1]}, "law constant needs"),
    ],
)
def test_bad_input(bench_problem, emcee, arguments, message):
    with pytest.raises(InputError, match=message):
        mcmc(bench_problem(LAWS["constant"]), **({"theta": [0.2]} | arguments))


def test_nothing_free_and_exact_data(bench_problem, emcee):
    with pytest.raises(InputError, match="no parameter of constant is fitted"):
        mcmc(bench_problem(LAWS["constant"], vary=np.array([False])), [0.2])
    with pytest.raises(FitError, match="has no width"):
        mcmc(bench_problem(LAWS["constant"], std=0.0), [0.2])
