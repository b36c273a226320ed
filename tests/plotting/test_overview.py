"""The matrix of a campaign: every trial, every check, and the numbers that go with it."""

import dataclasses

import numpy as np
import pytest

from ropefric.errors import Problem
from ropefric.plotting.campaign import CHECKS, FAIL, FLAG, NOT_JUDGED, OK, check_trial, draw_overview
from ropefric.traces.breakaway import Status
from ropefric.trials.result import Extraction

WORDS = {"ok", "flag", "fail", "not judged"}


def campaign(trials):
    return Extraction(name="made up", trials=tuple(trials), conditions=(), problems=())


def many(make_trial, n):
    trials = [make_trial(f"c{i:03d}", 320.0) for i in range(n)]
    for i in range(0, n, 7):
        trials[i] = make_trial(f"c{i:03d}", 320.0, list(Status)[1 + (i // 7) % 5])
    return trials


def test_each_status_fails_its_own_check_and_ends_the_judging(make_trial):
    failed = {}
    for status in list(Status)[1:]:
        levels = check_trial(make_trial("a", 320.0, status))
        place = levels.index(FAIL)
        failed[status] = list(CHECKS)[place]
        assert set(levels[place + 1 :]) <= {NOT_JUDGED}
        assert set(levels[:place]) <= {OK}
    assert len(set(failed.values())) == len(Status) - 1
    assert failed[Status.SATURATED] == "below the converter's ceiling"


def test_what_was_set_aside_or_warned_of_is_flagged(make_trial):
    trial = make_trial("a", 320.0)
    assert set(check_trial(trial)) == {OK}
    problem = Problem(code="RF000", message="doubtful", severity="warning")
    cases = {"not excluded by the user": {"excluded": "knot"},
        "not rejected by the rule": {"rejected_by": "two-sigma"}, "no warning": {"problems": (problem,)},
        "below the converter's ceiling": {"saturated_samples": 3}}  # fmt: skip
    for check, change in cases.items():
        levels = dict(zip(CHECKS, check_trial(dataclasses.replace(trial, **change)), strict=True))
        assert levels.pop(check) is FLAG
        assert set(levels.values()) == {OK}


def test_the_table_and_the_drawing_agree(extraction_of, trials, told, assert_readable):
    extraction = extraction_of(trials)
    made = told(draw_overview(extraction))
    assert_readable(made)
    rows = made.tables[0].rows
    assert [row[0] for row in rows] == [t.trial for t in trials]
    assert {word for row in rows for word in row[1:]} <= WORDS
    drawn = {}
    for collection in made.figure.axes[0].collections:
        if collection.get_label() in WORDS:
            for path in collection.get_paths():
                (x0, y0), (x1, y1) = path.vertices.min(axis=0), path.vertices.max(axis=0)
                for column in range(round(x0), round(x1)):
                    drawn[(column, round((y0 + y1) / 2))] = collection.get_label()
    assert drawn == {
        (column, place): word for column, row in enumerate(rows) for place, word in enumerate(row[1:])
    }
    assert "11 trials: 7 kept, 1 rejected, 1 excluded, 2 without a force" in made.figure.get_suptitle()
    for words in ("1 unreadable", "1 without a slip", "1 excluded by the user", "1 rejected by the rule"):
        assert words in made.alt

    looks = {c.get_label(): c for c in made.figure.axes[0].collections if c.get_label() in WORDS}
    grey = {label: float(c.get_facecolor()[0, :3] @ [0.299, 0.587, 0.114]) for label, c in looks.items()}
    assert grey["ok"] - grey["flag"] > 0.15
    assert grey["flag"] - grey["fail"] > 0.15
    assert looks["flag"].get_hatch()


@pytest.mark.slow
def test_many_trials_are_broken_into_bands(make_trial, assert_readable):
    for n, bands in ((1, 1), (41, 1), (400, 4)):
        made = draw_overview(campaign(many(make_trial, n)))
        assert (len(made.figure.axes), len(made.tables[0].rows)) == (bands, n)
        width_inch, height_inch = made.figure.get_size_inches()
        assert width_inch == 10.0
        assert height_inch < 14.0
        assert_readable(made)  # which draws it
        # Names keep their distance: a letter of 7 points is high.
        boxes = [label.get_window_extent() for label in made.figure.axes[0].get_xticklabels()]
        assert (np.diff([box.x0 for box in boxes]) > 7.0).all(), n
