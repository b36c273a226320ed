"""Measuring studies: the error and the time of every setting, one after another."""

import gc
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from ropefric.accuracy.measured import ACCURACIES, Measured, cheapest, in_case, pareto_front
from ropefric.accuracy.study import Setting, Study
from ropefric.errors import InputError

_MOST_LOOPS = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Effort:
    """How much time is spent on timing one call."""

    batch_s: float
    budget_s: float
    fewest: int
    most: int

    def __post_init__(self) -> None:
        if not (0.0 < self.batch_s <= self.budget_s and 1 <= self.fewest <= self.most):
            raise InputError(
                f"{self.fewest} to {self.most} batches of {self.batch_s} s in {self.budget_s} s makes no sense",
                fix="give 0 < batch_s <= budget_s and 1 <= fewest <= most",
            )


FULL = Effort(batch_s=5e-3, budget_s=0.15, fewest=5, most=15)
"""What an honest comparison takes."""

QUICK = Effort(batch_s=5e-4, budget_s=0.01, fewest=3, most=9)
"""A glance: medians good to some ten per cent on a quiet machine."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """How long one call takes."""

    seconds: float
    lower_s: float
    upper_s: float
    repeats: int
    loops: int


def time_call(
    call: Callable[[], object], effort: Effort = FULL, *, clock: Callable[[], float] = perf_counter
) -> Timing:
    """Return how long a call takes: median and quartiles over several batches of calls.

    The first call warms up caches and lazy imports and is thrown away. Then the number of calls in a batch is doubled
    until a batch lasts long enough. The garbage collector rests meanwhile.
    """
    resting = gc.isenabled()
    gc.disable()
    try:
        call()
        loops, elapsed_s = _calibrated(call, effort.batch_s, clock)
        repeats = int(np.clip(effort.budget_s / max(elapsed_s, 1e-12), effort.fewest, effort.most))
        times_s = [elapsed_s, *(_batch_s(call, loops, clock) for _ in range(repeats - 1))]
    finally:
        if resting:
            gc.enable()
    lower_s, median_s, upper_s = np.percentile(np.array(times_s) / loops, [25, 50, 75])
    return Timing(
        seconds=float(median_s), lower_s=float(lower_s), upper_s=float(upper_s), repeats=repeats, loops=loops
    )


def _calibrated(call: Callable[[], object], batch_s: float, clock: Callable[[], float]) -> tuple[int, float]:
    loops = 1
    while True:
        elapsed_s = _batch_s(call, loops, clock)
        if elapsed_s >= batch_s or loops >= _MOST_LOOPS:
            return loops, elapsed_s
        loops *= 2


def _batch_s(call: Callable[[], object], loops: int, clock: Callable[[], float]) -> float:
    start_s = clock()
    for _ in range(loops):
        call()
    return clock() - start_s


Progress = Callable[[int, int, str], None]

_UNSTEADY = 0.5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StudyResult:
    """What was measured of one study."""

    study: Study
    points: tuple[Measured, ...]
    quick: bool

    def front(self, case: str) -> tuple[Measured, ...]:
        """Return the points of a case that no other beats in both error and time, fastest first."""
        return pareto_front(in_case(self.points, case))

    def cheapest(self, case: str) -> tuple[tuple[float, Measured | None], ...]:
        """Return, for each accuracy 1e-2 … 1e-12, the fastest point that reaches it."""
        points = in_case(self.points, case)
        return tuple((accuracy, cheapest(points, accuracy)) for accuracy in ACCURACIES)

    @property
    def findings(self) -> tuple[str, ...]:
        """Return what the measurement says, in sentences."""
        return self.study.findings(self.points)

    @property
    def unsteady(self) -> float:
        """Return the share of points whose times spread by more than half their median: other work was going on."""
        return float(
            np.mean([point.spread_s > _UNSTEADY * point.seconds for point in self.points] or [False])
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain data."""
        return {
            "name": self.study.name,
            "title": self.study.title,
            "reference": self.study.reference,
            "counted": self.study.counted,
            "points": [point.to_dict() for point in self.points],
            "cheapest": {
                case.name: [
                    {
                        "accuracy": accuracy,
                        "method": None if point is None else point.method,
                        "setting": None if point is None else point.setting,
                        "seconds": None if point is None else point.seconds,
                    }
                    for accuracy, point in self.cheapest(case.name)
                ]
                for case in self.study.cases
            },
            "findings": list(self.findings),
            "unsteady": self.unsteady,
        }


def measure_study(
    study: Study, *, quick: bool = False, effort: Effort | None = None, progress: Progress | None = None
) -> StudyResult:
    """Return the error and time of every setting of a study."""
    return measure_studies([study], quick=quick, effort=effort, progress=progress)[0]


def measure_studies(
    studies: Sequence[Study],
    *,
    quick: bool = False,
    effort: Effort | None = None,
    progress: Progress | None = None,
) -> tuple[StudyResult, ...]:
    """Return the result of each study; parameters as in `measure_study`."""
    spent = effort or (QUICK if quick else FULL)
    planned = [(study, case.name, setting) for study in studies for case in study.cases
               for setting in case.settings() if setting.quick or not quick]  # fmt: skip
    found: dict[str, list[Measured]] = {study.name: [] for study in studies}
    for done, (study, case, setting) in enumerate(planned, start=1):
        found[study.name].append(_measured(case, setting, spent))
        if progress is not None:
            progress(done, len(planned), f"{study.name}: {case}, {setting.method} {setting.setting}".rstrip())
    return tuple(StudyResult(study=study, points=tuple(found[study.name]), quick=quick) for study in studies)


def _measured(case: str, setting: Setting, effort: Effort) -> Measured:
    outcome, timing = setting.assess(), time_call(setting.call, effort)
    return Measured(
        case=case,
        method=setting.method,
        setting=setting.setting,
        error=outcome.error,
        evaluations=outcome.evaluations,
        bias=outcome.bias,
        noise=outcome.noise,
        seconds=timing.seconds,
        lower_s=timing.lower_s,
        upper_s=timing.upper_s,
        repeats=timing.repeats,
        loops=timing.loops,
    )
