"""`ropefric verify`: every stored fit made again from its data."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ropefric.cli.command import Answer, Command
from ropefric.cli.fitting_options import NOT_TRUSTED
from ropefric.cli.output import Output
from ropefric.cli.tables import make_table, number

if TYPE_CHECKING:
    from rich.console import Console


FitFolder = Annotated[Path, typer.Argument(metavar="FOLDER", help="The folder of the stored fits.")]


def verify(out: Output, folder: FitFolder = Path("fits")) -> Answer:
    """Fit every stored fit of a folder again from its data, and compare.

    Exits with 4 when one does not come out again.
    """
    from ropefric.fitting.store import verify_fits  # noqa: PLC0415  (quick start-up)

    found = verify_fits(folder)
    n_ok = sum(item.ok for item in found)
    out.note(f"{n_ok} of {len(found)} fits come out of their data again")

    def show(console: "Console") -> None:
        rows = [
            (
                Path(item.path).name,
                "ok" if item.ok else "FAILED",
                number(item.difference, ".1g"),
                item.message,
            )
            for item in found
        ]
        console.print(make_table(("fit", "", "change [standard errors]", "found "), rows, left=2))

    return Answer(
        data={"ok": n_ok == len(found), "fits": [asdict(item) for item in found]},
        show=show,
        exit_code=0 if n_ok == len(found) else NOT_TRUSTED,
    )


COMMAND = Command(name="verify", run=verify, example="ropefric verify fits/", order=190)
