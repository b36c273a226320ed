"""Real recordings: what is known about them must come out."""

import numpy as np
import pytest

from ropefric.traces.assemble import assemble_trace
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.inspection import inspect_file
from ropefric.traces.readers.profile import Channel, ImportProfile

MECMESIN = ImportProfile(
    header_row=1, units_row=2, block_names_row=3, data_row=5, block_columns=4,
    channels={"time": Channel(column="Time"), "force": Channel(column=1)},
)  # fmt: skip


def test_the_inspected_profile_reads_the_wide_file_alike(real_data):
    path = real_data / "mecmesin_wide" / "example_forces_big.csv"
    found = inspect_file(path)
    assert (found.format, found.profile.block_columns, len(found.samples)) == ("wide", 4, 10)
    assert found.sampling_rate_Hz == pytest.approx(1000, rel=1e-3)
    for ours, theirs in zip(
        read_recordings(path, MECMESIN), read_recordings(path, found.profile), strict=True
    ):
        assert ours.sample == theirs.sample
        np.testing.assert_array_equal(ours.columns["force"], theirs.columns["force"])
        assert ours.units == theirs.units == {"time": "min", "force": "N"}


def test_a_headerless_wide_file(real_data):
    channels = {"time": Channel(column=3, unit="s"), "force": Channel(column=1, unit="N")}
    profile = ImportProfile(header_row=0, block_columns=4, channels=channels)
    path = real_data / "mecmesin_wide" / "example_forces_small.csv"
    first, second = read_recordings(path, profile)
    assert (first.sample, second.sample) == ("1", "2")
    np.testing.assert_array_equal(first.columns["force"], [1.2, 1.3, 1.4, 1.5])
    np.testing.assert_array_equal(second.columns["time"], [0.1, 0.25, 0.3, 0.4])


def test_capstan_files_read_without_any_profile(real_data):
    """The others are read by `trials/test_real_campaigns.py`."""
    (control,) = read_recordings(real_data / "phy_mini_ia_capstan" / "force_control.csv", ImportProfile())
    trace = assemble_trace(control, ImportProfile())
    assert (trace.sampling_rate_Hz, trace.notes) == (pytest.approx(50), ())
    assert trace.force_N[trace.time_s < 14].mean() == pytest.approx(7.8816, abs=1e-3)


def test_the_shifted_file_can_be_read_by_number(real_data):
    path = real_data / "rock_direct_shear" / "TM11_Pc130_Pp50_T180_repeat_test.txt"
    channels = {"time": Channel(column=1, unit="s"), "force": Channel(column=6, unit="kN")}
    profile = ImportProfile(header_row=0, data_row=4, channels=channels)
    trace = assemble_trace(read_recordings(path, profile)[0], profile)
    assert trace.force_N[0] == pytest.approx(30984.605)
    found = inspect_file(path)
    assert any("names 19 columns" in doubt for doubt in found.doubts)
    assert found.profile.header_row == 0
