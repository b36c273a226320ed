"""The effects a belt press may be simulated with, and how much each can matter at most.

Tensions are linear: each load, the preload and the speed have their own share, got by one small linear solution each.
So the tensions of every subset of effects are sums of the same few columns, and the largest change that an effect
makes among all subsets bounds it. What is bounded is |ΔT'| of each span over its T' with everything in, |ΔU| of each
roller over the largest U with everything in, |ΔP| of the drivers over their P, and |Δv| of each rim over the largest v
with everything in; leaving out several effects adds their bounds up at most.
"""

import math
import re
from collections.abc import Callable, Iterable
from functools import lru_cache
from itertools import product

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import SolverError
from ropefric.registry import Registry
from ropefric.systems.effect import Effect, Method, System, worst_case
from ropefric.systems.friction import TOLD, told_by
from ropefric.systems.press.answer import (
    LOADS,
    PressAnswer,
    PressModel,
    PressProblem,
    solve_press,
    without_load,
)
from ropefric.systems.press.creep import rim_speed_ratios
from ropefric.systems.press.machine import missing_elasticity, missing_masses
from ropefric.systems.press.slip import contacts_of, utilisation
from ropefric.systems.press.statics import solve_statics, span_density_kg_m
from ropefric.systems.press.steady import Parts, drive_power_W, speed_shift_kg_m

_ROUNDING = 1e-9


def _largest_change(name: str, problem: PressProblem) -> float:
    names = _applicable(problem)
    whole = (-1,) * len(names)
    if name == "elastic-creep":  # tensions and slip know nothing of it
        pace = _corners(problem)[2]
        return float((np.abs(pace - 1.0) / pace[whole].max(axis=-1, keepdims=True)).max())
    if name not in names:
        return 0.0
    tension_N, use, pace = _corners(problem)
    axis = names.index(name)
    by_span = np.abs(np.diff(tension_N, axis=axis)) / tension_N[whole]
    change = np.abs(np.diff(use, axis=axis))
    largest = np.broadcast_to(use[whole].max(axis=-1, keepdims=True), change.shape)
    by_roller = np.divide(change, largest, out=np.zeros_like(change), where=change > 0.0)
    by_rim = np.abs(np.diff(pace, axis=axis)) / pace[whole].max(axis=-1, keepdims=True)
    found = (float(one.max()) for one in (by_span, by_roller, by_rim))
    return max(*found, _share_of_pull(name, problem))


def _share_of_pull(name: str, problem: PressProblem) -> float:
    """Return a load's share of the pull Σ M/R of all loads, and so of the drivers' power."""
    if name not in LOADS:
        return 0.0
    rollers = problem.press.rollers
    own_N = sum(getattr(roller, LOADS[name]) / roller.radius_m for roller in rollers)
    total_N = sum(roller.torque_N_m / roller.radius_m for roller in rollers)
    if own_N == 0.0:
        return 0.0
    return abs(own_N / total_N) if total_N else math.inf


@lru_cache(maxsize=4)
def _corners(problem: PressProblem) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return T', U and the rims' pace of every subset of effects: an axis of length 2 each, then points, then places.

    The bounds of all effects are read off the same table.
    """
    names, press = _applicable(problem), problem.press
    statics = solve_statics(without_load(press, "squeeze-load"), closure=problem.closure)
    by_squeeze = solve_statics(without_load(press, "gravity-load"), closure=problem.closure)
    preloads = np.array([[part.force_N for part in press.take_ups]])
    if problem.preload_N is not None:
        preloads = np.repeat(problem.preload_N[:, np.newaxis], len(press.take_ups), axis=1)
    load, squared = problem.load_factor[:, np.newaxis], problem.speed_m_s[:, np.newaxis] ** 2
    base_N = statics.given_N + preloads @ statics.by_preload.T + 0.0 * squared
    loads_N = {"gravity-load": load * statics.by_load_N, "squeeze-load": load * by_squeeze.by_load_N}
    shift = {"locked": squared * speed_shift_kg_m(statics, "locked")}
    if not missing_elasticity(press):
        shift["elastic"] = squared * speed_shift_kg_m(statics, "elastic")
    tension_N = np.empty((2,) * len(names) + base_N.shape)
    for subset in product((0, 1), repeat=len(names)):
        chosen = {name for name, flag in zip(names, subset, strict=True) if flag}
        parts = Parts(
            mass="belt-inertia" in chosen,
            springs="tensioner-spring" in chosen,
            stretch="belt-elasticity" in chosen,
        )
        tension_N[subset] = base_N + sum(share for name, share in loads_N.items() if name in chosen)
        if not parts.keeps_tension:
            tension_N[subset] += shift[parts.tensioner]
    if not (tension_N > 0.0).all():
        raise SolverError("a span goes slack without some of the effects")
    # One evaluation of the law for each set of what it is told.
    use = np.empty((*tension_N.shape[:-1], len(press.rollers)))
    telling = [name for name in names if name in TOLD]
    for flags in product((0, 1), repeat=len(telling)):
        told = told_by([name for name, flag in zip(telling, flags, strict=True) if flag])
        place = tuple(flags[telling.index(name)] if name in telling else slice(None) for name in names)
        use[place] = utilisation(contacts_of(press, tension_N[place]), problem.friction, told=told)
    whole_N = tension_N.copy()
    if "belt-inertia" in names:
        whole_N[(slice(None),) * names.index("belt-inertia") + (1,)] += squared * span_density_kg_m(press)
    return tension_N, use, rim_speed_ratios(press, whole_N)


def _applicable(problem: PressProblem) -> list[str]:
    """Return the effects that can change something at all; the others halve the number of subsets each."""
    names = ["gravity-load", "squeeze-load"]
    if problem.speed_m_s.any():
        names.append("belt-inertia")
        if problem.press.tensioners:
            names.append("tensioner-spring")
        if not missing_elasticity(problem.press):
            names.append("belt-elasticity")
    looked_at = set(problem.friction.law.effects)
    if looked_at & {"wrap-dependence", "end-tension", "offset"}:
        names.append("wrap-dependence")
    if "size" in looked_at:
        names.append("size")
    return names


def _steady(
    name: str,
    adds: str,
    instead: str,
    needs: Callable[[PressProblem], tuple[str, ...]] = lambda problem: (),  # noqa: ARG005
) -> Effect[PressProblem, PressModel]:
    """Return an effect on a steady run. A start-up swings about that, and no bound is known for how far."""

    def is_bounded(problem: PressProblem) -> bool:
        unseen = name in TOLD and not problem.friction.law.effects  # by a law that looks at nothing
        return problem.start_up is None or unseen

    influence = worst_case(
        lambda problem: np.array([_largest_change(name, problem)]), rounding=_ROUNDING, possible=is_bounded
    )
    return Effect(name=name, adds=adds, instead=instead, needs=needs, influence=influence, cost=0.05)


def _moving(name: str, adds: str, instead: str, *, cost: float = 0.1) -> Effect[PressProblem, PressModel]:
    """Return an effect that only a start-up has; no bound is known where there is one."""
    return Effect(
        name=name,
        adds=adds,
        instead=instead,
        needs=_needs_of_start_up,
        influence=lambda problem: 0.0 if problem.start_up is None else math.inf,
        cost=cost,
    )


_UNIT = re.compile("_(?:N|m|kg|kg_m2)$")


def _scene_keys(fields: Iterable[str]) -> tuple[str, ...]:
    """Return fields as scenes call them: without the units."""
    return tuple(_UNIT.sub("", field) for field in fields)


def _needs_of_start_up(problem: PressProblem) -> tuple[str, ...]:
    # What a start-up needs besides is no news to somebody who asks for none.
    if problem.start_up is None:
        return ("start_up",)
    return _scene_keys([*missing_elasticity(problem.press), *missing_masses(problem.press)])


EFFECTS: Registry[Effect[PressProblem, PressModel]] = Registry(
    "effect of a press",
    (
        _steady("gravity-load", "the drag of the sludge's weight, eq. (6)", "no drag of weight"),
        _steady("squeeze-load", "the work of squeezing the cake, eq. (9)", "rollers that do not squeeze"),
        _steady(
            "belt-inertia",
            "the tension rho A v^2 that keeps the running belts on their path, eq. (39)",
            "belts without mass",
        ),
        _steady(
            "tensioner-spring",
            "tensioners that give way on their springs when the belts run",
            "tensioners locked where they stand at rest",
            lambda problem: () if problem.press.tensioners else ("rollers.NAME.tensioner",),
        ),
        _steady(
            "belt-elasticity",
            "belts that stretch by their EA",
            "belts that do not stretch",
            lambda problem: _scene_keys(missing_elasticity(problem.press)),
        ),
        _steady(
            "elastic-creep",
            "belts that are strained by T/EA, so that driven rollers run slower than the drivers and power is lost",
            "rims that all run at the speed of the drivers",
            lambda problem: _scene_keys(
                key for key in missing_elasticity(problem.press) if "axial_stiffness" in key
            ),
        ),
        _steady(
            "wrap-dependence",
            "a coefficient that depends on wrap and slack-side tension",
            "its average at the reference wrap and tension",
        ),
        _steady(
            "size",
            "a coefficient that depends on the roller's radius over half the belt's thickness",
            "the coefficient at the reference radius",
        ),
        _moving("belt-damping", "the material damping of the belts", "belts that do not damp"),
        _moving("tensioner-damping", "the dampers of the tensioners", "tensioners without dampers"),
        _moving(
            "arc-inertia",
            "the mass of the belts on the rollers",
            "belts without mass on the rollers (slip then cannot be simulated)",
        ),
        _moving("transient", "the start-up, with its swings and slips", "the steady run alone", cost=100.0),
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


def _distance(answer: PressAnswer, reference: PressAnswer) -> float:
    found = [
        _relative(answer.state.effective_tension_N, reference.state.effective_tension_N),
        _of_largest(answer.slip.utilisation, reference.slip.utilisation),
        _of_largest(*(drive_power_W(one.state)[..., np.newaxis] for one in (answer, reference))),
        _of_largest(answer.rim_speed_m_s, reference.rim_speed_m_s),
    ]
    moved, other = answer.start_up, reference.start_up
    if other is not None:
        if moved is None:
            return np.inf
        found.append(_relative(moved.tension_N.max(axis=0), other.tension_N.max(axis=0)))
        if moved.utilisation is not None and other.utilisation is not None:
            found.append(_of_largest(moved.utilisation.max(axis=0), other.utilisation.max(axis=0)))
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
    name="press",
    effects=EFFECTS,
    bare=lambda problem: PressModel(problem=problem),
    method=_method,
    solve=lambda model, method: solve_press(model),  # noqa: ARG005  (the model says which)
    distance=_distance,
)
"""Rollers and belts."""
