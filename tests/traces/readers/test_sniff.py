"""What inspection finds out, and the profile it writes."""

import json
import tomllib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ropefric.traces.readers.inspection import inspect_file
from ropefric.traces.readers.profile import Channel, ImportProfile, profile_to_toml


def test_a_german_file_is_understood(write):
    rows = "".join(f"{i * 10};{i / 8:.3f}\n".replace(".", ",") for i in range(100))
    path = write("Prüfung\nZeit;Kraft;\nms;kN;\n".encode("cp1252") + rows.replace("\n", ";\n").encode())
    found = inspect_file(path, shown_as="run.csv")
    assert (found.encoding, found.separator, found.decimal) == ("cp1252", ";", ",")
    assert (found.header_row, found.units_row, found.data_row, found.n_rows) == (2, 3, 4, 100)
    assert [column.unit for column in found.columns[:2]] == ["ms", "kN"]
    assert (found.columns[1].maximum, found.first_rows[0][:2]) == (12.375, ("0", "0,000"))
    assert (found.sampling_rate_Hz, found.is_uniform) == (100, True)
    assert found.profile.channels["time"] == Channel(column="Zeit")
    assert found.profile.channels["force"] == Channel(column="Kraft")
    assert any("column 2 is taken as the force" in doubt for doubt in found.doubts)


def test_an_ambiguous_decimal_stays_open_in_the_profile(write):
    path = write("time_s;force_N\n0;1,234\n1;2,345\n")
    found = inspect_file(path)
    assert "1.234 or 1234" in found.doubts[0]
    assert found.profile.decimal == ""


def test_text_columns_and_a_bad_clock_are_shown(write):
    found = inspect_file(write("time_s,event,force_N\n0,go,1\n2,stop,2\n1,x,\n"))
    assert [column.is_numeric for column in found.columns] == [True, False, True]
    assert found.columns[2].n_missing == 1
    assert any("backwards" in doubt for doubt in found.doubts)


def test_a_profile_may_name_columns_without_their_units(write):
    path = write("t [ms],F [kN]\n" + "".join(f"{10 * i},{i}\n" for i in range(9)))
    known = ImportProfile(channels={"time": Channel(column="t"), "force": Channel(column="F")})
    found = inspect_file(path, known)
    assert (found.sampling_rate_Hz, found.doubts, found.stopped) == (100, (), "")


def test_whole_steps_without_a_name_are_a_time_but_a_count_is_neither_time_nor_force(write):
    found = inspect_file(write("".join(f"{5 * i} {i % 7}\n" for i in range(60))))
    assert found.profile.channels == {"time": Channel(column=1, unit="ms"), "force": Channel(column=2)}
    assert found.sampling_rate_Hz == 200
    found = inspect_file(write("".join(f"{i} {i % 7}\n" for i in range(60))))
    assert found.profile.channels == {"force": Channel(column=2)}
    assert any('or, if it is a time, time = { column = 1, unit = "ms" }' in doubt for doubt in found.doubts)


def test_days_of_a_spreadsheet_and_units_behind_every_number(write):
    found = inspect_file(write("Date,Load (N)\n" + "".join(f"{45000 + i / 86400},{i}\n" for i in range(60))))
    assert (found.profile.channels["time"].unit, found.stopped) == ("d", "")
    found = inspect_file(write("t;F\n" + "".join(f"{i / 10} s;{i % 7} N\n" for i in range(60))))
    assert found.read == "1 recording of 60 samples, 10 Hz, 0 to 6 N"


@pytest.mark.parametrize("blank", [" ", "\u00a0", "\u202f"])
def test_a_blank_between_thousands_is_any_blank(write, blank):
    path = write("time_s;force_N\n" + "".join(f"{i};{i}{blank}016.9\n" for i in range(1, 40)))
    found = inspect_file(path)
    assert found.doubts[0].endswith('[import] thousands = " "')
    assert (
        inspect_file(path, ImportProfile(thousands=" ")).read
        == "1 recording of 39 samples, 1 Hz, 1017 to 3.902e+04 N"
    )


def test_a_force_that_a_cell_is_to_make_newtons_of_is_read_in_its_own_unit(write):
    for unit, advice in (("mV/V", 'rated_output = "2 mV/V"'), ("mV", 'sensitivity = "25 N/mV"')):
        found = inspect_file(write(f"t_s,F [{unit}]\n" + "".join(f"{i},{i / 8}\n" for i in range(9))))
        assert found.read.endswith(f"0 to 1 {unit}; not yet in newtons: force"), found.stopped
        assert any(advice in doubt for doubt in found.doubts)


def test_the_inspection_is_json(write):
    found = inspect_file(write("t_s,F_N\n0,1\n1,2\n"), shown_as="run.csv").to_dict()
    again = json.loads(json.dumps(found))
    assert (again, (again["file"], again["schema"])) == (found, ("run.csv", "ropefric.inspection/1"))
    assert tomllib.loads(again["profile_toml"])["import"]["channels"] == {"time": "t_s", "force": "F_N"}


names = st.text(min_size=1, max_size=8).filter(lambda text: text.strip() and max(text) < "\ud800")
plain = st.text(max_size=8).filter(lambda text: not any("\ud800" <= c <= "\udfff" for c in text))


@settings(deadline=None, max_examples=30)
@given(st.builds(ImportProfile, format=st.sampled_from(["auto", "wide"]),
    separator=st.sampled_from(["", "\t", ";", " "]), decimal=st.sampled_from(["", ","]), encoding=plain,
    table=plain, header_row=st.integers(-1, 9), data_row=st.integers(0, 9),
    missing=st.lists(plain, max_size=3).map(tuple), sampling_rate_Hz=st.none() | st.floats(1e-3, 1e9),
    constants=st.dictionaries(names, st.floats(-1e9, 1e9), max_size=2),
    derived=st.dictionaries(names, plain, max_size=2),
    channels=st.dictionaries(names, st.builds(Channel, column=st.integers(1, 99) | names, unit=plain),
    max_size=3)))  # fmt: skip
def test_a_profile_survives_toml(profile):
    table = tomllib.loads(profile_to_toml(profile))["import"]
    for key in ("format", "separator", "decimal", "encoding", "table", "header_row", "data_row"):
        assert table.get(key, getattr(ImportProfile(), key)) == getattr(profile, key)
    assert tuple(table.get("missing", ())) == profile.missing
    assert (table.get("constants", {}), table.get("derived", {})) == (profile.constants, profile.derived)
    if profile.sampling_rate_Hz is not None:
        assert float(table["sampling_rate"].removesuffix(" Hz")) == profile.sampling_rate_Hz
    for name, channel in profile.channels.items():
        entry = table["channels"][name]
        entry = entry if isinstance(entry, dict) else {"column": entry}
        assert Channel(**entry) == channel
