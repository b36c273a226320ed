"""The trial table: one row a trial, the hand-over between the lab half and the design half."""

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import DataError, InputError, Problem, UnknownNameError, raise_problems
from ropefric.files.plain_text import from_spreadsheet
from ropefric.friction.condition import Conditions, condition_groups
from ropefric.glossary import counted
from ropefric.quantities import split_unit_suffix
from ropefric.registry import did_you_mean
from ropefric.shown import Shown
from ropefric.trials import cells, numbers
from ropefric.trials.cells import QUANTITIES
from ropefric.trials.result import CHECK_UNITS, MU, Extraction, stems

if TYPE_CHECKING:
    import pandas as pd

_REQUIRED = {
    QUANTITIES[stem][0]: cells.example_of(stem, QUANTITIES)
    for stem in ("wheel_radius", "rope_diameter", "wrap_angle", "end_tension", "peak")
}
"""Numbers every table needs, and a header that gives each."""
_NUMBERS = tuple(dict.fromkeys(field for field, _, _ in QUANTITIES.values()))
_OPTIONAL = _NUMBERS[len(_REQUIRED) :]
_UNKNOWN = ("peak_std_N", "cell_std_N")
"""Those of them that are NaN where they are not given; the others are zero."""
_BESIDE = tuple(column.name for column in numbers.COLUMNS if column.read_as)
"""Numbers that a fit of F_A does not need, and that are passed over where they cannot be."""
FORCES = ("peak", "kinetic")
"""Forces to which a law can be fitted: the break-away force, or the mean force while sliding."""
_TEXTS = ("trial", "kept", "status")
LABELS = ("rope_id", "wheel", "mounting", "operator", "day", "dwell", "order", "cell")
"""Columns beside the numbers that can group trials."""
_QUANTITIES_BESIDE = {
    stem: (column.name, column.unit, 1.0) for column in numbers.COLUMNS for stem in column.read_as
}
# What an extraction and a list of trials have beside the columns a fit reads.
_PASSED_OVER = stems() - {"end_tension_set"} | {"exclude"}
_FRAME_NAMES = {"wrap_std_rad": "wrap_angle_std_rad"}
_EMPTY = frozenset({"", "nan", "na", "n/a", "none", "null", "<na>", "-"})
_TRUE = frozenset({"", "true", "yes", "1", "1.0", "kept"})
_FALSE = frozenset({"false", "no", "0", "0.0", "rejected"})
# A force this many standard deviations of its repeats below the end tension is no scatter; what they scatter by where
# there are none [-].
_FAR, _TYPICAL_SCATTER = 4.0, 0.02
_HASH_DIGITS = 64


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TrialTable(Shown):
    """Trials with the force each gave.

    Attributes
    ----------
    trial : tuple of str
        Names of the N trials.
    wheel_radius_m, rope_radius_m : ndarray, shape (N,)
        R_w, R_r [m].
    wrap_angle_rad : ndarray, shape (N,)
        φ [rad].
    end_tension_N, peak_N : ndarray, shape (N,)
        F_B and F_A [N]; NaN where a trial gave none.
    peak_std_N : ndarray, shape (N,)
        Standard uncertainty of F_A by the instrument [N]; NaN where unknown.
    end_tension_std_N, wrap_std_rad, wheel_radius_std_m, rope_radius_std_m : ndarray, shape (N,)
        Standard uncertainties of the settings; 0 where unknown. A weight, a wheel, a rope and a wrap setting are wrong
        by the same amount in every condition that has them.
    cell_std_N : ndarray, shape (N,)
        The part of the measured force's uncertainty that all trials of a force cell share [N]; NaN where unknown,
        and then the whole is taken as shared.
    kinetic_N, kinetic_mean_std_N : ndarray, shape (N,)
        Mean force while sliding, and its standard uncertainty [N]; NaN where unknown.
    end_tension_set_N : ndarray, shape (N,)
        Set value of F_B where it was measured [N], the same for all repeats of a condition; NaN elsewhere.
    force : {"peak", "kinetic"}
        The force in `peak_N`, see `of`.
    kept : ndarray of bool, shape (N,)
        False where a rule or the user set the trial aside.
    status : tuple of str
        "ok" where the recording gave a force.
    source : str
        Where the table comes from, for messages and provenance.
    warnings : tuple of Problem
        Its warnings.
    labels : mapping of str to tuple of str
        Columns of `LABELS` beside the trials: their rope, wheel, operator, dwell, order and force cell.

    Raises
    ------
    InputError
        If the columns disagree in length.

    Examples
    --------
    >>> table = TrialTable(
    ...     trial=("a", "b"), wheel_radius_m=[0.04, 0.04], rope_radius_m=[0.005, 0.005], wrap_angle_rad=[3.0, 3.0],
    ...     end_tension_N=[20, 20], peak_N=[40, 41],
    ... )
    >>> int(table.used.sum()), table.group().tolist()
    (2, [0, 0])
    """

    _said = (
        *("source", "trial", "used", "peak_N", "end_tension_N", "wrap_angle_rad"),
        *("wheel_radius_m", "rope_radius_m", "warnings"),
    )

    trial: tuple[str, ...]
    wheel_radius_m: FloatArray
    rope_radius_m: FloatArray
    wrap_angle_rad: FloatArray
    end_tension_N: FloatArray
    peak_N: FloatArray
    peak_std_N: FloatArray = np.nan  # type: ignore[assignment]
    end_tension_std_N: FloatArray = 0.0  # type: ignore[assignment]
    wrap_std_rad: FloatArray = 0.0  # type: ignore[assignment]
    wheel_radius_std_m: FloatArray = 0.0  # type: ignore[assignment]
    rope_radius_std_m: FloatArray = 0.0  # type: ignore[assignment]
    cell_std_N: FloatArray = np.nan  # type: ignore[assignment]
    kinetic_N: FloatArray = np.nan  # type: ignore[assignment]
    kinetic_mean_std_N: FloatArray = np.nan  # type: ignore[assignment]
    end_tension_set_N: FloatArray = np.nan  # type: ignore[assignment]
    force: str = "peak"
    kept: BoolArray = True  # type: ignore[assignment]
    status: tuple[str, ...] = ()
    source: str = ""
    warnings: tuple[Problem, ...] = field(default=())
    labels: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        n = len(self.trial)
        for name in (*_NUMBERS, *_BESIDE, "kept"):
            given = np.asarray(getattr(self, name), dtype=bool if name == "kept" else np.float64)
            if given.shape not in {(), (n,)}:
                raise InputError(f"{name} has shape {given.shape} for {n} trials", key=name)
            array = np.broadcast_to(given, (n,)).copy()
            if name in _OPTIONAL and name not in _UNKNOWN:
                array[np.isnan(array)] = 0.0
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        object.__setattr__(self, "trial", tuple(self.trial))
        object.__setattr__(self, "status", tuple(self.status) or ("ok",) * n)
        if len(self.status) != n:
            raise InputError(f"{len(self.status)} status words for {n} trials", key="status")

    def __len__(self) -> int:
        return len(self.trial)

    @property
    def used(self) -> BoolArray:
        """Return which trials a fit uses, shape (N,): kept, status ok, with a force."""
        good = np.array([word == "ok" for word in self.status], dtype=bool)
        return np.asarray(self.kept & good & (self.peak_N > 0.0))

    def of(self, force: str) -> "TrialTable":
        """Return the table with a force of `FORCES` to fit; trials without it are not kept.

        Raises
        ------
        UnknownNameError
            If there is no such force.
        InputError
            If no trial that is used has a kinetic force above its end tension.
        """
        if force not in FORCES:
            fix = did_you_mean(force, FORCES)
            raise UnknownNameError(f"unknown force {force!r}", key="of", fix=fix)
        if force in {self.force, "peak"}:
            return self
        there = np.asarray(self.kinetic_N > self.end_tension_N)
        lost = int(np.count_nonzero(self.used & ~there))
        if not (self.used & there).any():
            message = "no trial that is used has a kinetic force above its end tension"
            fix = "add a column kinetic_N, or extract recordings that go on after the break-away"
            raise InputError(message, code="RF410", key="of", fix=fix)
        doubts = self.warnings
        if lost:
            message = f"{counted(lost, 'trial')} left out: no kinetic force above the end tension"
            doubts += (Problem(code="RF410", message=message, path=self.source, severity="warning"),)
        return replace(
            self,
            force=force,
            peak_N=np.where(there, self.kinetic_N, np.nan),
            peak_std_N=self.kinetic_mean_std_N,
            kept=self.kept & there,
            warnings=doubts,
        )

    def conditions(self) -> Conditions:
        """Return the conditions of the n used trials."""
        used = self.used
        return Conditions(**{item.name: getattr(self, item.name)[used] for item in fields(Conditions)})

    def log_lift(self) -> FloatArray:
        """Return ln(F_A / 1 N) of the used trials, shape (n,)."""
        return np.log(self.peak_N[self.used])

    def group(self) -> IntArray:
        """Return the number 0 … k − 1 of the condition of every used trial, in order of appearance, shape (n,).

        A condition is a wheel, a rope, a wrap and the force that was set: the end tension, or, where the slack
        side was measured against a known weight, the lift force. The force set takes fewer values than the force
        measured.
        """
        by_end, by_lift = self._groups()
        return by_end if by_end.max(initial=-1) <= by_lift.max(initial=-1) else by_lift

    @property
    def measures_slack(self) -> bool:
        """Return whether the end tension was measured against a known lift force, not the other way round."""
        by_end, by_lift = self._groups()
        return bool(by_lift.max(initial=-1) < by_end.max(initial=-1))

    def _groups(self) -> tuple[IntArray, IntArray]:
        used = self.used
        geometry = [self.wheel_radius_m, self.rope_radius_m, self.wrap_angle_rad]
        set_N = np.where(np.isnan(self.end_tension_set_N), self.end_tension_N, self.end_tension_set_N)
        by_end = condition_groups(*(array[used] for array in [*geometry, set_N]))
        return by_end, condition_groups(*(array[used] for array in [*geometry, self.peak_N]))

    def to_frame(self) -> "pd.DataFrame":
        """Return the table as a pandas DataFrame with SI columns that `table_from_frame` reads back."""
        import pandas as pd  # noqa: PLC0415  (slow to load, and few calls need it)

        data: dict[str, Any] = {"trial": list(self.trial)}
        data |= {_FRAME_NAMES.get(name, name): getattr(self, name) for name in _NUMBERS}
        data |= {name: getattr(self, name) for name in _BESIDE if not np.isnan(getattr(self, name)).all()}
        data |= {name: list(words) for name, words in self.labels.items()}
        return pd.DataFrame(data | {"kept": self.kept, "status": list(self.status)})


def read_trial_table(path: str | os.PathLike[str], columns: Mapping[str, str] | None = None) -> TrialTable:
    r"""Return the trial table of a CSV file: what an extraction writes, or a table of one's own.

    The header names each column with its unit: `wheel_radius_mm`, `rope_diameter_mm`, `wrap_angle_deg`,
    `end_tension_N` (or `end_mass_kg`), `peak_N` (or `lift_force_kN`); optional `trial`, `kept`, `status`,
    `peak_std_N`, `end_tension_std_N`, `wrap_angle_std_deg`, `wheel_radius_std_mm`; `rope_id`, `wheel`, `operator`,
    `dwell_s` and `order`, by which a diagnosis groups trials. Other columns are passed over.
    Separators ";", tab and "," and decimal commas are found out. `columns` gives headers new names.
    """
    if PurePath(path).suffix.lower() == ".toml":
        fix = "give a table such as the trials.csv that `ropefric extract` writes, or in Python what extract() returns"
        raise DataError("this is a TOML file, not a table of trials", path=PurePath(path).as_posix(), fix=fix)
    table, problems = cells.read_cells(path)
    for name in columns or ():
        if name not in table.header:
            text, fix = f"there is no column {name!r} to be renamed", did_you_mean(name, table.header)
            raise UnknownNameError(text, path=table.path, key="columns", fix=fix)
    header = tuple((columns or {}).get(name, name) for name in table.header)
    return _table(replace(table, header=header), problems)


def table_from_frame(frame: "pd.DataFrame") -> TrialTable:
    """Return the trial table of a pandas DataFrame, whose columns are named as in `read_trial_table`."""
    header = tuple(str(name) for name in frame.columns)
    columns = []
    for index in range(len(header)):
        column = frame.iloc[:, index]
        values = zip(column.tolist(), column.isna().tolist(), strict=True)
        columns.append(["" if missing else str(value).strip() for value, missing in values])
    rows = tuple(enumerate(zip(*columns, strict=True), start=1))
    # The separator of no text: numbers from a frame have a decimal point.
    return _table(cells.CellTable(path="DataFrame", header=header, rows=rows), ())


def table_of_extraction(extraction: Extraction) -> TrialTable:
    """Return the trial table of an extraction; a pull in which friction helped the rope along is not kept."""
    trials = extraction.trials
    taken = {name: numbers.column(name).taken for name in (*_NUMBERS, *_BESIDE)}
    columns: dict[str, Any] = {name: np.array([*map(take, trials)]) for name, take in taken.items()}
    kept = np.array([trial.kept for trial in trials], dtype=np.bool_)
    kept &= (columns["peak_N"] > columns["end_tension_N"]) | _below_by_scatter(columns, kept)
    status = tuple(trial.breakaway.status.value for trial in trials)
    rows = tuple((line, ()) for line in range(1, 1 + len(trials)))
    place = cells.CellTable(path="extraction", header=(), rows=rows)
    doubts = (*_rows_twice(place, columns, kept), *_too_few(place, kept, status))
    raise_problems(doubts)
    names_of = tuple(trial.trial for trial in trials)
    own = [dict(one.own) | {"dwell": f"{one.dwell_s:g}"} for one in trials]
    for named, one in zip(own, trials, strict=True):
        named |= {name: getattr(one, name) for name in ("rope_id", "wheel", "cell")}
    labels = {name: tuple(str(row.get(name, "")) for row in own) for name in LABELS}
    return TrialTable(
        trial=names_of, kept=kept, status=status, source=place.path, warnings=doubts, labels=_filled(labels), **columns
    )  # fmt: skip


def _filled(labels: Mapping[str, Sequence[str]]) -> dict[str, tuple[str, ...]]:
    """Return the labels that say something of every trial."""
    return {name: tuple(values) for name, values in labels.items() if not {"", "nan"}.intersection(values)}


class _Rows:
    """The contents of the rows of a table, and by row their errors."""

    def __init__(self, table: cells.CellTable, columns: cells.Columns) -> None:
        self._table, self._columns = table, columns
        read, self.wrong = table.numbers(columns, empty=_EMPTY, doubted=_BESIDE)
        none = [math.nan] * len(table.rows)
        self.numbers = {name: np.array(read.get(name, none)) for name in (*_NUMBERS, *_BESIDE)}
        self._unread = {(i, problem.key) for i, some in self.wrong.items() for problem in some}

    def words_at(self, index: int) -> list[str]:
        """Return the words of a column, "" where there is none."""
        written = (cells_of[index] for _, cells_of in self._table.rows)
        return ["" if cell.lower() in _EMPTY else cell for cell in written]

    def words(self, name: str) -> list[str]:
        """Return the words of a known column; of one that is not there, none."""
        there = self._columns.get(name)
        return [""] * len(self._table.rows) if there is None else self.words_at(there.index)

    def kept(self) -> BoolArray:
        """Return which trials are kept, noting what does not say it."""
        said = self.words("kept")
        for i, word in enumerate(said):
            if word.lower() not in _TRUE | _FALSE:
                message = f"'{word[:40]}' does not say whether the trial is kept"
                line, key = self._table.rows[i][0], self._columns["kept"].header
                self.wrong[i].append(self._table.problem(line, key, "RF102", message, "write true or false"))
        return np.array([word.lower() not in _FALSE for word in said], dtype=np.bool_)

    def refuse_unusable(self, used: BoolArray) -> None:
        """Note, of the trials that are to be used, which numbers are missing or cannot be."""
        scattered = used & _below_by_scatter(self.numbers, used)
        unusable = (self.numbers["peak_N"] <= self.numbers["end_tension_N"]) | (self.numbers["peak_N"] == 0.0)
        for name in self._columns.keys() & set(_NUMBERS):
            values = self.numbers[name]
            unusable |= (values < 0.0) | (np.isnan(values) & (name in _REQUIRED))
        for i in np.flatnonzero(used & unusable).tolist():
            of_row = {name: float(self.numbers[name][i]) for name in _NUMBERS}
            known = {name: one for name, one in self._columns.items() if (i, one.header) not in self._unread}
            line, by_scatter = self._table.rows[i][0], bool(scattered[i])
            self.wrong[i] += _why_unusable(self._table, line, of_row, known, by_scatter=by_scatter)

    def problems(self) -> Iterator[Problem]:
        """Return all that is wrong, row by row."""
        return (problem for i in sorted(self.wrong) for problem in self.wrong[i])


def _table(table: cells.CellTable, problems: Sequence[Problem]) -> TrialTable:
    """Return a table of cells as trials, all at once, or refuse it with everything that is wrong.

    A row that is not kept, or whose recording gave no force, may lack numbers; a row that is to be used may not.
    """
    columns, found = _columns_of(table)
    rows = _Rows(table, columns)
    kept, status = rows.kept(), tuple(word.lower() or "ok" for word in rows.words("status"))
    rows.refuse_unusable(kept & np.array([word == "ok" for word in status], dtype=np.bool_))
    given = zip(map(from_spreadsheet, rows.words("trial")), table.rows, strict=True)
    trial = tuple(name or f"row-{line}" for name, (line, _) in given)
    twice = (*_names_twice(table, trial), *_rows_twice(table, rows.numbers, kept))
    doubts = (*twice, *_implausible(table, rows.numbers, kept))
    every = (*problems, *found, *rows.problems(), *doubts, *_cut_off(table), *_too_few(table, kept, status))
    raise_problems(every)
    stems = {cells.stem_of(name): i for i, name in enumerate(table.header)}
    labels = _filled({name: rows.words_at(stems[name]) for name in LABELS if name in stems})
    known: dict[str, Any] = {**rows.numbers, "labels": labels}
    return TrialTable(trial=trial, status=status, kept=kept, source=table.path, warnings=every, **known)


def _columns_of(table: cells.CellTable) -> tuple[cells.Columns, list[Problem]]:
    """Return the known columns, and the errors of the header."""
    united = {cells.word_of(stem) for stem, unit in map(split_unit_suffix, table.header) if unit}
    beside = {stem: meant for stem, meant in _QUANTITIES_BESIDE.items() if stem in united}
    columns, others, found = table.bind({**QUANTITIES, **beside}, _TEXTS)
    for name in others:
        if cells.stem_of(name) not in _PASSED_OVER:
            found += table.near_miss(name, QUANTITIES, _TEXTS)
    # With a wrong unit a column is there; that it is missing as well would only confuse.
    missing = () if any(one.severity == "error" for one in found) else _REQUIRED.keys() - columns.keys()
    for name in sorted(missing):
        named = name.rsplit("_", 1)[0].replace("_", " ").replace("peak", "break-away force")
        message = f"there is no column for the {named}; every trial needs one"
        fix = f"add a column {_REQUIRED[name]} (in any unit, as part of the name)"
        found.append(table.problem(table.header_line, "", "RF121", message, fix))
    return columns, found


def _below_by_scatter(numbers: Mapping[str, FloatArray], used: BoolArray) -> BoolArray:
    """Return which forces are at or below their end tension by no more than repeats scatter, as ln F_A/F_B may be.

    Where friction is small some pulls must be: leaving them out would make it look larger. None that lies as far off
    the other pulls of its condition, and none where most are below: that is a mistake.
    """
    peak_N, end_N = numbers["peak_N"], numbers["end_tension_N"]
    with np.errstate(divide="ignore", invalid="ignore"):
        rise = np.log(peak_N / end_N)
    settings = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N")
    usable = used & np.isfinite([rise, *(numbers[name] for name in settings)]).all(axis=0)
    above = usable & (rise > 0.0)
    below = usable & ~above
    if not below.any() or 2 * np.count_nonzero(below) > np.count_nonzero(usable):
        return np.zeros_like(used)
    group = np.zeros(used.size, dtype=np.int64)
    group[usable] = condition_groups(*(numbers[name][usable] for name in settings))
    size = np.bincount(group[above], minlength=int(group.max()) + 1)
    mean = np.bincount(group[above], rise[above], size.size) / np.maximum(size, 1)
    spread, spare = _TYPICAL_SCATTER, int(size.sum()) - np.count_nonzero(size)
    if spare:
        about = rise[above] - mean[group[above]]
        spread = max(math.sqrt(float(about @ about) / spare), 0.1 * _TYPICAL_SCATTER)
    return np.asarray(below & (rise >= mean[group] - _FAR * spread) & (rise >= -_FAR * spread))


def _why_unusable(
    table: cells.CellTable,
    line: int,
    numbers: Mapping[str, float],
    columns: cells.Columns,
    *,
    by_scatter: bool,
) -> Iterator[Problem]:
    for name in _REQUIRED:
        if name in columns and math.isnan(numbers[name]):
            message, left_out = "the cell is empty or NaN, but the trial is to be used", name == "peak_N"
            if left_out:
                message = "the cell is empty or NaN: the trial gave no force, and is left out"
            fix = "write the number, or set the trial aside with kept = false"
            yield table.problem(line, columns[name].header, "RF121", message, fix, warning=left_out)
    for name in ("peak_N", *_OPTIONAL):
        if numbers[name] < 0 or (name == "peak_N" and numbers[name] == 0):
            least = "above zero" if name == "peak_N" else "zero or more"
            message = f"{numbers[name]:g} (SI) is no possible value; it must be finite and {least}"
            yield table.problem(line, columns[name].header, "RF110", message, "correct the number")
            return
    peak_N, end_N = numbers["peak_N"], numbers["end_tension_N"]
    if by_scatter:
        message = f"F_A = {peak_N:.6g} N is not above F_B = {end_N:.6g} N, by no more than forces scatter: it is kept"
        fix = "leave it: without the low ones, friction that small would seem larger than it is"
        yield table.problem(line, columns["peak_N"].header, "RF411", message, fix, warning=True)
    elif peak_N <= end_N:
        low = f"the break-away force {peak_N:.6g} N is not above the end tension {end_N:.6g} N"
        message = f"{low}: friction can only add to it"
        fix = "check whether the two columns or their units are exchanged, or set the trial aside with kept = false"
        yield table.problem(line, columns["peak_N"].header, "RF411", message, fix)


def _names_twice(table: cells.CellTable, names: Sequence[str]) -> Iterator[Problem]:
    first: dict[str, int] = {}
    for name, (line, _) in zip(names, table.rows, strict=True):
        if name in first:
            message = f"the trial '{name}' is in line {first[name]} already"
            fix = "remove one of the two rows, or give it a name of its own"
            yield table.problem(line, "trial", "RF122", message, fix)
        first.setdefault(name, line)


def _rows_twice(
    table: cells.CellTable, numbers: Mapping[str, FloatArray], kept: BoolArray
) -> Iterator[Problem]:
    """Yield a warning for rows that agree in every number: measured twice alike, or pasted twice."""
    values = np.stack([numbers[name] for name in _REQUIRED], axis=-1)
    usable = np.flatnonzero(kept & ~np.isnan(values).any(axis=1))
    _, first = np.unique(values[usable], axis=0, return_index=True)
    again = np.delete(usable, first)
    if again.size:
        rows = counted(again.size, "row")
        message = f"{rows} with all numbers of an earlier one, the first here"
        fix = "remove what was pasted twice: it would count as a repeat"
        yield table.problem(table.rows[int(again[0])][0], "", "RF122", message, fix, warning=True)


def _implausible(
    table: cells.CellTable, numbers: Mapping[str, FloatArray], kept: BoolArray
) -> Iterator[Problem]:
    """Yield a warning for rows whose coefficient no rope has: a unit is wrong, or columns are swapped."""
    with np.errstate(all="ignore"):
        mu = np.log(numbers["peak_N"] / numbers["end_tension_N"]) / numbers["wrap_angle_rad"]
    usable = kept & np.isfinite(mu)
    # A single one may be low by scatter.
    is_low = usable.any() and float(np.median(np.abs(mu[usable]))) < MU[0]
    odd = np.flatnonzero(usable & ((mu > MU[1]) | is_low))
    if odd.size:
        outside = f"with an apparent coefficient outside {MU[0]:g} to {MU[1]:g}"
        message = f"{counted(odd.size, 'row')} {outside}, the first here: {mu[odd[0]]:.2g}"
        yield table.problem(table.rows[int(odd[0])][0], "", "RF140", message, CHECK_UNITS, warning=True)


def _cut_off(table: cells.CellTable) -> Iterator[Problem]:
    """Yield where a table that `extract` wrote ends within a row; its last column is a hash of known length."""
    if table.rows and table.header[-1] == "sha256":
        line, row = table.rows[-1]
        if len(row[-1]) not in {0, _HASH_DIGITS}:
            digits = f"{len(row[-1])} of {_HASH_DIGITS} digits"
            message = f"the last row ends within its last cell, {digits}: the table is cut off"
            fix = "copy the whole file again, or extract again"
            yield table.problem(line, "sha256", "RF103", message, fix)


def _too_few(table: cells.CellTable, kept: BoolArray, status: Sequence[str]) -> Iterator[Problem]:
    used = sum(is_kept and word == "ok" for is_kept, word in zip(kept.tolist(), status, strict=True))
    if used < 2:
        of_all = f"{used} of {len(status)} trials can be used"
        message = f"{of_all}; a fit needs at least two, with different conditions"
        fix = "measure more conditions, or correct the columns kept and status"
        yield table.problem(None, "", "RF410", message, fix)
