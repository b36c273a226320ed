"""Trials into conditions: the grouping, what the rule keeps, and what is said about it."""

import math
from dataclasses import asdict, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ropefric.traces.breakaway import Breakaway, Status
from ropefric.trials.outliers import RULES
from ropefric.trials.result import TrialResult, summarise_conditions

# The paper's example: 15 values with mean 321.7 N and s 5.5 N; without the one outlier the mean is 320.7 N.
STEPS, LEFT_N2 = np.arange(14) - 6.5, 14 * 5.5**2 - (335.7 - 321.7) ** 2 - 14 * (320.7 - 321.7) ** 2
PAPER_N = [335.7, *(320.7 + STEPS * math.sqrt(LEFT_N2 / (STEPS**2).sum())).tolist()]


def trial(
    name, measured_N=math.nan, *, wheel_m=0.04, wrap_rad=math.pi, end_N=60.0, slack_under_N=None, **more
):
    """Return a trial; without a force it is no-peak, with `slack_under_N` the slack side was measured."""
    status = Status.NO_PEAK if math.isnan(measured_N) else Status.OK
    tight_N, slack_N = (measured_N, end_N) if slack_under_N is None else (slack_under_N, measured_N)
    fields = {"wheel_radius_m": wheel_m, "rope_radius_m": 0.0049, "wrap_angle_rad": wrap_rad}
    fields |= {"trial": name, "file": f"{name}.csv", "end_tension_N": slack_N, "peak_N": tight_N}
    fields |= {
        "measures_slack": slack_under_N is not None,
        "breakaway": Breakaway(status=status, peak_N=measured_N),
    }
    fields["kept"] = status is Status.OK and not more.get("excluded")
    return TrialResult(**(fields | more))


def series(values_N, **more):
    return [trial(f"t{place}", value_N, **more) for place, value_N in enumerate(values_N)]


def test_the_paper_s_series_loses_its_one_outlier_unless_the_rule_is_none():
    trials, (condition,), problems = summarise_conditions(series(PAPER_N), "two-sigma")
    assert (condition.rejected, (condition.n, condition.n_kept)) == (("t0",), (15, 14))
    assert (condition.mean_all_N, condition.std_all_N) == pytest.approx((321.7, 5.5))
    assert condition.mean_kept_N == condition.lift_force_N == pytest.approx(320.7)
    assert condition.std_kept_N == pytest.approx(np.std(PAPER_N[1:], ddof=1))
    assert [t.kept for t in trials] == [False] + [True] * 14
    assert ([t.rejected_by for t in trials], problems) == (["two-sigma"] + [""] * 14, ())
    said = "the ±2s rule rejected 1 of 15: in clean normal series s of what it keeps reads 9 % low on average"
    assert said in condition.notes
    trials, (condition,), _ = summarise_conditions(series(PAPER_N), "none")
    assert (condition.rejected, condition.n_kept, condition.rule) == ((), 15, "none")
    assert condition.mean_kept_N == condition.mean_all_N
    assert all(t.kept and not t.rejected_by for t in trials)
    with pytest.raises(LookupError, match="two-sgima") as caught:
        summarise_conditions(series(PAPER_N), "two-sgima")
    assert "two-sigma" in caught.value.fix
    assert summarise_conditions([], "two-sigma") == ((), (), ())


def test_a_coefficient_that_no_rope_has_is_told_whichever_unit_is_wrong():
    right = {"wrap_rad": 3.0 * math.pi, "end_N": 60.0}
    for wrong, mu in (({}, ""), ({"wrap_rad": math.radians(9.42)}, "6.8"), ({"wrap_rad": 540.0}, "0.0021"),
            ({"end_N": 6e-12}, "3.3")):  # fmt: skip
        _, _, problems = summarise_conditions(series([184.0] * 6, **(right | wrong)), "none")
        assert [(one.code, f"is {mu}, outside" in one.message) for one in problems] == [
            ("RF140", True)
        ] * bool(mu)


def test_unusable_and_excluded_trials_are_listed_but_not_counted():
    spoilt = trial("spoilt")
    excluded = trial("excluded", 999.0, excluded="rope jumped")
    trials, (condition,), _ = summarise_conditions([spoilt, *series(PAPER_N), excluded], "two-sigma")
    assert (condition.n_recorded, condition.n, condition.n_kept) == (17, 15, 14)
    assert (condition.trials[0], condition.trials[-1]) == ("spoilt", "excluded")
    assert condition.rejected == ("t0",)
    assert [t.trial for t in trials if not t.kept] == ["spoilt", "t0", "excluded"]
    assert (trials[0].rejected_by, trials[-1].rejected_by) == ("", "")


def test_a_condition_without_a_single_force_has_no_numbers():
    trials, (condition,), problems = summarise_conditions([trial("a"), trial("b")], "two-sigma")
    assert (condition.n_recorded, condition.n, condition.n_kept, condition.rejected) == (2, 0, 0, ())
    assert all(math.isnan(getattr(condition, name))
        for name in ("mean_all_N", "std_all_N", "mean_kept_N", "std_kept_N", "lift_force_N"))  # fmt: skip
    assert condition.end_tension_N == 60.0
    assert condition.to_dict()["mean_kept_N"] is None
    assert not any(t.kept for t in trials)
    assert all(problem.code == "RF310" for problem in problems)


def test_few_trials_are_told_with_their_condition():
    _, (condition,), problems = summarise_conditions([trial("a", 100.0)], "two-sigma")
    assert condition.mean_kept_N == 100.0
    assert math.isnan(condition.std_kept_N)
    assert [problem.code for problem in problems] == ["RF310"]
    for n in (2, 5, 6):
        _, (condition,), problems = summarise_conditions(series([100.0] * (n - 1) + [1e6]), "two-sigma")
        assert condition.rejected == ((f"t{n - 1}",) if n > 5 else ())
        told = [(problem.code, problem.severity, problem.message[:42]) for problem in problems]
        assert told == [("RF310", "warning", "R_w = 40 mm, wrap 180 deg, F_B = 60 N: n =")] * (n <= 5)


def test_conditions_are_what_differs_in_radius_wrap_or_tension():
    trials = [trial("a", 100.0), trial("b", 100.0, wheel_m=0.03), trial("c", 100.0, wrap_rad=2.0),
        trial("d", 100.0, end_N=61.0), trial("e", 100.0, rope_radius_m=0.005), trial("f", 100.0),
        trial("g", 100.0, wheel_m=0.03, cell="K2", rope_id="other")]  # fmt: skip
    marked, conditions, _ = summarise_conditions(trials, "none")
    assert [c.trials for c in conditions] == [("b", "g"), ("c",), ("a", "f"), ("d",), ("e",)]
    assert [t.trial for t in marked] == list("abcdefg")


def test_radii_that_differ_by_rounding_are_one_condition():
    """40 mm and 80 mm / 2 and 0.04 m need not be the same number to the last bit."""
    trials = [trial("a", 100.0, wheel_m=0.04, wrap_rad=math.radians(540)),
        trial("b", 100.0, wheel_m=0.04 * (1 + 2e-16), wrap_rad=1.5 * 2 * math.pi * (1 + 3e-16)),
        trial("c", 100.0, wheel_m=0.04 * (1 + 1e-5), wrap_rad=math.radians(540))]  # fmt: skip
    _, conditions, _ = summarise_conditions(trials, "none")
    assert [c.trials for c in conditions] == [("a", "b"), ("c",)]


def test_where_the_slack_side_is_measured_the_weight_makes_the_condition():
    heavy = [trial(f"h{i}", force_N, slack_under_N=200.0) for i, force_N in enumerate([50.0, 51.0])]
    light = [trial(f"l{i}", force_N, slack_under_N=100.0) for i, force_N in enumerate([25.0, 27.0])]
    _, conditions, problems = summarise_conditions([*heavy, *light], "two-sigma")
    assert [(c.lift_force_N, c.end_tension_N, c.mean_kept_N) for c in conditions] == [(100.0, 26.0, 26.0),
        (200.0, 50.5, 50.5)]  # fmt: skip
    assert "F_A = 100 N" in problems[0].message


FORCES_N = st.lists(st.floats(50, 500), min_size=1, max_size=25)


@given(FORCES_N, st.sampled_from(list(RULES)))
@settings(deadline=None, max_examples=20)
def test_the_summary_is_that_of_the_flags(values_N, rule):
    given_trials = series(values_N)
    trials, (condition,), _ = summarise_conditions(given_trials, rule)
    assert all(t.kept for t in given_trials), "inputs are not changed"
    kept_N = np.array([t.measured_N for t in trials if t.kept])
    # As text: numbers that are not there are NaN, which equals nothing.
    unchanged = [asdict(replace(t, kept=True, rejected_by="")) for t in trials]
    assert repr(unchanged) == repr([asdict(t) for t in given_trials])
    assert condition.rejected == tuple(t.trial for t in trials if not t.kept)
    assert {t.rejected_by for t in trials if not t.kept} <= {rule}
    assert (condition.n, condition.n_kept) == (len(values_N), kept_N.size)
    assert condition.mean_all_N == pytest.approx(np.mean(values_N), rel=1e-12)
    if kept_N.size:
        assert condition.mean_kept_N == pytest.approx(kept_N.mean(), rel=1e-12)
    if kept_N.size > 1:
        assert condition.std_kept_N == pytest.approx(kept_N.std(ddof=1), rel=1e-9, abs=1e-9)


@given(st.data())
@settings(deadline=None, max_examples=30)
def test_the_order_of_the_list_does_not_decide(data):
    trials = [*series(PAPER_N), *(replace(t, trial=f"w{t.trial}", wrap_angle_rad=1.0)
        for t in series(PAPER_N[::-1]))]  # fmt: skip
    shuffled = data.draw(st.permutations(trials))
    marked, conditions, _ = summarise_conditions(shuffled, "two-sigma")
    assert [t.trial for t in marked] == [t.trial for t in shuffled]
    assert {t.trial for t in marked if not t.kept} == {"t0", "wt14"}
    assert [c.wrap_angle_rad for c in conditions] == [1.0, math.pi]
    assert [c.mean_kept_N for c in conditions] == pytest.approx([np.mean(PAPER_N[1:])] * 2, rel=1e-12)
