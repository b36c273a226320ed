"""`ropefric report`: the report of a campaign made again, from its folder of results or from the campaign."""

from pathlib import Path

from typer import Argument, BadParameter, Option

from ropefric.cli.commands.run import work_through
from ropefric.cli.options import Answer, Command, Force, Jobs, campaign_file, folder_option, parse_jobs
from ropefric.cli.output import Output


def report(
    out: Output,
    source: Path = Argument(
        ...,
        metavar="OUT_DIR|CAMPAIGN.toml",
        help="A folder that `run` wrote, or a campaign: its file or its folder.",
    ),
    *,
    folder: Path | None = folder_option(
        None, "--out", "-o", help="Of a campaign: where its results are, or are to be written [out]."
    ),
    law: str = Option("", help="Use this law, whichever wins; by default as in the run before."),
    jobs: Jobs = "auto",
    figures: bool = Option(True, "--figures/--no-figures", help="Draw the figures of the report."),
    force: Force = False,
) -> Answer:
    """Make report.html again, without extracting again what the cache holds.

    The tables, fits and numbers beside it are brought up to date with it; pictures of single conditions are left as
    they are, and removed if the forces have changed. Exits with 4 unless the law and its lift force are supported.
    """
    from ropefric.pipeline.provenance import MANIFEST, recorded_run  # noqa: PLC0415  (all of these: quick start-up)
    from ropefric.trials.campaign import load_campaign  # noqa: PLC0415

    if source.is_dir() and not (source / "campaign.toml").is_file():
        if folder is not None:
            raise BadParameter("a folder of results is written to itself", param_hint="--out")
        folder, (campaign, law_before) = source, recorded_run(source)
        law = law or law_before
    else:
        campaign = campaign_file(source)
        folder = folder or Path("out")
        if not law and (folder / MANIFEST).is_file():
            before, law_before = recorded_run(folder)
            law = law_before if before.resolve() == campaign.resolve() else ""
    loaded = load_campaign(campaign)
    n_jobs = parse_jobs(jobs, len(loaded.trials))
    drawing = frozenset({"report"} if figures else ())
    return work_through(out, loaded, folder, law=law, n_jobs=n_jobs, drawing=drawing, force=force)


COMMAND = Command("report", report, "ropefric report out", order=70)
