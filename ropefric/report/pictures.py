"""The figures of a report, drawn for the inside of the page, each with its numbers as CSV beside the page."""

from collections.abc import Callable

from ropefric.files.folder import Folder
from ropefric.pipeline.evidence import Evidence
from ropefric.pipeline.run import CampaignRun
from ropefric.plotting.figure import save_figure
from ropefric.plotting.svg import svg_text
from ropefric.report.chapter import Picture
from ropefric.report.drawings import Drawing, design_drawings, law_drawings, trial_drawings

Pictures = dict[str, tuple[Picture, ...]]
"""Pictures by the chapter they belong to, in order."""

FOLDER = "figures"
"""Where the numbers of the figures are written, beside the page."""


def draw_pictures(
    run: CampaignRun,
    evidence: Evidence,
    folder: Folder,
    *,
    progress: Callable[[int, int, str], None] | None = None,
) -> Pictures:
    """Return the figures of a report, and write the CSV files of their numbers under `figures` in a folder."""
    drawings = [*trial_drawings(run.extraction), *law_drawings(run.answer), *design_drawings(evidence)]
    found: dict[str, list[Picture]] = {}
    for done, drawing in enumerate(drawings, start=1):
        found.setdefault(drawing.chapter, []).append(_picture(drawing, folder))
        if progress is not None:
            progress(done, len(drawings), drawing.stem)
    return {chapter: tuple(pictures) for chapter, pictures in found.items()}


def _picture(drawing: Drawing, folder: Folder) -> Picture:
    drawn = drawing.draw()
    paths = save_figure(drawn, folder, f"{FOLDER}/{drawing.stem}", formats=())
    return Picture(
        stem=drawing.stem,
        svg=svg_text(drawn, stem=drawing.stem),
        caption=drawing.caption,
        files=tuple(f"{FOLDER}/{path.name}" for path in paths),
    )
