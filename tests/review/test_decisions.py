"""A decision changes its own cells of the trial list; every other byte stays."""

import codecs
import csv
import io
from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ropefric.errors import InputError
from ropefric.review.session import with_decision
from ropefric.trials.cells import read_cells

PICK = {"pick_s": 1.25, "why": "seen", "by": "A. Meier", "when": "2026-11-22T14:30:00+00:00", "exclude": ""}


def test_a_german_list_keeps_everything_but_three_cells():
    before = ("# Prüfstand 3; Seil ø 9,8\r\nfile;end_tension_N; Bemerkung ;pick_s;why;by;when\r\n"
        ";;;;;;\r\na.csv; 60,5;schräg ;;;;\r\nb.csv;60; ;;;;\r\n\r\n").encode("cp1252")  # fmt: skip
    after = with_decision(before, 4, PICK | {"why": "größter Wert"})
    row = "a.csv; 60,5;schräg ;1,25;größter Wert;A. Meier;2026-11-22T14:30:00+00:00\r\n".encode("cp1252")
    assert after == before.replace("a.csv; 60,5;schräg ;;;;\r\n".encode("cp1252"), row)


def test_columns_that_are_missing_come_last_and_comments_stay():
    before = b"file,wrap_angle_deg\n# a, remark\na.csv,180\n\nb.csv,90"
    after = with_decision(before, 5, PICK)
    assert after == (b"file,wrap_angle_deg,pick_s,why,by,when\n# a, remark\na.csv,180,,,,\n\n"
        b"b.csv,90,1.25,seen,A. Meier,2026-11-22T14:30:00+00:00")  # fmt: skip


def test_byte_order_mark_encoding_and_line_ends_stay():
    codecs_of = {codecs.BOM_UTF8: "utf-8", codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
    for (mark, codec), end in product(codecs_of.items(), ("\n", "\r\n", "\r")):
        lines = ["file\tnote\texclude", "a.csv\tµ\t", "b.csv\t\u2028x\t"]
        before = mark + (end.join(lines) + end).encode(codec)
        lines[2] += "schräg"
        assert with_decision(before, 3, {"exclude": "schräg"}) == mark + (end.join(lines) + end).encode(codec)


def test_a_time_is_written_in_the_unit_of_its_column():
    before = b"file,pick_ms,why,by,when\na.csv,,,,\n"
    assert b"a.csv,1250,seen," in with_decision(before, 2, PICK)


def test_an_empty_value_empties_a_cell_and_adds_no_column():
    before = b'file,"why",by\na.csv,"an ""old"" one",me\n'
    assert with_decision(before, 2, dict.fromkeys(("why", "by", "when", "exclude"), "")) == (
        b'file,"why",by\na.csv,,\n'
    )


def test_what_is_in_the_cell_already_is_not_written_anew():
    before = b'file,"exclude"\n"a.csv", "torn, by hand"\n'
    assert with_decision(before, 2, {"exclude": "torn, by hand"}) == before


def test_any_text_comes_back_as_it_was(tmp_path):
    path = tmp_path / "list.csv"
    for text in ("torn, twice", 'a "slip"', "two\nlines", "=1+1", "-5", "'quoted'"):
        path.write_bytes(with_decision(b"file,exclude\na.csv,\n", 2, {"exclude": text}))
        table, problems = read_cells(path)
        told = table.rows[0][1][1]
        assert not problems
        assert told.removeprefix("'") == text.replace("\n", " ").removeprefix("'")
        assert not told.startswith(("=", "-"))  # no spreadsheet runs it


def test_a_letter_that_the_encoding_lacks_is_refused():
    with pytest.raises(InputError, match="cp1252, which has no 'φ'") as refused:
        with_decision("file,exclude,note\na.csv,,schräg\n".encode("cp1252"), 2, {"exclude": "φ too small"})
    assert "UTF-8" in refused.value.fix


def test_forces_of_the_users_own_do_not_become_decisions():
    before = b"file,peak_N\na.csv,61.2\n"
    with pytest.raises(InputError, match="'peak_N' would be decisions too"):
        with_decision(before, 2, PICK)
    assert with_decision(before, 2, {"exclude": "torn"}) == b"file,peak_N,exclude\na.csv,61.2,torn\n"
    # Nor are they taken away with a decision that was none.
    assert with_decision(before, 2, {"peak_N": "", "why": ""}) == before


CELLS = st.text(st.sampled_from("ab ,;\"'µ#=."), max_size=6)


@settings(max_examples=40)
@given(data=st.data(), separator=st.sampled_from(",;\t"), end=st.sampled_from(["\n", "\r\n"]))
def test_whatever_stands_in_other_cells_stays(tmp_path_factory, data, separator, end):
    n = data.draw(st.integers(1, 4))
    rows = [[f"f{i}.csv", *data.draw(st.lists(CELLS, min_size=2, max_size=2))] for i in range(n)]
    stream = io.StringIO()
    writer = csv.writer(stream, delimiter=separator, lineterminator=end)
    writer.writerows([["file", "own", "exclude"], *rows])
    before = stream.getvalue().encode()
    line = data.draw(st.integers(2, n + 1))
    text = data.draw(CELLS)
    after = with_decision(before, line, {"exclude": text})
    lines = [one.split(end.encode()) for one in (before, after)]
    assert [place for place, pair in enumerate(zip(*lines, strict=True), 1) if pair[0] != pair[1]] in ([],
        [line])  # fmt: skip
    path = tmp_path_factory.getbasetemp() / "list.csv"
    path.write_bytes(after)
    told = dict(read_cells(path)[0].rows)[line]
    assert told[:2] == (rows[line - 2][0], rows[line - 2][1].strip())
    assert told[2].removeprefix("'") == " ".join(text.split()).removeprefix("'")
