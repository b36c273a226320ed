"""A million designs in one call; compared by pytest-benchmark, never asserted on the clock."""

import numpy as np
import pytest

from ropefric.fitting.design import design
from ropefric.fitting.fit import fit_law
from ropefric.fitting.predict import predict
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import LAWS
from ropefric.trials.table import TrialTable

N = 1_000_000


@pytest.fixture(scope="module")
def fit():
    rng = np.random.default_rng(0)
    grid = np.meshgrid(
        [0.02, 0.03, 0.05, 0.08], [5.0, 20.0, 80.0], np.radians([90, 180, 360, 720]), indexing="ij"
    )
    wheel, load, wrap = (np.repeat(axis.ravel(), 3) for axis in grid)
    at = Conditions(wheel_radius_m=wheel, rope_radius_m=0.005, wrap_angle_rad=wrap, end_tension_N=load)
    peak = np.exp(
        LAWS["coupled"].log_lift([0.25, -0.2, -0.3, -0.4, 0.05], at) + 0.01 * rng.standard_normal(len(at))
    )
    table = TrialTable(trial=tuple(map(str, range(len(at)))), wheel_radius_m=wheel, rope_radius_m=0.005,
                       wrap_angle_rad=wrap, end_tension_N=load, peak_N=peak)  # fmt: skip
    return fit_law(table, "coupled")


@pytest.mark.parametrize("probability", [None, 0.95])
def test_wrap_of_a_million_designs(benchmark, fit, probability):
    loads = np.geomspace(30, 500, N)
    settings = {"rope_radius_m": 0.005, "wheel_radius_m": 0.04, "end_tension_N": 20.0,
                "probability": probability}  # fmt: skip
    found = benchmark.pedantic(design, args=(fit,), kwargs={"lift_N": loads} | settings, rounds=1)
    assert found.reached.all()


def test_million_predictions(benchmark, fit):
    at = Conditions(
        wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=np.linspace(1, 12, N), end_tension_N=20.0
    )
    found = benchmark.pedantic(predict, args=(fit, at), rounds=1)
    assert found.lift_force_N.size == N
