"""φ → 0: the rise vanishes, the coefficient and the slopes do not lose a digit."""

import pytest
from hard_regime import Regime, once, worst_law_error

from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS

REGIME = Regime(
    name="φ → 0",
    statement="every law, wraps of 1e-3 down to 1e-300 rad: ln F_A, mean coefficient and slopes",
    accuracy=1e-12,
)
THETA = {name: [parameter.start for parameter in law.parameters] for name, law in ALL_LAWS.items()}
# A stiff rope does not touch the wheel at a small wrap, and is refused there.
LIMP = [name for name in ALL_LAWS if name != "bending"]


@once(REGIME)
def measured():
    near = [(name, THETA[name], (0.04, 0.005, wrap, 20.0)) for name in LIMP for wrap in (1e-3, 1e-12)]
    far = [(name, THETA[name], (0.04, 0.005, 1e-300, 20.0)) for name in LIMP]
    return max(worst_law_error(near), worst_law_error(far, digits=650))


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


@pytest.mark.parametrize("name", LIMP)
def test_zero_wrap_adds_nothing_and_has_no_mean(name, refused):
    pull = one_condition(0.04, 0.005, 0.0, 20.0)
    law = ALL_LAWS[name]
    assert law.log_lift(THETA[name], pull)[0] == pull.log_end_tension[0]
    refused(lambda: law.average_mu(THETA[name], pull), "no average coefficient over a wrap of zero")


@pytest.mark.parametrize("wrap", [5e-324, 1e-310, 1e-291])
def test_a_rise_that_is_no_normal_float_has_no_mean(wrap, refused):
    pull = one_condition(0.04, 0.005, wrap, 20.0)
    assert ALL_LAWS["constant"].log_lift([0.2], pull)[0] == pull.log_end_tension[0]
    refused(lambda: ALL_LAWS["constant"].average_mu([0.2], pull), "no average coefficient")


def test_the_slope_at_zero_wrap_is_infinite_where_nothing_came_before(refused):
    law, pull = ALL_LAWS["wrap-power-from-zero"], one_condition(0.04, 0.005, 0.0, 20.0)
    refused(lambda: law.log_lift_gradient_conditions([0.2, -0.5, 0.1], pull), "coefficient is infinite where")
    assert (
        ALL_LAWS["wrap-power-from-zero"].log_lift_gradient_conditions([0.2, 0.0, 0.1], pull)[0, 1]
        == 0.2 + 0.1
    )


def test_a_stiff_rope_does_not_touch(refused):
    refused(
        lambda: ALL_LAWS["bending"].log_lift([0.2, 1e-4], one_condition(0.04, 0.005, 1e-9, 20.0)), "too stiff"
    )
