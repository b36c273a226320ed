"""What a fit is worth, in one word; the word's text is advice."""

from collections.abc import Iterable
from enum import StrEnum


class FitStatus(StrEnum):
    """What became of a fit, from good to bad."""

    OK = "ok"
    EXTREME_SCATTER = "extreme-scatter"
    RESIDUAL_STRUCTURE = "residual-structure"
    AT_BOUND = "at-bound"
    UNIDENTIFIABLE = "unidentifiable"
    TOO_FEW_POINTS = "too-few-points"
    NOT_CONVERGED = "not-converged"

    @property
    def advice(self) -> str:
        """Return what the status means and what to do."""
        return ADVICE[self]


ADVICE: dict[FitStatus, str] = {
    FitStatus.OK: "The parameters are determined by the data within their intervals.",
    FitStatus.EXTREME_SCATTER: (
        "The repeats scatter so widely that the logarithm of the force is no longer its own mean. Find the cause "
        "in the recordings before using the law."
    ),
    FitStatus.RESIDUAL_STRUCTURE: (
        "What the law leaves over follows the wrap, the size or the load, so the law misses an effect. "
        "Compare other laws before using this one."
    ),
    FitStatus.AT_BOUND: (
        "A parameter lies on its bound, and that is not a measurement of it. Use the simpler law it amounts to, "
        "or measure the conditions that would show it."
    ),
    FitStatus.UNIDENTIFIABLE: (
        "The data cannot tell all parameters apart. Fix one of them, use a simpler law, or measure the conditions "
        "that are named."
    ),
    FitStatus.TOO_FEW_POINTS: "There are fewer conditions than parameters. Measure more, or use a simpler law.",
    FitStatus.NOT_CONVERGED: "The search did not reach a minimum. Give start values, or use a simpler law.",
}
"""What each status means and what to do about it."""

_ORDER = {status: rank for rank, status in enumerate(FitStatus)}


def worst(statuses: Iterable[FitStatus]) -> FitStatus:
    """Return the gravest of some statuses, OK for none."""
    return max(statuses, key=_ORDER.__getitem__, default=FitStatus.OK)
