"""The cost of accuracy on one page: a figure, the cheapest method for each accuracy, and the findings."""

import math
import os
import re
from collections.abc import Sequence
from pathlib import Path

from ropefric.accuracy.measure import Machine
from ropefric.accuracy.study import Measured, StudyResult, time_text
from ropefric.files.folder import Folder, as_folder
from ropefric.plotting.figure import save_figure, svg_text
from ropefric.plotting.work_precision import draw_work_precision
from ropefric.report.page import Chapter, Picture, Report, as_html
from ropefric.section import Section, plain

TITLE = "What accuracy costs in time"

_CAPTION = "Time of one call over its error; the thick grey line joins the settings that no other beats."
_LEAD = "How long a call takes for how small an error, and which method is the cheapest for it."
_WORTH_A_NOTE = 0.05
_POWER = re.compile(r"(?<=\de)-(?=\d)")
_ASKED = (1e-2, 1e-4, 1e-8, 1e-12)


def cost_sections(results: Sequence[StudyResult], machine: Machine) -> tuple[Section, ...]:
    """Return the machine and one section a study: the cheapest setting for each accuracy, and the findings."""
    how = "errors are relative; settings are timed in turn, and the least time of a call is shown"
    if any(result.quick for result in results):
        how += "; a quick look: some settings only, and little time for each"
    lines = [f"measured on {machine.line}", how]
    if not results:
        return (Section(lines=lines),)
    lines.append(
        "first the cheapest way to an accuracy in the ordinary case of each study; where ropefric does something "
        "dearer, it is for the sake of the other cases, which follow"
    )
    rows = []
    for result in results:
        found = dict(result.cheapest(result.study.cases[0].name))
        best = (point and f"{point.name}: {time_text(point.seconds)}" for point in map(found.get, _ASKED))
        rows.append((result.study.name, result.study.used or "–", *(cell or "–" for cell in best)))
    headings = ("study", "what ropefric does", *(f"cheapest to {_power(one)} " for one in _ASKED))
    return (Section("", lines, headings, rows, 2), *map(_study_section, results))


def _study_section(result: StudyResult) -> Section:
    """Return a study: its question, the cheapest setting of each case for each accuracy, equal rows in one."""
    study = result.study
    lines = (study.question, f"reference: {study.reference}", f"work is counted in {study.counted}")
    cases = [f"{case.name}: {case.title}" for case in study.cases]
    groups: dict[tuple[str, ...], list[float]] = {}
    for row in zip(*(result.cheapest(case.name) for case in study.cases), strict=True):
        if any(point is not None for _, point in row):
            groups.setdefault(tuple(_cell(point) for _, point in row), []).append(row[0][0])
    notes = list(result.findings)
    if result.unsteady > _WORTH_A_NOTE:
        notes.append(
            f"{100 * result.unsteady:.0f} % of the times spread by more than half: the machine was busy with other "
            "work, and close ranks may be chance. Measure again when it is idle."
        )
    title = f"{study.name}: {study.title}"
    if result.points and result.points[0].shares:
        return Section(title, (*lines, *cases), *_shares_table(result), 2, notes=notes)
    headings = ("accuracy", *(f"{case.name} " for case in study.cases))
    rows = [(_span(accuracies), *cells) for cells, accuracies in groups.items()]
    return Section(title, (*lines, *cases), headings, rows, notes=notes)


def _shares_table(result: StudyResult) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return headings and rows of a study that counts what pickers find: shares and errors in percent, and time."""
    names = dict.fromkeys(name for point in result.points for name in point.shares if name != "recordings")
    rows = []
    for point in result.points:
        cells = [plain(100.0 * point.shares.get(name, math.nan), ".0f") for name in names]
        errors = ((point.bias, "+.2g"), (point.noise, ".2g"), (point.error, ".2g"))
        cells += [plain(100.0 * one, form) for one, form in errors]
        rows.append((point.case, point.name, *cells, time_text(point.seconds)))
    percent = (f"{name.replace('_', ' ')} [%]" for name in (*names, "bias", "scatter", "95 %"))
    return ("case", "picker", *percent, "time"), rows


def _span(accuracies: list[float]) -> str:
    first, last = _power(accuracies[0]), _power(accuracies[-1])
    return first if len(accuracies) == 1 else f"{first} to {last}"


def _power(accuracy: float) -> str:
    return f"{accuracy:.0e}".replace("e-0", "e-")


def _cell(point: Measured | None) -> str:
    if point is None:
        return "–"
    return f"{point.name}: {time_text(point.seconds)} (± {time_text(0.5 * point.spread_s)})"


def write_cost(
    results: Sequence[StudyResult], machine: Machine, folder: Folder | str | os.PathLike[str]
) -> tuple[Path, ...]:
    """Write a figure and a CSV for each study, and cost.html; return their paths."""
    target = as_folder(folder)
    head, *sections = cost_sections(results, machine)
    chapters = [Chapter("result", "The cheapest way to an accuracy", (head,))]
    paths: list[Path] = []
    for result, section in zip(results, sections, strict=True):
        name = result.study.name
        drawn = draw_work_precision(result)
        written = save_figure(drawn, target, name)
        target.publish(name)
        picture = Picture(name, svg_text(drawn, stem=name), _CAPTION, (written[-1].name,))
        chapters.append(Chapter(name, section.title, (picture, section._replace(title=""))))
        paths += written
    # No line ends within a power of ten: a word joiner behind each minus.
    page = _POWER.sub("-\u2060", as_html(Report(TITLE, _LEAD, tuple(chapters))))
    paths += target.write({"cost.html": page})
    target.publish("page")
    return tuple(paths)
