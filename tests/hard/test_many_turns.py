"""Hundreds of turns: ln F_A is far above 709 and fine; the force itself is no float and refused by name."""

import math

import numpy as np
import pytest
from hard_regime import Regime, once, worst_law_error

from ropefric.friction.condition import one_condition
from ropefric.friction.law import LiftModel
from ropefric.friction.laws import ALL_LAWS

REGIME = Regime(
    name="100 turns and more",
    statement="every law, 100 to 1e12 turns, ln F_A up to 1e12: ln F_A and slopes; the force beyond e^709.78 is "
    "refused",
    accuracy=1e-12,
)
TURNS = [2 * math.pi * n for n in (100, 1000, 1e12)]
THETA = {name: [parameter.start for parameter in law.parameters] for name, law in ALL_LAWS.items()}


@once(REGIME)
def measured():
    stiff = [("bending", THETA["bending"], (0.04, 0.005, TURNS[0], 20.0))]
    return worst_law_error(
        [
            (name, THETA[name], (0.04, 0.005, wrap, 20.0))
            for name in ALL_LAWS
            if name != "bending"
            for wrap in TURNS
        ]
        + stiff
    )


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


# Friction that falls with the tension, or along the wrap to a small plateau, never gets there in 1000 turns.
@pytest.mark.parametrize("name", [name for name in ALL_LAWS if name not in {"howell", "wrap-exponential"}])
def test_the_logarithm_stays_finite_where_the_force_is_no_number(name):
    pull = one_condition(0.04, 0.005, 2 * math.pi * 3000, 20.0)
    law = ALL_LAWS[name]
    assert law.log_lift(THETA[name], pull)[0] > 709.8


def test_the_largest_force_that_a_float_holds():
    wrap = (math.log(1.7976931348623157e308) - math.log(20.0)) / 0.2
    held = one_condition(0.04, 0.005, wrap * (1 - 1e-15), 20.0)
    assert 1.79e308 < math.exp(ALL_LAWS["constant"].log_lift([0.2], held)[0]) < math.inf


def test_a_running_rope_takes_no_notice_of_its_inertia_there():
    pull = one_condition(0.04, 0.005, 2 * math.pi * 1000, 20.0)
    moving = LiftModel(law=ALL_LAWS["constant"], linear_density_kg_m=0.06, speed_m_s=10.0).log_lift(
        [0.2], pull
    )
    assert np.isclose(moving[0], math.log(14.0) + 0.2 * 2 * math.pi * 1000, rtol=1e-15, atol=0.0)
