"""One measured point of a study, and what follows from many: the front, and the cheapest for an accuracy."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from math import isfinite, nan
from typing import Any

ACCURACIES = tuple(10.0**-n for n in range(2, 13))
"""The relative accuracies a page answers for, 1e-2 … 1e-12."""

ROUNDING = 2.0**-53
"""Errors below half a unit in the last place are luck, and all the same."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """Error and time of one setting."""

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
    """Return the points of one case."""
    return tuple(point for point in points if point.case == case)


def pareto_front(points: Iterable[Measured]) -> tuple[Measured, ...]:
    """Return the points that no other point beats in both error and time, fastest first."""
    front: list[Measured] = []
    for point in sorted(points, key=lambda point: (point.seconds, point.shown_error)):
        if isfinite(point.error) and (not front or point.shown_error < front[-1].shown_error):
            front.append(point)
    return tuple(front)


def cheapest(points: Iterable[Measured], accuracy: float) -> Measured | None:
    """Return the fastest point with an error of at most `accuracy`; None if there is none."""
    good = (point for point in points if point.error <= accuracy)
    return min(good, key=lambda point: point.seconds, default=None)
