"""Of a list of effects each number has a bound of its own; a belt that has to push is a failure with its place."""

import pytest

from ropefric.scenes.kind import value_at
from ropefric.scenes.solve import solve_scene


@pytest.mark.parametrize(
    ("name", "effects"),
    [("belt-press", ["squeeze-load", "belt-inertia"]), ("climbing-hoist", ["size"]), ("belt-drive", ["wedge"]),
     ("cable-pull", ["wrap-dependence"])],
)  # fmt: skip
def test_every_number_of_a_list_keeps_its_own_bound(loaded, scene_of, name, effects):
    tree = loaded(name).document.data
    listed, whole = (solve_scene(scene_of(**tree | {"effects": one})) for one in (effects, "all"))
    told, wanted = listed.to_dict(), whole.to_dict()
    assert listed.own_bounds.keys() == {one.name for one in listed.quantities}
    off = {key: abs(value_at(told, key) - value_at(wanted, key)) for key in listed.own_bounds
           if value_at(wanted, key) is not None and value_at(told, key) is not None}  # fmt: skip
    assert max(off.values()) > 0.0
    assert name != "belt-press" or told["slip"]["2"]["utilisation"] == 0.0
    assert name != "belt-press" or listed.own_bounds["slip.2.utilisation"] == pytest.approx(0.5307, abs=1e-4)
    for key, one in off.items():
        assert one <= listed.own_bounds[key] * (1.0 + 1e-9), key
    assert whole.own_bounds == {}


def six_rollers():
    rollers = {"drive": {"radius": "100 mm", "wrap": "180 deg", "role": "driver", "inertia": "1 kg*m^2"}}
    for place in range(4):
        rollers[f"load{place}"] = {"radius": "100 mm", "wrap": "120 deg", "inertia": "4 kg*m^2",
                                   "squeeze_torque": "5 N*m"}  # fmt: skip
    rollers["take"] = {"radius": "80 mm", "wrap": "180 deg", "role": "tensioner", "inertia": "1 kg*m^2",
                       "tensioner": {"spring": "20 N/mm", "mass": "50 kg", "damping": "200 N*s/m"}}  # fmt: skip
    belt = {"loop": list(rollers), "width": "1 m", "thickness": "5 mm", "linear_density": "2 kg/m", "damping": "1 ms",
            "axial_stiffness": "500 kN", "span_lengths": ["1 m"] * len(rollers)}  # fmt: skip
    start_up = {"law": "ramp", "duration": "0.01 s", "simulate": "0.3 s", "points": 301}
    return {"system": "press", "press": {"speed": "1 m/s", "preload": "1000 N"}, "rollers": rollers,
            "belts": {"belt": belt}, "friction": {"mu": 0.5}, "start_up": start_up}  # fmt: skip


def test_a_press_that_cannot_be_pulled_like_this_shows_no_creep(loaded, scene_of):
    tree = loaded("belt-press").document.data
    held, slips = (solve_scene(scene_of(**tree | {"friction": {"mu": mu}})) for mu in (1.2, 0.3))
    parts = [[one.title for one in run.scene.kind.sections(run.to_dict())] for run in (held, slips)]
    assert slips.failures
    assert "Creep" not in parts[1]
    assert ("Creep" in parts[0]) == bool(held.to_dict()["creep"]["power_lost_W"])


def test_a_belt_of_a_press_strained_by_more_than_a_tenth_is_said_running_and_starting(scene_of):
    for starts in (False, True):
        tree = six_rollers()
        tree = tree if starts else {key: value for key, value in tree.items() if key != "start_up"}
        for stiffness, is_said in (("5 kN", True), ("500 kN", False)):
            tree["belts"]["belt"]["axial_stiffness"] = stiffness
            said = solve_scene(scene_of(**tree)).failures
            assert any("strained by more than 10 %" in one for one in said) == is_said, (starts, stiffness)
