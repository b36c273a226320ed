"""The lift force all laws of a comparison agree on, each by its weight, with their disagreement in the error."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.fitting.comparison import Comparison
from ropefric.fitting.predict import predict
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import ALL_LAWS

_LEAST_WEIGHT = 1e-4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModelAverage:
    """Lift forces averaged over the laws of a comparison, for n conditions."""

    lift_force_N: FloatArray
    std_N: FloatArray
    log_lift: FloatArray
    std_log: FloatArray
    std_between_laws: FloatArray
    extrapolated: np.ndarray[tuple[int], np.dtype[np.bool_]]
    weights: dict[str, float]
    left_out: dict[str, str]

    def to_dict(self) -> dict[str, Any]:
        """Return a JSON tree."""
        arrays = ("lift_force_N", "std_N", "log_lift", "std_log", "std_between_laws", "extrapolated")
        tree = {name: getattr(self, name).tolist() for name in arrays}
        return tree | {"weights": dict(self.weights), "left_out": dict(self.left_out)}


def averaged_prediction(comparison: Comparison, conditions: Conditions) -> ModelAverage:
    """Return the lift force averaged over the counted laws of a comparison.

    With weights w and the laws' ln F_A η ± s: mean η̄ = Σ w η and variance Σ w (s² + (η − η̄)²) (Burnham and
    Anderson 2002, eq. 4.9 in its revised form). Laws below a weight of 1e-4 are left away.
    """
    if not comparison.conclusive:
        raise InputError(
            "the laws of this comparison could not be weighed against each other",
            code="RF420",
            fix="measure more conditions, or predict with one law",
        )
    parts, left_out = [], {}
    for entry in comparison.ranking:
        if entry.fit is None or entry.weight < _LEAST_WEIGHT:
            continue
        problems = ALL_LAWS[entry.law].validity(entry.fit.theta, conditions)
        if problems:
            left_out[entry.law] = problems[0]
        else:
            parts.append((entry, predict(entry.fit, conditions, check=False)))
    total = math.fsum(entry.weight for entry, _ in parts)
    if total <= 0.0:
        raise InputError(
            "no law of this comparison has an answer for all conditions",
            code="RF420",
            fix="; ".join(f"{law}: {why}" for law, why in left_out.items()) or "compare more laws",
        )
    weight = np.array([[entry.weight / total] for entry, _ in parts])
    eta = np.stack([prediction.log_lift for _, prediction in parts])
    std = np.stack([prediction.std_log for _, prediction in parts])
    mean = (weight * eta).sum(axis=0)
    between = (weight * (eta - mean) ** 2).sum(axis=0)
    std_log = np.sqrt((weight * std**2).sum(axis=0) + between)
    lift = np.exp(mean)
    return ModelAverage(
        lift_force_N=lift,
        std_N=lift * std_log,
        log_lift=mean,
        std_log=std_log,
        std_between_laws=np.sqrt(between),
        extrapolated=parts[0][1].extrapolated,
        weights={entry.law: float(w) for (entry, _), (w,) in zip(parts, weight, strict=True)},
        left_out=left_out,
    )
