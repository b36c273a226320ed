"""Drawing the figures of a campaign, in several processes where that pays."""

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from ropefric.cli.output import Output
from ropefric.cli.progress import Progress

if TYPE_CHECKING:
    from ropefric.trials.result import Extraction

__all__ = ["SERIAL_FIGURES", "draw_figures"]

SERIAL_FIGURES = 8
"""Figures below which starting worker processes costs more than it saves."""


def draw_figures(extraction: "Extraction", folder: Path, n_jobs: int, out: Output) -> None:
    """Draw one figure per condition into a folder, telling how far it is.

    Parameters
    ----------
    extraction : Extraction
        What to draw.
    folder : Path
        Made where it is missing.
    n_jobs : int
        Number of processes.
    out : Output
        Where progress is told.
    """
    from concurrent.futures import ProcessPoolExecutor  # noqa: PLC0415  (these: quick start-up)

    from ropefric.plotting.campaign import write_condition_figures  # noqa: PLC0415
    from ropefric.trials.workers import become_expendable  # noqa: PLC0415

    with Progress(out, "figures") as progress, ExitStack() as stack:
        executor = None
        if n_jobs > 1 and len(extraction.conditions) >= SERIAL_FIGURES:
            # Ctrl-C reaches the workers too, but only this process is to answer it; and none is to outlive it.
            executor = ProcessPoolExecutor(n_jobs, initializer=become_expendable)
            stack.callback(executor.shutdown, cancel_futures=True)
        write_condition_figures(extraction, folder, executor=executor, progress=progress.update)
