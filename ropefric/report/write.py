"""A campaign's result as files for people: summary.txt and report.html."""

import os
from collections.abc import Callable
from pathlib import Path

from ropefric.files.folder import Folder, as_folder
from ropefric.pipeline.evidence import evidence_files, gather_evidence
from ropefric.pipeline.provenance import MANIFEST, manifest_text, trace_provenance
from ropefric.pipeline.run import CampaignRun
from ropefric.report.campaign_report import campaign_report
from ropefric.report.pictures import draw_pictures
from ropefric.report.render import as_html
from ropefric.report.summary import summary_text

REPORT = "report.html"

Progress = Callable[[int, int, str], None]


def write_report(
    run: CampaignRun,
    folder: Folder | str | os.PathLike[str],
    *,
    figures: bool = True,
    progress: Progress | None = None,
) -> tuple[Path, ...]:
    """Write summary.txt, report.html with the numbers of its figures, and what they rest on; return the paths.

    The page needs nothing else. Beside it stand figures/*.csv, uncertainty.json and next_tests.csv where there is a
    design, and manifest.json. The same campaign gives the same bytes.
    """
    target = as_folder(folder)
    evidence = gather_evidence(run)
    provenance = trace_provenance(run, evidence)
    pictures = draw_pictures(run, evidence, target, progress=progress) if figures else {}
    numbers = [
        target.path / name for chapter in pictures.values() for picture in chapter for name in picture.files
    ]
    texts = evidence_files(evidence) | {
        MANIFEST: manifest_text(provenance, run.campaign.path, target.path),
        "summary.txt": summary_text(run),
        REPORT: as_html(campaign_report(run, evidence, provenance, pictures)),
    }
    return (*numbers, *target.write(texts))
