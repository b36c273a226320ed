"""The figures of a report: which there are, under which chapter, and what is to be seen in them; drawn for the page."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor
from functools import partial

from ropefric.files.folder import Folder
from ropefric.fitting.predict import REGRESSORS
from ropefric.papers.paper import Shown
from ropefric.pipeline.evidence import Evidence
from ropefric.pipeline.run import CampaignAnswer, CampaignRun
from ropefric.plotting.campaign import conditions_of, draw_condition, draw_overview
from ropefric.plotting.design import draw_budget, draw_design_chart, draw_ladder, draw_tornado
from ropefric.plotting.figure import FigureWithData, begin, figure_files
from ropefric.plotting.fits import draw_capstan, draw_fit_band, draw_mu_facets, draw_residuals
from ropefric.plotting.machines import draw_chart
from ropefric.plotting.svg import svg_text
from ropefric.report.page import Picture
from ropefric.trials.result import Extraction

FOLDER = "figures"
"""Where the numbers of the figures are written, beside the page."""

_LAWS = 4
_FLAGGED = 4
_SWEPT = ("wrap_angle_rad", "end_tension_N", "wheel_radius_m")

Draw = Callable[[], FigureWithData]
Drawings = Iterator[tuple[str, str, str, Draw]]
"""Chapter, name and caption of figures, and what draws each."""


def draw_pictures(
    run: CampaignRun,
    evidence: Evidence,
    folder: Folder,
    *,
    of_paper: Iterable[Shown] = (),
    executor: Executor | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> dict[str, list[Picture]]:
    """Return the figures of a report by chapter, and write the CSV files of their numbers into a folder."""
    drawings = [*_of_trials(run.extraction), *_of_laws(run.answer), *_of_design(evidence)]
    drawings += [
        ("paper", f"paper_{one.stem}", f"{one.chart.title}.", partial(draw_chart, one.chart))
        for one in of_paper
    ]
    drawn = begin({stem: partial(_drawn, stem, draw) for _, stem, _, draw in drawings}, executor)
    made: dict[str, tuple[str, tuple[str, ...]]] = {}
    for done, (stem, (svg, files)) in enumerate(drawn(), start=1):
        # Workers draw, and this process alone writes.
        made[stem] = svg, tuple(f"{FOLDER}/{path.name}" for path in folder.write(files))
        if progress is not None:
            progress(done, len(drawings), stem)
    found: dict[str, list[Picture]] = {}
    for chapter, stem, caption, _ in drawings:
        svg, names = made[stem]
        found.setdefault(chapter, []).append(Picture(stem, svg, caption, names))
    return found


def _drawn(stem: str, draw: Draw) -> tuple[str, dict[str, bytes]]:
    figure = draw()
    files = figure_files(figure, f"{FOLDER}/{stem}", picture=False)
    return svg_text(figure, stem=stem), files


def _of_trials(extraction: Extraction) -> Drawings:
    """Give the overview of a campaign, and the repeatability of the conditions that are worth a look."""
    caption = "Every trial against every check: where a column has a mark, the recording wants a look."
    yield "trials", "overview", caption, partial(draw_overview, extraction)
    conditions = list(conditions_of(extraction).items())
    for place, why in chosen_conditions(extraction):
        stem, item = conditions[place]
        caption = f"Repeatability of condition {place + 1}: {why}."
        yield "trials", stem, caption, partial(draw_condition, *item, traces=False)


def chosen_conditions(extraction: Extraction) -> tuple[tuple[int, str], ...]:
    """Return the conditions whose repeatability is worth a figure: their place from 0, and why.

    Those with the most trials flagged or set aside, then the one that scatters least and the one that scatters most.
    """
    conditions = extraction.conditions
    gone = [item.n_recorded - item.n_kept for item in conditions]
    worst = sorted(range(len(conditions)), key=lambda place: -gone[place])[:_FLAGGED]
    found = {
        place: f"{gone[place]} of {conditions[place].n_recorded} trials not kept"
        for place in worst
        if gone[place]
    }
    scatter = sorted(
        (item.std_kept_N / item.mean_kept_N, place)
        for place, item in enumerate(conditions)
        if item.n_kept > 1
    )
    if scatter:
        found.setdefault(scatter[0][1], "the smallest scatter of all")
        found.setdefault(scatter[-1][1], "the largest scatter of all")
    return tuple(found.items())


def _of_laws(answer: CampaignAnswer) -> Drawings:
    """Give what tells whether the trials obey the capstan equation, and how good the law that is used is."""
    fit = answer.fit
    others = [other for other in answer.fits if other.law not in {fit.law, "constant"}]
    euler = [other for other in answer.fits if other.law == "constant" != fit.law]
    fits = [fit, *others[: _LAWS - 2], *euler]
    caption = (
        "Average coefficient of friction of every condition against end tension, wrap and wheel radius. By the capstan "
        "equation there would be one level line."
    )
    yield "friction", "mu_facets", caption, partial(draw_mu_facets, fits)
    caption = (
        "ln(F_A/F_B) against the wrap. By the capstan equation all points would lie on one straight line through the "
        "origin."
    )
    yield "friction", "capstan", caption, partial(draw_capstan, fits)
    for name in [name for name in _SWEPT if fit.validity[name][1] > fit.validity[name][0]] or _SWEPT[:1]:
        title = REGRESSORS[name][0]
        caption = (
            f"The law over the {title}: the inner band holds the mean law, the outer one a pull with a new rope; "
            "hatched: outside what was tested."
        )
        yield "bands", f"fit_over_{title.replace(' ', '_')}", caption, partial(draw_fit_band, fit, over=name)
    caption = (
        "Residuals over their standard deviation. If all is right they have no trend, one in twenty lies beyond ±2, "
        "and they follow the line of the normal quantiles."
    )
    yield "residuals", "residuals", caption, partial(draw_residuals, fit)
    caption = "All laws by AICc, with their weight and their error at conditions they have not seen."
    yield "ladder", "ladder", caption, partial(draw_ladder, answer.comparison)


def _of_design(evidence: Evidence) -> Drawings:
    """Give the budgets, what the design is sensitive to, and its neighbours, as far as there are any."""
    typical = f"the measured force of condition {evidence.typical_number}"
    for stated, stem, what in (
        (evidence.lift, "budget_lift", "the lift force of the design"),
        (evidence.typical, "budget_force", typical),
    ):
        if stated is not None:
            model, budget = stated.model, stated.budget
            rows = [(line.name, line.contribution) for line in budget.lines if line.contribution > 0.0]
            draw = partial(draw_budget, rows, unit=model.unit, title=model.symbol, combined=budget.combined)
            yield stem, stem, f"What makes up the standard uncertainty of {what}, largest first.", draw
    if evidence.swings:
        caption = (
            "What the lift force of the design does when one input changes: settings by 5 % of themselves, law and rope "
            "from end to end of their intervals."
        )
        yield "tornado", "tornado", caption, partial(draw_tornado, evidence.swings)
    if (chart := evidence.chart) is not None:
        caption = (
            f"Lift force over the wrap at F_B = {chart.end_tension_N:.4g} N: solid the mean law, dashed what "
            f"{100 * chart.probability:g} % of pulls with a new rope exceed; pale: outside what was tested."
        )
        yield "design", "design_chart", caption, partial(draw_design_chart, chart)
