"""A plan leaves out what it can afford to, never evaluates what it left out, and keeps its promise."""

import math
from dataclasses import replace

import pytest
from promise import costly

from ropefric.errors import DataError, InputError
from ropefric.registry import Registry
from ropefric.scenes.plan import make_plan
from ropefric.scenes.solve import solve_scene
from ropefric.systems.effect import Effect, Method, System, assemble
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
            apply=lambda model, problem, bound=bound: model + bound,
        )
        for name, bound in bounds.items()
    ]
    return System(
        name="toy",
        effects=Registry("effect", effects),
        bare=lambda problem: 0.0,
        method=lambda model, budget: Method(
            name="m", settings={"budget": budget}, error=method_error, why=""
        ),
        solve=lambda model, method: math.exp(model),
        distance=lambda answer, reference: abs(answer / reference - 1.0),
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
    effects = [replace(effect, influence=fail) for effect in system.effects.values()]
    quick = replace(system, effects=Registry("effect", effects))
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


def failing(system, names):
    """The system with the functions of some effects replaced by ones that fail."""

    def fail(*arguments):
        raise AssertionError("evaluated what was left out")

    effects = [
        replace(effect, apply=fail) if name in names else effect for name, effect in system.effects.items()
    ]
    return replace(system, effects=Registry("effect", effects))


def test_what_is_left_out_is_not_evaluated(loaded):
    scene = loaded("climbing-hoist")
    planning = costly(SYSTEM)
    plan, _ = make_plan(planning, scene.problem, accuracy=0.5, effects="auto")
    assert plan.left_out, plan.simulated
    broken = failing(planning, plan.left_out)
    again, model = make_plan(broken, scene.problem, accuracy=0.5, effects="auto")
    assert repr(again) == repr(plan), "a worth may be NaN, which equals nothing"
    assert broken.solve(model, again.method).log_lift > 0.0
    with pytest.raises(AssertionError, match="left out"):
        assemble(broken, scene.problem, [*plan.simulated, plan.left_out[0]])


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
