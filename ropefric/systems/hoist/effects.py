"""The effects a rope on a wheel may be simulated with, and how much each can change the lift force at most.

Every bound holds for |ln F_A with the effect − ln F_A without it|, whatever other effects are in: what a law may get
to see of the end tension is one of eight values (with or without ρv², EI/(2R²) and the rope's weight), and what it is
told one of eight sets, so the largest change of M = ∫μ dφ over these corners bounds it. For the forces themselves it
is used that P e^M(P) grows with the pressing force P, and never faster than P, for every law whose coefficient does
not rise along the wrap, unless it is told the tension and not the wrap; what it may then do more is added.
"""

from collections.abc import Callable, Iterator
from functools import lru_cache
from itertools import product

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.registry import Registry
from ropefric.systems.effect import Effect, Method, System, missing, worst_case
from ropefric.systems.friction import EVERYTHING
from ropefric.systems.hoist.contact import HoistModel, HoistProblem, Lift, lifted_arc_rad, solve_lift

Bound = Callable[[HoistProblem], FloatArray]

# Bounds are sums and maxima of rounded numbers.
_ROUNDING = 1e-12


def _pressing_N(problem: HoistProblem, *, without: str = "") -> FloatArray:
    """Return F_B − c − E, with and without each of them and the weight, shape (k, 1, n)."""
    seen = [problem.end_tension_N]
    for name, part in _parts_N(problem).items():
        if part.any() and name != without:
            seen += [tension_N + part for tension_N in seen]
    return np.stack(seen)[:, np.newaxis]


def _parts_N(problem: HoistProblem) -> dict[str, FloatArray]:
    """Return what each effect adds to the force that presses [N]."""
    return {
        "centrifugal": -problem.circling_N,
        "bending-stiffness": -problem.bending_N,
        "rope-weight": problem.weight_N,
    }


def least_pressing_N(problem: HoistProblem) -> FloatArray:
    """Return what presses on the wheel at the slack end at least, F_B − c − E [N]."""
    return problem.end_tension_N - problem.circling_N - problem.bending_N


def _wraps(problem: HoistProblem) -> FloatArray:
    """Return the longest and the shortest contact there may be, shape (1 or 2, n)."""
    if problem.bending_stiffness_N_m2 is None:
        return problem.wrap_angle_rad[np.newaxis]
    return np.stack([problem.wrap_angle_rad, _shortest_contact(problem)])


@lru_cache(maxsize=16)
def _at_corners(problem: HoistProblem, told: frozenset[str]) -> FloatArray:
    """Return M at every corner, shape (k, 1 or 2, n); the bounds of all effects look at the same ones."""
    return _exponents(problem, told, _pressing_N(problem))


def _exponents(problem: HoistProblem, told: frozenset[str], pressing_N: FloatArray) -> FloatArray:
    """Return M for every contact and every force that presses, shape (k, 1 or 2, n)."""
    return problem.friction.exponent(
        wheel_radius_m=problem.wheel_radius_m,
        rope_radius_m=problem.rope_radius_m,
        wrap_angle_rad=_wraps(problem),
        slack_tension_N=pressing_N,
        told=told,
    )


def _lifted(problem: HoistProblem, pulled_by_N: FloatArray) -> FloatArray:
    """Return the two arcs by which the rope stands off at most, where F_B less ρv² is `pulled_by_N` [rad]."""
    return 2.0 * lifted_arc_rad(problem.bending_N, pulled_by_N)


def _shortest_contact(problem: HoistProblem) -> FloatArray:
    return problem.wrap_angle_rad - _lifted(problem, least_pressing_N(problem) + problem.bending_N)


def answerable(problem: HoistProblem) -> BoolArray:
    """Return for which of n cases there is an answer with all effects in, shape (n,).

    The rope has to press on the wheel and touch it, and the law to have an answer to what presses.

    Where it does not, nothing may be left out either.
    """
    pressing_N = least_pressing_N(problem)
    possible = pressing_N > 0.0
    if possible.any() and problem.bending_stiffness_N_m2 is not None:
        pulled_by_N = np.where(possible, pressing_N + problem.bending_N, np.inf)
        possible &= problem.wrap_angle_rad > _lifted(problem, pulled_by_N)
    if "end-tension" not in problem.friction.law.effects:
        return possible
    return possible & problem.friction.has_answer(
        wheel_radius_m=problem.wheel_radius_m,
        rope_radius_m=problem.rope_radius_m,
        wrap_angle_rad=problem.wrap_angle_rad,
        slack_tension_N=np.where(possible, pressing_N, 1.0),
    )


def bounded(bound: Bound) -> Callable[[HoistProblem], float]:
    """Return the `influence` of a bound: the largest of all cases, `inf` where law or rope have no answer."""
    return worst_case(bound, rounding=_ROUNDING, possible=lambda problem: bool(answerable(problem).all()))


def told_bound(what: str) -> Bound:
    """Return the bound of one thing a law may be told: the largest change of M, whatever else it is told."""

    def bound(problem: HoistProblem) -> FloatArray:
        worst = np.zeros(problem.n)
        for told in _subsets(EVERYTHING - {what}):
            with_it, without = _at_corners(problem, told | {what}), _at_corners(problem, told)
            at_ends = np.max(np.abs(with_it - without), axis=1)
            between = np.maximum(_bulge(problem, with_it), _bulge(problem, without))
            worst = np.maximum(worst, np.max(at_ends + between, axis=0))
        return np.asarray(worst * _feedback(problem))

    return bound


def _bulge(problem: HoistProblem, exponents: FloatArray) -> FloatArray:
    """Return by how much M may lie above the straight line from its shortest to its longest contact, shape (k, n).

    Along the wrap M grows, and ever slower: it lies below its longest contact's, and below the straight line from the
    origin through its shortest contact's. For a change of M in between to be larger than at both ends, one of the two
    that are compared must bulge.
    """
    wraps = _wraps(problem)
    if len(wraps) == 1:
        return np.zeros((len(exponents), problem.n))
    rise, lost = exponents[:, 0] - exponents[:, 1], wraps[0] - wraps[1]
    steepest = exponents[:, 1] / wraps[1] * lost
    share = np.divide(rise, steepest, out=np.ones_like(rise), where=steepest > 0.0)
    return np.asarray(np.maximum(rise * (1.0 - share), 0.0))


def _feedback(problem: HoistProblem) -> FloatArray:
    """Return the factor by which a stiff rope enlarges a change of the lift force, shape (n,).

    The arc by which it stands off at the tight end shrinks as the lift force grows, by √(e/(2 − e)) for each unit of
    its logarithm, e = E/F; what that adds to the contact adds to the lift force again.
    """
    if problem.bending_stiffness_N_m2 is None:
        return np.ones(problem.n)
    e = problem.bending_N / (least_pressing_N(problem) + problem.bending_N)
    gain = _steepest(problem) * np.sqrt(e / (2.0 - e))
    factor: FloatArray = np.divide(1.0, 1.0 - gain, out=np.full(problem.n, np.inf), where=gain < 1.0)
    return factor


def _subsets(names: frozenset[str]) -> Iterator[frozenset[str]]:
    for chosen in product((False, True), repeat=len(names)):
        yield frozenset(name for name, wanted in zip(sorted(names), chosen, strict=True) if wanted)


@lru_cache(maxsize=2)
def _steepest(problem: HoistProblem) -> FloatArray:
    """Return the largest ΔM/Δφ where the contact shortens, whatever the law is told, shape (n,)."""
    wraps = _wraps(problem)
    lost = wraps[0] - wraps[-1]
    worst = np.zeros(problem.n)
    for told in _subsets(EVERYTHING):
        exponents = _at_corners(problem, told)
        # A concave M is steeper near its start than over the lost arc; a law with an offset is not concave.
        average = np.max(exponents / wraps, axis=(0, 1))
        change = np.max(np.abs(exponents[:, 0] - exponents[:, -1]), axis=0)
        slope = np.divide(change, lost, out=np.zeros(problem.n), where=lost > 0.0)
        worst = np.maximum.reduce([worst, average, slope])
    return worst


def _excess(problem: HoistProblem, effect: str) -> FloatArray:
    """Return by how much M may fall faster than the pressing force rises, shape (n,).

    It cannot where a law is told both tension and wrap, or not the tension; told the tension alone, it takes the
    coefficient at the reference wrap for the whole wrap, and that can fall faster.
    """
    without_N = _pressing_N(problem, without=effect)
    with_N = without_N + _parts_N(problem)[effect]
    step = np.abs(np.log(with_N / without_N))
    worst = np.zeros(problem.n)
    for told in (frozenset({"end-tension"}), frozenset({"end-tension", "size"})):
        fall = np.abs(_exponents(problem, told, with_N) - _exponents(problem, told, without_N))
        worst = np.maximum(worst, np.max(fall - step, axis=(0, 1)))
    return worst


def centrifugal_bound(problem: HoistProblem) -> FloatArray:
    """Return −ln(1 − c/(F_B − E)), and what a stiff rope stands off further."""
    # P e^M(P) grows with P, by less than P itself, so F_A falls by less than what presses does.
    idle_N = problem.circling_N
    if not idle_N.any():
        return np.zeros(problem.n)
    left = problem.end_tension_N - problem.bending_N
    change = -np.log1p(-idle_N / left) + _excess(problem, "centrifugal")
    return _feedback(problem) * (
        change + _arc_change(problem, problem.end_tension_N - idle_N, problem.end_tension_N)
    )


def weight_bound(problem: HoistProblem) -> FloatArray:
    """Return ln(1 + w/P), and what a stiff rope stands off less."""
    heavy_N = problem.weight_N
    if not heavy_N.any():
        return np.zeros(problem.n)
    pulled_by_N = problem.end_tension_N - problem.circling_N
    change = np.log1p(heavy_N / least_pressing_N(problem)) + _excess(problem, "rope-weight")
    return _feedback(problem) * (change + _arc_change(problem, pulled_by_N, pulled_by_N + heavy_N))


def _arc_change(problem: HoistProblem, slacker_N: FloatArray, tighter_N: FloatArray) -> FloatArray:
    """Return by how much M may change because a stiff rope stands off further when it is pulled less."""
    if problem.bending_stiffness_N_m2 is None:
        return np.zeros(problem.n)
    return _steepest(problem) * (_lifted(problem, slacker_N) - _lifted(problem, tighter_N))


def bending_bound(problem: HoistProblem) -> FloatArray:
    """Return −ln(1 − E/(F_B − c)), and the friction of the arcs that are lost."""
    stiff_N = problem.bending_N
    if not stiff_N.any():
        return np.zeros(problem.n)
    pulled_by_N = problem.end_tension_N - problem.circling_N
    change = -np.log1p(-stiff_N / pulled_by_N) + _excess(problem, "bending-stiffness")
    return change + _steepest(problem) * _lifted(problem, pulled_by_N)


def _stiffness_needs(problem: HoistProblem) -> tuple[str, ...]:
    if "bending-stiffness" in problem.friction.law.effects:
        return ("friction.law (bending has the stiffness in it already)",)
    return missing({"bending_stiffness_N_m2": "rope.bending_stiffness"})(problem)


EFFECTS: Registry[Effect[HoistProblem, HoistModel]] = Registry(
    "effect of a hoist",
    (
        Effect(
            name="wrap-dependence",
            adds="a coefficient that depends on how far the rope wraps",
            instead="its average at the reference wrap, over the whole wrap",
            influence=bounded(told_bound("wrap")),
            cost=0.3,
        ),
        Effect(
            name="size",
            adds="a coefficient that depends on the wheel's radius over the rope's",
            instead="the coefficient at the reference wheel and rope",
            influence=bounded(told_bound("size")),
            cost=0.1,
        ),
        Effect(
            name="end-tension",
            adds="a coefficient that depends on the end tension (the wrap it stands for)",
            instead="the coefficient at the reference end tension",
            influence=bounded(told_bound("end-tension")),
            cost=0.3,
        ),
        Effect(
            name="rope-weight",
            adds="the weight of the rope that hangs from the slack side, on top of the end tension",
            instead="a rope without weight",
            needs=missing(
                {"linear_density_kg_m": "rope.linear_density", "hanging_length_m": "rope.hanging_length"}
            ),
            influence=bounded(weight_bound),
            cost=0.05,
        ),
        Effect(
            name="centrifugal",
            adds="the tension rho v^2 that keeps the running rope on its circle and presses nothing",
            instead="a rope at rest",
            needs=missing({"linear_density_kg_m": "rope.linear_density", "speed_m_s": "wheel.speed"}),
            influence=bounded(centrifugal_bound),
            cost=0.2,
        ),
        Effect(
            name="bending-stiffness",
            adds="the tension EI/(2 R^2) that bends the rope, and the arcs at both ends where it stands off",
            instead="a limp rope",
            needs=_stiffness_needs,
            influence=bounded(bending_bound),
            cost=5.0,
        ),
    ),
)
"""In the order in which they are applied."""


_CLOSED_FORM = Method(
    name="closed form",
    error=1e-12,
    why="the wrap integral and the end tension's root are exact to rounding; a coarser rule would save microseconds",
)


def _distance(answer: Lift, reference: Lift) -> float:
    return float(np.max(np.abs(np.expm1(answer.log_lift - reference.log_lift))))


SYSTEM: System[HoistProblem, HoistModel, Lift] = System(
    name="hoist",
    effects=EFFECTS,
    bare=lambda problem: HoistModel(problem=problem),
    method=lambda model, budget: _CLOSED_FORM,  # noqa: ARG005  (nothing to choose)
    solve=lambda model, method: solve_lift(model),  # noqa: ARG005  (nothing to choose)
    distance=_distance,
)
"""A rope on a wheel."""
