"""Drive laws start at rest, end at full speed, and position and acceleration are the speed's integral and slope."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ropefric.errors import InputError
from ropefric.systems.press.transient.drives import DRIVE_LAWS, common_pieces, final_value, piecewise

TABLE = {"time_s": [0.0, 0.5, 2.0], "speed_m_s": [0.0, 0.8, 1.5]}
LAWS = {"constant": {"speed_m_s": 1.5}, "ramp": {"speed_m_s": 1.5, "duration_s": 2.0},
        "s-curve": {"speed_m_s": 1.5, "duration_s": 2.0}, "table": TABLE}  # fmt: skip
# After three seconds, by hand.
WAYS_M = {"constant": 4.5, "ramp": 3.0, "s-curve": 3.0, "table": 3.425}


def test_speed_position_and_acceleration_belong_together():
    assert set(LAWS) == set(DRIVE_LAWS) == set(WAYS_M)
    for name, arguments in LAWS.items():
        speed = DRIVE_LAWS[name](**arguments)
        assert final_value(speed) == 1.5, name
        assert float(speed(100.0)) == 1.5, name
        assert float(speed(0.0)) == (1.5 if name == "constant" else 0.0), name
        position, acceleration = speed.antiderivative(), speed.derivative()
        assert float(position(3.0)) == pytest.approx(WAYS_M[name], rel=1e-14), name
        at, h = np.array([0.1, 0.4, 1.1, 1.9, 2.5]), 1e-5
        np.testing.assert_allclose((position(at + h) - position(at - h)) / (2 * h), speed(at), rtol=1e-8)
        np.testing.assert_allclose(
            (speed(at + h) - speed(at - h)) / (2 * h), acceleration(at), rtol=1e-8, atol=1e-7
        )


def test_the_s_curve_has_no_jump_of_acceleration():
    acceleration = DRIVE_LAWS["s-curve"](**LAWS["s-curve"]).derivative()
    np.testing.assert_allclose(acceleration([0.0, 2.0 - 1e-12, 2.0]), 0.0, atol=1e-11)
    assert float(acceleration(1.0)) == pytest.approx(1.5 * 1.5 / 2.0)


@given(st.lists(st.floats(0.01, 3.0), min_size=1, max_size=4),
       st.lists(st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=3), min_size=5, max_size=5),
       st.floats(0.0, 12.0))  # fmt: skip
@settings(max_examples=40, deadline=None)
def test_taylor_coefficients_on_common_pieces_give_the_function_back(gaps, rows, time_s):
    starts = np.concatenate([[0.0], np.cumsum(gaps)])
    function = piecewise(starts, rows[: len(starts)])
    other = piecewise([0.0, 1.3], [[1.0], [2.0]])
    values = common_pieces([function, other]).at(time_s)
    scale = 5.0 * (1.0 + time_s) ** 2
    assert values[0] == pytest.approx(float(function(time_s)), abs=1e-12 * scale)
    assert values[1] == float(other(time_s))


def test_bad_parameters_are_refused():
    for name, arguments, word in [
        ("ramp", {"speed_m_s": 1.0, "duration_s": 0.0}, "duration_s"),
        ("s-curve", {"speed_m_s": float("nan"), "duration_s": 1.0}, "speed_m_s"),
        ("table", {"time_s": [0.0, 1.0], "speed_m_s": [0.0]}, "one speed for each"),
        ("table", {"time_s": [1.0, 2.0], "speed_m_s": [0.0, 1.0]}, "start at 0"),
        ("table", {"time_s": [0.0, 1.0], "speed_m_s": [0.0, -1.0]}, "zero or more"),
    ]:
        with pytest.raises(InputError, match=word):
            DRIVE_LAWS[name](**arguments)
