"""Measuring studies: the error and the time of every setting, one after another."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ropefric.accuracy.measured import ACCURACIES, Measured, cheapest, in_case, pareto_front
from ropefric.accuracy.study import Setting, Study
from ropefric.accuracy.timing import FULL, QUICK, Effort, time_call

__all__ = ["StudyResult", "measure_studies", "measure_study"]

Progress = Callable[[int, int, str], None]

_UNSTEADY = 0.5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StudyResult:
    """What was measured of one study.

    Attributes
    ----------
    study : Study
        The study.
    points : tuple of Measured
        In the order of its cases and settings.
    quick : bool
        Whether only the quick settings were measured.
    """

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
    """Return the error and time of every setting of a study.

    Parameters
    ----------
    study : Study
        The study.
    quick : bool
        Measure the quick settings only, with little time for each.
    effort : Effort, optional
        Time spent on each; by default that of a quick or a full measurement.
    progress : callable, optional
        Called with (done, total, what) after every setting.

    Examples
    --------
    >>> from ropefric.accuracy.study import Case, Outcome
    >>> one = Setting(method="m", setting="", call=lambda: 1.0, assess=lambda: Outcome(error=0.0, evaluations=1))
    >>> case = Case(name="c", title="", settings=lambda: (one,))
    >>> study = Study(name="s", title="", question="", reference="", counted="", cases=(case,))
    >>> [point.method for point in measure_study(study, quick=True).points]
    ['m']
    """
    return measure_studies([study], quick=quick, effort=effort, progress=progress)[0]


def measure_studies(
    studies: Sequence[Study],
    *,
    quick: bool = False,
    effort: Effort | None = None,
    progress: Progress | None = None,
) -> tuple[StudyResult, ...]:
    """Return the result of each study; parameters as in `measure_study`.

    Examples
    --------
    >>> measure_studies([])
    ()
    """
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
