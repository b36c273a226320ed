"""A plan leaves out what it can afford to, never evaluates what it left out, and keeps its promise."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from promise import costly

from ropefric.errors import DataError, InputError
from ropefric.registry import Registry
from ropefric.scenes.plan import make_plan
from ropefric.scenes.solve import solve_scene
from ropefric.systems.checks import Cases, Positive, ZeroOrMore
from ropefric.systems.effect import Effect, Method, Model, System, assemble, closed_form_system, missing
from ropefric.systems.hoist.effects import SYSTEM


def toy(bounds, method_error=0.0):
    """A system whose answer is the product of e^bound of the effects in it."""
    effects = [
        Effect(
            name=name,
            adds="",
            instead="nothing",
            cost=0.1,
            needs=lambda problem: (),
            influence=lambda problem, bound=bound: bound,
        )
        for name, bound in bounds.items()
    ]
    return System(
        name="toy",
        effects=Registry("effect", effects),
        model=Model,
        method=lambda model, budget: Method(
            name="m", settings={"budget": budget}, error=method_error, why=""
        ),
        solve=lambda model, method: math.exp(sum(bounds[name] for name in model.effects)),
        distance=lambda answer, reference, whole: abs(answer / reference - 1.0),
    )


def planned(bounds, accuracy, effects="auto", **options):
    return make_plan(toy(bounds, **options), None, accuracy=accuracy, effects=effects)[0]


def test_the_smallest_effects_go_first_and_their_sum_stays_in_the_budget():
    plan = planned({"a": 0.004, "b": 0.02, "c": 0.003, "d": 0.003}, 0.01)
    assert plan.left_out == (
        "c",
        "d",
    )  # all three would be 0.01 together, more than nine tenths of the accuracy
    assert plan.error_bound == pytest.approx(math.expm1(0.006))


def test_an_effect_of_no_influence_is_left_out_whatever_the_accuracy():
    plan = planned({"a": 0.0, "b": 1e-15}, 1e-300)
    assert plan.left_out == ("a",)


def test_an_effect_without_known_bound_is_never_left_out_by_itself():
    plan = planned({"a": math.inf, "b": 0.1}, 1.0)
    assert plan.simulated == ("a",)
    assert planned({"a": math.inf}, 1.0, effects=()).error_bound == math.inf


def test_the_method_gets_what_the_effects_left_of_the_budget():
    plan = planned({"a": 0.004, "b": 0.02}, 0.01)
    assert plan.method.settings["budget"] == pytest.approx((0.01 - math.expm1(0.004)) / math.exp(0.004))
    assert planned({"a": 0.02}, 0.01).method.settings["budget"] == pytest.approx(0.01)


def test_the_methods_own_error_is_part_of_the_bound():
    plan = planned({"a": 0.004}, 0.01, method_error=0.001)
    assert plan.error_bound == pytest.approx(math.expm1(0.004) + 0.001 * math.exp(0.004))


def test_named_effects_are_simulated_and_the_others_bound_the_error():
    plan = planned({"a": 0.5, "b": 0.1}, 0.01, effects=("b",))
    assert plan.simulated == ("b",)
    assert plan.error_bound == pytest.approx(math.expm1(0.5))
    assert not plan.keeps_accuracy


@pytest.mark.parametrize("name", ["hoist", "traction", "belt-drive"])
def test_a_closed_form_is_solved_whole_and_no_bound_of_it_is_searched(loaded, name):
    def fail(problem):
        raise AssertionError("searched for a bound")

    scene = loaded(name)
    system = scene.kind.system
    effects = [effect._replace(influence=fail) for effect in system.effects.values()]
    quick = system._replace(effects=Registry("effect", effects))
    plan, _ = make_plan(quick, scene.problem, accuracy=0.5, effects="auto")
    assert plan.simulated == make_plan(quick, scene.problem, accuracy=0.5, effects="all")[0].simulated
    assert plan.error_bound <= 1e-11


@pytest.mark.parametrize("accuracy", [0.3, 0.1, 0.03, 0.01, 1e-4, 1e-8])
def test_the_promise_would_hold_for_hoists_whose_effects_are_left_out(loaded, accuracy):
    planning = costly(SYSTEM)
    for name in ("hoist", "climbing-hoist", "small-wheel", "many-turns"):
        scene = loaded(name)
        plan, model = make_plan(planning, scene.problem, accuracy=accuracy, effects="auto")
        everything, full = make_plan(SYSTEM, scene.problem, accuracy=accuracy, effects="all")
        difference = SYSTEM.distance(
            SYSTEM.solve(model, plan.method), SYSTEM.solve(full, everything.method), None
        )
        assert difference <= min(accuracy, plan.error_bound), name


def test_what_is_left_out_is_not_evaluated(loaded):
    scene = loaded("climbing-hoist")
    planning = costly(SYSTEM)
    plan, model = make_plan(planning, scene.problem, accuracy=0.5, effects="auto")
    assert {"rope-weight", "centrifugal"} <= set(plan.left_out)
    answer = SYSTEM.solve(model, plan.method)
    other = replace(scene.problem, speed_m_s=np.array([3.0]), hanging_length_m=np.array([60.0]))
    again = SYSTEM.solve(assemble(SYSTEM, other, plan.simulated), plan.method)
    assert again.log_lift == answer.log_lift
    whole = SYSTEM.solve(assemble(SYSTEM, other, [*plan.simulated, *plan.left_out]), plan.method)
    assert whole.log_lift != answer.log_lift


def test_an_effect_is_added_by_one_declaration():
    """Beside what the mechanics do with it: planner, bounds and sums know it from its registry alone."""

    @dataclass(frozen=True, kw_only=True, eq=False)
    class Pull(Cases):
        force_N: Positive
        wind_N: ZeroOrMore | None = None

    @dataclass(frozen=True)
    class Answer:
        logs: np.ndarray

    def solve(model):
        return Answer(np.log(model.problem.force_N + model.part("wind", model.problem.wind_N))[np.newaxis])

    wind = Effect(
        name="wind", adds="the wind", instead="still air", needs=missing({"wind_N": "wind.force"}), cost=0.1
    )
    system = closed_form_system("pull", Registry("effect", [wind]), solve, error=0.0, why="")
    windy = Pull(force_N=100.0, wind_N=2.0)
    plan, model = make_plan(system, windy, accuracy=0.05, effects="auto")
    assert plan.left_out == ("wind",)
    assert plan.error_bound == pytest.approx(0.02)
    assert math.exp(system.solve(model, plan.method).logs[0, 0]) == pytest.approx(100.0)
    fine, model = make_plan(system, windy, accuracy=0.01, effects="auto")
    assert fine.simulated == ("wind",)
    assert math.exp(system.solve(model, fine.method).logs[0, 0]) == pytest.approx(102.0)
    calm = make_plan(system, Pull(force_N=100.0), accuracy=0.01, effects="all")[0]
    assert calm.decisions[0].why == "the scene does not give wind.force"


def test_a_named_effect_without_its_data_names_the_key(hoist_of):
    with pytest.raises(
        InputError, match=r"bending-stiffness cannot be simulated without rope\.bending_stiffness"
    ):
        make_plan(SYSTEM, hoist_of().problem, accuracy=0.01, effects=("bending-stiffness",))
    with pytest.raises(DataError, match=r"effects.*rope\.bending_stiffness"):
        solve_scene(hoist_of(effects=["bending-stiffness"]))


def test_all_is_every_applicable_effect(hoist_of):
    scene = hoist_of(effects="all")
    solution = solve_scene(scene)
    assert solution.plan.simulated == ("wrap-dependence", "size", "end-tension", "centrifugal")
    assert solution.plan.left_out == ()
    assert solution.plan.error_bound <= 1e-11
