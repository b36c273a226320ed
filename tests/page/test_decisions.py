"""Decisions stand beside the list, a line each; the last of a trial holds, and nothing is ever written anew."""

import csv
import os
from itertools import product
from threading import Thread

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ropefric.errors import DataError, InputError
from ropefric.files import disk
from ropefric.trials.campaign import check_campaign, load_campaign
from ropefric.trials.decisions import Decision, add_decisions, content_of, decision_of, read_decisions

HEAD = "trial,pick_s,peak_N,exclude,why,by,when,file"
PICK = Decision("c35-r01", pick_s=1.25, why="seen", by="A. Meier", when="2026-11-22T14:30:00+00:00")


def add(path, decision):
    return add_decisions(path, [decision], content_of(path))


def test_a_new_file_has_a_header_and_the_last_line_of_a_trial_holds_whole(campaign):
    path, lists = campaign / "decisions.csv", (campaign / "trials.csv").read_bytes()
    add(path, PICK)
    add(path, Decision("c35-r02", exclude='torn, "twice"', why="seen", by="B", file="traces/x.csv"))
    add(path, Decision("c35-r01", exclude="late", by="B"))
    assert path.read_text().splitlines() == [
        HEAD,
        "c35-r01,1.25,,,seen,A. Meier,2026-11-22T14:30:00+00:00,",
        'c35-r02,,,"torn, ""twice""",seen,B,,traces/x.csv',
        "c35-r01,,,late,,B,,",
    ]
    found, _, problems = read_decisions(path)
    assert (found["c35-r01"], problems) == (Decision("c35-r01", exclude="late", by="B", line=4), ())
    assert (campaign / "trials.csv").read_bytes() == lists


def test_it_holds_in_place_of_what_the_list_says_and_what_is_empty_takes_it_back(campaign):
    path, table = campaign / "decisions.csv", campaign / "trials.csv"
    head, *rows = [row for row in table.read_text().splitlines() if not row.startswith("#")]
    own = ",,61.25,0.5,by hand,C"  # of every trial
    table.write_text("\n".join([f"{head},pick_s,peak_N,peak_std_N,why,by", *(row + own for row in rows)]))

    def held(trial="c35-r01"):
        return next(one for one in load_campaign(campaign / "campaign.toml").trials if one.trial == trial)

    was = held()
    assert (was.peak_N, was.peak_std_N, was.by) == (61.25, 0.5, "C")
    add(path, PICK)
    assert (held().pick_s, held().peak_N, held().peak_std_N) == (1.25, None, None)
    assert (held().by, held().when) == (PICK.by, PICK.when)
    assert held("c35-r02").peak_N == 61.25
    add(path, Decision("c35-r01", by="A. Meier", when="later"))
    assert (held().decision, held().exclude, held().why, held().by) == ("", "", "", "")
    add(path, decision_of(was))
    assert (held().peak_N, held().peak_std_N, held().why) == (61.25, 0.5, "by hand")


def test_a_file_that_a_spreadsheet_saved_is_read_and_goes_on_if_it_begins_as_before(tmp_path):
    path = tmp_path / "decisions.csv"
    for mark, end in product(("", "\ufeff"), ("", "\r\n")):
        before = f"{mark}{HEAD}\r\na,1.25,,,seen,me,,{end}"
        path.write_text(before, encoding="utf-8", newline="")
        add(path, Decision("b", pick_s=1.5, why="zu spät, laut", by="me"))
        told, _, problems = read_decisions(path)
        assert not problems
        assert (told["a"].pick_s, told["b"].pick_s, told["b"].why) == (1.25, 1.5, "zu spät, laut")
        assert path.read_bytes().startswith(before.encode())
    path.write_text(
        "trial;pick_ms;peak_N;exclude;why;by;when;mine\na;1250,5;;;seen;me;;x\n", encoding="utf-8"
    )
    assert read_decisions(path)[0]["a"].pick_s == 1.2505
    with pytest.raises(InputError, match="does not begin as ropefric writes it"):
        add(path, PICK)


def test_what_two_write_at_once_is_all_there(tmp_path):
    path = tmp_path / "decisions.csv"
    before = add(path, PICK)

    def many(who):
        for i in range(40):  # each with what it read at the start
            add_decisions(path, [Decision(f"{who}{i}", exclude="torn", by=who)], before)

    both = [Thread(target=many, args=(who,)) for who in ("anna", "bert")]
    for one in both:
        one.start()
    for one in both:
        one.join()
    found, _, problems = read_decisions(path)
    assert not problems
    assert set(found) == {PICK.trial, *(f"{who}{i}" for who in ("anna", "bert") for i in range(40))}
    assert [one.name for one in tmp_path.iterdir()] == ["decisions.csv"]


def test_a_full_disk_leaves_it_as_it_was(tmp_path, monkeypatch):
    path = tmp_path / "decisions.csv"
    before, write = add(path, PICK), os.write
    monkeypatch.setattr(disk.os, "write", lambda where, content: write(where, content[:5]))
    with pytest.raises(DataError, match="no space left"):
        add(path, PICK)
    assert path.read_bytes() == before
    other = tmp_path / "elsewhere.csv"
    other.symlink_to(path)
    with pytest.raises(DataError, match="through links"):
        add(other, PICK)


BAD = [
    (f"{HEAD}\nc35-r01,soon,,,w,b,,\n", "RF102", 2, "pick_s"), (f"{HEAD}\nc35-r01,1\n", "RF103", 2, ""),
    ("trial,pick_s\n", "RF121", 1, "peak_N"), (f"{HEAD}\nc35-r01,1,2,,w,b,,\n", "RF111", 2, "peak_N"),
    (f"{HEAD}\nc35-r01,1,,,,b,,\n", "RF121", 2, "why"), (f"{HEAD}\nc35-r01,,-1,,w,b,,\n", "RF110", 2, "peak_N"),
    (f"{HEAD}\nc35-r01,1,,,w,b,,other.csv\n", "RF111", 2, "file"), ("", "RF101", None, ""),
]  # fmt: skip


def test_what_is_wrong_with_it_is_an_error_where_it_stands_and_an_unknown_trial_a_warning(campaign):
    path, toml = campaign / "decisions.csv", campaign / "campaign.toml"
    for text, code, line, key in BAD:
        path.write_text(text)
        (found,) = (one for one in check_campaign(toml) if one.severity == "error")
        assert (found.code, found.line, found.key) == (code, line, key), text
        assert found.path.endswith("decisions.csv")
        assert found.fix
    path.write_text(f"{HEAD}\nc99,1,,,w,b,,\n")
    (found,) = (one for one in load_campaign(toml).warnings if one.path.endswith("decisions.csv"))
    assert (found.code, found.line, "not used" in found.message) == ("RF120", 2, True)
    path.write_bytes(f"{HEAD}\nc35-r01,,,schr\xe4g,,b,,\n".encode("cp1252"))
    with pytest.raises(InputError, match="no UTF-8 text"):
        add(path, PICK)


@given(text=st.text(st.sampled_from("ab ,;\"'µ#=.-+@\n\t"), max_size=8))
def test_any_text_comes_back_and_no_spreadsheet_runs_it(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("any") / "decisions.csv"
    add(path, Decision(f"t{text.strip()}", exclude=text, by="me"))
    (told,) = read_decisions(path)[0].values()
    assert told.exclude.lstrip("'") == " ".join(text.split()).lstrip("'")
    (cells,) = csv.reader(path.read_text().splitlines()[1:])
    assert not any(cell.startswith(tuple("=+-@")) for cell in cells)
