"""Any dialect comes back exactly or is refused; any bytes are in tests/fuzz."""

import gzip

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from ropefric.arrays import FloatArray
from ropefric.errors import DataError
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.inspection import inspect_file
from ropefric.traces.readers.profile import Channel, ImportProfile

CHANNELS = {"time": Channel(column=1, unit="s"), "force": Channel(column=2, unit="N")}
HEADS = {"none": [], "names": [["time", "force"]], "units in names": [["time (s)", "force [N]"]],
    "units row": [["time", "force"], ["s", "N"]], "preamble": [["Prüfstand 7"], [], ["time_s", "force_N"]]
}  # fmt: skip


def to_bytes(rows, head, separator, decimal, *, eol, encoding, is_packed, ends_in_eol):
    lines = [separator.join(cells) for cells in HEADS[head]]
    lines += [separator.join(cell.replace(".", decimal) for cell in row) for row in rows]
    text = eol.join(lines) + (eol if ends_in_eol else "")
    data = text.encode(encoding)
    return gzip.compress(data, mtime=0) if is_packed else data


finite = st.floats(-1e6, 1e6, allow_nan=False).map(lambda x: x + 0.0)
cells = st.one_of(st.integers(-99999, 99999).map(str), finite.map(repr), finite.map(lambda x: f"{x:.3f}"),
    finite.map(lambda x: f"{x:.2e}"))  # fmt: skip


@settings(deadline=None, max_examples=50)
@given(
    rows=st.lists(st.tuples(cells, cells), min_size=1, max_size=30),
    head=st.sampled_from(sorted(HEADS)),
    marks=st.sampled_from([",.", ";.", ";,", "\t.", "\t,", " .", " ,", "|,"]).map(tuple),
    form=st.fixed_dictionaries(
        {
            "eol": st.sampled_from(["\n", "\r\n", "\r"]),
            "encoding": st.sampled_from(["utf-8", "utf-8-sig", "cp1252", "utf-16"]),
            "is_packed": st.booleans(),
            "ends_in_eol": st.booleans(),
        }
    ),
    told=st.booleans(),
)  # fmt: skip
def test_any_dialect_comes_back_exactly_or_is_refused(tmp_path_factory, *, rows, head, marks, form, told):
    separator, decimal = marks
    assume(separator != " " or head != "units in names")  # blanks in names would make more names
    path = tmp_path_factory.getbasetemp() / f"dialect.csv{'.gz' if form['is_packed'] else ''}"
    path.write_bytes(to_bytes(rows, head, separator, decimal, **form))
    profile = ImportProfile(channels=CHANNELS)
    if told:
        profile = ImportProfile(channels=CHANNELS, separator=separator, decimal=decimal)
    try:
        (found,) = read_recordings(path, profile)
    except DataError as error:
        # What is told needs no guess. Untold, only "1,234" is ambiguous.
        code = error.code
    else:
        code = ""
    if code:
        assert (code, decimal, told) == ("RF104", ",", False)
        return
    if not form["ends_in_eol"] and len(rows) > 1 and len(rows[-1][1]) < len(rows[-2][1]):
        rows = rows[:-1]  # its last number may have been cut
    for i, channel in enumerate(("time", "force")):
        np.testing.assert_array_equal(found.columns[channel], [float(row[i]) for row in rows])
    inspection = inspect_file(path)
    assert inspection.n_rows == len(rows)


ODD_CELLS = [" 5 ", "", "nan", "inf", "1e999", "1_0", "0x1", "1.5.2", "+.5", "5.", "-", "e5", "NA", "x",
    "1,5"]  # fmt: skip


@settings(deadline=None)
@given(
    st.lists(
        st.one_of(st.sampled_from(ODD_CELLS),
                  st.text(alphabet="0123456789.,eE+- nax", max_size=6), cells),
        min_size=1, max_size=8,
    ),
    st.sampled_from([".", ","]),
)  # fmt: skip
def test_the_fast_way_agrees_with_the_slow_one(tmp_path_factory, texts, decimal):
    path = tmp_path_factory.getbasetemp() / "cells.csv"
    path.write_text("".join(f"{i};{text}\n" for i, text in enumerate(texts)))
    profile = ImportProfile(separator=";", decimal=decimal, header_row=0, channels=CHANNELS)
    expected = slow_answer(texts, decimal)
    if expected is None:
        with pytest.raises(DataError) as caught:
            read_recordings(path, profile)
        assert caught.value.code == "RF102"
        assert caught.value.problem.line == 1 + next(
            i for i, text in enumerate(texts) if slow_answer([text], decimal) is None
        )
    else:
        np.testing.assert_array_equal(read_recordings(path, profile)[0].columns["force"], expected)


def slow_answer(texts, decimal) -> FloatArray | None:
    """What Python makes of the cells, written here once more without a look at the reader."""
    values = []
    for text in texts:
        cell = text.strip()
        if cell in ("", "nan", "NaN", "NAN", "Nan", "-nan", "-NaN"):
            values.append(np.nan)
            continue
        other = "," if decimal == "." else "."
        try:
            value = float(cell.replace(decimal, "."))
        except ValueError:
            return None
        if other in cell or "_" in cell or not np.isfinite(value):
            return None
        values.append(value)
    return np.array(values)
