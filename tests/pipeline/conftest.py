"""The committed bench, run once, and small tables with known truth."""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ropefric.friction.laws import LAWS
from ropefric.pipeline import run_campaign
from ropefric.trials.campaign import load_campaign
from ropefric.trials.table import TrialTable

BENCH = Path(__file__).parents[2] / "data" / "prth-bench"


@pytest.fixture(scope="session")
def bench_run(tmp_path_factory):
    """The run of data/prth-bench and the folder it wrote; do not change it."""
    folder = tmp_path_factory.mktemp("bench-run")
    return run_campaign(load_campaign(BENCH / "campaign.toml"), folder, jobs=2), folder


@pytest.fixture(scope="session")
def bench_truth():
    return tomllib.loads((BENCH / "truth.toml").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def pulls():
    """A factory of trial tables that obey a law: 3 wheels, 3 wraps, 2 loads, repeated."""

    def make(law="constant", *theta, scatter=0.01, repeats=4, seed=1):
        wheel, wrap, load = np.meshgrid([0.02, 0.04, 0.08], [2.0, 5.0, 10.0], [20.0, 80.0])
        columns = [np.repeat(values.ravel(), repeats) for values in (wheel, wrap, load)]
        n = columns[0].size
        empty = TrialTable(
            trial=tuple(f"t{i}" for i in range(n)), wheel_radius_m=columns[0], rope_radius_m=0.005,
            wrap_angle_rad=columns[1], end_tension_N=columns[2], peak_N=np.full(n, 1e6),
        )  # fmt: skip
        scattered = scatter * np.random.default_rng(seed).standard_normal(n)
        peak_N = np.exp(LAWS[law].log_lift(list(theta), empty.conditions()) + scattered)
        return replace(empty, peak_N=peak_N)

    return make
