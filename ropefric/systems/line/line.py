"""A rope through all its elements: tensions, elongation, a cycle, the other way round, what a take-up holds."""

from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError, RopefricError
from ropefric.systems.checks import refuse
from ropefric.systems.effect import log_change
from ropefric.systems.line.element import LineModel, LineProblem, Passage
from ropefric.systems.line.elements.drum import Drum
from ropefric.systems.line.tendon import Anchored, Stressed, anchored, stressed

_LARGEST_N = 1e30


class Cycle(NamedTuple):
    """A rope that is pulled and paid out against the same tension at the start, shape (n,)."""

    pulled_N: FloatArray
    paid_out_N: FloatArray
    lost_stroke_m: FloatArray


class LineAnswer(NamedTuple):
    """A rope through its elements; arrays of shape (n,).

    Attributes
    ----------
    tension_N : ndarray, shape (k + 1, n)
        Before the first element, between them and behind the last one [N].
    numbers : tuple of dict
        More numbers of each element by name.
    stretch_m : ndarray, shape (k, n)
        Elongation of the rope in each element; zero where it does not stretch.
    cycle : Cycle or None
        Of a line without drums; NaN where the rope would have to push.
    other_end : ndarray, shape (k + 1, n), or None
        Tensions where the rope is pulled through the same elements from the other end, in that order.
    needed_end_N : ndarray or None
        Least tension behind the last element with which every drum transmits its given pull.
    stressed, anchored : Stressed, tuple of Anchored
        Of a tendon: from both ends; after the slip at the anchorages, that of the start first where both are stressed.
    """

    model: LineModel
    tension_N: FloatArray
    numbers: tuple[dict[str, FloatArray], ...]
    stretch_m: FloatArray
    cycle: Cycle | None
    other_end: FloatArray | None
    needed_end_N: FloatArray | None
    stressed: Stressed | None
    anchored: tuple[Anchored, ...]

    @property
    def load_N(self) -> FloatArray | None:
        """Return the sum of the tensions that carry the load, each at the lower end of its run; None without any."""
        carrying = [
            self.tension_N[i if getattr(one, "slope_rad", 0.0) >= 0.0 else i + 1]
            for i, one in enumerate(self.model.problem.elements)
            if getattr(one, "carries", False)
        ]
        return np.sum(carrying, axis=0) if carrying else None

    @property
    def jacks(self) -> tuple[str, ...]:
        """Return the ends at which a tendon is stressed, in the order of `anchored`."""
        return (
            ("start", "end") if self.stressed is not None else (("start", "end")[self.model.problem.pulled],)
        )

    @property
    def stretches(self) -> bool:
        """Return whether the elongation of the rope is simulated."""
        return "stretch" in self.model.effects

    @property
    def logs(self) -> FloatArray:
        """Return the logarithms of all forces, shape (m, n); NaN of negative ones."""
        found = [*self.tension_N, *(value for one in self.numbers for value in one.values())]
        found += [] if self.cycle is None else [self.cycle.pulled_N, self.cycle.paid_out_N]
        found += [] if self.other_end is None else [*self.other_end]
        found += [] if self.needed_end_N is None else [self.needed_end_N]
        found += [] if self.stressed is None else [self.stressed.least_N]
        return _logs(found, self.model.problem.n)

    @property
    def stretch_logs(self) -> FloatArray:
        """Return the logarithms of all numbers that the stretch of the rope makes, shape (m, n)."""
        found = [*self.stretch_m, *(() if self.cycle is None else [self.cycle.lost_stroke_m])]
        tendon = [*(() if self.stressed is None else (self.stressed,)), *self.anchored]
        found += [row for one in tendon for part in one for row in part.reshape(-1, part.shape[-1])]
        return _logs(found, self.model.problem.n)


def _logs(values: Iterable[FloatArray], n: int) -> FloatArray:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.log(np.stack([np.broadcast_to(one, (n,)) for one in values])))


def distance(answer: LineAnswer, reference: LineAnswer, whole: LineAnswer) -> float:  # noqa: ARG001  (no scale)
    """Return the largest change of any number that both answers have, as a share of it."""
    change = log_change(answer.logs, reference.logs)
    if answer.stretches and reference.stretches:
        change = max(change, log_change(answer.stretch_logs, reference.stretch_logs))
    return float(np.expm1(change))


def solve_line(model: LineModel) -> LineAnswer:
    """Return the tensions along a line, and what follows from them."""
    problem = model.problem
    start_N, end_N, needed_end_N = problem.start_tension_N, problem.end_tension_N, _needed_end_N(model)
    if start_N is None and end_N is None and needed_end_N is not None:
        end_N = needed_end_N
        refuse(
            ~np.isfinite(end_N),
            "no tension lets a drum without friction pull anything",
            code="RF510",
            key="mu",
            fix="give the drum a coefficient",
        )
    both = _stressed(model) if problem.both_ends else None
    if both is None:
        tension_N = _tensions(model, is_pulled=problem.pulled, start_N=start_N, end_N=end_N)
    else:
        tension_N = both.sides_N.max(axis=0)
    passage = Passage(model, is_forward=True, is_pulled=problem.pulled)
    triples = list(zip(problem.elements, tension_N[:-1], tension_N[1:], strict=True))
    moves_whole = both is None and not any(isinstance(one, Drum) for one in problem.elements)
    return LineAnswer(
        model=model,
        tension_N=tension_N,
        numbers=tuple(one.numbers(passage, before_N, after_N) for one, before_N, after_N in triples),
        stretch_m=_stretch_m(passage, tension_N, moves=both is None),
        cycle=_cycle(model, tension_N[0]) if moves_whole else None,
        other_end=_other_end(model) if moves_whole and problem.pulled and len(triples) > 1 else None,
        needed_end_N=needed_end_N,
        stressed=both,
        anchored=_anchored(model, tension_N, both),
    )


def _stretch_m(passage: Passage, tension_N: FloatArray, *, moves: bool) -> FloatArray:
    """Return the elongation in each element, shape (k, n); zero where it is not simulated, or two jacks share it."""
    problem = passage.model.problem
    if not moves or problem.axial_stiffness_N is None or not passage.has("stretch"):
        return np.zeros((len(problem.elements), problem.n))
    return _drawn_N_m(passage, tension_N) / problem.axial_stiffness_N


def _drawn_N_m(passage: Passage, tension_N: FloatArray) -> FloatArray:
    """Return ∫T dx in each element, shape (k, n)."""
    pairs = zip(passage.model.problem.elements, tension_N[:-1], strict=True)
    return np.stack([one.stretch_N_m(passage, before_N) for one, before_N in pairs])


def _stressed(model: LineModel) -> Stressed:
    """Return a tendon with a jack at each end; where one force is given, both have it."""
    problem = model.problem
    start_N, end_N = problem.start_tension_N, problem.end_tension_N
    from_start_N = _tensions(model, is_pulled=False, start_N=end_N if start_N is None else start_N)
    from_end_N = _tensions(model, is_pulled=True, end_N=start_N if end_N is None else end_N)
    return stressed(from_start_N, from_end_N, _lengths_m(problem))


def _other_end(model: LineModel) -> FloatArray:
    """Return the tensions where the rope is pulled from the other end, with the same tension known; NaN without any."""
    problem = model.problem
    back = replace(problem, elements=tuple(one.turned() for one in reversed(problem.elements)))
    ends: dict[str, FloatArray | None] = {"start_N": problem.start_tension_N, "end_N": problem.end_tension_N}
    try:
        return _tensions(replace(model, problem=back), is_pulled=True, **ends)
    except RopefricError:
        return np.full((len(problem.elements) + 1, problem.n), np.nan)


def _tensions(
    model: LineModel, *, is_pulled: bool, start_N: FloatArray | None = None, end_N: FloatArray | None = None
) -> FloatArray:
    """Return the tensions from the end at which it is known, in the order of the line, shape (k + 1, n)."""
    passage = Passage(model, is_forward=start_N is not None, is_pulled=is_pulled)
    known_N = start_N if start_N is not None else end_N
    if known_N is None:
        raise InputError(
            "the tension is known at neither end of the line",
            code="RF121",
            key="start_tension_N",
            fix='add start_tension = "90 N", or end_tension; drums with a share of a pull need neither',
        )
    elements = model.problem.elements
    found = [np.broadcast_to(known_N, (model.problem.n,))]
    for place, one in list(enumerate(elements))[:: 1 if passage.is_forward else -1]:
        with np.errstate(over="ignore"):
            found.append(one.tension_N(passage, found[-1]))
        refuse(
            ~(np.abs(found[-1]) <= _LARGEST_N),
            "the tension grows beyond any rope, {largest:g} N",
            code="RF420",
            key=f"element {place}",
            fix="check angles, lengths and coefficients",
            largest=_LARGEST_N,
        )
    return np.stack(found[:: 1 if passage.is_forward else -1])


def _cycle(model: LineModel, start_N: FloatArray) -> Cycle:
    """Return what the hand feels as it pulls and pays out, and how far it moves before the other end does.

    NaN where the rope would have to push in one of the two, or the law has no answer to one.
    """
    problem, ends_N, drawn_N_m = model.problem, [], []
    pulls, lost_m = np.ones(problem.n, dtype=np.bool_), np.zeros(problem.n)
    try:
        for is_pulled in (True, False):
            tension_N = _tensions(model, is_pulled=is_pulled, start_N=start_N)
            drawn_N_m.append(_drawn_N_m(Passage(model, True, is_pulled), tension_N).sum(axis=0))
            ends_N.append(tension_N[-1])
            pulls &= (tension_N >= 0.0).all(axis=0)
    except RopefricError:
        return Cycle(*np.full((3, problem.n), np.nan))
    if "stretch" in model.effects and problem.axial_stiffness_N is not None:
        lost_m = (drawn_N_m[0] - drawn_N_m[1]) / problem.axial_stiffness_N
    return Cycle(*(np.where(pulls, one, np.nan) for one in (*ends_N, lost_m)))


def _needed_end_N(model: LineModel) -> FloatArray | None:
    """Return the take-up tension that serves all drums whose pull is given: the largest that any of them needs."""
    problem = model.problem
    passage = Passage(model, is_forward=True, is_pulled=problem.pulled)
    needed = []
    for place, one in enumerate(problem.elements):
        if isinstance(one, Drum) and one.is_set:
            behind_N = one.needed_out_N(passage)
            held = np.isfinite(behind_N)
            rest = replace(model, problem=replace(problem, elements=problem.elements[place + 1 :]))
            end_N = _tensions(rest, is_pulled=problem.pulled, start_N=np.where(held, behind_N, 0.0))[-1]
            needed.append(np.where(held, end_N, np.inf))
    return np.max(needed, axis=0) if needed else None


def _lengths_m(problem: LineProblem) -> FloatArray:
    return np.array([one.stretching_m for one in problem.elements])


def _anchored(model: LineModel, tension_N: FloatArray, both: Stressed | None) -> tuple[Anchored, ...]:
    """Return the tendon after its jack, or both, have let it back."""
    problem = model.problem
    if (
        problem.anchorage_slip_m is None
        or problem.axial_stiffness_N is None
        or "stretch" not in model.effects
    ):
        return ()
    lengths_m, slip_N_m = _lengths_m(problem), problem.anchorage_slip_m * problem.axial_stiffness_N
    if both is None:
        turn = slice(None, None, -1 if problem.pulled else 1)
        found = anchored(tension_N[turn], lengths_m[turn], slip_N_m)
        return (found._replace(tension_N=found.tension_N[turn]),)
    sides = []
    for side_N, turn in zip(both.sides_N, (slice(None), slice(None, None, -1)), strict=True):
        found = anchored(side_N[turn], lengths_m[turn], slip_N_m)
        refuse(
            found.largest_N < both.least_N,
            "the slips of both anchorages meet: friction would turn round beyond the least tension",
            code="RF510",
            key="anchorage_slip_m",
            fix="stress this tendon from one end",
        )
        after_N = np.where(side_N > found.largest_N, found.tension_N[turn], tension_N)
        sides.append(found._replace(tension_N=after_N))
    return tuple(sides)


def answerable(problem: LineProblem) -> BoolArray:
    """Return for which of n cases there may be an answer, shape (n,): a tension that is known is not negative."""
    return np.ones(problem.n, dtype=np.bool_)
