"""Measuring studies: the error and the time of every setting, one after another, on a machine that is named."""

import gc
import os
import platform
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from functools import cache
from importlib.metadata import version
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import numpy as np

from ropefric.accuracy.studies import STUDIES
from ropefric.accuracy.study import Case, Measured, Setting, Study, StudyResult

_CPUINFO = Path("/proc/cpuinfo")
_MOST_LOOPS = 1_000_000
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


FULL = Effort(batch_s=5e-4, budget_s=0.15, fewest=5, most=150)
"""Requirements of an honest comparison."""

QUICK = Effort(batch_s=5e-5, budget_s=0.01, fewest=3, most=90)
"""A short look: times good to some ten per cent on a quiet machine."""


class Timing(NamedTuple):
    """How long one call takes, and a range, of `repeats` batches of `loops` calls."""

    seconds: float
    lower_s: float
    upper_s: float
    repeats: int
    loops: int


def time_in_turn(
    calls: Sequence[Callable[[], object]], effort: Effort = FULL, *, clock: Callable[[], float] = perf_counter
) -> list[Timing]:
    """Return how long each of some calls takes: the least of several batches of calls, timed in turn.

    What slows the machine for a while then slows all of them, and the least of each not at all: batches are so short
    that some of them fit between what else the machine does. The first call warms up caches and lazy imports and is
    thrown away. Then the number of calls in a batch is doubled until a batch lasts long enough. The garbage collector
    rests meanwhile.
    """

    def batch_s(call: Callable[[], object], loops: int) -> float:
        start_s = clock()
        for _ in range(loops):
            call()
        return clock() - start_s

    resting, batches = gc.isenabled(), []
    gc.disable()
    try:
        for call in calls:
            call()
            loops = 1
            while (elapsed_s := batch_s(call, loops)) < effort.batch_s and loops < _MOST_LOOPS:
                loops *= 2
            repeats = int(np.clip(effort.budget_s / max(elapsed_s, 1e-12), effort.fewest, effort.most))
            batches.append(([elapsed_s], loops, repeats))
        for turn in range(1, effort.most):
            for call, (times_s, loops, repeats) in zip(calls, batches, strict=True):
                if turn < repeats:
                    times_s.append(batch_s(call, loops))
    finally:
        if resting:
            gc.enable()
    found = []
    for times_s, loops, _ in batches:
        least_s, upper_s = (np.percentile(times_s, [0, 75]) / loops).tolist()
        found.append(Timing(least_s, least_s, upper_s, len(times_s), loops))
    return found


def measure_studies(
    studies: Sequence[Study],
    *,
    quick: bool = False,
    effort: Effort | None = None,
    progress: Progress | None = None,
) -> tuple[StudyResult, ...]:
    """Return the error and time of every setting of each study; of a quick look, of some settings."""
    effort = effort or (QUICK if quick else FULL)
    cases = [(study, case) for study in studies for case in study.cases]
    points: dict[str, list[Measured]] = {study.name: [] for study in studies}
    for done, (study, case) in enumerate(cases, start=1):
        settings = [one for one in _settings(case) if one.quick or not quick]
        timings = time_in_turn([one.call for one in settings], effort)
        for setting, timing in zip(settings, timings, strict=True):
            points[study.name].append(replace(_assessed(case.name, setting), **timing._asdict()))
        if progress is not None:
            progress(done, len(cases), f"{study.name}: {case.name}")
    return tuple(StudyResult(study=study, points=tuple(points[study.name]), quick=quick) for study in studies)


def error_table(study: str, case: str = "", *, method: str = "") -> tuple[Measured, ...]:
    """Return the error and the work of every setting of a case, or of one method; no clock is looked at."""
    chosen = STUDIES[study].case(case)
    return tuple(_assessed(chosen.name, one) for one in _settings(chosen) if method in {"", one.method})


@cache
def _settings(case: Case) -> tuple[Setting, ...]:
    return case.settings()


@cache  # settings are told apart by their functions, so only those that `_settings` keeps come again
def _assessed(case: str, setting: Setting) -> Measured:
    return Measured(case=case, method=setting.method, setting=setting.setting, **asdict(setting.assess()))
