"""Shared parts of the commands: their answer, and options for files, folders, quantities and processes."""

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Annotated, Any, NamedTuple, TypeVar

import typer

from ropefric.cli import on_first_use
from ropefric.cli.output import Output
from ropefric.errors import DataError, InputError, RopefricError
from ropefric.files.disk import refuse_input, refuse_special

with on_first_use():
    from ropefric import executors, quantities, section
    from ropefric.files import folder as folders
    from ropefric.fitting import result, store
    from ropefric.trials import table

T = TypeVar("T")

NOT_TRUSTED = 4
"""Exit code of a result that is not supported: undecided, or not judged."""
SERIAL_BELOW = 20
"""Recordings below which starting worker processes costs more than it saves."""


class Answer(NamedTuple):
    """The result of one command: data for programs, what people see of it, an exit code."""

    data: Mapping[str, Any]
    show: "Sequence[section.Section] | str"
    exit_code: int = 0


class Command(NamedTuple):
    """One verb of the command line, declared in a file of `cli/commands/`."""

    name: str
    run: Callable[..., Answer]
    example: str
    order: int


def command(example: str, *, order: int) -> Callable[[Callable[..., Answer]], Command]:
    """Declare the command that a function runs, by whose name it is called."""
    return lambda run: Command(run.__name__.replace("_", "-"), run, example, order)


Words = list[str] | None
Number = float | None


def listed(metavar: str, help: str, *names: str) -> Any:  # noqa: A002  (as typer calls it)
    """Return an option that may be given several times."""
    return typer.Option(None, *names, metavar=metavar, help=f"{help}; repeatable.")


def option(metavar: str, help: str, *names: str, default: Any = None) -> Any:  # noqa: A002
    """Return an option with a value, shown as `metavar` in the help."""
    return typer.Option(default, *names, metavar=metavar or None, help=help)


def flag(name: str, help: str) -> Any:  # noqa: A002
    """Return an option that is given or not."""
    return typer.Option(False, name, help=help)


# Files and folders.


def out_folder(help: str, default: Path | None = None, names: tuple[str, ...] = ("--out", "-o")) -> Any:  # noqa: A002
    """Return an option that names a folder; an empty name, such as an unset variable gives, is none."""

    def named(text: str) -> Path:
        if not str(text):
            fix = 'write "." for this folder'
            raise RopefricError("the folder has no name", code="RF110", key="--out", fix=fix)
        return Path(text)

    return typer.Option(default, *names, parser=named, metavar="FOLDER", help=help)


_CAMPAIGN = "The campaign: its TOML file, or the folder with a campaign.toml."
_TABLE = "A trial table, CSV, Excel or Parquet: what `extract` writes, or one of your own."
CampaignArgument = Annotated[Path, typer.Argument(metavar="CAMPAIGN.toml", help=_CAMPAIGN)]
TableArgument = Annotated[Path, typer.Argument(metavar="TRIALS.csv", help=_TABLE)]
SceneArgument = Annotated[Path, typer.Argument(metavar="SCENE.toml", help="The scene.")]
FitOption = Annotated[Path, typer.Option("--fit", metavar="FIT.json", help="A stored fit.")]
Force = Annotated[bool, typer.Option("--force", help="Replace files there that ropefric did not write.")]
Jobs = Annotated[
    str, typer.Option(metavar="auto|N", help="Processes, at most the cores; auto: one for a small campaign.")
]
_CLUSTER = "Work on a dask cluster, tcp://HOST:8786 as a rule."
Cluster = Annotated[str, typer.Option("--cluster", metavar="local|ADDRESS", help=_CLUSTER)]
Parquet = Annotated[
    bool, typer.Option("--parquet", help="Write trials.parquet beside trials.csv, with the same numbers.")
]
Level = Annotated[float, typer.Option(help="Level of the intervals, between 0 and 1.")]


TABLES = (".csv", ".tsv", ".txt", ".xlsx", ".xls", ".ods")


def campaign_file(path: Path, *, or_table: bool = False) -> Path:
    """Return the campaign file that `path` names, which need not exist; or the table, where one will do."""
    if not or_table and path.suffix.lower() in TABLES and path.is_file():
        fix = "name the campaign.toml, or its folder; `ropefric report` answers a table of forces"
        raise DataError("this is a table, not a campaign", path=path, fix=fix)
    return path / "campaign.toml" if path.is_dir() else path


def read_table(path: Path, out: Output, *, of: str = "peak") -> "table.TrialTable":
    """Return a trial table of the force to fit, with its warnings on stderr."""
    found = table.read_trial_table(path).of(of)
    out.problems(found.warnings)
    return found


def read_fit(path: Path, out: Output) -> "result.FitResult":
    """Return a stored fit, and say on stderr if its law is not supported."""
    fit = store.load_fit(path)
    if not fit.trustworthy:
        out.note(f"{path}: the law is {fit.verdict.word}: {fit.verdict.reason}")
    if fit.of == "kinetic":
        out.note(f"{path}: a law of the kinetic force, so F_A is what keeps the rope sliding")
    return fit


def refuse_file(path: Path | None, source: Path | None, *, force: bool) -> None:
    """Refuse, before the work, to write to a special file, to an input, or without `force` over a file that exists."""
    if path is None:
        return
    refuse_special(path)
    refuse_input(path, source)
    if path.exists() and not force:
        fix = "choose another name, or replace it with --force"
        raise InputError("the file is there already", code="RF150", path=path.as_posix(), fix=fix)


def rope_radius(fit: "result.FitResult", given_m: float | None) -> float:
    """Return the rope radius [m] that is meant: the one given, or that of the trials if they had one only."""
    if given_m is not None:
        return given_m
    try:
        return fit.only_rope_radius_m()
    except InputError as error:
        raise typer.BadParameter(str(error), param_hint="--rope-diameter") from error


def exit_code_of(found: "bool | result.Verdict") -> int:
    """Return 0 for a supported result, 4 for an undecided or not judged one."""
    return 0 if getattr(found, "supported", found) else NOT_TRUSTED


def open_folder(
    path: Path | None, *, family: str, names: Iterable[str], inputs: Iterable[Path] = (), force: bool
) -> AbstractContextManager[Any]:
    """Return a command's folder, to be used as a context, see `OutputFolder`; of none given, nothing."""
    if path is None:
        return nullcontext()
    lend_fonts_a_place(path)
    return folders.OutputFolder(path, family=family, names=names, inputs=inputs, force=force)


def figure_names(*stems: str) -> tuple[str, ...]:
    """Return the files that figures may be written to: pictures, and tables with endings of their own."""
    return tuple(f"{stem}{end}" for stem in stems for end in (".png", ".csv", "_*.csv"))


def lend_fonts_a_place(folder: Path) -> None:
    """Let matplotlib keep its list of fonts with the results where the machine has no place for such things."""
    import tempfile  # noqa: PLC0415  (quick start-up)

    try:
        tempfile.gettempdir()
    except OSError:
        wished = os.environ.get("MPLCONFIGDIR")
        if not wished or not os.access(wished, os.W_OK):
            os.environ["MPLCONFIGDIR"] = str((folder / folders.CACHE / "matplotlib").absolute())


def publish(out: Output, folder: "folders.Folder", family: str, files: Sequence[Path]) -> Sequence[Path]:
    """Publish what was written to a folder, say so, and return its paths."""
    folder.publish(family)
    for path in files:
        out.note(f"wrote {path}")
    return files


def written_to(folder: Path, files: str) -> "section.Section":
    """Return the line that says where results are."""
    return section.Section(title="", lines=(f"written to {folder}: {files}",), verbatim=True)


# Quantities and numbers.


def read_quantity(text: str, si_unit: str, option: str) -> float:
    """Return an option's quantity, written with its unit as in a campaign file, in SI."""
    try:
        return quantities.parse_quantity(text, si_unit, name=option)
    except InputError as error:
        raise typer.BadParameter(str(error), param_hint=option) from error


_METAVARS = {"m": "LENGTH", "rad": "ANGLE", "N": "FORCE", "": "PART", "m/s": "SPEED", "kg/m": "DENSITY"}


def quantity(
    option: str,
    si_unit: str,
    help: str,  # noqa: A002  (as typer calls it)
    *,
    needed: bool = False,
    factor: float = 1.0,
) -> Any:
    """Return an option that is a quantity, times a factor; an empty text is none, unless the quantity is needed."""

    def read(text: str) -> float | None:
        return factor * read_quantity(text, si_unit, option) if text or needed else None

    metavar = _METAVARS.get(si_unit, "QUANTITY")
    return typer.Option(... if needed else None, option, parser=read, metavar=metavar, help=help)


def diameter(option: str, help: str) -> Any:  # noqa: A002
    """Return an option that is given as a diameter and used as a radius [m]."""
    return quantity(option, "m", help, factor=0.5)


ROPE_DIAMETER = diameter("--rope-diameter", "Of another rope than that of the trials.")


def parse_assignments(texts: Iterable[str], *, option: str) -> dict[str, float]:
    """Return options that set numbers by name, `--parameter mu=0.2`, as a mapping."""
    return _by_name(texts, option, "mu=0.2", _finite)


def parse_spans(texts: Iterable[str], *, option: str) -> dict[str, tuple[float, float]]:
    """Return options that set bounds by name, `--bound d=0:0.2`, as a mapping."""

    def read(text: str) -> tuple[float, float]:
        low, high = map(_finite, text.split(":"))
        if low >= high:
            raise ValueError
        return low, high

    return _by_name(texts, option, "d=0:0.2", read)


def parse_sharers(texts: Iterable[str] | None) -> dict[str, str] | None:
    """Return what shares stated errors, `--shared wrap=rig`, beside what a cell shares; None where nothing is said."""
    return {"cell": "cell"} | _by_name(texts, "--shared", "wrap=rig", str) if texts else None


def _finite(text: str) -> float:
    if not math.isfinite(value := float(text)):
        raise ValueError
    return value


def _by_name(texts: Iterable[str], option: str, like: str, read: Callable[[str], T]) -> dict[str, T]:
    values: dict[str, T] = {}
    for text in texts:
        name, equals, written = (part.strip() for part in text.partition("="))
        try:
            value = read(written)
        except ValueError:
            equals = ""
        if not name or not equals:
            raise typer.BadParameter(f"{text!r} is not like {like}", param_hint=option)
        if name in values:
            raise typer.BadParameter(f"{name!r} is given twice", param_hint=option)
        values[name] = value
    return values


def parse_jobs(text: str, n_items: int) -> int:
    """Return the number of processes for `n_items` recordings: what the user says, or what pays.

    No more than there are recordings and cores.
    """
    if text != "auto" and (not text.isdecimal() or len(text) > 9 or int(text) < 1):
        raise typer.BadParameter(f"{text!r} is neither 'auto' nor a number of processes", param_hint="--jobs")
    if text == "auto" and n_items < SERIAL_BELOW:
        return 1
    wanted = n_items if text == "auto" else int(text)
    return max(1, min(wanted, n_items, executors.usable_cores()))
