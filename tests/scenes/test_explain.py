"""`explain` says of every effect whether it is simulated, why, and what it is worth."""

from itertools import count

import pytest

from ropefric.errors import RopefricError
from ropefric.scenes.plan import explain_scene, make_plan
from ropefric.scenes.solve import solve_scene
from ropefric.systems.hoist.effects import SYSTEM
from ropefric.systems.press.answer import FAST_ERROR


def test_every_effect_is_told_of(loaded):
    told = explain_scene(loaded("climbing-hoist")).to_dict()
    assert [effect["name"] for effect in told["effects"]] == list(SYSTEM.effects)
    by_name = {effect["name"]: effect for effect in told["effects"]}
    assert by_name["bending-stiffness"]["fate"] == "not applicable"
    assert by_name["bending-stiffness"]["missing"] == ["rope.bending_stiffness"]
    assert 0.0 < by_name["centrifugal"]["bound"] < 0.01
    assert by_name["centrifugal"]["simulated"] is True, "a closed form is solved whole"
    assert by_name["size"]["why"] == "worth up to 0.23 of the answer"
    assert by_name["centrifugal"]["why"].endswith("of the answer; leaving it out would save no time")
    saw = {effect["name"]: effect for effect in explain_scene(loaded("band-saw")).to_dict()["effects"]}
    assert saw["torsion"]["simulated"] is False
    assert told["measured"] is None


def test_what_is_measured_stays_below_its_bound(loaded):
    ticks = count()
    told = explain_scene(loaded("climbing-hoist"), measure=True, clock=lambda: float(next(ticks))).to_dict()
    for effect in told["effects"]:
        if effect["fate"] != "not applicable":
            assert effect["worth"] <= effect["bound"] * (1 + 1e-9)
    assert told["measured"]["difference"] <= told["error_bound"]
    assert told["measured"]["planned_s"] == 1.0  # the clock given ticks once a solution


def test_bounds_are_shown_even_where_the_effects_are_named(hoist_of):
    told = explain_scene(hoist_of(effects=["size"])).to_dict()
    assert all(
        effect["bound"] is not None for effect in told["effects"] if effect["fate"] != "not applicable"
    )
    assert (
        next(effect for effect in told["effects"] if effect["name"] == "size")["why"] == "asked for by name"
    )


def test_without_measuring_nothing_is_timed(hoist_of):
    def never():
        raise AssertionError

    assert explain_scene(hoist_of(), clock=never).planned_s != pytest.approx(0.0)


def test_of_a_start_up_it_is_said_which_modes_swing(loaded, scene_of):
    """Slow enough it is quasi-static, of hard belts only slow modes swing, and where belts slip nothing is known."""
    tree = loaded("press-start-up").document.data | {"friction": {"mu": 0.9}, "accuracy": 0.02}
    tree["press"] = tree["press"] | {"preload": "4000 N"}
    tree["start_up"] = {"law": "s-curve", "duration": "12 s", "simulate": "14 s", "points": 101}
    quick = tree | {"start_up": tree["start_up"] | {"duration": "1 s"}}
    slow, quick, slips = (
        {one.name: one for one in explain_scene(scene).plan.decisions}
        for scene in (scene_of(**tree), scene_of(**quick), loaded("press-start-up"))
    )
    assert slow["slow-modes"].fate == slow["fast-modes"].fate == "left out"
    assert slow["slow-modes"].why.endswith("no swings at all: a start-up that is quasi-static")
    assert slow["slow-modes"].bound <= FAST_ERROR < slow["fast-modes"].bound + FAST_ERROR
    assert slow["fast-modes"].why.endswith("0 of 13 modes swing, belt upper and lower as good as rigid")
    assert quick["slow-modes"].fate == "simulated"
    assert quick["fast-modes"].fate == "left out"
    assert quick["fast-modes"].why.endswith("as if at rest; 3 of 13 modes swing")
    assert slips["fast-modes"].why.startswith("no bound is known")


def test_a_start_up_that_has_no_answer_is_explained(loaded, scene_of):
    tree = loaded("press-start-up").document.data
    tree["rollers"]["3"]["tensioner"] = tree["rollers"]["3"]["tensioner"] | {"travel": "-500 mm"}
    scene = scene_of(**tree)
    words = {one.name: one for one in explain_scene(scene).plan.decisions}
    assert words["fast-modes"].fate == "simulated"
    with pytest.raises(RopefricError, match="slack at rest"):
        solve_scene(scene)


def test_with_all_effects_nothing_is_asked_of_modes(loaded, monkeypatch):
    monkeypatch.delattr("ropefric.systems.press.answer.swinging_of")
    scene = loaded("press-start-up")
    plan, _ = make_plan(scene.kind.system, scene.problem, accuracy=0.02, effects="all")
    assert {"fast-modes", "slow-modes"} <= set(plan.simulated)
