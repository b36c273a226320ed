"""Studies of chance with fixed seeds: n^(-1/2), biases of the window, and what the covariance cannot see."""

import numpy as np
import pytest

from ropefric.accuracy.measure import error_table
from ropefric.accuracy.studies import STUDIES


def test_draws_err_with_one_over_the_root_of_the_number_where_the_law_is_linear(errors):
    found = errors("interval", "linear", "monte carlo")
    counts = np.array(sorted(found))
    slope, _ = np.polyfit(np.log(counts), np.log([found[n] for n in counts]), 1)
    assert slope == pytest.approx(-0.5, abs=0.1)


def test_draws_from_a_covariance_end_at_its_own_error_where_the_law_bends():
    covariance, profile, last = (error_table("interval", "curved", method=method)[-1].error
                                 for method in ("covariance", "profile", "monte carlo"))  # fmt: skip
    # The root mean square of both arms against the larger of the two.
    assert 0.5 * covariance < last < 1.1 * covariance
    assert profile < 1e-5 < covariance


def test_covariance_is_exact_where_the_law_is_linear():
    for method, bound in (("covariance", 1e-13), ("profile", 1e-6)):
        (row,) = error_table("interval", "linear", method=method)
        assert row.error < bound


@pytest.mark.slow
def test_the_profile_misses_the_truth_equally_often_on_both_sides_and_the_covariance_does_not():
    rows = {row.name: row for row in error_table("interval", "coverage")}
    tails = {name: (row.shares["too_low"], row.shares["too_high"]) for name, row in rows.items()}
    assert tails["profile"] == pytest.approx((0.025, 0.025))
    low, high = tails["covariance"]
    assert low > 0.025 > high, "the upper arm of this law is the longer one"
    assert rows["covariance"].error == pytest.approx(max(low - 0.025, 0.025 - high))
    assert tails["monte carlo, n = 10000"] == pytest.approx((low, high), abs=0.011)
    assert rows["profile"].error == 1 / 200
    (said,) = STUDIES["interval"].findings(tuple(rows.values()))
    assert "95.0% (2.5% too low, 2.5% too high) by profile" in said


@pytest.mark.slow
def test_the_window_trades_bias_for_noise_and_the_chosen_one_is_about_as_good_as_the_best():
    """First order: −rate (w − step)/2, so 301 samples cost 300/120 of what 121 cost."""
    best = {}
    for case in STUDIES["peak"].cases:
        found = {(s.method, s.setting): s.assess() for s in case.settings()}
        window = {int(n.split()[0]): one for (way, n), one in found.items() if way == "moving average"}
        # The ramp bends within it.
        assert window[301].bias / window[121].bias == pytest.approx(300 / 120, rel=0.12)
        assert found["raw maximum", ""].bias > window[3].bias > window[11].bias
        assert case.name != "noisy" or window[3].bias > 10 * abs(window[31].bias)
        best[case.name] = min(window, key=lambda n, window=window: window[n].error)
        chosen = found["chosen window", ""]
        assert chosen.error < 1.15 * window[best[case.name]].error
        assert abs(chosen.bias) < 0.5 * chosen.noise
    assert best["bench"] < best["noisy"], "more noise asks for a longer window"
