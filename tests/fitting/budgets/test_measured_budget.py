"""A measured force and the coefficient two forces give: what counts, what cancels, what is not counted twice."""

import math

import numpy as np
import pytest
from pulled import grid, table_at

from ropefric.errors import InputError
from ropefric.fitting.budgets import (
    ForceSide,
    coefficient_model,
    condition_numbered,
    conditions_of_extraction,
    conditions_of_table,
    force_model,
    weights,
    with_measured_end,
)
from ropefric.traces.calibration import ForceCell
from ropefric.uncertainty.budget import (
    BudgetStatus,
    Quantity,
    improvements,
    limit_of_error,
    linear_budget,
    propagate,
    repeats,
    state_uncertainty,
)

FORCES = (318.0, 322.0, 325.0, 317.0, 321.0)
WRAP = Quantity("wrap angle", "φ", "rad", 0.03, estimate=7.0)


def reading(symbol, force_N, offset_N=0.0):
    parts = Quantity("reading", symbol, "N", 1.0, estimate=force_N), Quantity("tare", "δ_0", "N", offset_N)
    return ForceSide(symbol=symbol, quantities=parts)


def test_the_lines_of_a_force_are_those_that_all_trials_share(pulls, lines_of):
    (condition,) = conditions_of_extraction(pulls(FORCES))
    found = lines_of(condition.lift)
    assert (found.repeatability.estimate, found.repeatability.dof) == (pytest.approx(np.mean(FORCES)), 4)
    assert found.repeatability.std == pytest.approx(np.std(FORCES, ddof=1) / math.sqrt(5))
    assert found.resolution.std == pytest.approx(1000 / 1023 / math.sqrt(12))
    assert found.linearity.std == pytest.approx(0.2 / math.sqrt(3))
    assert found.transmitter.std == pytest.approx(1.0 / math.sqrt(3))
    assert found.bias_of_the_smoothing.std == pytest.approx(0.12 / math.sqrt(3))
    # Each trial's own tare and picking scatter with it, and are not counted again.
    assert not {"tare", "picking", "cell's_repeatability"} & vars(found).keys()
    assert sum("repeatability holds it already" in note for note in condition.notes) == 2
    # A tare that all of them share does not average out.
    (condition,) = conditions_of_extraction(pulls(FORCES, tare_N=9.0))
    assert lines_of(condition.lift).tare.std == 0.2


def test_one_trial_counts_its_own_tare_and_picking_and_borrows_its_scatter(pulls, lines_of):
    _, alone = conditions_of_extraction(pulls(FORCES, (500.0,)))
    found = lines_of(alone.lift)
    relative = np.std(FORCES, ddof=1) / np.mean(FORCES)
    assert (found.repeatability.std, found.repeatability.dof) == (pytest.approx(500.0 * relative), 4)
    assert (found.tare.std, found.picking.std) == (0.2, 0.3)
    assert alone.measured.quantities[0].stated


def test_one_trial_without_any_repeats_is_not_to_be_trusted(pulls):
    (alone,) = conditions_of_extraction(pulls((500.0,)))
    assert not alone.measured.quantities[0].stated
    stated = state_uncertainty(force_model(alone.lift), status=BudgetStatus.NO_REPEATS, draws=10_000)
    assert not stated.trustworthy
    assert "Repeat the condition" in stated.to_dict()["advice"]


def test_scatter_that_a_rule_trimmed_is_put_right(pulls, lines_of):
    forces = (*FORCES, 319.0, 323.0, 320.0, 322.5, 350.0)
    (condition,) = conditions_of_extraction(pulls(forces, rule="two-sigma"))
    kept = forces[:-1]
    assert condition.n == 9
    mean = lines_of(condition.lift).repeatability
    assert mean.estimate == pytest.approx(np.mean(kept))
    assert 1.05 < mean.stated / np.std(kept, ddof=1) < 1.12


def test_where_the_slack_side_is_measured_the_weight_is_above(pulls):
    (condition,) = conditions_of_extraction(pulls((20.0, 20.5, 19.8), slack=True), weights_tolerance=0.001)
    assert condition.measured is condition.end
    assert condition.lift.is_product
    assert condition.lift.force_N == pytest.approx(60.0)
    with pytest.raises(InputError, match="it is a reading already"):
        with_measured_end(condition)


def test_a_trial_table_gives_chain_and_weights_as_it_states_them():
    stds = {"peak_std_N": [0.3, 0.4, 0.5, 0.5], "end_tension_std_N": 0.02, "wrap_std_rad": 0.01}
    table = table_at(grid([0.04], [3, 3, 6, 6], [20]), np.log([40, 41, 80, 82]), **stds)
    first, second = conditions_of_table(table, gravity_limit=0.0)
    assert first.lift.quantities[1].std == pytest.approx(math.sqrt((0.09 + 0.16) / 2))
    assert any("as if shared" in note for note in first.notes)
    assert linear_budget(force_model(first.end)).combined == pytest.approx(0.02)
    assert (second.number, second.wrap_std_rad, second.n) == (2, 0.01, 2)
    read = with_measured_end(first)
    assert (read.end.is_product, read.end.quantities[0].std) == (False, pytest.approx(0.02))
    assert with_measured_end(first, 0.5).end.quantities[0].std == 0.5
    with pytest.raises(InputError, match="there is no condition 3"):
        condition_numbered((first, second), 3)


@pytest.mark.parametrize("gain", [0.0, 0.002])
def test_sensitivities_are_the_derivatives(slopes_of, gain):
    """Of channels and of weights, on either side."""
    for lift in (reading("F_A", 200.0, 0.2), weights("F_A", 200.0)):
        for end in (reading("F_B", 50.0, 0.2), weights("F_B", 50.0)):
            model = coefficient_model(lift, end, WRAP, gain_limit=gain)
            np.testing.assert_allclose(model.sensitivities, slopes_of(model), rtol=1e-6, atol=1e-9)


def test_a_common_gain_cancels_and_an_offset_does_not():
    sides = reading("F_A", 200.0), reading("F_B", 50.0)
    plain = linear_budget(coefficient_model(*sides, WRAP))
    model = coefficient_model(*sides, WRAP, gain_limit=0.05)
    assert linear_budget(model).combined == pytest.approx(plain.combined, rel=1e-12)
    # Not to first order only: a factor common to both is gone altogether.
    drawn = propagate(model, plain, draws=100_000, seed=2)
    assert drawn.half_68 == pytest.approx(plain.combined, rel=0.02)
    off = linear_budget(coefficient_model(reading("F_A", 200.0, 0.5), reading("F_B", 50.0, 0.5), WRAP))
    expected = math.hypot(plain.combined, 0.5 / (7 * 200.0), 0.5 / (7 * 50.0))
    assert off.combined == pytest.approx(expected, rel=1e-12)


def test_against_dead_weights_the_gain_counts_in_full():
    sides = reading("F_A", 200.0), weights("F_B", 50.0)
    with_gain, without = (linear_budget(coefficient_model(*sides, WRAP, gain_limit=u)).combined
        for u in (0.01, 0.0))  # fmt: skip
    gap = with_gain**2 - without**2
    assert math.sqrt(gap) == pytest.approx(0.01 / math.sqrt(3) / 7.0, rel=1e-9)


def test_forces_the_wrong_way_round_are_told():
    for end_N in (50.0, -1.0):
        with pytest.raises(InputError, match="does not exceed F_B"):
            coefficient_model(reading("F_A", 40.0), reading("F_B", end_N), WRAP)


def test_intervals_of_few_repeats_cover_as_often_as_they_say():
    """Five pulls, a chain error drawn anew for each campaign: 95 % of y ± U hold the true force."""
    rng, inside, n = np.random.default_rng(5), 0, 1500
    for _ in range(n):
        chain_N = rng.uniform(-1.0, 1.0)
        pulled_N = 300.0 + chain_N + 1.5 * rng.standard_normal(5)
        mean = repeats("repeatability", "F", "N", mean=pulled_N.mean(), std=pulled_N.std(ddof=1), n=5)
        side = ForceSide(symbol="F_A", quantities=(mean, limit_of_error("transmitter", "δ", "N", 1.0)))
        low, high = linear_budget(force_model(side)).interval
        inside += low < 300.0 < high
    # Two standard errors of a share of 0.95 of 1500 are 1.1 %; Welch and Satterthwaite is an approximation.
    assert 0.935 < inside / n < 0.97


def test_improvements_are_the_budgets_they_promise(pulls):
    (condition,) = conditions_of_extraction(pulls(FORCES))
    budget = linear_budget(force_model(condition.lift))
    found = {item.action: item for item in improvements(budget)}
    more = found["10 instead of 5 repeats"]
    s = np.std(FORCES, ddof=1)
    mean = repeats("repeatability", "F", "N", mean=np.mean(FORCES), std=s, n=10)
    again = ForceSide(symbol="F_A", quantities=(mean, *condition.lift.quantities[1:]))
    assert more.expanded == pytest.approx(linear_budget(force_model(again)).expanded, rel=1e-12)
    assert more.saving == pytest.approx(1 - more.expanded / budget.expanded)
    assert list(found) == sorted(found, key=lambda action: -found[action].saving)


def test_a_line_through_two_points_is_taken_as_exact_and_said_to_be(pulls):
    cell = ForceCell(name="K1", full_scale_N=1000.0, points=((0.0, 0.0), (1000.0, 5.0)))
    (condition,) = conditions_of_extraction(pulls(FORCES, cell=cell))
    stated = state_uncertainty(force_model(condition.measured), draws=20_000)
    assert any("calibration line" in note for note in stated.notes if note.startswith("taken as exact"))
