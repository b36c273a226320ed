"""The search itself: against every plan there is, and against plans known from theory."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ropefric.fitting.exchange import Evidence, Exchange, best_plan


def told(rows, shares=None):
    """What means tell whose shares of common errors leave them a scatter of their own."""
    shares = shares or {}
    left = 1.0 - sum((share**2 for share in shares.values()), np.zeros(len(rows)))
    return Evidence(rows, np.sqrt(left), shares)


NOTHING = told(np.zeros((0, 2)))


def line(points):
    return np.stack([np.ones_like(points), points], axis=1)


def drawn(seed, n=11, old=2, shared=()):
    """Candidates, what is known, and targets; names of errors that each takes part in, some in both."""
    rng = np.random.default_rng(seed)

    def means(n):
        return told(rng.standard_normal((n, 3)), {name: rng.uniform(-0.5, 0.5, n) for name in shared})

    return means(n), means(old), rng.standard_normal((2, 3))


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10_000), st.integers(0, 2), st.sampled_from(["", "abc"]))
def test_no_plan_of_all_there_are_is_better(seed, old, shared):
    exchange = Exchange(*drawn(seed, 8, old=old, shared=shared))
    every = min(exchange.value(np.array(plan)) for plan in combinations(range(8), 4))
    plan = best_plan(exchange, 4)
    # Exchanges of one condition may end in a plan that only exchanges of two improve: by less than 1 % of a variance.
    assert exchange.value(plan) <= every + 0.01


def test_values_of_exchanges_are_those_of_the_plans():
    rest = np.array([0, 2, 5, 6])
    for shared in ("", "abc"):
        exchange = Exchange(*drawn(3, n=9, shared=shared))
        direct = [exchange.value(np.append(rest, i)) for i in range(9)]
        np.testing.assert_allclose(exchange.with_each(rest), direct, rtol=1e-8)


def test_the_value_of_a_plan_is_the_error_that_its_means_leave():
    candidates, known, targets = drawn(5, shared="abc")
    exchange = Exchange(candidates, known, targets, balance=0.0)
    plan = np.array([1, 4, 6, 7])
    chosen = told(candidates.rows[plan], {name: share[plan] for name, share in candidates.shares.items()})
    std, _ = known.joined(chosen).errors(targets)
    assert exchange.value(plan) == pytest.approx(np.log(np.mean(std**2)), rel=1e-9)


def test_a_mean_that_shares_its_error_adds_less_than_a_new_one():
    """One number from six means: four share an error that is nine tenths of their variance, two have their own.

    One of the four and both others leave the variance 0.38, (0.9 × (n/3)² + 0.1 n/9 + m/9) for n of the four and m
    others; independent, any three would leave a third.
    """
    share = np.where(np.arange(6) < 4, np.sqrt(0.9), 0.0)
    one, nothing = np.ones((1, 1)), told(np.zeros((0, 1)))
    exchange = Exchange(told(np.ones((6, 1)), {"wheel": share}), nothing, one, balance=0.0)
    plan = best_plan(exchange, 3, starts=4)
    assert np.count_nonzero(plan < 4) == 1
    assert np.exp(exchange.value(plan)) == pytest.approx((0.9 + 0.1 + 2.0) / 9.0)
    assert np.exp(exchange.value(np.arange(3))) == pytest.approx(0.9 + 0.1 / 3.0)


def test_units_of_the_parameters_do_not_matter():
    points = np.linspace(0.1, 2.0, 15)
    rows, target = line(points), np.array([[1.0, 3.0]])
    scale = np.array([1e-5, 1e4])
    plain = best_plan(Exchange(told(rows), NOTHING, target), 4)
    scaled = best_plan(Exchange(told(rows * scale), NOTHING, target * scale), 4)
    assert plain.tolist() == scaled.tolist()


def test_a_far_point_is_reached_with_the_weights_of_hoel_and_levine():
    """Extrapolating a line from [-1, 1] to 3: two thirds of all tests stand at the near end."""
    points = np.concatenate([np.linspace(-1.0, -0.999, 12), np.linspace(0.999, 1.0, 12)])
    choice = told(line(points)), NOTHING, np.array([[1.0, 3.0]])
    exchange = Exchange(*choice, balance=0.0)
    plan = exchange.improved(exchange.greedy(12))
    assert np.count_nonzero(points[plan] > 0.0) == 8


def test_what_is_known_is_not_asked_again():
    points = np.linspace(-1.0, 1.0, 21)
    known = np.tile([[1.0, -1.0]], (50, 1))
    plan = best_plan(Exchange(told(line(points)), told(known), np.array([[1.0, 0.0]])), 3)
    assert (points[plan] > 0.7).all()


def test_one_prediction_alone_leaves_parameters_undetermined_unless_balanced():
    points = np.linspace(0.1, 2.0, 20)
    choice = told(line(points)), NOTHING, np.array([[1.0, 1.0]])
    plans = {}
    for balance in (0.0, 0.3):
        exchange = Exchange(*choice, balance=balance)
        plans[balance] = exchange.improved(exchange.greedy(6))
    rows = choice[0].rows
    volume = {balance: -np.linalg.slogdet(rows[plan].T @ rows[plan])[1] for balance, plan in plans.items()}
    by_variance = Exchange(*choice, balance=0.0)
    variance = {balance: by_variance.value(plan) for balance, plan in plans.items()}
    assert volume[0.3] <= volume[0.0]
    assert variance[0.3] - variance[0.0] < 0.1


def test_an_error_beside_which_nothing_else_counts_leaves_a_plan():
    rng = np.random.default_rng(4)
    candidates = told(1e3 * rng.standard_normal((12, 3)), {"chain": np.ones(12)})
    search = Exchange(candidates, told(np.zeros((0, 3))), rng.standard_normal((1, 3)))
    plan = best_plan(search, 5)
    assert len(set(plan.tolist())) == 5
    assert np.isfinite(search.value(plan))
