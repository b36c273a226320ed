"""`ropefric fit`: one friction law on a trial table."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from typer import Option

from ropefric.cli.options import (
    Answer,
    Command,
    TableArgument,
    exit_code_of,
    parse_assignments,
    parse_spans,
    read_table,
)
from ropefric.cli.output import Output, Progress

_LARGE = 5_000_000
"""Bytes of a table that takes seconds."""


def fit(
    out: Output,
    trials: TableArgument,
    *,
    law: str = Option(..., help="The friction law: constant, wrap-power, coupled, …"),
    fix: list[str] | None = Option(None, metavar="NAME=VALUE", help="Hold a parameter; repeatable."),
    bound: list[str] | None = Option(
        None, metavar="NAME=LOW:HIGH", help="Bounds of a parameter; repeatable."
    ),
    start: list[str] | None = Option(None, metavar="NAME=VALUE", help="Start value; the law guesses others."),
    intervals: str = Option(
        "covariance", metavar="covariance|profile|bootstrap", help="Where the 95 % intervals come from."
    ),
    loss: str = Option("linear", help="linear, or soft_l1, huber, cauchy, arctan: less weight for outliers."),
    seed: int = Option(0, min=0, help="Of the search's further starts and of the bootstrap."),
    file: Path | None = Option(None, "--out", "-o", metavar="FIT.json", help="Store the fit there."),
    force: bool = Option(False, "--force", help="Write over a file that is there and is no fit."),
) -> Answer:
    """Fit a friction law to a trial table: parameters with 95 % intervals, and whether to trust them.

    Exits with 4 when the law is not supported by its fit: undecided, or not judged; the status says more.
    """
    from ropefric.fitting.fit import fit_law  # noqa: PLC0415  (all of these: quick start-up)
    from ropefric.fitting.intervals import with_intervals  # noqa: PLC0415
    from ropefric.fitting.store import check_target, save_fit  # noqa: PLC0415
    from ropefric.report.parts import fit_section, notes_sections, verdict_section  # noqa: PLC0415

    options = {
        "fixed": parse_assignments(fix or (), option="--fix"),
        "bounds": parse_spans(bound or (), option="--bound"),
        "start": parse_assignments(start or (), option="--start"),
    }
    if file is not None:  # before the work
        check_target(file, trials, overwrite=force)
    with _steps(trials, out) as step:
        step(0, "reading")
        table = read_table(trials, out)
        step(1, "fitting")
        fitted = fit_law(table, law, loss=loss, seed=seed, **options)
        step(2, "intervals")
        result = with_intervals(fitted, intervals, seed=seed)
        step(3, "done")
    if file is not None:
        out.note(f"wrote {save_fit(result, file, overwrite=force)}")
    verdict = verdict_section(result.verdict, "The verdict, by this fit alone")
    sections = [fit_section(result), verdict, *notes_sections(result)]
    return Answer(
        result.to_dict() | {"verdict": result.verdict.to_dict()},
        sections,
        exit_code_of(result.verdict),
    )


@contextmanager
def _steps(trials: Path, out: Output) -> Iterator[Callable[[int, str], None]]:
    """Give what shows the steps of a fit as progress, if the table is so large that they take time."""
    if not trials.is_file() or trials.stat().st_size < _LARGE:
        yield lambda _done, _what: None
        return
    with Progress(out, "fit") as progress:
        yield lambda done, what: progress.update(done, 3, what)


COMMAND = Command("fit", fit, "ropefric fit fits/prth-trials.csv --law coupled --out coupled.json", order=80)
