"""A result for people: the summary and the report of a campaign or a trial table, as files beside what they rest on."""

import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import Any

from ropefric import pipeline
from ropefric.files.folder import Folder, as_folder
from ropefric.files.plain_text import json_document
from ropefric.fitting.diagnose import WORDS, Diagnosis
from ropefric.fitting.predict import outside_words
from ropefric.friction.laws import ALL_LAWS
from ropefric.glossary import counted
from ropefric.pipeline import CampaignAnswer, CampaignRun, Evidence
from ropefric.report import page, parts
from ropefric.report.page import USUAL, Alert, Block, Chapter, Fold, Picture, Report, Subject, Wish
from ropefric.section import Section, as_text, percent, plain, plus_minus, to_error
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
    "warnings": "Remarks on the measurements",
    "trials": "Measured forces",
    "recordings": "Recordings",
    "friction": "Does the rope obey the capstan equation?",
    "law": "Fit of the law",
    "uncertainty": "Uncertainty budget",
    "design": "The design and its neighbours",
    "next": "Recommended tests",
    "provenance": "Settings and provenance",
}
_NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")
_WITHOUT = "without the decision: "
_NONE = (math.nan, math.nan, 0)
_WHERE = (
    "The plan uses the wheels of this campaign, and wraps and end tensions within the tested range. It makes the "
    "standard error of the lift force of the design as small as possible. The limit of F_A is the full scale of the "
    "largest force cell, or the largest measured force where no cell is stated."
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

    The page is complete in itself. Beside it are figures/*.csv, manifest.json, uncertainty.json and next_tests.csv if
    there is a design, and report.pdf if wished. The same campaign gives the same bytes. The figures are drawn by
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

    The inputs are the table and, if given, the file with the `words` about it.
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
    """Return counts of the recordings, the law in use and its comparison, the doubts, and the lift force."""
    counts = result.count_trials(run.extraction)
    lines = [f"{run.campaign.name}: {_tally(run.extraction)}"]
    if counts["n_rejected"]:
        lines.append(f"rejected by the rule {run.campaign.rejection}: look for a physical reason")
    if statuses := ", ".join(f"{n} {status}" for status, n in counts["status"].items() if status != "ok"):
        lines.append(f"recordings without a usable force: {statuses}")
    for name, cell in run.campaign.cells.items():
        if cell.assumed:
            limits = ", ".join(cell.assumed)
            lines.append(f"force cell {name}: {limits} assumed, not stated: state them in [cells.{name}]")
    sections = (Section(lines=lines), *_noted_section(run.extraction), *answer_sections(run.answer))
    nowhere = Section("Lift force", ("the campaign names no wheel: add [design] to it",))
    return sections if run.campaign.design is not None else (*sections, nowhere)


def answer_sections(answer: CampaignAnswer) -> tuple[Section, ...]:
    """Return the law in use and its comparison, the doubts, and the lift force of the design."""
    sections = (
        parts.verdict_section(answer.verdict, "The verdict"),
        parts.fit_section(answer.fit, f"The law: {answer.fit.law}, {answer.winner.how}"),
        parts.comparison_section(answer.comparison),
        parts.diagnosis_section(answer.diagnosis),
        Section("Doubts", notes=answer.doubts or ("all checks passed",)),
    )
    lift = answer.prediction
    return sections if lift is None else (*sections, parts.prediction_section(lift))


def _tally(extraction: result.Extraction) -> str:
    counts = result.count_trials(extraction)
    trials, conditions = counted(counts["n_trials"], "trial"), counted(counts["n_conditions"], "condition")
    return f"{trials} of {conditions}: {result.outcome_words(counts)}"


def _report(subject: Subject, pictures: Pictures) -> Report:
    """Return a report: the result on the first pages, then the annex; of a short one the first pages alone."""
    answer, evidence, run = subject.answer, subject.evidence, subject.run
    found = _alerts_of_answer(answer, evidence, asked=run is None or run.campaign.design is not None)
    of_answer = [alert._replace(text=_sentence(alert.text)) for alert in found]
    of_trials = [alert for alert in of_answer if alert.grade == "note"]
    if run is not None:
        of_trials += [*_alerts_of_trials(run.extraction), *_alerts_of_problems(run.extraction)]
    of_trials.sort(key=lambda alert: alert.grade)
    if not pictures:
        of_trials.append(Alert("note", "No figures", "`ropefric report` adds the figures."))
    front = page.front_blocks(subject, of_answer, of_trials, pictures.get("front", ()))
    blocks: dict[str, Iterable[Block]] = {"result": front}
    if not subject.wish.short:
        blocks |= {"warnings": [of_trials] if of_trials else []} | _annex(subject, pictures)
    chapters = (Chapter(key, _CHAPTERS[key], tuple(own)) for key, own in blocks.items())
    return Report(subject.title, f"{subject.tally}.", tuple(one for one in chapters if one.blocks))


def _annex(subject: Subject, pictures: Pictures) -> dict[str, Iterable[Block]]:
    """Return the blocks of each chapter behind the remarks."""
    answer, evidence, run = subject.answer, subject.evidence, subject.run
    hand = Fold("The lift force by hand", Section(lines=evidence.hand, verbatim=True))
    return {
        "trials": _trial_sections(run, evidence) if run else (),
        "recordings": pictures.get("recordings", ()),
        "friction": [*_causes(answer.diagnosis), *pictures.get("friction", ())],
        "law": [
            *pictures.get("law", ()),
            Fold("The laws compared", parts.comparison_section(answer.comparison)),
            *parts.notes_sections(answer.fit),
        ],
        "uncertainty": _uncertainty(evidence, pictures),
        "design": [*pictures.get("design", ()), *([hand] if evidence.hand else [])],
        "next": [Section(lines=(_WHERE,)), *parts.plan_sections(evidence.plan)] if evidence.plan else (),
        "provenance": _provenance(subject.provenance, 2 if run else 1),
    }


def _uncertainty(evidence: Evidence, pictures: Pictures) -> Iterator[Block]:
    if evidence.lift is not None:
        yield from parts.uncertainty_sections(evidence.lift, "The design", least_share=parts.LEAST_SHARE)
    yield from pictures.get("uncertainty", ())
    if evidence.typical is not None:
        title = f"The {evidence.typical.model.name} of condition {evidence.typical_number}, a typical one"
        found = parts.uncertainty_sections(evidence.typical, title, least_share=parts.LEAST_SHARE)
        yield from found if evidence.lift is None else (Fold(title, found[0]),)


def _causes(diagnosis: Diagnosis) -> Iterator[Section | Fold]:
    """Yield the causes the data support as a table; folded away those they do not, with what would decide them."""
    found: dict[bool, list[tuple[str, ...]]] = {True: [], False: []}
    for one in diagnosis.causes:
        yes, decide = one.supported == "yes", one.supported == "cannot-tell"
        found[yes].append((one.cause, WORDS[one.supported], one.experiment if decide else one.evidence))
    headings = ("cause ", "verdict ", "evidence, or the test that would decide ")
    yield Section("", (_sentence(diagnosis.summary),), headings if found[True] else (), found[True])
    if rest := found[False]:
        names = ", ".join(row[0] for row in rest)
        yield Fold(f"Not supported, or undetermined: {names}", Section("", (), headings, rest))


def _alerts_of_answer(answer: CampaignAnswer, evidence: Evidence, *, asked: bool) -> Iterator[Alert]:
    """Yield the doubts about a law and its lift force, with remarks; `asked`: whether a wheel was given."""
    verdict, prediction = answer.verdict, answer.prediction
    if not verdict.supported:
        of_lift = answer.winner.verdict.supported
        what = f"The lift force by {answer.fit.law}" if of_lift else f"The law {answer.fit.law}"
        yield Alert("stop", f"{what} is {verdict.word}", verdict.reason)
    for doubt in answer.doubts:
        if doubt not in verdict.reasons:
            yield Alert("doubt", "The law", doubt)
    if prediction is not None:
        beyond = outside_words(prediction.validity, prediction.conditions)
        outside = Alert("doubt", "The design lies outside the tested range", "")
        for note in prediction.notes():
            about = outside if note in beyond else Alert("note", "The lift force", "")
            yield about._replace(text=note)
    elif not asked:
        keys = "wheel_radius, wrap_angle and end_tension"
        yield Alert("note", "No lift force", f"The campaign names no wheel. Add [design] with {keys}.")
    for stated, what in ((evidence.lift, "the lift force"), (evidence.typical, "a typical measured force")):
        if stated is not None and not stated.trustworthy:
            yield Alert("doubt", f"Uncertainty of {what}: {stated.status}", stated.status.advice)
    yield from (Alert("note", "Left out of this report", text) for text in evidence.missing)


def _sentence(text: str) -> str:
    """Return a text with a capital letter, unless it begins with the name of a law."""
    return text if text.partition(" ")[0] in ALL_LAWS else f"{text[:1].upper()}{text[1:]}"


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
            text = f"{names}. They are not fitted. Look for a physical reason."
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
    """Yield all other problems by kind; problems of flagged recordings are reported already."""
    flagged = [trial for trial in extraction.trials if trial.breakaway.status is not Status.OK]
    for code, alike in result.problems_by_code(extraction, said_of=flagged).items():
        # By the name of the file alone: the page is the same wherever the campaign is.
        places = [replace(one, path=Path(one.path).name).where for one in alike[:_SAID]]
        said = zip(places, alike, strict=False)
        messages = [f"{place}: {one.message}" if place else one.message for place, one in said]
        if len(alike) > _SAID:
            messages.append(f"problems.csv lists {len(alike) - _SAID} more")
        fixes = dict.fromkeys(problem.fix for problem in alike[:_SAID] if problem.fix)
        text = "; ".join(messages) + "." + (f" To do: {'; '.join(fixes)}." if fixes else "")
        grave = any(problem.severity == "error" for problem in alike)
        yield Alert("doubt" if grave else "note", f"Recordings ({code})", text)


def _trial_sections(run: CampaignRun, evidence: Evidence) -> Iterator[Section | Fold]:
    """Yield all trials that are not kept, with the reason; the decisions of people; all conditions."""
    extraction = run.extraction
    slack = any(trial.measures_slack for trial in extraction.trials)
    forces = ("F_A", "F_B") if slack else ("F_B", "F_A")
    yield from _gone_section(extraction, evidence, forces)
    yield from _decided_section(extraction)
    yield _conditions_section(extraction, evidence, forces, slack=slack)
    yield from _sliding_section(extraction)
    yield from _noted_section(extraction)


def _noted_section(extraction: result.Extraction) -> Iterator[Section]:
    """Yield the notes on the recordings: of those that differ by their numbers only, their count and the first."""
    kinds: dict[str, list[tuple[str, str]]] = {}
    for trial in extraction.trials:
        for note in trial.breakaway.notes:
            if not note.startswith(_WITHOUT):
                kinds.setdefault(_NUMBER.sub("", note.partition(" (")[0]), []).append((trial.trial, note))
    rows = [(str(len(alike)), *alike[0]) for alike in sorted(kinds.values(), key=len, reverse=True)]
    if rows:
        yield Section(
            "Notes on the recordings", headings=("trials", "first ", "its note "), rows=rows, left=0
        )


def _gone_section(
    extraction: result.Extraction, evidence: Evidence, forces: tuple[str, str]
) -> Iterator[Section]:
    """Yield the trials that are not kept, doubtful ones first, and how the rule for outliers decides."""
    place = {name: summary for summary in extraction.conditions for name in summary.trials}
    gone = [trial for trial in extraction.trials if not trial.kept]
    if not gone:
        return
    rows = []
    for trial in sorted(gone, key=lambda trial: trial.breakaway.status is not Status.DOUBTFUL):
        fate = str(trial.breakaway.status) if trial.outcome == "without a force" else trial.outcome
        known_N = trial.peak_N if trial.measures_slack else trial.end_tension_N
        cells = parts.setting_cells(trial.wheel_radius_m, trial.wrap_angle_rad, known_N)
        why = _why(trial, place.get(trial.trial))
        rows.append((trial.trial, fate, *cells, plain(trial.measured_N), why))
    counts, (known, measured) = result.count_trials(extraction), forces
    title = f"Trials not kept (of {counted(counts['n_trials'], 'trial')}: {result.outcome_words(counts)})"
    headings = ("trial", "verdict", "R_w [mm]", "φ [deg]", f"{known} [N]", f"{measured} [N]", "why ")
    yield Section(title, (), headings, rows, 2, evidence.rejection)


def _conditions_section(
    extraction: result.Extraction, evidence: Evidence, forces: tuple[str, str], *, slack: bool
) -> Section:
    """Return every condition: number of trials, mean force, scatter, uncertainty, and the trials not kept."""
    gone = {trial.trial for trial in extraction.trials if not trial.kept}
    budgets, (known, measured) = {one.number: stated for one, stated in evidence.measured}, forces
    rows = []
    for number, item in enumerate(extraction.conditions, start=1):
        uncertainty = ("–", "–", "")
        if (stated := budgets.get(number)) is not None:
            largest = stated.lines[0]
            part = f"{largest.label} ({percent(largest.share, '.0f')})"
            uncertainty = (to_error(stated.combined, stated.combined), percent(stated.relative), part)
        cells, found = parts.condition_cells(item, slack=slack)
        not_kept = ", ".join(name for name in item.trials if name in gone)
        rows.append(
            (str(number), *cells, f"{item.n_kept} of {item.n_recorded}", *found, *uncertainty, not_kept)
        )
    headings = (
        *("no.", "R_w [mm]", "φ [deg]", f"{known} [N]", "kept", f"mean {measured} [N]", "s [N]"),
        *("u_c [N]", "u_c/mean", "largest part of u_c ", "not kept "),
    )
    note = (
        f"Mean {measured} and standard deviation s are of the trials kept. u_c is the standard uncertainty of the "
        "mean: repeats and measuring chain; a single trial has none. trials.csv lists every trial."
    )
    return Section("Conditions", headings=headings, rows=rows, left=0, notes=(note,))


def _sliding_section(extraction: result.Extraction) -> Iterator[Fold]:
    """Yield the other quantities of each condition: mean ± s of the kept trials."""
    conditions = extraction.conditions
    named = {one.name: one.heading(one.words) for one in numbers.summarised()}
    shown = [name for name in named if any(item.of_kept.get(name, _NONE)[2] for item in conditions)]
    if not shown:
        return
    rows = []
    for number, item in enumerate(conditions, start=1):
        found = [item.of_kept.get(name, _NONE) for name in shown]
        cells = (plus_minus(mean, std) if n > 1 else plain(mean) for mean, std, n in found)
        rows.append((str(number), str(max(n for *_, n in found)), *cells))
    headings = ("no.", "n", *(named[name] for name in shown))
    note = "Mean ± standard deviation of the n trials kept. trials.csv lists every trial."
    yield Fold("Other quantities of each condition", Section("", (), headings, rows, 0, (note,)))


def _decided_section(extraction: result.Extraction) -> Iterator[Section]:
    """Yield the decisions of people about single trials, if there are any, with name, date and reason."""
    rows = []
    for trial in extraction.trials:
        if trial.decision or (trial.excluded and trial.by):
            what = trial.decision or f"excluded: {trial.excluded}"
            notes = (note.partition(_WITHOUT) for note in trial.breakaway.notes)
            without = "; ".join(says for before, found, says in notes if found and not before)
            day = trial.when.partition("T")[0]
            rows.append((trial.trial, what, plain(trial.measured_N), trial.by, day, trial.why, without))
    if rows:
        headings = ("trial", "decision ", "force [N]", "by ", "date ", "reason ", "without the decision ")
        yield Section("Decisions of people", headings=headings, rows=rows, left=1)


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
    versions = parts.versions_in_words(provenance["versions"])
    notes = (provenance["command"], f"versions: {versions}", f"seeds: {seeds}")
    settings = Section(headings=("setting", "value "), rows=[*_flat(provenance["settings"])])
    lists, recordings = provenance["inputs"][:n_lists], provenance["inputs"][n_lists:]
    of_recordings = Fold(f"SHA-256 of the {counted(len(recordings), 'recording')}", _hashes(recordings))
    return (
        Section("Command that makes this report", ("Run it in the folder of the inputs.",), notes=notes),
        _hashes(lists, "Inputs"),
        *([of_recordings] if recordings else []),
        Fold("All settings in SI units, with defaults", settings),
    )


def _hashes(files: Iterable[Mapping[str, str]], title: str = "") -> Section:
    rows = [(item["path"], item["sha256"] or "could not be read") for item in files]
    return Section(title, headings=("file", "SHA-256 "), rows=rows)


def _flat(tree: Mapping[str, Any], stem: str = "") -> Iterator[tuple[str, str]]:
    """Return a tree as rows, without empty values."""
    for key, value in tree.items():
        name = f"{stem}.{key}" if stem else str(key)
        if isinstance(value, Mapping):
            yield from _flat(value, name)
        elif isinstance(value, list):
            if value:
                yield name, ", ".join(map(str, value))
        elif value is not None and value != "":
            yield name, str(value)
