"""One long work at a time, which says how far it is, can be stopped, and ends in words."""

import threading
import time

import pytest

from ropefric.errors import DataError, InputError
from ropefric.page.work import Work


def ended(work):
    while work.state()["running"]:
        time.sleep(0.005)
    return work.state()


def test_it_tells_how_far_it_is_and_what_came_of_it():
    work, go = Work(), threading.Event()

    def do(step):
        step(1, 3, "first")
        go.wait(20)
        return {"done": True}

    assert work.begin("reading", do)["work"]["running"]
    while work.state()["done"] < 1:
        time.sleep(0.005)
    with pytest.raises(InputError, match="reading has not finished yet"):
        work.begin("other", do)
    told = work.state()
    assert (told["done"], told["total"], told["item"]) == (1, 3, "first")
    go.set()
    assert ended(work)["result"] == {"done": True}


def test_it_is_stopped_at_its_next_step_and_another_may_begin():
    work, steps = Work(), []

    def endless(step):
        while True:
            step(len(steps), 0, "again")
            steps.append(1)
            time.sleep(0.001)

    work.begin("endless", endless)
    work.stop()
    assert "endless was stopped" in ended(work)["error"]["message"]
    work.begin("other", lambda _: 7)
    assert ended(work)["result"] == 7
    # Or another takes its place at once, and what becomes of the first is lost.
    work.begin("endless", endless)
    work.begin("third", lambda _: 8, instead=True)
    assert (ended(work)["name"], work.state()["result"]) == ("third", 8)


def test_what_goes_wrong_is_told_in_words():
    work = Work()

    def refuse(_):
        raise DataError("no file matches", code="RF101", fix="name another folder")

    work.begin("looking", refuse)
    found = {"code": "RF101", "message": "no file matches", "where": "", "fix": "name another folder"}
    assert ended(work)["error"] == found
    work.begin("looking", lambda _: 1 / 0)
    assert ended(work)["error"]["code"] == "RF000"
