"""Errors and counts: how one setting is judged against a reference."""

from collections.abc import Callable, Sequence
from typing import Generic, ParamSpec, TypeVar

import numpy as np
import numpy.typing as npt

from ropefric.accuracy.study import Outcome, Setting
from ropefric.arrays import FloatArray

P = ParamSpec("P")
R = TypeVar("R")


class Counted(Generic[P, R]):
    """A function that counts its calls, and the points it was called with."""

    def __init__(self, function: Callable[P, R]) -> None:
        self._function = function
        self.calls = 0
        self.points = 0

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """Return what the function returns."""
        self.calls += 1
        self.points += np.size(args[0]) if args else 1  # type: ignore[arg-type]  # anything has a size
        return self._function(*args, **kwargs)


def relative_errors(answer: npt.ArrayLike, reference: npt.ArrayLike) -> FloatArray:
    """Return answer/reference − 1; not a number where there is no answer."""
    exact = np.asarray(reference, dtype=np.float64)
    with np.errstate(invalid="ignore", over="ignore"):
        return np.asarray((np.asarray(answer, dtype=np.float64) - exact) / exact)


def largest_error(answer: npt.ArrayLike, reference: npt.ArrayLike) -> float:
    """Return the largest relative error; infinite where one answer is no number."""
    errors = np.abs(relative_errors(answer, reference))
    return float(errors.max()) if np.isfinite(errors).all() else float("inf")


def against(
    reference: npt.ArrayLike,
    function: Callable[P, R],
    solve: Callable[[Callable[P, R]], npt.ArrayLike],
    *,
    method: str,
    setting: str,
    quick: bool = True,
    counts: Callable[[Counted[P, R]], float] = lambda counted: counted.points,
    error: Callable[[npt.ArrayLike, npt.ArrayLike], float] = largest_error,
) -> Setting:
    """Return a setting that solves a problem given by a function, which is counted only while it is assessed."""

    def assess() -> Outcome:
        counted = Counted(function)
        answer = solve(counted)
        return Outcome(error=error(answer, reference), evaluations=counts(counted))

    return Setting(method=method, setting=setting, call=lambda: solve(function), assess=assess, quick=quick)


def over_seeds(errors: Sequence[float] | FloatArray, evaluations: float) -> Outcome:
    """Return the outcome of repetitions: root mean square, mean and standard deviation of their relative errors."""
    found = np.asarray(errors, dtype=np.float64)
    if not np.isfinite(found).all():
        return Outcome(error=float("inf"), evaluations=evaluations)
    return Outcome(
        error=float(np.sqrt(np.mean(found**2))),
        evaluations=evaluations,
        bias=float(found.mean()),
        noise=float(found.std(ddof=1)) if found.size > 1 else 0.0,
    )
