"""A campaign's result as files for people: summary.txt and report.html."""

from collections.abc import Callable
from pathlib import Path

from ropefric.pipeline.evidence import gather_evidence, write_evidence
from ropefric.pipeline.provenance import trace_provenance, write_manifest
from ropefric.pipeline.run import CampaignRun
from ropefric.report.campaign_report import campaign_report
from ropefric.report.pictures import draw_pictures
from ropefric.report.render import as_html
from ropefric.report.summary import summary_text

__all__ = ["REPORT", "write_report"]

REPORT = "report.html"

Progress = Callable[[int, int, str], None]


def write_report(
    run: CampaignRun, folder: Path, *, figures: bool = True, progress: Progress | None = None
) -> tuple[Path, ...]:
    """Write summary.txt, report.html with the numbers of its figures, and what they rest on; return the paths.

    The page needs nothing else. Beside it stand figures/*.csv, uncertainty.json and next_tests.csv where there is a
    design, and manifest.json. The same campaign gives the same bytes.

    Parameters
    ----------
    run : CampaignRun
        The result.
    folder : Path
        Where it was written.
    figures : bool
        Whether to draw figures, which takes most of the time.
    progress : callable, optional
        Called with done, total and the name of the figure just finished.
    """
    evidence = gather_evidence(run)
    provenance = trace_provenance(run, evidence)
    pictures = draw_pictures(run, evidence, folder, progress=progress) if figures else {}
    numbers = [
        folder / name for chapter in pictures.values() for picture in chapter for name in picture.files
    ]
    written = [
        *numbers,
        *write_evidence(evidence, folder),
        write_manifest(provenance, run.campaign.path, folder),
    ]
    page = as_html(campaign_report(run, evidence, provenance, pictures))
    for name, text in (("summary.txt", summary_text(run)), (REPORT, page)):
        written.append(folder / name)
        written[-1].write_text(text, encoding="utf-8", newline="\n")
    return tuple(written)
