"""What a prediction hands on: lift forces with their intervals, and what to know before trusting them."""

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.files.digits import rounded_tree
from ropefric.fitting.extrapolation import Validity, outside_words
from ropefric.fitting.judgement import Doubt, Verdict, doubts_of_interval, verdict_of
from ropefric.friction.condition import Conditions

Method = Literal["linear", "monte-carlo"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """What one of several laws that are not told apart answers: lift force, its standard deviation and interval."""

    law: str
    lift_force_N: float
    std_N: float
    interval_N: tuple[float, float]

    def to_dict(self) -> dict[str, Any]:
        """Return a JSON tree; None where there is no number."""
        return {
            "law": self.law,
            "lift_force_N": self.lift_force_N,
            "std_N": _number(self.std_N),
            "interval_N": [_number(end) for end in self.interval_N],
        }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Prediction:
    """Lift forces of a fitted law for n conditions, with what is known about them.

    Attributes
    ----------
    law : str
        The law.
    conditions : Conditions
        n conditions.
    log_lift, std_log : ndarray, shape (n,)
        ln(F_A / 1 N) of the mean law and its standard deviation [-].
    lift_force_N, std_N : ndarray, shape (n,)
        F_A [N] and its standard deviation F_A · std_log [N].
    interval_N : ndarray, shape (n, 2)
        Confidence interval of the mean law [N]: where the average of many ropes lies. It is made in ln F_A and
        so is longer upward.
    prediction_interval_N : ndarray, shape (n, 2)
        Where the F_A of one pull with one new rope lies [N]: the scatter between repeats and between
        conditions comes on top. NaN where the fit knows no scatter.
    level : float
        Level of both.
    dof : float
        Degrees of freedom of Student's t in them; 0 where nothing is left to estimate a scatter from, so that there
        is no standard deviation and no interval (NaN).
    method : {"linear", "monte-carlo"}
        How the uncertainty of the law was carried over.
    linear_agrees : ndarray of bool, shape (n,), or None
        Whether the ends of the linear and of the Monte-Carlo interval agree within 10 % of its half width;
        None where this was not looked at.
    drawn_interval_N : ndarray, shape (n, 2), or None
        The Monte-Carlo interval [N], where it was made.
    outside : ndarray of bool, shape (n, 4)
        Which of R_w, R_r, φ, F_B lie outside the tested range.
    validity : mapping
        Lowest and highest tested value of each.
    draws, seed : int
        Monte-Carlo draws and their seed; 0 draws if there were none.
    judged : Verdict
        On the law: by its own fit, or by the comparison it comes from.
    candidates : tuple of Candidate
        What the laws answer that the data do not tell apart, the law used first; empty where there is one only.
    """

    law: str
    conditions: Conditions
    log_lift: FloatArray
    std_log: FloatArray
    lift_force_N: FloatArray
    std_N: FloatArray
    interval_N: FloatArray
    prediction_interval_N: FloatArray
    level: float
    dof: float
    method: Method
    linear_agrees: BoolArray | None
    drawn_interval_N: FloatArray | None
    outside: BoolArray
    validity: Validity
    draws: int
    seed: int
    judged: Verdict
    candidates: tuple[Candidate, ...] = ()

    def __len__(self) -> int:
        return len(self.conditions)

    @property
    def extrapolated(self) -> BoolArray:
        """Return which conditions lie outside the tested range in any regressor, shape (n,)."""
        return np.asarray(self.outside.any(axis=1))

    @property
    def log_half_width(self) -> FloatArray:
        """Return half the confidence interval of ln F_A, shape (n,)."""
        return np.asarray(0.5 * np.diff(np.log(self.interval_N), axis=1)[:, 0])

    @property
    def spread_N(self) -> tuple[float, float] | None:
        """Return the lowest and highest end of the candidates' intervals, or of their forces where one has none."""
        if not self.candidates:
            return None
        ends = [end for item in self.candidates for end in (*item.interval_N, item.lift_force_N)]
        known = [end for end in ends if math.isfinite(end)]
        return min(known), max(known)

    def verdict(self, index: int = 0) -> Verdict:
        """Return the verdict on the lift force of one condition: that on the law, and on the interval."""
        doubts: list[Doubt] = [(self.judged.word, text) for text in self.judged.reasons]
        if self.linear_agrees is not None and not self.linear_agrees[index]:
            drawn = None if self.drawn_interval_N is None else self.drawn_interval_N[index]
            linear = self.interval_N[index]
            if self.method == "linear":
                doubts += doubts_of_interval(linear, drawn, self._disagreement(index))
        return verdict_of(doubts, self.judged.reason.removesuffix("."))

    def notes(self, index: int = 0) -> tuple[str, ...]:
        """Return what to know about one condition before trusting its numbers; empty if nothing."""
        notes = list(outside_words(self.validity, self.conditions, index))
        if self.linear_agrees is not None and not self.linear_agrees[index]:
            notes.append(self._disagreement(index))
        return tuple(notes)

    def _disagreement(self, index: int) -> str:
        text = "the interval depends on how the parameters' uncertainty is carried over: linearly"
        if self.drawn_interval_N is None:
            return f"{text} only, for the law has no answer for most of what they may be"
        (near, far), (low, high) = self.interval_N[index], self.drawn_interval_N[index]
        return f"{text} {near:.4g}–{far:.4g} N, drawn from their covariance {low:.4g}–{high:.4g} N"

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON shape: one flat object for one condition, `{"predictions": [...]}` for several."""
        rows = [self._row(i) for i in range(len(self))]
        return rows[0] if len(rows) == 1 else {"predictions": rows}

    def _row(self, i: int) -> dict[str, Any]:
        at = self.conditions
        given = {
            "law": self.law,
            "wheel_radius_m": float(at.wheel_radius_m[i]),
            "rope_radius_m": float(at.rope_radius_m[i]),
            "wrap_angle_rad": float(at.wrap_angle_rad[i]),
            "end_tension_N": float(at.end_tension_N[i]),
        }
        found = {
            "lift_force_N": float(self.lift_force_N[i]),
            "std_N": _number(self.std_N[i]),
            "interval_N": [_number(end) for end in self.interval_N[i]],
            "prediction_interval_N": [_number(end) for end in self.prediction_interval_N[i]],
            "level": self.level,
            "dof": _number(self.dof),
            "extrapolated": bool(self.extrapolated[i]),
            "method": self.method,
            "linear_agrees": None if self.linear_agrees is None else bool(self.linear_agrees[i]),
            "notes": list(self.notes(i)),
            "verdict": self.verdict(i).to_dict(),
            "candidates": [item.to_dict() for item in self.candidates],
            "spread_N": None if self.spread_N is None else list(self.spread_N),
        }
        return given | dict(rounded_tree(found))


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
