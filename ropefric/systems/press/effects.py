"""The effects a belt press may be simulated with, and how much each can matter at most.

Tensions are linear: each load, the preload and the speed have their own share, got by one small linear solution each.
So the tensions of every subset of effects are sums of the same few columns, and the largest change that an effect
makes among all subsets bounds it. What is bounded is |ΔT'| of each span over its T' with everything in, at rest, too,
|ΔU| of each roller over the largest U with everything in, and so for the other measures of slip, |ΔP| of the drivers
over their P, and |Δv| of each rim over the largest v with everything in; leaving out several effects adds their bounds
up at most.
"""

import math
import re
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache, partial
from itertools import compress, product

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError, SolverError
from ropefric.registry import Registry
from ropefric.systems.effect import (
    Effect,
    Method,
    System,
    applicable,
    law_bound,
    rounded_up,
    unknown,
)
from ropefric.systems.friction import TOLD, WrapFriction, told_by
from ropefric.systems.press.answer import (
    FAST_ERROR,
    QUICKER,
    PressAnswer,
    PressModel,
    PressProblem,
    operated,
    solve_press,
    swinging_of,
    swings,
    take_up,
)
from ropefric.systems.press.slip import LEAST_SLACK_N, MEASURES, Contacts, SlipTable, contacts_of
from ropefric.systems.press.statics import rim_speed_ratios, solve_statics, speed_shift_kg_m
from ropefric.systems.press.transient.modes import SwingingStartUp
from ropefric.systems.press.transient.start_up import GRID_ERROR, ON_TENSION, largest_difference

_ROUNDING = 1e-9
_LOADS = {"gravity-load": "gravity_torque_N_m", "squeeze-load": "squeeze_torque_N_m"}
"""The torque of a roller that each effect is about."""


def _largest_change(name: str, problem: PressProblem) -> float:
    names = _applicable(problem)
    if name not in (*names, "elastic-creep"):
        return 0.0
    tensions_N, uses, pace = _corners(problem)
    whole = (-1,) * len(names)
    fastest = pace[whole].max(axis=-1, keepdims=True)
    if name == "elastic-creep":  # tensions and slip know nothing of it
        return float((np.abs(pace - 1.0) / fastest).max())
    axis = names.index(name)
    changes = (
        *(np.abs(np.diff(one, axis=axis)) / one[whole] for one in tensions_N),
        *(_share_of_largest(np.abs(np.diff(use, axis=axis)), use[whole]) for use in uses),
        np.abs(np.diff(pace, axis=axis)) / fastest,
    )
    return max(*(float(one.max()) for one in changes), _share_of_pull(name, problem))


def _share_of_largest(change: FloatArray, reference: FloatArray) -> FloatArray:
    """Return a change as a share of the largest reference: a roller without torque has none of its own."""
    largest = np.broadcast_to(np.abs(reference).max(axis=-1, keepdims=True), change.shape)
    return np.asarray(np.divide(change, largest, out=np.zeros_like(change), where=change > 0.0))


def _share_of_pull(name: str, problem: PressProblem) -> float:
    """Return a load's share of the pull Σ M/R of all loads, and so of the drivers' power."""
    if name not in _LOADS:
        return 0.0
    own_N = sum(getattr(roller, _LOADS[name]) / roller.radius_m for roller in problem.press.rollers)
    total_N = float(problem.press.rim_load_N.sum())
    return own_N and (abs(own_N / total_N) if total_N else math.inf)


@lru_cache(maxsize=4)
def _corners(problem: PressProblem) -> tuple[tuple[FloatArray, FloatArray], list[FloatArray], FloatArray]:
    """Return T' at speed and at rest, the measures of slip and the rims' pace of every subset of effects.

    Each has an axis of length 2 for every effect, then points, then places.

    The bounds of all effects are read off the same table.
    """
    names, press = _applicable(problem), problem.press
    statics, by_squeeze = (
        solve_statics(operated(press, **{load: 0.0}), closure=problem.closure)
        for load in ("squeeze", "gravity")
    )
    load, squared = problem.load_factor[:, np.newaxis], problem.speed_m_s[:, np.newaxis] ** 2
    forces_N = np.array([[part.force_N for part in press.tensioners.values()]])
    if problem.preload_N is not None:
        forces_N = np.repeat(problem.preload_N[:, np.newaxis], forces_N.size, axis=1)
    base_N = statics.given_N + forces_N @ statics.by_preload.T + 0.0 * squared
    loads_N = {"gravity-load": load * statics.by_load_N, "squeeze-load": load * by_squeeze.by_load_N}
    subsets = [set(compress(names, flags)) for flags in product((0, 1), repeat=len(names))]
    shifts = {state: squared * speed_shift_kg_m(statics, state) for state in set(map(take_up, subsets))}
    still = [base_N + sum(share for name, share in loads_N.items() if name in chosen) for chosen in subsets]
    running = [one + shifts[take_up(chosen)] for one, chosen in zip(still, subsets, strict=True)]
    still_N, tension_N = (np.array(one).reshape((2,) * len(names) + base_N.shape) for one in (still, running))
    if not (tension_N > 0.0).all():
        raise SolverError("a span goes slack without some of the effects")
    # One evaluation of the law for each set of what it is told.
    uses = [np.empty((*tension_N.shape[:-1], len(press.rollers))) for _ in MEASURES]
    telling = [name for name in names if name in TOLD]
    for flags in product((0, 1), repeat=len(telling)):
        told = told_by([*compress(telling, flags)])
        place = tuple(flags[telling.index(name)] if name in telling else slice(None) for name in names)
        slip = SlipTable(press, tension_N[place], problem.friction, told=told)
        for use, measure in zip(uses, MEASURES, strict=True):
            use[place] = getattr(slip, measure)
    whole_N = tension_N.copy()
    if "belt-inertia" in names:
        whole_N[(slice(None),) * names.index("belt-inertia") + (1,)] += squared * press.density_kg_m
    return (tension_N, still_N), uses, rim_speed_ratios(press, whole_N)


def _applicable(problem: PressProblem) -> list[str]:
    """Return the effects that can change something at all; the others halve the number of subsets each."""
    names = ["gravity-load", "squeeze-load"]
    if problem.speed_m_s.any():
        names.append("belt-inertia")
        if problem.press.tensioners:
            names.append("tensioner-spring")
        if not problem.press.missing_elasticity:
            names.append("belt-elasticity")
    looked_at = set(problem.friction.law.effects)
    if looked_at & ON_TENSION:
        names.append("wrap-dependence")
    if "size" in looked_at:
        names.append("size")
    return names


def _steady(
    name: str,
    adds: str,
    instead: str,
    needs: Callable[[PressProblem], tuple[str, ...]] = lambda problem: (),  # noqa: ARG005
    *,
    cost: float = 0.0,
) -> Effect:
    """Return an effect on a steady run; only those of the law cost time. How far a start-up swings has no bound."""

    def influence(problem: PressProblem) -> float:
        unseen = name in TOLD and not problem.friction.law.effects  # by a law that looks at nothing
        if problem.start_up is not None and not unseen:
            return math.inf
        try:
            # Where a corner overflows or has no number, what it gives is no bound.
            with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
                return rounded_up(_largest_change(name, problem), _ROUNDING)
        except RopefricError:
            return math.inf

    each = partial(law_bound, name, _law_bound) if cost else None
    return Effect(name, adds, instead, needs=needs, influence=influence, cost=cost, each=each)


def _law_bound(problem: PressProblem, answer: PressAnswer | None) -> FloatArray:
    """Return an upper bound of what all that the law is not told changes in any number.

    Without an answer the tensions are not known, only which roller the law is told of.
    """
    if answer is not None:
        return _law_change(problem.friction, answer.slip)
    if problem.friction.theta.ndim > 1:
        return np.zeros(1)
    still_N = np.zeros(len(problem.press.spans))
    own_N = problem.friction.reference.end_tension_N
    return np.asarray(
        _spread(problem.friction, contacts_of(problem.press, still_N), own_N).max(keepdims=True)
    )


@lru_cache(maxsize=1)
def _law_change(friction: WrapFriction, slip: SlipTable) -> FloatArray:
    """Return that bound, reckoned once for all effects of the law.

    The tensions know nothing of it. A coefficient that changes by the factor e^d makes M another by M (e^d − 1) on each
    roller, and e^M − 1 by d more than that in its logarithm: what any measure of slip is inverse to, or less.
    """
    off = _spread(friction, slip.contacts, np.maximum(slip.contacts.slack_N, LEAST_SLACK_N))
    change = off + np.exp(off) * slip.exponent * np.expm1(off)
    return np.asarray(change.max(axis=-1))


def _spread(friction: WrapFriction, contacts: Contacts, slack_N: FloatArray) -> FloatArray:
    """Return by what factor, in logarithms, the coefficient changes at most on each roller in all cases.

    Where each case has parameters of its own it is in each case on all rollers: that is quicker than the law itself.
    """
    told = (contacts.radius_m, contacts.half_thickness_m, contacts.wrap_angle_rad, slack_N)
    axis = friction.theta.ndim - 1
    ranges = ((one.min(axis=axis), one.max(axis=axis)) for one in map(np.atleast_2d, told))
    names = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "slack_tension_N")
    off = friction.spread(**dict(zip(names, ranges, strict=True)))
    return off[:, np.newaxis] if axis else off


def _moving(
    name: str,
    adds: str,
    instead: str,
    *,
    bound: Callable[[PressProblem], float] = unknown,
    detail: Callable[[PressProblem], str] | None = None,
    cost: float = 0.1,
) -> Effect:
    """Return an effect that only a start-up has; of most no bound is known where there is one."""

    def influence(problem: PressProblem) -> float:
        return 0.0 if problem.start_up is None else bound(problem)

    return Effect(name, adds, instead, detail, influence, cost=cost, needs=_needs_of_start_up)


def _on_tension(problem: PressProblem) -> bool:
    return bool(ON_TENSION & set(problem.friction.law.effects))


def _sticking(problem: PressProblem) -> SwingingStartUp | None:
    with suppress(RopefricError):  # a start-up that has no answer says so where it is solved
        return swinging_of(problem, frozenset(applicable(EFFECTS, problem)))
    return None


def _swings_left_out(problem: PressProblem, *names: str) -> float:
    """Return what a start-up whose belts stick is off by at most with the swings of these modes left out."""
    swinging = _sticking(problem)
    return math.inf if swinging is None else swinging.bound(~swings(swinging, QUICKER - {*names}))


def _without_fast(problem: PressProblem) -> float:
    # Where nothing is said of swings, neither is there a difference of two of them.
    return _swings_left_out(problem, "fast-modes") - min(_swings_left_out(problem), 1.0)


def _without_slow(problem: PressProblem) -> float:
    without_fast = min(_swings_left_out(problem, "fast-modes"), 1.0)
    return _swings_left_out(problem, "fast-modes", "slow-modes") - without_fast


def _which_swing(problem: PressProblem) -> str:
    swinging = _sticking(problem)
    if swinging is None:
        return ""
    belts = swinging.rigid_belts(FAST_ERROR)
    told = f"{swinging.fewest(FAST_ERROR)} of {swinging.n_modes} modes swing"
    return told + (f", belt {' and '.join(belts)} as good as rigid" if belts else "")


_UNIT = re.compile("_(?:N|m|kg|kg_m2)$")


def _lacking(problem: PressProblem, *, masses: bool = False, part: str = "") -> tuple[str, ...]:
    """Return what is missing for belts that stretch, and for what moves, as scenes call it: without the units."""
    fields = problem.press.missing_elasticity + (problem.press.missing_masses if masses else [])
    return tuple(_UNIT.sub("", field) for field in fields if part in field)


def _needs_of_start_up(problem: PressProblem) -> tuple[str, ...]:
    # What a start-up needs besides is no news to somebody who asks for none.
    return ("start_up",) if problem.start_up is None else _lacking(problem, masses=True)


EFFECTS: Registry[Effect] = Registry(
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
        _steady("belt-elasticity", "belts that stretch by their EA", "belts that do not stretch", _lacking),
        _steady(
            "elastic-creep",
            "belts that are strained by T/EA, so that driven rollers run slower than the drivers and power is lost",
            "rims that all run at the speed of the drivers",
            partial(_lacking, part="axial_stiffness"),
        ),
        _steady(
            "wrap-dependence",
            "a coefficient that depends on wrap and slack-side tension",
            "its average at the reference wrap and tension",
            cost=1e-6,
        ),
        _steady(
            "size",
            "a coefficient that depends on the roller's radius over half the belt's thickness",
            "the coefficient at the reference radius",
            cost=5e-7,
        ),
        _moving("belt-damping", "the material damping of the belts", "belts that do not damp"),
        _moving("tensioner-damping", "the dampers of the tensioners", "tensioners without dampers"),
        _moving(
            "arc-inertia",
            "the mass of the belts on the rollers",
            "belts without mass on the rollers (slip then cannot be simulated)",
        ),
        _moving(
            "transient-friction",
            "friction that follows the tensions as they change",
            "friction as it is at standstill",
            bound=lambda problem: math.inf if _on_tension(problem) else 0.0,
            cost=1.0,
        ),
        _moving(
            "exact-switching",
            "belts that stick, slip and go slack, and drags that hold, each moment searched for with steps of its own",
            "the same moments met inside the steps of a grid",
            bound=lambda problem: min(GRID_ERROR, _swings_left_out(problem)),
            cost=10.0,
        ),
        _moving(
            "fast-modes",
            f"swings of the fastest modes, worth no more than {FAST_ERROR:g} in any tension together",
            "modes that follow the drive as if at rest",
            bound=_without_fast,
            detail=_which_swing,
        ),
        _moving(
            "slow-modes",
            "swings of all other modes",
            "no swings at all: a start-up that is quasi-static",
            bound=_without_slow,
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


_FOLLOWING_ERROR = 1e-3
"""Where friction follows the tensions along tangents."""


def _method(model: PressModel, budget: float) -> Method:  # noqa: ARG001  (the signature of `System.method`)
    task = model.start_up
    if task is None:
        return _DIRECT
    integrator = task.get("integrator", "exact")
    if integrator == "exact":
        follows = "transient-friction" in model.effects and _on_tension(model.problem)
        return _EXACT._replace(error=_FOLLOWING_ERROR) if follows else _EXACT
    return Method(
        name=f"direct solution and {integrator}",
        settings={name: task[name] for name in ("tolerance", "step_s") if task.get(name) is not None},
        error=np.inf,
        why="asked for by name; its error is not bounded beforehand",
    )


def _measure(name: str, answer: PressAnswer) -> FloatArray:
    # Where nothing is driven, utilisation is what rounding leaves of zero, and no share of that means anything.
    return np.asarray(np.round(getattr(answer.slip, name), 12))


def _distance(answer: PressAnswer, reference: PressAnswer, whole: PressAnswer) -> float:
    ones = (answer, reference, whole)

    def apart(read: Callable[[PressAnswer], FloatArray]) -> float:
        """Return the largest change of any of an answer's numbers, as a share of the largest."""
        values, others, all_in = map(read, ones)
        return float(_share_of_largest(np.abs(values - others), all_in).max())

    def tension_N(one: PressAnswer) -> FloatArray:
        return np.stack([one.state.effective_tension_N, one.at_rest_N])

    found = [
        float((np.abs(tension_N(answer) - tension_N(reference)) / tension_N(whole)).max()),
        *(apart(partial(_measure, name)) for name in MEASURES),
        apart(lambda one: one.state.drive_power_W[..., np.newaxis]),
        apart(lambda one: one.rim_speed_m_s),
    ]
    moved, other = answer.start_up, reference.start_up
    if other is not None:
        found.append(np.inf if moved is None else largest_difference(moved, other))
    return max(found)


SYSTEM: System = System(
    name="press",
    effects=EFFECTS,
    model=PressModel,
    method=_method,
    solve=lambda model, method: solve_press(model),  # noqa: ARG005  (the model says which)
    distance=_distance,
)
"""Rollers and belts."""
