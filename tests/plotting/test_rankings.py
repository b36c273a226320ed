"""Figures that rank: laws by AICc, contributions to an uncertainty, inputs by what they do to the force."""

import math

import numpy as np
import pytest

from ropefric.fitting.compare import Comparison, ComparisonEntry, compare_laws
from ropefric.plotting.design import draw_budget, draw_ladder, draw_tornado

NAN = math.nan
BUDGET = [("gain", 0.3), ("wrap", -1.2), ("tare", 0.4), ("humidity", NAN)]
SWINGS = [("F_B ± 5 N", 190.0, 210.0, 200.0), ("φ ± 5°", 206.0, 195.0, 200.0),
    ("μ ± 0.01", 170.0, 235.0, 200.0)]  # fmt: skip


def entry(law, delta, *, counted=True, note="", weight=0.5):
    return ComparisonEntry(
        law=law, n=12, k=2, chi2=10.0, aicc=delta - 50.0, bic=-49.0, delta_aicc=delta,
        weight=weight if counted else 0.0,
        loco_error=0.012 if counted else NAN, status="ok", counted=counted, note=note, fit=None,
    )  # fmt: skip


def test_the_ladder_shows_the_comparison(pulls, told, assert_readable):
    ranked = compare_laws(pulls, ["constant", "wrap-power", "size-power"])
    made = told(draw_ladder(ranked))
    assert_readable(made)
    (axes,) = made.figure.axes
    assert [label.get_text() for label in axes.get_yticklabels()] == [e.law for e in ranked.ranking]
    dots = [line.get_xydata()[0] for line in axes.lines if line.get_marker() in {"o", "D"}]
    wanted = [(e.delta_aicc, row) for row, e in enumerate(ranked.ranking) if e.counted]
    np.testing.assert_allclose(dots, wanted)
    assert [row[3] for row in made.tables[0].rows] == [e.weight for e in ranked.ranking]
    assert f"{ranked.best.law} is best with a weight of {ranked.best.weight:.3g}" in made.alt
    assert "ΔAICc [-]" in axes.get_xlabel()
    assert "28 trials, 7 conditions" in axes.get_title(loc="left")


def made_up(*ranking, **facts):
    return draw_ladder(Comparison(ranking=ranking, tests=(), notes=(), **facts))


def test_a_law_that_is_not_counted_is_a_cross_with_its_reason():
    not_counted = entry("groove", NAN, counted=False, note="has the same forces")
    made = made_up(entry("constant", 0.0), not_counted, n=6, n_trials=12, scatter_within=0.01)
    (axes,) = made.figure.axes
    assert [line.get_marker() for line in axes.lines if line.get_marker() != "None"] == ["D", "x"]
    assert any("has the same forces" in text.get_text() for text in axes.texts)
    assert "nan" not in made.alt
    none = entry("constant", math.inf, counted=False, note="too few")
    assert made_up(none, n=2, n_trials=2, scatter_within=NAN).alt == "1 law compared; none can be counted."


def budget(rows):
    combined = math.sqrt(math.fsum(value**2 for _, value in rows if not math.isnan(value)))
    return draw_budget(rows, unit="N", title="F_A", combined=combined)


def test_the_budget_is_ranked_with_shares_of_the_variance(told, assert_readable):
    made = told(budget(BUDGET))
    assert_readable(made)
    rows = made.tables[0].rows
    assert [row[0] for row in rows] == ["wrap", "tare", "gain", "humidity"]
    total = 0.3**2 + 1.2**2 + 0.4**2
    np.testing.assert_allclose([row[2] for row in rows[:3]], [1.44 / total, 0.16 / total, 0.09 / total])
    np.testing.assert_allclose([row[3] for row in rows[:3]], np.cumsum([1.44, 0.16, 0.09]) / total)
    assert math.isnan(rows[3][2])
    (bars,) = made.figure.axes
    np.testing.assert_allclose([patch.get_width() for patch in bars.patches], [1.2, 0.4, 0.3, 0.0])
    assert bars.get_xlabel().endswith("[N]")
    assert f"u = {math.sqrt(total):.4g} N (k = 1)" in bars.get_title()
    assert f"{math.sqrt(total):.4g} N" in made.alt


def test_a_correlated_budget_keeps_its_own_sum_and_one_without_contributions_says_so():
    made = draw_budget(BUDGET, unit="", title="x", combined=0.9)
    assert "0.9" in made.alt
    assert sum(row[2] for row in made.tables[0].rows[:3]) == pytest.approx(1.0)
    assert made.figure.axes[0].get_xlabel().endswith("[-]")
    assert budget([("gain", -2.0)]).tables[0].rows == (("gain", 2.0, 1.0, 1.0),)
    for rows in ([], [("gain", 0.0)], [("gain", NAN)]):
        made = budget(rows)
        assert "no contribution is known" in made.alt
        assert len(made.tables[0].rows) == len(rows)


def test_the_tornado_has_the_widest_swing_on_top(told, assert_readable):
    made = told(draw_tornado(SWINGS))
    assert_readable(made)
    assert [(row[0], row[4]) for row in made.tables[0].rows] == [("μ ± 0.01", 65.0), ("F_B ± 5 N", 20.0),
        ("φ ± 5°", 11.0)]  # fmt: skip
    (axes,) = made.figure.axes
    low, high = axes.patches[0], axes.patches[3]
    assert (low.get_x() + low.get_width(), high.get_x() + high.get_width()) == (170.0, 235.0)
    assert low.get_hatch()
    assert not high.get_hatch()
    assert axes.get_xlabel() == "Lift force $F_{\\mathrm{A}}$ [N]"
    assert "φ ± 5°: 206 to 195 N" in made.alt


def test_a_side_without_an_answer_is_left_out():
    made = draw_tornado([("R_w", NAN, 210.0, 200.0)])
    assert len(made.figure.axes[0].patches) == 1
    assert "unknown to 210 N" in made.alt
    assert draw_tornado([("R_w", 200.0, 200.0, 200.0)]).tables[0].rows[0][4] == 0.0
