"""The promise of a plan: it stays within the accuracy, and within the error bound that it states."""

import math

import numpy as np
import pytest
from hypothesis import strategies as st
from promise import check_promise, costly

from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS
from ropefric.report.scene import solution_sections
from ropefric.report.section import as_text
from ropefric.scenes.plan import make_plan
from ropefric.scenes.solve import solve_scene
from ropefric.systems.friction import WrapFriction
from ropefric.systems.hoist.contact import HoistProblem, answerable
from ropefric.systems.hoist.effects import SYSTEM

LAWS = {
    "constant": [(0.05, 0.4)],
    "constant-offset": [(0.05, 0.4), (0.0, 0.2)],
    "size-exponential": [(0.1, 0.4), (-0.4, -0.05), (-1.0, 0.0)],
    "wrap-power": [(0.01, 0.4), (-0.9, -0.05), (0.02, 0.2)],
    "wrap-exponential": [(0.01, 0.4), (-1.0, -0.02), (0.02, 0.2)],
    "coupled": [(0.1, 0.5), (-0.5, -0.05), (-1.0, 0.0), (-0.9, -0.05), (0.02, 0.15)],
    "howell": [(0.1, 0.5), (0.7, 0.99)],
}


@st.composite
def hoists(draw):
    """Ropes from thread to hawser; each optional datum is there or not."""
    name = draw(st.sampled_from(sorted(LAWS)))
    theta = np.array([draw(st.floats(low, high)) for low, high in LAWS[name]])
    wheel_m, rope_m = draw(st.floats(0.02, 0.2)), draw(st.floats(0.002, 0.008))
    wrap, end_N = draw(st.floats(0.5, 20.0)), draw(st.floats(5.0, 800.0))
    near = st.floats(0.8, 1.25)
    reference = one_condition(
        wheel_m * draw(near), rope_m * draw(near), wrap * draw(near), end_N * draw(near)
    )
    optional = {
        "speed_m_s": st.floats(0.0, 8.0),
        "linear_density_kg_m": st.floats(0.01, 0.3),
        "hanging_length_m": st.floats(0.1, 20.0),
        "bending_stiffness_N_m2": st.floats(1e-7, 2e-3),
    }
    return HoistProblem(
        friction=WrapFriction(law=ALL_LAWS[name], theta=theta, reference=reference),
        wheel_radius_m=wheel_m,
        rope_radius_m=rope_m,
        wrap_angle_rad=wrap,
        end_tension_N=end_N,
        **{key: draw(values) for key, values in optional.items() if draw(st.booleans())},
    )


ANSWERABLE = hoists().filter(lambda problem: answerable(problem).all())


def test_the_promise_holds_for_random_hoists():
    counts = check_promise(SYSTEM, ANSWERABLE, 30)
    assert counts["spared"] > 0.5 * counts["planned"] > 3


@pytest.mark.slow
def test_the_promise_holds_for_thousands_of_random_hoists():
    counts = check_promise(SYSTEM, ANSWERABLE, 2000)
    assert counts["spared"] > 0.8 * counts["planned"] > 400
    assert counts["spared with a worth"] > 0.5 * counts["planned"]


@pytest.mark.parametrize("accuracy", [0.3, 0.05, 0.01, 1e-3])
@pytest.mark.parametrize("name", ["belt-press", "fast-belt-press", "band-saw", "fast-band-saw"])
def test_the_promise_holds_for_the_bundled_machines(loaded, name, accuracy):
    scene = loaded(name)
    system = scene.kind.system
    plan, model = make_plan(system, scene.problem, accuracy=accuracy, effects="auto")
    full_plan, full = make_plan(system, scene.problem, accuracy=accuracy, effects="all")
    everything = system.solve(full, system.method(full, 1e-10))
    difference = system.distance(system.solve(model, plan.method), everything)
    assert difference <= min(accuracy, plan.error_bound)
    assert plan.keeps_accuracy
    assert full_plan.left_out == ()


def test_an_accuracy_below_rounding_is_not_promised(hoist_of):
    solution = solve_scene(hoist_of(accuracy=1e-15))
    assert not solution.plan.keeps_accuracy
    assert any(
        "the error of the method (closed form) is up to 1e-12" in warning for warning in solution.warnings
    )


def test_an_integrator_asked_for_by_name_promises_nothing(scene_of, loaded):
    tree = loaded("press-start-up").document.data
    start_up = tree["start_up"] | {"integrator": "rk4", "slip": False, "simulate": "0.2 s", "points": 11}
    solution = solve_scene(scene_of(**(tree | {"start_up": start_up})))
    assert math.isinf(solution.plan.error_bound)
    assert any("direct solution and rk4) is not known" in warning for warning in solution.warnings)


def test_of_a_start_up_only_the_exact_moments_of_slip_have_a_bound(loaded):
    scene = loaded("press-start-up")
    decisions = {
        one.name: one
        for one in make_plan(costly(scene.kind.system), scene.problem, accuracy=1.0, effects="auto")[
            0
        ].decisions
    }
    assert decisions["transient"].fate == "simulated"
    assert math.isinf(decisions["gravity-load"].bound)
    assert {name for name, one in decisions.items() if one.fate == "left out"} == {
        "wrap-dependence",
        "size",
        "transient-friction",
        "exact-switching",
    }


def test_the_power_of_a_press_does_not_depend_on_what_is_left_out(loaded, scene_of):
    """Belts without mass still run: the drivers do the work of the loads at the speed asked for."""
    scene = loaded("belt-press")
    problem, system = scene.problem, costly(scene.kind.system)
    plan, model = make_plan(system, problem, accuracy=0.1, effects="auto")
    assert "belt-inertia" in plan.left_out
    answer = system.solve(model, plan.method)
    numbers = {one.name: one.value[0] for one in scene.kind.quantities(answer, problem)}
    assert numbers["power_W"] == pytest.approx(1673.8, abs=0.05)
    tree = scene.kind.tree(answer, problem)
    assert tree["speed_m_s"] == pytest.approx(0.916298, abs=1e-6)
    assert tree["critical"]["friction"]["by_roller"]["2"] == pytest.approx(
        tree["slip"]["2"]["mu_required"], rel=1e-9
    )
    assert tree["critical"]["speed"]["value"] > 1.0, "a higher speed would still lift the belt"


def test_a_load_is_worth_its_share_of_the_power_at_least(loaded):
    """Squeezing does 1008 N of the 1826.667 N that the drivers pull, whatever it does to slip."""
    scene = loaded("belt-press")
    squeeze_N = sum(one.squeeze_torque_N_m / one.radius_m for one in scene.problem.press.rollers)
    bound = scene.kind.system.effects["squeeze-load"].influence(scene.problem)
    assert bound >= squeeze_N / 1826.667


@pytest.mark.parametrize(
    ("name", "parts"), [("belt-press", ["critical"]), ("band-saw", ["resonance", "comparison"])]
)
def test_what_the_bound_does_not_cover_is_said_where_something_is_left_out(scene_of, loaded, name, parts):
    tree = loaded(name).document.data
    named, whole = (solve_scene(scene_of(**tree | {"effects": one})) for one in (tree["effects"], "all"))
    assert named.plan.left_out
    assert named.to_dict()["beyond_bound"] == parts
    assert whole.to_dict()["beyond_bound"] == []
    said, nothing = (as_text(solution_sections(one, one.to_dict())) for one in (named, whole))
    assert "not bounded, but of the effects simulated" in said
    assert "not bounded" not in nothing
    assert ("torsion is left out: none of its frequencies stand here" in said) == (name == "band-saw")
