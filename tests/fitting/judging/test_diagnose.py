"""Diagnoses on data whose cause is known, and on data that cannot tell."""

import json

import numpy as np
import pytest

from ropefric.errors import InputError
from ropefric.fitting.compare import compare_laws
from ropefric.fitting.diagnose import diagnose
from ropefric.friction.laws import ALL_LAWS
from ropefric.trials.table import TrialTable


@pytest.mark.slow
def test_real_rope_on_a_cylinder_has_no_wrap_effect(cylinder_table, cylinder_comparisons):
    found = diagnose(cylinder_table, cylinder_comparisons["conditions"])
    assert found["wrap effect"].supported == "no"
    assert found["offset"].supported == "no"
    assert found["load dependence"].supported == "cannot-tell"  # one load was lifted
    assert found["size effect"].supported == "cannot-tell"
    assert "describes the trials" in found.summary
    assert "wrap effect: not supported" in found.text
    json.dumps(found.to_dict(), allow_nan=False)


def test_wrap_and_load_effect_of_the_wrap_law(campaign):
    found = diagnose(campaign("wrap-power", [0.2, -0.5, 0.1]))
    assert found["wrap effect"].supported == "yes"
    assert found["load dependence"].supported == "yes"
    assert found["offset"].supported == "no"
    assert found["load dependence"].numbers["slope_per_doubling"] < 0
    assert "does not describe" in found.summary


def test_a_clear_offset(campaign):
    """No wrap law has a μ that rises with the wrap, so none mimics an offset that takes force away."""
    table = campaign(
        "constant-offset", [0.15, -0.1], wraps_deg=(30, 60, 90, 180, 360, 720, 1080), within=0.005
    )
    found = diagnose(table)
    assert found["offset"].supported == "yes"
    assert found["wrap effect"].supported != "yes"
    assert found["offset"].numbers["k"] == pytest.approx(-0.1, abs=0.01)


def test_offset_and_wrap_effect_that_look_alike(campaign):
    found = diagnose(campaign("constant-offset", [0.15, 0.1]))
    assert found["wrap effect"].supported == "cannot-tell"
    assert "looks exactly like a wrap effect" in found["wrap effect"].evidence
    assert "wrap near zero" in found["offset"].experiment


def test_size_effect(campaign):
    found = diagnose(campaign("size-exponential", [0.25, -0.2, -0.3], radii=(0.015, 0.03, 0.06), repeats=3))
    assert found["size effect"].supported == "yes"
    assert found["wrap effect"].supported == "no"
    assert found["size effect"].numbers["slope_per_doubling"] > 0


@pytest.mark.slow
def test_obedient_rope_is_left_alone(campaign):
    table = campaign("constant", [0.18], radii=(0.02, 0.04), between=0.005, repeats=3, seed=3)
    found = diagnose(table)
    assert {c.cause for c in found.causes if c.supported == "yes"} <= {"condition scatter"}
    assert "describes the trials" in found.summary


def test_effects_that_many_conditions_do_not_show_are_not_there(campaign):
    """Neither a better law nor a trend speaks for them, and no other effect has to explain that away."""
    found = diagnose(campaign("constant", [0.2], radii=(0.02, 0.04, 0.08), repeats=3, seed=4))
    for effect in ("offset", "load dependence", "size effect"):
        assert found[effect].supported == "no", effect
        assert found[effect].numbers["p_value"] >= 0.05
        assert found[effect].numbers["gain_on_constant"] < 2.0


def test_one_wrap_cannot_tell_an_offset(campaign):
    found = diagnose(campaign("constant", [0.18], wraps_deg=(180,), repeats=3))
    assert found["offset"].supported == "cannot-tell"
    assert found["wrap effect"].supported == "cannot-tell"


def test_few_conditions_with_a_clear_trend_are_not_a_no(campaign):
    """AICc turns down every extra parameter at five conditions; the F-test still sees the offset."""
    found = diagnose(campaign("constant-offset", [0.15, 0.06], loads=(20.0,), repeats=3))
    assert found["offset"].numbers["p_value"] < 0.01
    assert found["offset"].supported == "cannot-tell"


@pytest.mark.slow
def test_new_ropes_scatter(campaign):
    assert diagnose(campaign("constant", [0.2], between=0.03))["condition scatter"].supported == "yes"
    assert diagnose(campaign("constant", [0.2]))["condition scatter"].supported == "no"
    assert diagnose(campaign("constant", [0.2], repeats=1))["condition scatter"].supported == "cannot-tell"


@pytest.mark.slow
def test_trials_that_never_slipped(campaign):
    good = campaign("constant", [0.2], repeats=2)
    status = ["ok"] * 20 + ["no-breakaway"] * 10
    table = TrialTable(
        trial=good.trial, wheel_radius_m=good.wheel_radius_m, rope_radius_m=good.rope_radius_m,
        wrap_angle_rad=good.wrap_angle_rad, end_tension_N=good.end_tension_N, peak_N=good.peak_N,
        status=tuple(status),
    )  # fmt: skip
    found = diagnose(table)["no gross slip"]
    assert found.supported == "yes"
    assert "10 of 30 trials (33%)" in found.evidence
    assert diagnose(good)["no gross slip"].supported == "no"


def test_a_comparison_without_data_is_refused(campaign):
    from dataclasses import replace

    table = campaign("constant", [0.2], repeats=2)
    comparison = compare_laws(table, [ALL_LAWS["constant"]])
    bare = tuple(
        replace(e, fit=None if e.fit is None else replace(e.fit, problem=None)) for e in comparison.ranking
    )
    with pytest.raises(InputError, match="carries no data"):
        diagnose(table, replace(comparison, ranking=bare))
    assert np.isfinite(comparison.scatter_within)


def test_a_law_that_counts_the_wrap_from_zero_may_be_among_the_best(campaign):
    """The notes look a near law up by its name; that it is no law of the usual comparison ended in RF120."""
    table = campaign("wrap-power-from-zero", [0.2, -0.4, 0.1])
    ranked = compare_laws(table, ALL_LAWS.values())
    assert any(entry.law.endswith("-from-zero") and entry.delta_aicc <= 2.0 for entry in ranked.ranking)
    assert diagnose(table, ranked)["wrap effect"].supported == "yes"
