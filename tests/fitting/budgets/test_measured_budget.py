"""A measured force: what counts, and what is not counted twice."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ropefric.fitting.budgets import measured_forces
from ropefric.traces.calibration import ForceCell
from ropefric.uncertainty.budget import (
    MeasurementModel,
    improvements,
    limit_of_error,
    linear_budget,
    repeats,
    state_uncertainty,
)

FORCES = (318.0, 322.0, 325.0, 317.0, 321.0)


def test_the_lines_of_a_force_are_those_that_all_trials_share(pulls, lines_of):
    (force,) = measured_forces(pulls(FORCES))
    found = lines_of(force.model)
    assert (found.repeatability.estimate, found.repeatability.dof) == (pytest.approx(np.mean(FORCES)), 4)
    assert found.repeatability.std == pytest.approx(np.std(FORCES, ddof=1) / math.sqrt(5))
    assert found.resolution.std == pytest.approx(1000 / 1023 / math.sqrt(12))
    assert found.linearity.std == pytest.approx(0.2 / math.sqrt(3))
    assert found.transmitter.std == pytest.approx(1.0 / math.sqrt(3))
    assert found.bias_of_the_smoothing.std == pytest.approx(0.12 / math.sqrt(3))
    # Each trial's own tare and picking scatter with it, and are not counted again.
    assert not {"tare", "picking", "cell's_repeatability"} & vars(found).keys()
    # A tare that all of them share does not average out.
    (force,) = measured_forces(pulls(FORCES, tare_N=9.0))
    assert lines_of(force.model).tare.std == 0.2


def test_one_trial_has_no_budget_and_the_others_keep_their_numbers(pulls):
    assert [force.number for force in measured_forces(pulls((500.0,), FORCES))] == [2]


def test_scatter_that_a_rule_trimmed_is_put_right(pulls, lines_of):
    forces = (*FORCES, 319.0, 323.0, 320.0, 322.5, 350.0)
    (force,) = measured_forces(pulls(forces, rule="two-sigma"))
    kept, mean = forces[:-1], lines_of(force.model).repeatability
    assert (mean.repeats, mean.estimate) == (9, pytest.approx(np.mean(kept)))
    assert 1.05 < mean.stated / np.std(kept, ddof=1) < 1.12
    assert "which the rejection rule leaves" in force.notes[0]


def test_where_the_slack_side_is_measured_the_budget_is_of_that(pulls):
    (force,) = measured_forces(pulls((20.0, 20.5, 19.8), slack=True))
    assert (force.model.symbol, force.model.estimate) == ("F_B", pytest.approx(20.1))


def test_sensitivities_are_the_derivatives(slopes_of, pulls):
    (force,) = measured_forces(pulls(FORCES))
    np.testing.assert_allclose(force.model.sensitivities, slopes_of(force.model), rtol=1e-6, atol=1e-9)


def test_intervals_of_few_repeats_cover_as_often_as_they_say():
    """Five pulls, a chain error drawn anew for each campaign: 95 % of y ± U hold the true force."""
    rng, inside, n = np.random.default_rng(5), 0, 1500
    chain = limit_of_error("transmitter", "δ", "N", 1.0)
    for _ in range(n):
        pulled_N = 300.0 + rng.uniform(-1.0, 1.0) + 1.5 * rng.standard_normal(5)
        mean = repeats("repeatability", "F", "N", mean=pulled_N.mean(), std=pulled_N.std(ddof=1), n=5)
        model = MeasurementModel("force", "F", "N", (mean, chain), lambda x: x.sum(axis=1), np.ones(2))
        low, high = linear_budget(model).interval
        inside += low < 300.0 < high
    # Two standard errors of a share of 0.95 of 1500 are 1.1 %; Welch and Satterthwaite is an approximation.
    assert 0.935 < inside / n < 0.97


def test_improvements_are_the_budgets_they_promise(pulls):
    (force,) = measured_forces(pulls(FORCES))
    budget = linear_budget(force.model)
    found = {item.action: item for item in improvements(budget)}
    more, std_N = found["10 instead of 5 repeats"], np.std(FORCES, ddof=1)
    mean = repeats("repeatability", "F", "N", mean=np.mean(FORCES), std=std_N, n=10)
    again = replace(force.model, quantities=(mean, *force.model.quantities[1:]))
    assert more.expanded == pytest.approx(linear_budget(again).expanded, rel=1e-12)
    assert more.saving == pytest.approx(1 - more.expanded / budget.expanded)
    assert list(found) == sorted(found, key=lambda action: -found[action].saving)


def test_a_line_through_two_points_is_taken_as_exact_and_said_to_be(pulls):
    cell = ForceCell(name="K1", full_scale_N=1000.0, points=((0.0, 0.0), (1000.0, 5.0)))
    (force,) = measured_forces(pulls(FORCES, cell=cell))
    stated = state_uncertainty(force.model, draws=20_000)
    assert any("calibration line" in note for note in stated.notes if note.startswith("taken as exact"))
