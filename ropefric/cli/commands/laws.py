"""The commands of friction laws: fitted to a trial table, compared, and stored fits shown or made again."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from typer import Argument, Option

from ropefric.cli.options import (
    NOT_TRUSTED,
    Answer,
    TableArgument,
    command,
    exit_code_of,
    parse_assignments,
    parse_spans,
    read_fit,
    read_table,
)
from ropefric.cli.output import Output, Progress, make_table, number

if TYPE_CHECKING:
    from rich.console import Console


_LARGE = 5_000_000
"""Bytes of a table that takes seconds."""


_OF = Option(
    "peak", metavar="peak|kinetic", help="Fit the break-away force, or the mean force while sliding."
)


@command("ropefric fit fits/prth-trials.csv --law coupled --out coupled.json", order=80)
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
    of: str = _OF,
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
        table = read_table(trials, out, of=of)
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
        result.to_dict() | {"verdict": result.verdict.to_dict(), "of": result.of},
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


@command("ropefric compare fits/prth-trials.csv", order=100)
def compare(
    out: Output,
    trials: TableArgument,
    *,
    laws: list[str] | None = Option(
        None, metavar="NAME[,NAME…]", help="Laws to compare, all by default; repeatable."
    ),
    of: str = _OF,
) -> Answer:
    """Rank friction laws on a trial table by AICc, with weights and the error at unseen conditions.

    The two constant laws always stand in the comparison. Exits with 4 unless the best law is supported: when the
    data leave two laws undecided, or no choice at all.
    """
    from ropefric.fitting.compare import choose_law, compare_laws  # noqa: PLC0415  (all of these: quick start-up)
    from ropefric.report.parts import comparison_section, verdict_section  # noqa: PLC0415

    names = [name.strip() for text in laws or () for name in text.split(",") if name.strip()]
    table = read_table(trials, out, of=of)
    with Progress(out, "fit") as progress:
        found = compare_laws(
            table, names or None, progress=lambda law, done, total: progress.update(done, total, law)
        )
    choice = choose_law(found)
    verdict = verdict_section(choice.verdict, f"The law: {choice.fit.law}")
    return Answer(
        found.to_dict() | choice.to_dict() | {"of": table.force},
        [comparison_section(found), verdict],
        exit_code_of(choice.verdict),
    )


@command("ropefric diagnose fits/prth-trials.csv", order=110)
def diagnose(out: Output, trials: TableArgument) -> Answer:
    """Say why trials do not obey the capstan equation, with the evidence: offset, load, size, wrap, no gross slip.

    Exits with 4 unless the best law is supported: when the data leave two laws undecided, or no choice at all.
    """
    from ropefric.fitting.diagnose import diagnose as find_causes  # noqa: PLC0415  (quick start-up)
    from ropefric.report.parts import diagnosis_section  # noqa: PLC0415

    found = find_causes(read_table(trials, out))
    return Answer(found.to_dict(), [diagnosis_section(found, full=True)], exit_code_of(found.verdict))


@command("ropefric show fits/prth-coupled.json", order=90)
def show(out: Output, file: Path = Argument(..., metavar="FIT.json", help="A stored fit.")) -> Answer:
    """Show a stored fit: its parameters, whether to trust it, what it was made from, where it holds.

    Exits with 4 when its law is not supported: undecided, or not judged.
    """
    from ropefric.report.parts import fit_section, notes_sections, origin_section  # noqa: PLC0415  (quick start-up)

    fit = read_fit(file, out)
    sections = [fit_section(fit, short=True), *notes_sections(fit), origin_section(fit)]
    return Answer(fit.to_dict() | {"verdict": fit.verdict.to_dict()}, sections, exit_code_of(fit.verdict))


@command("ropefric verify fits/", order=190)
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
