"""What the commands on trial tables and stored fits share."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ropefric.cli.output import Output
from ropefric.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.console import Console

    from ropefric.fitting.judgement import Verdict
    from ropefric.fitting.result import FitResult
    from ropefric.fitting.table import TrialTable
    from ropefric.report.section import Section


NOT_TRUSTED = 4
"""Exit code of a result that is not supported: undecided, or not judged."""

TableArgument = Annotated[
    Path,
    typer.Argument(metavar="TRIALS.csv", help="A trial table: what `extract` writes, or one of your own."),
]
FitOption = Annotated[Path, typer.Option("--fit", metavar="FIT.json", help="A stored fit.")]


def read_table(path: Path, out: Output) -> "TrialTable":
    """Return a trial table, and say on stderr what is doubtful about it."""
    from ropefric.fitting.table import read_trial_table  # noqa: PLC0415  (quick start-up)

    table = read_trial_table(path)
    out.problems(table.warnings)
    return table


def read_fit(path: Path, out: Output) -> "FitResult":
    """Return a stored fit, and say on stderr if its law is not supported."""
    from ropefric.fitting.store import load_fit  # noqa: PLC0415  (quick start-up)

    fit = load_fit(path)
    if not fit.trustworthy:
        out.note(f"{path}: the law is {fit.verdict.word}: {fit.verdict.reason}")
    return fit


def exit_code_of(verdict: "Verdict") -> int:
    """Return 0 for what is supported, 4 for what is undecided or not judged."""
    return 0 if verdict.supported else NOT_TRUSTED


def rope_radius(fit: "FitResult", given_m: float | None) -> float:
    """Return the rope radius [m] that is meant: the one given, or that of the trials if they had one only."""
    if given_m is not None:
        return given_m
    try:
        return fit.only_rope_radius_m()
    except InputError as error:
        raise typer.BadParameter(str(error), param_hint="--rope-diameter") from error


def show_sections(sections: "Sequence[Section]", console: "Console") -> None:
    """Print sections as plain text."""
    from ropefric.report.section import as_text  # noqa: PLC0415  (quick start-up)

    console.print(as_text(sections), end="", markup=False, soft_wrap=True)
