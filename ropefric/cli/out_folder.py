"""The folder that a command writes into: the options that name it, and what may not be written over."""

import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ropefric.errors import RopefricError

if TYPE_CHECKING:
    from ropefric.files.folder import OutputFolder
    from ropefric.trials.campaign_model import Campaign

__all__ = ["EXTRACTED", "Force", "campaign_inputs", "figure_names", "folder_option", "open_folder"]

EXTRACTED = (
    *("trials.csv", "conditions.csv", "problems.csv"),
    *("figures/Rw*deg_F*.png", "figures/Rw*deg_F*.csv"),
)
"""What an extraction writes."""

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
    path: Path,
    *,
    family: str,
    names: Iterable[str],
    inputs: Iterable[Path] = (),
    basis: str = "",
    force: bool,
) -> "OutputFolder":
    """Return a command's folder, to be used as a context; see `OutputFolder`."""
    import shlex  # noqa: PLC0415  (these: quick start-up)

    from ropefric.files.folder import CACHE, OutputFolder  # noqa: PLC0415

    _lend_a_place(path / CACHE)
    return OutputFolder(
        path,
        family=family,
        names=names,
        inputs=inputs,
        basis=basis,
        force=force,
        command=shlex.join(["ropefric", *sys.argv[1:]]),
    )


def figure_names(*stems: str) -> tuple[str, ...]:
    """Return the files that figures may be written to: pictures, and tables with endings of their own.

    Examples
    --------
    >>> figure_names("sweep")
    ('sweep.png', 'sweep.csv', 'sweep_*.csv')
    """
    return tuple(f"{stem}{end}" for stem in stems for end in (".png", ".csv", "_*.csv"))


def campaign_inputs(campaign: "Campaign") -> tuple[Path, ...]:
    """Return every file a campaign is read from."""
    from ropefric.trials.toml_document import read_toml  # noqa: PLC0415  (quick start-up)

    trials = campaign.path.parent / str(read_toml(campaign.path).data["trials"])
    return (campaign.path, trials, *dict.fromkeys(trial.path for trial in campaign.trials))


def _lend_a_place(folder: Path) -> None:
    """Let matplotlib keep its list of fonts in `folder` where the machine has no place for what is temporary."""
    import tempfile  # noqa: PLC0415  (quick start-up)

    try:
        tempfile.gettempdir()
    except OSError:
        wished = os.environ.get("MPLCONFIGDIR")
        if not wished or not os.access(wished, os.W_OK):
            os.environ["MPLCONFIGDIR"] = str((folder / "matplotlib").absolute())
