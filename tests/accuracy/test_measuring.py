"""Timing with a clock of our own, the front, the cheapest, and what a study result holds."""

import gc
import itertools
import math

import numpy as np
import pytest

from ropefric.accuracy.measure import FULL, QUICK, Effort, Timing, measure_studies, this_machine, time_in_turn
from ropefric.accuracy.studies import STUDIES
from ropefric.accuracy.study import (
    ACCURACIES,
    Case,
    Counted,
    Measured,
    Outcome,
    Setting,
    Study,
    against,
    cheapest,
    largest_error,
    over_seeds,
    pareto_front,
)
from ropefric.errors import UnknownNameError


class Clock:
    """Time that passes only when something is called, by as much as the next of `durations`."""

    def __init__(self, durations):
        self.now_s, self.durations, self.calls = 0.0, iter(durations), 0

    def __call__(self):
        return self.now_s

    def work(self):
        self.calls += 1
        self.now_s += next(self.durations)


def timed(durations, batch_s, budget_s, *fewest_and_most):
    clock = Clock(durations)
    (found,) = time_in_turn([clock.work], Effort(batch_s, budget_s, *fewest_and_most), clock=clock)
    return found, clock.calls


def test_a_call_is_timed_by_the_least_of_batches_as_long_and_as_many_as_it_takes():
    short, _ = timed(itertools.repeat(1e-6), 5e-3, 0.1, 5, 25)
    assert short.loops == 8192  # the first power of two whose batch lasts 5 ms
    assert short.seconds == pytest.approx(1e-6, rel=1e-6)
    assert 5 <= short.repeats <= 25
    assert short.upper_s == pytest.approx(short.lower_s, rel=1e-6)
    # The first call does not count, and a slow one in between hardly.
    once, _ = timed(itertools.chain([100.0, 1.0, 1.0, 50.0], itertools.repeat(1.0)), 0.5, 9.0, 5, 25)
    assert once == Timing(1.0, 1.0, 1.0, 9, 1)
    # As often as must be where a call is long, no more than may where it is short.
    assert timed(itertools.repeat(0.1), 0.05, 1e3, 3, 7)[0].repeats == 7
    long, calls = timed(itertools.repeat(10.0), 0.05, 1.0, 3, 7)
    assert (long.repeats, calls) == (3, 4)
    # The spread is up to the upper quartile.
    found, _ = timed([0.0, 1.0, 2.0, 3.0, 4.0, 5.0], 0.5, 0.5, 5, 5)
    assert (found.lower_s, found.seconds, found.upper_s) == (1.0, 1.0, 4.0)


def test_what_is_slow_for_a_while_is_slow_for_all_that_are_timed_in_turn():
    """Two calls of 1 s and 1.01 s, on a machine that takes three times as long after its first four seconds."""
    clock = Clock(())

    def work(seconds):
        clock.now_s += seconds if clock.now_s < 5.0 else 3.0 * seconds

    calls = [lambda: work(1.0), lambda: work(1.01)]
    effort = Effort(batch_s=0.5, budget_s=5.0, fewest=5, most=5)
    found = time_in_turn(calls, effort, clock=clock)
    assert [one.seconds for one in found] == pytest.approx([1.0, 1.01])
    assert all(one.lower_s == one.seconds < one.upper_s for one in found)
    assert [one.repeats for one in found] == [5, 5]
    order, few = [], Effort(batch_s=0.0, budget_s=0.0, fewest=5, most=5)
    time_in_turn([lambda: order.append("a"), lambda: order.append("b")], few)
    assert "".join(order) == "aabb" + "ab" * 4


def test_the_garbage_collector_works_again_even_after_a_failure():
    with pytest.raises(ZeroDivisionError):
        time_in_turn([lambda: 1 / 0])
    assert gc.isenabled()


def test_the_machine_is_named_and_a_quick_look_is_quicker():
    assert QUICK.budget_s < FULL.budget_s
    assert QUICK.batch_s < FULL.batch_s
    machine = this_machine()
    assert machine.cpu
    assert machine.numpy == np.__version__
    assert machine.line.count(",") >= 3


def point(method, error, seconds):
    return Measured(case="c", method=method, setting="", error=error, seconds=seconds, lower_s=seconds,
                    upper_s=seconds, repeats=1, loops=1, evaluations=1)  # fmt: skip


def test_nothing_on_the_front_is_beaten_and_everything_off_it_is():
    rng = np.random.default_rng(3)
    points = [point(f"m{i}", *10.0 ** rng.uniform(-12, 0, 2)) for i in range(60)]
    front = pareto_front(points)

    def beaten(p):
        return any(q.error <= p.error and q.seconds <= p.seconds and q is not p for q in points)

    assert {p.method for p in points if not beaten(p)} == {p.method for p in front}
    for accuracy in ACCURACIES:
        best = cheapest(points, accuracy)
        assert best == cheapest(front, accuracy)


def test_below_rounding_errors_are_all_the_same_and_infinite_ones_are_no_answer():
    points = [point("a", 0.0, 2.0), point("b", 1e-17, 1.0), point("none", math.inf, 0.1)]
    assert [p.method for p in pareto_front(points)] == ["b"]
    assert cheapest(points, 1e-2).method == "b"
    assert points[2].to_dict()["error"] is None


def test_counting_leaves_the_timed_function_alone():
    (setting,) = against([2.0, 4.0], "m", "", lambda f: f(np.array([1.5, 2.0])), np.square)
    outcome = setting.assess()
    assert outcome.evaluations == 2
    assert outcome.error == pytest.approx(0.125)
    np.testing.assert_array_equal(setting.call(), [2.25, 4.0])
    counted = Counted(lambda **_keywords: None)
    counted(x=1)
    assert (counted.calls, counted.points) == (1, 1)


def test_an_answer_that_is_no_number_is_an_infinite_error():
    assert largest_error([np.inf], [1.0]) == math.inf
    assert over_seeds([0.1, np.nan], 1.0).error == math.inf
    assert over_seeds([-0.2], 1.0) == Outcome(error=0.2, evaluations=1.0, bias=-0.2, noise=0.0)


def made_study(calls):
    def setting(name, error, *, quick):
        return Setting(method=name, setting="", call=lambda: calls.append(name),
                       assess=lambda: Outcome(error=error, evaluations=7.0), quick=quick)  # fmt: skip

    case = Case(name="only", title="",
                settings=lambda: (setting("a", 1e-3, quick=True), setting("b", 1e-9, quick=False)))  # fmt: skip
    return Study(name="made", title="", question="", reference="", counted="", cases=(case,),
                 findings=lambda points: tuple(p.method for p in points))  # fmt: skip


def test_a_study_is_measured_case_by_case_and_quickly_only_in_part():
    calls, told = [], []
    effort = Effort(batch_s=1e-9, budget_s=1e-9, fewest=1, most=1)
    (result,) = measure_studies([made_study(calls)], effort=effort, progress=lambda *args: told.append(args))
    assert [(p.method, p.error, p.evaluations) for p in result.points] == [("a", 1e-3, 7.0), ("b", 1e-9, 7.0)]
    assert calls == ["a", "a", "b", "b"], "each is called once to warm up"
    assert told == [(1, 1, "made: only")]
    assert result.findings == ("a", "b")
    tree = result.to_dict()
    assert [row["method"] for row in tree["cheapest"]["only"]][1:8] == [
        result.cheapest("only")[i][1].method for i in range(1, 8)
    ]
    assert tree["cheapest"]["only"][-1]["method"] is None
    quick = measure_studies([made_study(calls)], quick=True, effort=effort)[0]
    assert [p.method for p in quick.points] == ["a"]
    assert quick.quick


LONG = {"picks": pytest.mark.release, "scenes": pytest.mark.slow}


@pytest.mark.parametrize("study",
                         [pytest.param(one, id=name, marks=LONG.get(name, ()))
                          for name, one in STUDIES.items()])  # fmt: skip
def test_every_study_keeps_the_contract(study):
    assert study.cases
    for text in (study.title, study.question, study.reference, study.counted):
        assert text
    assert study.question.endswith("?")
    for case in study.cases:
        settings = case.settings()
        names = [(setting.method, setting.setting) for setting in settings]
        assert len(set(names)) == len(names)
        assert len({setting.method for setting in settings if setting.quick}) >= 2, "quick compares nothing"
        # Every method takes part in the quick look, so that no finding depends on how long one waits.
        assert {s.method for s in settings} - {s.method for s in settings if s.quick} <= {"adaptive quad"}
        outcome = settings[0].assess()
        assert outcome.error >= 0.0
        assert repr(outcome) == repr(settings[0].assess()), "bias and noise may be NaN, which equals nothing"
        settings[0].call()


def test_unknown_names_are_answered_with_the_nearest():
    with pytest.raises(UnknownNameError, match="did you mean 'integral'"):
        STUDIES["integrale"]
    with pytest.raises(UnknownNameError, match="did you mean 'regular'"):
        STUDIES["integral"].case("regula")
    assert STUDIES["integral"].case().name == "regular"
