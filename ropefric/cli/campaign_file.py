"""Which campaign is meant: its file, or the folder it lies in."""

from pathlib import Path
from typing import Annotated

import typer

CampaignArgument = Annotated[
    Path,
    typer.Argument(
        metavar="CAMPAIGN.toml", help="The campaign: its TOML file, or the folder with a campaign.toml."
    ),
]


def campaign_file(path: Path) -> Path:
    """Return the campaign file that `path` names, which need not exist."""
    return path / "campaign.toml" if path.is_dir() else path


def what_was_kept(cache_folder: Path | None) -> str:
    """Return what an interrupted run leaves for the next one."""
    if cache_folder is None:
        return "nothing is kept (--no-cache)"
    return f"finished recordings are kept in {cache_folder}; the same command goes on from there"
