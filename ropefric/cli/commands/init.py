"""`ropefric init`: a commented campaign to fill in."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ropefric.cli.command import Answer, Command
from ropefric.cli.output import Output

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["COMMAND"]

Folder = Annotated[Path, typer.Argument(help="Where to write them; made where it is missing.")]
Force = Annotated[bool, typer.Option("--force", help="Write over files that are already there.")]


def init(out: Output, *, folder: Folder = Path(), force: Force = False) -> Answer:
    """Write commented templates of campaign.toml and trials.csv, to be filled in with your campaign."""
    from ropefric.trials.campaign_templates import write_templates  # noqa: PLC0415  (quick start-up)

    written = write_templates(folder, overwrite=force)
    campaign = next((path for path in written if path.suffix == ".toml"), folder / "campaign.toml")
    out.note(f"next: fill them in, then  ropefric check {campaign}")

    def show(console: "Console") -> None:
        for path in written:
            console.print(f"wrote {path}", markup=False, soft_wrap=True)

    return Answer(data={"written": written}, show=show)


COMMAND = Command(name="init", run=init, example="ropefric init my-campaign", order=10)
