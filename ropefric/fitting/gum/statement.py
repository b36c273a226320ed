"""A budget with its check by draws: the whole statement of an uncertainty, and what would make it smaller."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from ropefric.fitting.gum.budget import BudgetLine, LinearBudget, effective_dof, linear_budget
from ropefric.fitting.gum.model import MeasurementModel
from ropefric.fitting.gum.propagation import DrawnAnswer, propagate
from ropefric.fitting.gum.quantity import Quantity
from ropefric.fitting.propagation import quantile

SCHEMA = "ropefric.uncertainty/1"

# Sources with a smaller part of u_c² change U by less than 4 % even if they vanish.
_WORTH_A_WORD = 0.08
# Less than half a per cent of U is no help to anybody.
_NOTICED = 0.005


class BudgetStatus(StrEnum):
    """What a budget is worth, from good to bad."""

    OK = "ok"
    DRAWS_DISAGREE = "draws-disagree"
    NO_REPEATS = "no-repeats"
    FIT_NOT_TRUSTED = "fit-not-trusted"

    @property
    def advice(self) -> str:
        """Return what the status means and what to do."""
        return _ADVICE[self]


_ADVICE = {
    BudgetStatus.OK: "The draws agree with the budget.",
    BudgetStatus.DRAWS_DISAGREE: (
        "The draws disagree with the budget: the inputs are so uncertain that the answer bends within them, or one "
        "with a flat distribution outweighs the rest. Use the interval of the draws, not y ± U."
    ),
    BudgetStatus.NO_REPEATS: (
        "There is one trial and nothing tells its scatter, which is usually the largest part: the budget leaves it "
        "out. Repeat the condition."
    ),
    BudgetStatus.FIT_NOT_TRUSTED: "The fit is not to be trusted, and so neither is what it adds to the budget.",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Improvement:
    """What one change would do to the expanded uncertainty."""

    source: str
    action: str
    expanded: float
    saving: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Statement:
    """The uncertainty of one answer.

    Attributes
    ----------
    model : MeasurementModel
        The measurement equation.
    budget : LinearBudget
        Its budget.
    drawn : DrawnAnswer
        The check by draws.
    improvements : tuple of Improvement
        What would help, most first.
    status : BudgetStatus
        Whether to trust it.
    notes : tuple of str
        What is not in the budget, and why.
    """

    model: MeasurementModel
    budget: LinearBudget
    drawn: DrawnAnswer
    improvements: tuple[Improvement, ...]
    status: BudgetStatus
    notes: tuple[str, ...] = ()

    @property
    def trustworthy(self) -> bool:
        """Return whether y ± U may be used as it stands."""
        return self.status is BudgetStatus.OK

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON tree of schema `ropefric.uncertainty/1`; infinite degrees of freedom are None."""
        found = self.budget
        return {
            "schema": SCHEMA,
            "quantity": self.model.name,
            "symbol": self.model.symbol,
            "unit": self.model.unit,
            "estimate": found.estimate,
            "lines": [line.to_dict() for line in found.lines],
            "combined": found.combined,
            "effective_dof": found.effective_dof if math.isfinite(found.effective_dof) else None,
            "coverage_factor": found.coverage_factor,
            "level": found.level,
            "expanded": found.expanded,
            "interval": list(found.interval),
            "monte_carlo": self.drawn.to_dict(),
            "improvements": [
                {"source": i.source, "action": i.action, "expanded": i.expanded, "saving": i.saving}
                for i in self.improvements
            ],
            "status": self.status.value,
            "trustworthy": self.trustworthy,
            "advice": self.status.advice,
            "notes": list(self.notes),
        }


def state_uncertainty(
    model: MeasurementModel,
    *,
    level: float = 0.95,
    draws: int = 200_000,
    seed: int = 0,
    status: BudgetStatus = BudgetStatus.OK,
    notes: tuple[str, ...] = (),
) -> Statement:
    """Return the budget of a measurement equation, checked by draws."""
    budget = linear_budget(model, level=level)
    drawn = propagate(model, budget, draws=draws, seed=seed)
    if status is BudgetStatus.OK and not drawn.agrees:
        status = BudgetStatus.DRAWS_DISAGREE
    return Statement(
        model=model,
        budget=budget,
        drawn=drawn,
        improvements=improvements(budget),
        status=status,
        notes=(*notes, *_exact(model), *_assumed(model)),
    )


def _exact(model: MeasurementModel) -> tuple[str, ...]:
    names = [item.name for item in model.quantities if not item.std]
    return (f"taken as exact: {', '.join(names)}",) if names else ()


def _assumed(model: MeasurementModel) -> tuple[str, ...]:
    return tuple(
        f"{item.name} is assumed, nobody stated it: state {item.assumed}"
        for item in model.quantities
        if item.assumed and item.std
    )


def improvements(budget: LinearBudget) -> tuple[Improvement, ...]:
    """Return what halving each large source would do to U, and what twice the repeats or conditions would.

    u_c, ν_eff and k are made anew for each. Twice the repeats shrink s/√n by √2 and more than double its degrees of
    freedom; twice the conditions behind a fit are taken to shrink its part by √2 too, which they do if they lie like
    those there are.
    """
    found: list[Improvement] = []
    for place, line in enumerate(budget.lines):
        if line.share < _WORTH_A_WORD:
            continue
        for action, factor, more_dof in _actions(line):
            expanded = _expanded_with(budget, place, factor, more_dof)
            saving = 1.0 - expanded / budget.expanded
            if saving >= _NOTICED:
                found.append(Improvement(source=line.name, action=action, expanded=expanded, saving=saving))
    return tuple(sorted(found, key=lambda item: -item.saving))


def _actions(line: BudgetLine) -> list[tuple[str, float, Callable[[float], float]]]:
    """Return what can be done about a line: in words, the factor on its contribution, its new degrees of freedom."""
    more = 1.0 / math.sqrt(2.0)
    if not isinstance(line.source, Quantity):
        # k − q degrees of freedom become 2k − q.
        q = len(line.source.symbols)
        return [(f"twice the conditions behind the {line.name}", more, lambda dof: 2.0 * dof + q)]
    n = line.source.repeats
    if n:
        return [(f"{2 * n} instead of {n} repeats", more, lambda dof: dof + n)]
    return [(f"halve the uncertainty of {line.name}", 0.5, lambda dof: dof)]


def _expanded_with(
    budget: LinearBudget, place: int, factor: float, more_dof: Callable[[float], float]
) -> float:
    contributions = [line.contribution for line in budget.lines]
    dof = [line.dof for line in budget.lines]
    contributions[place] *= factor
    dof[place] = more_dof(dof[place])
    reach = quantile(0.5 + 0.5 * budget.level, effective_dof(contributions, dof))
    return reach * math.hypot(*contributions)
