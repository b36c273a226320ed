"""The trial list: rows of trials.csv as `TrialSpec`, with all that is wrong or doubtful; and a list made from names."""

import glob
import math
import os
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial
from itertools import chain, count
from pathlib import Path, PurePath, PurePosixPath
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError, InputError, Problem, data_error
from ropefric.files.disk import kind_of_file
from ropefric.files.plain_text import csv_text, to_spreadsheet
from ropefric.files.toml_edit import toml_key
from ropefric.friction.condition import condition_groups
from ropefric.glossary import counted
from ropefric.registry import did_you_mean
from ropefric.trials import cells
from ropefric.trials.campaign_model import DECISIONS, CampaignFile, Protocol, TrialSpec
from ropefric.trials.decisions import Decision, read_decisions

MISSING_RECORDING = "RF124"
"""Code of the problem that a recording is not there."""
FEWEST_REPEATS = 6

TEXTS = ("trial", "file", "sample", "wheel", "cell", "end_cell", "rope_id", "exclude", "note", "why", "by")
QUANTITIES = {
    **cells.SETTINGS,
    "lift_force": ("lift_force_N", "N", 1.0),
    "lift_mass": ("lift_force_N", "kg", cells.STANDARD_GRAVITY_M_S2),
    "dwell": ("dwell_s", "s", 1.0),
    "from": ("start_s", "s", 1.0),
    "until": ("stop_s", "s", 1.0),
    "pick": ("pick_s", "s", 1.0),
}
_DECIDED = {"peak": ("peak_N", "N", 1.0), "peak_std": ("peak_std_N", "N", 1.0)}
"""Known only beside `why` and `by`: a table of results, which has them too, serves as a list."""
_MEANINGS = {
    **cells.POSITIVE,
    "file": "the recording it was made of",
    "lift_force_N": "the known tight-side tension, for the sensor measures the slack side",
    "cell": "a force cell, for its force is in counts, V or mV/V",
    "end_cell": "the force cell of its slack side, whose signal is in counts, V or mV/V",
}


class _Row:
    """One row of the trial list as far as it can be read, and its errors."""

    def __init__(
        self, table: cells.CellTable, columns: cells.Columns, place: int, numbers: cells.Numbers
    ) -> None:
        self.table, self.columns = table, columns
        self.line, self.cells = table.rows[place]
        self.texts, self.numbers = table.texts(columns, self.cells), cells.given_numbers(numbers, place)
        self.problems: list[Problem] = []
        # Lists written on Windows name folders with backslashes.
        self.file, self.sample = self.texts.get("file", "").replace("\\", "/"), self.texts.get("sample", "")
        self.name = self.texts.get("trial", "")
        self.decided: tuple[Decision, cells.CellTable] | None = None

    def decide(self, decision: Decision, of: cells.CellTable) -> None:
        """Let a decision stand in place of what the row itself says."""
        if decision.peak_N is None or not math.isclose(self.numbers.get("peak_N", 0.0), decision.peak_N):
            self.numbers.pop("peak_std_N", None)
        for name in ("pick_s", "peak_N"):
            self.numbers.pop(name, None)
        given = {"pick_s": decision.pick_s, "peak_N": decision.peak_N}
        self.numbers |= {name: value for name, value in given.items() if value is not None}
        self.texts |= {name: getattr(decision, name) for name in ("exclude", "why", "by", "when")}
        if decision.is_empty:
            self.texts["by"] = self.texts["when"] = ""
        self.decided = decision, of

    def doubt(self, name: str, code: str, message: str, fix: str) -> None:
        """Record an error of a decision where that stands."""
        if self.decided is None:
            self.say(name, code, message, fix)
        else:
            decision, table = self.decided
            self.problems.append(table.problem(decision.line, name, code, message, fix))

    def say(self, name: str, code: str, message: str, fix: str, *, warning: bool = False) -> None:
        """Record an error of a column."""
        key = self.columns[name].header if name in self.columns else name
        self.problems.append(self.table.problem(self.line, key, code, message, fix, warning=warning))

    def need(self, *names: str) -> None:
        """Take note of cells that are empty."""
        for name in names:
            if name in self.columns and not self.cells[self.columns[name].index]:
                meaning = _MEANINGS["wheel_radius_m" if name == "wheel" else name]
                what = f"{self.columns[name].header} is empty; every trial needs {meaning}"
                self.say(name, "RF121", what, "fill the cell")


def read_trials(
    path: str | os.PathLike[str], folder: Path, campaign: CampaignFile, needed: Sequence[str]
) -> tuple[tuple[TrialSpec, ...], tuple[Problem, ...]]:
    """Return the rows of a list about recordings in a folder, and all that is wrong.

    Of wrong rows, whose recordings can yet be looked at, unknown numbers are NaN.
    `needed` are the columns that must be there beside file, wheel and wrap: a tension, and force cells.
    """
    try:
        table, torn = cells.read_cells(path)
    except DataError as error:
        return (), error.problems
    decided = _DECIDED if {"why", "by"} <= {*map(cells.word_of, table.header)} else {}
    columns, others, refused = table.bind({**QUANTITIES, **decided}, TEXTS)
    problems = [*torn, *refused, *_check_header(table, columns, others, None if refused else needed)]
    if not torn and not table.rows:
        message, fix = "the table has a header, but no trials", "add a row for every recording"
        problems.append(table.problem(table.header_line, "", "RF101", message, fix))
    numbers, wrong = table.numbers(columns)
    rows = [_Row(table, columns, place, numbers) for place in range(len(table.rows))]
    _refuse_twice(rows)
    if kind_of_file(folder) == "folder":
        _refuse_missing(rows, folder)
    _name(rows)
    problems += _decide(rows, Path(path).with_name(DECISIONS))
    for place, row in enumerate(rows):
        row.problems += wrong[place]
        _check(row, campaign, needed, wrong_header=bool(refused))
        problems += row.problems
    trials = tuple(_trial(row, others, folder, campaign) for row in rows if row.file)
    return trials, tuple(sorted(problems, key=lambda p: p.line or math.inf))


def _decide(rows: Sequence[_Row], path: Path) -> Iterator[Problem]:
    """Carry out the decisions beside the list; yield their errors, and those of no trial of the list."""
    made, table, problems = read_decisions(path)
    yield from problems
    named = {row.name: row for row in rows}
    for name, decision in made.items():
        row = named.get(name)
        if row is None:
            message, fix = f"there is no trial '{name}' in the list", "correct the name, or remove the line"
            yield table.problem(decision.line, "trial", "RF120", f"{message}: not used", fix, warning=True)
        elif decision.file not in {"", row.file, row.texts["file"]}:
            message = f"this was decided about {decision.file}, but the trial '{name}' is now {row.file}"
            fix = "give each row of the list a name of its own in the column trial, and correct or remove this line"
            yield table.problem(decision.line, "file", "RF111", message, fix)
        else:
            row.decide(decision, table)


def _check_decision(row: _Row, *, alone: bool) -> None:
    """Take note of what a decision lacks or has twice; `alone`: the only trial of its recording."""
    given = [name for name in ("pick_s", "peak_N") if name in row.numbers]
    if "peak_std_N" in row.numbers and "peak_N" not in given:
        row.doubt("peak_std_N", "RF121", "there is no peak_N that it belongs to", "add it")
    if not given:
        return
    if len(given) > 1:
        row.doubt("peak_N", "RF111", "pick_s and peak_N are both given", "leave one of the two cells empty")
    for name in ("peak_N", "peak_std_N"):
        value_N = row.numbers.get(name, 1.0)
        if value_N < 0.0 or (name == "peak_N" and value_N == 0.0):
            row.doubt(name, "RF110", f"{value_N:g} N is no possible value", "correct the number")
    for name, what in (("why", "its reason"), ("by", "who took it")):
        if not row.texts.get(name):
            row.doubt(name, "RF121", f"a decision needs {what}", f"fill the column {name}")
    if not alone:
        message = "one decision cannot stand for several trials of a recording"
        fix = 'list each block by its name, with protocol "breakaway", or cut the recording with from_s and until_s'
        row.doubt(given[0], "RF111", message, fix)


def _check_header(
    table: cells.CellTable, columns: cells.Columns, others: Sequence[str], asked: Sequence[str] | None
) -> Iterator[Problem]:
    """Yield that columns of those `asked` for are missing, and likely meanings of unknown ones."""
    needed = {"file": "file", "wrap_angle_rad": "wrap_angle_deg"} | {name: name for name in asked or ()}
    if not {"wheel", "wheel_radius_m"} & columns.keys():
        needed["wheel_radius_m"] = "wheel_radius_mm (or wheel, with names from [wheels])"
    for name, header in needed.items() if asked is not None else ():
        if name in columns:
            continue
        message = f"there is no column {header}; every trial needs {_MEANINGS[name]}"
        key, fix = (
            header.split(maxsplit=1)[0],
            f"add the column {header}, or correct the name of the one that holds it",
        )
        yield table.problem(table.header_line, key, "RF121", message, fix)
    for name in others:
        yield from table.near_miss(name, QUANTITIES, TEXTS)
        if cells.stem_of(name) == "peak":
            fix = "add the columns why and by, if it is a decision about the break-away"
            yield table.problem(table.header_line, name, "RF141", "kept, but not used", fix, warning=True)
    yield from _unnamed_columns(table)


def _unnamed_columns(table: cells.CellTable) -> Iterator[Problem]:
    """Yield a problem for every column without a name that holds something."""
    for index, name in enumerate(table.header):
        held = next((row for row in table.rows if not name and row[1][index]), None)
        if held is not None:
            message = f"column {index + 1} has no name, but holds '{held[1][index][:60]}'"
            fix = "name it; a column whose name starts with '_' is ignored"
            yield table.problem(held[0], "", "RF120", message, fix)


def _interval(row: _Row, protocol: Protocol) -> tuple[float | None, float | None]:
    return row.numbers.get("start_s", protocol.start_s), row.numbers.get("stop_s", protocol.stop_s)


def _check(row: _Row, campaign: CampaignFile, needed: Sequence[str], *, wrong_header: bool) -> None:
    """Record missing, unknown or contradictory values of a row."""
    row.need("file", "wrap_angle_rad", *needed)
    for name, known in _described(campaign).items():
        if (word := row.texts.get(name, "")) and word not in known:
            fix = f"describe it under [{name.removeprefix('end_')}s.{toml_key(word)}] in the campaign file"
            fix = did_you_mean(word[:80], known) if known else fix
            row.say(name, "RF120", f"unknown {name} '{word}'", fix)
    _check_wheel(row, campaign, wrong_header=wrong_header)
    _check_interval(row, campaign.protocol)
    _check_decision(row, alone=campaign.protocol.name == "breakaway" and row.sample != "*")


def _described(campaign: CampaignFile) -> dict[str, Mapping[str, Any]]:
    """Return what the campaign file describes, by the column that names it."""
    return {"wheel": campaign.wheels, "cell": campaign.cells, "end_cell": campaign.cells}


def _check_interval(row: _Row, protocol: Protocol) -> None:
    """Take note of a part of the recording that ends before it begins."""
    start_s, stop_s = _interval(row, protocol)
    if start_s is not None and stop_s is not None and not start_s < stop_s:
        place = "stop_s" if "stop_s" in row.columns else "start_s"
        message = f"the part from {start_s:g} s until {stop_s:g} s is empty"
        row.say(place, "RF111", message, "give an end after the start")


def _check_wheel(row: _Row, campaign: CampaignFile, *, wrong_header: bool) -> None:
    """Take note of a wheel that is neither named nor measured, or both and not alike."""
    wheel, radius_m = row.texts.get("wheel", ""), row.numbers.get("wheel_radius_m")
    known_m = campaign.wheels[wheel].radius_m if wheel in campaign.wheels else None
    if not wheel and radius_m is None and not wrong_header:
        row.need("wheel_radius_m" if "wheel_radius_m" in row.columns else "wheel")
    elif radius_m and known_m and not math.isclose(radius_m, known_m, rel_tol=1e-6):
        message = f"the radius is {radius_m * 1e3:g} mm, but wheel '{wheel}' has {known_m * 1e3:g} mm"
        row.say("wheel_radius_m", "RF111", message, "correct one, or leave one of the two cells empty")


def _trial(row: _Row, own: Sequence[str], folder: Path, campaign: CampaignFile) -> TrialSpec:
    """Return a row in SI, with NaN for what a wrong one lacks; the user's `own` columns are kept, but not used."""
    start_s, stop_s = _interval(row, campaign.protocol)
    wheel, described = campaign.wheels.get(row.texts.get("wheel", "")), _described(campaign)
    settings = {
        "wheel_radius_m": wheel.radius_m if wheel else math.nan,
        "rope_radius_m": campaign.rope.radius_m,
        "wrap_angle_rad": math.nan,
    }
    texts = {name: text for name, text in row.texts.items() if text in described.get(name, (text,))}
    given: dict[str, Any] = {**settings, **texts, **row.numbers}
    given |= {"trial": row.name, "start_s": start_s, "stop_s": stop_s}
    kept = tuple((name, row.cells[row.table.header.index(name)]) for name in own)
    return TrialSpec(**given, path=folder / row.file, line=row.line, own=kept)


# --- recordings and names ---


def _refuse_missing(rows: Sequence[_Row], folder: Path) -> None:
    """Take note of recordings that are not there, or are no files; as warnings where the trial is excluded."""
    kinds = {file: kind_of_file(folder / file) for file in {row.file: 0 for row in rows} if file}
    for row in rows:
        kind = kinds.get(row.file, "file")
        if kind == "file":
            continue
        message = f"the recording {row.texts['file']} is not there"
        fix = f"put it into {folder.as_posix()}, correct the name, or the key 'data' of the campaign file"
        if kind == "device or pipe":
            message = f"the recording {row.texts['file']} is a device or pipe, not a file"
            fix = "write its content to a file, and name that"
        elif row.file.startswith("#"):
            fix = "put comments above the header; below it every line is a trial"
        row.say("file", MISSING_RECORDING, message, fix, warning=bool(row.texts.get("exclude")))


def _refuse_twice(rows: Sequence[_Row]) -> None:
    """Take note of recordings listed twice; parts that do not overlap in time are different trials."""
    # '*' takes every block, so beside it no block is another recording.
    whole = {row.file for row in rows if row.sample == "*"}
    groups: dict[tuple[str, str], list[_Row]] = {}
    for row in rows:
        if row.file:
            groups.setdefault((row.file, "*" if row.file in whole else row.sample), []).append(row)
    for (file, _), group in groups.items():
        latest_s, latest = -math.inf, group[0]
        for row in sorted(group, key=lambda row: (row.numbers.get("start_s", -math.inf), row.line)):
            stop_s = row.numbers.get("stop_s", math.inf)
            if row.numbers.get("start_s", -math.inf) < latest_s:
                first, second = sorted((latest, row), key=lambda item: item.line)
                what = f"block '{second.sample}' of " if second.sample else ""
                fix = "remove one row, or give each its own part of the recording with from_s and until_s"
                if file in whole:
                    fix = "remove one row; the sample '*' takes every block of the file"
                message = f"{what}{second.texts['file']} is listed in line {first.line} already"
                second.say("file", "RF122", message, fix)
            if stop_s > latest_s:
                latest_s, latest = stop_s, row


def free_name(name: str, taken: Collection[str]) -> str:
    """Return a name, with a number where it is taken."""
    return next(one for one in chain((name,), (f"{name}-{n}" for n in count(2))) if one not in taken)


def _name(rows: Sequence[_Row]) -> None:
    """Give every row a name of its own, and take note of names given twice.

    A row without a name is called after its file, with the block where there is one, and a number where that
    name is taken.
    """
    taken, first = {row.name for row in rows}, dict[str, int]()
    for row in rows:
        if not row.name:
            stem = PurePosixPath(PurePosixPath(row.file).name.removesuffix(".gz")).stem
            block = f"#{row.sample}" if row.sample not in {"", "*"} else ""
            row.name = free_name(f"{stem}{block}" or "trial", taken)
            taken.add(row.name)
        elif (line := first.setdefault(row.name, row.line)) != row.line:
            message = f"the name '{row.name}' is given in line {line} already"
            row.say("trial", "RF122", message, "give every trial its own name, or leave the cell empty")


MOST_TURNS = 20
"""90 degrees that are taken for radians are 14 turns, 180 degrees 29."""

# --- what is doubtful in a list without errors, or cannot be learned from it: said once for the whole list ---


def radius_doubt(radius_m: float) -> str:
    """Return why a wheel radius is probably in another unit; "" if it is plausible."""
    if 1e-3 <= radius_m <= 10.0:
        return ""
    return f"a wheel radius of {radius_m:g} m is outside 1 mm to 10 m, probably in another unit"


def advise(trials: Sequence[TrialSpec], path: str, *, rule: str, one_trial_each: bool) -> tuple[Problem, ...]:
    """Return warnings about a trial list without errors."""
    used = [trial for trial in trials if not trial.exclude]
    warn = partial(Problem, path=path, severity="warning")
    doubts = [
        warn(code="RF140", message=message, line=trial.line, key=key, fix=fix)
        for trial in trials
        for key, message, fix in _doubts_of(trial)
    ]
    doubts += _nothing_hung(used, warn)
    if used and rule == "two-sigma" and one_trial_each and all(trial.sample != "*" for trial in used):
        doubts += _few_repeats(used, warn)
    return tuple(sorted(doubts, key=lambda doubt: (doubt.line or 0, doubt.code, doubt.key)))


_Warn = Callable[..., Problem]


def _doubts_of(trial: TrialSpec) -> Iterator[tuple[str, str, str]]:
    """Yield column, warning and fix of a row."""
    wheel_m, rope_m = trial.wheel_radius_m, trial.rope_radius_m
    if not trial.wheel and (said := radius_doubt(wheel_m)):
        yield "wheel_radius", said, "check the unit in the header"
    if (turns := trial.wrap_angle_rad / math.tau) > MOST_TURNS:
        said = f"a wrap of {turns:g} turns is probably in another unit"
        yield "wrap_angle", said, "check the unit in the header"
    if trial.exclude.lower() in {"no", "n", "false", "0", "-", "none"}:
        said = f"'{trial.exclude}' is taken as a reason, so the trial is excluded"
        yield "exclude", said, "leave the cell empty to keep the trial"
    if rope_m >= wheel_m:
        said = f"the rope radius, {rope_m * 1e3:g} mm, is not below the wheel radius, {wheel_m * 1e3:g} mm"
        yield "rope_diameter", said, "check both, and whether a diameter was given as a radius"


def _few_repeats(trials: Sequence[TrialSpec], warn: _Warn) -> Iterator[Problem]:
    group = condition_groups(*_settings(trials))
    counts = np.bincount(group)
    few, least = int(np.count_nonzero(counts < FEWEST_REPEATS)), int(counts.min())
    if few:
        message = (
            f"{few} of {counted(counts.size, 'condition')} have fewer than {FEWEST_REPEATS} repeats (fewest: {least}); "
            "the ±2s rule cannot reject anything for n <= 5 (largest possible |z| = (n-1)/sqrt(n))"
        )
        fix = f'plan {FEWEST_REPEATS} repeats or more, or choose [rejection] rule = "none" on purpose'
        line = trials[int(np.argmax(counts[group] == least))].line
        yield warn(code="RF310", message=message, line=line, fix=fix)


def _settings(trials: Sequence[TrialSpec]) -> tuple[FloatArray, ...]:
    """Return what repeats have in common: size ratio, wrap, load and wheel of each trial."""
    size = [trial.wheel_radius_m / trial.rope_radius_m for trial in trials]
    load_N = [t.end_tension_N if t.end_tension_N is not None else t.lift_force_N or 0.0 for t in trials]
    columns = (size, [t.wrap_angle_rad for t in trials], load_N, [t.wheel_radius_m for t in trials])
    return tuple(np.array(column) for column in columns)


def _nothing_hung(trials: Sequence[TrialSpec], warn: _Warn) -> Iterator[Problem]:
    """Warn that repeats cannot be recognised where the end tension is measured and the weight is not stated."""
    unsaid = [one for one in trials if one.end_tension_N is None and one.lift_force_N is None]
    if unsaid:
        message = "the end tension is measured, and the list does not say what was hung: each of "
        message += f"{counted(len(unsaid), 'trial')} is a condition of its own, without repeats"
        fix = "add the column end_tension_N with what was set; what was measured is still what counts"
        yield warn(code="RF310", message=message, line=unsaid[0].line, key="end_tension", fix=fix)


# --- a list of trials from the names of the recordings ---

_DIGITS = re.compile(r"([0-9]+)")
_GROUP = re.compile(r"\{(\w+)\}")
_DIGITS_OF = r"[+-]?\d+(?:[.,]\d+)?"
_SHOWN = 3


def list_from_names(files: str, pattern: str, folder: Path) -> tuple[bytes, str]:
    """Return a list of trials of the files that a glob pattern finds, and notes on names that do not match.

    In the pattern of names, `{wrap_angle_deg}` matches a number or, where a column of that name holds text, for
    words; `*` matches anything.
    Names are headers of the list, with their units. Without "/" the pattern is compared with the file's name, with or
    without its ending.
    """
    paths = glob.glob(files, recursive=True)  # noqa: PTH207  (whole paths too, which Path.glob refuses)
    found = sorted((path for path in paths if Path(path).is_file()), key=_natural)
    if not found:
        raise DataError(
            "no file matches", path=files, fix="check the folder, and quote the pattern: 'daq/*.csv'"
        )
    compiled = _compiled(pattern)
    parts = {path: _match(compiled, pattern, path) if compiled else {} for path in found}
    rows = [
        {"file": Path(os.path.relpath(path, folder)).as_posix(), **named}
        for path, named in parts.items()
        if named is not None
    ]
    if not rows:
        why = f"none of {counted(len(found), 'name')} matches the pattern {pattern!r}; the first is {found[0]!r}"
        like = '"{wheel}_{wrap_angle_deg}deg_{repeat}"; * matches anything'
        fix = f"write what changes from name to name as {{header}}, such as {like}"
        raise InputError(why, key="--pattern", fix=fix)
    missed = [path for path, named in parts.items() if named is None]
    shown = f"{', '.join(missed[:_SHOWN])}{', …' if len(missed) > _SHOWN else ''}"
    told = f"{len(missed)} of {len(found)} names do not match the pattern and are left out: {shown}"
    return _list_of(rows), told if missed else ""


def _list_of(rows: Sequence[Mapping[str, str]]) -> bytes:
    """Return what names say as a list of trials, with empty columns for what every trial needs beside."""
    columns, _, problems = cells.CellTable(path="--pattern", header=tuple(rows[0])).bind(QUANTITIES, TEXTS)
    if problems:
        raise data_error(problems)
    meaning = {"wheel": "wheel_radius_m", "lift_force_N": "end_tension_N"}
    known = {*columns, *(meaning[name] for name in meaning.keys() & columns.keys())}
    needed = [
        stem for stem in ("wheel_radius", "wrap_angle", "end_tension") if QUANTITIES[stem][0] not in known
    ]
    names = [*rows[0], *(cells.example_of(stem, QUANTITIES) for stem in needed)]
    numbers = {column.header for column in columns.values() if column.si_unit}
    table = [names]
    for row in rows:
        written = {name: cell.replace(",", ".") if name in numbers else cell for name, cell in row.items()}
        table.append([to_spreadsheet(written.get(name, "")) for name in names])
    return csv_text(table).encode()


def _natural(path: str) -> tuple[list[tuple[int, str]], str]:
    return [(int(part), "") if part.isdigit() else (-1, part) for part in _DIGITS.split(path)], path


def _compiled(pattern: str) -> re.Pattern[str] | None:
    text = "".join(
        f"(?P<{part}>{_of_column(part)})" if place % 2 else re.escape(part).replace(r"\*", ".*?")
        for place, part in enumerate(_GROUP.split(pattern))
    )
    try:
        found = re.compile(text)
    except re.error as error:
        fix = "each {name} is a word and occurs once"
        raise InputError(f"{pattern!r} is no pattern: {error}", key="--pattern", fix=fix) from None
    if pattern and not found.groupindex:
        fix = 'write what changes as {header}, such as "{wheel}_{wrap_angle_deg}deg_{repeat}"'
        raise InputError(f"the pattern {pattern!r} names no column", key="--pattern", fix=fix)
    return found if pattern else None


def _of_column(name: str) -> str:
    table = cells.CellTable(path="", header=(name,))
    columns, _, _ = table.bind(QUANTITIES, TEXTS)
    return _DIGITS_OF if any(column.si_unit for column in columns.values()) else ".+?"


def _match(compiled: re.Pattern[str], pattern: str, path: str) -> dict[str, str] | None:
    whole = "/".join(PurePath(path).parts[-1 - pattern.count("/") :])
    bare = whole.removesuffix(".gz")
    for name in (bare.removesuffix(PurePath(bare).suffix), whole):
        if found := compiled.fullmatch(name):
            return {key: value.strip() for key, value in found.groupdict(default="").items()}
    return None
