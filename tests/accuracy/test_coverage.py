"""The study of coverage: campaigns that are what they say, shares that count, findings that say what is not held."""

import numpy as np
import pytest

from ropefric.accuracy.studies import STUDIES, uncertainty
from ropefric.accuracy.studies.uncertainty import KINDS, Design, Intervals, coverage, with_all_designs
from ropefric.accuracy.study import Measured


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
    assert len(whole.cases) == 3 * 5 * 4 * 2 + 4
    assert len({case.name for case in whole.cases}) == len(whole.cases)
