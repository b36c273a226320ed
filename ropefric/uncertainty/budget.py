"""The law of propagation of uncertainty (JCGM 100): one line a source, their sum, and the expanded uncertainty."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.uncertainty.quantity import Block, Evaluation, Quantity, check_level, directions, quantile


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeasurementModel:
    """A measurement equation y = f(x), x the k single quantities and then the q of a block."""

    name: str
    symbol: str
    unit: str
    quantities: tuple[Quantity, ...]
    evaluate: Callable[[FloatArray], FloatArray]
    sensitivities: FloatArray
    block: Block | None = None

    def __post_init__(self) -> None:
        if self.sensitivities.shape != self.inputs.shape:
            raise InputError(
                f"{self.name}: {self.sensitivities.size} sensitivities for {self.inputs.size} inputs",
                key=self.name,
            )
        if not (np.isfinite(self.estimate) and np.isfinite(self.sensitivities).all()):
            raise InputError(f"{self.name}: there is no answer at the estimates of the inputs", key=self.name)

    @property
    def inputs(self) -> FloatArray:
        """Return the estimates of all inputs, shape (k + q,)."""
        singles = np.array([item.estimate for item in self.quantities])
        return singles if self.block is None else np.concatenate([singles, self.block.estimates])

    @property
    def estimate(self) -> float:
        """Return y at the estimates of the inputs."""
        return float(self.evaluate(self.inputs[np.newaxis, :])[0])

    def draw(self, rng: np.random.Generator, n: int) -> FloatArray:
        """Return the answer to n draws of the inputs, shape (n,); NaN where there is none."""
        columns = [item.draw(rng, n)[:, np.newaxis] for item in self.quantities]
        if self.block is not None:
            columns.append(self.block.draw(rng, n))
        return self.evaluate(np.hstack(columns))


@dataclass(frozen=True, slots=True, kw_only=True)
class BudgetLine:
    """One source of uncertainty."""

    source: Quantity | Block
    sensitivity: float
    contribution: float
    share: float
    correlated: tuple[dict[str, Any], ...] = ()
    """For a block its independent directions: `changes` of its quantities together, and their `contribution`."""

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
        item = self.source
        row: dict[str, Any] = {
            "contribution": self.contribution,
            "share": self.share,
            "dof": self.dof if math.isfinite(self.dof) else None,
            "correlated": list(self.correlated),
        }
        row |= {
            name: getattr(item, name, None)
            for name in ("name", "type", "unit", "estimate", "stated", "divisor")
        }
        if isinstance(item, Quantity):
            row |= {"symbol": item.symbol, "standard_uncertainty": item.std, "sensitivity": self.sensitivity}
            return row | {"distribution": item.distribution, "assumed": item.assumed or None}
        family = "multivariate normal" if math.isinf(self.dof) else "multivariate t"
        row |= {"symbol": ", ".join(item.symbols), "standard_uncertainty": None, "sensitivity": None}
        return row | {"distribution": family}


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
    check_level(level)
    k, block = len(model.quantities), model.block
    found: list[tuple[Quantity | Block, float, float, tuple[dict[str, Any], ...]]] = [
        (item, float(c), abs(float(c)) * item.std, ())
        for item, c in zip(model.quantities, model.sensitivities[:k], strict=True)
    ]
    if block is not None:
        columns = directions(block.covariance)
        worth = model.sensitivities[k:] @ columns
        parts = tuple(
            {
                "changes": dict(zip(block.symbols, columns[:, i].tolist(), strict=True)),
                "contribution": float(worth[i]),
            }
            for i in np.argsort(-np.abs(worth), kind="stable")
        )
        found.append((block, math.nan, math.hypot(*worth.tolist()), parts))
    combined = math.hypot(*(contribution for _, _, contribution, _ in found))
    if combined == 0.0:
        raise InputError(
            f"nothing that goes into {model.name} is uncertain", key=model.name, fix="give an uncertainty"
        )
    lines = [
        BudgetLine(source=source, sensitivity=c, contribution=u, share=(u / combined) ** 2, correlated=parts)
        for source, c, u, parts in found
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
