"""A campaign's result for people: the summary, the report, and both as files beside what they rest on."""

import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ropefric.errors import Problem
from ropefric.files.folder import Folder, as_folder
from ropefric.glossary import counted
from ropefric.pipeline.evidence import Evidence, evidence_files, gather_evidence
from ropefric.pipeline.provenance import MANIFEST, InputFile, Provenance, manifest_text, trace_provenance
from ropefric.pipeline.run import CampaignRun
from ropefric.report.page import Alert, Block, Chapter, Fact, Fold, Picture, Report, as_html
from ropefric.report.parts import (
    comparison_section,
    diagnosis_section,
    fit_section,
    notes_sections,
    plan_sections,
    prediction_section,
    tested_ranges,
    uncertainty_sections,
    verdict_section,
)
from ropefric.report.section import Section, Table, as_text, interval, percent, plain
from ropefric.traces.breakaway import ADVICE, Status
from ropefric.trials.outliers import RULES
from ropefric.trials.result import (
    SUMMARISED,
    ConditionSummary,
    Extraction,
    TrialResult,
    count_trials,
    outcome_words,
)

Pictures = Mapping[str, Sequence[Picture]]
"""Pictures by the chapter they belong to, in order."""

_NAMED = 8
"""Trials that an alert names; the others are counted."""
_SAID = 3
"""Problems of one kind that are said in full."""
_NONE = (math.nan, math.nan, 0)
_NOTHING = ("nothing was found",)
_WHERE = (
    "Chosen among the wheels that were used, and wraps and end tensions between the smallest and the largest that "
    "were, so that the lift force of the design becomes as certain as it can."
)


def write_report(
    run: CampaignRun,
    folder: Folder | str | os.PathLike[str],
    *,
    figures: bool = True,
    progress: Callable[[int, int, str], None] | None = None,
) -> tuple[Path, ...]:
    """Write summary.txt, report.html with the numbers of its figures, and what they rest on; return the paths.

    The page needs nothing else. Beside it stand figures/*.csv, uncertainty.json and next_tests.csv where there is a
    design, and manifest.json. The same campaign gives the same bytes.
    """
    target = as_folder(folder)
    evidence = gather_evidence(run)
    provenance = trace_provenance(run, evidence)
    pictures: Pictures = {}
    if figures:
        from ropefric.report.pictures import draw_pictures  # noqa: PLC0415  (matplotlib takes half a second)

        pictures = draw_pictures(run, evidence, target, progress=progress)
    numbers = [
        target.path / name for drawn in pictures.values() for picture in drawn for name in picture.files
    ]
    texts = evidence_files(evidence) | {
        MANIFEST: manifest_text(provenance, run.campaign.path, target.path),
        "summary.txt": as_text(summary_sections(run)),
        "report.html": as_html(campaign_report(run, evidence, provenance, pictures)),
    }
    return (*numbers, *target.write(texts))


def summary_sections(run: CampaignRun) -> tuple[Section, ...]:
    """Return the law that is used, how it won, what is doubtful, and the lift force of the design."""
    answer, counts = run.answer, count_trials(run.extraction)
    lines = [f"{run.campaign.name}: {_tally(run.extraction)}"]
    if counts["n_rejected"]:
        lines.append(f"rejected by the rule {run.campaign.rejection}; look for a physical reason")
    if statuses := ", ".join(f"{n} {status}" for status, n in counts["status"].items() if status != "ok"):
        lines.append(f"recordings without a usable force: {statuses}")
    lines += [
        f"force cell {name}: {', '.join(cell.assumed)} assumed, not stated: state them in [cells.{name}]"
        for name, cell in run.campaign.cells.items()
        if cell.assumed
    ]
    sections = [
        Section(lines=tuple(lines)),
        verdict_section(answer.verdict, "The verdict"),
        _law_section(run),
        comparison_section(answer.comparison),
        diagnosis_section(answer.diagnosis),
        Section(title="Doubts", notes=answer.doubts or _NOTHING),
    ]
    if answer.prediction is not None:
        sections.append(prediction_section(answer.prediction))
    elif run.campaign.design is None:
        sections.append(
            Section(title="Lift force", lines=("the campaign names no wheel: add [design] to it",))
        )
    return tuple(sections)


def _tally(extraction: Extraction) -> str:
    counts = count_trials(extraction)
    trials, conditions = counted(counts["n_trials"], "trial"), counted(counts["n_conditions"], "condition")
    return f"{trials} of {conditions}: {outcome_words(counts)}"


def _law_section(run: CampaignRun) -> Section:
    return fit_section(run.answer.fit, f"The law: {run.answer.fit.law}, {run.answer.winner.how}")


def campaign_report(
    run: CampaignRun, evidence: Evidence, provenance: Provenance, pictures: Pictures
) -> Report:
    """Return a campaign's report: what to know first, the result, the evidence, settings and provenance."""
    answer = run.answer
    shown = {key: tuple(drawn) for key, drawn in pictures.items()}
    trials, diagnosis = shown.get("trials", ()), diagnosis_section(answer.diagnosis)
    undecided = tuple(
        f"{cause.cause}: {cause.experiment}"
        for cause in answer.diagnosis.causes
        if cause.supported == "cannot-tell"
    )
    result: list[Block] = [_facts(run, evidence), _law_section(run)]
    if evidence.hand:
        result.append(Fold("The lift force by hand", Section(lines=evidence.hand, verbatim=True)))
    friction: list[Block] = [
        Section(lines=diagnosis.lines, notes=diagnosis.notes),
        *shown.get("friction", ()),
    ]
    if undecided:
        friction.append(Section(title="What would decide it", notes=undecided))
    law: tuple[Block, ...] = (
        comparison_section(answer.comparison),
        *shown.get("ladder", ()),
        *shown.get("bands", ()),
        Section(title="Tested range: beyond it the law is extrapolated", notes=tested_ranges(answer.fit)),
        *shown.get("residuals", ()),
        *notes_sections(answer.fit),
    )
    measured: tuple[Block, ...] = (
        _measured_section(run),
        *trials[:1],
        _set_aside_section(run.extraction),
        *_decided_section(run.extraction),
        _conditions_section(run.extraction, evidence),
        *_sliding_section(run.extraction),
        *trials[1:],
    )
    plan = () if evidence.plan is None else (Section(lines=(_WHERE,)), *plan_sections(evidence.plan))
    chapters = (
        Chapter("warnings", "What to know first", (_alerts(run, evidence, with_figures=bool(pictures)),)),
        Chapter("result", "The result", tuple(result)),
        Chapter("trials", "What was measured", measured),
        Chapter("friction", "Does it obey the capstan equation?", tuple(friction)),
        Chapter("law", "How good the law is", law),
        Chapter("uncertainty", "What makes up the uncertainty", tuple(_uncertainty(evidence, shown))),
        Chapter("design", "The design and its neighbours", shown.get("design", ())),
        Chapter("next", "What to measure next", plan),
        Chapter("provenance", "Settings and provenance", _provenance(provenance)),
    )
    return Report(
        title=run.campaign.name,
        lead=f"{_tally(run.extraction)}; the friction law they ask for, how good it is, and the lift force it gives.",
        chapters=tuple(chapter for chapter in chapters if chapter.blocks),
    )


def _uncertainty(evidence: Evidence, shown: Mapping[str, tuple[Picture, ...]]) -> Iterator[Block]:
    typical = f"condition {evidence.typical_number}, a typical one"
    for stated, key, of_what in (
        (evidence.lift, "budget_lift", "the design"),
        (evidence.typical, "budget_force", typical),
    ):
        if stated is not None:
            budget, *rest = uncertainty_sections(stated, f"Budget of the {stated.model.name} of {of_what}")
            yield budget
            yield from shown.get(key, ())
            yield from (part for part in rest if part.lines or part.notes)
            yield from shown.get("tornado", ()) if stated is evidence.lift else ()


def _alerts(run: CampaignRun, evidence: Evidence, *, with_figures: bool) -> list[Alert]:
    """Return what stands against a result, or ought to be kept in mind; gravest first."""
    found = [
        *_alerts_of_answer(run, evidence),
        *_alerts_of_trials(run.extraction),
        *_alerts_of_problems(run.extraction),
    ]
    found.sort(key=lambda alert: ("stop", "doubt", "note").index(alert.grade))
    if not found:
        found.append(Alert("note", "Nothing was found", "No check stands against the result."))
    if not with_figures:
        text = "This report was made without figures; `ropefric report` adds them."
        found.append(Alert("note", "No figures", text))
    return found


def _alerts_of_answer(run: CampaignRun, evidence: Evidence) -> Iterator[Alert]:
    verdict, prediction = run.answer.verdict, run.answer.prediction
    if not verdict.supported:
        yield Alert("stop", f"The law {run.answer.fit.law} is {verdict.word}", verdict.reason)
    for doubt in run.answer.doubts:
        if doubt not in verdict.reasons:
            yield Alert("doubt", "About the law", doubt)
    if prediction is not None:
        outside = Alert("doubt", "The design lies outside what was tested", "")
        about = outside if prediction.extrapolated[0] else Alert("note", "About the lift force", "")
        yield from (about._replace(text=note) for note in prediction.notes())
    elif run.campaign.design is None:
        keys = "wheel_radius, wrap_angle and end_tension"
        yield Alert("note", "No lift force", f"The campaign names no wheel: add [design] with {keys} to it.")
    for stated, what in ((evidence.lift, "the lift force"), (evidence.typical, "a typical measured force")):
        if stated is not None and not stated.trustworthy:
            yield Alert("doubt", f"About the uncertainty of {what}: {stated.status}", stated.status.advice)
    yield from (Alert("note", "Left out of this report", text) for text in evidence.missing)


def _alerts_of_trials(extraction: Extraction) -> Iterator[Alert]:
    groups: dict[tuple[str, str], list[TrialResult]] = {}
    for trial in extraction.trials:
        if trial.outcome == "without a force":
            groups.setdefault(("without a force", trial.breakaway.status), []).append(trial)
        elif trial.outcome == "rejected":
            groups.setdefault(("rejected", trial.rejected_by), []).append(trial)
        elif trial.excluded:
            groups.setdefault(("excluded", trial.excluded), []).append(trial)
    grave, statuses = ("without a force", "rejected", "excluded"), [str(status) for status in Status]
    ranked = sorted(
        groups, key=lambda key: (grave.index(key[0]), statuses.index(key[1]) if key[0] == grave[0] else 0)
    )
    for what, why in ranked:
        alike = groups[what, why]
        names = ", ".join(trial.trial for trial in alike[:_NAMED])
        names += f" and {len(alike) - _NAMED} more" if len(alike) > _NAMED else ""
        n = counted(len(alike), "trial")
        if what == "without a force":
            yield Alert("doubt", f"{n} without a force: {why}", f"{names}. {_advice(Status(why), alike)}")
        elif what == "rejected":
            text = f"{names}. They take no part in the law; look for a physical reason."
            yield Alert("note", f"{n} rejected by the rule {why} ({_rule_label(why)})", text)
        else:
            yield Alert("note", f"{n} excluded: {why}", f"{names}.")


def _rule_label(rule: str) -> str:
    return RULES[rule].label if rule in RULES else rule


def _advice(status: Status, flagged: Sequence[TrialResult]) -> str:
    """Return what to do about a status; for a file that could not be read, the reader's own words."""
    if status is not Status.UNREADABLE:
        return ADVICE[status]
    fixes = dict.fromkeys(problem.fix for trial in flagged for problem in trial.problems if problem.fix)
    details = dict.fromkeys(trial.breakaway.detail for trial in flagged)
    return f"{'; '.join([*details][:_SAID])}. To do: {'; '.join([*fixes][:_SAID]) or 'record again'}."


def _alerts_of_problems(extraction: Extraction) -> Iterator[Alert]:
    """Give what else was wrong or doubtful, by kind; what a flagged recording says of itself is said already."""
    flagged = [trial for trial in extraction.trials if trial.breakaway.status is not Status.OK]
    said = {problem for trial in flagged for problem in trial.problems}
    by_code: dict[str, list[Problem]] = {}
    for problem in extraction.problems:
        if problem not in said:
            by_code.setdefault(problem.code, []).append(problem)
    for code, alike in by_code.items():
        messages = [problem.message for problem in alike[:_SAID]]
        if len(alike) > _SAID:
            messages.append(f"{len(alike) - _SAID} more like these, listed in problems.csv")
        fixes = dict.fromkeys(problem.fix for problem in alike[:_SAID] if problem.fix)
        text = "; ".join(messages) + "." + (f" To do: {'; '.join(fixes)}." if fixes else "")
        grave = any(problem.severity == "error" for problem in alike)
        yield Alert("doubt" if grave else "note", f"About the recordings ({code})", text)


def _facts(run: CampaignRun, evidence: Evidence) -> list[Fact]:
    """Return the numbers a reader looks for first."""
    facts = []
    fit, found = run.answer.fit, run.answer.prediction
    if found is not None:
        at, level = found.conditions, f"{100 * found.level:g} %"
        where = (
            f"on average, for R_w = {plain(1e3 * at.wheel_radius_m[0])} mm, φ = "
            f"{plain(math.degrees(at.wrap_angle_rad[0]))} deg, F_B = {plain(at.end_tension_N[0])} N, rope of "
            f"{plain(2e3 * at.rope_radius_m[0])} mm"
        )
        mean = f"where the average of many ropes lies; standard error {plain(found.std_N[0], '.2g')} N"
        one, pull = found.prediction_interval_N[0], "where one pull with a new rope lies"
        facts.append(Fact("Lift force of the design", f"{plain(found.lift_force_N[0], '.5g')} N", where))
        facts.append(Fact(f"{level} confidence interval", f"{interval(found.interval_N[0])} N", mean))
        if not math.isnan(float(one[0])):
            facts.append(Fact(f"{level} prediction interval", f"{interval(one)} N", pull))
    facts.append(Fact("Law", f"{fit.law}, {run.answer.verdict.word}", run.answer.verdict.reason))
    unseen, scatter = run.answer.winner.entry.loco_error, fit.statistics.scatter_within
    if math.isfinite(unseen):
        remark = "root mean square over conditions left out one by one"
        facts.append(Fact("Error at unseen conditions", percent(unseen), remark))
    if math.isfinite(scatter):
        facts.append(Fact("Scatter between repeats", percent(scatter), "standard deviation of one pull"))
    if evidence.lift is not None:
        first = evidence.lift.budget.lines[0]
        name = f"What dominates the {evidence.lift.model.name}"
        facts.append(Fact(name, first.label, f"{percent(first.share, '.0f')} of its variance"))
    if evidence.plan is not None:
        plan = evidence.plan
        value = f"{counted(len(plan), 'condition')}, {counted(len(plan) * plan.repeats, 'pull')}"
        better = f"for a mean law {plain(plan.improvement, '.2g')} times as certain"
        facts.append(Fact("What to measure next", value, better))
    return facts


def _measured_section(run: CampaignRun) -> Section:
    """Return with what was measured, and over which range."""
    campaign, rope = run.campaign, run.campaign.rope
    of_rope = [f"rope: {plain(2e3 * rope.radius_m)} mm in diameter"]
    if rope.linear_density_kg_m is not None:
        of_rope.append(f"{plain(1e3 * rope.linear_density_kg_m)} g/m")
    if rope.material:
        of_rope.append(rope.material)
    wheels = ", ".join(
        f"{name} R_w = {plain(1e3 * wheel.radius_m)} mm" + (f" ({wheel.material})" if wheel.material else "")
        for name, wheel in campaign.wheels.items()
    )
    cells = ", ".join(
        f"{name} to {plain(cell.full_scale_N)} N"
        + (f" ({', '.join(cell.assumed)} assumed, not stated)" if cell.assumed else "")
        for name, cell in campaign.cells.items()
    )
    smoothing = campaign.smoothing.mode
    if campaign.smoothing.window_s:
        smoothing += f", {plain(1e3 * campaign.smoothing.window_s)} ms"
    notes = (
        ", ".join(of_rope),
        f"wheels: {wheels}" if wheels else "",
        f"force cells: {cells}" if cells else "",
        f"tested: {', '.join(tested_ranges(run.answer.fit))}",
        f"protocol {campaign.protocol.name}; smoothing {smoothing}; outliers by {campaign.rejection}",
    )
    return Section(notes=tuple(filter(None, notes)))


def _tensions(extraction: Extraction) -> tuple[str, str]:
    """Return the symbols of the tension that is known and of the one that is measured."""
    slack = any(trial.measures_slack for trial in extraction.trials)
    return ("F_A", "F_B") if slack else ("F_B", "F_A")


def _setting_cells(item: ConditionSummary | TrialResult, known_N: float) -> tuple[str, str, str]:
    return plain(1e3 * item.wheel_radius_m), plain(math.degrees(item.wrap_angle_rad)), plain(known_N)


def _conditions_section(extraction: Extraction, evidence: Evidence) -> Section:
    """Return all conditions: how many trials, their mean force, scatter and uncertainty, and which do not count."""
    known, measured = _tensions(extraction)
    budgets = {item.condition.number: item for item in evidence.measured}
    gone = {trial.trial for trial in extraction.trials if not trial.kept}
    rows = []
    for number, item in enumerate(extraction.conditions, start=1):
        uncertainty = ("–", "–", "")
        if (stated := budgets.get(number)) is not None:
            largest = stated.budget.lines[0]
            part = f"{largest.label} ({percent(largest.share, '.0f')})"
            uncertainty = (plain(stated.budget.combined, ".2g"), percent(stated.relative), part)
        rows.append(
            (
                str(number),
                *_setting_cells(item, item.lift_force_N if known == "F_A" else item.end_tension_N),
                f"{item.n_kept} of {item.n_recorded}",
                plain(item.mean_kept_N),
                plain(item.std_kept_N, ".2g"),
                *uncertainty,
                ", ".join(name for name in item.trials if name in gone),
            )
        )
    headings = (
        *("no.", "R_w [mm]", "φ [deg]", f"{known} [N]", "kept", f"mean {measured} [N]", "s [N]"),
        *("u_c [N]", "u_c/mean", "largest part of u_c ", "not kept "),
    )
    note = (
        f"mean {measured} and s: of the trials kept; u_c: standard uncertainty of that mean, repeats and measuring "
        "chain; every trial stands in trials.csv"
    )
    return Section(
        title="Conditions", table=Table(headings=headings, rows=tuple(rows), left=0), notes=(note,)
    )


def _sliding_section(extraction: Extraction) -> Iterator[Section]:
    """Yield what was measured beside the break-away force, by condition: mean ± s of the kept trials."""
    conditions = extraction.conditions
    shown = [name for name in SUMMARISED if any(item.of_kept.get(name, _NONE)[2] for item in conditions)]
    if not shown:
        return
    rows = []
    for number, item in enumerate(conditions, start=1):
        found = [item.of_kept.get(name, _NONE) for name in shown]
        cells = (f"{plain(mean)} ± {plain(std, '.2g')}" if n > 1 else plain(mean) for mean, std, n in found)
        rows.append((str(number), str(max(n for *_, n in found)), *cells))
    headings = ("no.", "n", *(SUMMARISED[name] for name in shown))
    note = "mean ± s of the kept trials, n of them at most; every trial stands in trials.csv"
    yield Section(
        title="Beside the break-away force",
        table=Table(headings=headings, rows=tuple(rows), left=0),
        notes=(note,),
    )


def _set_aside_section(extraction: Extraction) -> Section:
    """Return all trials that do not count: their condition, what became of them, and why."""
    place = {name: summary for summary in extraction.conditions for name in summary.trials}
    counts = count_trials(extraction)
    title = f"Trials not kept (of {counted(counts['n_trials'], 'trial')}: {outcome_words(counts)})"
    known, measured = _tensions(extraction)
    rows = tuple(
        (
            trial.trial,
            str(trial.breakaway.status) if trial.outcome == "without a force" else trial.outcome,
            *_setting_cells(trial, trial.peak_N if trial.measures_slack else trial.end_tension_N),
            plain(trial.measured_N),
            _why(trial, place.get(trial.trial)),
        )
        for trial in sorted(
            extraction.trials, key=lambda trial: trial.breakaway.status is not Status.DOUBTFUL
        )
        if not trial.kept
    )
    if not rows:
        return Section(title=title, lines=("Every trial gave a force and counts.",))
    headings = ("trial", "verdict", "R_w [mm]", "φ [deg]", f"{known} [N]", f"{measured} [N]", "why ")
    return Section(title=title, table=Table(headings=headings, rows=rows, left=2))


def _decided_section(extraction: Extraction) -> Iterator[Section]:
    """Yield what people decided about single trials, where they did: what, who and why."""
    rows = tuple(
        (
            trial.trial,
            trial.decision or f"excluded: {trial.excluded}",
            plain(trial.measured_N),
            trial.by,
            trial.why,
            "; ".join(note for note in trial.breakaway.notes if note.startswith("without the decision")),
        )
        for trial in extraction.trials
        if trial.decision or (trial.excluded and trial.by)
    )
    if rows:
        headings = ("trial", "decision ", "F_A [N]", "by ", "why ", "and else ")
        table = Table(headings=headings, rows=rows, left=1)
        yield Section(title="Decided by people", table=table)


def _why(trial: TrialResult, summary: ConditionSummary | None) -> str:
    if trial.excluded:
        return trial.excluded
    if trial.breakaway.status is not Status.OK:
        candidates = trial.measured("candidates")
        return trial.breakaway.detail + (f"; candidates: {candidates}" if candidates else "")
    rule = _rule_label(trial.rejected_by)
    if summary is None:
        return rule
    return f"{rule}; mean of all {plain(summary.mean_all_N)} N, s = {plain(summary.std_all_N, '.2g')} N"


def _provenance(provenance: Provenance) -> tuple[Block, ...]:
    """Return command, versions, seeds and inputs with their hashes; settings and recordings folded away."""
    seeds = ", ".join(f"{name} {seed}" for name, seed in provenance.seeds.items())
    made = ", ".join(f"{name} {number}" for name, number in sorted(provenance.versions.items()))
    notes = (provenance.command, f"versions: {made}", f"seeds: {seeds}")
    settings = Table(headings=("setting", "value "), rows=tuple(_flat(provenance.settings)))
    return (
        Section(title="How to make it again", lines=("in the campaign's folder:",), notes=notes),
        Section(title="Inputs", table=_hashes((provenance.campaign, provenance.trial_list))),
        Fold(
            f"SHA-256 of the {len(provenance.recordings)} recordings",
            Section(table=_hashes(provenance.recordings)),
        ),
        Fold("All settings, defaults filled in, in SI", Section(table=settings)),
    )


def _hashes(files: Iterable[InputFile]) -> Table:
    rows = tuple((item.path, item.sha256 or "could not be read") for item in files)
    return Table(headings=("file", "SHA-256 "), rows=rows)


def _flat(tree: Mapping[str, Any], stem: str = "") -> Iterator[tuple[str, str]]:
    """Return a tree as rows; what is empty or not given is left out."""
    for key, value in tree.items():
        name = f"{stem}.{key}" if stem else str(key)
        if isinstance(value, Mapping):
            yield from _flat(value, name)
        elif isinstance(value, list):
            if value:
                yield name, ", ".join(map(str, value))
        elif value is not None and value != "":
            yield name, str(value)
