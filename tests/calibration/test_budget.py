import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ropefric.errors import InputError
from ropefric.traces.budget import combined_std_N, end_tension_std_N, force_budget
from ropefric.traces.calibration import Adc, Calibration, ForceCell

SMALL = Calibration(cell=ForceCell(name="small", full_scale_N=1000.0))
LARGE = Calibration(cell=ForceCell(name="large", full_scale_N=5000.0))


@pytest.mark.parametrize("calibration", [SMALL, LARGE])
def test_the_papers_accumulated_error_holds(calibration):
    """Accumulated error within ±0.3 %FS: cell, transmitter, converter and weights at their limits together."""
    full_scale_N = calibration.cell.full_scale_N
    budget = force_budget(full_scale_N, calibration)
    weights_N = 0.0005 * full_scale_N
    assert budget.worst_case_N + weights_N < 0.003 * full_scale_N
    # and it is no empty statement: the limits come to more than two thirds of it
    assert budget.worst_case_N + weights_N > 0.002 * full_scale_N


def test_each_component_by_hand():
    budget = force_budget(321.7, SMALL, picking_std_N=0.4, tare_std_N=0.05)
    std_N = {c.name: c.standard_uncertainty_N for c in budget.components}
    assert std_N == pytest.approx(
        {
            "linearity": 0.2 / math.sqrt(3),
            "hysteresis": 0.2 / math.sqrt(3),
            "repeatability": 0.2 / math.sqrt(3),
            "transmitter": 1.0 / math.sqrt(3),
            "quantisation": 1000 / 1023 / math.sqrt(12),
            "tare": 0.05,
            "picking": 0.4,
        }
    )
    assert std_N["quantisation"] == pytest.approx(0.28, abs=0.005)
    assert budget.combined_N == pytest.approx(math.sqrt(sum(u**2 for u in std_N.values())))
    assert math.isinf(budget.effective_dof)
    for component in budget.components:
        assert component.standard_uncertainty_N == pytest.approx(component.estimate_N / component.divisor)


def test_quantisation_of_the_large_cell_as_the_conventions_print_it():
    std_N = {c.name: c.standard_uncertainty_N for c in force_budget(0.0, LARGE).components}
    assert std_N["quantisation"] == pytest.approx(1.41, abs=0.005)


def test_a_simulated_chain_scatters_as_the_budget_says():
    rng = np.random.default_rng(11)
    n, fs_N = 200_000, 1000.0
    truth_N = rng.uniform(300.0, 310.0, n)
    limits_N = [0.2, 0.2, 0.2, 1.0]
    reading_N = truth_N + sum(rng.uniform(-limit, limit, n) for limit in limits_N)
    counts = np.rint(reading_N / fs_N * 1023).astype(int)
    error_N = SMALL.apply(counts)[0] - truth_N
    assert np.std(error_N) == pytest.approx(force_budget(305.0, SMALL).combined_N, rel=0.01)
    assert np.abs(error_N).max() <= force_budget(305.0, SMALL).worst_case_N


def noisy_cell(n, seed, scatter_V=0.004):
    rng = np.random.default_rng(seed)
    force_N = np.linspace(0.0, 1000.0, n)
    voltage_V = 0.005 * force_N + rng.normal(0, scatter_V, n)
    return ForceCell(
        name="cell",
        full_scale_N=1000.0,
        linearity=0.0,
        hysteresis=0.0,
        repeatability=0.0,
        transmitter=0.0,
        points=tuple(zip(force_N.tolist(), voltage_V.tolist(), strict=True)),
    )


def test_the_calibration_line_predicts_its_own_scatter():
    """A reading with the points' scatter, converted by the line, misses by what the budget states."""
    squares, stated = [], []
    rng = np.random.default_rng(2)
    for seed in range(600):
        calibration = Calibration(cell=noisy_cell(6, seed), adc=Adc(bits=24))
        line = calibration.cell.line
        voltage_V = 0.005 * 900.0 + rng.normal(0, 0.004)
        squares.append(((voltage_V - line.zero_V) * line.gain_N_V - 900.0) ** 2)
        stated.append(combined_std_N([900.0], calibration)[0] ** 2)
    assert np.mean(squares) == pytest.approx(np.mean(stated), rel=0.15)


def test_degrees_of_freedom_come_from_the_points():
    budget = force_budget(500.0, Calibration(cell=noisy_cell(6, 0), adc=Adc(bits=24)))
    assert budget.effective_dof == pytest.approx(4.0, rel=1e-3)
    mixed = force_budget(500.0, Calibration(cell=noisy_cell(6, 0)), picking_std_N=0.8)
    line = next(c for c in mixed.components if c.name == "calibration line")
    assert mixed.effective_dof == pytest.approx(mixed.combined_N**4 / (line.contribution_N**4 / 4))


def test_two_points_have_no_scatter_to_tell():
    cell = ForceCell(name="cell", full_scale_N=1000.0, points=((0.0, 0.0), (1000.0, 5.0)))
    budget = force_budget(500.0, Calibration(cell=cell))
    assert budget.combined_N == pytest.approx(force_budget(500.0, SMALL).combined_N)
    assert json.loads(json.dumps(budget.to_dict(), allow_nan=False))["effective_dof"] is None


def test_the_tare_of_the_calibration_counts_by_default():
    tared = Calibration(cell=SMALL.cell, tare_N=5.0, tare_std_N=3.0)
    assert force_budget(9.0, tared).combined_N == pytest.approx(
        math.hypot(3.0, force_budget(9.0, SMALL).combined_N)
    )
    assert force_budget(9.0, tared, tare_std_N=0.0) == force_budget(9.0, SMALL, tare_std_N=0.0)


@given(
    force_N=st.lists(st.floats(-100, 1000), min_size=1, max_size=5),
    picking_std_N=st.floats(0, 10),
    tare_N=st.floats(-50, 50),
    n_points=st.sampled_from([0, 2, 3, 7]),
)
def test_the_fast_way_is_the_slow_way(force_N, picking_std_N, tare_N, n_points):
    cell = noisy_cell(n_points, 9) if n_points else SMALL.cell
    calibration = Calibration(cell=cell, tare_N=tare_N, tare_std_N=0.3)
    slow = [force_budget(f, calibration, picking_std_N=picking_std_N).combined_N for f in force_N]
    fast = combined_std_N(force_N, calibration, picking_std_N=np.full(len(force_N), picking_std_N))
    assert fast.tolist() == pytest.approx(slow, rel=1e-12)


def test_trials_without_a_peak_have_no_uncertainty():
    force_N = np.array([100.0, np.nan])
    std_N = combined_std_N(force_N, SMALL, picking_std_N=[0.1, np.nan])
    assert np.isfinite(std_N).tolist() == [True, False]
    assert force_N[0] == 100.0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: force_budget(math.nan, SMALL), "force of nan N"),
        (lambda: force_budget(1.0, SMALL, picking_std_N=-1.0), "picking_std_N = -1"),
        (lambda: force_budget(1.0, SMALL, tare_std_N=math.inf), "tare_std_N = inf"),
        (lambda: combined_std_N([1.0], SMALL, picking_std_N=math.nan), "picking_std_N = nan"),
        (lambda: combined_std_N([1.0, 2.0], SMALL, tare_std_N=[0.1, -0.1]), "tare_std_N = -0.1"),
        (
            lambda: combined_std_N([1.0, 2.0], SMALL, picking_std_N=[0.1] * 3),
            "3 values of picking_std_N for 2",
        ),
        (lambda: end_tension_std_N(-1.0), "end_tension_N = -1"),
        (lambda: end_tension_std_N(1.0, weights=math.nan), "weights = nan"),
    ],
)
def test_bad_numbers_are_refused(call, message):
    with pytest.raises(InputError, match=message) as error:
        call()
    assert error.value.code == "RF214"


def test_end_tension_is_a_twentieth_of_a_per_cent_at_its_limit():
    assert end_tension_std_N(80.0) * math.sqrt(3) == pytest.approx(0.04)
    assert end_tension_std_N(0.0) == 0.0
