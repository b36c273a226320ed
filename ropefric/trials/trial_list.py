"""The trial list: rows of trials.csv as `TrialSpec`, with everything that is wrong in them."""

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path

from ropefric.errors import DataError, Problem
from ropefric.registry import did_you_mean
from ropefric.trials.trial_cells import Row, decimal_mark, read_row
from ropefric.trials.trial_columns import BoundColumn, bind_columns
from ropefric.trials.trial_files import check_files, check_names
from ropefric.trials.trial_spec import TrialSpec
from ropefric.trials.trial_table import CellTable, read_cells

_SLIP = 0.75


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialContext:
    """What the campaign file says that rows depend on; as far as it could be read."""

    folder: Path
    folder_exists: bool = True
    wheels: Mapping[str, float | None]
    cells: tuple[str, ...] = ()
    rope_radius_m: float | None = None
    needs_lift_force: bool | None = False
    needs_cell: bool = False
    start_s: float | None = None
    stop_s: float | None = None


def read_trials(
    path: str | os.PathLike[str], context: TrialContext
) -> tuple[tuple[TrialSpec, ...], tuple[Problem, ...]]:
    """Return the rows that can be used, and all problems of the table."""
    try:
        table, problems_of_rows = read_cells(path)
    except DataError as error:
        # A trial list is named by the campaign file, and looked for where that is.
        in_campaign = "check the path, relative to the campaign file"
        return (), tuple(
            replace(one, fix=in_campaign) if "no such file" in one.message else one for one in error.problems
        )
    columns, own, problems_of_header = bind_columns(table.header, table.path, table.header_line)
    problems = [*problems_of_rows, *problems_of_header]
    reader = _Reader(
        path=table.path,
        columns=columns,
        context=context,
        header_line=table.header_line,
        header_is_good=all(problem.severity == "warning" for problem in problems_of_header),
        own=own,
    )
    # A mistyped header says more than the consequence that its column is missing.
    if reader.header_is_good:
        missing = reader.missing_columns()
        mistyped = {problem.key for problem in missing}
        problems = [problem for problem in problems if problem.key not in mistyped] + missing
    decimal = decimal_mark(table, columns)
    rows = [read_row(cells, line, columns, table.path, decimal) for line, cells in table.rows]
    problems += _unnamed_columns(table)
    if not table.rows and not problems_of_rows:
        message, fix = "the table has a header, but no trials", "add a row for every recording"
        problems.append(
            Problem(code="RF101", message=message, path=table.path, line=table.header_line, fix=fix)
        )
    for row in rows:
        row.problems.extend(reader.check(row))
    problems += check_files(rows, context.folder if context.folder_exists else None, table.path)
    names, problems_of_names = check_names(rows, table.path)
    problems += problems_of_names
    problems += [problem for row in rows for problem in row.problems]
    trials = [
        trial
        for row, name, (_, cells) in zip(rows, names, table.rows, strict=True)
        if not row.problems and (trial := reader.trial(row, name, cells)) is not None
    ]
    return tuple(trials), tuple(sorted(problems, key=lambda p: p.line or math.inf))


def _unnamed_columns(table: CellTable) -> list[Problem]:
    """Return a problem for every column without a name that holds something."""
    problems = []
    for index, name in enumerate(table.header):
        held = next((row for row in table.rows if not name and row[1][index]), None)
        if held is not None:
            message = f"column {index + 1} has no name, but holds '{held[1][index][:60]}'"
            fix = "name it; a column whose name starts with '_' is ignored"
            problems.append(Problem(code="RF120", message=message, path=table.path, line=held[0], fix=fix))
    return problems


@dataclass(frozen=True, slots=True, kw_only=True)
class _Reader:
    path: str
    columns: dict[str, BoundColumn]
    context: TrialContext
    header_line: int
    header_is_good: bool
    own: Mapping[str, int]

    @property
    def tension(self) -> tuple[str, ...]:
        if self.context.needs_lift_force is None:
            return ()
        return ("lift_force_N",) if self.context.needs_lift_force else ("end_tension_N",)

    def missing_columns(self) -> list[Problem]:
        needed = {"file": "file", "wrap_angle_rad": "wrap_angle_deg"} | {
            field: field for field in self.tension
        }
        if not {"wheel", "wheel_radius_m"} & self.columns.keys():
            needed["wheel_radius_m"] = "wheel_radius_mm (or wheel, with names from [wheels])"
        if self.context.needs_cell:
            needed["cell"] = "cell"
        return [self._missing(field, header) for field, header in needed.items() if field not in self.columns]

    def _missing(self, field: str, header: str) -> Problem:
        """Return that a column is missing, or that its name is mistyped."""
        known = header.split(maxsplit=1)[0]
        near = get_close_matches(known, self.own, n=1, cutoff=_SLIP)
        if near:
            message, fix = "this column is not known", did_you_mean(near[0], [known])
        else:
            message = f"there is no column {header}; every trial needs {_MEANINGS[field]}"
            fix = f"add the column {header}"
        return Problem(
            code="RF120" if near else "RF121",
            message=message,
            path=self.path,
            line=self.header_line,
            key=near[0] if near else known,
            fix=fix,
        )

    def check(self, row: Row) -> list[Problem]:
        """Return what is missing or contradictory in a row."""
        problems = [self._empty(row, field) for field in ("file", "wrap_angle_rad", *self.tension)]
        problems += [
            self._name(row, "wheel", self.context.wheels),
            self._name(row, "cell", self.context.cells),
        ]
        problems.append(self._wheel(row))
        if self.context.needs_cell:
            problems.append(self._empty(row, "cell"))
        start_s, stop_s = self._interval(row)
        if start_s is not None and stop_s is not None and not start_s < stop_s:
            message = f"the part from {start_s:g} s until {stop_s:g} s is empty"
            column = self.columns.get("stop_s") or self.columns["start_s"]
            problems.append(
                self._problem(row, "RF111", message, column.header, "give an end after the start")
            )
        return [problem for problem in problems if problem is not None]

    def trial(self, row: Row, name: str, cells: tuple[str, ...]) -> TrialSpec | None:
        """Return a checked row in SI; None where the campaign file leaves something open."""
        texts, numbers, context = row.texts, row.numbers, self.context
        wheel_m = numbers.get("wheel_radius_m", context.wheels.get(texts.get("wheel", "")))
        rope_m = numbers.get("rope_radius_m", context.rope_radius_m)
        wrap_rad, file = numbers.get("wrap_angle_rad"), texts.get("file")
        if wheel_m is None or rope_m is None or wrap_rad is None or not file:
            return None
        start_s, stop_s = self._interval(row)
        given = {
            key: texts[key]
            for key in ("sample", "wheel", "cell", "rope_id", "exclude", "note")
            if key in texts
        }
        return TrialSpec(
            trial=name,
            file=file,
            path=context.folder / file.replace("\\", "/"),
            line=row.line,
            wheel_radius_m=wheel_m,
            rope_radius_m=rope_m,
            wrap_angle_rad=wrap_rad,
            end_tension_N=numbers.get("end_tension_N"),
            lift_force_N=numbers.get("lift_force_N"),
            dwell_s=numbers.get("dwell_s"),
            start_s=start_s,
            stop_s=stop_s,
            own=tuple((header, cells[index]) for header, index in self.own.items()),
            **given,
        )

    def _interval(self, row: Row) -> tuple[float | None, float | None]:
        start_s = row.numbers.get("start_s", self.context.start_s)
        return start_s, row.numbers.get("stop_s", self.context.stop_s)

    def _problem(self, row: Row, code: str, message: str, key: str, fix: str) -> Problem:
        return Problem(code=code, message=message, path=self.path, line=row.line, key=key, fix=fix)

    def _empty(self, row: Row, field: str) -> Problem | None:
        column = self.columns.get(field)
        if column is None or row.texts.get(field) or field in row.numbers or field in row.unreadable:
            return None
        message = f"{column.header} is empty; every trial needs {_MEANINGS[field]}"
        return self._problem(row, "RF121", message, column.header, "fill the cell")

    def _name(self, row: Row, field: str, known: Mapping[str, object] | tuple[str, ...]) -> Problem | None:
        name = row.texts.get(field, "")
        if not name or name in known:
            return None
        fix = (
            did_you_mean(name[:80], known)
            if known
            else f"describe it under [{field}s.{name}] in the campaign file"
        )
        return self._problem(row, "RF120", f"unknown {field} '{name}'", self.columns[field].header, fix)

    def _wheel(self, row: Row) -> Problem | None:
        name, radius_m = row.texts.get("wheel", ""), row.numbers.get("wheel_radius_m")
        if not name and radius_m is None and self.header_is_good and "wheel_radius_m" not in row.unreadable:
            column = self.columns.get("wheel_radius_m") or self.columns.get("wheel")
            if column is None:
                return None
            message = f"{column.header} is empty; every trial needs {_MEANINGS['wheel_radius_m']}"
            return self._problem(row, "RF121", message, column.header, "fill the cell")
        known_m = self.context.wheels.get(name)
        if radius_m is None or known_m is None or math.isclose(radius_m, known_m, rel_tol=1e-6):
            return None
        message = f"the radius is {radius_m * 1e3:g} mm, but wheel '{name}' has {known_m * 1e3:g} mm"
        fix = "correct one, or leave one of the two cells empty"
        return self._problem(row, "RF111", message, self.columns["wheel_radius_m"].header, fix)


_MEANINGS = {
    "file": "the recording it was made of",
    "wheel_radius_m": "a wheel radius",
    "wrap_angle_rad": "a wrap angle",
    "end_tension_N": "an end tension",
    "lift_force_N": "the known tight-side tension, for the sensor measures the slack side",
    "cell": "a force cell, for its recording is in counts",
}
