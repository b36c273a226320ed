"""The commands of a campaign: its break-away forces, its whole way to a lift force, its report."""

import logging
import math
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from typer import Argument, BadParameter, Option

from ropefric.cli import on_first_use, options
from ropefric.cli.options import Answer, Force, Words, command, exit_code_of, flag, listed, out_folder
from ropefric.cli.output import Output, Progress
from ropefric.errors import RopefricError, raise_problems
from ropefric.glossary import counted

with on_first_use():
    from ropefric import executors, pipeline, plugins, section
    from ropefric.files import folder as folders
    from ropefric.friction import laws
    from ropefric.report import campaign as pages
    from ropefric.report import page, parts
    from ropefric.traces import breakaway
    from ropefric.trials import campaign as campaigns
    from ropefric.trials import campaign_model, numbers, result, workers
    from ropefric.trials import extract as extracting

if TYPE_CHECKING:
    from concurrent.futures import Executor


SERIAL_FIGURES = 8
"""Figures below which starting worker processes costs more than it saves."""
_FIGURE_FILES = ("svg", "pdf", "png")
_NAMED = 3
"""Of trials with one reason."""
# The advice for these says something about the measurement; an unreadable file has advice of its own.
_ADVISED = ("doubtful", "no-breakaway", "no-peak", "saturated", "too-short")


@command("ropefric extract data/prth-bench/campaign.toml --out out", order=50)
def extract(
    out: Output,
    campaign: options.CampaignArgument,
    *,
    folder: Path = out_folder("Where tables and figures go.", Path("out")),
    jobs: options.Jobs = "auto",
    cluster: options.Cluster = "",
    parquet: options.Parquet = False,
    figures: bool = Option(True, "--figures/--no-figures", help="Draw one figure per condition."),
    force: Force = False,
) -> Answer:
    """Find the break-away force of every recording, reject outliers, and write tables and figures.

    Writes trials.csv (a row a recording), conditions.csv (a row a condition), problems.csv and, in figures/,
    one figure per condition with the data it shows. What an earlier run wrote there and no longer fits is removed.
    """
    campaign = options.campaign_file(campaign)
    loaded = _loaded(campaign, flag_missing=True)
    n_jobs = options.parse_jobs(jobs, len(loaded.trials))
    # Before the work, so that a folder that cannot be used costs nothing.
    options.lend_fonts_a_place(folder)
    target = pipeline.campaign_folder(loaded, folder, answers=False, force=force)
    with target, ExitStack() as stack:
        with executors.cluster(cluster, n_jobs) as executor, Progress(out, "extract") as progress:
            how: dict[str, Any] = {"jobs": n_jobs, "executor": executor}
            extraction = extracting.extract_campaign(loaded, progress=progress.update, **how)
        result.write_tables(extraction, target, parquet=parquet)
        target.publish("tables")
        if figures:
            pool = drawing_pool(extraction, n_jobs, stack)
            start_figures(extraction, target, out, pool)()
    say_problems(extraction, folder, out)
    data, exit_code = extraction.to_dict(), 0
    # A campaign without a single usable force is an error, though its tables are there.
    if (error := result.no_force(extraction, campaign)) is not None:
        if not out.json:
            out.problems(error.problems)
        data, exit_code = data | error.to_dict(), error.exit_code
    return Answer(data, _sections(extraction), exit_code)


def _loaded(path: Path, *, flag_missing: bool = False) -> "campaign_model.Campaign":
    """Return a campaign; refuse one with all that is wrong: beside its files the recordings that cannot be read."""
    found, problems = campaigns.examine_campaign(path, flag_missing=flag_missing)
    if found is None or any(one.severity == "error" for one in problems):
        raise_problems((*problems, *(extracting.check_recordings(found)[1] if found else ())))
    return cast("campaign_model.Campaign", found)


def drawing_pool(extraction: "result.Extraction", n_jobs: int, stack: ExitStack) -> "Executor | None":
    """Return processes to draw the figures in, which live as long as `stack`; None where it does not pay."""
    from concurrent.futures import ProcessPoolExecutor  # noqa: PLC0415  (quick start-up)

    if n_jobs == 1 or len(extraction.conditions) < SERIAL_FIGURES:
        return None
    # Ctrl-C reaches the workers too, but only this process is to answer it; and none is to outlive it.
    executor = ProcessPoolExecutor(n_jobs, initializer=_work_quietly, initargs=(plugins.loaded(),))
    stack.callback(executor.shutdown, cancel_futures=True)
    return executor


def start_figures(
    extraction: "result.Extraction", folder: "folders.Folder", out: Output, executor: "Executor | None"
) -> Callable[[], None]:
    """Begin to draw one figure per condition; return what waits for them, writes and publishes them."""
    from ropefric.plotting.campaign import start_condition_figures  # noqa: PLC0415  (its package loads matplotlib)

    write = start_condition_figures(extraction, folder, under="figures/", executor=executor)

    def finish() -> None:
        with Progress(out, "figures") as progress:
            write(progress.update)
        folder.publish("figures")

    return finish


def _work_quietly(_plugins: object) -> None:
    workers.become_expendable()
    # What matplotlib tells of its fonts and folders is for no reader of ours.
    logging.getLogger().addHandler(logging.NullHandler())


def say_problems(extraction: "result.Extraction", folder: Path, out: Output) -> None:
    """Say what was wrong or doubtful beside the recordings that the summary lists, and what became of the trials."""
    found = result.problems_by_code(extraction, said_of=_without_force(extraction)).values()
    out.problems(chain.from_iterable(found), rest="problems.csv lists all")
    trials = extraction.trials
    n_recordings = len({(trial.file, trial.sample) for trial in trials})
    what = counted(len(trials), "trial")
    if n_recordings != len(trials):
        what += f" in {counted(n_recordings, 'recording')}"
    counts = result.outcome_words(result.count_trials(extraction))
    out.note(f"{what}: {counts} → {folder / 'problems.csv'}")


def _sections(extraction: "result.Extraction") -> "list[section.Section]":
    """Return a row a condition, then the recordings without a usable force and what to do about them."""
    slack = any(trial.measures_slack for trial in extraction.trials)
    known, measured = ("F_A", "F_B") if slack else ("F_B", "F_A")
    brief = [column for column in numbers.summarised() if column.brief]
    headings = (
        *("R_w [mm]", "φ [deg]", f"{known} [N]", "trials", "kept", f"mean {measured} [N]", "s [N]"),
        *(column.heading(column.brief) for column in brief),
        "rejected ",
    )
    rows = []
    for one in extraction.conditions:
        settings, forces = parts.condition_cells(one, slack=slack)
        beside = [section.plain(one.of_kept.get(column.name, (math.nan,))[0]) for column in brief]
        kept = str(one.n_recorded), str(one.n_kept)
        rows.append((*settings, *kept, *forces, *beside, ", ".join(one.rejected)))
    told = [section.Section(headings=headings, rows=rows, left=0)]
    if flagged := _without_force(extraction):
        statuses = dict.fromkeys(trial.breakaway.status for trial in flagged)
        said = f"{len(flagged)} of {len(extraction.trials)} trials are without a force:"
        reasons = [*map(_flagged_row, result.alike(flagged))]
        advice = [f"{one}: {breakaway.ADVICE[one]}" for one in statuses if one in _ADVISED]
        told.append(section.Section("", (said,), ("trial", "status", "why "), reasons, left=3))
        told.append(section.Section(lines=advice))
    return told


def _without_force(extraction: "result.Extraction") -> "list[result.TrialResult]":
    """Return the trials without a usable force, first those that a person can decide."""
    found = [trial for trial in extraction.trials if trial.outcome == "without a force"]
    return sorted(found, key=lambda trial: trial.breakaway.status != "doubtful")


def _flagged_row(group: "Sequence[result.TrialResult]") -> tuple[str, str, str]:
    """Return a row for trials that have one reason."""
    trial, names = group[0], ", ".join(one.trial for one in group[:_NAMED])
    if len(group) > _NAMED:
        names += f", … ({len(group)} trials)"
    advised = trial.breakaway.status in _ADVISED
    fixes = [] if advised else [problem.fix for problem in trial.problems if problem.fix]
    return names, str(trial.breakaway.status), "; ".join([trial.why_no_force, *fixes])


@command("ropefric run data/prth-bench/campaign.toml --out out", order=60)
def run(
    out: Output,
    campaign: options.CampaignArgument,
    *,
    folder: Path = out_folder("Where everything is written.", Path("out")),
    law: str = Option("", help="Use this law, whichever wins."),
    jobs: options.Jobs = "auto",
    cluster: options.Cluster = "",
    parquet: options.Parquet = False,
    figures: bool = Option(
        True, "--figures/--no-figures", help="Draw figures: one per condition, and those of the report."
    ),
    force: Force = False,
) -> Answer:
    """Do everything: extract the forces, reject outliers, fit and compare all laws, predict the campaign's wheel.

    Writes report.html, summary.txt, trials.csv, conditions.csv, problems.csv, figures/, fits/ (a file a law),
    comparison.csv, prediction.json, uncertainty.json, next_tests.csv and manifest.json. What an earlier run wrote
    there and no longer fits is removed. Exits with 4 unless the law and its lift force are supported: when the data
    leave two of them undecided, or judge none.
    """
    loaded, wish = _loaded(options.campaign_file(campaign)), page.Wish(figures=figures)
    how: dict[str, Any] = {"law": law, "cluster": cluster, "parquet": parquet, "force": force}
    return work_through(out, loaded, folder, wish, jobs=jobs, of_conditions=figures, **how)


def work_through(
    out: Output,
    campaign: "campaign_model.Campaign",
    folder: Path,
    wish: "page.Wish",
    *,
    law: str = "",
    jobs: str,
    cluster: str = "",
    parquet: bool = False,
    of_conditions: bool = False,
    force: bool = False,
) -> Answer:
    """Return the answer to a campaign, and write everything into a folder; figures `of_conditions`, too.

    `law` is the one to use, "" for the best.
    """
    # Before the work, so that a law that is not known and a folder that cannot be used cost nothing.
    if law:
        laws.ALL_LAWS[law]
    n_jobs = options.parse_jobs(jobs, len(campaign.trials))
    options.lend_fonts_a_place(folder)
    target = pipeline.campaign_folder(campaign, folder, force=force)

    to_finish: list[Callable[[], None]] = []
    pool: list[Executor | None] = [None]

    def draw(extraction: "result.Extraction") -> None:
        say_problems(extraction, folder, out)
        if of_conditions:
            # Other processes draw while this one fits; what is published is one part at a time.
            pool[0] = drawing_pool(extraction, n_jobs, stack)
            to_finish.append(start_figures(extraction, target, out, pool[0]))

    with target, ExitStack() as stack:
        try:
            with (
                executors.cluster(cluster, n_jobs) as executor,
                Progress(out, "extract") as extracting,
                Progress(out, "fit") as fitting,
            ):
                how: dict[str, Any] = {"law": law, "jobs": n_jobs, "parquet": parquet}
                how |= {"extract_progress": extracting.update, "fit_progress": fitting.update_named}
                done = pipeline.run_campaign(campaign, target, executor=executor, on_extracted=draw, **how)
        except RopefricError:
            for finish in to_finish:
                finish()
            raise
        with Progress(out, "report") as reporting:
            written = pages.write_report(done, target, wish, executor=pool[0], progress=reporting.update)
        target.publish("answer")
        for finish in to_finish:
            finish()
    said = options.written_to(folder, "report.html, trials.csv, fits/, comparison.csv, …")
    data = done.to_dict() | {"written": [*done.written, *written]}
    return Answer(data, [*pages.summary_sections(done), said], exit_code_of(done.answer.verdict))


@command("ropefric report out --pdf", order=70)
def report(
    out: Output,
    source: Path = Argument(
        ...,
        metavar="OUT_DIR|CAMPAIGN.toml|TRIALS.csv",
        help="A folder that `run` wrote; a campaign, its file or its folder; or a table of forces, as .csv or .xlsx.",
    ),
    *,
    folder: Path | None = out_folder("Of a campaign or a table: where its results are to be [out]."),
    law: str = Option("", help="Use this law, whichever wins; by default as in the run before."),
    short: bool = flag(
        "--short", "The first two pages alone: answer, law, a typical recording, remarks, limits."
    ),
    pdf: bool = flag("--pdf", "Print it as report.pdf too; needs Chromium, Chrome or Edge."),
    figure_files: Words = listed("svg|pdf|png", "Write the report's figures as such files too"),
    about: Path | None = Option(
        None, metavar="FILE.toml", help="Of a table: a file with [design] and [report], as in a campaign."
    ),
    jobs: options.Jobs = "auto",
    figures: bool = Option(True, "--figures/--no-figures", help="Draw the figures of the report."),
    force: Force = False,
) -> Answer:
    """Make report.html again, from the recordings on; or make one of a table of forces.

    The tables, fits and numbers beside it are brought up to date with it; pictures of single conditions are left as
    they are, and removed if the forces have changed. Exits with 4 unless the law and its lift force are supported.
    """
    formats = tuple(name.strip() for text in figure_files or () for name in text.split(","))
    if unknown := [word for word in formats if word not in _FIGURE_FILES]:
        raise BadParameter(
            f"{unknown[0]!r} is none of {', '.join(_FIGURE_FILES)}", param_hint="--figure-files"
        )
    wish = page.Wish(pdf, figures, formats, short)
    if pdf:
        page.find_browser()  # before the work
    if source.suffix.lower() in options.TABLES and not source.is_dir():
        inputs = [source, about] if about else [source]
        target = pipeline.table_folder(inputs, folder or Path("out"), force=force)
        return _report_table(out, inputs, target, law, wish)
    if about is not None:
        raise BadParameter("a campaign has a [report] of its own", param_hint="--about")
    campaign, folder, law = _to_report(source, folder, law)
    return work_through(out, campaigns.load_campaign(campaign), folder, wish, law=law, jobs=jobs, force=force)


def _to_report(source: Path, folder: Path | None, law: str) -> tuple[Path, Path, str]:
    """Return the campaign that is named, or whose results are; their folder; the law, by default that of before."""
    if source.is_dir() and not (source / "campaign.toml").is_file():
        if folder is not None:
            raise BadParameter("a folder of results is written to itself", param_hint="--out")
        campaign, law_before = pipeline.recorded_run(source)
        return campaign, source, law or law_before
    campaign, folder = options.campaign_file(source), folder or Path("out")
    if law or not (folder / pipeline.MANIFEST).is_file():
        return campaign, folder, law
    before, law = pipeline.recorded_run(folder)
    return campaign, folder, law if before.resolve() == campaign.resolve() else ""


def _report_table(
    out: Output, inputs: Sequence[Path], target: "folders.OutputFolder", law: str, wish: "page.Wish"
) -> Answer:
    """Answer a table of forces, and write its report into a folder."""
    if law:
        laws.ALL_LAWS[law]
    about = campaigns.load_about(inputs[1]) if len(inputs) > 1 else campaign_model.AboutTable()
    table = options.read_table(inputs[0], out)
    options.lend_fonts_a_place(target.path)
    with target:
        with Progress(out, "fit") as fitting, Progress(out, "report") as reporting:
            answer = pipeline.answer_trials(
                table, design=about.design, law=law, progress=fitting.update_named
            )
            written = pipeline.write_answer(answer, target)
            told: dict[str, Any] = {"words": about.report, "wish": wish, "progress": reporting.update}
            written += pages.write_table_report(answer, inputs, target, **told)
        target.publish("answer")
    said = options.written_to(target.path, "report.html, fits/, comparison.csv, …")
    data = answer.to_dict() | {"written": [*written]}
    return Answer(data, [*pages.answer_sections(answer), said], exit_code_of(answer.verdict))
