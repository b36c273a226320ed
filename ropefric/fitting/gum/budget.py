"""The law of propagation of uncertainty (JCGM 100): one line a source, their sum, and the expanded uncertainty."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.fitting.gum.model import MeasurementModel
from ropefric.fitting.gum.quantity import Block, Evaluation, Quantity
from ropefric.fitting.propagation import quantile


@dataclass(frozen=True, slots=True, kw_only=True)
class Direction:
    """An independent direction of a block: its quantities change together by one standard uncertainty."""

    changes: Mapping[str, float]
    contribution: float


@dataclass(frozen=True, slots=True, kw_only=True)
class BudgetLine:
    """One source of uncertainty."""

    source: Quantity | Block
    sensitivity: float
    contribution: float
    share: float
    directions: tuple[Direction, ...] = ()

    @property
    def name(self) -> str:
        """Return what it is, in words."""
        return self.source.name

    @property
    def label(self) -> str:
        """Return its name, with the word where its uncertainty is assumed and nobody stated it."""
        assumed = isinstance(self.source, Quantity) and self.source.assumed
        return f"{self.name} (assumed)" if assumed else self.name

    @property
    def type(self) -> Evaluation:
        """Return how it was evaluated, "A" or "B"."""
        return self.source.type

    @property
    def dof(self) -> float:
        """Return its degrees of freedom."""
        return self.source.dof

    def to_dict(self) -> dict[str, Any]:
        """Return the line as JSON-able values; what a block has none of is None."""
        row: dict[str, Any] = {
            "name": self.name,
            "type": self.type,
            "contribution": self.contribution,
            "share": self.share,
            "dof": self.dof if math.isfinite(self.dof) else None,
        }
        if isinstance(self.source, Quantity):
            item = self.source
            return row | {
                "symbol": item.symbol,
                "unit": item.unit,
                "estimate": item.estimate,
                "stated": item.stated,
                "divisor": item.divisor,
                "standard_uncertainty": item.std,
                "distribution": item.distribution,
                "sensitivity": self.sensitivity,
                "assumed": item.assumed or None,
                "correlated": [],
            }
        return row | {
            "symbol": ", ".join(self.source.symbols),
            "unit": None,
            "estimate": None,
            "stated": None,
            "divisor": None,
            "standard_uncertainty": None,
            "distribution": "multivariate normal" if math.isinf(self.dof) else "multivariate t",
            "sensitivity": None,
            "correlated": [
                {"changes": dict(part.changes), "contribution": part.contribution} for part in self.directions
            ],
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearBudget:
    """Lines of a budget with their sum."""

    estimate: float
    lines: tuple[BudgetLine, ...]
    combined: float
    effective_dof: float
    level: float
    coverage_factor: float

    @property
    def expanded(self) -> float:
        """Return the expanded uncertainty U = k u_c."""
        return self.coverage_factor * self.combined

    @property
    def interval(self) -> tuple[float, float]:
        """Return y − U and y + U."""
        return self.estimate - self.expanded, self.estimate + self.expanded


def effective_dof(contributions: Sequence[float], dof: Sequence[float]) -> float:
    """Return ν_eff = u_c⁴/Σ(uᵢ⁴/νᵢ), eq. (G.2b) of JCGM 100; infinite if all are.

    It holds for independent contributions; one that comes from correlated quantities enters as a whole, with the
    degrees of freedom of their covariance.
    """
    total = math.fsum(u**4 / nu for u, nu in zip(contributions, dof, strict=True) if u > 0.0)
    return math.hypot(*contributions) ** 4 / total if total > 0.0 else math.inf


def linear_budget(model: MeasurementModel, *, level: float = 0.95) -> LinearBudget:
    """Return the budget of a measurement equation by the law of propagation of uncertainty, eq. (10) of JCGM 100."""
    if not 0.0 < level < 1.0:
        raise InputError(
            f"the level is {level:g}", key="level", fix="give a level between 0 and 1, such as 0.95"
        )
    k = len(model.quantities)
    found: list[tuple[Quantity | Block, float, float, tuple[Direction, ...]]] = [
        (item, float(c), abs(float(c)) * item.std, ())
        for item, c in zip(model.quantities, model.sensitivities[:k], strict=True)
    ]
    if model.block is not None:
        directions = _directions(model.block, model.sensitivities[k:])
        found.append((model.block, math.nan, math.hypot(*(d.contribution for d in directions)), directions))
    combined = math.hypot(*(contribution for _, _, contribution, _ in found))
    if combined == 0.0:
        raise InputError(
            f"nothing that goes into {model.name} is uncertain", key=model.name, fix="give an uncertainty"
        )
    lines = [
        BudgetLine(
            source=source,
            sensitivity=c,
            contribution=contribution,
            share=(contribution / combined) ** 2,
            directions=directions,
        )
        for source, c, contribution, directions in found
    ]
    dof = effective_dof([line.contribution for line in lines], [line.dof for line in lines])
    return LinearBudget(
        estimate=model.estimate,
        lines=tuple(sorted(lines, key=lambda line: -line.contribution)),
        combined=combined,
        effective_dof=dof,
        level=level,
        coverage_factor=quantile(0.5 + 0.5 * level, dof),
    )


def _directions(block: Block, sensitivities: FloatArray) -> tuple[Direction, ...]:
    """Return the directions of a block, the one that matters most first."""
    columns = block.directions()
    worth = sensitivities @ columns
    order = np.argsort(-np.abs(worth), kind="stable")
    return tuple(
        Direction(
            changes=dict(zip(block.symbols, columns[:, i].tolist(), strict=True)),
            contribution=float(worth[i]),
        )
        for i in order
    )
