"""Habits of loggers nobody here has: rows above the data, units, clocks and what stands beside a measured force."""

import numpy as np
import pytest
from reading import read, refused

from ropefric.files.text_table import is_unit
from ropefric.quantities import split_unit_suffix
from ropefric.traces.readers.inspection import inspect_file
from ropefric.traces.readers.profile import Channel


def pull(row, n=40, **more):
    """Return lines of a pull, 25 Hz and 2 N a row, after a template with {t}, {f}, {i}."""
    return "".join(row.format(i=i, t=f"{i / 25:.2f}", f=f"{2 * i}", **more) + "\n" for i in range(n))


def seen(found):
    """Return what matters of an inspection that reads: the columns of its channels, and what was read."""
    assert found.stopped == ""
    return {name: channel.column for name, channel in found.profile.channels.items()}, found.read


PULL = "1 recording of 40 samples, 25 Hz, 0 to 78 N"

# --- rows above the data ---


def test_a_unit_is_known_by_how_it_is_written_and_a_name_is_none():
    units = "kN·mm", "[1/s]", "mm/sec", "Pa*s", "µNm", "(m^2)", "second", "Nmm", "daN", "s⁻¹", "N/mm²"
    assert [cell for cell in units if not is_unit(cell)] == []
    names = "Force", "Time", "F", "t", "x", "CH1", "NO.", "Smp", "load", "2 runs", "mean"
    assert [cell for cell in names if is_unit(cell)] == []


def test_one_rare_unit_does_not_make_a_row_of_units_the_names(write):
    path = write("Way\tLoad\tTorque\tRunning Time\nmm\tN\tkN·mm\tsec\n" + pull("{i}.5\t{f}\t0.1\t{t}"))
    assert seen(inspect_file(path)) == ({"time": "Running Time", "force": "Load"}, PULL)


def test_rows_of_words_between_names_and_data_hide_no_name(write):
    head = "Kraft am Seil;Weg\nZeit [s];Kraft [N];Weg [mm]\n25 Hz;25 Hz;25 Hz\nU9C 1kN;U9C 1kN;WA50\n"
    found = inspect_file(write(head + pull("{t};{f};{i}")))
    assert seen(found) == ({"time": "Zeit [s]", "force": "Kraft [N]"}, PULL)
    assert (found.header_row, found.profile.header_row) == (2, 2)
    head = '"TIMESTAMP","RECORD","Pull","Way"\n"TS","RN","N","mm"\n"","","Smp","Smp"\n'
    found = inspect_file(write(head + pull('"2024-05-17 10:21:{i:02d}",{i},{f},1.5')))
    assert seen(found)[0] == {"time": "TIMESTAMP", "force": "Pull"}
    assert (found.header_row, found.units_row) == (1, 2)


def test_numbers_over_units_are_names_of_channels(write):
    found = inspect_file(write("x-axis,1\nsecond,Volt\n" + pull("{t},{f}")))
    assert [(column.name, column.unit) for column in found.columns] == [("x-axis", "s"), ("1", "V")]
    assert found.profile.channels["force"] == Channel(column="1", unit="V")


def test_a_labelled_row_of_counts_is_no_data(write):
    head = "Result:,Pull 3,,\nInterval and points:,1,40,\nInterval data:,Point,Force,Time\n,,,\n,,[N],[s]\n"
    assert seen(inspect_file(write(head + pull(",{i},{f},{t}"))))[1] == PULL


# --- cells ---


def test_a_unit_behind_the_number_in_every_cell(write):
    found = inspect_file(write("Time (s),Tension\n" + pull("{t},{f}.5 kN")))
    assert seen(found)[1] == "1 recording of 40 samples, 25 Hz, 500 to 7.85e+04 N"
    error = refused(
        write("time_s,Tension\n0,1 kN\n1,200 N\n"),
        channels={"time": Channel(column="time_s"), "force": Channel(column="Tension")},
    )
    assert (error.code, error.where) == ("RF102", "run:3 Tension")
    found = inspect_file(write("Time (s),Pull [N]\n" + pull("{t},{f}.5 kN")))
    assert ("cannot read '0.5 kN'" in " ".join(found.doubts), found.read) == (True, "")


def test_a_column_that_breaks_off_says_where(write):
    rows = pull("{t};{f}").replace("1.00;50", "1.00;∞").replace("1.20;60", "1.20;OVL")
    found = inspect_file(write("Time (s);Channel A\n" + rows))
    assert found.stopped
    assert any(":27" in doubt and "'∞'" in doubt and "infinite" in doubt for doubt in found.doubts)
    found = inspect_file(
        write("Time;Load\nms;N\n" + "".join(f"{i * 40:,};{i}\n".replace(",", "'") for i in range(40)))
    )
    assert any('thousands = "\'"' in doubt for doubt in found.doubts)


def test_a_column_of_remarks_is_no_doubt(write):
    found = inspect_file(write("Time (s),Pull [N],Remark\n" + pull("{t},{f},dry; clean")))
    assert seen(found)[1] == PULL
    assert not any("dry" in doubt for doubt in found.doubts)


def test_the_zero_that_ends_a_string_of_c_is_no_damage(write):
    rows = pull("{t},{f}")
    path = write("D:\\tests\\pull 3.txt\0\r\n\r\nTime (s),Load (N)\r\n" + rows)
    assert seen(inspect_file(path))[1] == PULL
    error = refused(write("time_s,force_N\n" + rows[:250] + "\0" * 64 + rows[314:]))
    assert ("copy the file again" in error.fix, "zero" in str(error)) == (True, True)


def test_text_that_is_called_a_workbook_is_read_as_text(write):
    assert seen(inspect_file(write("Time (s)\tForce (N)\n" + pull("{t}\t{f}"), "pull.xls")))[1] == PULL


def test_a_date_joined_to_its_time_of_day_is_a_stamp(write):
    found = inspect_file(write("when,Load (N)\n" + pull("2018-11-30-10:04:{i:02d}.5,{f}")))
    assert seen(found) == ({"time": "when", "force": "Load (N)"}, PULL.replace("25 Hz", "1 Hz"))


def test_units_as_r_writes_them():
    assert [split_unit_suffix(name) for name in ("Load.N.", "Time..s.", "No.", "v1.2.")] == [
        *(("Load", "N"), ("Time", "s"), ("No.", ""), ("v1.2.", ""))
    ]


def test_empty_rows_at_the_end_are_no_samples(write):
    head, rows = "# sampling rate: 25 Hz\nNo.,Load (N)\n", pull("{i},{f}")
    (trace,) = read(write(head + rows + ",\n" * 300), channels={"force": Channel(column=2)})
    assert (trace.force_N.size, trace.force_N[-1]) == (40, 78)
    blank = rows.replace("20,40\n", "20,40\n" + "\n" * 500)
    assert seen(inspect_file(write(head + blank)))[1] == PULL


def test_a_cut_row_is_named_where_rows_end_with_a_separator(write):
    error = refused(write("Time (s);Load (N);Way\n" + pull("{t};{f};1.5;") + "1.60;8"))
    assert (error.code, error.where) == ("RF103", "run:42")


# --- which column is what ---


@pytest.mark.parametrize(
    "name", ["preload_N", "GoalForce (N)", "Sollkraft [N]", "cmd_N", "Set Force (N)", "Nominal Load (N)"]
)
def test_a_force_that_is_set_is_not_the_measured_one(write, name):
    path = write(f"time_s,{name},pulled_N\n" + pull("{t},1{f},{f}"))
    assert seen(inspect_file(path)) == ({"time": "time_s", "force": "pulled_N"}, PULL)


def test_a_strain_that_rises_is_no_time(write):
    strain = np.cumsum(np.linspace(1, 3, 40)) / 1e3
    rows = "".join(f"{one:.6f},{2 * i}\n" for i, one in enumerate(strain))
    found = inspect_file(write("strain,Load (N)\n" + rows))
    assert found.profile.channels.keys() == {"force"}
    assert any("no column looks like the time" in doubt for doubt in found.doubts)
    assert inspect_file(write(rows)).profile.channels["time"] == Channel(
        column=1, unit="s"
    )  # nothing names it
    assert (
        inspect_file(write("Время,Load (N)\n" + pull("{t},{f}"))).profile.channels["time"].column == "Время"
    )


def test_channels_in_rows_whose_time_has_no_unit(write):
    rows = "".join(
        f"{1736440328.5 + i / 25:.3f},{side},{i + k}\n"
        for i in range(40)
        for k, side in enumerate(("top", "slack"))
    )
    found = inspect_file(write("Unix Timestamp,Position,Value [N]\n" + rows))
    assert seen(found) == (
        {"time": "Unix Timestamp", "force": "top", "end_tension": "slack"},
        PULL.replace("78", "39"),
    )
    assert (found.format, found.sampling_rate_Hz) == ("long", 25)
    assert any(
        "does not state the unit of the time; s is taken, as that makes 25 Hz" in doubt
        for doubt in found.doubts
    )


def test_the_indices_that_pytables_writes_are_no_recordings(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file["pull/time_s"], file["pull/force_N"] = np.arange(40) / 25, 2.0 * np.arange(40)
        file["pull/_i_table/index/sorted"] = np.arange(4000.0)
    (trace,) = read(
        tmp_path / "run.h5",
        channels={n: Channel(column=f"pull/{n}_{u}") for n, u in (("time", "s"), ("force", "N"))},
    )
    assert trace.force_N.size == 40
    assert [column.name for column in inspect_file(tmp_path / "run.h5").columns] == [
        "pull/force_N",
        "pull/time_s",
    ]
