"""A sweep over preloads and speeds gives what the formulas of a press with one load say at every point."""

import numpy as np
import pytest

from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.slip import SlipTable
from ropefric.systems.press.statics import solve_statics, steady_state

SPEEDS, PRELOADS = np.linspace(0.0, 8.0, 9), np.linspace(600.0, 1000.0, 5)


@pytest.fixture(scope="module")
def statics():
    """One belt over a driver, a loaded roller, an idler and a take-up."""
    rollers = (Roller(name="drive", radius_m=0.1, wrap_angle_rad=3.0, role="driver"),
               Roller(name="load", radius_m=0.1, wrap_angle_rad=1.0, squeeze_torque_N_m=12.0),
               Roller(name="idler", radius_m=0.1, wrap_angle_rad=1.0),
               Roller(name="take-up", radius_m=0.1, wrap_angle_rad=3.0, role="tensioner",
                      tensioner=Tensioner(spring_N_m=0.0, travel_m=0.0, force_N=600.0)))  # fmt: skip
    loop = tuple(roller.name for roller in rollers)
    belt = Belt(name="belt", loop=loop, linear_density_kg_m=1.0, thickness_m=0.005, width_m=1.0)
    return solve_statics(Press(rollers=rollers, belts=(belt,), speed_m_s=2.0))


def test_the_largest_utilisation_is_that_of_the_loaded_roller(statics):
    state = steady_state(statics, preload_N=PRELOADS[:, None], speed_m_s=SPEEDS)
    slip = SlipTable(statics.press, state.effective_tension_N, 0.6)
    # U = 120 / ((F/2 − 120 − v²) (e^0.6 − 1)) for the roller `load`.
    slack_N = PRELOADS[:, np.newaxis] / 2.0 - 120.0 - SPEEDS**2
    np.testing.assert_allclose(slip.of("load"), 120.0 / (slack_N * np.expm1(0.6)), rtol=1e-12)
    assert (slip.utilisation.max(axis=-1) >= slip.of("load")).all()
