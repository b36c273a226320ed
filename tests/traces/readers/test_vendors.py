"""Exports of vendors, Vernier's XML and HDF5: names, units and clocks as they are told, damage with place and remedy."""

import math

import numpy as np
import pytest
from reading import read, refused

from ropefric.traces.readers.inspection import inspect_file
from ropefric.traces.readers.profile import Channel

# --- NI ---

NI = """\ufeffTimestamp,2020-03-16 17:04:51,Timestamp,2020-03-16 17:04:51
Interval,0.5,Interval,0.5
Channel name,"Force",Channel name,"Way, left"
Unit,"kN",Unit,"mm"
0,0.25,0,1
0.5,0.5,0.5,2
1,0.75,1,3
"""


def test_an_ni_export_keeps_its_names_and_its_clocks(write):
    path = write(NI)
    (trace,) = read(path)
    assert (trace.time_s.tolist(), trace.force_N.tolist()) == ([0, 0.5, 1], [250, 500, 750])
    assert "NI export: Force, Way, left, each with a time of its own" in trace.notes
    found = inspect_file(path)
    assert [(c.name, c.unit) for c in found.columns] == [
        *(("time of Force", "s"), ("Force", "kN"), ("time of Way, left", "s"), ("Way, left", "mm"))
    ]
    assert (found.format, found.sampling_rate_Hz, found.doubts) == ("ni-csv", 2, ())
    assert "Timestamp: 2020-03-16 17:04:51" in found.notes


def test_ni_channels_with_other_clocks_are_aligned_by_time(write):
    path = write(NI.replace("0.5,0.5,0.5,2", "0.5,0.5,0.25,2"))
    both = {"force": Channel(column="Force"), "way": Channel(column="Way, left")}
    (trace,) = read(path, channels=both, derived={"force": "force + 0.0 * way / 1000"})
    assert (trace.time_s.tolist(), trace.force_N.tolist()) == ([0, 0.5, 1], pytest.approx([250, 500, 750]))
    way = both | {"end_tension": Channel(column="Way, left", unit="N", instead_of="mm")}
    np.testing.assert_allclose(read(path, channels=way)[0].end_tension_N, [2, np.nan, 3])
    assert read(path, channels={"force": Channel(column="Force")})[0].time_s.tolist() == [0, 0.5, 1]


def test_a_damaged_ni_export_is_told(write):
    error = refused(write(NI + "1.5,oops,1.5,4\n"))
    assert (error.code, error.where) == ("RF102", "run:8 Force")
    error = refused(write("time_s,force_N\n0,1\n"), format="ni-csv")
    assert (error.code, "Channel name" in str(error)) == ("RF103", True)


def test_the_real_ni_export(real_data):
    path = real_data / "vendor_headers" / "a3NI.csv"
    found = inspect_file(path)
    assert [(c.name, c.unit) for c in found.columns][1::2] == [("Force", "V"), ("Input 1", "V")]
    assert (found.format, found.n_rows, found.sampling_rate_Hz) == ("ni-csv", 1078, 2000)
    assert any("the force is in V" in doubt for doubt in found.doubts)
    volts = {"channels": {"volts": Channel(column="Force")}, "constants": {"gain": 100.0}}
    (trace,) = read(path, **volts, derived={"force": "volts * gain"})
    assert trace.force_N[0] == pytest.approx(-12.917863583)
    assert trace.time_s[-1] == pytest.approx(1077 * 0.0005)


# --- Mitsubishi ---

MR = """Axis1
Number of sampling data,3
Sampling time interval(ms),0.5
Time,Analog 1,Analog 2,Digital 1
ms,Servo motor speed,Torque,Not selected
0.0,0,1,0
0.5,10,2,0
1.0,20,3,0
"""


def test_a_servo_trace_is_one_recording_with_the_names_of_what_was_measured(write):
    path = write(MR)
    found = inspect_file(path)
    assert (found.format, found.samples, found.n_rows) == ("mr-configurator", (), 3)
    assert [c.name for c in found.columns] == ["Time", "Servo motor speed", "Torque", "Digital 1"]
    assert any("Number of sampling data 3" in note for note in found.notes)
    channels = {"time": Channel(column="Time"), "torque": Channel(column="Torque")}
    (trace,) = read(path, channels=channels, derived={"force": "torque * 2"})
    assert (trace.time_s.tolist(), trace.force_N.tolist()) == ([0, 0.0005, 0.001], [2, 4, 6])


def test_a_quantity_measured_twice_is_told_by_its_slot(write):
    found = inspect_file(write(MR.replace("Servo motor speed", "Torque")))
    assert [c.name for c in found.columns[1:3]] == ["Torque (Analog 1)", "Torque (Analog 2)"]


def test_the_real_servo_trace(real_data):
    found = inspect_file(real_data / "vendor_headers" / "a3MR.csv")
    assert (found.format, found.n_rows, len(found.columns)) == ("mr-configurator", 1024, 16)
    assert found.sampling_rate_Hz == pytest.approx(1500, rel=1e-5)
    assert [c.name for c in found.columns[:4]] == [
        *("Time", "Servo motor speed", "Torque", "Droop pulses (by 1 pls.)")
    ]


def test_many_channels_under_one_header_are_one_recording(write):
    """A short row above (number of samples, operator) is no header of two columns written once."""
    rows = "".join(f"{i},{i},{i},{i}\n" for i in range(5))
    found = inspect_file(write(f"Operator,Smith\ntime_s,force_N,way_mm,other\n{rows}"))
    assert (found.format, found.samples, found.header_row) == ("delimited", (), 2)


# --- Vernier ---


def column(name, unit, cells):
    lines = "\n".join(str(cell) for cell in cells)
    return (
        f"<DataColumn><ID>1 </ID><DataObjectName>{name}</DataObjectName><DataObjectShortName>x"
        f"</DataObjectShortName><ColumnUnits>{unit}</ColumnUnits><ColumnCells>\n{lines}\n</ColumnCells></DataColumn>"
    )


def run(name, *columns):
    return f"<DataSet><ID>2 </ID><DataSetName>{name}</DataSetName>{''.join(columns)}</DataSet>"


def document(*runs):
    return f'<?xml version="1.0" encoding="UTF-8" ?>\n<Document>{"".join(runs)}</Document>'


TIME = column("Time", "s", [0, 0.1, 0.2])


def test_vernier_runs_are_recordings(write):
    first = run("Run 1", TIME, column("Force", "N", [1, "Z1 1:", 3]))
    latest = run("Latest", TIME, column("Force", "kN", [1, 2, 3]), column("Work", "J", []))
    fits = run("&#38;&#38;^% CurveFitFunctions")
    path = write(document(first, latest, fits), "run.cmbl")
    one, two = read(path)
    assert (one.name, two.name) == ("run#Run 1", "run#Latest")
    np.testing.assert_array_equal(one.force_N, [1, np.nan, 3])
    assert two.force_N.tolist() == [1000, 2000, 3000]
    assert "Vernier Logger Pro, runs: Run 1, Latest" in one.notes
    assert inspect_file(path).samples == ("Run 1", "Latest")
    (chosen,) = read(path, table="Latest")
    assert (chosen.name, chosen.time_s.tolist()) == ("run", [0, 0.1, 0.2])
    assert refused(path, table="Latset").fix == "did you mean 'Latest'?"


def test_a_vernier_file_that_cannot_be_used(write):
    for text, words in (
        ("<Document><DataSet>", "no element found"),
        ("hello", "not a readable Vernier file"),
        (document(), "no run"),
        (document(run("Run 1", TIME, column("Force", "N", ["1", "2,5", "3"]))), "decimal comma"),
        ('<!DOCTYPE a [<!ENTITY b "c">]><Document>&b;</Document>', "XML entities"),
        ('<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><Document>&b;</Document>', "XML entities"),
    ):
        error = refused(write(text, "run.cmbl"))
        assert error.code in {"RF101", "RF102"}
        assert words in str(error)


# --- HDF5 ---


def save_h5(path, fill):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        fill(file)
    return path


def test_data_sets_are_columns_and_attributes_tell_the_rate(tmp_path):
    def fill(file):
        group = file.create_group("pull")
        group.attrs["Sampling rate"] = 200.0
        group["force"] = np.array([1.0, 2.0, 3.0])
        group["force"].attrs["units"] = "kN"
        file["warm_up/force"] = np.arange(9)
        file["note"] = "text"

    path = save_h5(tmp_path / "run.h5", fill)
    (trace,) = read(path, table="pull")
    assert (trace.force_N.tolist(), trace.time_s.tolist()) == ([1000, 2000, 3000], [0, 0.005, 0.01])
    assert "0.005 s from sample to sample, by the attribute 'Sampling rate'" in trace.notes
    (trace,) = read(path, channels={"force": Channel(column="pull/force")})
    assert trace.sampling_rate_Hz == 200
    found = inspect_file(path)
    assert ([(c.name, c.unit) for c in found.columns], found.samples) == (
        [("force", "kN")],
        ("pull", "warm_up"),
    )
    assert "did you mean 'pull'" in refused(path, table="pul").fix


def test_times_matrices_and_records(tmp_path):
    def fill(file):
        file["time"] = np.arange(4) / 10
        file["force"] = np.arange(4)[:, None]
        file["matrix"] = np.column_stack([np.arange(4), np.arange(4) * 2])
        file["records"] = np.array([(i, i * 3) for i in range(4)], dtype=[("t", float), ("F", float)])
        file["empty"] = np.empty((0, 3))

    path = save_h5(tmp_path / "run.hdf5", fill)
    keys = {"time": Channel(column="time", unit="s")}
    for name, slope in (("force", 1), ("matrix/2", 2), ("records/F", 3)):
        (trace,) = read(path, channels={**keys, "force": Channel(column=name, unit="N")})
        assert trace.force_N.tolist() == [0, slope, 2 * slope, 3 * slope]
    assert [column.n_missing for column in inspect_file(path).columns if column.name == "empty"] == [0]


def test_hdf5_that_cannot_be_used(tmp_path, write):
    h5py = pytest.importorskip("h5py")
    assert refused(write(b"\x89HDF\r\n\x1a\n" + bytes(100), "run.h5")).code == "RF101"
    assert refused(save_h5(tmp_path / "void.h5", lambda file: None)).code == "RF101"
    outside = save_h5(tmp_path / "outside.h5", lambda file: file.create_dataset("force", data=np.arange(5.0)))

    def link(file):
        file["force"] = h5py.ExternalLink(outside.name, "force")

    assert refused(save_h5(tmp_path / "link.h5", link)).code == "RF101"  # other files are not opened


def test_a_rate_is_a_positive_number(tmp_path):
    def fill(file):
        file["force"] = np.arange(5.0)
        file["force"].attrs["fs"] = math.nan
        file["force"].attrs["dt"] = 0.25
        file["force"].attrs["unit"] = b"N"

    assert read(save_h5(tmp_path / "run.h5", fill))[0].time_s.tolist() == [0, 0.25, 0.5, 0.75, 1]
