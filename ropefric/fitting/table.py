"""The trial table: one row a trial, the hand-over between the lab half and the design half."""

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import InputError, Problem, raise_problems
from ropefric.fitting.table_columns import OPTIONAL_NUMBERS, REQUIRED_NUMBERS, bind_table_columns
from ropefric.fitting.table_rows import ParsedRows, parse_rows
from ropefric.friction.condition import Conditions, condition_groups
from ropefric.trials.trial_table import CellTable, read_cells

if TYPE_CHECKING:
    import pandas as pd


_NUMBERS = (*REQUIRED_NUMBERS, *OPTIONAL_NUMBERS)
_FRAME_NAMES = {"wrap_std_rad": "wrap_angle_std_rad"}
_HASH_DIGITS = 64


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TrialTable:
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
    end_tension_std_N, wrap_std_rad, wheel_radius_std_m : ndarray, shape (N,)
        Standard uncertainties of the settings; 0 where unknown.
    kept : ndarray of bool, shape (N,)
        False where a rule or the user set the trial aside.
    status : tuple of str
        "ok" where the recording gave a force.
    source : str
        Where the table comes from, for messages and provenance.
    warnings : tuple of Problem
        What is doubtful about it.

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
    kept: BoolArray = True  # type: ignore[assignment]
    status: tuple[str, ...] = ()
    source: str = ""
    warnings: tuple[Problem, ...] = field(default=())

    def __post_init__(self) -> None:
        n = len(self.trial)
        for name in (*_NUMBERS, "kept"):
            given = np.asarray(getattr(self, name), dtype=bool if name == "kept" else np.float64)
            if given.shape not in {(), (n,)}:
                raise InputError(f"{name} has shape {given.shape} for {n} trials", key=name)
            array = np.broadcast_to(given, (n,)).copy()
            if name in OPTIONAL_NUMBERS and name != "peak_std_N":
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

    def conditions(self) -> Conditions:
        """Return the conditions of the n used trials."""
        used = self.used
        return Conditions(
            wheel_radius_m=self.wheel_radius_m[used],
            rope_radius_m=self.rope_radius_m[used],
            wrap_angle_rad=self.wrap_angle_rad[used],
            end_tension_N=self.end_tension_N[used],
        )

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
        by_end = condition_groups(*(array[used] for array in [*geometry, self.end_tension_N]))
        return by_end, condition_groups(*(array[used] for array in [*geometry, self.peak_N]))

    def to_frame(self) -> "pd.DataFrame":
        """Return the table as a pandas DataFrame with SI columns that `table_from_frame` reads back."""
        import pandas as pd  # noqa: PLC0415  (slow to load, and few calls need it)

        data: dict[str, Any] = {"trial": list(self.trial)}
        data |= {_FRAME_NAMES.get(name, name): getattr(self, name) for name in _NUMBERS}
        return pd.DataFrame(data | {"kept": self.kept, "status": list(self.status)})


def read_trial_table(path: str | os.PathLike[str]) -> TrialTable:
    r"""Return the trial table of a CSV file: what an extraction writes, or a table of one's own.

    The header names each column with its unit: `wheel_radius_mm`, `rope_diameter_mm`, `wrap_angle_deg`,
    `end_tension_N` (or `end_mass_kg`), `peak_N` (or `lift_force_kN`); optional `trial`, `kept`, `status`,
    `peak_std_N`, `end_tension_std_N`, `wrap_angle_std_deg`, `wheel_radius_std_mm`. Other columns are passed over.
    Separators ";", tab and "," and decimal commas are found out.
    """
    cells, problems = read_cells(path)
    return _table(cells, problems, str(Path(path).as_posix()))


def table_from_frame(frame: "pd.DataFrame") -> TrialTable:
    """Return the trial table of a pandas DataFrame, whose columns are named as in `read_trial_table`."""
    header = tuple(str(name) for name in frame.columns)
    columns = [_texts(frame.iloc[:, index]) for index in range(len(header))]
    rows = tuple((line, cells) for line, cells in enumerate(zip(*columns, strict=True), start=1))
    # The separator of no text: numbers from a frame have a decimal point.
    cells = CellTable(path="DataFrame", separator=",", header=header, header_line=0, rows=rows)
    return _table(cells, (), "DataFrame")


def _texts(column: "pd.Series[Any]") -> list[str]:
    missing = column.isna().tolist()
    return ["" if gone else str(value).strip() for value, gone in zip(column.tolist(), missing, strict=True)]


def _table(cells: CellTable, problems: tuple[Problem, ...], source: str) -> TrialTable:
    line = cells.header_line or None
    columns, _others, found = bind_table_columns(cells.header, cells.path, line)
    rows, wrong = parse_rows(cells, columns)
    every = [*problems, *found, *wrong, *_cut_off(cells), *_too_few(rows, cells.path)]
    raise_problems(every)
    return TrialTable(
        trial=tuple(rows.trial),
        status=tuple(rows.status),
        kept=rows.kept,
        source=source,
        warnings=tuple(every),
        **rows.numbers,
    )


def _cut_off(cells: CellTable) -> tuple[Problem, ...]:
    """Return where a table that `extract` wrote ends within a row; its last column is a hash of known length."""
    if not cells.rows or cells.header[-1] != "sha256":
        return ()
    line, row = cells.rows[-1]
    if len(row) != len(cells.header) or len(row[-1]) in {0, _HASH_DIGITS}:
        return ()
    message = f"the last row ends within its last cell, {len(row[-1])} of {_HASH_DIGITS} digits: the table is cut off"
    fix = "copy the whole file again, or extract again"
    return (Problem(code="RF103", message=message, path=cells.path, line=line, key="sha256", fix=fix),)


def _too_few(rows: ParsedRows, path: str) -> tuple[Problem, ...]:
    used = sum(kept and status == "ok" for kept, status in zip(rows.kept, rows.status, strict=True))
    if used >= 2:
        return ()
    message = (
        f"{used} of {len(rows.trial)} trials can be used; a fit needs at least two, with different conditions"
    )
    fix = "measure more conditions, or correct the columns kept and status"
    return (Problem(code="RF410", message=message, path=path, fix=fix),)
