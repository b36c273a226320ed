"""`explain` says of every effect whether it is simulated, why, and what it is worth."""

from itertools import count

import pytest

from ropefric.scenes.plan import explain_scene
from ropefric.systems.hoist.effects import SYSTEM


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
