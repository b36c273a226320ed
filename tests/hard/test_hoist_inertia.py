"""F_B → ρv²⁺ in a scene: the running rope hardly presses; at ρv² and above it lifts off, and is refused by name."""

from dataclasses import replace

import numpy as np
import pytest
from hard_hoist import DENSITY, SPEED, lifted, rope, true_log_lift
from hard_regime import Regime, once, relative

from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS
from ropefric.systems.friction import WrapFriction

REGIME = Regime(
    name="F_B → ρv²⁺ in a hoist",
    statement="F_B/ρv² − 1 = 1e-3 … 2e-16, limp or half as stiff as it can follow, wraps of 25 and 200 rad: ln F_A "
    "of what a scene assembles",
    accuracy=1e-12,
)
CIRCLING = DENSITY * SPEED**2


@once(REGIME)
def measured():
    errors = []
    for above in (1e-3, 2.0**-30, 2.0**-52):
        tension = CIRCLING * (1.0 + above)
        for share in (0.0, 0.5):
            for wrap in (25.0, 200.0):
                case = {
                    "mu": 0.2, "wrap": wrap, "tension": tension, "stiffness_N": share * (tension - CIRCLING),
                    "moving": True,
                }  # fmt: skip
                errors.append(relative(lifted(rope(**case)).log_lift[0], true_log_lift(**case)))
    return max(errors)


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


def test_what_friction_adds_comes_back_after_many_turns():
    """16 N and a last bit above: over e^40 the bit outweighs the rest."""
    bit = 2.0**-52
    found = lifted(rope(wrap=200.0, tension=CIRCLING * (1.0 + bit), moving=True))
    np.testing.assert_allclose(found.lift_force_N, CIRCLING * (1.0 + bit * np.exp(40.0)), rtol=1e-13)


@pytest.mark.parametrize("speed", [SPEED, np.nextafter(SPEED, 17.0), -17.0, 1e9, 1e30])
@pytest.mark.parametrize("stiffness", [0.0, 1.0])
def test_a_rope_that_lifts_off_is_refused(speed, stiffness, refused):
    fast = replace(rope(wrap=25.0, tension=CIRCLING, stiffness_N=stiffness, moving=True), speed_m_s=speed)
    refused(lambda: lifted(fast), "is not below the end tension of 16 N: the rope lifts off the wheel")


def test_a_pressing_tension_below_the_reference_is_refused(refused):
    friction = WrapFriction(
        law=ALL_LAWS["wrap-power"],
        theta=np.array([0.2, -0.5, 0.1]),
        reference=one_condition(0.1875, 0.0625, 6.0, 60.0),
    )
    barely = rope(wrap=25.0, tension=16.5, friction=friction, moving=True)
    refused(lambda: lifted(barely), "F_B = 0.5 N is below F_0")
