"""A campaign's key numbers, and what was measured, in a few words."""

import math

from ropefric.fitting.predict import REGRESSORS
from ropefric.glossary import counted
from ropefric.pipeline.evidence import Evidence
from ropefric.pipeline.run import CampaignRun
from ropefric.report.chapter import Fact
from ropefric.report.parts import tested_range
from ropefric.report.section import Section, interval, plain


def key_facts(run: CampaignRun, evidence: Evidence) -> tuple[Fact, ...]:
    """Return the numbers a reader looks for first."""
    return (*_lift_facts(run), *_law_facts(run), *_uncertainty_facts(evidence))


def _lift_facts(run: CampaignRun) -> tuple[Fact, ...]:
    found = run.answer.prediction
    if found is None:
        return ()
    at, level = found.conditions, f"{100 * found.level:g} %"
    where = (
        f"on average, for R_w = {plain(1e3 * at.wheel_radius_m[0])} mm, φ = "
        f"{plain(math.degrees(at.wrap_angle_rad[0]))} deg, F_B = {plain(at.end_tension_N[0])} N, rope of "
        f"{plain(2e3 * at.rope_radius_m[0])} mm"
    )
    facts = [
        Fact(name="Lift force of the design", value=f"{plain(found.lift_force_N[0], '.5g')} N", remark=where),
        Fact(
            name=f"{level} confidence interval",
            value=f"{interval(found.interval_N[0])} N",
            remark=f"where the average of many ropes lies; standard error {plain(found.std_N[0], '.2g')} N",
        ),
    ]
    if not math.isnan(float(found.prediction_interval_N[0, 0])):
        value = f"{interval(found.prediction_interval_N[0])} N"
        facts.append(
            Fact(
                name=f"{level} prediction interval", value=value, remark="where one pull with a new rope lies"
            )
        )
    return tuple(facts)


def _law_facts(run: CampaignRun) -> tuple[Fact, ...]:
    fit, entry = run.answer.fit, run.answer.winner.entry
    verdict = run.answer.verdict
    facts = [Fact(name="Law", value=f"{fit.law}, {verdict.word}", remark=verdict.reason)]
    if math.isfinite(entry.loco_error):
        facts.append(
            Fact(
                name="Error at unseen conditions",
                value=f"{100 * entry.loco_error:.2g} %",
                remark="root mean square over conditions left out one by one",
            )
        )
    if math.isfinite(fit.statistics.scatter_within):
        facts.append(
            Fact(
                name="Scatter between repeats",
                value=f"{100 * fit.statistics.scatter_within:.2g} %",
                remark="standard deviation of one pull",
            )
        )
    return tuple(facts)


def _uncertainty_facts(evidence: Evidence) -> tuple[Fact, ...]:
    facts = []
    if evidence.lift is not None:
        first = evidence.lift.budget.lines[0]
        facts.append(
            Fact(
                name=f"What dominates the {evidence.lift.model.name}",
                value=first.label,
                remark=f"{100 * first.share:.0f} % of its variance",
            )
        )
    if evidence.plan is not None:
        plan = evidence.plan
        better = f"for a mean law {plain(plan.improvement, '.2g')} times as certain"
        value = f"{counted(len(plan), 'condition')}, {counted(len(plan) * plan.repeats, 'pull')}"
        facts.append(Fact(name="What to measure next", value=value, remark=better))
    return tuple(facts)


def measured_section(run: CampaignRun) -> Section:
    """Return with what was measured, and over which range."""
    campaign, validity = run.campaign, run.answer.fit.validity
    rope = f"rope: {plain(2e3 * campaign.rope.radius_m)} mm in diameter"
    if campaign.rope.linear_density_kg_m is not None:
        rope += f", {plain(1e3 * campaign.rope.linear_density_kg_m)} g/m"
    if campaign.rope.material:
        rope += f", {campaign.rope.material}"
    wheels = ", ".join(
        f"{name} R_w = {plain(1e3 * wheel.radius_m)} mm" + (f" ({wheel.material})" if wheel.material else "")
        for name, wheel in campaign.wheels.items()
    )
    cells = ", ".join(
        f"{name} to {plain(cell.full_scale_N)} N"
        + (f" ({', '.join(cell.assumed)} assumed, not stated)" if cell.assumed else "")
        for name, cell in campaign.cells.items()
    )
    ranges = ", ".join(tested_range(name, validity[name]) for name in REGRESSORS if name in validity)
    smoothing = campaign.smoothing.mode
    if campaign.smoothing.window_s:
        smoothing += f", {plain(1e3 * campaign.smoothing.window_s)} ms"
    notes = (
        rope,
        *((f"wheels: {wheels}",) if wheels else ()),
        *((f"force cells: {cells}",) if cells else ()),
        f"tested: {ranges}",
        f"protocol {campaign.protocol.name}; smoothing {smoothing}; outliers by {campaign.rejection}",
    )
    return Section(title="", notes=notes)
