"""A result for people: the summary and the report of a campaign or a trial table, as files beside what they rest on."""

import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from ropefric import pipeline
from ropefric.files.folder import Folder, as_folder
from ropefric.files.plain_text import json_document
from ropefric.glossary import counted
from ropefric.pipeline import CampaignAnswer, CampaignRun, Evidence
from ropefric.report import page, parts
from ropefric.report.page import USUAL, Alert, Block, Chapter, Fold, Picture, Report, Subject, Wish
from ropefric.section import Section, as_text, percent, plain
from ropefric.traces.breakaway import ADVICE, Status
from ropefric.trials import numbers, result
from ropefric.trials.campaign_model import ReportWords
from ropefric.trials.outliers import RULES

Progress = Callable[[int, int, str], None]
Pictures = Mapping[str, Sequence[Picture]]
"""Pictures by the chapter they belong to, in order."""

_NAMED = 8
"""Trials that an alert names; the others are counted."""
_SAID = 3
"""Problems of one kind that are said in full."""
_CHAPTERS = {
    "result": "The result",
    "warnings": "What to know of the measurements",
    "trials": "What was measured",
    "recordings": "Every recording and its pick",
    "friction": "Does it obey the capstan equation?",
    "law": "How good the law is",
    "uncertainty": "What makes up the uncertainty",
    "design": "The design and its neighbours",
    "next": "What to measure next",
    "provenance": "Settings and provenance",
}
_OF_LAW = ("ladder", "bands", "residuals")
_NONE = (math.nan, math.nan, 0)
_WHERE = (
    "Chosen among the wheels that were used, and wraps and end tensions between the smallest and the largest that "
    "were, so that the lift force of the design becomes as certain as it can."
)


def write_report(
    run: CampaignRun,
    folder: Folder | str | os.PathLike[str],
    wish: Wish = USUAL,
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> tuple[Path, ...]:
    """Write summary.txt, report.html with the numbers of its figures, and what they rest on; return the paths.

    The page needs nothing else. Beside it stand figures/*.csv, uncertainty.json and next_tests.csv where there is a
    design, manifest.json and, if wished, report.pdf. The same campaign gives the same bytes. The figures are drawn by
    the executor, if any.
    """
    target, campaign, evidence = as_folder(folder), run.campaign, pipeline.gather_evidence(run)
    provenance, tally = pipeline.trace_provenance(run, evidence), _tally(run.extraction)
    told = (campaign.report, page.measured_rows(run), run, wish)
    subject = Subject(campaign.name, tally, run.answer, evidence, provenance, *told)
    texts = pipeline.manifest(provenance, campaign.path, target.path)
    texts["summary.txt"] = as_text(summary_sections(run))
    return _write(subject, target, texts, executor=executor, progress=progress)


def write_table_report(
    answer: CampaignAnswer,
    inputs: Sequence[Path],
    folder: Folder,
    *,
    words: ReportWords,
    wish: Wish = USUAL,
    progress: Progress | None = None,
) -> tuple[Path, ...]:
    """Write the same for the answer to a trial table, for those who have forces and no recordings.

    The inputs are the table and, where there is one, the file that says more about it, from where `words` are.
    """
    evidence, table, found = pipeline.gather_evidence(answer), inputs[0], answer.fit.statistics
    trials = counted(len(answer.table.trial), "trial")
    tally = f"{trials} of {counted(found.n_conditions, 'condition')}: {found.n} fitted"
    provenance = pipeline.trace_table(answer, evidence, inputs)
    measured = {"Trial table": table.name}
    subject = Subject(table.stem, tally, answer, evidence, provenance, words, measured, wish=wish)
    texts = {pipeline.MANIFEST: json_document(provenance)}
    texts["summary.txt"] = as_text((Section(lines=[f"{table.name}: {tally}"]), *answer_sections(answer)))
    return _write(subject, folder, texts, executor=None, progress=progress)


def _write(
    subject: Subject,
    folder: Folder,
    texts: dict[str, str],
    *,
    executor: Executor | None,
    progress: Progress | None,
) -> tuple[Path, ...]:
    pictures: Pictures = {}
    if subject.wish.figures:
        from ropefric.report.pictures import draw_pictures  # noqa: PLC0415  (matplotlib takes half a second)

        pictures = draw_pictures(subject, folder, executor=executor, progress=progress)
    numbers = [
        folder.path / name for drawn in pictures.values() for picture in drawn for name in picture.files
    ]
    html = page.as_html(_report(subject, pictures))
    files: dict[str, Any] = texts | pipeline.evidence_files(subject.evidence) | {"report.html": html}
    if subject.wish.pdf:
        files["report.pdf"] = page.pdf_of(html)
    return (*numbers, *folder.write(files))


def summary_sections(run: CampaignRun) -> tuple[Section, ...]:
    """Return what was recorded, the law that is used, how it won, what is doubtful, and the lift force of the design."""
    counts = result.count_trials(run.extraction)
    lines = [f"{run.campaign.name}: {_tally(run.extraction)}"]
    if counts["n_rejected"]:
        lines.append(f"rejected by the rule {run.campaign.rejection}; look for a physical reason")
    if statuses := ", ".join(f"{n} {status}" for status, n in counts["status"].items() if status != "ok"):
        lines.append(f"recordings without a usable force: {statuses}")
    for name, cell in run.campaign.cells.items():
        if cell.assumed:
            limits = ", ".join(cell.assumed)
            lines.append(f"force cell {name}: {limits} assumed, not stated: state them in [cells.{name}]")
    sections = (Section(lines=lines), *answer_sections(run.answer))
    nowhere = Section("Lift force", ("the campaign names no wheel: add [design] to it",))
    return sections if run.campaign.design is not None else (*sections, nowhere)


def answer_sections(answer: CampaignAnswer) -> tuple[Section, ...]:
    """Return the law that is used, how it won, what is doubtful, and the lift force of the design."""
    sections = (
        parts.verdict_section(answer.verdict, "The verdict"),
        parts.fit_section(answer.fit, f"The law: {answer.fit.law}, {answer.winner.how}"),
        parts.comparison_section(answer.comparison),
        parts.diagnosis_section(answer.diagnosis),
        Section("Doubts", notes=answer.doubts or ("nothing was found",)),
    )
    lift = answer.prediction
    return sections if lift is None else (*sections, parts.prediction_section(lift))


def _tally(extraction: result.Extraction) -> str:
    counts = result.count_trials(extraction)
    trials, conditions = counted(counts["n_trials"], "trial"), counted(counts["n_conditions"], "condition")
    return f"{trials} of {conditions}: {result.outcome_words(counts)}"


def _report(subject: Subject, pictures: Pictures) -> Report:
    """Return a report: the result on the first pages, then what to know, the evidence, settings and provenance."""
    answer, evidence, run = subject.answer, subject.evidence, subject.run
    by_hand = Fold("The lift force by hand", Section(lines=evidence.hand, verbatim=True))
    open_causes = [one for one in answer.diagnosis.causes if one.supported == "cannot-tell"]
    undecided = [f"{cause.cause}: {cause.experiment}" for cause in open_causes]
    of_answer = [*_alerts_of_answer(answer, evidence, asked=run is None or run.campaign.design is not None)]
    of_trials = [alert for alert in of_answer if alert.grade == "note"]
    if run is not None:
        of_trials += [*_alerts_of_trials(run.extraction), *_alerts_of_problems(run.extraction)]
    of_trials.sort(key=lambda alert: alert.grade)
    if not pictures:
        text = "This report was made without figures; `ropefric report` adds them."
        of_trials.append(Alert("note", "No figures", text))
    blocks: dict[str, Iterable[Block]] = {
        "result": page.front_blocks(subject, of_answer, len(of_trials), pictures.get("front", ())),
        "warnings": [of_trials] if of_trials else [],
        "trials": [*(_trial_sections(run, evidence) if run else ()), *pictures.get("trials", ())],
        "recordings": pictures.get("recordings", ()),
        "friction": [
            parts.diagnosis_section(answer.diagnosis)._replace(title=""),
            *pictures.get("friction", ()),
            *([Section("What would decide it", notes=undecided)] if undecided else []),
        ],
        "law": [
            parts.comparison_section(answer.comparison),
            *(drawn for key in _OF_LAW for drawn in pictures.get(key, ())),
            *parts.notes_sections(answer.fit),
        ],
        "uncertainty": _uncertainty(evidence, pictures),
        "design": [*pictures.get("design", ()), *([by_hand] if evidence.hand else [])],
        "next": [Section(lines=(_WHERE,)), *parts.plan_sections(evidence.plan)] if evidence.plan else (),
        "provenance": _provenance(subject.provenance, 2 if run else 1),
    }
    chapters = (Chapter(key, _CHAPTERS[key], tuple(own)) for key, own in blocks.items())
    lead = f"{subject.tally}; the friction law they ask for, how good it is, and the lift force it gives."
    shown = tuple(chapter for chapter in chapters if chapter.blocks)
    return Report(subject.title, lead, shown)


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


def _alerts_of_answer(answer: CampaignAnswer, evidence: Evidence, *, asked: bool) -> Iterator[Alert]:
    """Give what stands against a law and its lift force, or ought to be kept in mind; whether one was `asked` for."""
    verdict, prediction = answer.verdict, answer.prediction
    if not verdict.supported:
        of_lift = answer.winner.verdict.supported
        what = f"The lift force by {answer.fit.law}" if of_lift else f"The law {answer.fit.law}"
        yield Alert("stop", f"{what} is {verdict.word}", verdict.reason)
    for doubt in answer.doubts:
        if doubt not in verdict.reasons:
            yield Alert("doubt", "About the law", doubt)
    if prediction is not None:
        outside = Alert("doubt", "The design lies outside what was tested", "")
        about = outside if prediction.extrapolated[0] else Alert("note", "About the lift force", "")
        yield from (about._replace(text=note) for note in prediction.notes())
    elif not asked:
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
            yield Alert("note", f"{what} by the rule {why} ({RULES[why].label})", text)
        else:
            yield Alert("note", f"{what}: {why}", f"{names}.")


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


def _trial_sections(run: CampaignRun, evidence: Evidence) -> Iterator[Section]:
    """Give all trials that do not count, with what became of them and why; all conditions, and what people decided.

    Of a condition: how many trials, their mean force, scatter and uncertainty, and which do not count.
    """
    extraction = run.extraction
    slack = any(trial.measures_slack for trial in extraction.trials)
    known, measured = ("F_A", "F_B") if slack else ("F_B", "F_A")
    place = {name: summary for summary in extraction.conditions for name in summary.trials}
    gone = {trial.trial: trial for trial in extraction.trials if not trial.kept}
    counts = result.count_trials(extraction)
    title = f"Trials not kept (of {counted(counts['n_trials'], 'trial')}: {result.outcome_words(counts)})"
    rows: list[tuple[str, ...]] = []
    for trial in sorted(gone.values(), key=lambda trial: trial.breakaway.status is not Status.DOUBTFUL):
        fate = str(trial.breakaway.status) if trial.outcome == "without a force" else trial.outcome
        known_N = trial.peak_N if trial.measures_slack else trial.end_tension_N
        cells = parts.setting_cells(trial.wheel_radius_m, trial.wrap_angle_rad, known_N)
        why = _why(trial, place.get(trial.trial))
        rows.append((trial.trial, fate, *cells, plain(trial.measured_N), why))
    headings: tuple[str, ...]
    headings = ("trial", "verdict", "R_w [mm]", "φ [deg]", f"{known} [N]", f"{measured} [N]", "why ")
    lines = () if gone else ("Every trial gave a force and counts.",)
    yield Section(title, lines, headings if gone else (), rows, 2, evidence.rejection)
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
    yield Section("Conditions", headings=headings, rows=rows, left=0, notes=(note,))
    yield from _decided_section(extraction)
    yield from _sliding_section(extraction)


def _sliding_section(extraction: result.Extraction) -> Iterator[Section]:
    """Yield what was measured beside the break-away force, by condition: mean ± s of the kept trials."""
    conditions = extraction.conditions
    named = {one.name: one.heading(one.words) for one in numbers.summarised()}
    shown = [name for name in named if any(item.of_kept.get(name, _NONE)[2] for item in conditions)]
    if not shown:
        return
    rows = []
    for number, item in enumerate(conditions, start=1):
        found = [item.of_kept.get(name, _NONE) for name in shown]
        cells = (f"{plain(mean)} ± {plain(std, '.2g')}" if n > 1 else plain(mean) for mean, std, n in found)
        rows.append((str(number), str(max(n for *_, n in found)), *cells))
    headings = ("no.", "n", *(named[name] for name in shown))
    note = "mean ± s of the kept trials, n of them at most; every trial stands in trials.csv"
    yield Section("Beside the break-away force", headings=headings, rows=rows, left=0, notes=(note,))


def _decided_section(extraction: result.Extraction) -> Iterator[Section]:
    """Yield what people decided about single trials, where they did: what, who and why."""
    rows = []
    for trial in extraction.trials:
        if trial.decision or (trial.excluded and trial.by):
            what = trial.decision or f"excluded: {trial.excluded}"
            without = [note for note in trial.breakaway.notes if note.startswith("without the decision")]
            own = trial.by, trial.why, "; ".join(without)
            rows.append((trial.trial, what, plain(trial.measured_N), *own))
    if rows:
        headings = ("trial", "decision ", "F_A [N]", "by ", "why ", "and else ")
        yield Section("Decided by people", headings=headings, rows=rows, left=1)


def _why(trial: result.TrialResult, summary: result.ConditionSummary | None) -> str:
    if trial.excluded:
        return trial.excluded
    if trial.breakaway.status is not Status.OK:
        return trial.why_no_force
    rule = RULES[trial.rejected_by].label
    if summary is None:
        return rule
    return f"{rule}; mean of all {plain(summary.mean_all_N)} N, s = {plain(summary.std_all_N, '.2g')} N"


def _provenance(provenance: Mapping[str, Any], n_lists: int) -> tuple[Block, ...]:
    """Return command, versions, seeds and inputs with their hashes; settings and recordings folded away."""
    seeds = ", ".join(f"{name} {seed}" for name, seed in provenance["seeds"].items())
    made = ", ".join(f"{name} {number}" for name, number in sorted(provenance["versions"].items()))
    notes = (provenance["command"], f"versions: {made}", f"seeds: {seeds}")
    settings = Section(headings=("setting", "value "), rows=[*_flat(provenance["settings"])])
    lists, recordings = provenance["inputs"][:n_lists], provenance["inputs"][n_lists:]
    of_recordings = Fold(f"SHA-256 of the {counted(len(recordings), 'recording')}", _hashes(recordings))
    return (
        Section("How to make it again", ("in the folder of the inputs:",), notes=notes),
        _hashes(lists, "Inputs"),
        *([of_recordings] if recordings else []),
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
