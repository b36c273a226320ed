"""`ropefric run`: a campaign's whole way, from recordings to the lift force of a wheel."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ropefric.cli.campaign_file import CampaignArgument, campaign_file, what_was_kept
from ropefric.cli.command import Answer, Command
from ropefric.cli.figures import draw_figures
from ropefric.cli.fitting_options import exit_code_of, show_sections
from ropefric.cli.jobs import parse_jobs
from ropefric.cli.out_folder import Force, folder_option, open_campaign_folder
from ropefric.cli.output import Output
from ropefric.cli.progress import Progress
from ropefric.cli.summary import end_line, other_problems

if TYPE_CHECKING:
    from rich.console import Console

    from ropefric.pipeline.run import CampaignRun
    from ropefric.trials.campaign_model import Campaign
    from ropefric.trials.result import Extraction


OutFolder = Annotated[Path, folder_option("--out", "-o", help="Where everything is written.")]
Law = Annotated[str, typer.Option(help="Use this law, whichever wins.")]
Jobs = Annotated[
    str, typer.Option(metavar="auto|N", help="Processes, at most the cores; auto: one for a small campaign.")
]
Figures = Annotated[
    bool,
    typer.Option("--figures/--no-figures", help="Draw figures: one per condition, and those of the report."),
]
Cache = Annotated[bool, typer.Option("--cache/--no-cache", help="Skip recordings that have not changed.")]


def run(
    out: Output,
    campaign: CampaignArgument,
    *,
    folder: OutFolder = Path("out"),
    law: Law = "",
    jobs: Jobs = "auto",
    figures: Figures = True,
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

    Parameters
    ----------
    out : Output
        Where progress is told.
    campaign : Campaign
        From `load_campaign`.
    folder : Path
        Where to write.
    law : str
        The law to use; "" for the best.
    n_jobs : int
        Processes.
    cache : bool
        Whether recordings that have not changed are skipped.
    drawing : frozenset of str
        Which figures are drawn: those of the "report", and one of each of the "conditions".
    force : bool
        Replace files that ropefric did not write.
    """
    from ropefric.pipeline.run import run_campaign  # noqa: PLC0415  (all of these: quick start-up)
    from ropefric.report.write import write_report  # noqa: PLC0415

    # Before the work, so that a law that is not known and a folder that cannot be used cost nothing.
    _check_law(law)
    cache_dir = folder / ".cache" if cache else None
    target = open_campaign_folder(campaign, folder, force=force)

    def draw(extraction: "Extraction") -> None:
        out.problems(other_problems(extraction))
        out.note(end_line(extraction, folder / "problems.csv"))
        if "conditions" in drawing:
            draw_figures(extraction, target, n_jobs, out)

    try:
        with target:
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
            with Progress(out, "report") as reporting:
                pages = write_report(result, target, figures="report" in drawing, progress=reporting.update)
            target.publish("answer")
    except KeyboardInterrupt:
        out.note(what_was_kept(cache_dir))
        raise
    return Answer(
        data=result.to_dict() | {"written": [*result.written, *pages]},
        show=lambda console: _show(result, folder, console),
        exit_code=exit_code_of(result.answer.verdict),
    )


def _check_law(law: str) -> None:
    from ropefric.friction.laws import ALL_LAWS  # noqa: PLC0415  (quick start-up)

    if law:
        ALL_LAWS[law]


def _show(result: "CampaignRun", folder: Path, console: "Console") -> None:
    from ropefric.report.summary import summary_sections  # noqa: PLC0415  (quick start-up)

    show_sections(summary_sections(result), console)
    console.print(f"\nwritten to {folder}: report.html, trials.csv, fits/, comparison.csv, …", markup=False,
                  soft_wrap=True)  # fmt: skip


COMMAND = Command(
    name="run", run=run, example="ropefric run data/prth-bench/campaign.toml --out out", order=60
)
