"""A plan leaves out what it can afford to, never evaluates what it left out, and keeps its promise."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from ropefric.errors import DataError, InputError
from ropefric.registry import Registry
from ropefric.scenes.plan import make_plan
from ropefric.scenes.solve import solve_scene
from ropefric.systems.checks import Cases, Positive, ZeroOrMore
from ropefric.systems.effect import Effect, Method, Model, System, closed_form_system, missing
from ropefric.systems.hoist.effects import SYSTEM


def toy(bounds, method_error=0.0):
    """A system whose answer is the product of e^bound of the effects in it."""
    effects = [Effect(name=name, adds="", instead="nothing", cost=0.1, needs=lambda problem: (),
                      bound=lambda problem, answer, bound=bound: np.array([bound]))
               for name, bound in bounds.items()]  # fmt: skip
    return System(name="toy", effects=Registry("effect", effects), model=Model,
                  method=lambda model, budget: Method(
                      name="m", settings={"budget": budget}, error=method_error, why=""
                  ),
                  solve=lambda model, method: math.exp(sum(bounds[name] for name in model.effects)),
                  distance=lambda answer, reference, whole: abs(answer / reference - 1.0))  # fmt: skip


def planned(bounds, accuracy, effects="auto", **options):
    return make_plan(toy(bounds, **options), None, accuracy=accuracy, effects=effects)[0]


@pytest.mark.parametrize(
    ("bounds", "accuracy", "left_out", "error", "budget"),
    [
        # All three small ones would be 0.01 together, more than nine tenths of the accuracy.
        ({"a": 0.004, "b": 0.02, "c": 0.003, "d": 0.003}, 0.01, ("c", "d"), 0.006, None),
        ({"a": 0.004, "b": 0.02}, 0.01, ("a",), 0.004, (0.01 - math.expm1(0.004)) / math.exp(0.004)),
        ({"a": 0.02}, 0.01, (), 0.0, 0.01),
        ({"a": 0.0, "b": 1e-15}, 1e-300, ("a",), 0.0, None),
        ({"a": math.inf, "b": 0.1}, 1.0, ("b",), 0.1, None),
    ],
)
def test_the_smallest_effects_go_first_and_the_method_gets_what_they_leave(
    bounds, accuracy, left_out, error, budget
):
    plan = planned(bounds, accuracy)
    assert plan.left_out == left_out
    assert plan.error_bound == pytest.approx(math.expm1(error), rel=1e-12)
    assert budget is None or plan.method.settings["budget"] == pytest.approx(budget)


def test_a_list_has_no_bound_before_it_is_solved_and_the_methods_error_is_part_of_a_bound():
    assert planned({"a": 0.1}, 1.0, effects=()).error_bound == math.inf
    plan = planned({"a": 0.004}, 0.01, method_error=0.001)
    assert plan.error_bound == pytest.approx(math.expm1(0.004) + 0.001 * math.exp(0.004))


def test_what_has_no_bound_is_simulated_whatever_it_costs():
    system = toy({"a": 0.001})
    plain = Registry("effect", [one._replace(bound=None) for one in system.effects.values()])
    plan, _ = make_plan(system._replace(effects=plain), None, accuracy=0.5, effects="auto")
    assert plan.simulated == ("a",)
    assert math.isnan(plan.decisions[0].bound)


def test_what_is_quick_is_solved_whole_at_any_accuracy(loaded):
    for name in (
        "hoist",
        "climbing-hoist",
        "traction",
        "belt-drive",
        "fast-belt-press",
        "cable-pull",
        "tendon",
    ):
        scene = loaded(name)
        plan, _ = make_plan(scene.kind.system, scene.problem, accuracy=0.5, effects="auto")
        assert plan.left_out == (), name
        assert plan.error_bound <= 1e-11, name


def test_a_list_is_as_far_from_everything_as_it_is_found_to_be(loaded, scene_of):
    """What is quick is simulated to know it; what is dear and has a bound, the blade's stiffness, is not."""
    tree = loaded("climbing-hoist").document.data
    listed, whole = (solve_scene(scene_of(**tree | {"effects": one})) for one in (["size"], "all"))
    off = abs(listed.answer.lift_force_N[0] / whole.answer.lift_force_N[0] - 1.0)
    assert off <= listed.plan.error_bound
    assert listed.plan.error_bound > 0.1
    assert not listed.plan.keeps_accuracy
    saw = solve_scene(loaded("band-saw"))
    assert saw.plan.left_out == ("bending", "torsion")
    assert 0.07 < saw.plan.error_bound < 0.2
    started = loaded("press-start-up").document.data | {"effects": ["gravity-load"]}
    assert math.isinf(solve_scene(scene_of(**started)).plan.error_bound), "dear, and without a bound"


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

    def bound(problem, answer):
        return np.log1p(problem.wind_N / problem.force_N)

    wind = Effect(name="wind", adds="the wind", instead="still air", bound=bound,
                  needs=missing({"wind_N": "wind.force"}), cost=0.1)  # fmt: skip
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
    with pytest.raises(InputError, match=r"bending-stiffness cannot .* without rope\.bending_stiffness"):
        make_plan(SYSTEM, hoist_of().problem, accuracy=0.01, effects=("bending-stiffness",))
    with pytest.raises(DataError, match=r"effects.*rope\.bending_stiffness"):
        solve_scene(hoist_of(effects=["bending-stiffness"]))
