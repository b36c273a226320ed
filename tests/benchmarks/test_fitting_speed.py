"""What the batched fit saves against lmfit, and the closed forms against root finding and quadrature.

Run with `pytest tests/benchmarks --benchmark-only -s`. Ratios are printed and never asserted on: clocks are noisy.
What is asserted is that both ways find the same.
"""

import sys
from time import perf_counter

import lmfit
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from ropefric.fitting.problem import FitProblem, batched_fit
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import LAWS

LAW = LAWS["coupled"]
TRUTH = np.array([0.2, -0.2, -0.3, -0.4, 0.05])
STD = 0.01
LOOP = 40
# lmfit stops when χ² falls by less than 1.5e-8 of itself, which is a step of 2e-3 root mean square residuals.
LIKE_LMFIT = 1e-3
RESAMPLES = 2000


def lift_force_N(law, theta, conditions):
    return np.exp(law.log_lift(theta, conditions))


@pytest.fixture(scope="module")
def problem():
    """216 conditions: 6 wheels, 6 wraps, 6 loads."""
    wheel, wrap, load = np.meshgrid([0.02, 0.03, 0.04, 0.06, 0.08, 0.12],
                                    np.pi * np.array([0.5, 1, 2, 3, 4, 6]),
                                    [2.0, 5.0, 10.0, 20.0, 80.0, 200.0])  # fmt: skip
    plan = Conditions(wheel_radius_m=wheel.ravel(), rope_radius_m=0.0049, wrap_angle_rad=wrap.ravel(),
                      end_tension_N=load.ravel())  # fmt: skip
    noise = STD * np.random.default_rng(1).standard_normal(216)
    return FitProblem(law=LAW, conditions=plan, log_lift=LAW.log_lift(TRUTH, plan) + noise,
                      std=np.full(216, STD), group=np.arange(216),
                      start=np.array([0.3, -0.3, -0.5, -0.3, 0.08]), lower=LAW.lower, upper=LAW.upper,
                      vary=np.ones(5, bool))  # fmt: skip


def lmfit_fit(problem, log_lift, start):
    """The same law, vectorised over the conditions, through lmfit with numerical derivatives."""
    parameters = lmfit.Parameters()
    for p, value in zip(problem.law.parameters, start, strict=True):
        parameters.add(p.name, value=value, min=p.lower, max=p.upper)

    def residual(values):
        theta = [values[name].value for name in problem.law.parameter_names]
        return (problem.law.log_lift(theta, problem.conditions) - log_lift) / problem.std

    return np.array(list(lmfit.minimize(residual, parameters).params.valuesdict().values()))


def seconds(work, times=5):
    """Best of several: what the work costs when nothing else runs."""
    spent = []
    for _ in range(times):
        begin = perf_counter()
        work()
        spent.append(perf_counter() - begin)
    return min(spent)


def say(what, fast, slow):
    sys.stdout.write(
        f"\n{what}: {fast * 1e3:.3g} ms against {slow * 1e3:.3g} ms, {slow / fast:.3g} times faster\n"
    )


@pytest.mark.benchmark(group="single coupled fit, 216 conditions")
def test_a_single_fit(benchmark, problem):
    ours = benchmark(batched_fit, problem, tolerance=LIKE_LMFIT).theta[0]
    theirs = lmfit_fit(problem, problem.log_lift, problem.start)
    exact = batched_fit(problem).theta[0]
    assert np.abs(ours - exact).max() <= np.abs(theirs - exact).max()
    assert np.allclose(exact, theirs, rtol=1e-4)
    slow = seconds(lambda: lmfit_fit(problem, problem.log_lift, problem.start), times=20)
    for what, tolerance in [("to lmfit's accuracy or better", LIKE_LMFIT), ("to 1e-9 standard errors", 1e-9)]:
        fast = seconds(lambda tolerance=tolerance: batched_fit(problem, tolerance=tolerance), times=20)
        say(f"one coupled fit {what}", fast, slow)


@pytest.mark.benchmark(group="2000 refits, 216 conditions")
def test_many_refits(benchmark, problem):
    best = batched_fit(problem).theta[0]
    rng = np.random.default_rng(2)
    every = LAW.log_lift(best, problem.conditions) + STD * rng.standard_normal((RESAMPLES, 216))
    found, data = (
        benchmark.pedantic(batched_fit, (problem, every, best), rounds=3, iterations=1),
        every[:LOOP],
    )
    ours = batched_fit(problem, data, best).theta
    theirs = np.array([lmfit_fit(problem, one, best) for one in data])
    assert np.allclose(ours, theirs, atol=1e-3 * found.theta.std(axis=0))
    fast = seconds(lambda: batched_fit(problem, every, best), times=3)
    slow = seconds(lambda: [lmfit_fit(problem, one, best) for one in data], times=2) * RESAMPLES / LOOP
    say(f"{RESAMPLES} refits", fast, slow)


def designs(n):
    rng = np.random.default_rng(11)
    return Conditions(wheel_radius_m=rng.uniform(0.02, 0.1, n), rope_radius_m=0.005,
                      wrap_angle_rad=rng.uniform(1, 12, n), end_tension_N=rng.uniform(1.5, 200, n))  # fmt: skip


def lift_by_quadrature(conditions):
    mu_inf, a, b, c, d = TRUTH
    forces = []
    for r, phi, tension in zip(
        conditions.size_ratio, conditions.wrap_angle_rad, conditions.end_tension_N, strict=True
    ):
        strength = mu_inf * (1 - np.exp(a * r + b))

        def mu(angle, strength=strength):
            return strength * angle**c + d

        def short(angle, mu=mu, tension=tension):
            return quad(mu, 0, angle)[0] - np.log(tension)

        start = brentq(short, 1e-9, 200)
        forces.append(tension * np.exp(quad(mu, start, start + phi)[0]))
    return np.array(forces)


@pytest.mark.benchmark(group="lift force of a million designs")
def test_lift_forces(benchmark):
    many, few = designs(1_000_000), designs(200)
    forces = benchmark.pedantic(lift_force_N, (LAW, TRUTH, many), rounds=3, iterations=1)
    assert len(forces) == 1_000_000
    assert np.allclose(lift_force_N(LAW, TRUTH, few), lift_by_quadrature(few), rtol=1e-8)
    fast = seconds(lambda: lift_force_N(LAW, TRUTH, many), times=3) / 1e6
    slow = seconds(lambda: lift_by_quadrature(few), times=2) / 200
    say("a lift force", fast, slow)
