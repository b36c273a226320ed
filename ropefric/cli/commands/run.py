"""`ropefric run`: a campaign's whole way, from recordings to the lift force of a wheel."""

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from typer import Option

from ropefric.cli.commands.extract import say_problems, start_figures, what_was_kept
from ropefric.cli.options import (
    Answer,
    Cache,
    CampaignArgument,
    Command,
    Force,
    Jobs,
    campaign_file,
    exit_code_of,
    folder_option,
    lend_fonts_a_place,
    parse_jobs,
    written_to,
)
from ropefric.cli.output import Output, Progress
from ropefric.errors import RopefricError

if TYPE_CHECKING:
    from ropefric.trials.campaign_model import Campaign
    from ropefric.trials.result import Extraction


def run(
    out: Output,
    campaign: CampaignArgument,
    *,
    folder: Path = folder_option(Path("out"), "--out", "-o", help="Where everything is written."),
    law: str = Option("", help="Use this law, whichever wins."),
    jobs: Jobs = "auto",
    figures: bool = Option(
        True, "--figures/--no-figures", help="Draw figures: one per condition, and those of the report."
    ),
    cache: Cache = True,
    force: Force = False,
) -> Answer:
    """Do everything: extract the forces, reject outliers, fit and compare all laws, predict the campaign's wheel.

    Writes report.html, summary.txt, trials.csv, conditions.csv, problems.csv, figures/, fits/ (a file a law),
    comparison.csv, prediction.json, uncertainty.json, next_tests.csv and manifest.json. What an earlier run wrote
    there and no longer fits is removed. Exits with 4 unless the law and its lift force are supported: when the data
    leave two of them undecided, or judge none.
    """
    from ropefric.trials.campaign import load_campaign  # noqa: PLC0415  (quick start-up)

    loaded = load_campaign(campaign_file(campaign))
    n_jobs = parse_jobs(jobs, len(loaded.trials))
    drawing = frozenset({"conditions", "report"}) if figures else frozenset()
    return work_through(
        out, loaded, folder, law=law, n_jobs=n_jobs, cache=cache, drawing=drawing, force=force
    )


def work_through(
    out: Output,
    campaign: "Campaign",
    folder: Path,
    *,
    law: str = "",
    n_jobs: int = 1,
    cache: bool = True,
    drawing: frozenset[str] = frozenset({"report"}),
    force: bool = False,
) -> Answer:
    """Return the answer to a campaign, and write everything into a folder.

    `law` is the one to use, "" for the best; `drawing` names the figures: those of the "report", those of "conditions".
    """
    from ropefric.friction.laws import ALL_LAWS  # noqa: PLC0415  (all of these: quick start-up)
    from ropefric.pipeline.run import campaign_folder, run_campaign  # noqa: PLC0415
    from ropefric.report.campaign import summary_sections, write_report  # noqa: PLC0415

    # Before the work, so that a law that is not known and a folder that cannot be used cost nothing.
    if law:
        ALL_LAWS[law]
    cache_dir = folder / ".cache" if cache else None
    lend_fonts_a_place(folder)
    target = campaign_folder(campaign, folder, force=force)

    to_finish: list[Callable[[], None]] = []

    def draw(extraction: "Extraction") -> None:
        say_problems(extraction, folder, out)
        if "conditions" in drawing:
            # Other processes draw while this one fits; what is published is one part at a time.
            to_finish.append(start_figures(extraction, target, n_jobs, out, stack))

    try:
        with target, ExitStack() as stack:
            try:
                with Progress(out, "extract") as extracting, Progress(out, "fit") as fitting:
                    result = run_campaign(
                        campaign,
                        target,
                        law=law,
                        jobs=n_jobs,
                        cache_dir=cache_dir,
                        extract_progress=extracting.update,
                        fit_progress=lambda name, done, total: fitting.update(done, total, name),
                        on_extracted=draw,
                    )
            except RopefricError:
                for finish in to_finish:
                    finish()
                raise
            with Progress(out, "report") as reporting:
                pages = write_report(result, target, figures="report" in drawing, progress=reporting.update)
            target.publish("answer")
            for finish in to_finish:
                finish()
    except KeyboardInterrupt:
        out.note(what_was_kept(cache_dir))
        raise
    said = written_to(folder, "report.html, trials.csv, fits/, comparison.csv, …")
    return Answer(
        result.to_dict() | {"written": [*result.written, *pages]},
        [*summary_sections(result), said],
        exit_code_of(result.answer.verdict),
    )


COMMAND = Command("run", run, "ropefric run data/prth-bench/campaign.toml --out out", order=60)
