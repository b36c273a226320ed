"""Roots of a covariance: they make it again to the last digits, in whatever units, also where it is singular."""

import numpy as np
import pytest

from ropefric.uncertainty.budget import directions, joint_draws, symmetric_root

CORRELATION = np.array([[1.0, 0.9, 0.0], [0.9, 1.0, -0.3], [0.0, -0.3, 1.0]])
UNITS = np.array([1e-9, 1.0, 1e7])


def covariance_of(size):
    return CORRELATION * np.outer(size, size)


@pytest.mark.parametrize("root", [directions, symmetric_root])
def test_a_root_gives_every_element_of_the_covariance_again(root):
    found = root(covariance_of(UNITS))
    np.testing.assert_allclose((found @ found.T) / np.outer(UNITS, UNITS), CORRELATION, atol=1e-14)


@pytest.mark.parametrize("root", [directions, symmetric_root])
def test_a_root_does_not_depend_on_units(root):
    found, converted = root(covariance_of(np.ones(3))), root(covariance_of(UNITS))
    np.testing.assert_allclose(converted, UNITS[:, None] * found, rtol=1e-12, atol=1e-22)


def test_an_exact_quantity_stays_where_it_is():
    covariance = np.zeros((3, 3))
    covariance[:2, :2] = [[4.0, 2.0], [2.0, 1.0]]  # the first two move as one
    root = symmetric_root(covariance)
    drawn = joint_draws(np.array([5.0, 7.0, 9.0]), root, dof=np.inf, n=4000, rng=np.random.default_rng(0))
    assert (drawn[:, 2] == 9.0).all()
    np.testing.assert_allclose(drawn[:, 0] - 5.0, 2.0 * (drawn[:, 1] - 7.0), atol=1e-6)
    assert drawn[:, 0].std() == pytest.approx(2.0, rel=0.05)
