"""F_B → F_0⁺: the wrap φ0 vanishes, μ(φ0) is infinite; below F_0 there is none, and it is refused by name."""

import pytest
from hard_regime import Regime, once, worst_law_error

from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS

REGIME = Regime(
    name="F_B → F_0⁺",
    statement="F_B/F_0 − 1 = 1e-3 … 2e-16 with wraps of 1e-9 … 60 rad: ln F_A and slopes; F_B < F_0 is refused",
    accuracy=1e-12,
)
ABOVE = (1e-3, 2.0**-30, 2.0**-52)
THETA = {
    "wrap-power": [[0.2, -0.5, 0.1], [0.3, -0.9, 0.0]],
    "wrap-exponential": [[0.2, -0.5, 0.1], [0.1, -5.0, 1e-6]],
    "coupled": [[0.2, -0.2, -0.3, -0.6, 0.05]],
}


@once(REGIME)
def measured():
    def cases(names, place):
        for name in names:
            for above, wrap in zip(ABOVE * 2, (1e-9, 2.0, 60.0, 60.0, 1e-9, 2.0), strict=True):
                yield name, THETA[name][place], (0.04, 0.005, wrap, 1.0 + above)

    # With b = -0.9 and no plateau the slope by ln F_B is as small as 1e-140.
    return max(
        worst_law_error(cases(THETA, 0)),
        worst_law_error(cases(["wrap-power", "wrap-exponential"], 1), digits=450),
    )


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


@pytest.mark.parametrize("name", THETA)
def test_at_the_reference_the_wrap_counts_from_zero(name):
    law, theta = ALL_LAWS[name], THETA[name][0]
    pull = one_condition(0.04, 0.005, 2.0, 1.0)
    assert law.log_lift(theta, pull)[0] == pytest.approx(
        law.without_end_tension().log_lift(theta, pull)[0], rel=1e-15
    )
    by_tension = law.log_lift_gradient_conditions(theta, pull)[0, 2]
    assert 0.0 <= by_tension < 1.0


@pytest.mark.parametrize("tension", [1 - 2.0**-53, 0.5, 1e-300, 5e-324])
@pytest.mark.parametrize("name", THETA)
def test_below_the_reference_is_refused(name, tension, refused):
    law, pull = ALL_LAWS[name], one_condition(0.04, 0.005, 2.0, tension)
    error = refused(
        lambda: law.log_lift(THETA[name][0], pull), "below F_0 = 1 N, so no wrap angle stands for it"
    )
    assert "without_end_tension" in error.fix
    assert law.without_end_tension().average_mu(THETA[name][0], pull)[0] > 0.0
