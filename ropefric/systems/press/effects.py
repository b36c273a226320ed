"""The effects a belt press may be simulated with, and how far two answers with some of them are apart."""

import re
from functools import partial

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.registry import Registry
from ropefric.systems.effect import Effect, Method, System, law_effects
from ropefric.systems.press.answer import PressAnswer, PressModel, PressProblem, solve_press
from ropefric.systems.press.slip import MEASURES
from ropefric.systems.press.transient.start_up import largest_difference

_UNIT = re.compile("_(?:N|m|kg|kg_m2)$")


def _lacking(problem: PressProblem, *, masses: bool = False, part: str = "") -> tuple[str, ...]:
    """Return the missing keys for belts that stretch and for moving parts, by their names in scenes, without units."""
    fields = problem.press.missing_elasticity + (problem.press.missing_masses if masses else [])
    return tuple(_UNIT.sub("", field) for field in fields if part in field)


def _needs_of_start_up(problem: PressProblem) -> tuple[str, ...]:
    # What a start-up needs besides is no news to somebody who asks for none.
    return ("start_up",) if problem.start_up is None else _lacking(problem, masses=True)


def _moving(name: str, adds: str, instead: str, cost: float = 0.1) -> Effect:
    """Return an effect that only a start-up has."""
    return Effect(name, adds, instead, cost=cost, needs=_needs_of_start_up)


EFFECTS: Registry[Effect] = Registry(
    "effect of a press",
    (
        Effect("gravity-load", "the drag of the sludge's weight, eq. (6)", "no drag of weight"),
        Effect("squeeze-load", "the work of squeezing the cake, eq. (9)", "rollers that do not squeeze"),
        Effect(
            "belt-inertia",
            "the tension rho A v^2 that keeps the running belts on their path, eq. (39)",
            "belts without mass",
        ),
        Effect(
            "tensioner-spring",
            "tensioners that give way on their springs when the belts run",
            "tensioners locked where they stand at rest",
            needs=lambda problem: () if problem.press.tensioners else ("rollers.NAME.tensioner",),
        ),
        Effect(
            "belt-elasticity",
            "belts that stretch by their EA",
            "belts that do not stretch; between fixed centres they keep their length with EA",
            needs=_lacking,
        ),
        Effect(
            "elastic-creep",
            "belts that are strained by T/EA, so that driven rollers run slower than the drivers and power is lost",
            "rims that all run at the speed of the drivers",
            needs=partial(_lacking, part="axial_stiffness"),
        ),
        *law_effects("roller", "belt"),
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
            cost=1.0,
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
    error=1e-4,
    why="between two changes of a contact the start-up is linear, and its exponential is exact for any step",
)


_FOLLOWING_ERROR = 1e-3
"""Where friction follows the tensions along tangents."""


def _method(model: PressModel, budget: float) -> Method:  # noqa: ARG001  (the signature of `System.method`)
    if model.start_up is None:
        return _DIRECT
    follows = "transient-friction" in model.effects and model.problem.friction.follows_tension
    return _EXACT._replace(error=_FOLLOWING_ERROR) if follows else _EXACT


_ROUNDING = 1e-12
"""Of the largest number of a kind, or of one: what rounding leaves of zero, no share of which means anything."""


def _numbers(answer: PressAnswer) -> list[FloatArray]:
    tensions_N = (answer.state.effective_tension_N, answer.at_rest_N)
    return [
        *tensions_N,
        *(getattr(answer.slip, name) for name in MEASURES),
        answer.state.drive_power_W,
        answer.rim_speed_m_s,
    ]


def _distance(answer: PressAnswer, reference: PressAnswer, whole: PressAnswer) -> float:
    found = [
        _largest_share(*three)
        for three in zip(_numbers(answer), _numbers(reference), _numbers(whole), strict=True)
    ]
    moved, other = answer.start_up, reference.start_up
    if other is not None:
        found.append(np.inf if moved is None else largest_difference(moved, other))
    return max(found)


def _largest_share(one: FloatArray, other: FloatArray, whole: FloatArray) -> float:
    """Return the largest change of any number, as a share of that number with everything in."""
    finite = np.where(np.isfinite(whole), np.abs(whole), 0.0)
    noise = _ROUNDING * float(finite.max(initial=1.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.abs(one - other)
        same = (change <= noise) | (one == other) | (np.isnan(one) & np.isnan(other))
        share = np.where(same, 0.0, change / np.abs(whole))
    return float(np.where(np.isnan(share), np.inf, share).max(initial=0.0))


SYSTEM: System = System(
    name="press",
    effects=EFFECTS,
    model=PressModel,
    method=_method,
    solve=lambda model, method: solve_press(model),  # noqa: ARG005  (the model says which)
    distance=_distance,
)
"""Rollers and belts."""
