"""A campaign's result for people: the summary, the report, and both as files beside what they rest on."""

import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from ropefric.files.folder import Folder, as_folder
from ropefric.glossary import counted
from ropefric.papers.prth import reduction_of
from ropefric.pipeline.evidence import Evidence, evidence_files, gather_evidence, manifest, trace_provenance
from ropefric.pipeline.run import CampaignRun
from ropefric.report import parts
from ropefric.report.page import Alert, Block, Chapter, Fact, Fold, Picture, Report, as_html
from ropefric.report.section import Section, as_text, interval, percent, plain
from ropefric.scenes.kind import Part
from ropefric.traces.breakaway import ADVICE, Status
from ropefric.trials import result
from ropefric.trials.outliers import RULES

Pictures = Mapping[str, Sequence[Picture]]
"""Pictures by the chapter they belong to, in order."""

_NAMED = 8
"""Trials that an alert names; the others are counted."""
_SAID = 3
"""Problems of one kind that are said in full."""
_CHAPTERS = {
    "warnings": "What to know first",
    "result": "The result",
    "trials": "What was measured",
    "friction": "Does it obey the capstan equation?",
    "law": "How good the law is",
    "paper": "As the paper on rope and wheel reduces trials",
    "uncertainty": "What makes up the uncertainty",
    "design": "The design and its neighbours",
    "next": "What to measure next",
    "provenance": "Settings and provenance",
}
_NONE = (math.nan, math.nan, 0)
_WHERE = (
    "Chosen among the wheels that were used, and wraps and end tensions between the smallest and the largest that "
    "were, so that the lift force of the design becomes as certain as it can."
)


def write_report(
    run: CampaignRun,
    folder: Folder | str | os.PathLike[str],
    *,
    figures: bool = True,
    executor: Executor | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> tuple[Path, ...]:
    """Write summary.txt, report.html with the numbers of its figures, and what they rest on; return the paths.

    The page needs nothing else. Beside it stand figures/*.csv, uncertainty.json and next_tests.csv where there is a
    design, and manifest.json. The same campaign gives the same bytes. The figures are drawn by the executor, if any.
    """
    target = as_folder(folder)
    evidence = gather_evidence(run)
    provenance = trace_provenance(run, evidence)
    pictures: Pictures = {}
    reduced, of_paper = reduction_of(run.answer.table)
    if figures:
        from ropefric.report.pictures import draw_pictures  # noqa: PLC0415  (matplotlib takes half a second)

        pictures = draw_pictures(
            run, evidence, target, executor=executor, progress=progress, of_paper=of_paper
        )
    numbers = [
        target.path / name for drawn in pictures.values() for picture in drawn for name in picture.files
    ]
    texts = evidence_files(evidence) | manifest(provenance, run.campaign.path, target.path)
    texts |= {
        "summary.txt": as_text(summary_sections(run)),
        "report.html": as_html(campaign_report(run, evidence, provenance, pictures, reduced)),
    }
    return (*numbers, *target.write(texts))


def summary_sections(run: CampaignRun) -> tuple[Section, ...]:
    """Return the law that is used, how it won, what is doubtful, and the lift force of the design."""
    answer, counts = run.answer, result.count_trials(run.extraction)
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
    sections = (
        Section(lines=lines),
        parts.verdict_section(answer.verdict, "The verdict"),
        _law_section(run),
        parts.comparison_section(answer.comparison),
        parts.diagnosis_section(answer.diagnosis),
        Section("Doubts", notes=answer.doubts or ("nothing was found",)),
    )
    if answer.prediction is not None:
        return (*sections, parts.prediction_section(answer.prediction))
    nowhere = Section("Lift force", ("the campaign names no wheel: add [design] to it",))
    return sections if run.campaign.design is not None else (*sections, nowhere)


def _tally(extraction: result.Extraction) -> str:
    counts = result.count_trials(extraction)
    trials, conditions = counted(counts["n_trials"], "trial"), counted(counts["n_conditions"], "condition")
    return f"{trials} of {conditions}: {result.outcome_words(counts)}"


def _law_section(run: CampaignRun) -> Section:
    return parts.fit_section(run.answer.fit, f"The law: {run.answer.fit.law}, {run.answer.winner.how}")


def campaign_report(
    run: CampaignRun,
    evidence: Evidence,
    provenance: Mapping[str, Any],
    pictures: Pictures,
    reduced: Iterable[Part] = (),
) -> Report:
    """Return a campaign's report: what to know first, the result, the evidence, settings and provenance."""
    answer, extraction, plan = run.answer, run.extraction, evidence.plan
    by_hand = Fold("The lift force by hand", Section(lines=evidence.hand, verbatim=True))
    undecided = [
        f"{cause.cause}: {cause.experiment}"
        for cause in answer.diagnosis.causes
        if cause.supported == "cannot-tell"
    ]
    blocks: dict[str, Iterable[Block]] = {
        "warnings": [_alerts(run, evidence, with_figures=bool(pictures))],
        "result": [_facts(run, evidence), _law_section(run), *([by_hand] if evidence.hand else [])],
        "trials": [
            _measured_section(run),
            *pictures.get("trials", ())[:1],
            *_trial_sections(extraction, evidence),
            *_decided_section(extraction),
            *_sliding_section(extraction),
            *pictures.get("trials", ())[1:],
        ],
        "friction": [
            parts.diagnosis_section(answer.diagnosis)._replace(title=""),
            *pictures.get("friction", ()),
            *([Section("What would decide it", notes=undecided)] if undecided else []),
        ],
        "law": [
            parts.comparison_section(answer.comparison),
            *pictures.get("ladder", ()),
            *pictures.get("bands", ()),
            Section("Tested range: beyond it the law is extrapolated", notes=parts.tested_ranges(answer.fit)),
            *pictures.get("residuals", ()),
            *parts.notes_sections(answer.fit),
        ],
        "paper": [*(Section(**part._asdict()) for part in reduced), *pictures.get("paper", ())],
        "uncertainty": _uncertainty(evidence, pictures),
        "design": pictures.get("design", ()),
        "next": () if plan is None else [Section(lines=(_WHERE,)), *parts.plan_sections(plan)],
        "provenance": _provenance(provenance),
    }
    chapters = (Chapter(key, _CHAPTERS[key], tuple(own)) for key, own in blocks.items())
    return Report(
        title=run.campaign.name,
        lead=f"{_tally(extraction)}; the friction law they ask for, how good it is, and the lift force it gives.",
        chapters=tuple(chapter for chapter in chapters if chapter.blocks),
    )


def _uncertainty(evidence: Evidence, pictures: Pictures) -> Iterator[Block]:
    typical = f"condition {evidence.typical_number}, a typical one"
    for stated, key, of_what in (
        (evidence.lift, "budget_lift", "the design"),
        (evidence.typical, "budget_force", typical),
    ):
        if stated is not None:
            budget, *rest = parts.uncertainty_sections(
                stated, f"Budget of the {stated.model.name} of {of_what}"
            )
            yield budget
            yield from pictures.get(key, ())
            yield from (part for part in rest if part.lines or part.notes)
            yield from pictures.get("tornado", ()) if stated is evidence.lift else ()


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


def _alerts_of_trials(extraction: result.Extraction) -> Iterator[Alert]:
    groups: dict[tuple[int, int, str], list[result.TrialResult]] = {}
    statuses, outcomes = [str(status) for status in Status], ("without a force", "rejected", "excluded")
    for trial in extraction.trials:
        if trial.outcome in outcomes:
            grave, status = outcomes.index(trial.outcome), str(trial.breakaway.status)
            why = (status, trial.rejected_by, trial.excluded)[grave]
            groups.setdefault((grave, 0 if grave else statuses.index(status), why), []).append(trial)
    for (grave, _, why), alike in sorted(groups.items(), key=lambda group: group[0][:2]):
        names = ", ".join(trial.trial for trial in alike[:_NAMED])
        names += f" and {len(alike) - _NAMED} more" if len(alike) > _NAMED else ""
        what = f"{counted(len(alike), 'trial')} {outcomes[grave]}"
        if grave == 0:
            yield Alert("doubt", f"{what}: {why}", f"{names}. {_advice(Status(why), alike)}")
        elif grave == 1:
            text = f"{names}. They take no part in the law; look for a physical reason."
            yield Alert("note", f"{what} by the rule {why} ({_rule_label(why)})", text)
        else:
            yield Alert("note", f"{what}: {why}", f"{names}.")


def _rule_label(rule: str) -> str:
    return RULES[rule].label if rule in RULES else rule


def _advice(status: Status, flagged: Sequence[result.TrialResult]) -> str:
    """Return what to do about a status; for a file that could not be read, the reader's own words."""
    if status is not Status.UNREADABLE:
        return ADVICE[status]
    fixes = dict.fromkeys(problem.fix for trial in flagged for problem in trial.problems if problem.fix)
    details = dict.fromkeys(trial.breakaway.detail for trial in flagged)
    return f"{'; '.join([*details][:_SAID])}. To do: {'; '.join([*fixes][:_SAID]) or 'record again'}."


def _alerts_of_problems(extraction: result.Extraction) -> Iterator[Alert]:
    """Give what else was wrong or doubtful, by kind; what a flagged recording says of itself is said already."""
    flagged = [trial for trial in extraction.trials if trial.breakaway.status is not Status.OK]
    for code, alike in result.problems_by_code(extraction, said_of=flagged).items():
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
        at = found.conditions
        cells = parts.setting_cells(at.wheel_radius_m[0], at.wrap_angle_rad[0], at.end_tension_N[0])
        (wheel, wrap, tension), rope = cells, plain(2e3 * at.rope_radius_m[0])
        where = f"on average, for R_w = {wheel} mm, φ = {wrap} deg, F_B = {tension} N, rope of {rope} mm"
        facts.append(Fact("Lift force of the design", f"{plain(found.lift_force_N[0], '.5g')} N", where))
        level, one = f"{100 * found.level:g} %", found.prediction_interval_N[0]
        mean = f"where the average of many ropes lies; standard error {plain(found.std_N[0], '.2g')} N"
        facts.append(Fact(f"{level} confidence interval", f"{interval(found.interval_N[0])} N", mean))
        if not math.isnan(float(one[0])):
            pull = "where one pull with a new rope lies"
            facts.append(Fact(f"{level} prediction interval", f"{interval(one)} N", pull))
    facts.append(Fact("Law", f"{fit.law}, {run.answer.verdict.word}", run.answer.verdict.reason))
    unseen, scatter = run.answer.winner.entry.loco_error, fit.statistics.scatter_within
    if math.isfinite(unseen):
        remark = "root mean square over conditions left out one by one"
        facts.append(Fact("Error at unseen conditions", percent(unseen), remark))
    if math.isfinite(scatter):
        facts.append(Fact("Scatter between repeats", percent(scatter), "standard deviation of one pull"))
    if evidence.lift is not None:
        first, name = evidence.lift.budget.lines[0], f"What dominates the {evidence.lift.model.name}"
        facts.append(Fact(name, first.label, f"{percent(first.share, '.0f')} of its variance"))
    if (plan := evidence.plan) is not None:
        value = f"{counted(len(plan), 'condition')}, {counted(len(plan) * plan.repeats, 'pull')}"
        better = f"for a mean law {plain(plan.improvement, '.2g')} times as certain"
        facts.append(Fact("What to measure next", value, better))
    return facts


def _measured_section(run: CampaignRun) -> Section:
    """Return with what was measured, and over which range."""
    campaign, rope = run.campaign, run.campaign.rope
    density = rope.linear_density_kg_m
    weight = "" if density is None else f"{plain(1e3 * density)} g/m"
    of_rope = (f"rope: {plain(2e3 * rope.radius_m)} mm in diameter", weight, rope.material)
    wheels = [
        f"{name} R_w = {plain(1e3 * wheel.radius_m)} mm" + (f" ({wheel.material})" if wheel.material else "")
        for name, wheel in campaign.wheels.items()
    ]
    cells = [
        f"{name} to {plain(cell.full_scale_N)} N"
        + (f" ({', '.join(cell.assumed)} assumed, not stated)" if cell.assumed else "")
        for name, cell in campaign.cells.items()
    ]
    window_s = campaign.smoothing.window_s
    smoothing = campaign.smoothing.mode + (f", {plain(1e3 * window_s)} ms" if window_s else "")
    notes = (
        ", ".join(filter(None, of_rope)),
        f"wheels: {', '.join(wheels)}" if wheels else "",
        f"force cells: {', '.join(cells)}" if cells else "",
        f"tested: {', '.join(parts.tested_ranges(run.answer.fit))}",
        f"protocol {campaign.protocol.name}; smoothing {smoothing}; outliers by {campaign.rejection}",
    )
    return Section(notes=tuple(filter(None, notes)))


def _trial_sections(extraction: result.Extraction, evidence: Evidence) -> tuple[Section, Section]:
    """Return all trials that do not count, with what became of them and why; and all conditions.

    Of a condition: how many trials, their mean force, scatter and uncertainty, and which do not count.
    """
    slack = any(trial.measures_slack for trial in extraction.trials)
    known, measured = ("F_A", "F_B") if slack else ("F_B", "F_A")
    place = {name: summary for summary in extraction.conditions for name in summary.trials}
    gone = {trial.trial: trial for trial in extraction.trials if not trial.kept}
    counts = result.count_trials(extraction)
    title = f"Trials not kept (of {counted(counts['n_trials'], 'trial')}: {result.outcome_words(counts)})"
    aside = Section(title, ("Every trial gave a force and counts.",), notes=evidence.rejection)
    rows: list[tuple[str, ...]] = []
    headings: tuple[str, ...]
    if gone:
        for trial in sorted(gone.values(), key=lambda trial: trial.breakaway.status is not Status.DOUBTFUL):
            fate = str(trial.breakaway.status) if trial.outcome == "without a force" else trial.outcome
            known_N = trial.peak_N if trial.measures_slack else trial.end_tension_N
            cells = parts.setting_cells(trial.wheel_radius_m, trial.wrap_angle_rad, known_N)
            why = _why(trial, place.get(trial.trial))
            rows.append((trial.trial, fate, *cells, plain(trial.measured_N), why))
        headings = ("trial", "verdict", "R_w [mm]", "φ [deg]", f"{known} [N]", f"{measured} [N]", "why ")
        aside = Section(title, headings=headings, rows=rows, left=2, notes=evidence.rejection)
    budgets = {condition.number: budget for condition, budget in evidence.measured}
    rows = []
    for number, item in enumerate(extraction.conditions, start=1):
        uncertainty = ("–", "–", "")
        if (stated := budgets.get(number)) is not None:
            largest = stated.lines[0]
            part = f"{largest.label} ({percent(largest.share, '.0f')})"
            uncertainty = (plain(stated.combined, ".2g"), percent(stated.relative), part)
        cells, forces = parts.condition_cells(item, slack=slack)
        not_kept = ", ".join(name for name in item.trials if name in gone)
        kept = f"{item.n_kept} of {item.n_recorded}"
        rows.append((str(number), *cells, kept, *forces, *uncertainty, not_kept))
    headings = (
        *("no.", "R_w [mm]", "φ [deg]", f"{known} [N]", "kept", f"mean {measured} [N]", "s [N]"),
        *("u_c [N]", "u_c/mean", "largest part of u_c ", "not kept "),
    )
    note = (
        f"mean {measured} and s: of the trials kept; u_c: standard uncertainty of that mean, repeats and measuring "
        "chain; every trial stands in trials.csv"
    )
    return aside, Section("Conditions", headings=headings, rows=rows, left=0, notes=(note,))


def _sliding_section(extraction: result.Extraction) -> Iterator[Section]:
    """Yield what was measured beside the break-away force, by condition: mean ± s of the kept trials."""
    conditions = extraction.conditions
    shown = [
        name for name in result.SUMMARISED if any(item.of_kept.get(name, _NONE)[2] for item in conditions)
    ]
    if not shown:
        return
    rows = []
    for number, item in enumerate(conditions, start=1):
        found = [item.of_kept.get(name, _NONE) for name in shown]
        cells = (f"{plain(mean)} ± {plain(std, '.2g')}" if n > 1 else plain(mean) for mean, std, n in found)
        rows.append((str(number), str(max(n for *_, n in found)), *cells))
    headings = ("no.", "n", *(result.SUMMARISED[name] for name in shown))
    note = "mean ± s of the kept trials, n of them at most; every trial stands in trials.csv"
    yield Section("Beside the break-away force", headings=headings, rows=rows, left=0, notes=(note,))


def _decided_section(extraction: result.Extraction) -> Iterator[Section]:
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
        yield Section("Decided by people", headings=headings, rows=rows, left=1)


def _why(trial: result.TrialResult, summary: result.ConditionSummary | None) -> str:
    if trial.excluded:
        return trial.excluded
    if trial.breakaway.status is not Status.OK:
        return trial.why_no_force
    rule = _rule_label(trial.rejected_by)
    if summary is None:
        return rule
    return f"{rule}; mean of all {plain(summary.mean_all_N)} N, s = {plain(summary.std_all_N, '.2g')} N"


def _provenance(provenance: Mapping[str, Any]) -> tuple[Block, ...]:
    """Return command, versions, seeds and inputs with their hashes; settings and recordings folded away."""
    seeds = ", ".join(f"{name} {seed}" for name, seed in provenance["seeds"].items())
    made = ", ".join(f"{name} {number}" for name, number in sorted(provenance["versions"].items()))
    notes = (provenance["command"], f"versions: {made}", f"seeds: {seeds}")
    settings = Section(headings=("setting", "value "), rows=[*_flat(provenance["settings"])])
    lists, recordings = provenance["inputs"][:2], provenance["inputs"][2:]
    return (
        Section("How to make it again", ("in the campaign's folder:",), notes=notes),
        _hashes(lists, "Inputs"),
        Fold(f"SHA-256 of the {len(recordings)} recordings", _hashes(recordings)),
        Fold("All settings, defaults filled in, in SI", settings),
    )


def _hashes(files: Iterable[Mapping[str, str]], title: str = "") -> Section:
    rows = [(item["path"], item["sha256"] or "could not be read") for item in files]
    return Section(title, headings=("file", "SHA-256 "), rows=rows)


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
