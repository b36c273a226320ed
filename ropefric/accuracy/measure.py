"""Measuring studies: the error and the time of every setting, one after another, on a machine that is named."""

import gc
import hashlib
import json
import os
import platform
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace
from functools import cache
from importlib.metadata import version
from itertools import groupby
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from ropefric.accuracy.studies import STUDIES
from ropefric.accuracy.study import Case, Measured, Setting, Study, StudyResult
from ropefric.arrays import FloatArray
from ropefric.executors import software, spread

_CPUINFO = Path("/proc/cpuinfo")
_MOST_LOOPS = 1_000_000
_SHORTER = 10
"""Factor by which batches timed in turn are shorter than usual, and more numerous."""

Progress = Callable[[int, int, str], None]


class Machine(NamedTuple):
    """The machine of a measurement: a time without it has no meaning."""

    cpu: str
    cores: int
    system: str
    python: str
    numpy: str
    scipy: str

    @property
    def line(self) -> str:
        """Return all of it in a line."""
        cores = "1 core" if self.cores == 1 else f"{self.cores} cores"
        made = f"Python {self.python}, numpy {self.numpy}, scipy {self.scipy}"
        return f"{self.cpu}, {cores}, {self.system}; {made}"


def this_machine() -> Machine:
    """Return the machine this runs on; its processor from a file, else the platform's name."""
    lines = _CPUINFO.read_text(encoding="utf-8", errors="replace").splitlines() if _CPUINFO.is_file() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return Machine(
        cpu=(models[0] if models else "") or platform.processor() or "unknown processor",
        cores=os.cpu_count() or 1,
        system=f"{platform.system()} {platform.machine()}",
        python=platform.python_version(),
        numpy=version("numpy"),
        scipy=version("scipy"),
    )


class Effort(NamedTuple):
    """How much time is spent on timing one call."""

    batch_s: float
    budget_s: float
    fewest: int
    most: int


FULL = Effort(batch_s=5e-3, budget_s=0.15, fewest=5, most=15)
"""Requirements of an honest comparison."""

QUICK = Effort(batch_s=5e-4, budget_s=0.01, fewest=3, most=9)
"""A short look: medians good to some ten per cent on a quiet machine."""


class Timing(NamedTuple):
    """How long one call takes, and a range, of `repeats` batches of `loops` calls."""

    seconds: float
    lower_s: float
    upper_s: float
    repeats: int
    loops: int


def time_call(
    call: Callable[[], object], effort: Effort = FULL, *, clock: Callable[[], float] = perf_counter
) -> Timing:
    """Return how long a call takes: median and quartiles over several batches of calls."""
    ((times_s, loops),) = _batches([call], effort, clock)
    lower_s, median_s, upper_s = np.percentile(times_s, [25, 50, 75]).tolist()
    return Timing(median_s, lower_s, upper_s, times_s.size, loops)


def time_in_turn(
    calls: Sequence[Callable[[], object]], effort: Effort = FULL, *, clock: Callable[[], float] = perf_counter
) -> list[Timing]:
    """Return how long calls take that are to be held against each other: the least of several batches in turn.

    What slows the machine for a while then slows all of them, and the least of each not at all: batches are so short
    that some of them fit between what else the machine does.
    """
    found, shares = [], effort._replace(batch_s=effort.batch_s / _SHORTER, most=effort.most * _SHORTER)
    for times_s, loops in _batches(calls, shares, clock):
        least_s, upper_s = np.percentile(times_s, [0, 75]).tolist()
        found.append(Timing(least_s, least_s, upper_s, times_s.size, loops))
    return found


def _batches(
    calls: Sequence[Callable[[], object]], effort: Effort, clock: Callable[[], float]
) -> list[tuple[FloatArray, int]]:
    """Return how long each call takes in several batches, and of how many calls these are.

    The first call warms up caches and lazy imports and is thrown away. Then the number of calls in a batch is doubled
    until a batch lasts long enough. The garbage collector rests meanwhile.
    """

    def batch_s(call: Callable[[], object], loops: int) -> float:
        start_s = clock()
        for _ in range(loops):
            call()
        return clock() - start_s

    resting, found = gc.isenabled(), []
    gc.disable()
    try:
        for call in calls:
            call()
            loops = 1
            while (elapsed_s := batch_s(call, loops)) < effort.batch_s and loops < _MOST_LOOPS:
                loops *= 2
            repeats = int(np.clip(effort.budget_s / max(elapsed_s, 1e-12), effort.fewest, effort.most))
            found.append(([elapsed_s], loops, repeats))
        for turn in range(1, effort.most):
            for call, (times_s, loops, repeats) in zip(calls, found, strict=True):
                if turn < repeats:
                    times_s.append(batch_s(call, loops))
    finally:
        if resting:
            gc.enable()
    return [(np.array(times_s) / loops, loops) for times_s, loops, _ in found]


def measure_studies(
    studies: Sequence[Study],
    *,
    quick: bool = False,
    effort: Effort | None = None,
    progress: Progress | None = None,
    executor: Any = None,
    kept: Path | None = None,
) -> tuple[StudyResult, ...]:
    """Return the error and time of every setting of each study; errors are found by an executor, times taken here.

    Each goes at once to the file `kept`, a line each. Results in it, measured by this version on this
    machine, are not measured again, so that the same call continues where another ended.
    """
    effort = effort or (QUICK if quick else FULL)
    planned = list(_pieces(studies, effort, quick=quick))
    found: dict[str, list[Measured]] = {study.name: [] for study in studies}
    for done, (piece, point) in enumerate(_measured(planned, effort, executor, kept), start=1):
        found[piece.study.name].append(point)
        if progress is not None:
            one = piece.setting
            said = f"{piece.study.name}: {piece.case.name}, {one.method} {one.setting}".rstrip()
            progress(done, len(planned), said)
    return tuple(StudyResult(study=study, points=tuple(found[study.name]), quick=quick) for study in studies)


def _pieces(studies: Sequence[Study], effort: Effort, *, quick: bool) -> Iterator["_Piece"]:
    """Yield the settings of all cases of all studies; of a quick look some."""
    how = (software(), this_machine().line, effort)
    for study in studies:
        for case in study.cases:
            for place, setting in enumerate(_settings(case)):
                if setting.quick or not quick:
                    yield _Piece(_name_of(how, study, case, setting), study, case, place, setting)


def _measured(
    pieces: Sequence["_Piece"], effort: Effort, executor: Any, kept: Path | None
) -> Iterator[tuple["_Piece", Measured]]:
    """Yield each setting with its point, from the file `kept` or measured now and written to it."""
    before = {} if kept is None else _kept_before(kept)
    left = [piece for piece in pieces if piece.name not in before]
    assessed = spread(_assessed_at, ((piece.case, piece.place) for piece in left), executor)
    timed = _timed(left, effort)
    for piece in pieces:
        point = before.get(piece.name)
        if point is None:
            point = replace(next(assessed), **next(timed)._asdict())
            if kept is not None:
                _keep(kept, piece.name, point)
        yield piece, point


class _Piece(NamedTuple):
    """A setting to measure: by its name, the study and the case it belongs to, and its place in the case."""

    name: str
    study: Study
    case: Case
    place: int
    setting: Setting


def _timed(pieces: Sequence[_Piece], effort: Effort) -> Iterator[Timing]:
    """Yield how long each takes when it is asked for; those of a case in turn, where its study says so."""
    for (study, _), group in groupby(pieces, key=lambda piece: (piece.study, piece.case)):
        calls = [piece.setting.call for piece in group]
        yield from (
            time_in_turn(calls, effort) if study.in_turn else (time_call(call, effort) for call in calls)
        )


def _name_of(how: tuple[object, ...], study: Study, case: Case, setting: Setting) -> str:
    """Return the identity of a setting and of how it is measured."""
    text = repr((*how, study.name, case.name, case.title, setting.method, setting.setting))
    return hashlib.sha256(text.encode()).hexdigest()


def _keep(kept: Path, name: str, point: Measured) -> None:
    """Write a point to a file in a line of its own; the line before may be cut off."""
    kept.parent.mkdir(parents=True, exist_ok=True)
    with kept.open("a", encoding="utf-8") as stream:
        stream.write("\n" + json.dumps([name, asdict(point)]))


def _kept_before(kept: Path) -> dict[str, Measured]:
    """Return the points that an earlier call kept, by name; a line that was cut off is none."""
    points = {}
    for line in kept.read_text(encoding="utf-8").splitlines() if kept.is_file() else ():
        try:
            name, tree = json.loads(line)
            points[name] = Measured(**tree)
        except (ValueError, TypeError):
            continue
    return points


def error_table(study: str, case: str = "", *, method: str = "") -> tuple[Measured, ...]:
    """Return the error and the work of every setting of a case, or of one method; no clock is looked at."""
    chosen = STUDIES[study].case(case)
    return tuple(_assessed(chosen.name, one) for one in _settings(chosen) if method in {"", one.method})


def enough(study: str, accuracy: float, case: str = "", *, method: str = "") -> Measured:
    """Return the setting of the least work with an error of at most `accuracy`, the same on every machine."""
    good = [row for row in error_table(study, case, method=method) if row.error <= accuracy]
    return min(good, key=lambda row: (row.evaluations, row.error))


@cache
def _settings(case: Case) -> tuple[Setting, ...]:
    return case.settings()


def _assessed_at(piece: tuple[Case, int]) -> Measured:
    case, place = piece
    return _assessed(case.name, _settings(case)[place])


@cache  # settings are told apart by their functions, so only those that `_settings` keeps come again
def _assessed(case: str, setting: Setting) -> Measured:
    return Measured(case=case, method=setting.method, setting=setting.setting, **asdict(setting.assess()))
