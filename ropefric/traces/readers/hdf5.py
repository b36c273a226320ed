"""HDF5: data sets as columns, called by their paths; needs the extra `lab`."""

import io
from collections.abc import Container, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.files.text import Source
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import (
    Reader,
    Table,
    array_table,
    check_choice,
    foreign,
    package,
    recordings_among,
    seconds_from_first,
)

_DEEPEST = 20

RATES = ("sampling_rate", "sample_rate", "sampling_rate_hz", "sample_rate_hz", "sampling_frequency", "fs")
"""Attributes with samples per second, of a data set, its group or the file, whatever their case and blanks."""
STEPS = ("dt", "dt_s", "wf_increment", "sampling_interval", "sample_interval", "time_step")
"""Attributes with seconds from sample to sample."""
STARTS = ("t0", "start", "start_s", "start_time", "wf_start_time", "wf_start_offset", "time_offset")
"""Attributes with the time of the first sample, in seconds or as a date with a time of day."""
_UNITS = ("unit", "units", "unit_string")


class _Column(NamedTuple):
    """A column, its unit, its first sample [s] and its step of time [s], 0 where it is unknown, and a note."""

    values: np.ndarray[Any, Any]
    unit: str
    start: float | np.datetime64
    step_s: float
    said: str


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return the data sets of the group that the profile names, else all."""
    h5py = package("h5py", "HDF5", source)
    named = {channel.column for channel in profile.channels.values()}
    raw, fix = source.raw_bytes(), "copy it again, or name its format in [import] format"
    with foreign(source, "this is not a readable HDF5 file", fix), h5py.File(io.BytesIO(raw)) as file:
        sets = _sets_of_group(dict(_sets(file, "", h5py)), profile.table.strip("/"), source)
        columns = {
            name: _Column(values, *_attributes(item, file))
            for path, item in _once(sets, named, h5py).items()
            for name, values in _columns(item, path)
        }
    if not columns:
        raise source.error("no data set holds a column of numbers", fix="record it again")
    said = f"HDF5: {', '.join(columns)[:300]}"
    alike = _groups_alike(columns)
    if len(alike) < 2 or named & columns.keys():
        return (_table(columns, source, said),)
    sizes = {name: max(column.values.size for column in group.values()) for name, group in alike.items()}
    tables = {name: _table(group, source, said) for name, group in alike.items()}
    return recordings_among(tables, sizes, profile, "groups")


def _sets_of_group(sets: Mapping[str, Any], group: str, source: Source) -> dict[str, Any]:
    """Return the data sets of a group, under their paths within it; of all groups where none is named."""
    groups = {path[:end] for path in sets for end, mark in enumerate(path) if mark == "/"}
    check_choice(group, {*sets, *groups}, "group", source)
    under = f"{group}/" if group else ""
    return {path.removeprefix(under): item for path, item in sets.items() if f"{path}/".startswith(under)}


def _groups_alike(columns: Mapping[str, _Column]) -> dict[str, dict[str, _Column]]:
    """Return the groups that have the columns of the largest group: recordings beside each other."""
    groups: dict[str, dict[str, _Column]] = {}
    for path, column in columns.items():
        group, _, name = path.rpartition("/")
        groups.setdefault(group, {})[name] = column
    most = max(groups.values(), key=lambda group: sum(column.values.size for column in group.values()))
    return {name: group for name, group in groups.items() if name and group.keys() == most.keys()}


def _table(columns: Mapping[str, _Column], source: Source, said: str) -> Table:
    """Return a table whose columns have a clock of their own where attributes define one."""
    chosen = list(columns.values())
    dates = iter(seconds_from_first([c.start for c in chosen if isinstance(c.start, np.datetime64)]))
    starts_s = [next(dates) if isinstance(c.start, np.datetime64) else c.start for c in chosen]
    first_s = min((start for c, start in zip(chosen, starts_s, strict=True) if c.step_s), default=0.0)

    def clock(index: int) -> FloatArray | None:
        step_s = chosen[index].step_s
        start_s = starts_s[index] - first_s
        return start_s + step_s * np.arange(chosen[index].values.size, dtype=np.float64) if step_s else None

    arrays = {path: column.values for path, column in columns.items()}
    units = {path: column.unit for path, column in columns.items()}
    has_clock = any(column.step_s for column in chosen)
    notes = [said, *(column.said for column in chosen if column.said)]
    return array_table(arrays, source, units=units, clock=clock if has_clock else None, notes=notes)


def _sets(group: Any, path: str, h5py: Any, above: tuple[Any, ...] = ()) -> Iterator[tuple[str, Any]]:
    """Yield path and data set of all there is below a group, through links too; other files are not opened."""
    for name in group:
        is_index = name.startswith(("_i_", "_p_"))  # of PyTables and pandas
        if is_index or isinstance(group.get(name, getlink=True), h5py.ExternalLink):
            continue
        item = group.get(name)
        if isinstance(item, h5py.Dataset) and not (item.is_virtual or item.external):
            yield f"{path}{name}", item
        elif isinstance(item, h5py.Group) and item not in above and len(above) < _DEEPEST:
            yield from _sets(item, f"{path}{name}/", h5py, (*above, group, item))


def _once(sets: Mapping[str, Any], named: Container[str | int], h5py: Any) -> dict[str, Any]:
    """Return every data set under its shortest path, and under those that are named; links give it many."""
    found, seen = dict[str, Any](), set[int]()
    for path in sorted(sets, key=lambda path: (path.count("/"), path)):
        place = h5py.h5o.get_info(sets[path].id).addr
        if place not in seen or path in named:
            found[path] = sets[path]
            seen.add(place)
    return {path: found[path] for path in sets if path in found}


def _columns(item: Any, path: str) -> Iterator[tuple[str, np.ndarray[Any, Any]]]:
    """Yield path and values of every column of a data set: a vector, the fields of records, or a matrix."""
    kind, n_axes = item.dtype, sum(size > 1 for size in item.shape or ())
    if kind.names and n_axes == 1:
        numeric = [name for name in kind.names if kind[name].kind in "iuf"]
        yield from ((f"{path}/{name}", np.ravel(item[name])) for name in numeric)
    elif kind.kind in "iuf" and n_axes == 1:
        yield path, np.ravel(item[()])
    elif kind.kind in "iuf" and n_axes == 2:
        values = np.squeeze(item[()])
        columns = values.T if values.shape[0] > values.shape[1] else values  # more samples than channels
        yield from ((f"{path}/{number}", column) for number, column in enumerate(columns, start=1))


def _attributes(item: Any, file: Any) -> tuple[str, float | np.datetime64, float, str]:
    """Return unit, start, step and note by the attributes of a data set, its group or the file: see `_Column`."""
    unit = next((value for key, value in item.attrs.items() if key.lower() in _UNITS), "")
    stated = [pair for place in (item, item.parent, file) for pair in place.attrs.items()]
    start = next((found for key, value in stated if (found := _start(_word(key), value)) is not None), 0.0)
    for key, value in stated:
        word, number = _word(key), np.ravel(value)
        if word in (*RATES, *STEPS) and _is_plain(number) and 0 < number[0] < np.inf:
            step_s = float(number[0]) if word in STEPS else 1.0 / float(number[0])
            return _text(unit), start, step_s, f"{step_s:g} s from sample to sample, by the attribute {key!r}"
    return _text(unit), start, 0.0, ""


def _start(word: str, value: Any) -> float | np.datetime64 | None:
    if word not in STARTS:
        return None
    number = np.ravel(value)
    if _is_plain(number):
        return float(number[0]) if np.isfinite(number[0]) else None
    try:
        return np.datetime64(_text(value).removesuffix("Z"), "ns")
    except ValueError:
        return None


def _is_plain(number: np.ndarray[Any, Any]) -> bool:
    return number.size == 1 and number.dtype.kind in "iuf"


def _word(key: str) -> str:
    return "_".join(key.lower().split())


def _text(value: Any) -> str:
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)


READER = Reader(
    name="hdf5",
    suffixes=(".h5", ".hdf5", ".hdf"),
    description="HDF5: data sets as columns (extra lab)",
    tables=_tables,
)
