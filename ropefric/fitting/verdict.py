"""The one verdict on a law and on what it predicts: supported, undecided or not judged, with the reason in words.

All rules stand here, and the terminal, the report, JSON and the exit code say what they say.

not judged
    The data leave no choice or no test: the fit has not converged, the data do not show its parameters or only one
    end of their range, there are fewer than `spare` = 3 more conditions than fitted parameters (as for AICc, which
    has no value below n = k + 2 with the scatter among the k), or no law but one could be weighed.
undecided
    Something speaks against the law. Its own fit: the residuals follow a regressor, the repeats scatter extremely,
    or the conditions scatter more than twice as far as their repeats (a third or more of the residuals then lie
    beyond ±2 of the scatter between repeats) while fewer than ten conditions are left over, too few to show whether
    that is a new rope each time or an effect the law misses; with ten, a trend would have been found, and the
    scatter counts as scatter, which the clustered errors and the prediction interval hold. Another law: one that
    stands more than 2 in AICc before it (an evidence ratio of e), or one within 2 that gives another lift force.
    The interval: the linear one and the one drawn from the parameters' covariance differ by more than a half width.
supported
    Otherwise. A law within 2 that gives the same lift force is no contradiction. Two laws of which neither is a
    special case of the other do where the root mean square of ln F_A between them lies within the half width of the
    used law's interval, and the intervals differ by no more than a factor 2. A law and a richer one that contains
    it do where it lies within both half widths, added as squares: what the richer law knows of its extra effect is
    in its own, wider interval, and that it is wider says nothing against the simpler law.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Literal

import numpy as np
from scipy.special import fdtrc

from ropefric.arrays import FloatArray
from ropefric.fitting.statistics import FitStatistics
from ropefric.glossary import counted


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

Word = Literal["supported", "undecided", "not judged"]
Doubt = tuple[Word, str]
"""The word a finding calls for, and the finding; "supported" for one that is only to be known."""

RIVAL = 2.0
"""Difference in AICc up to which two laws are not told apart."""

_WORDS: tuple[Word, ...] = ("supported", "undecided", "not judged")
_ONLY_DOUBTED = (FitStatus.EXTREME_SCATTER, FitStatus.RESIDUAL_STRUCTURE)
# Conditions beyond the fitted parameters: one for the scatter, one more for the small-sample term of AICc.
_SPARE = 3
_MANY_SPARE = 10
_SCATTER_RATIO = 2.0
_LACK_OF_FIT_P = 1e-3
_WIDTHS = 2.0
# Forces that agree to this are the same whatever their intervals.
_SAME = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """What is to be thought of a law, or of a lift force."""

    word: Word
    reasons: tuple[str, ...]

    @property
    def supported(self) -> bool:
        """Return whether the result may be used as it stands."""
        return self.word == "supported"

    @property
    def reason(self) -> str:
        """Return the reasons as one text."""
        return " ".join(text if text.endswith((".", ")")) else f"{text}." for text in self.reasons)

    def to_dict(self) -> dict[str, Any]:
        """Return a JSON tree."""
        return {"word": self.word, "reason": self.reason, "reasons": list(self.reasons)}


def verdict_of(doubts: Iterable[Doubt], otherwise: str) -> Verdict:
    """Return the gravest word that doubts call for, with all that call for one; `otherwise` is why there is none."""
    grave = sorted((doubt for doubt in doubts if doubt[0] != "supported"), key=lambda d: -_WORDS.index(d[0]))
    if not grave:
        return Verdict(word="supported", reasons=(otherwise,))
    return Verdict(word=grave[0][0], reasons=tuple(dict.fromkeys(text for _, text in grave)))


def doubts_of_fit(
    law: str, status: FitStatus, advice: tuple[str, ...], found: FitStatistics
) -> tuple[Doubt, ...]:
    """Return what speaks against a law in its own fit."""
    doubts: list[Doubt] = []
    if status is not FitStatus.OK:
        word: Word = "undecided" if status in _ONLY_DOUBTED else "not judged"
        doubts.append((word, advice[0] if advice else status.advice))
    n, n_fitted = found.n_conditions, found.n - found.dof
    within, between, spare = found.scatter_within, found.scatter_between, n - n_fitted
    if spare < _SPARE and status is not FitStatus.TOO_FEW_POINTS:
        text = (
            f"{counted(n, 'condition')} cannot test {counted(n_fitted, 'fitted parameter')} of {law}: "
            f"{n_fitted + _SPARE} are needed"
        )
        doubts.append(("not judged", text))
    elif spare < _MANY_SPARE and between > _SCATTER_RATIO * within:
        F = 1.0 + found.n / n * (between / within) ** 2
        if float(fdtrc(spare, found.n - n, F)) < _LACK_OF_FIT_P:
            text = (
                f"the conditions lie {between:.2%} off {law}, their repeats scatter by {within:.2%}: "
                f"{n} conditions do not show whether that is a new rope each time or an effect it misses"
            )
            doubts.append(("undecided", text))
    return tuple(doubts)


def doubts_of_interval(linear: FloatArray, drawn: FloatArray | None, words: str) -> tuple[Doubt, ...]:
    """Return the doubt that a linear and a drawn interval disagree grossly, or that nothing could be drawn."""
    if drawn is None:
        return (("undecided", words),)
    half = 0.5 * float(linear[1] - linear[0])
    apart = float(np.abs(drawn - linear).max())
    return (("undecided", words),) if apart > half + _SAME * float(np.abs(linear).max()) else ()


def same_lift(
    difference: FloatArray, half_width: FloatArray, rival_half_width: FloatArray, *, nested: bool
) -> bool:
    """Return whether two laws give the same lift force, by root mean squares over n conditions."""
    apart, own, others = (
        math.sqrt(float(np.mean(values**2))) for values in (difference, half_width, rival_half_width)
    )
    if apart <= _SAME:
        return True
    if nested:
        return apart <= math.hypot(own, others)
    return apart <= own and own / _WIDTHS <= others <= own * _WIDTHS
