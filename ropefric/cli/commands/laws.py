"""The commands of friction laws: fitted to a trial table, compared, and stored fits shown or made again."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from typer import Argument, Option

from ropefric.cli import on_first_use, options
from ropefric.cli.options import Answer, Words, command, exit_code_of, flag, listed, option
from ropefric.cli.output import Output, Progress

with on_first_use():
    from ropefric import section
    from ropefric.fitting import compare as comparing
    from ropefric.fitting import diagnose as diagnosing
    from ropefric.fitting import fit as fitting
    from ropefric.fitting import intervals as confidence
    from ropefric.fitting import store
    from ropefric.report import parts


_LARGE = 5_000_000
"""Bytes of a table that takes seconds."""


_OF = Option(
    "peak", metavar="peak|kinetic", help="Fit the break-away force, or the mean force while sliding."
)

_TOUCHING = Option(
    None, min=0.0, help="Turns that touch the one beside them; by default all beyond the first may."
)


@command("ropefric fit fits/prth-trials.csv --law coupled --out coupled.json", order=80)
def fit(
    out: Output,
    trials: options.TableArgument,
    *,
    law: str = Option(..., help="The friction law: constant, wrap-power, coupled, …"),
    fix: Words = listed("NAME=VALUE", "Hold a parameter"),
    bound: Words = listed("NAME=LOW:HIGH", "Bounds of a parameter"),
    start: Words = Option(None, metavar="NAME=VALUE", help="Start value; the law guesses others."),
    intervals: str = option(
        "auto|covariance|profile|bootstrap|bootstrap-t",
        "Where the 95 % intervals come from; auto is the covariance where it will do, else the profile.",
        default="auto",
    ),
    loss: str = Option("linear", help="linear, or soft_l1, huber, cauchy, arctan: less weight for outliers."),
    seed: int = Option(0, min=0, help="Of the search's further starts and of the bootstrap."),
    of: str = _OF,
    file: Path | None = Option(None, "--out", "-o", metavar="FIT.json", help="Store the fit there."),
    force: bool = flag("--force", "Write over a file that is there and is no fit."),
) -> Answer:
    """Fit a friction law to a trial table: parameters with 95 % intervals, and whether to trust them.

    Exits with 4 when the law is not supported by its fit: undecided, or not judged; the status says more.
    """
    given = {
        "fixed": options.parse_assignments(fix or (), option="--fix"),
        "bounds": options.parse_spans(bound or (), option="--bound"),
        "start": options.parse_assignments(start or (), option="--start"),
    }
    if file is not None:  # before the work
        store.check_target(file, trials, overwrite=force)
    with _steps(trials, out) as step:
        step(0, "reading")
        table = options.read_table(trials, out, of=of)
        step(1, "fitting")
        fitted = fitting.fit_law(table, law, loss=loss, seed=seed, **given)
        step(2, "intervals")
        result = confidence.with_intervals(fitted, intervals, seed=seed)
        step(3, "done")
    if file is not None:
        out.note(f"wrote {store.save_fit(result, file, overwrite=force)}")
    verdict = parts.verdict_section(result.verdict, "The verdict, by this fit alone")
    sections = [parts.fit_section(result), verdict, *parts.notes_sections(result)]
    data = result.to_dict() | {"verdict": result.verdict.to_dict(), "of": result.of}
    return Answer(data, sections, exit_code_of(result.verdict))


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
    trials: options.TableArgument,
    *,
    laws: Words = listed("NAME[,NAME…]", "Laws to compare, all by default"),
    of: str = _OF,
    touching_turns: float | None = _TOUCHING,
) -> Answer:
    """Rank friction laws on a trial table by AICc, with weights and the error at unseen conditions.

    What no law knows is said beside them: contact between coils, where that describes the trials as well or better.

    The two constant laws always stand in the comparison. Exits with 4 unless the best law is supported: when the
    data leave two laws undecided, or no choice at all.
    """
    names = [name.strip() for text in laws or () for name in text.split(",") if name.strip()]
    table = options.read_table(trials, out, of=of)
    with Progress(out, "fit") as progress:
        told = progress.update_named
        found = comparing.compare_laws(table, names or None, touching_turns=touching_turns, progress=told)
    chosen = comparing.choose_law(found)
    verdict = parts.verdict_section(chosen.verdict, f"The law: {chosen.fit.law}")
    data = found.to_dict() | chosen.to_dict() | {"of": table.force}
    return Answer(data, [parts.comparison_section(found), verdict], exit_code_of(chosen.verdict))


@command("ropefric diagnose fits/prth-trials.csv", order=110)
def diagnose(
    out: Output,
    trials: options.TableArgument,
    *,
    touching_turns: float | None = _TOUCHING,
) -> Answer:
    """Say why trials do not obey the capstan equation, with the evidence: offset, load, size, wrap, coil contact.

    Columns rope_id, wheel, operator, dwell and order of the table are looked at too. Of what is not supported the
    largest effect is stated that the data leave room for.

    Exits with 4 unless the best law is supported: when the data leave two laws undecided, or no choice at all.
    """
    found = diagnosing.diagnose(options.read_table(trials, out), touching_turns=touching_turns)
    return Answer(found.to_dict(), [parts.diagnosis_section(found, full=True)], exit_code_of(found.verdict))


@command("ropefric show fits/prth-coupled.json", order=90)
def show(out: Output, file: Path = Argument(..., metavar="FIT.json", help="A stored fit.")) -> Answer:
    """Show a stored fit: its parameters, whether to trust it, what it was made from, where it holds.

    Exits with 4 when its law is not supported: undecided, or not judged.
    """
    fit = options.read_fit(file, out)
    sections = [parts.fit_section(fit, short=True), *parts.notes_sections(fit), parts.origin_section(fit)]
    return Answer(fit.to_dict() | {"verdict": fit.verdict.to_dict()}, sections, exit_code_of(fit.verdict))


@command("ropefric verify fits/", order=190)
def verify(
    out: Output,
    folder: Path = Argument(Path("fits"), metavar="FOLDER", help="The folder of the stored fits."),
) -> Answer:
    """Fit every stored fit of a folder again from its data, and compare.

    Exits with 4 when one does not come out again.
    """
    found = store.verify_fits(folder)
    n_ok = sum(item.ok for item in found)
    out.note(f"{n_ok} of {len(found)} fits come out of their data again")
    words, good = {True: "ok", False: "FAILED"}, n_ok == len(found)
    rows = [(Path(i.path).name, words[i.ok], section.plain(i.difference, ".1g"), i.message) for i in found]
    headings = ("fit", "", "change [standard errors]", "found ")
    shown = section.Section(headings=headings, rows=rows, left=2)
    return Answer({"ok": good, "fits": [item._asdict() for item in found]}, [shown], exit_code_of(good))
