"""Every layout comes in: what `inspect` proposes of an unknown file reads it, and it says so, or what stops it."""

import datetime as dt
from dataclasses import replace

import numpy as np
import pytest
from reading import read, refused

from ropefric.traces.assemble import assemble_trace
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.inspection import inspect_file
from ropefric.traces.readers.profile import Channel, ImportProfile
from ropefric.traces.readers.several import blocks_of_header

PEAKS = (115.0, 118.0, 121.0)


def pull(peak_N, n=400, rate_Hz=100.0):
    time_s = np.arange(n) / rate_Hz
    return time_s, np.interp(time_s, [0, 0.5, 2.5, 2.6, 9], [0, 0, peak_N, 0.8 * peak_N, 0.8 * peak_N])


def proposed(path):
    """Return the traces by the proposed profile, which must have been tried."""
    found = inspect_file(path)
    assert not found.stopped, found.stopped
    assert found.read
    return found, [assemble_trace(raw, found.profile) for raw in read_recordings(path, found.profile)]


def tops(traces):
    return [float(np.nanmax(trace.force_N)) for trace in traces]


# --- files of others ---


@pytest.mark.parametrize(
    ("name", "top_N", "n", "rate_Hz", "said"),
    [
        ("counter-as-time/sno.csv", [120], 1, 10, "C_1_Temps"),
        ("excel-values-sheet-last/testxpert_three_sheets.xlsx", [120], 1, 10, "Values Specimen 1"),
        ("linescale/ls3_native.csv", [1200], 1, 40, "40 Hz"),
        ("linescale/logger_wide.csv", [1200], 1, 40, "value_kN"),
        ("note-beside-header/note.csv", [120], 1, 10, "Load"),
        ("quoted-thousands/pull.csv", [1200], 1, 100, "Load"),
        ("side-by-side-unequal/pasco_runs.csv", PEAKS, 3, 100, "3 recordings"),
        ("side-by-side-unequal/vernier_runs.csv", PEAKS, 3, 100, "3 recordings"),
        ("unit-spellings/mark10.csv", [120], 1, 100, "Load [lbF]"),
        ("unit-spellings/newton.lvm", [120], 1, 100, "Kraft"),
    ],
)
def test_files_of_others_come_in_by_their_own_proposal(real_data, name, top_N, n, rate_Hz, said):  # noqa: PLR0917
    path = real_data / "field_inputs" / name
    found, traces = proposed(path)
    assert tops(traces) == pytest.approx(top_N, rel=0.02)
    assert [trace.sampling_rate_Hz for trace in traces] == pytest.approx([rate_Hz] * n, rel=1e-3)
    assert f"{n} recording" in found.read
    assert said in str(found.to_dict())


# --- several recordings in a file, one ability ---

SHORTER = (300, 400, 350)
PULLS = [pull(peak_N, n) for peak_N, n in zip(PEAKS, SHORTER, strict=True)]


def side_by_side(head):
    rows = []
    for i in range(max(SHORTER)):
        cells = [f"{t[i]:.2f},{f[i]:.3f}" if i < t.size else "," for t, f in PULLS]
        rows.append(",".join(cells))
    return "\n".join([*head, *rows]) + "\n"


def below_each_other(head, *, between="\n"):
    parts = []
    for number, (time_s, force_N) in enumerate(PULLS, start=1):
        rows = [f"{t:.2f};{f:.3f}" for t, f in zip(time_s, force_N, strict=True)]
        parts.append("\n".join([*(line.format(number) for line in head), *rows]) + "\n")
    return between.join(parts)


def in_rows(form):
    lines = []
    for number, (time_s, force_N) in enumerate(PULLS, start=1):
        lines += [form.format(number, t, f) for t, f in zip(time_s, force_N, strict=True)]
    return "\n".join(lines) + "\n"


SEVERAL = {
    "names written once": (side_by_side(["Time (s),Force (N),,,,"]), "wide"),
    "Shimadzu": (
        side_by_side(
            ["1 _ 1,,1 _ 2,,1 _ 3,", "Time,Force,Time,Force,Time,Force", "(sec),(N),(sec),(N),(sec),(N)"]
        ),
        "wide",
    ),
    "numbered names": (
        side_by_side(["Time 1 (s),Force 1 (N),Time 2 (s),Force 2 (N),Time 3 (s),Force 3 (N)"]),
        "wide",
    ),
    "suffixed names": (side_by_side(["t_1 [s],F_1 [N],t_2 [s],F_2 [N],t_3 [s],F_3 [N]"]), "wide"),
    "header again": (below_each_other(["Probe {}", "Zeit [s];Kraft [N]"]), "stacked"),
    "header and units again": (
        below_each_other(["Specimen {}", "2026-03-0{} 10:00:00", "Time;Load", "s;N"]),
        "stacked",
    ),
    "header alone again": (below_each_other(["Time (s);Load (N)"], between=""), "stacked"),
    "a column of specimens": ("specimen,time_s,force_N\n" + in_rows("{},{:.2f},{:.3f}"), "long"),
    "a column of words": ("t_s;Versuch;F_N\n" + in_rows("{1:.2f};Lauf {0};{2:.3f}"), "long"),
}


@pytest.mark.parametrize("kind", SEVERAL)
def test_several_recordings_in_a_text_are_one_ability(write, kind):
    content, layout = SEVERAL[kind]
    found, traces = proposed(write(content))
    assert (found.format, len(found.samples), len(set(found.samples))) == (layout, 3, 3)
    assert tops(traces) == pytest.approx(PEAKS, abs=0.01)
    assert [trace.time_s.size for trace in traces] == list(SHORTER)
    assert "read 3 recordings" in f"read {found.read}"


def test_the_names_of_recordings_are_those_above_them(write):
    assert inspect_file(write(SEVERAL["header again"][0])).samples == ("Probe 1", "Probe 2", "Probe 3")
    assert inspect_file(write(SEVERAL["a column of words"][0])).samples == ("Lauf 1", "Lauf 2", "Lauf 3")
    assert inspect_file(write(SEVERAL["Shimadzu"][0])).samples == ("1 _ 1", "1 _ 2", "1 _ 3")


@pytest.mark.parametrize("order", ["alternating", "below each other"])
def test_a_long_table_of_channels_has_a_clock_for_each(write, order):
    (time_s, force_N), slow_s = PULLS[0], np.arange(0, 3, 0.05) + 0.003
    rows = [(t, "F_A", f) for t, f in zip(time_s, force_N, strict=True)]
    rows += [(t, "F_B", 20 + t) for t in slow_s]
    rows = sorted(rows) if order == "alternating" else rows
    text = "time_s,channel,value\n" + "".join(f"{t:.3f},{name},{value:.3f}\n" for t, name, value in rows)
    path = write(text)
    found = inspect_file(path).profile
    assert (found.format, found.channel_column, found.value_column) == ("long", "channel", "value")
    channels = {"time": Channel(column="time_s"), "force": Channel(column="F_A", unit="N")}
    channels["end_tension"] = Channel(column="F_B", unit="N")
    profile = replace(found, channels=channels)
    (trace,) = (assemble_trace(raw, profile) for raw in read_recordings(path, profile))
    assert (trace.force_N.size, np.nanmax(trace.force_N)) == (300, pytest.approx(PEAKS[0]))
    there = np.isfinite(trace.end_tension_N)
    np.testing.assert_allclose(trace.end_tension_N[there], 20 + trace.time_s[there], atol=0.006)


def test_a_channel_that_begins_megabytes_below_is_seen(write):
    note = "x" * 5000
    rows = [(i, name, 50 + i % 97) for name in ("F_A", "F_B") for i in range(500)]
    path = write(
        "time_s,channel,value,note\n" + "".join(f"{i / 100},{name},{f},{note}\n" for i, name, f in rows)
    )
    assert path.stat().st_size > 2 * 2**21
    found = inspect_file(path)
    assert (found.format, found.profile.channel_column, found.n_rows) == ("long", "channel", 500)


def test_a_layout_that_a_text_does_not_have_is_refused(write):
    long = write("specimen,t,F\na,0,1\nb,1,2\n")
    names = {"recording_column": "specimen", "format": "long"}
    channel = {"channel_column": "specimen", "value_column": "F", "format": "long"}
    for more, code, words in (
        ({"format": "stacked", "header_row": 0}, "RF103", "no header that comes again"),
        ({"format": "long"}, "RF105", "needs a column that names recordings"),
        (names | {"channel_column": "F"}, "RF105", "and one of their values"),
        (channel, "RF105", "no column is the time, with its unit"),
    ):
        error = refused(long, **more)
        assert error.code == code
        assert words in str(error)


def test_an_event_column_makes_no_recordings(write):
    time_s, force_N = PULLS[0]
    rows = [f"{t:.2f},{'rest' if t < 1 else 'run'},{f:.3f}" for t, f in zip(time_s, force_N, strict=True)]
    found, (trace,) = proposed(write("time_s,phase,force_N\n" + "\n".join(rows) + "\n"))
    assert (found.format, trace.time_s.size) == ("delimited", 300)


def test_sheets_of_a_workbook_are_recordings_where_they_are_alike(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.title = "Parameters"
    book.active.append(["Speed", 10])
    for number, (time_s, force_N) in enumerate(PULLS, start=1):
        sheet = book.create_sheet(f"Run {number}")
        for row in [["Time", "Force"], ["s", "N"], *zip(time_s.tolist(), force_N.tolist(), strict=True)]:
            sheet.append(row)
    book.save(path := tmp_path / "runs.xlsx")
    found, traces = proposed(path)
    assert found.samples == ("Run 1", "Run 2", "Run 3")
    assert tops(traces) == pytest.approx(PEAKS)


def test_groups_are_recordings_where_they_are_alike(tmp_path):
    tdms, h5py = pytest.importorskip("nptdms"), pytest.importorskip("h5py")
    start, path = np.datetime64("2026-03-01T10:00:00"), tmp_path / "runs.tdms"
    with tdms.TdmsWriter(path) as writer:
        for number, (time_s, force_N) in enumerate(PULLS, start=1):
            # Time stamps as a channel of their own.
            stamps = start + np.round(time_s * 1e6).astype("timedelta64[us]")
            columns = ("When", stamps, {}), ("Force", force_N, {"unit_string": "Newton"})
            writer.write_segment([tdms.ChannelObject(f"Run {number}", *column) for column in columns])
    found, traces = proposed(path)
    assert (found.samples, tops(traces)) == (("Run 1", "Run 2", "Run 3"), pytest.approx(PEAKS))
    assert traces[1].time_s[-1] == pytest.approx(PULLS[1][0][-1])
    with h5py.File(path := tmp_path / "runs.h5", "w") as file:
        for number, (time_s, force_N) in enumerate(PULLS, start=1):
            file[f"store/{number}/time"], file[f"store/{number}/force"] = time_s, force_N
            file[f"store/{number}/time"].attrs["unit"], file[f"store/{number}/force"].attrs["unit"] = "s", "N"
            file[f"runs/{number}"] = h5py.SoftLink(f"/store/{number}")
            file[f"store/{number}/up"] = h5py.SoftLink("/store")  # a circle
    profile = ImportProfile(table="runs")
    assert tops([assemble_trace(raw, profile) for raw in read_recordings(path, profile)]) == pytest.approx(
        PEAKS
    )


def test_recordings_are_called_what_their_columns_share_or_numbered_from_one():
    assert [block.sample for block in blocks_of_header(["t_s", "F_N"] * 3)] == ["1", "2", "3"]
    header = [f"Run {number}: {name}" for number in (1, 2) for name in ("Time (s)", "Force (N)")]
    assert blocks_of_header(header) == [(f"Run {number}", ("Time (s)", "Force (N)")) for number in (1, 2)]


# --- what inspect proposes ---


@pytest.mark.parametrize("n", [2, 300])
def test_of_columns_that_differ_by_their_zero_the_first_is_the_force(write, n):
    rows = "".join(f"{i},{3 * i},{3 * i + 5}\n" for i in range(n))
    found = inspect_file(write(f"time_s,a [N],b [N]\n{rows}"))
    assert found.profile.channels["force"].column == "a [N]"
    assert any("the first of those that differ by their zero" in doubt for doubt in found.doubts)


def test_two_signals_of_a_german_logger_are_proposed_with_what_is_missing(write):
    time_s, force_N = pull(120.0)
    rows = [
        f"{t:.2f};{f / 25:.4f};{f / 100 + 0.2:.4f}".replace(".", ",")
        for t, f in zip(time_s, force_N, strict=True)
    ]
    head = ["Messung 7", "Abtastrate;100 Hz", "", "Zeit [s];Zugkraft [mV];Gegenkraft [mV]"]
    found = inspect_file(write("\n".join([*head, *rows, "Ende der Messung;;", "Maximum;4,8;1,4"]) + "\n"))
    assert found.profile.channels == {
        "time": Channel(column="Zeit [s]"),
        "force": Channel(column="Zugkraft [mV]", unit="mV"),
        "end_tension": Channel(column="Gegenkraft [mV]", unit="mV"),
    }
    assert found.profile.skip_footer == 2
    assert "1 recording of 400 samples, 100 Hz, 0 to 4.8 mV" in found.read
    assert any('sensitivity = "25 N/mV"' in doubt for doubt in found.doubts)
    assert any("column 3 looks like a measured end tension" in doubt for doubt in found.doubts)


@pytest.mark.parametrize(
    ("scale", "form", "unit"), [(1.0, ".2f", "s"), (1e3, ".0f", "ms"), (1e6, ".0f", "us"), (1e3, ".1f", "ms")]
)
def test_a_time_without_a_unit_gets_the_one_that_makes_a_recording(write, scale, form, unit):
    time_s, force_N = pull(120.0)
    rows = "".join(f"{scale * t:{form}},{f:.3f}\n" for t, f in zip(time_s, force_N, strict=True))
    found, (trace,) = proposed(write(f"time,force_N\n{rows}"))
    assert trace.sampling_rate_Hz == pytest.approx(100)
    assert any(f"{unit} is taken, as that makes 100 Hz over 3.99 s" in doubt for doubt in found.doubts)


def test_a_counter_is_no_time(write):
    _, force_N = pull(120.0)
    found = inspect_file(write("Index,force_N\n" + "".join(f"{i},{f:.3f}\n" for i, f in enumerate(force_N))))
    assert "time" not in found.profile.channels
    assert "sampling rate" in found.stopped
    named = write(
        "# Sampling rate: 100 Hz\nIndex,force_N\n" + "".join(f"{i},{f:.3f}\n" for i, f in enumerate(force_N))
    )
    assert proposed(named)[1][0].sampling_rate_Hz == pytest.approx(100)


@pytest.mark.parametrize(
    "said", ["Sampling rate: 100 Hz", "Abtastrate;0,1 kHz", "dt = 10 ms", "Sample interval [ms];10"]
)
def test_a_rate_above_the_table_is_compared_with_its_time(write, said):
    time_s, force_N = pull(120.0)
    rows = "".join(f"{1e3 * t:.0f};{f:.3f}\n" for t, f in zip(time_s, force_N, strict=True))
    assert read(write(f"{said}\n\ntime_ms;force_N\n{rows}"))[0].sampling_rate_Hz == pytest.approx(100)
    path = write(f"{said}\n\ntime;force_N\n{rows}")
    channels = {"time": Channel(column="time", unit="s"), "force": Channel(column="force_N")}
    error = refused(path, channels=channels)
    assert (error.code, "0.1 Hz" in str(error), "the head of the file 100 Hz" in str(error)) == (
        "RF203",
        True,
        True,
    )
    assert read(path, channels=channels, sampling_rate_Hz=0.1)[0].sampling_rate_Hz == pytest.approx(0.1)


def test_a_sheet_may_hold_dates(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book, began = openpyxl.Workbook(), dt.datetime(2026, 3, 1, 23, 59, 59)  # noqa: DTZ001
    for row in [
        ["Datum", "Kraft [N]"],
        *((began + dt.timedelta(seconds=t), f) for t, f in zip(*pull(120.0), strict=True)),
    ]:
        book.active.append(list(row))
    book.save(path := tmp_path / "run.xlsx")
    _, (trace,) = proposed(path)
    assert trace.time_s[-1] == pytest.approx(3.99, abs=1e-3)
