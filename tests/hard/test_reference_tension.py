"""F_B → F_0⁺: the wrap φ0 vanishes, μ(φ0) is infinite; below F_0 there is none, and it is refused by name."""

import mpmath as mp
import pytest
from hard_regime import Regime, once, relative, worst_law_error

from ropefric.friction.condition import one_condition
from ropefric.friction.integral import log_force_ratio, log_lift_exponential, log_lift_power
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
    worst = max(
        worst_law_error(cases(THETA, 0)),
        worst_law_error(cases(["wrap-power", "wrap-exponential"], 1), digits=450),
    )
    for tension, force_0 in [
        (1 + 2**-52, 1.0),
        (10 * (1 + 2**-50), 10.0),
        (1e300, 1e-300),
        (1e300 * (1 + 1e-9), 1e300),
    ]:
        with mp.workdps(60):
            truth = mp.log(mp.mpf(tension) / mp.mpf(force_0))
        worst = max(worst, relative(log_force_ratio(tension, force_0), truth))
    return worst


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


def test_below_a_reference_of_ones_own_is_refused(refused):
    for lift in (log_lift_power, log_lift_exponential):
        refused(
            lambda lift=lift: lift(
                0.2, -0.5, 0.1, wrap_rad=2.0, end_tension_N=10 * (1 - 1e-15), reference_N=10.0
            ),
            "below the reference force",
        )
