"""The wrap φ0 that the end tension stands for is below every float: ln φ0 = −5298 and far less."""

from hard_regime import Regime, once, worst_law_error

from ropefric.friction.condition import one_condition
from ropefric.friction.integral import power_log_start
from ropefric.friction.laws import ALL_LAWS

REGIME = Regime(
    name="φ0 underflows",
    statement="a φ^b + c and the coupled law with b + 1 = 1e-3 … 2e-16, F_B = 1.5 … 1e6 N: ln F_A and slopes",
    accuracy=1e-12,
)


@once(REGIME)
def measured():
    power = [
        ("wrap-power", [0.2, s - 1.0, c], (0.04, 0.005, wrap, tension))
        for s, c, wrap, tension in [
            (1e-3, 0.1, 5.0, 2.7),
            (1e-3, 0.0, 40.0, 200.0),
            (1e-3, 0.01, 1e-9, 20.0),
            (1e-9, 0.1, 5.0, 1e6),
            (2.0**-52, 0.1, 17.0, 1.5),
            (2.0**-52, 0.0, 0.3, 20.0),
        ]
    ]
    coupled = [("coupled", [0.2, -0.2, -0.3, s - 1.0, 0.05], (0.04, 0.005, 6.0, 20.0)) for s in (1e-3, 1e-12)]
    return worst_law_error([*power, *coupled], digits=500)


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


def test_the_start_is_far_below_every_float():
    assert -5299 < power_log_start(1.0, 0.2, -0.999, 0.0) < -5298
    assert power_log_start(1.0, 0.2, -1 + 2.0**-52, 0.0) < -1e17


def test_the_lift_force_does_not_depend_on_the_load_there():
    # μ(φ0) is beyond every number, so F_A is what the wrap alone makes of F_0 … and the slope by ln F_B is nothing.
    slopes = ALL_LAWS["wrap-power"].log_lift_gradient_conditions(
        [0.2, -0.999, 0.1], one_condition(0.04, 0.005, 5.0, 2.7)
    )
    assert slopes[0, 2] == 0.0
