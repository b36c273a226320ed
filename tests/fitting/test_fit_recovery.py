"""Known truth comes back, and the errors are what they say: pulls over many simulated tables."""

import numpy as np
import pytest
from pulled import table_at

from ropefric.fitting.fit import fit_law
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import LAWS

TRUTH = {"constant": [0.2], "constant-offset": [0.2, 0.05], "size-power": [0.25, 3.0, 0.05],
    "size-exponential": [0.3, -0.2, -0.3], "wrap-exponential": [0.25, -0.15, 0.08],
    "wrap-power": [0.2, -0.5, 0.1], "coupled": [0.46, -0.22, -0.3, -0.48, 0.055], "thickness": [0.2],
    "bending": [0.2, 1e-4], "howell": [0.5, 0.85],
    "groove": [0.07, LAWS["groove"].parameters[1].start]}  # fmt: skip


def conditions():
    """Six radii, wraps and loads in a Latin square: 36 conditions that show every effect."""
    i, j = (index.ravel() for index in np.meshgrid(range(6), range(6), indexing="ij"))
    radii, loads = 0.005 * np.array([2, 3, 4.5, 7, 11, 17.0]), np.geomspace(1.5, 200, 6)
    wraps = np.linspace(np.pi / 2, 4 * np.pi, 6)[j]
    settings = {"wheel_radius_m": radii[i], "wrap_angle_rad": wraps, "end_tension_N": loads[(i + j) % 6]}
    return Conditions(rope_radius_m=0.005, **settings)


def simulated(law, theta, seed, *, repeats=4, within=0.01, between=0.0):
    rng, k = np.random.default_rng(seed), 36
    at = conditions().select(np.repeat(np.arange(k), repeats))
    noise = within * rng.normal(size=k * repeats) + between * np.repeat(rng.normal(size=k), repeats)
    return table_at(at, LAWS[law].log_lift(theta, at) + noise)


def pulls(law, seeds, *, between=0.0, **options):
    theta = np.array(TRUTH[law])
    rows = []
    for seed in seeds:
        fit = fit_law(simulated(law, theta, seed, between=between), law, n_starts=1, **options)
        rows.append([(item.value - true) / item.std for item, true in zip(fit.parameters, theta, strict=True)
                     if item.vary])  # fmt: skip
    return np.array(rows)


def test_pulls_of_a_law():
    z = pulls("constant", range(30))
    # Standard error of the mean 0.18, of the standard deviation 0.13: two of each.
    assert np.abs(z.mean(axis=0)).max() < 0.4
    assert z.std(axis=0, ddof=1).min() > 0.72
    assert z.std(axis=0, ddof=1).max() < 1.28


@pytest.mark.release
@pytest.mark.parametrize("law", TRUTH)
def test_pulls_of_every_law(law):
    z = pulls(law, range(400))
    assert np.abs(z.mean(axis=0)).max() < 0.15
    assert z.std(axis=0, ddof=1).min() > 0.85
    assert z.std(axis=0, ddof=1).max() < 1.15


@pytest.mark.release
@pytest.mark.parametrize("law", ["constant", "coupled"])
def test_clustered_pulls(law):
    z = pulls(law, range(400), between=0.01)
    assert np.abs(z.mean(axis=0)).max() < 0.15
    assert z.std(axis=0, ddof=1).min() > 0.85
    # Student's t with 31 degrees of freedom has 1.03; uneven leverage adds to it.
    assert z.std(axis=0, ddof=1).max() < 1.2
