"""`ropefric inspect`: what is in a recording file, and the import profile that would read it."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ropefric.cli.command import Answer, Command
from ropefric.cli.looks import show_inspection
from ropefric.cli.output import Output
from ropefric.cli.quantity_option import read_quantity
from ropefric.errors import DataError, InputError
from ropefric.files.write import refuse_input, refuse_special, write_file

if TYPE_CHECKING:
    from collections.abc import Callable

    from rich.console import Console

    from ropefric.traces.readers.inspection import Inspection
    from ropefric.traces.readers.profile import ImportProfile
    from ropefric.trials.workers import Limits


RecordingFile = Annotated[Path, typer.Argument(metavar="FILE", help="A recording.")]
Format = Annotated[
    str,
    typer.Option(
        "--format", metavar="NAME", help="How it is written, where its name does not tell: delimited, …"
    ),
]
Destination = Annotated[
    Path | None,
    typer.Option("--write-profile", metavar="PATH", help="Write the suggested \\[import] section there."),
]
Force = Annotated[bool, typer.Option("--force", help="Write over a file that is already there.")]
Everything = Annotated[
    bool, typer.Option("--all", help="Read a large text whole, not only its first and last megabyte.")
]
Memory = Annotated[str, typer.Option(metavar="QUANTITY", help="Most memory that reading it may take [2 GB].")]
Time = Annotated[str, typer.Option(metavar="QUANTITY", help="Most time that reading it may take [120 s].")]


def inspect(
    out: Output,
    file: RecordingFile,
    *,
    file_format: Format = "auto",
    write_profile: Destination = None,
    force: Force = False,
    everything: Everything = False,
    memory: Memory = "",
    time: Time = "",
) -> Answer:
    """Look at a recording: columns, units, ranges, first rows, doubts, and the profile to read it with.

    Paste the section into campaign.toml, after checking the doubts.
    """
    from ropefric.traces.readers.profile import ImportProfile, profile_to_toml  # noqa: PLC0415  (quick start-up)

    if file.is_dir():
        raise DataError("this is a folder, not a recording", path=file, fix=_fix_of_folder(file))
    if write_profile is not None:  # before the work
        _check_target(write_profile, file, force=force)
    found = _look(
        partial(_inspect, file, ImportProfile(format=file_format), everything), file, _limits(memory, time)
    )
    profile = profile_to_toml(found.profile)
    if write_profile is not None:
        write_file(write_profile, profile)
        out.note(f"wrote {write_profile}")

    def show(console: "Console") -> None:
        show_inspection(found, console)
        console.print("\nsuggested for campaign.toml:\n", style="bold")
        console.print(profile.rstrip(), markup=False, soft_wrap=True)

    return Answer(data=found.to_dict(), show=show)


def _limits(memory: str, time: str) -> "Limits":
    from ropefric.trials.workers import Limits  # noqa: PLC0415  (all of these: quick start-up)

    given: dict[str, float] = {}
    if memory:
        given["memory_bytes"] = read_quantity(memory, "byte", "--memory")
    if time:
        given["time_s"] = read_quantity(time, "s", "--time")
    return Limits(**given)


def _look(inspect_it: "Callable[[int], Inspection]", file: Path, limits: "Limits") -> "Inspection":
    """Return what is found out about a file, by a process that may die of it."""
    from ropefric.trials.workers import Lost, guarded  # noqa: PLC0415

    ((_, found),) = guarded(inspect_it, 1, limits=limits)
    if isinstance(found, Lost):
        raise DataError(found.reason, code="RF101", path=file, fix=found.fix)
    return found


def _inspect(file: Path, profile: "ImportProfile", everything: bool, _: int) -> "Inspection":  # noqa: FBT001
    from ropefric.traces.readers.inspection import inspect_file  # noqa: PLC0415

    return inspect_file(file, profile, everything=everything)


def _fix_of_folder(folder: Path) -> str:
    """Return what to name instead of a folder; a campaign's recordings are looked at by other commands."""
    if (folder / "campaign.toml").is_file():
        return f"name one file of it; `ropefric check {folder}` looks at the campaign"
    names = sorted(path.name for path in folder.iterdir() if path.is_file() and not path.name.startswith("."))
    return f"name one file of it, such as {names[0]}" if names else "name a file; this folder holds none"


def _check_target(path: Path, recording: Path, *, force: bool) -> None:
    refuse_special(path)
    refuse_input(path, recording)
    if path.exists() and not force:
        raise InputError(
            "the file is there already", code="RF150", path=path, fix="choose another name, or add --force"
        )


COMMAND = Command(
    name="inspect", run=inspect, example="ropefric inspect run07.csv --write-profile import.toml", order=20
)
