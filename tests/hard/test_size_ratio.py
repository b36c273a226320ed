"""r → 0 and r → ∞: a wheel that vanishes beside the rope, and a rope that vanishes beside the wheel."""

import pytest
from hard_regime import Regime, once, worst_law_error

from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS

REGIME = Regime(
    name="r → 0 and r → ∞",
    statement="every law with a size effect, R_w/R_r from 1e-298 to 1e298, b = 0 too: ln F_A and slopes",
    accuracy=1e-12,
)
THETA = {
    "size-power": [[0.2, 1.5, 0.02], [0.2, 1.0, 0.0]],
    "size-exponential": [[0.2, -0.2, -0.3], [0.2, -0.2, 0.0]],
    "coupled": [[0.2, -0.2, -0.3, -0.4, 0.05], [0.2, -0.2, 0.0, -0.4, 0.05]],
    "thickness": [[0.2], [3.0]],
    "howell": [[0.5, 0.9]],
}
NEAR = [(1e-9, 0.005), (0.001, 0.005), (1e9, 0.005), (0.04, 1e-9)]
FAR = [(1e-300, 0.005), (0.04, 1e-298)]


def _cases(sizes, most=2):
    return [
        (name, theta, (*size, 6.0, 20.0))
        for name, sets in THETA.items()
        for theta in sets[:most]
        for size in sizes
    ]


@once(REGIME)
def measured():
    return max(worst_law_error(_cases(NEAR)), worst_law_error(_cases(FAR, 1), digits=950))


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


def test_a_very_large_wheel_is_eulers_equation():
    pull = one_condition(1e296, 0.005, 6.0, 20.0)
    for name, theta in [
        ("size-power", [0.15, 2.0, 0.05]),
        ("size-exponential", [0.2, -0.2, -0.3]),
        ("thickness", [0.2]),
    ]:
        assert ALL_LAWS[name].average_mu(theta, pull)[0] == pytest.approx(0.2, rel=1e-15)


@pytest.mark.parametrize("size", [(1e300, 1e-300), (5e-324, 1e10), (1.7e308, 1.7e308)])
def test_a_ratio_that_no_float_holds_is_refused(size, refused):
    refused(lambda: one_condition(*size, 6.0, 20.0), "no number holds R_w/R_r")
