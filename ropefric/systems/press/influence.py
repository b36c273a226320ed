"""How much each effect of a press can change tensions and slip at most, before slip is solved for.

Tensions are linear: each load, the preload and the speed have their own share, got by one small linear solution each.
So the tensions of every subset of effects are sums of the same few columns, and the largest change that an effect
makes among all subsets bounds it. What is bounded is |ΔT'| of each span over its T' with everything in, and |ΔU| of
each roller over the largest U with everything in; leaving out several effects adds their bounds up at most.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ropefric.errors import RopefricError
from ropefric.friction.condition import FloatArray
from ropefric.systems.press.contact import contacts_of
from ropefric.systems.press.equations import span_density_kg_m
from ropefric.systems.press.machine import Press
from ropefric.systems.press.problem import PressProblem
from ropefric.systems.press.slip import utilisation
from ropefric.systems.press.speed import speed_shift_kg_m
from ropefric.systems.press.statics import solve_statics

__all__ = ["STEADY", "influence_of", "of_start_up", "without_gravity", "without_squeeze"]

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
    """Return the `influence` of one effect of a steady run."""

    def influence(problem: PressProblem) -> float:
        if problem.start_up is not None and not _is_idle(name, problem):
            # A start-up swings about the steady run; no bound is known for how far.
            return math.inf
        try:
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                worst = _largest_change(name, problem)
        except RopefricError:
            return math.inf
        if math.isnan(worst):
            return math.inf
        return worst * (1.0 + _ROUNDING) + (1e-12 if worst > 0.0 else 0.0)

    return influence


def of_start_up(problem: PressProblem) -> float:
    """Return the `influence` of an effect that only a start-up has: not known where there is one."""
    return 0.0 if problem.start_up is None else math.inf


def _is_idle(name: str, problem: PressProblem) -> bool:
    """Return whether a law does not look at what the effect would tell it."""
    return name in _TOLD and not problem.friction.law.effects


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Corner:
    """One subset of effects: its tensions and its slip."""

    tension_N: FloatArray
    utilisation: FloatArray


def _largest_change(name: str, problem: PressProblem) -> float:
    applicable = _applicable(problem)
    if name not in applicable:
        return 0.0
    shares = _Shares.of(problem)
    others = [one for one in applicable if one != name]
    full = shares.corner(problem, frozenset(applicable))
    if not (full.tension_N > 0.0).all():
        return math.inf
    largest_use = full.utilisation.max(axis=-1, keepdims=True)
    worst = 0.0
    for chosen in product((False, True), repeat=len(others)):
        rest = frozenset(one for one, wanted in zip(others, chosen, strict=True) if wanted)
        with_it, without = shares.corner(problem, rest | {name}), shares.corner(problem, rest)
        if not ((with_it.tension_N > 0.0).all() and (without.tension_N > 0.0).all()):
            return math.inf
        by_span = np.max(np.abs(with_it.tension_N - without.tension_N) / full.tension_N)
        use = np.abs(with_it.utilisation - without.utilisation)
        by_roller = np.max(np.divide(use, largest_use, out=np.zeros_like(use), where=use > 0.0))
        worst = max(worst, float(by_span), float(by_roller))
    return worst


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

    @classmethod
    def of(cls, problem: PressProblem) -> "_Shares":
        press = problem.press
        by_gravity = solve_statics(without_squeeze(press), closure=problem.closure)
        by_squeeze = solve_statics(without_gravity(press), closure=problem.closure)
        statics = by_gravity
        preloads = (
            np.array([part.tensioner.force_N for part in press.tensioners if part.tensioner is not None])
            if problem.preload_N is None
            else np.repeat(problem.preload_N[:, np.newaxis], len(press.tensioners), axis=1)
        )
        load = problem.load_factor[:, np.newaxis]
        squared = problem.speed_m_s[:, np.newaxis] ** 2
        locked = squared * -span_density_kg_m(press)
        elastic = squared * speed_shift_kg_m(statics, "elastic") if _stretches(press) else locked
        return cls(
            base_N=np.atleast_2d(statics.given_N + preloads @ statics.by_preload.T),
            loads_N={
                "gravity-load": load * by_gravity.by_load_N,
                "squeeze-load": load * by_squeeze.by_load_N,
            },
            speed_N={
                (False, False): locked,
                (False, True): locked,
                (True, False): np.zeros_like(locked),
                (True, True): elastic,
            },
        )

    def corner(self, problem: PressProblem, names: frozenset[str]) -> _Corner:
        tension_N = self.base_N + sum(
            (share for load, share in self.loads_N.items() if load in names), np.zeros(1)
        )
        if "belt-inertia" in names:
            tension_N = tension_N + self.speed_N["tensioner-spring" in names, "belt-elasticity" in names]
        told = frozenset[str]().union(*(_TOLD[name] for name in names if name in _TOLD))
        contacts = contacts_of(problem.press, tension_N)
        return _Corner(tension_N=tension_N, utilisation=utilisation(contacts, problem.friction, told=told))
