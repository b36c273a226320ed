"""From a trial table to the law that is used and the lift force it predicts."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ropefric.errors import RopefricError
from ropefric.fitting.choice import Choice, choose_law
from ropefric.fitting.compare import Comparison, compare_laws
from ropefric.fitting.diagnose import Diagnosis, diagnose
from ropefric.fitting.predict import Prediction, predict
from ropefric.fitting.result import FitResult
from ropefric.fitting.verdict import Verdict
from ropefric.friction.condition import Conditions, one_condition
from ropefric.friction.laws import LAWS
from ropefric.trials.campaign_model import DesignWheel
from ropefric.trials.table import TrialTable

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CampaignAnswer:
    """What a trial table says."""

    table: TrialTable
    comparison: Comparison
    winner: Choice
    diagnosis: Diagnosis
    prediction: Prediction | None
    doubts: tuple[str, ...]

    @property
    def fit(self) -> FitResult:
        """Return the fit of the law that is used."""
        return self.winner.fit

    @property
    def verdict(self) -> Verdict:
        """Return the verdict: on the lift force where there is one, which holds that on the law, else on the law."""
        return self.winner.verdict if self.prediction is None else self.prediction.verdict()

    @property
    def fits(self) -> tuple[FitResult, ...]:
        """Return the fits of all laws that have one, best first."""
        return tuple(entry.fit for entry in self.comparison.ranking if entry.fit is not None)

    def to_dict(self) -> dict[str, Any]:
        """Return ranking, fit, prediction and diagnosis as a JSON tree."""
        return {
            **self.comparison.to_dict(),
            "law": self.fit.law,
            "verdict": self.verdict.to_dict(),
            "fit": self.fit.to_dict(),
            "prediction": None if self.prediction is None else self.prediction.to_dict(),
            "diagnosis": self.diagnosis.to_dict(),
            "doubts": list(self.doubts),
        }


def answer_trials(
    table: TrialTable,
    *,
    design: DesignWheel | None = None,
    rope_radius_m: float | None = None,
    law: str = "",
    progress: Progress | None = None,
) -> CampaignAnswer:
    """Return which law a trial table asks for, what it supports, and the lift force of a design."""
    laws = [*LAWS, law] if law and law not in LAWS else None
    comparison = compare_laws(table, laws, progress=progress)
    wheel, refused = _wheel(table, design, rope_radius_m)
    winner = choose_law(comparison, law, wheel)
    prediction = None
    if wheel is not None:
        try:
            prediction = winner.of(predict(winner.fit, wheel))
        except RopefricError as error:
            refused = (_refusal(error),)
    return CampaignAnswer(
        table=table,
        comparison=comparison,
        winner=winner,
        diagnosis=diagnose(table, comparison),
        prediction=prediction,
        doubts=tuple(dict.fromkeys((*winner.doubts, *winner.fit.advice, *comparison.notes[1:], *refused))),
    )


def _wheel(
    table: TrialTable, design: DesignWheel | None, rope_radius_m: float | None
) -> tuple[Conditions | None, tuple[str, ...]]:
    """Return the wheel of a design, or None and why there is none."""
    if design is None:
        return None, ()
    rope_m = float(np.median(table.rope_radius_m[table.used])) if rope_radius_m is None else rope_radius_m
    try:
        return one_condition(design.wheel_radius_m, rope_m, design.wrap_angle_rad, design.end_tension_N), ()
    except RopefricError as error:
        return None, (_refusal(error),)


def _refusal(error: RopefricError) -> str:
    return f"no lift force for the design: {error}"
