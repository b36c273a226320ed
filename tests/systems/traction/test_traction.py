"""A lift's traction sheave: the printed numbers of EN 81-50, 5.11, its limits, what is left out, bad input."""

import json
import math

import numpy as np
import pytest

import ropefric as rf
from ropefric.scenes.plan import make_plan
from ropefric.scenes.scene_templates import scene_text, write_scenes
from ropefric.section import as_text
from ropefric.systems.friction import WrapFriction
from ropefric.systems.traction.effects import SYSTEM
from ropefric.systems.traction.sheave import (
    CASES,
    TractionModel,
    TractionProblem,
    round_factor,
    solve_traction,
    wedge_factor,
)

LIFT = {
    "car_kg": 700.0, "rated_load_kg": 630.0, "counterweight_kg": 1015.0, "travel_m": 18.0, "wheel_radius_m": 0.2,
    "wrap_angle_rad": math.radians(160.0), "groove_angle_rad": math.radians(35.0), "undercut_rad": math.radians(90.0),
    "rope_radius_m": 0.005, "rope_count": 4.0, "linear_density_kg_m": 0.336, "above_car_m": 2.0,
    "above_counterweight_m": 2.57, "speed_m_s": 1.0, "deceleration_m_s2": 0.5, "counterweight_pulley_kg": 21.0,
}  # fmt: skip


def solved(effects=tuple(SYSTEM.effects), **changes):
    values = {name: value for name, value in (LIFT | changes).items() if value is not None}
    return solve_traction(TractionModel(problem=TractionProblem(**values), effects=frozenset(effects)))


@pytest.fixture(scope="module")
def answer():
    return solved()


def test_the_printed_factors_of_friction_and_tensions(answer):
    loading, braking, _, stalled = answer.friction_factor[:, 0]
    assert (round(loading, 4), round(braking, 4), round(stalled, 4)) == (0.1849, 0.1681, 0.3698)
    held = np.exp(answer.log_capacity[:, 0])
    assert (round(held[0], 3), round(held[1], 3), round(held[3], 3)) == (1.676, 1.599, 2.809)
    found = dict(zip(CASES, zip(answer.tight_N[:, 0], answer.slack_N[:, 0], strict=True), strict=True))
    assert found["loading"] == pytest.approx((14856.0, 9991.0), abs=0.5)
    assert found["braking-up"] == pytest.approx((10760.0, 6542.0), abs=0.5)
    rope_kg_m = 4.0 * 0.336
    hung_up_kg = 700.0 + 2.0 * rope_kg_m, (2.57 + 18.0) * rope_kg_m  # the counterweight on its buffer
    assert found["stalled"] == pytest.approx(9.81 * np.array(hung_up_kg), rel=1e-12)


def test_answers_are_told_apart_by_the_logarithms_of_all_their_numbers(answer):
    numbers = (np.exp(answer.log_capacity), answer.tight_N, answer.slack_N, answer.friction_factor, answer.utilisation,
               answer.wrap_limit_rad, answer.undercut_limit_rad)  # fmt: skip
    np.testing.assert_allclose(np.exp(answer.logs), numbers, rtol=1e-13)


def test_braking_upward_fails_and_what_would_mend_it(answer):
    assert round(answer.utilisation[1, 0], 3) == 1.029
    assert math.degrees(answer.needed_wrap_rad[0]) == pytest.approx(169.6, abs=0.05)
    assert math.degrees(answer.needed_undercut_rad[0]) == pytest.approx(97.3, abs=0.05)
    for more in ({"undercut_rad": answer.needed_undercut_rad}, {"wrap_angle_rad": answer.needed_wrap_rad}):
        mended = solved(**more)
        assert mended.utilisation[:3].max() == pytest.approx(1.0, rel=1e-12)
    # The plain groove holds while loading, and an undercut is needed for braking alone.
    rough = solved(friction=WrapFriction.constant(0.12))
    assert rough.undercut_limit_rad[0, 0] == 0.0
    mended = solved(friction=WrapFriction.constant(0.12), undercut_rad=rough.needed_undercut_rad)
    assert mended.utilisation[:3].max() == pytest.approx(1.0, rel=1e-12)


def test_v_grooves():
    hard = solved(groove="v-hardened", undercut_rad=0.0).friction_factor[:, 0]
    assert hard[0] == pytest.approx(0.1 / math.sin(math.radians(17.5)), rel=1e-14)
    worn = solved(groove="v").friction_factor[:, 0]
    assert worn[0] == pytest.approx(0.1 * 4.0 * (1.0 - math.sqrt(0.5)) / (0.5 * math.pi - 1.0), rel=1e-13)
    assert worn[3] == pytest.approx(0.2 / math.sin(math.radians(17.5)), rel=1e-14), "stalled, as if hardened"


def test_an_undercut_as_wide_as_can_be_is_a_wedge():
    gamma = np.radians([25.0, 35.0, 50.0])
    assert round_factor(gamma, np.pi - gamma - 1e-5) == pytest.approx(wedge_factor(gamma), rel=1e-4)
    assert round_factor(np.array([1e-9]), np.zeros(1)) == pytest.approx(4.0 / math.pi, rel=1e-8)


def test_no_effect_is_two_weights_on_a_smooth_stop():
    bare = solved(effects=())
    assert bare.tight_N[:, 0] == pytest.approx(9.81 * np.array([1487.5, 1015.0, 1330.0, 700.0]))
    assert bare.slack_N[:, 0] == pytest.approx(9.81 * np.array([1015.0, 700.0, 1015.0, 0.0]))
    assert bare.mu[:, 0].tolist() == [0.1, 0.1, 0.1, 0.2]


def scene(tmp_path, old="", new=""):
    path = tmp_path / "traction.toml"
    path.write_text(scene_text("traction").replace(old, new, 1), encoding="utf-8")
    return path


def test_the_template_is_the_published_lift_and_its_answer_is_no_certificate(tmp_path):
    path = next(path for path in write_scenes(tmp_path, ["traction"]) if path.suffix == ".toml")
    solution = rf.solve(path)
    tree = solution.to_dict()
    assert not solution.stands
    assert tree["failures"] == ["the ropes slip in the load case braking-up: utilisation 1.03"]
    assert "no certificate" in tree["note"]
    assert tree["cases"]["braking-up"]["utilisation"] == pytest.approx(1.0286, abs=5e-5)
    assert tree["cases"]["stalled"]["passes"]
    json.dumps(tree, allow_nan=False)
    assert rf.explain(path).plan.simulated == ("rope-weight", "deceleration", "pulley-inertia", "speed")


def test_a_sweep_mends_it(tmp_path):
    found = rf.sweep(scene(tmp_path), "sheave.wrap=160deg,175deg", "sheave.undercut=90deg,100deg")
    assert (found.columns["largest_utilisation"] > 1.0).tolist() == [True, False, False, False]
    assert found.failures == {"the ropes slip in the load case braking-up": 1}
    use = {case: found.columns[f"cases.{case}.utilisation"] for case in CASES}
    assert all((one[2:] < one[:2]).all() for case, one in use.items() if case != "stalled")
    assert (use["stalled"][2:] > use["stalled"][:2]).all()


def test_a_fit_brings_its_interval(tmp_path):
    write_scenes(tmp_path, ["hoist"])
    path = scene(tmp_path, "# [friction]\n", '[friction]\nfit = "fits/prth-coupled.json"\n')
    tree = rf.solve(path).to_dict()
    low, high = tree["largest_utilisation_interval"]
    assert low < tree["largest_utilisation"] < high
    assert tree["friction_is"] == "the scene's"
    assert tree["extrapolated"]
    # Ropes without weight leave nothing to hold when stalled, whatever the friction: 0 and certain.
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("linear_density", "# linear_density"), encoding="utf-8")
    cases = rf.solve(path).to_dict()["cases"]
    assert cases["stalled"]["utilisation"] == 0.0
    assert "utilisation_std" not in cases["stalled"]
    assert cases["loading"]["utilisation_std"] > 0.0


def test_the_chart_shows_what_is_held_and_what_is_asked(tmp_path):
    from ropefric.plotting.machines import scene_figures

    ((stem, figure),) = scene_figures(rf.solve(scene(tmp_path)))
    assert stem == "traction"
    rows = {row[0]: row[1:] for row in figure.tables[0].rows if "asked" in row[0]}
    assert rows["asked by braking-up"] == pytest.approx((160.0, 10760.18 / 6542.03), rel=1e-5)
    figure.figure.canvas.draw()


def test_a_car_lighter_than_the_hanging_rope_slips_at_no_wrap_when_stalled():
    one = np.ones(1)
    problem = TractionProblem(
        car_kg=100 * one, rated_load_kg=100 * one, counterweight_kg=150 * one, travel_m=51 * one,
        wheel_radius_m=0.25 * one, rope_radius_m=0.005 * one, wrap_angle_rad=2 * one, groove_angle_rad=one,
        undercut_rad=0 * one, rope_count=2 * one, linear_density_kg_m=one,
    )  # fmt: skip
    _, model = make_plan(SYSTEM, problem, accuracy=1e-6, effects="all")
    found = SYSTEM.solve(model, "closed-form")
    assert found.tight_N[3] < found.slack_N[3]
    assert np.isnan(found.wrap_limit_rad[3, 0])
    assert np.isfinite(found.wrap_limit_rad[:3]).all()
    with np.errstate(all="raise", divide="ignore"):
        assert np.isnan(found.logs[-2, 3, 0])


def test_what_the_standard_excludes_is_said_to_be_outside_it(tmp_path):
    text = scene_text("traction")
    for key, value in (("undercut", "110 deg"), ("groove_angle", "20 deg"), ("deceleration", "0.1 m/s^2")):
        line = next(one for one in text.splitlines() if one.split("=")[0].strip() == key)
        failures = rf.solve(scene(tmp_path, line, f'{key} = "{value}"')).to_dict()["failures"]
        words = f"{key.replace('_', ' ')} {value.split()[0]}"
        assert any(one.startswith("outside EN 81-50") and words in one for one in failures), key
    assert not any("outside" in one for one in rf.solve(scene(tmp_path)).to_dict()["failures"])


def test_without_friction_no_wrap_is_enough(tmp_path):
    solution = rf.solve(scene(tmp_path, "# [friction]\n", "[friction]\nmu = 0\n"))
    found = solution.to_dict()
    assert found["needed_wrap_rad"] is None
    assert "make it hold: none, without friction" in as_text(solution.scene.kind.sections(found))
    assert all(not found["cases"][case]["passes"] for case in ("loading", "braking-up", "braking-down"))
