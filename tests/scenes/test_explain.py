"""`explain` says of every effect whether it is simulated, why, and what it is worth."""

import math
from dataclasses import replace
from itertools import count

import pytest

from ropefric.errors import RopefricError
from ropefric.report.parts import explanation_sections
from ropefric.scenes.explain import explain_scene, explain_solution
from ropefric.scenes.solve import solve_scene
from ropefric.section import as_text
from ropefric.systems.hoist.effects import SYSTEM


def by_name(scene, **how):
    return {one["name"]: one for one in explain_scene(scene, **how).to_dict()["effects"]}


def test_every_effect_is_told_of(loaded):
    told = explain_scene(loaded("climbing-hoist")).to_dict()
    assert [effect["name"] for effect in told["effects"]] == list(SYSTEM.effects)
    named = {effect["name"]: effect for effect in told["effects"]}
    assert named["bending-stiffness"]["fate"] == "not applicable"
    assert named["bending-stiffness"]["missing"] == ["rope.bending_stiffness"]
    assert named["bending-stiffness"]["worth"] is None
    assert named["centrifugal"]["simulated"] is True, "a closed form is solved whole"
    assert named["centrifugal"]["why"].endswith("an effect without a bound is always simulated")
    assert named["centrifugal"]["bound"] is None
    saw = by_name(loaded("band-saw"))
    assert saw["torsion"]["simulated"] is False
    assert saw["torsion"]["worth"] == 0.0
    assert told["measured"] is None


def test_an_effect_is_worth_what_leaving_it_out_changes(loaded, scene_of):
    tree = loaded("climbing-hoist").document.data
    whole = solve_scene(scene_of(**tree | {"effects": "all"}))
    for name, one in by_name(scene_of(**tree)).items():
        if one["fate"] == "simulated":
            others = [other for other in whole.plan.simulated if other != name]
            without = solve_scene(scene_of(**tree | {"effects": others})).answer
            change = abs(without.log_lift[0] - whole.answer.log_lift[0])
            assert one["worth"] >= math.expm1(change) * (1.0 - 1e-9)
    saw = loaded("band-saw").document.data | {"accuracy": 0.2, "effects": "auto"}
    del saw["excitation"]
    told = by_name(scene_of(**saw))["bending"]
    assert told["fate"] == "left out"
    assert 0.0 < told["worth"] <= told["bound"]
    assert told["why"].startswith("influence at most ")


def test_times_are_medians_of_runs_in_turn_and_what_is_less_than_their_spread_is_not_told(loaded):
    steady = count()
    told = explain_scene(loaded("climbing-hoist"), measure=True, clock=lambda: float(next(steady)))
    assert (told.planned_s, told.all_s, told.spread_s) == (1.0, 1.0, 0.0)
    assert told.to_dict()["measured"]["difference"] <= told.plan.error_bound
    assert all(one.time_spread_s == 0.0 for one in told.plan.decisions if not math.isnan(one.worth))
    assert all(math.isnan(one.time_s) for one in told.plan.decisions), "none takes time by this clock"
    said = " ".join(as_text(explanation_sections(told)).split())
    assert "the difference is below what the clock resolves here, 0 µs" in said


def test_without_measuring_nothing_is_timed(hoist_of):
    def never():
        raise AssertionError

    assert math.isnan(explain_scene(hoist_of(), clock=never).planned_s)


def test_a_start_up_that_has_no_answer_is_explained(loaded, scene_of):
    tree = loaded("press-start-up").document.data
    tree["rollers"]["3"]["tensioner"] = tree["rollers"]["3"]["tensioner"] | {"travel": "-500 mm"}
    scene = scene_of(**tree)
    assert by_name(scene)["transient"]["fate"] == "simulated"
    with pytest.raises(RopefricError, match="slack at rest"):
        solve_scene(scene)


def test_an_answer_is_explained_without_solving_the_scene_again(loaded, monkeypatch):
    """The influences are those that `explain` gives, from fewer solutions by one."""
    scene, counts = loaded("climbing-hoist"), []
    solve = scene.kind.system.solve

    def counted(model, method):
        counts.append(model.effects)
        return solve(model, method)

    system = scene.kind.system._replace(solve=counted)
    scene = replace(scene, kind=replace(scene.kind, system=system))
    solution = solve_scene(scene)
    counts.clear()
    found = explain_solution(solution).to_dict()
    own = len(counts)
    counts.clear()
    assert found == explain_scene(scene).to_dict()
    assert own == len(counts) - 1
