"""The time of one call, taken so that a microsecond is measured as well as a second."""

import gc
from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from ropefric.errors import InputError

__all__ = ["FULL", "QUICK", "Effort", "Timing", "time_call"]

_MOST_LOOPS = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Effort:
    """How much time is spent on timing one call.

    Attributes
    ----------
    batch_s : float
        A time is taken of as many calls as last this long together, so that the clock's own resolution does not
        count [s].
    budget_s : float
        About the whole time for one setting [s]; a call that takes longer by itself is repeated `fewest` times.
    fewest, most : int
        Bounds of the number of times taken.

    Raises
    ------
    InputError
        If a time is not positive or the bounds are not 1 <= fewest <= most.
    """

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
    """How long one call takes.

    Attributes
    ----------
    seconds : float
        Median [s].
    lower_s, upper_s : float
        First and third quartile [s].
    repeats, loops : int
        Number of times taken, and of calls behind each.
    """

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

    Parameters
    ----------
    call : callable
        What is timed.
    effort : Effort
        How much time to spend.
    clock : callable
        Returns the time [s].

    Examples
    --------
    >>> ticks = iter(range(100))
    >>> effort = Effort(batch_s=1.0, budget_s=4.0, fewest=3, most=5)
    >>> timing = time_call(lambda: None, effort, clock=lambda: next(ticks))
    >>> timing.seconds, timing.repeats, timing.loops
    (1.0, 4, 1)
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
