"""A predicted lift force on a wheel that is known only so well."""

import dataclasses
import math

import numpy as np
import pytest
from pulled import grid, table_at

from ropefric.errors import InputError
from ropefric.fitting.budgets import lift_model, state_lift
from ropefric.fitting.fit import fit_law
from ropefric.fitting.predict import predict
from ropefric.fitting.scatter import ALL
from ropefric.friction.condition import Conditions, one_condition
from ropefric.friction.laws import ALL_LAWS
from ropefric.uncertainty.budget import directions, linear_budget, propagate, state_uncertainty

WHEEL = one_condition(0.04, 0.005, 8.0, 60.0)
UNSURE = {"wheel_radius_m": 2e-4, "rope_radius_m": 5e-5, "wrap_angle_rad": 0.03, "end_tension_N": 0.5}


def test_pairs_are_the_diagonal_of_every_set_at_every_condition():
    rng = np.random.default_rng(4)
    at = Conditions(wheel_radius_m=0.04 * (1 + 0.05 * rng.standard_normal(30)), rope_radius_m=0.005,
        wrap_angle_rad=8 + 0.5 * rng.standard_normal(30),
        end_tension_N=60 + rng.standard_normal(30))  # fmt: skip
    for law in ALL_LAWS.values():
        start = np.array([item.start for item in law.parameters])
        theta = np.clip(start * (1 + 0.02 * rng.standard_normal((30, start.size))), law.lower, law.upper)
        np.testing.assert_array_equal(law.log_lift_of_pairs(theta, at), np.diag(law.log_lift(theta, at)))


def test_a_pair_without_an_answer_is_nan_and_leaves_the_others():
    at = Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=8, end_tension_N=[0.5, 60])
    found = ALL_LAWS["wrap-power"].log_lift_of_pairs(np.tile([0.2, -0.5, 0.1], (2, 1)), at)
    assert np.isnan(found).tolist() == [True, False]


@pytest.mark.parametrize("one_pull", [False, True])
def test_sensitivities_are_the_derivatives(slopes_of, wrap_fit, one_pull):
    model = lift_model(wrap_fit, WHEEL, UNSURE, one_pull=one_pull)
    np.testing.assert_allclose(model.sensitivities, slopes_of(model), rtol=2e-5, atol=1e-3)


def test_of_an_exact_wheel_the_budget_is_the_prediction(wrap_fit):
    budget = linear_budget(lift_model(wrap_fit, WHEEL, {}))
    found = predict(wrap_fit, WHEEL)
    assert budget.estimate == pytest.approx(found.lift_force_N[0], rel=1e-12)
    assert budget.combined == pytest.approx(found.std_N[0], rel=1e-9)
    assert budget.effective_dof == pytest.approx(found.dof)
    assert budget.lines[0].contribution == pytest.approx(budget.combined)


def test_one_pull_is_as_uncertain_as_the_prediction_interval(wrap_fit):
    budget = linear_budget(lift_model(wrap_fit, WHEEL, {}, one_pull=True))
    low, high = predict(wrap_fit, WHEEL).prediction_interval_N[0]
    # The one goes up and down alike, by t(ν_eff); the other is exponentiated, by t of the law's degrees of freedom.
    assert budget.interval[1] - budget.interval[0] == pytest.approx(high - low, rel=0.08)


def test_each_uncertainty_of_the_wheel_adds_its_square(wrap_fit):
    def combined(**parts):
        return linear_budget(lift_model(wrap_fit, WHEEL, parts)).combined

    whole, law = combined(**UNSURE), combined()
    parts = [combined(**{name: value}) ** 2 - law**2 for name, value in UNSURE.items()]
    assert whole**2 == pytest.approx(law**2 + sum(parts), rel=1e-9)


def test_directions_of_a_block_rebuild_its_covariance_in_any_unit(wrap_fit):
    covariance = np.asarray(wrap_fit.covariance)
    scale = np.diag([1e6, 1.0, 1e-6])
    for turned in (covariance, scale @ covariance @ scale):
        found = directions(turned)
        np.testing.assert_allclose(found @ found.T, turned, rtol=1e-9)


def test_a_wheel_known_too_badly_is_found_out_by_the_draws(wrap_fit):
    stated = state_uncertainty(lift_model(wrap_fit, WHEEL, {"wrap_angle_rad": 3.0}), draws=50_000, seed=1)
    assert str(stated.status) == "draws-disagree"
    assert not stated.trustworthy
    low, high = stated.drawn.symmetric_interval
    assert low > 0.0  # no force is negative, which y − U says
    assert stated.budget.interval[0] < low
    assert high > stated.budget.interval[1]


def test_parameters_that_the_data_do_not_show_leave_the_force_as_sure_as_its_prediction():
    """One end tension: five parameters lie in a curved valley, along which the forces stay what they are."""
    at = grid([0.02, 0.035, 0.06], [3.0, 6.0, 9.0, 12.0], [60.0], 4)
    log_lift = ALL_LAWS["coupled"].log_lift(np.array([0.5, -0.25, -0.05, -0.6, 0.08]), at)
    scatter = 0.015 * np.random.default_rng(3).standard_normal(len(at))
    fit = fit_law(table_at(at, log_lift + scatter), "coupled")
    stated, found = state_lift(fit, WHEEL, {}), predict(fit, WHEEL)
    assert str(fit.status) == "unidentifiable"
    assert stated.drawn.agrees
    assert stated.drawn.symmetric_interval == pytest.approx(found.interval_N[0], rel=0.02)


def test_same_seed_same_statement(wrap_fit):
    model = lift_model(wrap_fit, WHEEL, UNSURE)
    first, second = (state_uncertainty(model, draws=20_000, seed=7).to_dict() for _ in range(2))
    assert first == second
    assert state_uncertainty(model, draws=20_000, seed=8).to_dict()["monte_carlo"] != first["monte_carlo"]


def test_what_cannot_be_stated_is_told(wrap_fit):
    two = Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=[1, 2], end_tension_N=20)
    with pytest.raises(InputError, match="a budget is of one"):
        lift_model(wrap_fit, two, UNSURE)
    unknown = dataclasses.replace(wrap_fit.scatter, names=tuple(ALL for _ in wrap_fit.scatter.names))
    lost = dataclasses.replace(wrap_fit, scatter=unknown)
    with pytest.raises(InputError, match="knows no scatter"):
        lift_model(lost, WHEEL, UNSURE, one_pull=True)
    with pytest.raises(InputError, match="the level is 1"):
        linear_budget(lift_model(wrap_fit, WHEEL, UNSURE), level=1.0)
    model = lift_model(wrap_fit, WHEEL, UNSURE)
    with pytest.raises(InputError, match="9 draws"):
        propagate(model, linear_budget(model), draws=9)


def test_a_budget_says_that_its_fit_gives_no_interval(wrap_fit):
    one = fit_law(table_at(grid([0.04], [6.0], [20.0], 4), np.log([66.0, 66.7, 65.8, 66.3])), "constant")
    said = [state_lift(fit, WHEEL, {"wrap_angle_rad": 0.03}, draws=10_000).notes for fit in (one, wrap_fit)]
    assert ["the fit gives no interval" in " ".join(notes) for notes in said] == [True, False]


def test_a_law_that_was_held_leaves_the_wheel_alone_uncertain():
    table = table_at(grid([0.04], [3, 3, 6, 6], [20]), np.log([36.0, 36.8, 66.0, 66.7]))
    fit = fit_law(table, "constant", fixed={"mu": 0.2})
    wheel = one_condition(0.04, 0.005, 4.5, 20.0)
    budget = linear_budget(lift_model(fit, wheel, {"wrap_angle_rad": 0.03}))
    assert budget.combined == pytest.approx(20.0 * math.exp(0.9) * 0.2 * 0.03, rel=1e-9)
