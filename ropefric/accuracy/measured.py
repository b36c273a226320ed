"""One measured point of a study, and what follows from many: the front, and the cheapest for an accuracy."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from math import isfinite, nan
from typing import Any

__all__ = ["ACCURACIES", "ROUNDING", "Measured", "cheapest", "in_case", "pareto_front"]

ACCURACIES = tuple(10.0**-n for n in range(2, 13))
"""The relative accuracies a page answers for, 1e-2 … 1e-12."""

ROUNDING = 2.0**-53
"""Errors below half a unit in the last place are luck, and all the same."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """Error and time of one setting.

    Attributes
    ----------
    case, method, setting : str
        What was measured.
    error : float
        Relative error against the reference [-].
    seconds : float
        Median time of one call [s].
    lower_s, upper_s : float
        First and third quartile of the time of one call [s].
    repeats, loops : int
        How many times were taken, and how many calls stood behind each.
    evaluations : float
        Work in the unit of the study.
    bias, noise : float
        See `Outcome`.

    Examples
    --------
    >>> point = Measured(case="c", method="m", setting="", error=0.0, seconds=1e-6, lower_s=1e-6, upper_s=2e-6,
    ...     repeats=5, loops=10, evaluations=1)
    >>> point.spread_s, point.name
    (1e-06, 'm')
    """

    case: str
    method: str
    setting: str
    error: float
    seconds: float
    lower_s: float
    upper_s: float
    repeats: int
    loops: int
    evaluations: float
    bias: float = nan
    noise: float = nan

    @property
    def spread_s(self) -> float:
        """Return the range between the quartiles [s]."""
        return self.upper_s - self.lower_s

    @property
    def name(self) -> str:
        """Return method and setting in one."""
        return f"{self.method}, {self.setting}" if self.setting else self.method

    @property
    def shown_error(self) -> float:
        """Return the error, not below rounding."""
        return max(self.error, ROUNDING)

    def to_dict(self) -> dict[str, Any]:
        """Return the point as plain data, None where there is no number."""
        tree = asdict(self) | {"spread_s": self.spread_s}
        return {
            key: None if isinstance(value, float) and not isfinite(value) else value
            for key, value in tree.items()
        }


def in_case(points: Iterable[Measured], case: str) -> tuple[Measured, ...]:
    """Return the points of one case.

    Examples
    --------
    >>> in_case((), "regular")
    ()
    """
    return tuple(point for point in points if point.case == case)


def pareto_front(points: Iterable[Measured]) -> tuple[Measured, ...]:
    """Return the points that no other point beats in both error and time, fastest first.

    Parameters
    ----------
    points : iterable of Measured
        Of one case; those without an answer are on no front.

    Examples
    --------
    >>> common = dict(case="c", setting="", lower_s=0.0, upper_s=0.0, repeats=1, loops=1, evaluations=1)
    >>> points = [Measured(method=name, error=error, seconds=time, **common)
    ...     for name, error, time in [("slow", 1e-3, 3.0), ("good", 1e-3, 2.0), ("rough", 0.1, 1.0)]]
    >>> [point.method for point in pareto_front(points)]
    ['rough', 'good']
    """
    front: list[Measured] = []
    for point in sorted(points, key=lambda point: (point.seconds, point.shown_error)):
        if isfinite(point.error) and (not front or point.shown_error < front[-1].shown_error):
            front.append(point)
    return tuple(front)


def cheapest(points: Iterable[Measured], accuracy: float) -> Measured | None:
    """Return the fastest point with an error of at most `accuracy`; None if there is none.

    Examples
    --------
    >>> cheapest((), 1e-6) is None
    True
    """
    good = (point for point in points if point.error <= accuracy)
    return min(good, key=lambda point: point.seconds, default=None)
