"""The figures of a report: which there are, under which chapter, and what is to be seen in them; drawn for the page."""

from collections.abc import Iterator
from concurrent.futures import Executor
from functools import partial

from ropefric.files.folder import Folder
from ropefric.fitting.predict import REGRESSORS
from ropefric.pipeline import CampaignAnswer, Evidence
from ropefric.plotting import campaign as of_trials
from ropefric.plotting import fits as of_laws
from ropefric.plotting.design import draw_budget, draw_design_chart, draw_ladder, draw_tornado
from ropefric.plotting.figure import Draw, Progress, start_drawing
from ropefric.report.page import Picture, Subject
from ropefric.trials.result import Extraction, TrialResult

FOLDER = "figures"
"""Where the numbers of the figures are written, beside the page."""

_LAWS = 4
_SWEPT = ("wrap_angle_rad", "end_tension_N", "wheel_radius_m")

Drawings = Iterator[tuple[str, str, str, Draw]]
"""Chapter, name and caption of figures, and what draws each."""


def draw_pictures(
    subject: Subject,
    folder: Folder,
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> dict[str, list[Picture]]:
    """Return the figures of a report by chapter; write the CSV files of their numbers, and pictures in other formats."""
    answer, evidence = subject.answer, subject.evidence
    extraction = subject.run.extraction if subject.run else None
    drawings = [*_of_front(answer, extraction, evidence)]
    drawings += [] if extraction is None else _of_trials(extraction)
    drawings += [*_of_laws(answer), *_of_design(evidence)]
    draws = {stem: draw for _, stem, _, draw in drawings}
    how = {"under": f"{FOLDER}/", "on_page": True, "formats": subject.wish.formats}
    made = start_drawing(draws, folder, executor, **how)(progress)
    found: dict[str, list[Picture]] = {}
    for chapter, stem, caption, _ in drawings:
        svg, own = made[stem]
        files = tuple(f"{FOLDER}/{path.name}" for path in own)
        found.setdefault(chapter, []).append(Picture(stem, svg, caption, files, narrow=chapter == "front"))
    return found


def _of_front(answer: CampaignAnswer, extraction: Extraction | None, evidence: Evidence) -> Drawings:
    """Give a typical recording, where there are any, and the law with its data."""
    if extraction is not None and (trial := typical_trial(extraction, evidence.typical_number)) is not None:
        caption = f"A typical recording, {trial.trial}, with the force picked from it."
        yield "front", "typical_recording", caption, partial(of_trials.draw_recording, trial)
    caption = (
        "The law and what was measured: the inner band holds the mean law, the outer one a pull with a new rope; "
        "hatched: outside what was tested."
    )
    over = (*_swept(answer), _SWEPT[0])[0]
    yield "front", "law", caption, partial(of_laws.draw_fit_band, answer.fit, over=over, narrow=True)


def typical_trial(extraction: Extraction, number: int) -> TrialResult | None:
    """Return the kept trial of a condition, or of the first that has one, whose force is closest to their mean.

    One with bumps, spikes or hum is typical only where all have them.
    """
    by_name = {trial.trial: trial for trial in extraction.trials}
    for item in (*extraction.conditions[max(number - 1, 0) : number], *extraction.conditions):
        kept = [by_name[name] for name in item.trials if by_name[name].kept and by_name[name].outline]
        if kept:
            more = {t.trial: bool(t.breakaway.events or t.breakaway.notes) for t in kept}
            return min(kept, key=lambda t: (more[t.trial], abs(t.measured_N - item.mean_kept_N)))
    return None


def _swept(answer: CampaignAnswer) -> list[str]:
    """Return the regressors that the trials change."""
    validity = answer.fit.validity
    return [name for name in _SWEPT if validity[name][1] > validity[name][0]]


def _of_trials(extraction: Extraction) -> Drawings:
    """Give every recording, the overview where a trial does not count, and the conditions that are worth a look."""
    pages = [*of_trials.pages_of_recordings(extraction.trials)]
    shown = sum(map(len, pages))
    for number, page in enumerate(pages, start=1):
        first, last = page[0].trial, page[-1].trial
        caption = (
            f"Recordings {first} to {last}, each with its pick, its lowest and highest force, and its length."
        )
        if shown < len(extraction.trials):
            caption += (
                f" {shown} of {len(extraction.trials)} are drawn, those that do not count before all others."
            )
        yield "recordings", f"recordings_{number}", caption, partial(of_trials.draw_recordings, page)
    if any(not trial.kept or trial.problems for trial in extraction.trials):
        caption = "Every trial against every check: where a column has a mark, the recording wants a look."
        yield "trials", "overview", caption, partial(of_trials.draw_overview, extraction)
    conditions = list(of_trials.conditions_of(extraction).items())
    for place, why in chosen_conditions(extraction):
        stem, item = conditions[place]
        caption = f"Repeatability of condition {place + 1}: {why}."
        yield "trials", stem, caption, partial(of_trials.draw_condition, *item, traces=False)


def chosen_conditions(extraction: Extraction) -> tuple[tuple[int, str], ...]:
    """Return the conditions whose repeatability is worth a figure: their place from 0, and why.

    That with the most trials flagged or set aside, and the one that scatters most.
    """
    conditions = extraction.conditions
    gone = [item.n_recorded - item.n_kept for item in conditions]
    found = {}
    if any(gone):
        worst = gone.index(max(gone))
        found[worst] = f"{gone[worst]} of {conditions[worst].n_recorded} trials not kept"
    many = ((place, item) for place, item in enumerate(conditions) if item.n_kept > 1)
    scatter = [(item.std_kept_N / item.mean_kept_N, -place) for place, item in many]
    if scatter:
        found.setdefault(-max(scatter)[1], "the largest scatter of all")
    return tuple(found.items())


def _of_laws(answer: CampaignAnswer) -> Drawings:
    """Give what tells whether the trials obey the capstan equation, and how good the law that is used is."""
    fit = answer.fit
    others = [other for other in answer.fits if other.law not in {fit.law, "constant"}]
    euler = [other for other in answer.fits if other.law == "constant" != fit.law]
    fits = [fit, *others[: _LAWS - 2], *euler]
    if fit.statistics.n_conditions > 1:
        caption = (
            "Average coefficient of friction of every condition against end tension, wrap and wheel radius. By the "
            "capstan equation there would be one level line."
        )
        yield "friction", "mu_facets", caption, partial(of_laws.draw_mu_facets, fits)
        caption = (
            "ln(F_A/F_B) against the wrap. By the capstan equation all points would lie on one straight line through "
            "the origin."
        )
        yield "friction", "capstan", caption, partial(of_laws.draw_capstan, fits)
    for name in _swept(answer):
        title = REGRESSORS[name][0]
        caption = f"The law over the {title}, and off it."
        stem = f"fit_over_{title.replace(' ', '_')}"
        yield "bands", stem, caption, partial(of_laws.draw_fit_band, fit, over=name)
    caption = (
        "Residuals over their standard deviation. If all is right they have no trend, one in twenty lies beyond ±2, "
        "and they follow the line of the normal quantiles."
    )
    yield "residuals", "residuals", caption, partial(of_laws.draw_residuals, fit)
    if answer.comparison.conclusive:
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
            break  # one picture; of the other the table says the same
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
