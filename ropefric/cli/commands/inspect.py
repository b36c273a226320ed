"""`ropefric inspect`: what is in a recording file, and the import profile that would read it."""

from functools import partial
from itertools import accumulate
from pathlib import Path
from typing import TYPE_CHECKING

from typer import Argument, Option

from ropefric.cli.options import Answer, Command, quantity
from ropefric.cli.output import Output, make_table, number
from ropefric.errors import DataError, InputError
from ropefric.files.write import refuse_input, refuse_special, write_file

if TYPE_CHECKING:
    from rich.console import Console

    from ropefric.traces.readers.inspection import ColumnSummary, Inspection
    from ropefric.traces.readers.profile import ImportProfile


_MARKS = {"\t": "tab", " ": "space", ",": "comma", ";": "semicolon", ".": "point", "|": "bar"}


def inspect(
    out: Output,
    file: Path = Argument(..., metavar="FILE", help="A recording."),
    *,
    file_format: str = Option(
        "auto",
        "--format",
        metavar="NAME",
        help="How it is written, where its name does not tell: delimited, …",
    ),
    write_profile: Path | None = Option(
        None, metavar="PATH", help="Write the suggested [import] section there."
    ),
    force: bool = Option(False, "--force", help="Write over a file that is already there."),
    everything: bool = Option(
        False, "--all", help="Read a large text whole, not only its first and last megabyte."
    ),
    memory: float | None = quantity(
        None, "--memory", "byte", "QUANTITY", "Most memory that reading it may take [2 GB]."
    ),
    time: float | None = quantity(
        None, "--time", "s", "QUANTITY", "Most time that reading it may take [120 s]."
    ),
) -> Answer:
    """Look at a recording: columns, units, ranges, first rows, doubts, and the profile to read it with.

    Paste the section into campaign.toml, after checking the doubts.
    """
    from ropefric.traces.readers.profile import ImportProfile, profile_to_toml  # noqa: PLC0415  (quick start-up)
    from ropefric.trials.workers import Limits, Lost, guarded  # noqa: PLC0415

    if file.is_dir():
        raise DataError("this is a folder, not a recording", path=file, fix=_fix_of_folder(file))
    if write_profile is not None:  # before the work
        refuse_special(write_profile)
        refuse_input(write_profile, file)
        if write_profile.exists() and not force:
            fix = "choose another name, or add --force"
            raise InputError("the file is there already", code="RF150", path=write_profile, fix=fix)
    given = {"memory_bytes": memory, "time_s": time}
    limits = Limits(**{name: value for name, value in given.items() if value is not None})
    # By a process that may die of it.
    look = partial(_inspect, file, ImportProfile(format=file_format), everything)
    ((_, found),) = guarded(look, 1, limits=limits)
    if isinstance(found, Lost):
        raise DataError(found.reason, code="RF101", path=file, fix=found.fix)
    profile = profile_to_toml(found.profile)
    if write_profile is not None:
        write_file(write_profile, profile)
        out.note(f"wrote {write_profile}")

    def show(console: "Console") -> None:
        _show(found, console)
        console.print("\nsuggested for campaign.toml:\n", style="bold")
        console.print(profile.rstrip(), markup=False, soft_wrap=True)

    return Answer(found.to_dict(), show)


def _inspect(file: Path, profile: "ImportProfile", everything: bool, _: int) -> "Inspection":  # noqa: FBT001
    from ropefric.traces.readers.inspection import inspect_file  # noqa: PLC0415

    return inspect_file(file, profile, everything=everything)


def _fix_of_folder(folder: Path) -> str:
    """Return what to name instead of a folder; a campaign's recordings are looked at by other commands."""
    if (folder / "campaign.toml").is_file():
        return f"name one file of it; `ropefric check {folder}` looks at the campaign"
    names = sorted(path.name for path in folder.iterdir() if path.is_file() and not path.name.startswith("."))
    return f"name one file of it, such as {names[0]}" if names else "name a file; this folder holds none"


def _show(found: "Inspection", console: "Console") -> None:
    """Print what was found out about a file: how it is written, its columns, its first rows, what to check."""
    console.print(_headline(found), markup=False, soft_wrap=True)
    console.print()
    headings = ("no.", "column ", "unit ", "from", "to", "missing", "holds ")
    rows = [_column_row(found, column) for column in found.columns]
    filled = [place for place in range(len(headings)) if any(row[place] for row in rows)]
    shown = [[row[place] for place in filled] for row in (headings, *rows)]
    console.print(make_table(shown[0], shown[1:], left=0))
    if found.first_rows:
        _show_first_rows(found, console)
    if found.doubts:
        console.print("\nplease check:\n", style="bold yellow")
        for doubt in found.doubts:
            console.print(f"- {doubt}", markup=False, soft_wrap=True)


def _show_first_rows(found: "Inspection", console: "Console") -> None:
    console.print("\nfirst rows:\n", style="bold")
    names = [column.name or f"({column.number})" for column in found.columns]
    rows = [[*row[: len(names)], *[""] * (len(names) - len(row))] for row in found.first_rows]
    widths = [max(map(len, cells)) + 3 for cells in zip(names, *rows, strict=True)]
    fitting = sum(total <= console.width for total in accumulate(widths))
    console.print(make_table(names[:fitting], [row[:fitting] for row in rows], left=0))
    hidden = max(len(row) for row in found.first_rows) - fitting
    if hidden > 0:
        console.print(f"({hidden} more columns)")


def _headline(found: "Inspection") -> str:
    rows = f"{found.n_rows} rows"
    if found.n_rows_about:
        rows = f"at least {found.n_rows} rows, perhaps {found.n_rows_about:.2g}"
    facts = [found.format, rows]
    if found.samples:
        names = ", ".join(found.samples[:12]) + (" …" if len(found.samples) > 12 else "")
        facts.append(f"{len(found.samples)} recordings side by side ({names})")
    if found.separator:
        facts.append(f"separator {_MARKS.get(found.separator, found.separator)}")
    if found.decimal:
        facts.append(f"decimal {_MARKS.get(found.decimal, found.decimal)}")
    if found.encoding:
        facts.append(found.encoding)
    if found.header_row:
        facts.append(f"header in line {found.header_row}")
    if found.sampling_rate_Hz is not None:
        steps = "uniform" if found.is_uniform else "not uniform"
        facts.append(f"{number(found.sampling_rate_Hz, '.5g')} Hz, {steps}")
    return f"{found.file}: {', '.join(facts)}"


def _column_row(found: "Inspection", column: "ColumnSummary") -> tuple[str, ...]:
    holds = "whole numbers" if column.is_integer else "numbers" if column.is_numeric else "text"
    if column.name in found.saturation:
        holds += ", at a converter's limit"
    limits = ("" if limit is None else number(limit, ".6g") for limit in (column.minimum, column.maximum))
    return str(column.number), column.name, column.unit, *limits, str(column.n_missing or ""), holds


COMMAND = Command("inspect", inspect, "ropefric inspect run07.csv --write-profile import.toml", order=20)
