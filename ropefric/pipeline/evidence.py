"""What a report shows beyond the answer: budgets, what the design is sensitive to, what to measure next."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

from ropefric.errors import RopefricError
from ropefric.files.digits import rounded_tree
from ropefric.files.plain_text import json_document
from ropefric.fitting.design import DesignChart
from ropefric.fitting.measured_budget import MeasuredCondition, conditions_of_extraction, force_model
from ropefric.fitting.next_tests import LabPlan
from ropefric.pipeline.design_views import chart_of_design, plan_for_design, state_design, swings_of_design
from ropefric.pipeline.run import CampaignRun
from ropefric.uncertainty.budget import LinearBudget, linear_budget
from ropefric.uncertainty.statement import Statement, state_uncertainty

T = TypeVar("T")


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredBudget:
    """The uncertainty of one condition's measured force, by its budget alone."""

    condition: MeasuredCondition
    budget: LinearBudget

    @property
    def relative(self) -> float:
        """Return u_c over the force [-]."""
        return self.budget.combined / abs(self.budget.estimate)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Evidence:
    """What stands behind a campaign's answer; None where there is no design, or where it could not be made."""

    measured: tuple[MeasuredBudget, ...] = ()
    typical: Statement | None = None
    typical_number: int = 0
    lift: Statement | None = None
    swings: tuple[tuple[str, float, float, float], ...] = ()
    chart: DesignChart | None = None
    plan: LabPlan | None = None
    hand: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()


def gather_evidence(run: CampaignRun) -> Evidence:
    """Return what a report shows beyond the answer of a campaign."""
    missing: list[str] = []

    def attempt(name: str, make: Callable[[], T]) -> T | None:
        try:
            return make()
        except RopefricError as error:
            missing.append(f"no {name}: {error.problem.message}")
            return None

    measured = attempt("budgets of the measured forces", lambda: _measured(run)) or ()
    middle = sorted(measured, key=lambda item: item.relative)[len(measured) // 2] if measured else None
    typical = None
    if middle is not None:
        model, notes = force_model(middle.condition.measured), middle.condition.notes
        typical = attempt("budget of a typical force", lambda: state_uncertainty(model, notes=notes))
    found = Evidence(
        measured=measured,
        typical=typical,
        typical_number=0 if middle is None else middle.condition.number,
        missing=tuple(missing),
    )
    prediction = run.answer.prediction
    if prediction is None:
        return found
    fit, wheel = run.answer.fit, prediction.conditions
    # Arguments are evaluated in their order, so `missing` is complete when it is read.
    return replace(
        found,
        lift=attempt("uncertainty budget of the lift force", lambda: state_design(fit, wheel)),
        swings=attempt("sensitivities", lambda: swings_of_design(fit, prediction)) or (),
        chart=attempt("design chart", lambda: chart_of_design(fit, wheel)),
        plan=attempt("plan of further tests", lambda: plan_for_design(run, wheel)),
        hand=attempt("hand calculation", lambda: fit.friction_law.calculation(fit.theta, wheel)) or (),
        missing=tuple(missing),
    )


def _measured(run: CampaignRun) -> tuple[MeasuredBudget, ...]:
    conditions = conditions_of_extraction(run.extraction, weights_tolerance=run.campaign.weights_tolerance)
    return tuple(
        MeasuredBudget(condition=item, budget=linear_budget(force_model(item.measured)))
        for item in conditions
    )


def evidence_files(evidence: Evidence) -> dict[str, str]:
    """Return uncertainty.json and next_tests.csv by name, as far as there are such."""
    texts = {}
    if evidence.lift is not None:
        texts["uncertainty.json"] = json_document(rounded_tree(evidence.lift.to_dict()))
    if evidence.plan is not None:
        texts["next_tests.csv"] = evidence.plan.to_csv()
    return texts
