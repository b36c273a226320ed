"""b → 0⁻: the wrap effect goes away and Euler's equation must come out, with the slope by b of its own size."""

import math

import numpy as np
from hard_regime import Regime, once, worst_law_error

from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS

REGIME = Regime(
    name="b → 0⁻",
    statement="power, exponential and coupled laws, exponents and rates of −1e-3 … −1e-300: ln F_A and slopes",
    accuracy=1e-12,
)


@once(REGIME)
def measured():
    def cases(*sizes):
        for b in sizes:
            for name in (
                "wrap-power",
                "wrap-exponential",
                "wrap-power-from-zero",
                "wrap-exponential-from-zero",
            ):
                yield name, [0.2, -b, 0.1], (0.04, 0.005, 7.0, 20.0)
            yield "coupled", [0.2, -0.2, -0.3, -b, 0.05], (0.04, 0.005, 7.0, 20.0)

    return max(worst_law_error(cases(1e-3, 1e-9, 1e-16)), worst_law_error(cases(1e-300), digits=650))


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


def test_the_limit_is_eulers_equation():
    pull = one_condition(0.04, 0.005, 7.0, 20.0)
    euler = math.log(20.0) + 0.3 * 7.0
    for name in ("wrap-power", "wrap-exponential"):
        for b in (-1e-300, -5e-324, -0.0, 0.0):
            assert np.isclose(ALL_LAWS[name].log_lift([0.2, b, 0.1], pull)[0], euler, rtol=1e-15, atol=0.0)
