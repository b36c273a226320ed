"""Tolerances of wheels, rope and wraps go from the campaign into the trial table, in memory and in the file."""

import math

import numpy as np
import pytest

import ropefric as rf
from ropefric.trials.result import write_tables

SETTINGS = ('tolerance = "0.2 mm"\n[wheels.W40]\nradius = "40 mm"\ntolerance = "0.1 mm"\n'
    '[protocol]\nname = "breakaway"\nwrap_tolerance = "2 deg"')  # fmt: skip
RECORDS = {"a": 50, "b": 52, "c": 110, "d": 108}


def test_tolerances_are_errors_that_trials_share_where_it_is_said(lab, tmp_path):
    lab.pulls(**RECORDS)
    rows = [{"file": f"{name}.csv", "wheel": "W40", "wrap_angle_deg": 180 * (1 + (name in "cd")),
        "end_tension_N": 20} for name in RECORDS]  # fmt: skip
    extraction = lab.write(rows, SETTINGS).extract()
    table = rf.trial_table(extraction)
    assert table.wheel_radius_std_m == pytest.approx(1e-4 / math.sqrt(3))
    assert table.rope_radius_std_m == pytest.approx(1e-4 / math.sqrt(3))  # 0.2 mm of the diameter given
    assert table.wrap_std_rad == pytest.approx(math.radians(2) / math.sqrt(3))
    write_tables(extraction, tmp_path)
    again = rf.trial_table(tmp_path / "trials.csv")
    for name in ("wheel_radius_std_m", "rope_radius_std_m", "wrap_std_rad", "cell_std_N"):
        np.testing.assert_allclose(getattr(again, name), getattr(table, name), rtol=1e-8)
    assert rf.fit(extraction, "thickness").common_errors == ()
    shared = {"wheel_radius": "wheel", "rope_radius": "rope", "wrap": "rig"}
    found = rf.fit(extraction, "thickness", shared=shared).common_errors
    assert {(item.kind, item.by) for item in found} == set(shared.items())
