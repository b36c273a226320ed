"""What a comparison of laws hands on: the ranking, the nested tests and what to know before reading them."""

import math
from dataclasses import dataclass
from typing import Any, Literal

from ropefric.errors import UnknownNameError
from ropefric.files.digits import rounded_tree
from ropefric.fitting.criteria import FTest
from ropefric.fitting.result import FitResult
from ropefric.registry import did_you_mean

Unit = Literal["conditions", "trials"]
_DIGITS = 6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ComparisonEntry:
    """One law in a comparison; NaN where there is no such number."""

    law: str
    n: int
    k: int
    chi2: float
    aicc: float
    bic: float
    delta_aicc: float
    weight: float
    loco_error: float
    status: str
    counted: bool
    note: str
    fit: FitResult | None

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON object of the entry; None where there is no number."""
        numbers = ("chi2", "aicc", "delta_aicc", "weight", "bic", "loco_error")
        values = {name: getattr(self, name) for name in numbers}
        plain = {name: float(value) if math.isfinite(value) else None for name, value in values.items()}
        return {
            "law": self.law,
            "n": self.n,
            "k": self.k,
            "status": self.status,
            "counted": self.counted,
            "note": self.note,
        } | _rounded(plain)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Comparison:
    """Laws on one trial table, best first.

    Attributes
    ----------
    ranking : tuple of ComparisonEntry
        Counted laws by AICc, then the others.
    tests : tuple of FTest
        Nested pairs, on the same observations.
    unit : {"conditions", "trials"}
        What an observation is.
    n, n_trials : int
        Observations and trials.
    scatter_within : float
        Standard deviation of ln F_A between repeats [-]; NaN without repeats.
    notes : tuple of str
        What to know before reading the ranking.
    """

    ranking: tuple[ComparisonEntry, ...]
    tests: tuple[FTest, ...]
    unit: Unit
    n: int
    n_trials: int
    scatter_within: float
    notes: tuple[str, ...]

    @property
    def best(self) -> ComparisonEntry:
        """Return the entry that won."""
        return self.ranking[0]

    @property
    def conclusive(self) -> bool:
        """Return whether laws could be weighed against each other, so that the first of the ranking was chosen."""
        return self.best.counted and not math.isnan(self.best.weight)

    def __getitem__(self, law: str) -> ComparisonEntry:
        for entry in self.ranking:
            if entry.law == law:
                return entry
        known = [entry.law for entry in self.ranking]
        raise UnknownNameError(f"{law!r} is not in this comparison", fix=did_you_mean(law, known))

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON shape: `ranking` best first, F-tests and notes; weights are null if not `conclusive`."""
        return _rounded({
            "ranking": [entry.to_dict() for entry in self.ranking],
            "f_tests": [
                {"simpler": t.simpler, "fuller": t.fuller, "f": t.f if math.isfinite(t.f) else None,
                 "dof": list(t.dof), "p_value": t.p_value}
                for t in self.tests
            ],
            "unit": self.unit,
            "n": self.n,
            "n_trials": self.n_trials,
            "scatter_within": self.scatter_within if math.isfinite(self.scatter_within) else None,
            "conclusive": self.conclusive,
            "notes": list(self.notes),
        })  # fmt: skip


def _rounded(tree: dict[str, Any]) -> dict[str, Any]:
    """Return numbers to six digits: criteria are differences of logarithms, weights and p-values their powers."""
    plain: dict[str, Any] = rounded_tree(tree, _DIGITS)
    return plain
