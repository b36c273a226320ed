"""A campaign begun from its recordings: the import profile that reads them, and a row of the list for each of them."""

import csv
import glob
import os
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

from ropefric.errors import RopefricError
from ropefric.files.plain_text import csv_text, from_spreadsheet, to_spreadsheet
from ropefric.glossary import counted
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.inspection import Inspection, inspect_file
from ropefric.traces.readers.profile import ImportProfile, profile_to_toml
from ropefric.trials.trial_list import list_from_names
from ropefric.trials.workers import Limits, Lost, guarded

Progress = Callable[[int, int, str], None]
_SHOWN = 3
_OPEN = ImportProfile()


class Proposal(NamedTuple):
    """A list of trials, the section that reads their recordings, "" where none was found, and what was assumed.

    `found` is what was seen in one of the files, None where none opens.
    """

    trials: bytes
    section: str
    said: tuple[str, ...]
    found: Inspection | None = None


def propose_campaign(
    recordings: str,
    pattern: str,
    folder: Path,
    limits: Limits | None = None,
    *,
    known: ImportProfile = _OPEN,
    progress: Progress | None = None,
) -> Proposal:
    """Return a proposed campaign from the files of a folder or glob pattern; each file is read.

    What the profile that is known leaves open is found out. A row is one recording: a file with several has several
    rows. No file is left out of the list because it cannot be read; that is said.
    """
    trials, missed = list_from_names(files_of(recordings), pattern, folder)
    header, *rows = csv.reader(trials.decode().splitlines())
    # The folder need not be there yet.
    files = (from_spreadsheet(row[header.index("file")]) for row in rows)
    paths = [Path(os.path.normpath(folder / file)) for file in files]
    usual = Counter(path.suffix.lower() for path in paths).most_common(1)[0][0]
    alike = [path for path in paths if path.suffix.lower() == usual]
    found = inspected(alike, known, limits or Limits())
    of_names = (missed,) if missed else ()
    if isinstance(found, str):
        return Proposal(trials, "", (*of_names, f"{alike[0].name} cannot be read: {found}"))
    samples, unread, profile = _read_by(paths, found.profile, limits or Limits(), progress)
    found = replace(found, profile=profile)
    read = f"read {found.read}, from {found.file}" if found.read else f"{found.file}: {found.stopped}"
    said = (read, *(f"assumed: {doubt}" for doubt in found.doubts), *unread)
    comments = [f"# {line}" for line in said]
    section = "\n".join(["# How to read the recordings, found out from them:", *comments, ""])
    section += profile_to_toml(found.profile)
    return Proposal(_with_samples(header, rows, samples) or trials, section, of_names + said, found)


def _with_samples(
    header: Sequence[str], rows: Sequence[Sequence[str]], samples: Sequence[Sequence[str]]
) -> bytes:
    """Return a list with a row for each recording of a file; nothing where no file has several."""
    if not any(len(names) > 1 for names in samples):
        return b""
    place = header.index("file") + 1
    table = [[*header[:place], "sample", *header[place:]]]
    for row, names in zip(rows, samples, strict=True):
        table += [[*row[:place], to_spreadsheet(name), *row[place:]] for name in names]
    return csv_text(table).encode()


def files_of(recordings: str) -> str:
    """Return the glob pattern of a folder's files, or the one that is given."""
    return f"{glob.escape(recordings.rstrip('/'))}/*" if Path(recordings).is_dir() else recordings


def _read_by(
    paths: Sequence[Path], profile: ImportProfile, limits: Limits, progress: Progress | None
) -> tuple[list[tuple[str, ...]], list[str], ImportProfile]:
    """Return what `_samples_of` does and the profile, without its row numbers if more files are read by names alone."""
    samples, unread = _samples_of(paths, profile, limits, progress)
    if unread and all(isinstance(channel.column, str) for channel in profile.channels.values()):
        by_names = replace(profile, header_row=-1, units_row=0, data_row=0)  # heads differ in length
        again, less = _samples_of(paths, by_names, limits, progress)
        if len(less) < len(unread):
            return again, less, by_names
    return samples, unread, profile


def _samples_of(
    paths: Sequence[Path], profile: ImportProfile, limits: Limits, progress: Progress | None
) -> tuple[list[tuple[str, ...]], list[str]]:
    """Return the names of the recordings of each file, and what to say of those that are not read."""
    samples: list[tuple[str, ...]] = [("",)] * len(paths)
    wrong: dict[str, list[str]] = {}
    running = guarded(partial(_samples, paths, profile), len(paths), limits=limits)
    for done, (number, read) in enumerate(running, start=1):
        if progress is not None:
            progress(done, len(paths), paths[number].name)
        if isinstance(read, str | Lost):
            wrong.setdefault(read.reason if isinstance(read, Lost) else read, []).append(paths[number].name)
        else:
            samples[number] = read
    unread = []
    for why, some in wrong.items():
        shown = ", ".join(some[:_SHOWN]) + (", …" if len(some) > _SHOWN else "")
        unread.append(f"{counted(len(some), 'file')} of {len(paths)} not read with it: {shown}: {why}")
    return samples, unread


def inspected(paths: Sequence[Path], known: ImportProfile, limits: Limits) -> Inspection | str:
    """Return the first of some files whose own proposal reads it, else the first that opens, or why none does."""
    some = list(dict.fromkeys((paths[0], paths[len(paths) // 2], paths[-1])))
    opened: list[Inspection] = []
    why: list[str] = []
    for _, found in guarded(partial(_inspect, some, known), len(some), limits=limits):
        if isinstance(found, Inspection):
            opened.insert(0 if found.read else len(opened), found)
        else:
            why.append(found if isinstance(found, str) else found.reason)
    return opened[0] if opened else why[0]


def _inspect(paths: Sequence[Path], known: ImportProfile, number: int) -> Inspection | str:
    try:
        return inspect_file(paths[number], known, shown_as=paths[number].name)
    except RopefricError as error:
        return error.problem.message


def _samples(paths: Sequence[Path], profile: ImportProfile, number: int) -> tuple[str, ...] | str:
    """Return the names of the recordings of a file, or why it is not read."""
    try:
        return tuple(
            raw.sample for raw in read_recordings(paths[number], profile, shown_as=paths[number].name)
        )
    except RopefricError as error:
        return error.problem.message
