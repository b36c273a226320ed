"""The folder that a command writes into: the options that name it, and how it is opened."""

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ropefric.errors import RopefricError

if TYPE_CHECKING:
    from ropefric.files.folder import OutputFolder
    from ropefric.trials.campaign_model import Campaign


Force = Annotated[bool, typer.Option("--force", help="Replace files there that ropefric did not write.")]


def folder_option(*names: str, help: str) -> Any:  # noqa: A002  (as typer calls it)
    """Return an option that names a folder; an empty name, such as an unset variable gives, is none."""
    return typer.Option(*names, parser=_folder_named, metavar="FOLDER", help=help)


def _folder_named(text: str) -> Path:
    if not str(text):
        raise RopefricError(
            "the folder has no name", code="RF110", key="--out", fix='write "." for this folder'
        )
    return Path(text)


def open_folder(
    path: Path, *, family: str, names: Iterable[str], inputs: Iterable[Path] = (), force: bool
) -> "OutputFolder":
    """Return a command's folder, to be used as a context; see `OutputFolder`."""
    from ropefric.files.folder import OutputFolder  # noqa: PLC0415  (quick start-up)

    _lend_a_place(path)
    return OutputFolder(path, family=family, names=names, inputs=inputs, force=force)


def open_campaign_folder(
    campaign: "Campaign", path: Path, *, answers: bool = True, force: bool
) -> "OutputFolder":
    """Return the folder of a campaign's results, to be used as a context; see `campaign_folder`."""
    from ropefric.pipeline.run import campaign_folder  # noqa: PLC0415  (quick start-up)

    _lend_a_place(path)
    return campaign_folder(campaign, path, answers=answers, force=force)


def figure_names(*stems: str) -> tuple[str, ...]:
    """Return the files that figures may be written to: pictures, and tables with endings of their own."""
    return tuple(f"{stem}{end}" for stem in stems for end in (".png", ".csv", "_*.csv"))


def _lend_a_place(folder: Path) -> None:
    """Let matplotlib keep its list of fonts with the results where the machine has no place for such things."""
    import tempfile  # noqa: PLC0415  (these: quick start-up)

    from ropefric.files.folder import CACHE  # noqa: PLC0415

    try:
        tempfile.gettempdir()
    except OSError:
        wished = os.environ.get("MPLCONFIGDIR")
        if not wished or not os.access(wished, os.W_OK):
            os.environ["MPLCONFIGDIR"] = str((folder / CACHE / "matplotlib").absolute())
