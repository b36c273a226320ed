"""MATLAB, TDMS and sheets: the same recording comes out of each, and damage is told."""

import datetime as dt
import sys

import numpy as np
import pytest

from ropefric.errors import DataError
from ropefric.traces.assemble import assemble_trace
from ropefric.traces.readers import find_reader, read_recordings
from ropefric.traces.readers.inspection import inspect_file
from ropefric.traces.readers.profile import Channel, ImportProfile

START = dt.datetime(2024, 1, 1)  # noqa: DTZ001  (loggers write local time)
T = np.arange(50) * 2.0
F = np.sin(T) + 2
BY_NAME = ImportProfile(
    channels={"time": Channel(column="t", unit="ms"), "force": Channel(column="F", unit="kN")}
)
BY_NUMBER = ImportProfile(
    channels={"time": Channel(column=1, unit="ms"), "force": Channel(column=2, unit="kN")}
)


def check(path, profile):
    (recording,) = read_recordings(path, profile)
    trace = assemble_trace(recording, profile)
    np.testing.assert_allclose(trace.time_s, T * 1e-3, rtol=1e-15)
    np.testing.assert_allclose(trace.force_N, F * 1e3, rtol=1e-15)
    found = inspect_file(path, profile)
    assert (found.format, found.n_rows) == (find_reader(path, profile).name, 50)


def refused(path, profile=BY_NAME):
    with pytest.raises(DataError) as caught:
        read_recordings(path, profile, shown_as="shown")
    assert caught.value.problem.path == "shown"
    return caught.value


def save_mat(path, content, **options):
    from scipy.io import savemat

    savemat(path, content, **options)
    return path


def test_matlab(tmp_path):
    for content, profile in (({"t": T, "F": F, "note": "x"}, BY_NAME),
        ({"t": T[:, None], "F": F[None, :], "rate": 500.0}, BY_NAME),
        ({"run": {"t": T, "F": F, "who": "Jo"}}, BY_NAME), ({"data": np.column_stack([T, F])}, BY_NUMBER),
        ({"t": T.astype(np.int16), "F": F}, BY_NAME)):  # fmt: skip
        for options in ({}, {"do_compression": True}):
            check(save_mat(tmp_path / "run.mat", content, **options), profile)
    check(save_mat(tmp_path / "run.mat", {"t": T, "F": F}, format="4"), BY_NAME)


def test_matlab_variables_are_named_and_missed(tmp_path):
    path = save_mat(tmp_path / "run.mat", {"warmup": np.zeros((9, 2)), "pull": np.column_stack([T, F])})
    named = ImportProfile(table="pull", channels=BY_NUMBER.channels)
    check(path, named)
    error = refused(path, ImportProfile(table="pul", channels=BY_NUMBER.channels))
    assert (error.code, error.fix) == ("RF105", "did you mean 'pull'?")
    assert "without names" in str(refused(path, BY_NAME))


def test_matlab_content_that_cannot_be_used(tmp_path):
    for content, code in (
        ({"t": T, "F": F[:9]}, "RF103"), ({"t": T, "F": F * 1j}, "RF105"), ({"F": F * np.inf, "t": T}, "RF102"),
        ({"note": "nothing"}, "RF101"), ({}, "RF101"),
    ):  # fmt: skip
        assert refused(save_mat(tmp_path / "run.mat", content)).code == code
    path = tmp_path / "run.mat"
    path.write_bytes(b"MATLAB 7.3 MAT-file".ljust(512) + b"\x89HDF\r\n\x1a\n" + bytes(100))
    error = refused(path)
    assert error.code == "RF101"
    assert "-v7" in error.fix


def save_tdms(path, channels, group="g"):
    tdms = pytest.importorskip("nptdms")
    with tdms.TdmsWriter(path) as writer:
        writer.write_segment([tdms.ChannelObject(group, *channel) for channel in channels])
    return path


def test_tdms(tmp_path):
    path = save_tdms(
        tmp_path / "run.tdms", [("t", T, {"unit_string": "ms"}), ("F", F, {"unit_string": "kN"})]
    )
    check(path, ImportProfile(channels={"time": Channel(column="t"), "force": Channel(column="F")}))
    check(path, ImportProfile())
    assert refused(path, ImportProfile(table="pull")).fix == "known: g"


def test_tdms_without_waveforms_and_times_has_no_clock(tmp_path):
    found = inspect_file(save_tdms(tmp_path / "run.tdms", [("Force", F, {"unit_string": "kN"})]))
    assert (found.notes, found.sampling_rate_Hz) == ((), None)


def test_tdms_waveforms_bring_their_own_clock(tmp_path):
    waveform = {"wf_increment": 0.002, "wf_start_offset": 0.0, "wf_start_time": START}
    path = save_tdms(tmp_path / "run.tdms", [("Force", F, {**waveform, "unit_string": "kN"})])
    check(path, ImportProfile())
    assert inspect_file(path).sampling_rate_Hz == 500
    assert inspect_file(path).notes == ("the time is that of the waveforms",)
    (recording,) = read_recordings(path, ImportProfile(sampling_rate_Hz=100.0))
    assert "time" not in recording.columns  # the profile's word goes first


def test_tdms_channels_of_other_rates_do_not_hide_the_clock(tmp_path):
    start = {"wf_start_offset": 0.0, "wf_start_time": START}
    force = {"wf_increment": 0.002, "unit_string": "kN"}
    waves = [("Force", F, force | start), ("Room", F[:9], {"wf_increment": 1.0} | start)]
    path = save_tdms(tmp_path / "run.tdms", waves)
    check(path, ImportProfile())
    both = {"force": Channel(column="Force"), "end_tension": Channel(column="Room", unit="N")}
    (recording,) = read_recordings(path, profile := ImportProfile(channels=both))
    ends_N = assemble_trace(recording, profile).end_tension_N
    assert np.flatnonzero(np.isfinite(ends_N)).tolist() == [0]  # the second was read after the last force


def test_tdms_without_data_is_told(tmp_path):
    assert refused(save_tdms(tmp_path / "run.tdms", [("t", T), ("s", ["a"] * 50)]), ImportProfile(
        channels={"force": Channel(column="s")})).code == "RF102"  # fmt: skip


def save_xlsx(path, rows, sheet="Sheet"):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.title = sheet
    for row in rows:
        book.active.append(row)
    book.save(path)
    return path


ROWS = [list(row) for row in zip(T.tolist(), F.tolist(), strict=True)]


@pytest.mark.parametrize(
    "head", [[["t", "F"]], [["Test of March"], [], ["t", "F"]], [["t", "F"], ["ms", "kN"]]]
)
def test_sheets(tmp_path, head):
    check(save_xlsx(tmp_path / "run.xlsx", [*head, *ROWS]), BY_NAME)
    check(save_xlsx(tmp_path / "bare.xlsx", ROWS), BY_NUMBER)


@pytest.mark.parametrize(
    ("suffix", "package"), [("xlsx", "python_calamine"), ("tdms", "nptdms"), ("h5", "h5py")]
)
def test_missing_packages_are_told(tmp_path, monkeypatch, suffix, package):
    monkeypatch.setitem(sys.modules, package, None)
    path = tmp_path / f"run.{suffix}"
    path.write_bytes(b"anything")
    error = refused(path)
    assert (error.code, error.fix) == ("RF107", 'pip install "ropefric[lab]"')
    assert package in str(error)


@pytest.mark.parametrize("cell", ["12,47", "oops", True, START])
def test_a_sheet_cell_that_is_no_number(tmp_path, cell):
    error = refused(save_xlsx(tmp_path / "run.xlsx", [["t", "F"], [0, 1.5], [1, cell], [2, 3.5]]))
    assert (error.code, error.where) == ("RF102", "shown:3 F")


def test_sheet_text_numbers_missing_cells_and_names(tmp_path):
    rows = [["t", "F"], [0, "1,5"], [1, None], [2, "-"], [3, "#DIV/0!"]]
    path = save_xlsx(tmp_path / "run.xlsx", rows, "pulls")
    profile = ImportProfile(decimal=",", missing=("-",), channels=BY_NAME.channels, table="pulls")
    force = read_recordings(path, profile)[0].columns["force"]
    np.testing.assert_array_equal(force, [1.5, np.nan, np.nan, np.nan])
    assert "did you mean 'pulls'" in refused(path, ImportProfile(table="pull", channels=BY_NAME.channels)).fix
    assert refused(save_xlsx(tmp_path / "void.xlsx", [])).code == "RF101"
