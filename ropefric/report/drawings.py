"""Which figures a report has, under which chapter, and what is to be seen in them."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from ropefric.fitting.predict import REGRESSORS
from ropefric.pipeline.evidence import Evidence
from ropefric.pipeline.run import CampaignAnswer
from ropefric.plotting.conditions import conditions_of, draw_repeatability
from ropefric.plotting.design_chart import draw_design_chart
from ropefric.plotting.figure import FigureWithData
from ropefric.plotting.fits import draw_capstan, draw_fit_band, draw_mu_facets, draw_residuals
from ropefric.plotting.overview import draw_overview
from ropefric.plotting.rankings import draw_budget, draw_ladder, draw_tornado
from ropefric.trials.result import ConditionSummary, Extraction
from ropefric.uncertainty.statement import Statement

_LAWS = 4
_FLAGGED = 4
_SWEPT = ("wrap_angle_rad", "end_tension_N", "wheel_radius_m")


@dataclass(frozen=True, slots=True, kw_only=True)
class Drawing:
    """A figure to be drawn."""

    chapter: str
    stem: str
    caption: str
    draw: Callable[[], FigureWithData]


def trial_drawings(extraction: Extraction) -> list[Drawing]:
    """Return the overview of a campaign, and the repeatability of the conditions that are worth a look."""
    conditions = conditions_of(extraction)
    overview = Drawing(
        chapter="trials",
        stem="overview",
        caption="Every trial against every check: where a column has a mark, the recording wants a look.",
        draw=partial(draw_overview, extraction),
    )
    strips = [
        Drawing(
            chapter="trials",
            stem=conditions[place][0],
            caption=f"Repeatability of condition {place + 1}: {why}.",
            draw=partial(draw_repeatability, *conditions[place][1:]),
        )
        for place, why in chosen_conditions(extraction)
    ]
    return [overview, *strips]


def chosen_conditions(extraction: Extraction) -> tuple[tuple[int, str], ...]:
    """Return the conditions whose repeatability is worth a figure: their place from 0, and why.

    Those with the most trials flagged or set aside, then the one that scatters least and the one that scatters most.
    """
    conditions = extraction.conditions
    gone = [item.n_recorded - item.n_kept for item in conditions]
    worst = sorted(range(len(conditions)), key=lambda place: (-gone[place], place))[:_FLAGGED]
    found = {
        place: f"{gone[place]} of {conditions[place].n_recorded} trials not kept"
        for place in worst
        if gone[place]
    }
    spread = sorted((_spread(item), place) for place, item in enumerate(conditions) if item.n_kept > 1)
    if spread:
        found.setdefault(spread[0][1], "the smallest scatter of all")
        found.setdefault(spread[-1][1], "the largest scatter of all")
    return tuple(found.items())


def _spread(summary: ConditionSummary) -> float:
    return summary.std_kept_N / summary.mean_kept_N


def law_drawings(answer: CampaignAnswer) -> list[Drawing]:
    """Return what tells whether the trials obey the capstan equation, and how good the law that is used is."""
    fit = answer.fit
    others = [other for other in answer.fits if other.law not in {fit.law, "constant"}]
    plain = [other for other in answer.fits if other.law == "constant" != fit.law]
    fits = [fit, *others[: _LAWS - 2], *plain]
    moved = [name for name in _SWEPT if fit.validity[name][1] > fit.validity[name][0]] or [_SWEPT[0]]
    return [
        Drawing(
            chapter="friction",
            stem="mu_facets",
            caption="Average coefficient of friction of every condition against end tension, wrap and wheel radius. "
            "By the capstan equation there would be one level line.",
            draw=partial(draw_mu_facets, fits),
        ),
        Drawing(
            chapter="friction",
            stem="capstan",
            caption="ln(F_A/F_B) against the wrap. By the capstan equation all points would lie on one straight line "
            "through the origin.",
            draw=partial(draw_capstan, fits),
        ),
        *(
            Drawing(
                chapter="bands",
                stem=f"fit_over_{REGRESSORS[name][0].replace(' ', '_')}",
                caption=f"The law over the {REGRESSORS[name][0]}: the inner band holds the mean law, the outer one a "
                "pull with a new rope; hatched: outside what was tested.",
                draw=partial(draw_fit_band, fit, over=name),
            )
            for name in moved
        ),
        Drawing(
            chapter="residuals",
            stem="residuals",
            caption="Residuals over their standard deviation. If all is right they have no trend, one in "
            "twenty lies beyond ±2, and they follow the line of the normal quantiles.",
            draw=partial(draw_residuals, fit),
        ),
        Drawing(
            chapter="ladder",
            stem="ladder",
            caption="All laws by AICc, with their weight and their error at conditions they have not seen.",
            draw=partial(draw_ladder, answer.comparison),
        ),
    ]


def design_drawings(evidence: Evidence) -> list[Drawing]:
    """Return the budgets, what the design is sensitive to, and its neighbours, as far as there are any."""
    found = []
    force = f"the measured force of condition {evidence.typical_number}"
    if evidence.lift is not None:
        found.append(_budget(evidence.lift, "budget_lift", "the lift force of the design"))
    if evidence.swings:
        found.append(
            Drawing(
                chapter="tornado",
                stem="tornado",
                caption="What the lift force of the design does when one input changes: settings by 5 % of "
                "themselves, law and rope from end to end of their intervals.",
                draw=partial(draw_tornado, evidence.swings),
            )
        )
    if evidence.typical is not None:
        found.append(_budget(evidence.typical, "budget_force", force))
    if evidence.chart is not None:
        chart = evidence.chart
        found.append(
            Drawing(
                chapter="design",
                stem="design_chart",
                caption=f"Lift force over the wrap at F_B = {chart.end_tension_N:.4g} N: solid the mean law, dashed "
                f"what {100 * chart.probability:g} % of pulls with a new rope exceed; pale: outside what was tested.",
                draw=partial(draw_design_chart, chart),
            )
        )
    return found


def _budget(stated: Statement, stem: str, what: str) -> Drawing:
    rows = [(line.name, line.contribution) for line in stated.budget.lines if line.contribution > 0.0]
    draw = partial(
        draw_budget, rows, unit=stated.model.unit, title=stated.model.symbol, combined=stated.budget.combined
    )
    return Drawing(
        chapter=stem,
        stem=stem,
        caption=f"What makes up the standard uncertainty of {what}, largest first.",
        draw=draw,
    )
