"""`ropefric show`: a stored fit, for people."""

from pathlib import Path

from typer import Argument

from ropefric.cli.options import Answer, Command, exit_code_of, read_fit
from ropefric.cli.output import Output


def show(out: Output, file: Path = Argument(..., metavar="FIT.json", help="A stored fit.")) -> Answer:
    """Show a stored fit: its parameters, whether to trust it, what it was made from, where it holds.

    Exits with 4 when its law is not supported: undecided, or not judged.
    """
    from ropefric.report.parts import fit_section, notes_sections, origin_section  # noqa: PLC0415  (quick start-up)

    fit = read_fit(file, out)
    sections = [fit_section(fit, short=True), *notes_sections(fit), origin_section(fit)]
    return Answer(fit.to_dict() | {"verdict": fit.verdict.to_dict()}, sections, exit_code_of(fit.verdict))


COMMAND = Command("show", show, "ropefric show fits/prth-coupled.json", order=90)
