"""The effects a belt press may be simulated with, and how much each can matter at most."""

from collections.abc import Callable
from dataclasses import replace

from ropefric.registry import Registry
from ropefric.systems.effect import Effect
from ropefric.systems.press.answer import PressModel
from ropefric.systems.press.influence import influence_of, of_start_up, without_gravity, without_squeeze
from ropefric.systems.press.problem import PressProblem
from ropefric.systems.press.response import Parts
from ropefric.systems.press.transient.ingredients import Ingredients

__all__ = ["EFFECTS", "bare"]

Needs = Callable[[PressProblem], tuple[str, ...]]
Apply = Callable[[PressModel, PressProblem], PressModel]


def bare(problem: PressProblem) -> PressModel:
    """Return the model without any effect: unloaded belts without mass, locked tensioners, one coefficient."""
    return PressModel(
        press=without_squeeze(without_gravity(problem.press)),
        closure=problem.closure,
        friction=problem.friction,
        told=frozenset(),
        speed_m_s=problem.speed_m_s,
        preload_N=problem.preload_N,
        load_factor=problem.load_factor,
        parts=Parts(),
        ingredients=Ingredients(
            arc_inertia=False, belt_damping=False, tensioner_damping=False, centrifugal=False
        ),
    )


def _nothing(problem: PressProblem) -> tuple[str, ...]:  # noqa: ARG001  (the signature of `needs`)
    return ()


def _elastic_belts(problem: PressProblem) -> tuple[str, ...]:
    missing = []
    for belt in problem.press.belts:
        if belt.axial_stiffness_N is None:
            missing.append(f"belts.{belt.name}.axial_stiffness")
        if belt.span_lengths_m is None:
            missing.append(f"belts.{belt.name}.span_lengths")
    return tuple(missing)


def _start_up(problem: PressProblem) -> tuple[str, ...]:
    return () if problem.start_up is not None else ("start_up",)


def _moving_masses(problem: PressProblem) -> tuple[str, ...]:
    # What a start-up needs besides is no news to somebody who asks for none.
    if problem.start_up is None:
        return _start_up(problem)
    missing = [*_elastic_belts(problem)]
    for roller in problem.press.rollers:
        if roller.inertia_kg_m2 is None and roller.role != "driver":
            missing.append(f"rollers.{roller.name}.inertia")
        if roller.tensioner is not None and roller.tensioner.mass_kg is None:
            missing.append(f"rollers.{roller.name}.tensioner.mass")
    return tuple(missing)


def _a_tensioner(problem: PressProblem) -> tuple[str, ...]:
    return () if problem.press.tensioners else ("rollers.NAME.tensioner",)


def _load(model: PressModel, problem: PressProblem, torque: str) -> PressModel:
    own = {roller.name: getattr(roller, torque) for roller in problem.press.rollers}
    rollers = tuple(replace(roller, **{torque: own[roller.name]}) for roller in model.press.rollers)
    return replace(model, press=replace(model.press, rollers=rollers))


def _weigh(model: PressModel, problem: PressProblem) -> PressModel:
    return _load(model, problem, "gravity_torque_N_m")


def _squeeze(model: PressModel, problem: PressProblem) -> PressModel:
    return _load(model, problem, "squeeze_torque_N_m")


def _circle(model: PressModel, problem: PressProblem) -> PressModel:  # noqa: ARG001  (the signature of `apply`)
    moving = replace(model.ingredients, centrifugal=True)
    return replace(model, parts=replace(model.parts, mass=True), ingredients=moving)


def _spring(model: PressModel, problem: PressProblem) -> PressModel:  # noqa: ARG001  (the signature of `apply`)
    return replace(model, parts=replace(model.parts, springs=True))


def _stretch(model: PressModel, problem: PressProblem) -> PressModel:  # noqa: ARG001  (the signature of `apply`)
    return replace(model, parts=replace(model.parts, stretch=True))


def _told(*what: str) -> Apply:
    def apply(model: PressModel, problem: PressProblem) -> PressModel:  # noqa: ARG001  (the signature of `apply`)
        return replace(model, told=model.told | set(what))

    return apply


def _with(ingredient: str) -> Apply:
    def apply(model: PressModel, problem: PressProblem) -> PressModel:  # noqa: ARG001  (the signature of `apply`)
        return replace(model, ingredients=replace(model.ingredients, **{ingredient: True}))

    return apply


def _run_up(model: PressModel, problem: PressProblem) -> PressModel:
    return replace(model, start_up=problem.start_up)


def _steady(
    name: str, adds: str, instead: str, *, apply: Apply, needs: Needs = _nothing
) -> Effect[PressProblem, PressModel]:
    return Effect(
        name=name,
        adds=adds,
        instead=instead,
        needs=needs,
        influence=influence_of(name),
        apply=apply,
        cost=0.05,
    )


def _moving(
    name: str, adds: str, instead: str, *, apply: Apply, cost: float
) -> Effect[PressProblem, PressModel]:
    return Effect(
        name=name,
        adds=adds,
        instead=instead,
        needs=_moving_masses,
        influence=of_start_up,
        apply=apply,
        cost=cost,
    )


EFFECTS: Registry[Effect[PressProblem, PressModel]] = Registry(
    "effect of a press",
    (
        _steady(
            "gravity-load", "the drag of the sludge's weight, eq. (6)", "no drag of weight", apply=_weigh
        ),
        _steady(
            "squeeze-load",
            "the work of squeezing the cake, eq. (9)",
            "rollers that do not squeeze",
            apply=_squeeze,
        ),
        _steady(
            "belt-inertia",
            "the tension rho A v^2 that keeps the running belts on their path, eq. (39)",
            "belts without mass",
            apply=_circle,
        ),
        _steady(
            "tensioner-spring",
            "tensioners that give way on their springs when the belts run",
            "tensioners locked where they stand at rest",
            apply=_spring,
            needs=_a_tensioner,
        ),
        _steady(
            "belt-elasticity",
            "belts that stretch by their EA",
            "belts that do not stretch",
            apply=_stretch,
            needs=_elastic_belts,
        ),
        _steady(
            "wrap-dependence",
            "a coefficient that depends on wrap and slack-side tension",
            "its average at the reference wrap and tension",
            apply=_told("wrap", "end-tension"),
        ),
        _steady(
            "size",
            "a coefficient that depends on the roller's radius over half the belt's thickness",
            "the coefficient at the reference radius",
            apply=_told("size"),
        ),
        _moving(
            "belt-damping",
            "the material damping of the belts",
            "belts that do not damp",
            apply=_with("belt_damping"),
            cost=0.1,
        ),
        _moving(
            "tensioner-damping",
            "the dampers of the tensioners",
            "tensioners without dampers",
            apply=_with("tensioner_damping"),
            cost=0.1,
        ),
        _moving(
            "arc-inertia",
            "the mass of the belts on the rollers",
            "belts without mass on the rollers (slip then cannot be simulated)",
            apply=_with("arc_inertia"),
            cost=0.1,
        ),
        _moving(
            "transient",
            "the start-up, with its swings and slips",
            "the steady run alone",
            apply=_run_up,
            cost=100.0,
        ),
    ),
)
"""In the order in which they are applied."""
