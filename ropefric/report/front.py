"""The first two pages of a report: who asked what, the answer, how sure it is, two pictures, the limits."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from ropefric.files.plain_text import localized
from ropefric.glossary import counted
from ropefric.pipeline.evidence import Evidence
from ropefric.pipeline.run import CampaignAnswer, CampaignRun
from ropefric.report import parts
from ropefric.report.formula import formulas
from ropefric.report.page import Alert, Block, Fact, Formula, Particulars, Picture
from ropefric.report.section import Section, interval, percent, plain
from ropefric.trials.campaign_model import ReportWords

_GIVEN = {
    "lab": "Laboratory",
    "customer": "Customer",
    "operator": "Operator",
    "number": "Report",
    "date": "Date",
}
SHORT_NAMES = (16, 20)
"""Letters that figures have room for in the name of a trial."""
_LIMITS = ("linearity", "hysteresis", "repeatability", "transmitter")


class Wish(NamedTuple):
    """How a report is wanted: the language of its numbers ("" as [report] says), as PDF too, figures as which files."""

    language: str = ""
    pdf: bool = False
    figures: bool = True
    formats: tuple[str, ...] = ()


USUAL = Wish()


class Subject(NamedTuple):
    """What a report is of: an answer, what stands behind it, and what is said beside it.

    `measured` are particulars of what was measured with what; `run` is None where there is a trial table alone.
    """

    title: str
    tally: str
    answer: CampaignAnswer
    evidence: Evidence
    provenance: Mapping[str, Any]
    words: ReportWords
    measured: Sequence[tuple[str, str]]
    run: CampaignRun | None = None
    wish: Wish = USUAL

    @property
    def language(self) -> str:
        """Return whose numbers and dates the report has."""
        return self.wish.language or self.words.language

    @property
    def names(self) -> frozenset[str]:
        """Return what people have named with numbers that a language would change, whole and as figures cut it."""
        words, table = self.words, self.answer.table
        given = [self.title, words.lab, words.customer, words.operator, words.number, *table.trial]
        if self.run is not None:
            campaign, trials = self.run.campaign, self.run.extraction.trials
            given += [
                *campaign.wheels,
                *campaign.cells,
                *(one.trial for one in trials),
                *(one.file for one in trials),
            ]
            given += [wheel.material for wheel in campaign.wheels.values()]
        cut = {name[:length] for name in given for length in (None, *SHORT_NAMES)}
        return frozenset(name for name in cut if localized(name, self.language) != name)


def front_blocks(
    subject: Subject, alerts: Sequence[Alert], n_remarks: int, pictures: Sequence[Picture]
) -> Iterator[Block]:
    """Give the blocks of the first two pages: what is grave, who and what, the answer, law, pictures, and limits.

    `alerts` are of the answer; so many remarks on the measurements stand in the annex.
    """
    answer, words = subject.answer, subject.words
    if grave := [alert for alert in alerts if alert.grade == "stop"]:
        yield grave
    given = [(label, str(getattr(words, name))) for name, label in _GIVEN.items()]
    rows = (*given, *subject.measured, ("Question", words.question))
    yield Particulars(tuple(row for row in rows if row[1]))
    yield [*_facts(answer, subject.evidence)]
    law = parts.fit_section(answer.fit, f"The law: {answer.fit.law}, {answer.winner.how}")
    yield Section(law.title)
    yield Formula(formulas(answer.fit.friction_law))
    yield law._replace(title="", lines=law.lines[1:])
    if pictures:
        yield Section("In pictures")
        yield from pictures
    tested = f"tested: {', '.join(parts.tested_ranges(answer.fit))}; beyond it the law is extrapolated"
    annex = [f"{counted(n_remarks, 'remark')} on the measurements: see the annex"] if n_remarks else []
    yield Section("Limits and assumptions", notes=(tested, *words.assumptions, *annex))
    doubts = [alert for alert in alerts if alert.grade == "doubt"]
    if doubts or not grave:
        yield doubts or [Alert("note", "Nothing was found", "No check stands against the result.")]


def measured_rows(run: CampaignRun) -> list[tuple[str, str]]:
    """Return rope, wheels, force cells with their calibration, and the way of measuring, as far as they are given."""
    campaign, rope = run.campaign, run.campaign.rope
    density = rope.linear_density_kg_m
    weight = "" if density is None else f"{plain(1e3 * density)} g/m"
    used = {(trial.wheel_radius_m, trial.cell) for trial in run.extraction.trials}
    wheels = [
        f"{name} R_w = {plain(1e3 * wheel.radius_m)} mm" + (f" ({wheel.material})" if wheel.material else "")
        for name, wheel in campaign.wheels.items()
        if wheel.radius_m in {radius_m for radius_m, _ in used}
    ]
    cells = [
        _cell_words(name, cell) for name, cell in campaign.cells.items() if name in {one for _, one in used}
    ]
    window_s = campaign.smoothing.window_s
    smoothing = campaign.smoothing.mode + (f", {plain(1e3 * window_s)} ms" if window_s else "")
    method = f"protocol {campaign.protocol.name}; smoothing {smoothing}; outliers by {campaign.rejection}"
    size = f"{plain(2e3 * rope.radius_m)} mm in diameter"
    return [
        ("Rope", ", ".join(filter(None, (size, weight, rope.material)))),
        ("Wheels", "; ".join(wheels)),
        ("Force cells", "; ".join(cells)),
        ("Method", method),
    ]


def _cell_words(name: str, cell: Any) -> str:
    """Return a cell's range, its number and calibration, and its limits of error, those that are assumed as such."""
    known = ", ".join(f"{limit} {100 * getattr(cell, limit):.2g} %" for limit in _LIMITS)
    assumed = f" ({', '.join(cell.assumed)} assumed, not stated)" if cell.assumed else ""
    said = (
        f"{name} to {plain(cell.full_scale_N)} N",
        cell.serial and f"serial {cell.serial}",
        cell.calibrated and f"calibrated {cell.calibrated}",
        f"of full scale: {known}{assumed}",
    )
    return ", ".join(filter(None, said))


def _facts(answer: CampaignAnswer, evidence: Evidence) -> Iterator[Fact]:
    """Give the numbers a reader looks for first."""
    fit, found = answer.fit, answer.prediction
    if found is not None:
        at = found.conditions
        cells = parts.setting_cells(at.wheel_radius_m[0], at.wrap_angle_rad[0], at.end_tension_N[0])
        (wheel, wrap, tension), rope = cells, plain(2e3 * at.rope_radius_m[0])
        where = f"on average, for R_w = {wheel} mm, φ = {wrap} deg, F_B = {tension} N, rope of {rope} mm"
        yield Fact("Lift force of the design", f"{plain(found.lift_force_N[0], '.5g')} N", where)
        level, one = f"{100 * found.level:g} %", found.prediction_interval_N[0]
        mean = f"where the average of many ropes lies; standard error {plain(found.std_N[0], '.2g')} N"
        yield Fact(f"{level} confidence interval", f"{interval(found.interval_N[0])} N", mean)
        if not math.isnan(float(one[0])):
            pull = "where one pull with a new rope lies"
            yield Fact(f"{level} prediction interval", f"{interval(one)} N", pull)
    yield Fact("Law and verdict", f"{fit.law}, {answer.verdict.word}", answer.verdict.reason)
    unseen, scatter = answer.winner.entry.loco_error, fit.statistics.scatter_within
    if math.isfinite(unseen):
        remark = "root mean square over conditions left out one by one"
        yield Fact("Error at unseen conditions", percent(unseen), remark)
    if math.isfinite(scatter):
        yield Fact("Scatter between repeats", percent(scatter), "standard deviation of one pull")
    if evidence.lift is not None:
        first, name = evidence.lift.budget.lines[0], f"What dominates the {evidence.lift.model.name}"
        yield Fact(name, first.label, f"{percent(first.share, '.0f')} of its variance")
    if (plan := evidence.plan) is not None:
        value = f"{counted(len(plan), 'condition')}, {counted(len(plan) * plan.repeats, 'pull')}"
        better = f"for a mean law {plain(plan.improvement, '.2g')} times as certain"
        yield Fact("What to measure next", value, better)
