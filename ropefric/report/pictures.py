"""The figures of a report, with their chapters and captions, drawn for the page."""

from collections.abc import Iterator
from concurrent.futures import Executor
from functools import partial

from ropefric.files.folder import Folder
from ropefric.fitting.predict import REGRESSORS
from ropefric.pipeline import CampaignAnswer, Evidence
from ropefric.plotting import campaign as of_trials
from ropefric.plotting import fits as of_laws
from ropefric.plotting.design import draw_design_chart, draw_ladder, draw_statement, draw_tornado
from ropefric.plotting.figure import Draw, Progress, start_drawing
from ropefric.report.page import Picture, Subject
from ropefric.report.parts import LEAST_SHARE
from ropefric.trials.result import Extraction

FOLDER = "figures"
"""Where the numbers of the figures are written, beside the page."""

_SWEPT = ("wrap_angle_rad", "end_tension_N", "wheel_radius_m")

Drawings = Iterator[tuple[str, str, str, Draw]]
"""Chapter, name and caption of figures, and what draws each."""


def draw_pictures(
    subject: Subject, folder: Folder, *, executor: Executor | None = None, progress: Progress | None = None
) -> dict[str, list[Picture]]:
    """Return the figures of a report by chapter; write the CSV files of their numbers, and pictures in other formats."""
    answer, evidence = subject.answer, subject.evidence
    extraction = subject.run.extraction if subject.run else None
    drawings = [*_of_front(answer, extraction, evidence)]
    if not subject.wish.short:
        drawings += [] if extraction is None else _of_trials(extraction)
        drawings += [*_of_laws(answer), *_of_design(answer, evidence)]
    draws = {stem: draw for _, stem, _, draw in drawings}
    how = {"under": f"{FOLDER}/", "on_page": True, "formats": subject.wish.formats}
    made = start_drawing(draws, folder, executor, **how)(progress)
    found: dict[str, list[Picture]] = {}
    for chapter, stem, caption, _ in drawings:
        svg, own = made[stem]
        files = tuple(f"{FOLDER}/{path.name}" for path in own)
        narrow = chapter == "front" or stem.startswith("fit_over")
        found.setdefault(chapter, []).append(Picture(stem, svg, caption, files, narrow))
    return found


def _of_front(answer: CampaignAnswer, extraction: Extraction | None, evidence: Evidence) -> Drawings:
    """Give a typical recording, where there are any, and the law with its data."""
    trial = of_trials.typical_trial(extraction, evidence.typical_number) if extraction else None
    if trial is not None:
        caption = f"A typical recording, {trial.trial}, with the force picked from it."
        yield "front", "typical_recording", caption, partial(of_trials.draw_recording, trial)
    caption = (
        "The law and the measured conditions. Inner band: 95 % for the mean law; outer band: 95 % of pulls with a new "
        "rope; hatched: not tested."
    )
    over = (*of_laws.varied(answer.fit, _SWEPT), _SWEPT[0])[0]
    yield "front", "law", caption, partial(of_laws.draw_fit_band, answer.fit, over=over)


def _of_trials(extraction: Extraction) -> Drawings:
    """Give the recordings not kept or with a remark, and a typical one of each condition."""
    trials = of_trials.selected_trials(extraction)
    pages = of_trials.pages_of_recordings(trials)
    for place, page in enumerate(pages, start=1):
        caption = (
            f"Recordings {page[0].trial} to {page[-1].trial}: those that are not kept or have a remark, and a typical "
            f"one of each condition ({len(trials)} of {len(extraction.trials)}). Each has its pick, its lowest and "
            "highest force, and its length."
        )
        yield "recordings", f"recordings_{place}", caption, partial(of_trials.draw_recordings, page)


def _of_laws(answer: CampaignAnswer) -> Drawings:
    """Give the test of the capstan equation, and how well the law that is used fits."""
    fit = answer.fit
    # Two lines: others would lie on one another.
    fits = [fit, *(other for other in answer.fits if other.law == "constant" != fit.law)]
    if fit.statistics.n_conditions > 1:
        varied = " and ".join(REGRESSORS[name][0] for name in of_laws.varied(fit))
        caption = f"Average coefficient of friction against {varied}. The capstan equation is a level line."
        yield "friction", "mu_facets", caption, partial(of_laws.draw_mu_facets, fits)
        caption = "ln(F_A/F_B) against the wrap. The capstan equation is a straight line through the origin."
        yield "friction", "capstan", caption, partial(of_laws.draw_capstan, fits)
    for name in of_laws.varied(fit, _SWEPT)[1:]:  # the first stands on the first page
        title = REGRESSORS[name][0]
        caption = f"The law and the measured conditions over the {title}."
        stem = f"fit_over_{title.replace(' ', '_')}"
        yield "law", stem, caption, partial(of_laws.draw_fit_band, fit, over=name)
    caption = (
        "Standardised residuals. Residuals of a good fit have no trend, one in twenty lies beyond ±2, and they follow "
        "the line of the normal quantiles."
    )
    yield "law", "residuals", caption, partial(of_laws.draw_residuals, fit)
    if answer.comparison.conclusive:
        caption = "Laws ranked by AICc, with their weight and their error at conditions left out of the fit."
        yield "law", "ladder", caption, partial(draw_ladder, answer.comparison)


def _of_design(answer: CampaignAnswer, evidence: Evidence) -> Drawings:
    """Give the budget, the sensitivities of the design, and its neighbours, as far as there are any."""
    typical = "budget_force", f"the measured force of condition {evidence.typical_number}"
    stem, what = ("budget_lift", "the lift force of the design") if evidence.lift else typical
    if (stated := evidence.lift or evidence.typical) is not None:
        caption = f"Contributions to the standard uncertainty of {what}, largest first."
        yield "uncertainty", stem, caption, partial(draw_statement, stated, least_share=LEAST_SHARE)
    if evidence.swings:
        caption = (
            "Change of the lift force when one input changes: each setting by 5 %, the law and the rope from end to end "
            "of their intervals."
        )
        yield "uncertainty", "tornado", caption, partial(draw_tornado, evidence.swings)
    if (chart := evidence.chart) is not None:
        caption = (
            f"Lift force over the wrap at F_B = {chart.end_tension_N:.4g} N. Lines: mean law; bands: down to the force "
            f"that {100 * chart.probability:g} % of pulls with a new rope exceed; hatched or pale: not tested."
        )
        yield "design", "design_chart", caption, partial(draw_design_chart, chart, design=answer.prediction)
