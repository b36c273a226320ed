"""The study of coverage: campaigns that are what they say, shares that count, findings that say what is not held."""

import numpy as np
import pytest

from ropefric.accuracy.measure import this_machine
from ropefric.accuracy.studies import STUDIES, uncertainty
from ropefric.accuracy.studies.uncertainty import (
    EFFECTS,
    JUDGED_DESIGNS,
    KINDS,
    Design,
    Intervals,
    coverage,
    verdicts,
    with_all_designs,
)
from ropefric.accuracy.study import Measured, StudyResult
from ropefric.report.cost_page import cost_markdown


def test_campaigns_scatter_as_designed():
    """Of 60 campaigns without and with a gain error: scatter within, between and in common."""
    design, means, within = Design("constant", 12, 5, 0.03, "gain"), [], []
    for seed in range(60):
        table, _ = design.table(seed)
        off = (np.log(table.peak_N / table.end_tension_N) - 0.2 * table.wrap_angle_rad).reshape(12, 5)
        within.append(off.var(axis=1, ddof=1).mean())
        means.append(off.mean(axis=1))
    assert np.sqrt(np.mean(within)) == pytest.approx(uncertainty.WITHIN, rel=0.05)
    between = np.sqrt(np.var(means, axis=1, ddof=1).mean() - uncertainty.WITHIN**2 / 5)
    assert between == pytest.approx(0.03, rel=0.1)
    assert np.std(np.mean(means, axis=1)) == pytest.approx(
        np.hypot(uncertainty.GAIN, 0.03 / np.sqrt(12)), rel=0.3
    )


def test_shares_count_the_intervals_that_hold_the_truth():
    design = Design("constant", 6, 1)
    wide = coverage(design, lambda _: Intervals(np.array([[0.1, 0.3]]), np.array([0.0, 99.0])), 4)
    assert (wide.shares["parameters"], wide.shares["mean"], wide.shares["given"]) == (1.0, 1.0, 1.0)
    assert np.isnan(wide.shares["pull"])
    none = coverage(design, lambda _: Intervals(np.array([[0.3, 0.4]]), np.full(2, np.nan)), 4)
    assert (none.shares["parameters"], none.shares["given"], none.error) == (0.0, 0.0, 0.95)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_gives_an_interval_about_the_estimate(kind):
    fit, _ = uncertainty._campaign(Design("constant", 12, 3), 1)
    found = KINDS[kind](fit)
    low, high = found.parameters[0]
    assert low < fit["mu"].value < high
    assert 0.002 < high - low < 0.02


@pytest.mark.slow
def test_the_default_holds_the_mean_and_a_pull_in_93_to_97_of_100():
    """Of 300 campaigns: the limits, and two standard errors of a share."""
    room = 2 * np.sqrt(0.95 * 0.05 / 300)
    for design in (
        Design("constant", 8, 5),
        Design("coupled", 36, 5),
        Design("wrap-power", 12, 5, special="gain"),
    ):
        shares = coverage(design, KINDS["covariance"], 300).shares
        for name in ("mean", "pull"):
            assert 0.93 - room < shares[name] < 0.97 + room, (design.name, name)


def test_findings_say_what_is_covered_where_it_is_not_95_percent():
    def point(case, method, parameters, seconds):
        shares = {"parameters": parameters, "mean": 0.95, "pull": 0.95}
        return Measured(
            case=case, method=method, setting="", error=0.0, evaluations=200.0, shares=shares, seconds=seconds
        )

    points = (
        point("a", "auto", 0.95, 2.0), point("b", "auto", 0.81, 2.0),
        point("a", "profile", 0.95, 9.0), point("b", "profile", 0.96, 9.0),
    )  # fmt: skip
    assert STUDIES["uncertainty"].findings(points) == (
        "auto, the default, holds 93 to 97 % in 1 of 2 designs.",
        "b: parameters 81 %.",
        "Cheapest kind that holds 93 to 97 % everywhere, but for chance: profile.",
    )


def test_all_designs_are_every_law_size_repeats_and_scatter():
    whole = with_all_designs(STUDIES["uncertainty"])
    assert len(whole.cases) == 3 * 5 * 4 * 2 + 4 + 40
    assert len({case.name for case in whole.cases}) == len(whole.cases)


@pytest.mark.parametrize(
    ("effect", "setting", "change"),
    [
        ("no effect", "wrap_angle_rad", 1.0),
        ("wrap effect", "wrap_angle_rad", 0.8),
        ("size effect", "wheel_radius_m", 1.25),
        ("load dependence", "end_tension_N", 0.8),
    ],
)
def test_a_true_effect_is_as_large_as_stated_over_its_setting(effect, setting, change, monkeypatch):
    monkeypatch.setattr(uncertainty, "WITHIN", 0.0)
    table, _ = Design("constant", 36, 1, 0.0, effect).table(0)
    mu, level = np.log(table.peak_N / table.end_tension_N) / table.wrap_angle_rad, getattr(table, setting)
    assert mu[level == level.max()] == pytest.approx(0.2 * change)
    assert mu[level == level.min()] == pytest.approx(0.2)
    assert all(np.ptp(mu[np.isclose(level, one)]) < 1e-12 for one in level)


def test_campaigns_of_other_designs_are_others():
    first, more, even = (
        Design("constant", 8, *rest, special="no effect").table(0)[0] for rest in ((1,), (3,), (1, 0.0))
    )
    assert not np.isclose(first.peak_N, more.peak_N[::3], rtol=1e-3).any()
    assert not np.isclose(first.peak_N, even.peak_N, rtol=1e-4).all()


class Judged:
    """A comparison of which so much is supported."""

    def __init__(self, law, word, causes):
        self.causes = [type("Cause", (), {"cause": cause, "supported": "yes"}) for cause in causes]
        self.fit = type("Fit", (), {"friction_law": uncertainty.LAWS[law]})
        self.verdict = type("Verdict", (), {"supported": word == "supported"})


def judging(monkeypatch, *found):
    """Judge the campaigns like this, one after the other."""
    queue = iter(found)
    monkeypatch.setattr(uncertainty, "compare_laws", lambda _table: Judged(*next(queue)))
    monkeypatch.setattr(uncertainty, "choose_law", lambda ranked: ranked)
    monkeypatch.setattr(uncertainty, "diagnose", lambda _table, ranked: ranked)


def test_what_is_supported_is_counted(monkeypatch):
    judging(
        monkeypatch,
        ("constant", "supported", ["condition scatter"]),
        ("howell", "undecided", []),
        ("howell", "supported", ["size effect", "offset"]),
        ("thickness", "supported", ["wrap effect"]),
    )
    wrong = verdicts(Design("constant", 8, 3, special="no effect"), 4)
    assert (wrong.shares["law"], wrong.shares["effect"], wrong.error) == (0.5, 0.5, 0.5)
    judging(monkeypatch, ("howell", "supported", ["size effect"]), ("constant", "supported", ["offset"]))
    found = verdicts(Design("constant", 8, 3, special="size effect"), 2)
    assert (found.shares["law"], found.shares["effect"], found.error) == (0.5, 0.5, 0.5)


def test_a_share_has_its_binomial_interval(monkeypatch):
    """Of none in ten, Clopper and Pearson's is 0 to 1 - 0.025^(1/10); of 3 in 10, 6.67 to 65.25 %."""
    never, now = ("constant", "supported", []), ("howell", "supported", [])
    judging(monkeypatch, *10 * [never])
    none = verdicts(Design("constant", 8, 3, special="no effect"), 10)
    assert (none.shares["law_low"], none.shares["law_high"]) == (0.0, pytest.approx(1 - 0.025**0.1))
    judging(monkeypatch, *3 * [now], *7 * [never])
    three = verdicts(Design("constant", 8, 3, special="no effect"), 10)
    assert [three.shares[name] for name in ("law_low", "law_high")] == pytest.approx(
        [0.0667, 0.6525], abs=5e-5
    )
    judging(monkeypatch, *7 * [("constant", "supported", ["offset"])], *3 * [never])
    seven = verdicts(Design("constant", 8, 3, special="no effect"), 10).shares
    assert [seven[f"effect_{end}"] for end in ("low", "high")] == pytest.approx([0.3475, 0.9333], abs=5e-5)


def test_the_page_and_the_findings_show_verdicts_beside_intervals():
    shares = {"law": 0.02, "law_low": 0.005, "law_high": 0.05}
    few, many = (
        shares | {"effect": share, "effect_low": share - 0.01, "effect_high": share + 0.1}
        for share in (0.01, 0.8)
    )
    points = (
        Measured(case="a", method="auto", setting="", error=0.0, evaluations=200.0, seconds=1.0,
                 shares={"parameters": 0.95, "mean": 0.95, "pull": 0.95}),
        Measured(case="b, no effect", method="no effect", setting="", error=0.02, evaluations=200.0, shares=few),
        Measured(case="b, no effect", method="wrap effect", setting="", error=0.2, evaluations=200.0,
                 shares=many),
    )  # fmt: skip
    found = STUDIES["uncertainty"].findings(points)
    assert found[-2:] == (
        "b, no effect: a richer law is supported in 2 % (0 to 5 %) of 200 campaigns, an effect in 1 % (0 to 11 %).",
        (
            "b, wrap effect: a law with it is supported in 2 % (0 to 5 %) of 200 campaigns, "
            "the effect in 80 % (79 to 90 %)."
        ),
    )
    result = StudyResult(study=STUDIES["uncertainty"], points=points, quick=False)
    page = cost_markdown([result], this_machine())
    assert "| b, no effect | wrap effect | – | – | – | 2 |" in page


@pytest.mark.slow
@pytest.mark.parametrize("design", JUDGED_DESIGNS[1::14], ids=lambda one: one.name)
def test_constant_data_rarely_support_another_law(design):
    """Of 60 campaigns, at a true share of 5 %: 8 and more are seen once in 100 times."""
    found = verdicts(design, 60).shares
    assert found["law"] <= 7 / 60
    assert found["effect"] <= 7 / 60


@pytest.mark.hours
@pytest.mark.parametrize("design", JUDGED_DESIGNS, ids=lambda one: one.name)
def test_constant_data_support_another_law_in_a_twentieth_of_campaigns_at_most(design):
    """Of 1000 campaigns at each of the 40 designs: 5 % and two standard errors of that share."""
    found = verdicts(design, 1000).shares
    assert found["law"] <= 0.05 + 2.0 * np.sqrt(0.05 * 0.95 / 1000)


@pytest.mark.slow
def test_a_clear_effect_is_found_in_most_campaigns():
    """A fifth of μ over all wheels or loads, 12 conditions of 5: nearly always; over the wraps an offset may do too."""
    for effect, least in (("size effect", 0.9), ("load dependence", 0.9), ("wrap effect", 0.3)):
        assert verdicts(Design("constant", 12, 5, special=effect), 20).shares["effect"] >= least
    assert set(EFFECTS) == {"no effect", "wrap effect", "size effect", "load dependence"}
