"""What the fitting tests share."""

import sys
from pathlib import Path

import numpy as np
import pytest

from ropefric.fitting.problem import FitProblem
from ropefric.friction.condition import Conditions

# The tables that the tests of several folders make up, `pulled`.
sys.path.insert(0, str(Path(__file__).parent))


def bench_plan(repeats=1):
    """4 wheels x 4 wraps x 4 loads, each pulled several times."""
    wheel, wrap, load = np.meshgrid([0.02, 0.03, 0.05, 0.1], np.pi * np.array([0.5, 1, 2, 4]),
        [2.0, 10.0, 50.0, 200.0])  # fmt: skip
    columns = (np.repeat(column.ravel(), repeats) for column in (wheel, wrap, load))
    names = ("wheel_radius_m", "wrap_angle_rad", "end_tension_N")
    return Conditions(rope_radius_m=0.0049, **dict(zip(names, columns, strict=True)))


@pytest.fixture(scope="session")
def bench_problem():
    """A factory of fit problems with known truth: normal scatter within and between conditions."""

    def make(law, truth=None, *, std=0.01, between=0.0, repeats=1, seed=0, plan=None, **changes):
        conditions = bench_plan(repeats) if plan is None else plan
        n = len(conditions)
        theta = np.array([p.start for p in law.parameters]) if truth is None else np.asarray(truth, float)
        rng = np.random.default_rng(seed)
        group = np.arange(n) // repeats
        scatter = std * rng.standard_normal(n) + between * rng.standard_normal(n // repeats)[group]
        settings = {"start": theta, "lower": law.lower, "upper": law.upper,
            "vary": np.array([not p.fixed for p in law.parameters]), "std": np.full(n, std or 0.01),
            "log_lift": law.log_lift(theta, conditions) + scatter}  # fmt: skip
        return FitProblem(law=law, conditions=conditions, group=group, **(settings | changes))

    return make
