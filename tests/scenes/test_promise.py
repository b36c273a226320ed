"""The promise of a plan: it stays within the accuracy, and within the error bound that it states."""

import pytest

from ropefric.report.parts import solution_sections
from ropefric.scenes.solve import solve_scene
from ropefric.section import as_text


def test_an_accuracy_below_rounding_is_not_promised(hoist_of):
    solution = solve_scene(hoist_of(accuracy=1e-15))
    assert not solution.plan.keeps_accuracy
    said = "the error of the method (closed form) is up to 1e-12"
    assert any(said in warning for warning in solution.warnings)


@pytest.mark.parametrize(
    ("name", "parts"), [("belt-press", ["critical", "creep.power_lost_W"]), ("band-saw", ["resonance"])]
)
def test_what_the_bound_does_not_cover_is_said_where_something_is_left_out(scene_of, loaded, name, parts):
    tree = dict(loaded(name).document.data)
    if name == "band-saw":
        tree["blade"] = tree["blade"] | {"modes": 3}
    named, whole = (solve_scene(scene_of(**tree | {"effects": one})) for one in (tree["effects"], "all"))
    assert named.plan.left_out
    assert named.to_dict()["beyond_bound"] == parts
    assert whole.to_dict()["beyond_bound"] == []
    said, nothing = (as_text(solution_sections(one, one.to_dict())) for one in (named, whole))
    assert "without a bound, by the effects simulated" in said
    assert "without a bound" not in nothing
    assert ("torsion is left out; its frequencies are not listed" in said) == (name == "band-saw")


def test_what_resonates_is_of_the_blade_that_is_simulated(scene_of, loaded):
    tree = loaded("band-saw").document.data
    for effects in ([], ["tension-difference"], ["travel"], ["wheel-inertia-tension", "travel", "bending"]):
        found = solve_scene(scene_of(**tree | {"effects": effects})).to_dict()
        for one in found["resonance"]["nearest"]:
            assert one["mode_Hz"] == pytest.approx(
                found[one["side"]]["frequencies_Hz"][one["mode"] - 1], rel=1e-3
            )


def test_a_yes_or_no_that_effects_left_out_by_name_may_turn_is_said_to_be_open(hoist_of):
    rope = {"linear_density": "62 g/m", "hanging_length": "5 m", "bending_stiffness": "2e-3 N*m^2"}
    load, effects = {"end_tension": "80 N"}, ["wrap-dependence", "size", "end-tension"]
    force_N = solve_scene(hoist_of(rope=rope, load=load, effects=effects)).quantities[0].value[0]
    near = load | {"payload": f"{0.999 * force_N / 9.80665:.6f} kg"}
    solution = solve_scene(hoist_of(rope=rope, load=near, effects=effects, accuracy=0.2))
    assert solution.plan.keeps_accuracy
    assert not solution.stands
    told = solution.to_dict()
    assert len(told["undecided"]) == 1
    assert told["undecided"][0].startswith("the hoist does not lift its payload")
    assert told["undecided"][0] in " ".join(told["warnings"])
    whole = solve_scene(hoist_of(rope=rope, load=near, effects="all"))
    apart_N = abs(told["margin_N"] - whole.to_dict()["margin_N"])
    assert 0.0 < apart_N <= told["own_bounds"]["margin_N"]
    assert "bound of margin_N: " in as_text(solution_sections(solution, told))
    far = solve_scene(hoist_of(rope=rope, load=load | {"payload": "1 kg"}, effects=effects, accuracy=0.2))
    assert not far.undecided
    assert whole.to_dict()["own_bounds"] == {}


def test_which_roller_slips_is_open_within_the_bound_of_a_list(loaded, scene_of):
    tree = loaded("belt-press").document.data
    first = solve_scene(scene_of(**tree)).to_dict()
    needed = first["slip"][first["first_to_slip"]]["mu_required"]
    solution = solve_scene(scene_of(**tree | {"friction": {"mu": needed * 1.001}}))
    assert f"whether the belt slips on roller {first['first_to_slip']}" in solution.undecided
    tree |= {"friction": {"mu": needed * 1.001}, "effects": "all"}
    assert not solve_scene(scene_of(**tree)).undecided
    # Without friction the belt slips whatever is left out.
    tree |= {"friction": {"mu": 0}, "effects": first["effects"]["simulated"]}
    smooth = solve_scene(scene_of(**tree))
    assert smooth.plan.left_out
    assert smooth.failures
    assert not smooth.undecided


@pytest.mark.parametrize("case",
                         [("3920 N", 0.34, 1.0, "1.3 kg*m^2", "4"),
                          pytest.param(("1930 N", 0.35, 1.2, "8 kg*m^2", "5"), marks=pytest.mark.slow)])  # fmt: skip
def test_a_slip_of_a_millisecond_between_the_steps_of_a_grid_is_not_missed(loaded, scene_of, case):
    preload, mu, load_factor, inertia, roller = case
    tree = loaded("press-start-up").document.data | {"friction": {"mu": mu}, "accuracy": 0.05}
    tree["press"] = tree["press"] | {"preload": preload, "closure": "equal", "load_factor": load_factor}
    tree["rollers"] = tree["rollers"] | {"3": tree["rollers"]["3"] | {"inertia": inertia}}
    tree["start_up"] = {"law": "constant", "simulate": "0.1 s", "points": 23, "loads": "constant"}
    planned, whole = (solve_scene(scene_of(**tree | {"effects": effects})).answer.start_up.summary()
                      for effects in ("auto", "all"))  # fmt: skip
    assert whole["slipping_s"][roller] < 2e-3
    assert planned["first_slip_s"].keys() == whole["first_slip_s"].keys()
