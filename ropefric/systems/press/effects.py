"""The effects a belt press may be simulated with, and how much each can matter at most.

Tensions are linear: each load, the preload and the speed have their own share, got by one small linear solution each.
So the tensions of every subset of effects are sums of the same few columns, and the largest change that an effect
makes among all subsets bounds it. What is bounded is |ΔT'| of each span over its T' with everything in, |ΔU| of each
roller over the largest U with everything in, and |ΔP| of the drivers over their P; leaving out several effects adds
their bounds up at most.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import SolverError
from ropefric.registry import Registry
from ropefric.systems.bound import worst_case
from ropefric.systems.effect import Effect, Method, System
from ropefric.systems.press.answer import PressAnswer, PressModel, PressProblem, solve_press
from ropefric.systems.press.machine import Press
from ropefric.systems.press.slip import contacts_of, utilisation
from ropefric.systems.press.statics import solve_statics, span_density_kg_m
from ropefric.systems.press.steady import Parts, drive_power_W, speed_shift_kg_m
from ropefric.systems.press.transient.ingredients import Ingredients
from ropefric.systems.spread import Rule

_RULES: dict[str, Rule] = {
    "speed_m_s": "zero or more",
    "preload_N": "zero or more",
    "load_factor": "zero or more",
}


STEADY = (
    "gravity-load",
    "squeeze-load",
    "belt-inertia",
    "tensioner-spring",
    "belt-elasticity",
    "wrap-dependence",
    "size",
)
"""The effects that act on a steady run, in the order of the bits of a subset."""

_TOLD = {"wrap-dependence": frozenset({"wrap", "end-tension"}), "size": frozenset({"size"})}
_ROUNDING = 1e-9


def without_gravity(press: Press) -> Press:
    """Return a press whose rollers do not feel the weight of the sludge."""
    return replace(press, rollers=tuple(replace(roller, gravity_torque_N_m=0.0) for roller in press.rollers))


def without_squeeze(press: Press) -> Press:
    """Return a press that does not squeeze."""
    return replace(press, rollers=tuple(replace(roller, squeeze_torque_N_m=0.0) for roller in press.rollers))


def influence_of(name: str) -> Callable[[PressProblem], float]:
    """Return the `influence` of one effect of a steady run.

    A start-up swings about the steady run, and no bound is known for how far.
    """
    return worst_case(
        lambda problem: np.array([_largest_change(name, problem)]),
        rounding=_ROUNDING,
        possible=lambda problem: problem.start_up is None or _is_idle(name, problem),
    )


def of_start_up(problem: PressProblem) -> float:
    """Return the `influence` of an effect that only a start-up has: not known where there is one."""
    return 0.0 if problem.start_up is None else math.inf


def _is_idle(name: str, problem: PressProblem) -> bool:
    """Return whether a law does not look at what the effect would tell it."""
    return name in _TOLD and not problem.friction.law.effects


def _largest_change(name: str, problem: PressProblem) -> float:
    names = _applicable(problem)
    if name not in names:
        return 0.0
    corners = _corners(problem)
    axis = names.index(name)
    by_span = np.abs(np.diff(corners.tension_N, axis=axis)) / corners.tension_N[(-1,) * len(names)]
    use = np.abs(np.diff(corners.utilisation, axis=axis))
    largest_use = corners.utilisation[(-1,) * len(names)].max(axis=-1, keepdims=True)
    by_roller = np.divide(
        use, np.broadcast_to(largest_use, use.shape), out=np.zeros_like(use), where=use > 0.0
    )
    return max(float(by_span.max()), float(by_roller.max()), _share_of_pull(name, problem.press))


def _share_of_pull(name: str, press: Press) -> float:
    """Return a load's share of the pull Σ M/R of all loads, and so of the drivers' power."""
    torque = {"gravity-load": "gravity_torque_N_m", "squeeze-load": "squeeze_torque_N_m"}.get(name)
    if torque is None:
        return 0.0
    own_N = sum(getattr(roller, torque) / roller.radius_m for roller in press.rollers)
    total_N = sum(roller.torque_N_m / roller.radius_m for roller in press.rollers)
    if own_N == 0.0:
        return 0.0
    return abs(own_N / total_N) if total_N else math.inf


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Corners:
    """Tensions and slip of every subset of effects: one axis of length 2 an effect, then points, then members."""

    tension_N: FloatArray
    utilisation: FloatArray


@lru_cache(maxsize=4)
def _corners(problem: PressProblem) -> _Corners:
    """Return all subsets at once; the bounds of all effects are read off the same table."""
    names = _applicable(problem)
    shares = _shares(problem)
    tension_N = np.empty((2,) * len(names) + shares.base_N.shape)
    for subset in product((0, 1), repeat=len(names)):
        chosen = {name for name, flag in zip(names, subset, strict=True) if flag}
        tension_N[subset] = shares.tension_N(chosen)
    if not (tension_N > 0.0).all():
        raise SolverError("a span goes slack without some of the effects")
    return _Corners(tension_N=tension_N, utilisation=_utilisation(problem, names, tension_N))


def _utilisation(problem: PressProblem, names: list[str], tension_N: FloatArray) -> FloatArray:
    """Return U of every subset; one evaluation of the law for each set of what it is told."""
    telling = [name for name in names if name in _TOLD]
    found = np.empty((*tension_N.shape[:-1], len(problem.press.rollers)))
    for flags in product((0, 1), repeat=len(telling)):
        told = frozenset[str]().union(
            *(_TOLD[name] for name, flag in zip(telling, flags, strict=True) if flag)
        )
        place = tuple(flags[telling.index(name)] if name in telling else slice(None) for name in names)
        found[place] = utilisation(contacts_of(problem.press, tension_N[place]), problem.friction, told=told)
    return found


def _applicable(problem: PressProblem) -> list[str]:
    """Return the effects that can change something at all; the others halve the number of subsets each."""
    names = ["gravity-load", "squeeze-load"]
    if problem.speed_m_s.any():
        names.append("belt-inertia")
        if problem.press.tensioners:
            names.append("tensioner-spring")
        if _stretches(problem.press):
            names.append("belt-elasticity")
    if "wrap-dependence" in problem.friction.law.effects or "end-tension" in problem.friction.law.effects:
        names.append("wrap-dependence")
    if "size" in problem.friction.law.effects:
        names.append("size")
    if "offset" in problem.friction.law.effects:
        names.append("wrap-dependence")
    return list(dict.fromkeys(names))


def _stretches(press: Press) -> bool:
    return all(belt.axial_stiffness_N is not None and belt.span_lengths_m is not None for belt in press.belts)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Shares:
    """The columns of which the tensions of every subset are sums, shape (n or 1, n_spans)."""

    base_N: FloatArray
    loads_N: dict[str, FloatArray]
    speed_N: dict[tuple[bool, bool], FloatArray]

    def tension_N(self, names: set[str]) -> FloatArray:
        """Return T' with the named effects in."""
        total = self.base_N + sum(share for load, share in self.loads_N.items() if load in names)
        if "belt-inertia" in names:
            total = total + self.speed_N["tensioner-spring" in names, "belt-elasticity" in names]
        return total


def _shares(problem: PressProblem) -> _Shares:
    press = problem.press
    statics = solve_statics(without_squeeze(press), closure=problem.closure)
    by_squeeze = solve_statics(without_gravity(press), closure=problem.closure)
    preloads = (
        np.array([part.tensioner.force_N for part in press.tensioners if part.tensioner is not None])
        if problem.preload_N is None
        else np.repeat(problem.preload_N[:, np.newaxis], len(press.tensioners), axis=1)
    )
    load = problem.load_factor[:, np.newaxis]
    squared = problem.speed_m_s[:, np.newaxis] ** 2
    locked = squared * -span_density_kg_m(press)
    elastic = squared * speed_shift_kg_m(statics, "elastic") if _stretches(press) else locked
    base_N = np.atleast_2d(statics.given_N + preloads @ statics.by_preload.T)
    return _Shares(
        base_N=np.broadcast_to(base_N, locked.shape),
        loads_N={"gravity-load": load * statics.by_load_N, "squeeze-load": load * by_squeeze.by_load_N},
        speed_N={
            (False, False): locked,
            (False, True): locked,
            (True, False): np.zeros_like(locked),
            (True, True): elastic,
        },
    )


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


_DIRECT = Method(
    name="direct solution",
    error=1e-11,
    why="the balances are linear; one small system of equations gives all tensions",
)
_EXACT = Method(
    name="direct solution and matrix exponential",
    error=1e-7,
    why="between two changes of a contact the start-up is linear, and its exponential is exact for any step",
)


def _method(model: PressModel, budget: float) -> Method:  # noqa: ARG001  (the signature of `System.method`)
    if model.start_up is None:
        return _DIRECT
    task = model.start_up
    if task.integrator == "exact":
        return _EXACT
    return Method(
        name=f"direct solution and {task.integrator}",
        settings={"tolerance": task.settings.tolerance}
        | ({} if task.settings.step_s is None else {"step_s": task.settings.step_s}),
        error=np.inf,
        why="asked for by name; its error is not bounded beforehand",
    )


def _solve(model: PressModel, method: Method) -> PressAnswer:  # noqa: ARG001  (the signature of `System.solve`)
    return solve_press(model)


def _distance(answer: PressAnswer, reference: PressAnswer) -> float:
    found = [
        _relative(answer.state.effective_tension_N, reference.state.effective_tension_N),
        _of_largest(answer.slip.utilisation, reference.slip.utilisation),
        _of_largest(*(drive_power_W(one.state)[..., np.newaxis] for one in (answer, reference))),
    ]
    if reference.start_up is not None:
        if answer.start_up is None:
            return np.inf
        found.append(
            _relative(answer.start_up.tension_N.max(axis=0), reference.start_up.tension_N.max(axis=0))
        )
        if answer.start_up.utilisation is not None and reference.start_up.utilisation is not None:
            found.append(
                _of_largest(
                    answer.start_up.utilisation.max(axis=0), reference.start_up.utilisation.max(axis=0)
                )
            )
    return max(found)


def _relative(values: FloatArray, reference: FloatArray) -> float:
    return float(np.max(np.abs(values / reference - 1.0)))


def _of_largest(values: FloatArray, reference: FloatArray) -> float:
    """Return the largest difference, as a share of the largest reference: a roller without torque has none itself."""
    largest = np.max(np.abs(reference), axis=-1, keepdims=True)
    difference = np.abs(values - reference)
    share = np.divide(difference, largest, out=np.zeros_like(difference), where=difference > 0.0)
    return float(np.max(share))


SYSTEM: System[PressProblem, PressModel, PressAnswer] = System(
    name="press", effects=EFFECTS, bare=bare, method=_method, solve=_solve, distance=_distance
)
"""Rollers and belts."""
