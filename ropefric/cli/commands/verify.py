"""`ropefric verify`: every stored fit made again from its data."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from typer import Argument

from ropefric.cli.options import NOT_TRUSTED, Answer, Command
from ropefric.cli.output import Output, make_table, number

if TYPE_CHECKING:
    from rich.console import Console


def verify(
    out: Output,
    folder: Path = Argument(Path("fits"), metavar="FOLDER", help="The folder of the stored fits."),
) -> Answer:
    """Fit every stored fit of a folder again from its data, and compare.

    Exits with 4 when one does not come out again.
    """
    from ropefric.fitting.store import verify_fits  # noqa: PLC0415  (quick start-up)

    found = verify_fits(folder)
    n_ok = sum(item.ok for item in found)
    out.note(f"{n_ok} of {len(found)} fits come out of their data again")

    def show(console: "Console") -> None:
        words = {True: "ok", False: "FAILED"}
        rows = [
            (Path(one.path).name, words[one.ok], number(one.difference, ".1g"), one.message) for one in found
        ]
        console.print(make_table(("fit", "", "change [standard errors]", "found "), rows, left=2))

    return Answer(
        {"ok": n_ok == len(found), "fits": [asdict(item) for item in found]},
        show,
        0 if n_ok == len(found) else NOT_TRUSTED,
    )


COMMAND = Command("verify", verify, "ropefric verify fits/", order=190)
