"""A scene solved: the answer, its uncertainty, and what was simulated for it."""

import math
from dataclasses import dataclass, replace
from typing import Any

from ropefric.errors import InputError, RopefricError
from ropefric.fitting.predict import REGRESSORS, outside_range
from ropefric.friction.condition import Conditions
from ropefric.scenes.jsonable import finite, method_tree
from ropefric.scenes.plan import Plan, make_plan
from ropefric.scenes.scene import Scene, placed
from ropefric.scenes.uncertainty import Uncertain, carry_through, known
from ropefric.systems.effect import assemble


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solution:
    """The answer to a scene.

    Attributes
    ----------
    scene : Scene
        What was asked.
    plan : Plan
        What was simulated, and how.
    answer : object
        Of the scene's system.
    quantities : tuple of Uncertain
        The numbers that people read.
    level : float
        Of the intervals.
    extrapolation : tuple of str
        In which respects the friction is used outside what it was tested for.
    """

    scene: Scene
    plan: Plan
    answer: Any
    quantities: tuple[Uncertain, ...]
    level: float
    extrapolation: tuple[str, ...]

    @property
    def failures(self) -> tuple[str, ...]:
        """Return what the machine does not do, however well that is known: a hoist that does not lift."""
        found = self.scene.kind.failures(self.answer, self.scene.problem)
        return tuple(one.text() for one in found if one.fails.any())

    @property
    def stands(self) -> bool:
        """Return whether the friction is supported, the accuracy kept, and the machine does what it is for."""
        source = self.scene.source
        return self.plan.keeps_accuracy and not self.failures and (source is None or not source.warnings)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return what speaks against using the answer, or the machine."""
        source = self.scene.source
        own = (*self.failures, *(() if source is None else source.warnings))
        beyond = tuple(f"extrapolated: {words}" for words in self.extrapolation)
        if self.plan.keeps_accuracy:
            return (*own, *beyond)
        bound = "not known" if math.isinf(self.plan.error_bound) else f"up to {self.plan.error_bound:.2g}"
        source_of_it = f"leaving out {', '.join(self.plan.left_out)}"
        if not self.plan.left_out or self.plan.method.error > self.plan.accuracy:
            source_of_it = f"the method ({self.plan.method.name})"
        found = f"the error of {source_of_it} is {bound}, more than the accuracy of {self.plan.accuracy:g}"
        return (*own, *beyond, found)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON shape; numbers without a finite value are null."""
        kind, plan = self.scene.kind, self.plan
        tree = {"system": kind.name, **kind.tree(self.answer, self.scene.problem)}
        for quantity in self.quantities:
            _put(tree, quantity)
        tree["level"] = self.level
        tree["extrapolated"] = bool(self.extrapolation)
        tree["effects"] = {
            "simulated": list(plan.simulated),
            "left_out": list(plan.left_out),
            "not_applicable": [one.name for one in plan.decisions if one.fate == "not applicable"],
        }
        tree["accuracy"] = plan.accuracy
        tree["error_bound"] = finite(plan.error_bound)
        tree["method"] = method_tree(plan.method)
        tree["friction"] = None if self.scene.source is None else self.scene.source.origin
        tree["failures"] = list(self.failures)
        tree["warnings"] = list(self.warnings)
        return tree


def _put(tree: dict[str, Any], quantity: Uncertain) -> None:
    """Put a number at its place: "slip.2.utilisation" goes under slip, under "2"."""
    *path, name = quantity.name.split(".")
    place = tree
    for part in path:
        place = place.setdefault(part, {})
    place[name] = finite(quantity.value[0])
    if len(quantity.std) and quantity.std[0] == 0.0:
        return
    stem = name.removesuffix("_N") if name.endswith("_N") else name
    unit = "_N" if stem != name else ""
    # The main answer has the contract's bare names; the others carry their own.
    prefix = "" if name == "lift_force_N" else f"{stem}_"
    place[f"{prefix}std{unit}"] = finite(quantity.std[0])
    place[f"{prefix}interval{unit}"] = [finite(end) for end in quantity.interval[0]]


def solve_scene(scene: Scene, *, level: float = 0.95) -> Solution:
    """Return the answer to a scene."""
    if not 0.0 < level < 1.0:
        raise InputError(
            f"the level is {level:g}", key="level", fix="give a level between 0 and 1, such as 0.95"
        )
    try:
        plan, model = make_plan(
            scene.kind.system, scene.problem, accuracy=scene.accuracy, effects=scene.effects
        )
        answer = scene.kind.system.solve(model, plan.method)
        quantities = scene.kind.quantities(answer, scene.problem)
        uncertain = (
            tuple(known(quantity) for quantity in quantities)
            if scene.source is None
            else carry_through(
                scene.source, lambda friction: _again(scene, plan, friction), quantities, level=level
            )
        )
    except RopefricError as error:
        raise placed(error, scene.document) from error
    return Solution(
        scene=scene,
        plan=plan,
        answer=answer,
        quantities=uncertain,
        level=level,
        extrapolation=_extrapolation(scene),
    )


def _again(scene: Scene, plan: Plan, friction: Any) -> Any:
    problem = replace(scene.problem, friction=friction)
    model = assemble(scene.kind.system, problem, plan.simulated)
    return scene.kind.quantities(scene.kind.system.solve(model, plan.method), problem)


def _extrapolation(scene: Scene) -> tuple[str, ...]:
    """Return one sentence for each regressor that leaves the tested range anywhere."""
    source = scene.source
    if source is None or source.tested is None:
        return ()
    contacts = Conditions(**scene.kind.contacts(scene.problem))
    outside = outside_range(source.tested, contacts)
    words = []
    for column, (name, (what, unit, factor)) in enumerate(REGRESSORS.items()):
        if outside[:, column].any():
            found = factor * getattr(contacts, name)[outside[:, column]]
            low, high = (factor * end for end in source.tested[name])
            words.append(
                f"{what} {_span(found.min(), found.max())} {unit} is outside the tested {_span(low, high)} {unit}"
            )
    return tuple(words)


def _span(low: float, high: float) -> str:
    return f"{low:.4g}" if f"{low:.4g}" == f"{high:.4g}" else f"{low:.4g}–{high:.4g}"
