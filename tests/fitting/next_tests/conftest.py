"""A rig, laws with parameters, and campaigns simulated from a law with scatter at two levels."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from pulled import table_at

from ropefric.fitting.fit import fit_law
from ropefric.fitting.next_tests import allowed_conditions, planned_guess
from ropefric.fitting.predict import predict
from ropefric.fitting.resolution import FACTORS, MeanScatter, RigLimits, levels
from ropefric.friction.condition import one_condition
from ropefric.friction.laws import LAWS

LAW_GUESSES = {"constant": {"mu": 0.15}, "size-exponential": {"mu_inf": 0.25, "a": -0.25, "b": -0.2},
    "wrap-power": {"a": 0.2, "b": -0.5, "c": 0.1}, "howell": None,
    "coupled": {"mu_inf": 0.46, "a": -0.22, "b": -0.3, "c": -0.48, "d": 0.055}}  # fmt: skip
WANTED = {"inside": (0.035, 400.0, 60.0), "large wheel": (0.1, 540.0, 60.0), "strong": (0.05, 900.0, 150.0)}
SCATTER = MeanScatter(within=0.017, between=0.01)


@pytest.fixture(scope="session")
def bench():
    """The wheels, wraps and weights of the PRTH bench, with its smaller cell."""
    return RigLimits(wheel_radius_m=(0.015, 0.02, 0.03, 0.04, 0.06),
        wrap_angle_rad=tuple(map(math.radians, levels(90.0, 1080.0, 12, step=45.0))),
        end_tension_N=levels(5.0, 200.0, 10), rope_radius_m=0.0049, largest_force_N=800.0)  # fmt: skip


@pytest.fixture(scope="session")
def guessed():
    """A factory of laws at guessed parameters."""

    def make(name, scatter=SCATTER, **changes):
        law = LAWS[name]
        values = LAW_GUESSES.get(name) or {item.name: item.start for item in law.parameters}
        return planned_guess(law, values | changes, scatter)

    return make


@pytest.fixture(scope="session")
def wanted():
    """A factory of wanted conditions by name."""

    def make(name):
        radius_m, wrap_deg, load_N = WANTED[name]
        return one_condition(radius_m, 0.0049, math.radians(wrap_deg), load_N)

    return make


@pytest.fixture(scope="session")
def usual(bench):
    """The one-factor-at-a-time plan about the middle of the bench's settings."""

    def make(planned):
        """Eleven conditions that differ from the middle one in one factor, spread evenly, and that one."""
        grid = bench.conditions()
        allowed = allowed_conditions(planned, bench, grid)[0].reshape(bench.shape)
        spots = np.argwhere(allowed)
        last = np.array(bench.shape) - 1.0
        centre = spots[np.argmin((((spots - last / 2) / last) ** 2).sum(axis=1).round(12))]
        found = [centre]
        for axis, share in zip(range(len(FACTORS)), (4, 4, 3), strict=True):
            alone = spots[((spots != centre).sum(axis=1) == 1) & (spots[:, axis] != centre[axis])]
            found += [*alone[np.linspace(0, len(alone) - 1, share).round().astype(int)]]
        return grid.select(np.ravel_multi_index(tuple(np.array(found).T), bench.shape))

    return make


@dataclass(frozen=True)
class Outcome:
    """Of many simulated campaigns: widths of the interval of ln F_A, its errors, how often it held the truth."""

    widths: np.ndarray
    errors: np.ndarray
    covered: float


@pytest.fixture(scope="session")
def campaigns():
    """Simulate pulls from the law with scatter, fit them as a user would, and predict."""

    def run(planned, conditions, target, *, repeats=4, n=12, seed=0):
        law, theta, scatter = planned.law, planned.theta, planned.scatter
        rng, k = np.random.default_rng(seed), len(conditions)
        group = np.repeat(np.arange(k), repeats)
        pulls = conditions.select(group)
        truth = float(law.log_lift(theta, target)[0])
        widths, errors, held = [], [], 0
        for _ in range(n):
            log_lift = law.log_lift(theta, pulls) + scatter.between * rng.standard_normal(k)[group]
            log_lift = log_lift + scatter.within * rng.standard_normal(group.size)
            fit = fit_law(table_at(pulls, log_lift), law, n_starts=1)
            found = predict(fit, target, method="linear")
            low, high = np.log(found.interval_N[0])
            widths.append(high - low)
            errors.append(found.log_lift[0] - truth)
            held += low < truth < high
        return Outcome(np.array(widths), np.array(errors), held / n)

    return run


@pytest.fixture(scope="session")
def root():
    """The folder of the checkout."""
    return Path(__file__).parents[3]
