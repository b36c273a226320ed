"""`ropefric extract`: every recording of a campaign -> break-away forces, tables and figures."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ropefric.cli.campaign_file import CampaignArgument, campaign_file, what_was_kept
from ropefric.cli.command import Answer, Command
from ropefric.cli.figures import draw_figures
from ropefric.cli.jobs import parse_jobs
from ropefric.cli.out_folder import Force, folder_option, open_campaign_folder
from ropefric.cli.output import Output
from ropefric.cli.progress import Progress
from ropefric.cli.summary import end_line, other_problems, show_extraction
from ropefric.errors import DataError
from ropefric.traces.breakaway import Status

if TYPE_CHECKING:
    from ropefric.trials.result import Extraction


OutFolder = Annotated[Path, folder_option("--out", "-o", help="Where tables and figures go.")]
Jobs = Annotated[
    str, typer.Option(metavar="auto|N", help="Processes, at most the cores; auto: one for a small campaign.")
]
Figures = Annotated[bool, typer.Option("--figures/--no-figures", help="Draw one figure per condition.")]
Cache = Annotated[bool, typer.Option("--cache/--no-cache", help="Skip recordings that have not changed.")]


def extract(
    out: Output,
    campaign: CampaignArgument,
    *,
    folder: OutFolder = Path("out"),
    jobs: Jobs = "auto",
    figures: Figures = True,
    cache: Cache = True,
    force: Force = False,
) -> Answer:
    """Find the break-away force of every recording, reject outliers, and write tables and figures.

    Writes trials.csv (a row a recording), conditions.csv (a row a condition), problems.csv and, in figures/,
    one figure per condition with the data it shows. What an earlier run wrote there and no longer fits is removed.
    """
    from ropefric.trials.campaign import load_campaign  # noqa: PLC0415  (all of these: quick start-up)
    from ropefric.trials.extract import extract_campaign  # noqa: PLC0415
    from ropefric.trials.result import write_tables  # noqa: PLC0415

    campaign = campaign_file(campaign)
    loaded = load_campaign(campaign, missing_recordings="flag")
    n_jobs = parse_jobs(jobs, len(loaded.trials))
    cache_folder = folder / ".cache" if cache else None
    # Before the work, so that a folder that cannot be used costs nothing.
    target = open_campaign_folder(loaded, folder, answers=False, force=force)
    try:
        with target:
            with Progress(out, "extract") as progress:
                extraction = extract_campaign(
                    loaded, jobs=n_jobs, cache_dir=cache_folder, progress=progress.update
                )
            write_tables(extraction, target)
            target.publish("tables")
            if figures:
                draw_figures(extraction, target, n_jobs, out)
    except KeyboardInterrupt:
        out.note(what_was_kept(cache_folder))
        raise
    out.problems(other_problems(extraction))
    out.note(end_line(extraction, folder / "problems.csv"))
    return _verdict(extraction, campaign, out)


def _verdict(extraction: "Extraction", campaign: Path, out: Output) -> Answer:
    """Return the answer; a campaign without a single usable force is an error, though its tables are there."""
    data = extraction.to_dict()
    exit_code = 0
    if not any(trial.breakaway.status == Status.OK for trial in extraction.trials):
        error = DataError(
            f"none of the {len(extraction.trials)} recordings gave a usable force",
            code="RF301",
            path=campaign,
            fix="problems.csv says why for each; `ropefric inspect FILE` shows what a file holds",
        )
        if not out.json:
            out.problems(error.problems)
        data |= error.to_dict()
        exit_code = error.exit_code
    return Answer(data=data, show=lambda console: show_extraction(extraction, console), exit_code=exit_code)


COMMAND = Command(
    name="extract", run=extract, example="ropefric extract data/prth-bench/campaign.toml --out out", order=50
)
