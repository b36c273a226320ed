"""F_B → ρv²⁺: the rope hardly presses on the wheel; at ρv² and above it lifts off, and is refused by name."""

import mpmath as mp
import numpy as np
import pytest
from hard_regime import Regime, once, relative

from ropefric.friction.condition import one_condition
from ropefric.friction.law import LiftModel
from ropefric.friction.laws import ALL_LAWS

REGIME = Regime(
    name="F_B → ρv²⁺",
    statement="F_B/ρv² − 1 = 1e-3 … 2e-16: ln F_A, and the digits of what friction adds as far as F_B − ρv² has them",
    accuracy=1e-12,
)
DENSITY, SPEED = 0.0625, 16.0  # 16 N, exact in floats
MU, WRAP = 0.2, 25.0


@once(REGIME)
def measured():
    worst = 0.0
    for above in (1e-3, 2.0**-30, 2.0**-52):
        tension = DENSITY * SPEED**2 * (1 + above)
        pull = one_condition(0.04, 0.005, WRAP, tension)
        found = LiftModel(law=ALL_LAWS["constant"], linear_density_kg_m=DENSITY, speed_m_s=SPEED).log_lift(
            [MU], pull
        )[0]
        with mp.workdps(60):
            inertia = mp.mpf(DENSITY) * mp.mpf(SPEED) ** 2
            pressing = (mp.mpf(tension) - inertia) * mp.exp(mp.mpf(MU) * mp.mpf(WRAP))
            truth = mp.log(inertia + pressing)
        worst = max(worst, relative(found, truth))
    return worst


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


@pytest.mark.parametrize("speed", [16.0, 16.000001, 1e9, 1e160, 1.7e308, -17.0])
def test_a_rope_that_lifts_off_is_refused(speed, refused):
    pull = one_condition(0.04, 0.005, WRAP, 16.0)
    refused(
        lambda: LiftModel(law=ALL_LAWS["constant"], linear_density_kg_m=DENSITY, speed_m_s=speed).log_lift(
            [MU], pull
        ),
        "is not below F_B at condition 0 .*: the rope lifts off the wheel",
    )


def test_a_pressing_tension_below_the_reference_is_refused(refused):
    pull = one_condition(0.04, 0.005, WRAP, 16.5)
    refused(
        lambda: LiftModel(law=ALL_LAWS["wrap-power"], linear_density_kg_m=DENSITY, speed_m_s=SPEED).log_lift(
            [0.2, -0.5, 0.1], pull
        ),
        "F_B = 0.5 N is below F_0",
    )


def test_a_rope_at_rest_is_the_law_itself_whatever_its_size():
    for tension in (1e-310, 1e-300, 20.0, 1e300):
        pull = one_condition(0.04, 0.005, WRAP, tension)
        moving = LiftModel(law=ALL_LAWS["constant"], linear_density_kg_m=1e300, speed_m_s=0.0).log_lift(
            [MU], pull
        )
        assert moving[0] == ALL_LAWS["constant"].log_lift([MU], pull)[0]


@pytest.mark.parametrize("speed", [np.nan, np.inf, -np.inf])
def test_a_speed_that_no_float_holds_is_refused(speed, refused):
    refused(
        lambda: LiftModel(law=ALL_LAWS["constant"], linear_density_kg_m=DENSITY, speed_m_s=speed),
        "must be finite",
    )
