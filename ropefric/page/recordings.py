"""A folder of recordings as a campaign that is proposed, looked at, corrected, and only then written."""

import csv
import json
import re
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ropefric.errors import DataError, InputError, Problem
from ropefric.files.disk import write_files
from ropefric.page.review import decimated
from ropefric.quantities import parse_quantity
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.inspection import as_signals, trace_as_it_is
from ropefric.traces.readers.profile import Channel, ImportProfile
from ropefric.trials.campaign import TEMPLATES, examine_campaign, template_texts
from ropefric.trials.extract import check_recordings
from ropefric.trials.proposal import Proposal, files_of, propose_campaign
from ropefric.trials.trial_list import list_from_names

Progress = Callable[[int, int, str], None]
MOST_ROWS = 5000
"""Of a list of trials, on the page."""
_OWN_FOLDER = 'data   = "."'
HEADERS = (
    "wheel",
    "wheel_radius_mm",
    "wrap_angle_deg",
    "wrap_turns",
    "end_tension_N",
    "end_mass_kg",
    "repeat",
    "*",
)
"""Quantities that file names often contain, as headers of a list of trials have it; \"*\" stands for anything else."""
_TOLD = ("severity", "code", "key", "message", "fix")
_BARE = re.compile(r"[A-Za-z0-9_-]+")
_TABLE_KEYS = ("format", "recording_column", "channel_column", "value_column")


class Wish(NamedTuple):
    """Statements of a person about recordings: folder, file names, columns, and what no file contains."""

    recordings: str
    pattern: str
    known: ImportProfile
    settings: Mapping[str, Mapping[str, str]]


def wish_of(tree: Mapping[str, Any]) -> Wish:
    """Return a wish as the page sends it; what is empty is left to be found out."""
    channels = {
        name: Channel(
            column=_column(one["column"]), unit=one.get("unit", ""), sensitivity=one.get("sensitivity", "")
        )
        for name, one in tree.get("channels", {}).items()
        if one.get("column")
    }
    known: dict[str, Any] = {name: tree[name] for name in _TABLE_KEYS if tree.get(name)}
    if tree.get("sampling_rate"):
        known["sampling_rate_Hz"] = parse_quantity(tree["sampling_rate"], "Hz", name="the sampling rate")
    settings = {
        table: {key: json.dumps(value, ensure_ascii=False) for key, value in keys.items() if value}
        for table, keys in tree.get("settings", {}).items()
    }
    settings = {_table(name): keys for name, keys in settings.items() if keys}
    return Wish(
        tree["recordings"], tree.get("pattern", ""), ImportProfile(channels=channels, **known), settings
    )


def _table(name: str) -> str:
    """Return the name of a table as TOML writes it: a wheel may be called as its user likes."""
    kind, dot, own = name.partition(".")
    return name if not dot or _BARE.fullmatch(own) else f"{kind}.{json.dumps(own, ensure_ascii=False)}"


def _column(text: str) -> str | int:
    """Return a column by its header, or by its number where the page says "#3"."""
    return int(text[1:]) if text.startswith("#") and text[1:].isdecimal() else text


class Draft:
    """A campaign that is not written yet; `home` is the folder that it will stand in."""

    def __init__(self, home: Path) -> None:
        self.home = home
        self._read: tuple[Any, Proposal] | None = None
        self._texts: dict[str, bytes] = {}

    def propose(self, wish: Wish, progress: Progress | None = None) -> dict[str, Any]:
        """Return what the recordings and the wish make: columns, list of trials, and what contradicts or is missing."""
        if not self.home.is_dir():
            raise DataError("there is no such folder", path=self.home, fix="make it, or choose another one")
        read = (wish.recordings, wish.pattern, repr(wish.known), self.home)
        if self._read is None or self._read[0] != read:
            how: dict[str, Any] = {"known": wish.known, "progress": progress}
            self._read = read, propose_campaign(wish.recordings, wish.pattern, self.home, **how)
        proposal = self._read[1]
        self._texts = template_texts(proposal.section, wish.settings)
        self._texts[TEMPLATES[1]] = proposal.trials
        header, *rows = csv.reader(proposal.trials.decode().splitlines())
        found = proposal.found
        wheels = header.index("wheel") if "wheel" in header else -1
        return {
            "found": None if found is None else found.to_dict(),
            "channels": {} if found is None else _channels(found.profile),
            "section": proposal.section,
            "said": list(proposal.said),
            "header": header,
            "rows": rows[:MOST_ROWS],
            "n_rows": len(rows),
            "wheels": sorted({row[wheels] for row in rows if wheels >= 0 and row[wheels]}),
            "problems": [{name: getattr(one, name) for name in _TOLD} for one in self._problems()],
            "there": [name for name in TEMPLATES if (self.home / name).exists()],
        }

    def _problems(self) -> tuple[Problem, ...]:
        """Return what `ropefric check` would say of the campaign, were it written."""
        with tempfile.TemporaryDirectory(prefix="ropefric-") as folder:
            texts = dict(self._texts)
            data = f"data   = {json.dumps(self.home.resolve().as_posix(), ensure_ascii=False)}"
            texts[TEMPLATES[0]] = texts[TEMPLATES[0]].replace(_OWN_FOLDER.encode(), data.encode(), 1)
            write_files(folder, texts)
            campaign, problems = examine_campaign(Path(folder, TEMPLATES[0]))
            unread = check_recordings(campaign)[1] if campaign is not None else ()
        return (*problems, *unread)

    def write(self, *, overwrite: bool) -> Path:
        """Write what was proposed last, and return the campaign file; another one is replaced only if that is said."""
        if not self._texts:
            raise InputError("nothing is proposed yet", fix="look at the recordings first")
        return write_files(self.home, self._texts, overwrite=overwrite)[0]

    def names(self, recordings: str, pattern: str) -> dict[str, Any]:
        """Return the list of trials that file names make by a pattern; no recording is read."""
        trials, told = list_from_names(files_of(recordings), pattern, self.home)
        header, *rows = csv.reader(trials.decode().splitlines())
        return {"header": header, "rows": rows[:MOST_ROWS], "n_rows": len(rows), "told": told}

    def trace(self, number: int, start_s: float, stop_s: float, columns: int) -> dict[str, Any]:
        """Return one recording of the list as it is drawn, before any tare: its force, and the end tension beside it."""
        proposal = None if self._read is None else self._read[1]
        if proposal is None or proposal.found is None:
            raise InputError("no recording is read yet", fix="look at the recordings first")
        header, *rows = csv.reader(proposal.trials.decode().splitlines())
        row = dict(zip(header, rows[number], strict=True))
        profile, signals = as_signals(proposal.found.profile)
        raws = read_recordings(self.home / row["file"], profile, shown_as=row["file"])
        raw = next((one for one in raws if one.sample == row.get("sample", one.sample)), raws[0])
        trace = trace_as_it_is(raw, profile)
        curves = {"force": trace.force_N}
        if trace.end_tension_N is not None:
            curves["end_tension"] = trace.end_tension_N
        tree: dict[str, Any] = {"file": row["file"], "units": {}, "curves": {}}
        for name, force_N in curves.items():
            here = np.isfinite(force_N)
            tree["curves"][name] = decimated(
                (trace.time_s[here], force_N[here], None), start_s, stop_s, columns
            )
            tree["units"][name] = signals.get(name, "N" if trace.counts is None else "counts")
        return tree


def _channels(profile: ImportProfile) -> dict[str, dict[str, str]]:
    """Return the channels of a profile as the page's fields hold them."""
    return {
        name: {
            "column": f"#{one.column}" if isinstance(one.column, int) else one.column,
            "unit": one.unit,
            "sensitivity": one.sensitivity,
        }
        for name, one in profile.channels.items()
    }
