"""A review decides, writes, computes anew; whatever goes wrong, the list is whole."""

import csv
import gzip
import io
import shutil
import threading
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ropefric.errors import DataError, InputError
from ropefric.page import review as session
from ropefric.page.review import decimated

BENCH = Path(__file__).parents[2] / "data" / "prth-bench"
DOUBTFUL = ("c28-r03", "c35-r02")


def rows_of(path):
    return {row["trial"]: row for row in csv.DictReader(io.StringIO(path.read_text()))}


def accept(review, trial):
    return review.decide(trial, "pick", pick_s=review.trial(trial)["candidates"][0]["time_s"])


def test_an_accepted_candidate_counts_and_everything_else_stays(begin, campaign):
    review, path = begin(), campaign / "trials.csv"
    before = path.read_bytes()
    for name, row in review.overview()["rows"].items():
        probability = review._state.trials[name].breakaway.probability
        assert row["probability"] == (probability if np.isfinite(probability) else None)
    changed = accept(review, "c28-r03")
    was, now = (changed["change"][key] for key in ("was", "is"))
    assert (was["outcome"], was["force_N"], now["outcome"]) == ("without a force", None, "kept")
    assert now["force_N"] == pytest.approx(79.12, abs=0.01)
    assert now["repeats"]["n_kept"] == was["repeats"]["n_kept"] + 1
    assert now["repeats"]["mean_N"] != was["repeats"]["mean_N"]
    assert set(changed["rows"]) == {"c28-r03"}
    assert path.read_bytes() == before
    head, row = (campaign / "decisions.csv").read_text().splitlines()
    assert head == "trial,pick_s,peak_N,exclude,why,by,when,file"
    said = "review: candidate 1 of 2 accepted,A. Meier,2026-11-22T14:30:00+00:00"
    assert row == f"c28-r03,2.19833,,,{said},{review._spec('c28-r03').file}"


def test_exclude_comment_take_back_and_undo(begin, campaign):
    review, path = begin(), campaign / "decisions.csv"

    def rows():
        return {
            name: {key: row[key] for key in row if key != "by"}
            for name, row in review.overview()["rows"].items()
        }

    before = [rows()]
    review.decide("c35-r01", "exclude", text="rope, torn")
    assert review.overview()["rows"]["c35-r01"]["excluded"] == "rope, torn"
    before.append(rows())
    review.decide("c35-r03", "comment", text="loud")
    assert review.overview()["rows"]["c35-r03"]["why"] == "loud"
    before.append(rows())
    accept(review, "c35-r02")
    before.append(rows())
    changed = review.decide("c35-r02", "clear")
    assert changed["rows"]["c35-r02"]["outcome"] == "without a force"
    for number, held in enumerate(reversed(before), 6):
        review.undo()
        assert rows() == held
        assert len(path.read_text().splitlines()) == number
    with pytest.raises(InputError, match="no decision can be undone"):
        review.undo()
    assert review.n_written == 0


def test_a_moved_pick_is_where_the_person_put_it(begin, campaign):
    review = begin()
    was = review.trial("c35-r01")["picked"]
    shown = review.preview("c35-r01", was[2] + 0.0123456789)["picked"]
    assert not (campaign / "decisions.csv").exists()
    changed = review.decide("c35-r01", "pick", pick_s=was[2] + 0.0123456789, text="the later one")
    row = changed["rows"]["c35-r01"]
    assert [row["force_N"], row["std_N"]] == pytest.approx(shown[:2], rel=1e-9)
    assert (row["why"], row["decision"]) == ("the later one", f"pick_s = {was[2] + 0.0123456789:.6g} s")
    # Where the force only rises there is no peak, and nothing is written.
    content = (campaign / "decisions.csv").read_bytes()
    with pytest.raises(DataError, match="no peak to measure") as refused:
        review.decide("c35-r01", "pick", pick_s=was[2] - 0.3)
    assert (refused.value.code, (campaign / "decisions.csv").read_bytes()) == ("RF244", content)


def test_where_somebody_else_changed_list_or_decisions_nothing_is_written(begin, campaign):
    review, path, made = begin(), campaign / "trials.csv", campaign / "decisions.csv"
    toml = campaign / "campaign.toml"
    theirs = path.read_bytes().replace(b"# taken in spring", b"# taken in autumn")
    path.write_bytes(theirs)
    for _ in range(2):
        with pytest.raises(DataError, match="somebody else") as refused:
            review.decide("c35-r01", "exclude", text="torn")
        assert (refused.value.code, path.read_bytes(), made.exists()) == ("RF153", theirs, False)
        assert review.overview()["rows"]["c35-r01"]["excluded"] == ""
        review.reload()
        toml.write_text(toml.read_text().replace('diameter = "9.8 mm"', 'diameter = "10.8 mm"'))
    review.reload()
    assert review.campaign.rope.radius_m == pytest.approx(5.4e-3)
    review.decide("c35-r01", "exclude", text="torn")
    other = begin()
    other.decide("c35-r03", "exclude", text="loud")
    content = made.read_bytes()
    for again in (review.undo, lambda: review.decide("c35-r01", "clear")):
        with pytest.raises(DataError, match="somebody else"):
            again()
    assert (path.read_bytes(), made.read_bytes()) == (theirs, content)
    review.reload()
    assert review.overview()["rows"]["c35-r03"]["excluded"] == "loud"


def test_only_what_changed_is_extracted_again(begin, campaign, monkeypatch):
    review, path = begin(), campaign / "trials.csv"
    extract, asked = session.extract_rows, []

    def extract_rows(campaign, **options):
        asked.append([row.trial for row in campaign.trials])
        return extract(campaign, **options)

    monkeypatch.setattr(session, "extract_rows", extract_rows)
    path.write_bytes(path.read_bytes().replace(b"W30,900,60", b"W30,900,61"))
    review.reload()
    review.decide("c35-r01", "exclude", text="torn")
    review.undo()
    assert asked == [[f"c11-r0{i}" for i in range(1, 5)], ["c35-r01"], ["c35-r01"]]


def test_recordings_that_changed_on_the_disk_are_read_again(begin, campaign, monkeypatch):
    toml, folder = campaign / "campaign.toml", campaign / "own"
    shutil.copytree(BENCH / "traces", folder / "traces")
    toml.write_text(toml.read_text().replace(f'data = "{BENCH.as_posix()}"', 'data = "own"'))
    review = begin()
    paths = [review._spec(f"c35-r0{i}").path for i in (1, 3, 4)]
    force_N = review.overview()["rows"]["c35-r03"]["force_N"]
    extract, asked = session.extract_rows, []

    def extract_rows(campaign, *, trusted=False, **options):
        asked.append((sorted(row.trial for row in campaign.trials), trusted))
        return extract(campaign, trusted=trusted, **options)

    monkeypatch.setattr(session, "extract_rows", extract_rows)
    paths[0].unlink()
    for look in (review.preview, lambda trial, time_s: review.curve(trial, time_s, np.nan, 100)):
        with pytest.raises(DataError, match="no such file") as refused:
            look("c35-r01", 2.0)
        assert "another place" not in refused.value.fix
    asked.clear()
    shutil.copy(paths[2], paths[1])
    review.reload()
    rows = review.overview()["rows"]
    assert (rows["c35-r01"]["status"], rows["c35-r03"]["force_N"] == force_N) == ("unreadable", False)
    # Nobody has read them as they are now, so another process does.
    assert asked == [(["c35-r01", "c35-r03"], False)]
    shutil.copy(paths[2], paths[0])
    review.reload()
    assert review.overview()["rows"]["c35-r01"]["force_N"] == rows["c35-r04"]["force_N"]


@pytest.mark.parametrize("what", ["disk", "campaign"])
def test_a_decision_that_cannot_be_kept_leaves_the_list_as_it_was(begin, campaign, monkeypatch, what):
    review, path = begin(), campaign / "decisions.csv"
    review.decide("c35-r01", "exclude", text="torn")
    before, overview = path.read_bytes(), review.overview()["rows"]
    if what == "disk":

        def refuse(*_, **__):
            raise DataError("cannot be written: no space left on device", code="RF105")

        monkeypatch.setattr(session, "add_decisions", refuse)
    else:  # as a list would that somebody changes at this very moment

        def refuse(*_, **__):
            raise DataError("one decision cannot stand for several trials", code="RF111")

        monkeypatch.setattr(session, "load_campaign", refuse)
    with pytest.raises(DataError, match=r"no space|several trials"):
        accept(review, "c28-r03")
    assert (path.read_bytes(), review.overview()["rows"]) == (before, overview)


def test_decisions_that_say_nothing_are_refused(begin, campaign):
    review, before = begin(), sorted(path.name for path in campaign.iterdir())
    for action, options, why in (("exclude", {"text": " "}, "needs its reason"), ("comment", {}, "empty"),
        ("pick", {}, "no time"), ("pick", {"pick_s": float("nan")}, "no time"),
        ("clear", {}, "changes nothing"), ("delete", {}, "no action")):  # fmt: skip
        with pytest.raises(InputError, match=why):
            review.decide("c35-r01", action, **options)
    with pytest.raises(InputError, match="no trial"):
        review.decide("c99", "clear")
    assert sorted(path.name for path in campaign.iterdir()) == before


def test_a_list_in_a_workbook_or_packed_is_only_read(begin, campaign):
    path, toml = campaign / "trials.csv", campaign / "campaign.toml"
    (campaign / "trials.gz").write_bytes(gzip.compress(path.read_bytes()))
    book = pytest.importorskip("openpyxl").Workbook()
    for line in path.read_text().splitlines():
        book.active.append(line.split(","))
    book.save(campaign / "trials.xlsx")
    text = toml.read_text()
    for name in ("trials.gz", "trials.xlsx"):
        toml.write_text(text.replace('"trials.csv"', f'"{name}"'))
        before = (campaign / name).read_bytes()
        row = begin().decide("c35-r01", "exclude", text=f"torn in {name}")["rows"]["c35-r01"]
        assert (row["excluded"], (campaign / name).read_bytes()) == (f"torn in {name}", before)


@pytest.mark.slow  # a process is started for what may be of harm to this one
def test_a_recording_that_is_not_there_is_told_and_can_be_excluded(begin, campaign):
    path = campaign / "trials.csv"
    path.write_bytes(path.read_bytes() + b"lost,traces/lost.csv.gz,W30,180,60,K1,,,\n")
    review = begin()
    assert review.overview()["rows"]["lost"]["status"] == "unreadable"
    with pytest.raises(DataError, match="no such file"):
        review.curve("lost", np.nan, np.nan, 100)
    assert review.decide("lost", "exclude", text="never recorded")["rows"]["lost"]["outcome"] == "excluded"


def test_a_curve_of_the_whole_and_of_a_stretch(begin):
    review = begin()
    whole = review.curve("c35-r01", np.nan, np.nan, 300)
    peak = review.trial("c35-r01")
    at_s = peak["picked"][2]
    near = review.curve("c35-r01", at_s - 0.05, at_s + 0.05, 1000)
    assert max(whole["high_N"]) == pytest.approx(max(near["high_N"]), rel=1e-6)
    assert len(whole["time_s"]) <= 300 < len(near["time_s"]) + 100
    smoothed = np.interp(at_s, near["time_s"], near["smoothed_N"])
    assert smoothed == pytest.approx(peak["picked"][0], rel=1e-3)


def test_where_the_break_away_may_be_comes_with_the_curve_and_is_asked_once(begin, undecided):
    review = begin()
    whole = review.curve("c35-r01", np.nan, np.nan, 300)
    assert whole["places"] == [[2.1, 2.2, 0.61], [1.5, 1.5, 0.3]]
    assert whole["reasons"] == [["no-breakaway", 0.09], ["no-peak", 0.0]]
    assert review.curve("c35-r01", 1.0, 2.0, 300)["places"] == whole["places"]
    assert len(undecided) == 1
    review.curve("c11-r01", np.nan, np.nan, 300)
    assert len(undecided) == 2


def test_the_picker_sees_the_part_that_is_looked_at(begin, campaign, undecided):
    path = campaign / "trials.csv"
    cells = {"trial": ",from_s", "c35-r01": ",0.5"}
    rows = [row + cells.get(row.split(",")[0], ",") for row in path.read_text().splitlines()[1:]]
    path.write_text("\n".join([*rows, ""]))
    begin().curve("c35-r01", np.nan, np.nan, 300)
    assert undecided == [pytest.approx(0.5, abs=1e-3)]


@pytest.mark.parametrize("protocol", ['picker = "highest"', 'ending = "separation"'])
def test_without_probabilities_there_is_nothing_to_show(begin, campaign, undecided, protocol):
    toml = campaign / "campaign.toml"
    toml.write_text(toml.read_text().replace('name = "breakaway"', f'name = "breakaway"\n{protocol}'))
    curve = begin().curve("c35-r01", np.nan, np.nan, 300)
    assert (curve["places"], curve["reasons"], undecided) == ([], [], [])


@settings(max_examples=20)
@given(data=st.data(), n=st.integers(1, 300), columns=st.integers(10, 60))
def test_decimation_keeps_every_extreme(data, n, columns):
    random = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    time_s = np.cumsum(random.exponential(size=n) + 1e-3)
    force_N = random.normal(size=n) * 10.0 ** random.integers(-3, 4)
    start_s, stop_s = sorted(random.uniform(time_s[0], time_s[-1] + 1.0, 2))
    if data.draw(st.booleans()):
        start_s = stop_s = np.nan
    shown = decimated((time_s, force_N, force_N), start_s, stop_s, columns)
    inside = (time_s >= shown["start_s"]) & (time_s <= shown["stop_s"])
    assert len(shown["time_s"]) <= 2 * columns + 2
    assert (np.diff(shown["time_s"]) > 0).all()
    if inside.any():
        low, high = force_N[inside].min(), force_N[inside].max()
        assert min(shown["low_N"]) <= low + 1e-7 * abs(low)
        assert max(shown["high_N"]) >= high - 1e-7 * abs(high)
        # And the highest is drawn where it was.
        width_s = (shown["stop_s"] - shown["start_s"]) / columns
        of_shown = shown["time_s"][int(np.argmax(shown["high_N"]))]
        top = np.argmax(np.where(inside, force_N, -np.inf))
        assert max(shown["high_N"]) > high * (1 + 1e-7) or abs(of_shown - time_s[top]) <= width_s


def test_nobody_who_looks_waits_while_a_decision_is_measured(begin, monkeypatch):
    review = begin()
    extract, measuring, go_on = session.extract_rows, threading.Event(), threading.Event()

    def extract_rows(campaign, **options):
        measuring.set()
        assert go_on.wait(60)
        return extract(campaign, **options)

    monkeypatch.setattr(session, "extract_rows", extract_rows)
    done = threading.Thread(target=review.decide, args=("c35-r01", "exclude"), kwargs={"text": "torn"})
    done.start()
    assert measuring.wait(60)
    seen, looks = [], (review.overview, review.answer, lambda: review.trial("c35-r01"))
    looking = threading.Thread(target=lambda: seen.extend(look() for look in looks))
    looking.start()
    looking.join(60)
    assert len(seen) == 3
    assert seen[0]["rows"]["c35-r01"]["excluded"] == ""
    go_on.set()
    done.join(60)
    assert review.overview()["rows"]["c35-r01"]["excluded"] == "torn"
