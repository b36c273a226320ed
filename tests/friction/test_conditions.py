"""Conditions: spread to one length, read-only, and refused with the place of the first mistake."""

import numpy as np
import pytest

from ropefric.errors import InputError
from ropefric.friction.condition import Conditions

GOOD = {
    "wheel_radius_m": 0.04,
    "rope_radius_m": 0.005,
    "wrap_angle_rad": [1.0, 2.0, 3.0],
    "end_tension_N": 20,
}


def test_scalars_spread_and_arrays_are_the_conditions_own():
    wrap = np.array([1.0, 2.0, 3.0])
    pulls = Conditions(**GOOD | {"wrap_angle_rad": wrap})
    wrap[0] = 99.0
    assert len(pulls) == 3
    assert pulls.wrap_angle_rad.tolist() == [1.0, 2.0, 3.0]
    assert pulls.end_tension_N.dtype == np.float64
    with pytest.raises(ValueError, match="read-only"):
        pulls.end_tension_N[0] = 1.0
    assert np.allclose(pulls.log_end_tension, np.log(20.0), rtol=1e-15)
    assert pulls.size_ratio.tolist() == [8.0, 8.0, 8.0]


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("wheel_radius_m", [0.04, 0.0, 0.04], r"wheel_radius_m\[1\] is 0 m"),
        ("rope_radius_m", -0.005, r"rope_radius_m\[0\] is -0.005 m"),
        ("wrap_angle_rad", [1.0, 2.0, -1e-9], r"wrap_angle_rad\[2\] is -1e-09 rad"),
        ("end_tension_N", [1.0, np.nan, np.nan], r"end_tension_N\[1\] is nan N.*2 of 3"),
        ("end_tension_N", np.inf, "must be finite and positive"),
        ("end_tension_N", "heavy", "not a number"),
        ("end_tension_N", [[1.0, 2.0, 3.0]], "has 2 axes"),
        ("end_tension_N", [1.0, 2.0], "disagree in length"),
    ],
)
def test_what_cannot_be_is_refused(name, value, said):
    with pytest.raises(InputError, match=said):
        Conditions(**GOOD | {name: value})


def test_selection_keeps_the_order():
    pulls = Conditions(**GOOD)
    assert pulls.select([2, 0]).wrap_angle_rad.tolist() == [3.0, 1.0]
    assert pulls.select(pulls.wrap_angle_rad > 1.5).wrap_angle_rad.tolist() == [2.0, 3.0]
