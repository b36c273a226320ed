"""All loads together, and the power that they take."""

import numpy as np
import pytest

from ropefric.systems.press.statics import solve_statics, steady_state


def test_all_loads_together_and_their_power(paper_press):
    pulls_N = [roller.torque_N_m / roller.radius_m for roller in paper_press.rollers]
    assert sum(pulls_N) == pytest.approx(1826.667, abs=5e-4)
    state = steady_state(solve_statics(paper_press))
    assert float(state.drive_power_W) == pytest.approx(1673.8, abs=0.05)
    # The same from the other end: what the motors turn.
    supplied_N = -(paper_press.incidence @ state.effective_tension_N)[~paper_press.is_driven]
    assert supplied_N.sum() == pytest.approx(sum(pulls_N))


def test_power_grows_with_load_and_speed(paper_press):
    statics = solve_statics(paper_press)
    state = steady_state(statics, load_factor=[[0.5], [1.0]], speed_m_s=[0.0, 1.0])
    np.testing.assert_allclose(state.drive_power_W, [[0.0, 913.3333], [0.0, 1826.6667]], rtol=1e-6)
