"""What a plan of tests hands on: its conditions, and how certain the wanted prediction is before and after."""

import csv
import io
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.fitting.planning.exchange import Criterion
from ropefric.fitting.planning.precision import PlannedLaw
from ropefric.friction.condition import Conditions
from ropefric.uncertainty.quantity import quantile

SCHEMA = "ropefric.test-plan/1"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Outlook:
    """How certain predictions are expected to be."""

    std_log: FloatArray
    dof: int
    level: float

    @property
    def half_width_log(self) -> FloatArray:
        """Return half the width of the interval of each ln F_A, t(dof) · std; infinite without degrees of freedom."""
        if not self.dof:
            return np.full_like(self.std_log, np.inf)
        return quantile(0.5 + 0.5 * self.level, float(self.dof)) * self.std_log

    def to_dict(self, lift_N: FloatArray) -> list[dict[str, Any]]:
        """Return standard error and interval [N] about lift forces; None where infinite."""
        half = self.half_width_log
        low_N, high_N = lift_N * np.exp(-half), lift_N * np.exp(np.minimum(half, 700.0))
        rows = []
        for i, std in enumerate(self.std_log.tolist()):
            ends = [float(low_N[i]), float(high_N[i])] if math.isfinite(half[i]) else [None, None]
            rows.append(
                {
                    "std_log": _number(std),
                    "std_N": _number(std * float(lift_N[i])),
                    "interval_N": ends,
                    "dof": self.dof,
                }
            )
        return rows


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LabPlan:
    """Conditions to test, and what they are expected to give.

    Attributes
    ----------
    planned : PlannedLaw
        What the plan was made for.
    conditions : Conditions
        n conditions, wheel by wheel.
    repeats : int
        Pulls of each.
    log_lift : ndarray, shape (n,)
        Expected ln F_A.
    wanted : Conditions
        The t predictions wanted.
    wanted_log_lift : ndarray, shape (t,)
        Their ln F_A by the parameters the plan was made for.
    criterion : {"v", "d"}
        What was made small.
    level : float
        Level of the intervals.
    parameter_std : ndarray, shape (q,)
        Standard errors of the free parameters expected with the plan.
    before, after : Outlook
        Without and with the plan.
    one_factor, one_factor_at_target : Outlook
        With a plan of the same size that varies one factor at a time about the middle of the rig's settings, or about
        the first wanted condition, in its stead.
    largest_force_N : float
        Of the cell [N].
    n_candidates : int
        Conditions to choose from.
    starts, agreeing_starts, seed : int
        Starts of the search, how many ended at this plan's value, and their seed.
    notes : tuple of str
        What to know about it.
    """

    planned: PlannedLaw
    conditions: Conditions
    repeats: int
    log_lift: FloatArray
    wanted: Conditions
    wanted_log_lift: FloatArray
    criterion: Criterion
    level: float
    parameter_std: FloatArray
    before: Outlook
    after: Outlook
    one_factor: Outlook
    one_factor_at_target: Outlook
    largest_force_N: float
    n_candidates: int
    starts: int
    agreeing_starts: int
    seed: int
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.conditions)

    @property
    def gain(self) -> float:
        """Return how much wider the intervals of ln F_A are with the one-factor plan about the middle [-]."""
        return _ratio(self.one_factor, self.after)

    @property
    def gain_at_target(self) -> float:
        """Return the same against the one-factor plan about the wanted condition [-]."""
        return _ratio(self.one_factor_at_target, self.after)

    @property
    def improvement(self) -> float:
        """Return how much wider they are without the plan [-]; infinite where nothing is known yet."""
        return _ratio(self.before, self.after)

    def expected_parameter_std(self) -> dict[str, float]:
        """Return the expected standard error of each parameter that is to be determined."""
        return dict(zip(self.planned.free_names, self.parameter_std.tolist(), strict=True))

    def rows(self) -> list[dict[str, Any]]:
        """Return the conditions as rows in SI, with the expected force and its part of what the cell takes."""
        at, lift_N = self.conditions, np.exp(self.log_lift)
        return [
            {
                "condition": i + 1,
                "wheel_radius_m": float(at.wheel_radius_m[i]),
                "rope_radius_m": float(at.rope_radius_m[i]),
                "wrap_angle_rad": float(at.wrap_angle_rad[i]),
                "end_tension_N": float(at.end_tension_N[i]),
                "repeats": self.repeats,
                "expected_lift_force_N": float(lift_N[i]),
                "cell_use": float(lift_N[i] / self.largest_force_N),
            }
            for i in range(len(self))
        ]

    def to_csv(self) -> str:
        r"""Return the plan as CSV for the lab: a row a condition, in millimetres, degrees and newtons."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        heads = ("wheel_radius_mm", "rope_diameter_mm", "wrap_angle_deg", "end_tension_N")
        writer.writerow(("condition", *heads, "repeats", "expected_lift_force_N"))
        for row in self.rows():
            settings = (
                1e3 * row["wheel_radius_m"],
                2e3 * row["rope_radius_m"],
                math.degrees(row["wrap_angle_rad"]),
                row["end_tension_N"],
            )
            force = f"{row['expected_lift_force_N']:.4g}"
            writer.writerow((row["condition"], *(f"{x:.10g}" for x in settings), row["repeats"], force))
        return text.getvalue()

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON tree of schema `ropefric.test-plan/1`; what is infinite is None."""
        law, lift_N, at = self.planned.law, np.exp(self.wanted_log_lift), self.wanted
        scatter = self.planned.scatter
        return {
            "schema": SCHEMA,
            "law": law.name,
            "parameters": law.as_mapping(self.planned.theta),
            "expected_std": self.expected_parameter_std(),
            "scatter": {
                "within": scatter.within,
                "between": scatter.between,
                "instrument_N": scatter.instrument_N,
            },
            "criterion": self.criterion,
            "conditions": self.rows(),
            "n_tests": len(self) * self.repeats,
            "wanted": [
                {
                    "wheel_radius_m": float(at.wheel_radius_m[i]),
                    "rope_radius_m": float(at.rope_radius_m[i]),
                    "wrap_angle_rad": float(at.wrap_angle_rad[i]),
                    "end_tension_N": float(at.end_tension_N[i]),
                    "lift_force_N": float(lift_N[i]),
                }
                for i in range(len(at))
            ],
            "level": self.level,
            "before": self.before.to_dict(lift_N),
            "after": self.after.to_dict(lift_N),
            "one_factor": self.one_factor.to_dict(lift_N),
            "one_factor_at_target": self.one_factor_at_target.to_dict(lift_N),
            "gain": _number(self.gain),
            "gain_at_target": _number(self.gain_at_target),
            "improvement": _number(self.improvement),
            "n_candidates": self.n_candidates,
            "starts": self.starts,
            "agreeing_starts": self.agreeing_starts,
            "seed": self.seed,
            "notes": list(self.notes),
        }


def _ratio(other: Outlook, own: Outlook) -> float:
    """Return the ratio of root-mean-square half widths; NaN where neither is finite."""
    wide = math.sqrt(float(np.mean(other.half_width_log**2)))
    narrow = math.sqrt(float(np.mean(own.half_width_log**2)))
    return math.nan if math.isinf(narrow) else wide / narrow


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
