"""The examples that the GUM and its first supplement print, with the digits they print."""

import math

import numpy as np
import pytest

from ropefric.uncertainty.budget import (
    MeasurementModel,
    Quantity,
    directions,
    effective_dof,
    limit_of_error,
    linear_budget,
    propagate,
    quantile,
)


def test_effective_degrees_of_freedom_of_g_4():
    """JCGM 100, G.4.1: relative uncertainties 0.25, 0.57, 0.82 % from 10, 5, 15 readings."""
    parts = [0.25, 0.57, 0.82]
    dof = effective_dof(parts, [9.0, 4.0, 14.0])
    assert (math.hypot(*parts), dof) == (pytest.approx(1.03, abs=0.005), pytest.approx(19.0, abs=0.05))
    assert quantile(0.975, dof) == pytest.approx(2.09, abs=0.005)


VOLTAGE = np.array([4.9990, 19.6610e-3, 1.04446])
COVARIANCE = np.outer([0.0032, 0.0095e-3, 0.00075], [0.0032, 0.0095e-3, 0.00075]) * np.array(
    [[1.0, -0.36, 0.86], [-0.36, 1.0, -0.65], [0.86, -0.65, 1.0]]
)


@pytest.mark.parametrize(("function", "value", "std"),
    [(lambda v, i, p: v / i * np.cos(p), 127.732, 0.071), (lambda v, i, p: v / i * np.sin(p), 219.847, 0.295),
    (lambda v, i, _: v / i, 254.260, 0.236)], ids=["R", "X", "Z"])  # fmt: skip
def test_correlated_inputs_of_h_2(function, value, std):
    """JCGM 100, H.2: resistance, reactance, impedance from correlated voltage, current and phase."""
    turned, step = directions(COVARIANCE), np.array([1e-4, 1e-7, 1e-5])
    slopes = [(function(*(VOLTAGE + d)) - function(*(VOLTAGE - d))) / (2 * d.sum()) for d in np.diag(step)]
    model = MeasurementModel(name="y", symbol="y", unit="Ω", quantities=tuple(Quantity(n, n, "-", 1.0) for n in "abc"),
        evaluate=lambda x: function(*(VOLTAGE + x @ turned.T).T), sensitivities=slopes @ turned)  # fmt: skip
    budget = linear_budget(model)
    # The inputs are printed to two digits of their uncertainty, and strongly correlated.
    assert budget.estimate == pytest.approx(value, abs=0.006)
    assert budget.combined == pytest.approx(std, abs=0.0015)
    assert propagate(model, budget).agrees


def sum_of(quantities):
    return MeasurementModel(name="sum", symbol="Y", unit="-", quantities=tuple(quantities),
        evaluate=lambda x: x.sum(axis=1), sensitivities=np.ones(len(quantities)))  # fmt: skip


@pytest.mark.parametrize(
    ("widths", "std", "linear_end", "drawn_end", "agrees"),
    [
        (None, 2.0, 3.92, 3.92, True),  # 9.2.2, four normal inputs
        ((1.0, 1.0, 1.0, 1.0), 2.0, 3.92, 3.88, True),  # 9.2.3, four rectangular ones
        ((1.0, 1.0, 1.0, 10.0), 10.1, 19.9, 17.0, False),  # 9.2.4, one of them ten times as wide
    ],
    ids=["normal", "rectangular", "one dominates"],
)
def test_the_additive_examples_of_the_supplement(widths, std, linear_end, drawn_end, agrees):
    """JCGM 101, 9.2: the sum of four inputs of unit standard deviation."""
    names = "abcd"
    if widths is None:
        quantities = [Quantity(name, name, "-", 1.0) for name in names]
    else:
        quantities = [limit_of_error(name, name, "-", width * math.sqrt(3.0))
            for name, width in zip(names, widths, strict=True)]  # fmt: skip
    model = sum_of(quantities)
    budget = linear_budget(model)
    drawn = propagate(model, budget, draws=400_000, seed=1)
    assert budget.combined == pytest.approx(std, abs=0.05)
    assert budget.lines[0].contribution == max(line.contribution for line in budget.lines)
    assert budget.interval == pytest.approx((-linear_end, linear_end), abs=0.05)
    # 2.7 σ/√N is the noise of an end; three of them.
    noise = 3 * 2.7 * std / math.sqrt(400_000)
    assert drawn.symmetric_interval == pytest.approx((-drawn_end, drawn_end), abs=0.05 + noise)
    assert drawn.agrees is agrees


def test_a_mean_of_few_readings_is_drawn_as_student_t():
    """JCGM 101, 6.4.9: the linear and the drawn interval are the same t interval."""
    model = sum_of([Quantity(name="mean", symbol="x", unit="-", estimate=7.0, stated=2.0, type="A", dof=4.0)])
    budget = linear_budget(model)
    drawn = propagate(model, budget, draws=400_000, seed=3)
    assert budget.expanded == pytest.approx(2.776 * 2.0, abs=0.001)
    # Three times the noise of an end of a t interval with four degrees of freedom, √(pq/N)/density.
    assert drawn.symmetric_interval == pytest.approx(budget.interval, abs=0.06)
