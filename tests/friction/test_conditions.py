"""Conditions: spread to one length, read-only, and refused with the place of the first mistake."""

import numpy as np
import pytest

from ropefric.errors import InputError
from ropefric.friction.condition import Conditions, condition_groups, distinct, levels

GOOD = {"wheel_radius_m": 0.04, "rope_radius_m": 0.005, "wrap_angle_rad": [1.0, 2.0, 3.0],
        "end_tension_N": 20}  # fmt: skip


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


def test_what_cannot_be_is_refused():
    for name, value, said in (
        ("wheel_radius_m", [0.04, 0.0, 0.04], r"wheel_radius_m\[1\] is 0 m"),
        ("rope_radius_m", -0.005, r"rope_radius_m\[0\] is -0.005 m"),
        ("wrap_angle_rad", [1.0, 2.0, -1e-9], r"wrap_angle_rad\[2\] is -1e-09 rad"),
        ("end_tension_N", [1.0, np.nan, np.nan], r"end_tension_N\[1\] is nan N.*2 of 3"),
        ("end_tension_N", np.inf, "must be finite and positive"),
        ("end_tension_N", "heavy", "not a number"),
        ("end_tension_N", [[1.0, 2.0, 3.0]], "has 2 axes"),
        ("end_tension_N", [1.0, 2.0], "disagree in length"),
    ):
        with pytest.raises(InputError, match=said):
            Conditions(**GOOD | {name: value})


def test_selection_keeps_the_order():
    pulls = Conditions(**GOOD)
    assert pulls.select([2, 0]).wrap_angle_rad.tolist() == [3.0, 1.0]
    assert pulls.select(pulls.wrap_angle_rad > 1.5).wrap_angle_rad.tolist() == [2.0, 3.0]


def test_settings_are_put_together_by_one_rule_without_an_edge():
    """Rounding to any number of digits has edges; equal settings written in two units may lie on either side."""
    degrees = np.arange(5.0, 1100.0, 5.0)
    twice = np.concatenate([np.radians(degrees), np.array([float(f"{x:.9g}") for x in np.radians(degrees)])])
    assert levels(twice).tolist() == 2 * list(range(degrees.size))
    assert condition_groups(twice, np.full(twice.size, 0.04)).tolist() == 2 * list(range(degrees.size))
    assert distinct([0.3, 0.1 + 0.2, 0.0, 0.0]).tolist() == [0.0, 0.3]


def test_measured_forces_do_not_join_hands():
    """A chain of neighbours, each a part in ten million above the last, is no single setting."""
    forces_N = 60.0 * (1.0 + 1e-7 * np.arange(1000))
    assert levels(forces_N).max() > 80


def test_conditions_are_numbered_in_order_of_appearance_and_missing_settings_are_alike():
    assert condition_groups([3.0, 1.0, 3.0, 2.0]).tolist() == [0, 1, 0, 2]
    assert condition_groups([np.nan, 1.0, np.nan], [1.0, 1.0, 1.0]).tolist() == [0, 1, 0]
    assert condition_groups([]).tolist() == []
    big = np.arange(5000.0) + 1.0
    assert condition_groups(big, big, big, big, big, big).tolist() == list(range(5000))
