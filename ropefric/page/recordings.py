"""A folder of recordings as a new campaign, or an existing campaign: checked and corrected, then written."""

import csv
import json
import os
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from difflib import unified_diff
from hashlib import sha256
from math import nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ropefric.errors import DataError, InputError, Problem
from ropefric.files.disk import read_file, write_files
from ropefric.files.plain_text import csv_text, from_spreadsheet, to_spreadsheet
from ropefric.files.toml import TomlDocument, parse_toml
from ropefric.files.toml_edit import Keys, with_values
from ropefric.page.review import changed_meanwhile, decimated
from ropefric.page.work import Step
from ropefric.quantities import parse_quantity
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.inspection import Inspection, signals_of_cells, trace_as_it_is
from ropefric.traces.readers.profile import Channel, ImportProfile, channel_value
from ropefric.trials.campaign import TEMPLATES, examine_campaign, template_texts
from ropefric.trials.cells import read_cells, word_of
from ropefric.trials.extract import check_recordings
from ropefric.trials.proposal import Proposal, files_of, inspected, propose_campaign
from ropefric.trials.trial_list import list_from_names
from ropefric.trials.workers import Limits

MOST_PROBLEMS, MOST_LINES = 60, 200
"""Problems and changed lines that are shown on the page."""
_PROBLEM = ("severity", "code", "key", "message", "fix")
_NO_CHANNEL = Channel(column="")
_BOM = b"\xef\xbb\xbf"


class Wish(NamedTuple):
    """Statements of a person about recordings: folder, file names, columns, and what no file contains.

    `settings` are values of campaign.toml by their keys, "" where none is given; `cells` are the force cells of all
    recordings by the column of the list that names them.
    """

    recordings: str
    pattern: str
    channels: Mapping[str, Channel]
    settings: Mapping[Keys, Any]
    cells: Mapping[str, str]

    @property
    def known(self) -> ImportProfile:
        """Return how recordings are to be read, as far as it is stated."""
        stated = self.settings.items()
        known = {keys[-1]: value for keys, value in stated if value and keys[0] == "import"}
        if "sampling_rate" in known:
            rate_Hz = parse_quantity(known.pop("sampling_rate"), "Hz", name="the sampling rate")
            known["sampling_rate_Hz"] = rate_Hz
        channels = {name: one for name, one in self.channels.items() if one.column}
        return ImportProfile(channels=channels, **known)


def wish_of(tree: Mapping[str, Any]) -> Wish:
    """Return a wish as the page sends it: channels by name, settings in tables as campaign.toml has them."""
    channels = {name: Channel(**one) for name, one in tree.get("channels", {}).items()}
    cells = {column: name for column, name in tree.get("cells", {}).items() if name}
    settings = dict(_leaves(tree.get("settings", {})))
    return Wish(tree.get("recordings", ""), tree.get("pattern", ""), channels, settings, cells)


def _leaves(tables: Mapping[str, Any], above: Keys = ()) -> Iterator[tuple[Keys, Any]]:
    """Yield the values in tables, each with its keys."""
    for key, value in tables.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, (*above, key))
        else:
            yield (*above, key), value


class _Seen(NamedTuple):
    """Recordings as they are listed, how they are read, and the problems of them and of their campaign."""

    folder: Path
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    found: Inspection | None
    problems: Sequence[Problem]
    said: Sequence[str]


class Draft:
    """A campaign that is not written yet; `home` is the folder that it will be in.

    With `campaign`, a file, the settings of this campaign change; its list of trials stays.
    """

    def __init__(self, home: Path, campaign: Path | None = None) -> None:
        self.home, self.campaign = home, campaign
        self._read: tuple[Any, Any] | None = None
        self._seen: _Seen | None = None
        self._texts: dict[str, bytes] = {}
        self._there: dict[str, bytes] = {}
        self._own = b"" if campaign is None else read_file(campaign)
        self._first_channels: Mapping[str, Channel] | None = None

    @property
    def _document(self) -> TomlDocument:
        """Return the campaign file as it was in the beginning; an empty one of a new campaign."""
        return parse_toml(self._own, str(self.campaign), "campaign file")

    def form(self) -> dict[str, Any]:
        """Return the settings of the campaign as its file stated them in the beginning."""
        return dict(json.loads(json.dumps(self._document.data, default=str)))

    def propose(self, wish: Wish, progress: Step | None = None) -> dict[str, Any]:
        """Return columns, trials and problems of the recordings under a wish, and the lines that would change."""
        if not self.home.is_dir():
            raise DataError("there is no such folder", path=self.home, fix="make it, or choose another one")
        if self.campaign is not None and read_file(self.campaign) != self._own:
            raise changed_meanwhile(self.campaign)
        seen = self._revised(self.campaign, wish) if self.campaign else self._new(wish, progress)
        self._seen, self._there = seen, self._contents()
        channels = _shown_channels(seen.found)
        changes = (_difference(name, old, self._texts[name]) for name, old in self._there.items())
        return {
            "found": None if seen.found is None else seen.found.to_dict(),
            "channels": {name: asdict(one) for name, one in channels.items()},
            "said": seen.said,
            "header": seen.header,
            "rows": seen.rows,
            "problems": _counted(seen.problems)[:MOST_PROBLEMS],
            "there": [*self._there],
            "difference": "".join(changes),
            "shown": self.shown,
        }

    def _contents(self) -> dict[str, bytes]:
        """Return what now is in the files that would be written, of those that exist."""
        there = (name for name in self._texts if os.path.lexists(self.home / name))
        return {name: read_file(self.home / name) for name in there}

    def _new(self, wish: Wish, progress: Step | None) -> _Seen:
        """Return the recordings of a proposed campaign; they are read again only if the wish changes how."""
        read = (wish.recordings, wish.pattern, repr(wish.known), self.home)
        if self._read is None or self._read[0] != read:
            how: dict[str, Any] = {"known": wish.known, "progress": progress}
            self._read = read, propose_campaign(wish.recordings, wish.pattern, self.home, **how)
        proposal: Proposal = self._read[1]
        stated = {keys: value for keys, value in wish.settings.items() if value and keys[0] != "import"}
        header, *rows = csv.reader(proposal.trials.decode().splitlines())
        cells = {column: to_spreadsheet(name) for column, name in wish.cells.items() if column not in header}
        header, rows = [*header, *cells], [[*row, *cells.values()] for row in rows]
        listed = {TEMPLATES[1]: csv_text([header, *rows]).encode()}
        self._texts = template_texts(proposal.section, stated) | listed
        with tempfile.TemporaryDirectory(prefix="ropefric-") as folder:
            elsewhere = stated | {("data",): self.home.resolve().as_posix()}
            write_files(folder, template_texts(proposal.section, elsewhere) | listed)
            problems, _ = _examined(Path(folder, TEMPLATES[0]), None)
        rows = [[from_spreadsheet(cell) for cell in row] for row in rows]
        return _Seen(self.home, header, rows, proposal.found, problems, proposal.said)

    def _revised(self, path: Path, wish: Wish) -> _Seen:
        """Return the recordings of the existing campaign, read with its changed settings."""
        data, content = self._document.data, self._changed(wish)
        self._texts = {path.name: content} if content != self._own else {}
        problems, campaign = _examined(path, content)
        header, rows = _listed(self.home / str(data.get("trials", "")))
        folder, profile = self.home / str(data.get("data", ".")), campaign.profile if campaign else wish.known
        read: Inspection | str = "the list of trials names no recording"
        if rows and "file" in header:
            read = inspected([folder / rows[0][header.index("file")]], profile, Limits())
        found, said = (None, [read]) if isinstance(read, str) else (read, [])
        if self._first_channels is None and found is not None:
            self._first_channels = _shown_channels(found)
        return _Seen(folder, header, rows, found, problems, said)

    def _changed(self, wish: Wish) -> bytes:
        """Return the campaign file with the settings that a wish changes."""
        stated = dict(_leaves(self._document.data))
        settings = wish.settings.items()
        values = {keys: value or None for keys, value in settings if str(stated.get(keys, "")) != str(value)}
        values |= self._changed_channels(wish.channels)
        mark = _BOM if self._own.startswith(_BOM) else b""
        return mark + with_values(self._own.decode("utf-8-sig"), values).encode()

    def _changed_channels(self, wanted: Mapping[str, Channel]) -> dict[Keys, Any]:
        """Return the channels that differ from those the page showed first, as the campaign file has them."""
        shown = self._first_channels or {}
        changed = [name for name, one in wanted.items() if one != shown.get(name, _NO_CHANNEL)]
        stated, values = self._document.table("import", "channels"), dict[Keys, Any]()
        # Once one is stated, no other is found out.
        for name in wanted if changed and not stated else changed:
            value, own = channel_value(wanted[name]), stated.get(name)
            if isinstance(own, dict) and value:
                kept = {key: own[key] for key in ("time", "tare", "instead_of") if key in own}
                value = (value if isinstance(value, dict) else {"column": value}) | kept
            values["import", "channels", name] = value or None
        return values

    @property
    def shown(self) -> str:
        """Return what distinguishes the proposal that was shown last from any other one."""
        return sha256(repr([self.home, self._texts, self._there]).encode()).hexdigest()

    def write(self, shown: str, *, overwrite: bool) -> Path:
        """Write the proposal that was shown, and return the campaign file; replace no file without `overwrite`.

        Nothing is written if a file, or the proposal, is another one than was shown.
        """
        if self._seen is None:
            raise InputError("nothing is proposed yet", fix="look at the recordings first")
        if shown != self.shown or self._contents() != self._there:
            raise changed_meanwhile(self.campaign or self.home)
        written = write_files(self.home, self._texts, overwrite=overwrite)
        return self.campaign or written[0]

    def names(self, recordings: str, pattern: str) -> dict[str, Any]:
        """Return the list of trials that file names make by a pattern; no recording is read."""
        trials, missed = list_from_names(files_of(recordings), pattern, self.home)
        header, *rows = csv.reader(trials.decode().splitlines())
        return {"header": header, "rows": rows, "said": missed}

    def trace(self, number: int, columns: int) -> dict[str, Any]:
        """Return one recording of the list as it is drawn, before any tare: its force, and the end tension beside it."""
        if self._seen is None or self._seen.found is None:
            raise InputError("no recording is read yet", fix="look at the recordings first")
        row = dict(zip(self._seen.header, self._seen.rows[number], strict=True))
        profile = self._seen.found.profile
        raws = read_recordings(self._seen.folder / row["file"], profile, shown_as=row["file"])
        raw = next((one for one in raws if one.sample == row.get("sample", one.sample)), raws[0])
        trace, signals = trace_as_it_is(raw, profile), signals_of_cells(raw, profile)
        tree: dict[str, Any] = {"file": row["file"], "units": {}, "curves": {}}
        for name, force_N in (("force", trace.force_N), ("end_tension", trace.end_tension_N)):
            if force_N is not None:
                here = np.isfinite(force_N)
                tree["curves"][name] = decimated((trace.time_s[here], force_N[here], None), nan, nan, columns)
                tree["units"][name] = signals.get(name, "N" if trace.counts is None else "counts")
        return tree


def _listed(path: Path) -> tuple[list[str], list[list[str]]]:
    """Return the headers and rows of a list of trials; none if it cannot be read, which is among the problems."""
    try:
        table, _ = read_cells(path)
    except DataError:
        return [], []
    return [word_of(name) for name in table.header], [[*cells] for _, cells in table.rows]


def _examined(path: Path, content: bytes | None) -> tuple[tuple[Problem, ...], Any]:
    """Return what `ropefric check` says of a campaign, and the campaign, None where it cannot be read."""
    campaign, problems = examine_campaign(path, content=content)
    return (*problems, *(check_recordings(campaign)[1] if campaign is not None else ())), campaign


def _shown_channels(found: Inspection | None) -> dict[str, Channel]:
    """Return the channels of a recording, as far as the page has fields for them."""
    channels = {} if found is None else found.profile.channels
    names = ("column", "unit", "sensitivity")
    return {key: Channel(**{name: getattr(one, name) for name in names}) for key, one in channels.items()}


def _counted(problems: Iterable[Problem]) -> list[dict[str, Any]]:
    """Return each problem once, with its number of occurrences."""
    found = Counter(tuple(getattr(one, name) for name in _PROBLEM) for one in problems)
    return [dict(zip(_PROBLEM, one, strict=True)) | {"times": n} for one, n in found.items()]


def _difference(name: str, before: bytes, after: bytes) -> str:
    """Return the lines of a file that would change, with those beside them."""
    old, new = (text.decode("utf-8-sig", "replace").splitlines(True) for text in (before, after))
    lines = [*unified_diff(old, new, name, name, n=1)]
    more = [f"… and {len(lines) - MOST_LINES} more lines\n"] if len(lines) > MOST_LINES else []
    return "".join(lines[:MOST_LINES] + more)
