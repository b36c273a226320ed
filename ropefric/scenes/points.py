"""Many cases of one scene, planned once for some of them and solved block by block: a grid, or draws.

What the cases are is said by a `Points`; each is a list of values, one array for each of its axes. They are solved in
one call where the system allows it, one by one elsewhere, here or by an executor.
"""

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import prod
from typing import Any, NamedTuple, Protocol

import numpy as np

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import InputError, RopefricError
from ropefric.executors import spread
from ropefric.fitting.predict import EXTRAPOLATED, REGRESSORS
from ropefric.scenes.kind import Failure, Quantity
from ropefric.scenes.plan import room_for_effects, solve_planned, worth_asking
from ropefric.scenes.scene import Scene, cases_outside, replaced, source_of
from ropefric.shown import Shown
from ropefric.systems.checks import rules_of
from ropefric.systems.effect import applicable, assemble

MOST_CASES = 1_000_000
"""Of an axis, of a whole grid, and of draws: all are held, some 200 MB."""

BLOCK = 50_000
_ONE_BY_ONE = 20
"""Points of a piece of work that are solved one after another."""
_SEEN_S = 1.0
"""Time of one call at most, about."""
_LOOKED_AT = 61
"""Cases, evenly spaced among all, at which it is asked whether leaving effects out saves time."""

Progress = Callable[[int, int, str], None]


class Points(Protocol):
    """Which cases of a scene are solved: values of its keys, and perhaps parameters of its friction behind them.

    Attributes
    ----------
    option : str
        The option of the command behind them, for errors: --sweep.
    what : str
        One of them in words.
    fix : str
        Advice if none of them has an answer.
    keys : tuple of str
        Of the scene, that change.
    shape : tuple of int
        How many there are, along each axis.
    """

    option: str
    what: str
    fix: str
    keys: tuple[str, ...]
    shape: tuple[int, ...]

    def at(self, places: IntArray) -> list[FloatArray]:
        """Return the values of all keys at places in SI, and last the parameters if they differ, (n, p)."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Answers(Shown):
    """The answers to many cases; what its fields are say `Sweep` and `Draws`."""

    columns: dict[str, FloatArray]
    failed: int
    first_failure: str
    simulated: tuple[str, ...]
    error_bound: float
    accuracy: float = math.inf
    failures: dict[str, int] = field(default_factory=dict)
    left_out: dict[str, int] = field(default_factory=dict)
    extrapolated_at: dict[str, int] = field(default_factory=dict)

    @property
    def keeps_accuracy(self) -> bool:
        """Return whether the error bound is within the accuracy wanted at every point."""
        return self.error_bound <= self.accuracy

    def _warnings(self, at: str) -> tuple[str, ...]:
        """Return where the machine does not do what it is for, after words for a number of points, and a large error."""
        found = [f"{at.format(n)} {words}" for words, n in self.failures.items() if n]
        found += [
            f"{at.format(n)} extrapolated: the {what} is outside what was tested"
            for what, n in self.extrapolated_at.items()
        ]
        if not self.keeps_accuracy:
            bound = "not known" if math.isinf(self.error_bound) else f"up to {self.error_bound:.2g}"
            found.append(f"the error is {bound} at some points, more than the accuracy of {self.accuracy:g}")
        return tuple(found)


def solve_points(scene: Scene, points: Points, *, progress: Progress | None, executor: Any) -> dict[str, Any]:
    """Return the fields of `Answers` to many cases."""
    total = prod(points.shape)
    tally = _Tally(total)
    for found in _Run(scene, points).spread(progress, executor):
        tally.add(found)
    if tally.failed == total:
        raise InputError(
            f"no {points.what} has an answer; the first says: {tally.first_failure}",
            code="RF503",
            key=points.option,
            fix=points.fix,
        )
    return tally.fields(scene)


class _Tally:
    """The numbers of all points, and their failures, effects, largest error and extrapolations."""

    def __init__(self, total: int) -> None:
        self.columns: dict[str, FloatArray] = defaultdict(lambda: np.full(total, np.nan))
        self.failed, self.first_failure, self.error_bound = 0, "", 0.0
        self.simulated, self.failures, self.left_out = set[str](), Counter[str](), Counter[str]()
        self.outside = np.zeros(len(REGRESSORS), dtype=np.int64)

    def add(self, outcomes: "Iterable[Outcome]") -> None:
        """Take the numbers of some points, NaN where there is no answer, and count the rest."""
        for places, found in outcomes:
            if isinstance(found, RopefricError):
                self.failed += places.size
                self.first_failure = self.first_failure or found.problem.message
                continue
            for quantity in found.quantities:
                self.columns[quantity.name][places] = quantity.value
            if found.outside is not None:
                self.columns[EXTRAPOLATED][places] = found.outside.any(axis=1)
                self.outside += found.outside.sum(axis=0)
            self.simulated |= found.simulated
            self.error_bound = max(self.error_bound, found.error_bound)
            self.left_out.update(dict.fromkeys(found.left_out, places.size))
            for way in found.failures:
                self.failures[way.words] += int(way.fails.sum())

    def fields(self, scene: Scene) -> dict[str, Any]:
        """Return what was counted, as fields of `Answers`."""
        every = scene.kind.system.effects
        names = [what for what, _, _ in REGRESSORS.values()]
        outside = dict(zip(names, self.outside.tolist(), strict=True))
        return {
            "columns": dict(self.columns),
            "failed": self.failed,
            "first_failure": self.first_failure,
            "simulated": tuple(name for name in every if name in self.simulated),
            "error_bound": self.error_bound,
            "accuracy": scene.accuracy,
            "failures": dict(self.failures),
            "extrapolated_at": {what: n for what, n in outside.items() if n},
            "left_out": {name: self.left_out[name] for name in every if self.left_out[name]},
        }


class _Found(NamedTuple):
    """Answers to some points, and the effects simulated for them."""

    quantities: tuple[Quantity, ...]
    failures: tuple[Failure, ...]
    simulated: frozenset[str]
    error_bound: float
    left_out: frozenset[str] = frozenset()
    outside: BoolArray | None = None

    def at(self, some: BoolArray) -> "_Found":
        """Return what some of the points give."""
        quantities = tuple(one._replace(value=one.value[some]) for one in self.quantities)
        failures = tuple(one._replace(value=one.value[some], fails=one.fails[some]) for one in self.failures)
        outside = None if self.outside is None else self.outside[some]
        return self._replace(quantities=quantities, failures=failures, outside=outside)


Outcome = tuple[IntArray, _Found | RopefricError]


class _Run:
    """Many cases as they are solved: whether leaving effects out saves time is decided once, on some of them.

    They are left out where their bounds allow it. Points at which a yes or no is then open, or a difference of two
    numbers is less accurate than wanted, are solved again with all effects.
    """

    def __init__(self, scene: Scene, points: Points) -> None:
        self.scene, self.points, self.kind = scene, points, scene.kind
        self.fields = [self.kind.sweep_fields.get(key) for key in points.keys]
        self.by_array = None not in self.fields and self.kind.in_one_call(scene.problem)
        cost_s = sum(one.cost for one in applicable(self.kind.system.effects, scene.problem).values())
        # Of a dear machine few at once, so that people see how far it is.
        size = min(BLOCK, max(1, int(_SEEN_S / max(cost_s, 1e-9))))
        self.size = size if self.by_array else _ONE_BY_ONE
        self.room = room_for_effects(scene.accuracy)
        self.gone: frozenset[str] = frozenset()
        if scene.effects == "auto" and self.by_array:
            # Where some make no problem, the sweep will say which.
            with suppress(RopefricError):
                self.gone = self._worth_leaving_out(prod(points.shape))

    def build(self, places: IntArray) -> Any:
        """Return the problem of some points."""
        scene, kind, values = self.scene, self.kind, self.points.at(places)
        thetas = values[len(self.fields) :]
        if self.by_array:
            pairs = zip(self.fields, values, strict=False)
            changed: dict[str, Any] = {one.field: one.factor * value for one, value in pairs if one}
            if thetas:
                changed["friction"] = replace(scene.problem.friction, theta=thetas[0])
                # The parameters alone do not make many cases of one.
                name = next(iter(rules_of(type(scene.problem))))  # type: ignore[arg-type]  # a class is hashable
                changed.setdefault(name, np.broadcast_to(getattr(scene.problem, name), len(thetas[0])))
            return replace(scene.problem, **changed)
        table = scene.table
        for key, value in zip(self.points.keys, values, strict=False):
            table = replaced(table, key, float(value[0]))
        source = source_of(kind, table, scene.folder)
        friction = None if source is None else source.friction
        if friction is not None and thetas:
            friction = replace(friction, theta=thetas[0][0])
        return kind.problem(table, friction)

    def _worth_leaving_out(self, total: int) -> frozenset[str]:
        """Return the effects that have a bound and take time, if leaving them out saves more than it costs."""
        known = applicable(self.kind.system.effects, self.scene.problem)
        gone = frozenset(one.name for one in worth_asking(known.values(), total))
        if not gone:
            return gone
        places = np.unique(np.linspace(0, total - 1, _LOOKED_AT).astype(np.int64))
        some = self.build(places[self.kind.answerable(self.build(places))])
        # Of some it is known before anything is solved that they stay.
        might_go = self._bounds(some, gone) <= self.room
        if not might_go.any():
            return frozenset()
        may_go = self._bounds(some, gone, self._solved(some, known.keys() - gone)[1]) <= self.room
        # Where they might go and may not, everything is solved after all.
        return gone if may_go.sum() > (might_go & ~may_go).sum() else frozenset()

    def _bounds(self, problem: Any, gone: frozenset[str], answer: Any = None) -> FloatArray:
        """Return what leaving out some effects changes at most, shape (n,); without an answer no more than that."""
        effects = (self.kind.system.effects[name] for name in gone)
        bounds = sum(one.bound(problem, answer) for one in effects if one.bound)
        return np.broadcast_to(np.asarray(bounds), (problem.n,))

    def _solved(self, problem: Any, simulated: Iterable[str]) -> tuple[_Found, Any]:
        """Return what a problem gives with some effects, and its answer."""
        system = self.kind.system
        model = assemble(system, problem, simulated)
        method = system.method(model, self.scene.accuracy)
        answer = system.solve(model, method)
        return self._found(problem, answer, model.effects, method.error), answer

    def pieces(self, start: int, stop: int) -> list[tuple[int, int]]:
        """Return the first point of each piece of a block, and the one after its last."""
        return [(first, min(first + self.size, stop)) for first in range(start, stop, self.size)]

    def spread(self, progress: Progress | None, executor: Any) -> Iterator[list[Outcome]]:
        """Yield what the points of all pieces of all blocks give."""
        total, done = prod(self.points.shape), 0
        blocks = ((start, min(start + BLOCK, total)) for start in range(0, total, BLOCK))
        pieces = (piece for block in blocks for piece in self.pieces(*block))
        for found in spread(self.outcomes, pieces, executor):
            done += sum(places.size for places, _ in found)
            if progress is not None:
                progress(done, total, self.points.what.split()[0] + "s")
            yield found

    def outcomes(self, piece: tuple[int, int]) -> list[Outcome]:
        """Return what the points of a piece give; point by point where a key does not go in one call."""
        size = self.size if self.by_array else 1
        parts = (np.arange(first, min(first + size, piece[1])) for first in range(*piece, size))
        return [found for places in parts for found in self._outcomes(places)]

    def _outcomes(self, places: IntArray) -> Iterator[Outcome]:
        lost = np.zeros(places.size, dtype=np.bool_)
        if self.by_array:
            with suppress(RopefricError):  # some of them make no problem; halving them finds which
                lost = np.broadcast_to(~self.kind.answerable(self.build(places)), places.shape)
        yield from self._refused(places[lost])
        places = places[~lost]
        if self.gone and places.size and (lessened := self._lessened(places)) is not None:
            less, found = lessened
            yield places[less], found
            places = places[~less]
        yield from self._whole(places)

    def _refused(self, places: IntArray) -> Iterator[Outcome]:
        """Yield what points without an answer give, of which one is solved, to hear why not."""
        yield from self._whole(places[:1])
        if places.size > 1:
            yield places[1:], InputError("there is no answer")

    def _lessened(self, places: IntArray) -> tuple[BoolArray, _Found] | None:
        """Return which points can be solved with less than everything, and what they give."""
        # What has no answer, or none without some effect, is left to everything.
        with suppress(RopefricError):
            some = self._bounds(self.build(places), self.gone) <= self.room
            if not some.any():
                return None
            less = self.build(places[some])
            names = applicable(self.kind.system.effects, less).keys()
            found, answer = self._solved(less, names - self.gone)
            bounds = self._bounds(less, self.gone, answer)
            error = np.expm1(np.minimum(bounds, 1.0))
            sure = (bounds <= self.room) & _is_settled(found, error, self.scene.accuracy)
            if sure.any():
                most = float(error[sure].max())
                bound = most + found.error_bound * (1.0 + most)
                some[np.flatnonzero(some)[~sure]] = False
                return some, found.at(sure)._replace(left_out=self.gone, error_bound=bound)
        return None

    def _whole(self, places: IntArray) -> Iterator[Outcome]:
        """Yield what points give, solved in one call.

        Those without an answer are set apart if the error says which they are, and else halved down to single ones.
        """
        if not places.size:
            return
        try:
            found = self._planned(self.build(places))
        except RopefricError as error:
            refused = np.asarray(error.cases)
            if places.size == 1:
                yield places, error
            elif refused.shape == places.shape and refused.any():
                yield from self._refused(places[refused])
                yield from self._whole(places[~refused])
            else:
                for half in np.array_split(places, 2):
                    yield from self._whole(half)
        else:
            yield places, found

    def _planned(self, problem: Any) -> _Found:
        """Return what a problem gives as asked for; with everything where sweeps are planned as a whole."""
        scene = self.scene
        whole = scene.effects == "auto" and self.by_array
        plan, answer = solve_planned(scene, problem, "all" if whole else "")
        return self._found(
            problem, answer, frozenset(plan.simulated), plan.error_bound, frozenset(plan.left_out)
        )

    def _found(self, problem: Any, answer: Any, *of: Any) -> _Found:
        """Return what some points give, and in which respects the friction is used outside what it was tested for."""
        kind, source = self.kind, self.scene.source
        numbers = (*kind.quantities(answer, problem), *kind.outcomes(answer, problem))
        found = _Found(numbers, kind.failures(answer, problem), *of)
        if source is None or source.tested is None:
            return found
        return found._replace(outside=cases_outside(source.tested, kind.contacts(problem), problem.n))


def _is_settled(found: _Found, error: FloatArray, accuracy: float) -> BoolArray:
    """Return at which points an answer that errs by a share `error` leaves no yes or no open, and no difference."""
    settled = np.ones(error.size, dtype=np.bool_)
    for one in found.quantities:
        if one.scale is not None:
            settled &= error * np.abs(one.scale) <= accuracy * np.abs(one.value)
    for way in found.failures:
        settled &= ~way.is_open(error)
    return settled
