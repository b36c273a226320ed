"""Drawing the figures of a campaign, in several processes where that pays."""

from contextlib import ExitStack
from typing import TYPE_CHECKING

from ropefric.cli.output import Output
from ropefric.cli.progress import Progress

if TYPE_CHECKING:
    from ropefric.files.folder import Folder
    from ropefric.trials.result import Extraction


SERIAL_FIGURES = 8
"""Figures below which starting worker processes costs more than it saves."""


def draw_figures(extraction: "Extraction", folder: "Folder", n_jobs: int, out: Output) -> None:
    """Draw one figure per condition into figures/ of a folder and publish them, telling how far it is."""
    from concurrent.futures import ProcessPoolExecutor  # noqa: PLC0415  (these: quick start-up)

    from ropefric.plotting.conditions import write_condition_figures  # noqa: PLC0415

    with Progress(out, "figures") as progress, ExitStack() as stack:
        executor = None
        if n_jobs > 1 and len(extraction.conditions) >= SERIAL_FIGURES:
            # Ctrl-C reaches the workers too, but only this process is to answer it; and none is to outlive it.
            executor = ProcessPoolExecutor(n_jobs, initializer=_work_quietly)
            stack.callback(executor.shutdown, cancel_futures=True)
        write_condition_figures(
            extraction, folder, under="figures/", executor=executor, progress=progress.update
        )
    folder.publish("figures")


def _work_quietly() -> None:
    import logging  # noqa: PLC0415  (these: quick start-up)

    from ropefric.trials.workers import become_expendable  # noqa: PLC0415

    become_expendable()
    # What matplotlib tells of its fonts and folders is for no reader of ours.
    logging.getLogger().addHandler(logging.NullHandler())
