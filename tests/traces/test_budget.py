"""What a measuring chain leaves uncertain of one force."""

import math

import numpy as np
import pytest

from ropefric.errors import InputError
from ropefric.traces.calibration import (
    Adc,
    Calibration,
    ForceCell,
    chain_quantities,
    end_tension_std_N,
    force_std_N,
)

SMALL = Calibration(cell=ForceCell(name="small", full_scale_N=1000.0))
LARGE = Calibration(cell=ForceCell(name="large", full_scale_N=5000.0))


def worst_case_N(calibration):
    """The sum of all limits of error, as data sheets add them."""
    limits = (item for item in chain_quantities(0.0, calibration) if item.distribution != "normal")
    return sum(math.sqrt(3.0) * item.std for item in limits)


def test_the_papers_accumulated_error_holds():
    """Accumulated error within ±0.3 %FS: cell, transmitter, converter and weights at their limits together."""
    for calibration in (SMALL, LARGE):
        full_scale_N = calibration.cell.full_scale_N
        # And it is no empty statement: the limits come to more than two thirds of it.
        assert 0.002 < worst_case_N(calibration) / full_scale_N + 0.0005 < 0.003


def test_each_component_by_hand():
    tared = Calibration(cell=SMALL.cell, tare_std_N=0.05)
    std_N = {item.name: item.std for item in chain_quantities(321.7, tared)}
    cell_N = dict.fromkeys(("linearity", "hysteresis", "cell's repeatability"), 0.2 / math.sqrt(3))
    chain_N = {"transmitter": 1.0 / math.sqrt(3), "resolution": 1000 / 1023 / math.sqrt(12)}
    assert (std_N, std_N["resolution"]) == (pytest.approx(cell_N | chain_N), pytest.approx(0.28, abs=0.005))
    combined_N = math.sqrt(sum(u**2 for u in std_N.values()) + 0.05**2 + 0.4**2)
    assert force_std_N(321.7, tared, picking_std_N=0.4) == pytest.approx(combined_N)


def test_a_simulated_chain_scatters_as_the_budget_says():
    rng = np.random.default_rng(11)
    n, fs_N = 200_000, 1000.0
    truth_N = rng.uniform(300.0, 310.0, n)
    limits_N = [0.2, 0.2, 0.2, 1.0]
    reading_N = truth_N + sum(rng.uniform(-limit, limit, n) for limit in limits_N)
    counts = np.rint(reading_N / fs_N * 1023).astype(int)
    error_N = SMALL.apply(counts)[0] - truth_N
    assert np.std(error_N) == pytest.approx(force_std_N(305.0, SMALL), rel=0.01)
    assert np.abs(error_N).max() <= worst_case_N(SMALL)


def noisy_cell(n, seed, scatter_V=0.004):
    rng = np.random.default_rng(seed)
    force_N = np.linspace(0.0, 1000.0, n)
    voltage_V = 0.005 * force_N + rng.normal(0, scatter_V, n)
    exact = dict.fromkeys(("linearity", "hysteresis", "repeatability", "transmitter"), 0.0)
    points = tuple(zip(force_N.tolist(), voltage_V.tolist(), strict=True))
    return ForceCell(name="cell", full_scale_N=1000.0, points=points, **exact)


def test_the_calibration_line_predicts_its_own_scatter():
    """A reading with the points' scatter, converted by the line, misses by what the budget states."""
    squares, stated = [], []
    rng = np.random.default_rng(2)
    for seed in range(600):
        calibration = Calibration(cell=noisy_cell(6, seed), adc=Adc(bits=24))
        line = calibration.cell.line
        voltage_V = 0.005 * 900.0 + rng.normal(0, 0.004)
        squares.append(((voltage_V - line.zero_V) * line.gain_N_V - 900.0) ** 2)
        stated.append(force_std_N(900.0, calibration) ** 2)
    assert np.mean(squares) == pytest.approx(np.mean(stated), rel=0.15)


def test_degrees_of_freedom_come_from_the_points_and_two_have_no_scatter():
    line = chain_quantities(500.0, Calibration(cell=noisy_cell(6, 0), adc=Adc(bits=24)))[-1]
    assert (line.name, line.dof) == ("calibration line", 4.0)
    cell = ForceCell(name="cell", full_scale_N=1000.0, points=((0.0, 0.0), (1000.0, 5.0)))
    assert force_std_N(500.0, Calibration(cell=cell)) == pytest.approx(force_std_N(500.0, SMALL))
    assert math.isinf(chain_quantities(500.0, Calibration(cell=cell))[-1].dof)


def test_the_tare_counts_a_recording_in_newtons_has_the_picking_alone():
    tared = Calibration(cell=SMALL.cell, tare_N=5.0, tare_std_N=3.0)
    assert force_std_N(9.0, tared) == pytest.approx(math.hypot(3.0, force_std_N(9.0, SMALL)))
    assert force_std_N(100.0, None, picking_std_N=0.3) == 0.3


def test_end_tension_is_a_twentieth_of_a_per_cent_at_its_limit():
    assert end_tension_std_N(80.0, 0.0005) * math.sqrt(3) == pytest.approx(0.04)
    assert end_tension_std_N(0.0, 0.0005) == 0.0
    for bad in ((-1.0, 0.01), (1.0, math.nan)):
        with pytest.raises(InputError, match="is no standard uncertainty"):
            end_tension_std_N(*bad)
