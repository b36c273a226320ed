"""`ropefric cost`: error and time of every numerical choice, measured here and now."""

from dataclasses import asdict
from pathlib import Path

from typer import Argument, Option

from ropefric.cli.options import Answer, Force, command, folder_option, open_folder, written_to
from ropefric.cli.output import Output, Progress


@command("ropefric cost integral --out cost --quick", order=180)
def cost(
    out: Output,
    studies: list[str] | None = Argument(
        None, metavar="[STUDY …]", help="Studies to measure, all by default."
    ),
    *,
    folder: Path = folder_option(
        Path("cost"), "--out", "-o", help="Where figures, tables and page are written."
    ),
    campaign: list[Path] | None = Option(
        None, "--campaign", help="For picks: a campaign with truth.toml; repeatable."
    ),
    quick: bool = Option(False, "--quick", help="Some settings only, and little time for each."),
    force: Force = False,
) -> Answer:
    """Measure what accuracy costs in time on this machine.

    Of the lift-force integral, the end tension's root, break-away peaks and their pickers, intervals, fits, press, blade
    and scenes.

    For every study it writes NAME.csv, NAME.png (time over error, the best settings marked), and for all of them
    cost.md and cost.html with the cheapest method for each accuracy from 1e-2 to 1e-12.
    """
    from ropefric.accuracy.measure import measure_studies, this_machine  # noqa: PLC0415  (quick start-up)
    from ropefric.accuracy.studies import STUDIES  # noqa: PLC0415
    from ropefric.accuracy.studies.picks import with_campaigns  # noqa: PLC0415
    from ropefric.report.cost_page import cost_sections, write_cost  # noqa: PLC0415

    chosen = [STUDIES[name] for name in dict.fromkeys(studies or STUDIES)]
    if campaign:
        chosen = [with_campaigns(study, campaign) if study.name == "picks" else study for study in chosen]
    pairs = [f"{study.name}.{ending}" for study in chosen for ending in ("png", "csv")]
    # Before the work, so that a folder that cannot be used costs nothing.
    with open_folder(folder, family="cost", names=["cost.md", "cost.html", *pairs], force=force) as target:
        machine = this_machine()
        out.note(f"measuring on {machine.line}")
        with Progress(out, "cost") as progress:
            results = measure_studies(chosen, quick=quick, progress=progress.update)
        written = write_cost(results, machine, target)
    data = {
        "machine": asdict(machine),
        "quick": quick,
        "studies": [result.to_dict() for result in results],
        "written": list(written),
    }
    said = written_to(folder, "cost.html, cost.md, …")
    return Answer(data, [*cost_sections(results, machine), said])
