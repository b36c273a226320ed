"""HDF5: data sets as columns, called by their paths; needs the extra `lab`."""

import io
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.files.text import Source
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import Reader, Table, array_table, check_choice, foreign, needs_package

RATES = ("sampling_rate", "sample_rate", "sampling_rate_hz", "sample_rate_hz", "sampling_frequency", "fs")
"""Attributes that tell samples per second, of a data set, its group or the file, whatever their case and blanks."""
STEPS = ("dt", "dt_s", "wf_increment", "sampling_interval", "sample_interval", "time_step")
"""Attributes that tell seconds from sample to sample."""
_UNITS = ("unit", "units", "unit_string")

_Column = tuple[
    np.ndarray[Any, Any], str, float, str
]  # values, unit, step of time [s] (0: not told), what to say of it


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return the data sets of the group that the profile names, else all."""
    try:
        import h5py  # noqa: PLC0415  (an extra that is not always there)
    except ImportError:
        raise needs_package("HDF5 needs the package h5py", source) from None
    raw, fix = source.raw_bytes(), "copy it again, or name its format in [import] format"
    with foreign(source, "this is not a readable HDF5 file", fix), h5py.File(io.BytesIO(raw)) as file:
        paths: list[str] = []
        file.visit(paths.append)
        sets = [file[path] for path in paths]
        # What lies in other files is not opened.
        own = [s for s in sets if isinstance(s, h5py.Dataset) and not (s.is_virtual or s.external)]
        columns = {path: (values, *_told(item, file)) for item in own for path, values in _columns(item)}
    if not columns:
        raise source.error("no data set holds a column of numbers", fix="record it again")
    said = f"HDF5: {', '.join(columns)[:300]}"
    group = profile.table.strip("/")
    check_choice(group, {*columns, *(path.rpartition("/")[0] for path in columns)}, "group", source)
    if group:
        under = f"{group}/"
        columns = {p.removeprefix(under): c for p, c in columns.items() if f"{p}/".startswith(under)}
    return (_table(columns, source, said),)


def _table(columns: Mapping[str, _Column], source: Source, said: str) -> Table:
    """Return a table whose columns bring a clock with them where attributes tell one."""
    chosen = list(columns.values())

    def clock(index: int) -> FloatArray | None:
        values, _, step_s, _ = chosen[index]
        return np.arange(values.size, dtype=np.float64) * step_s if step_s else None

    arrays = {path: values for path, (values, *_) in columns.items()}
    units = {path: unit for path, (_, unit, *_) in columns.items()}
    has_clock = any(step_s for _, _, step_s, _ in chosen)
    notes = [said, *(note for *_, note in chosen if note)]
    return array_table(arrays, source, units=units, clock=clock if has_clock else None, notes=notes)


def _columns(item: Any) -> Iterator[tuple[str, np.ndarray[Any, Any]]]:
    """Yield path and values of every column of a data set: a vector, the fields of records, or a matrix."""
    path, shape = item.name.strip("/"), [size for size in item.shape or () if size > 1]
    if item.dtype.names and len(shape) == 1:
        fields = [name for name in item.dtype.names if item.dtype[name].kind in "iuf"]
        yield from ((f"{path}/{name}", np.ravel(item[name])) for name in fields)
    elif item.dtype.kind in "iuf" and len(shape) == 1:
        yield path, np.ravel(item[()])
    elif item.dtype.kind in "iuf" and len(shape) == 2:
        matrix = np.squeeze(item[()])
        rows = matrix.T if shape[0] > shape[1] else matrix
        yield from ((f"{path}/{number}", row) for number, row in enumerate(rows, start=1))


def _told(item: Any, file: Any) -> tuple[str, float, str]:
    """Return the unit and the time from sample to sample [s] that attributes tell, 0 for none, and what to say of it."""
    unit = next((value for key, value in item.attrs.items() if key.lower() in _UNITS), "")
    unit = unit.decode(errors="replace") if isinstance(unit, bytes) else str(unit)
    for key, value in (pair for place in (item, item.parent, file) for pair in place.attrs.items()):
        word, number = "_".join(key.lower().split()), np.ravel(value)
        if (
            word in (*RATES, *STEPS)
            and number.size == 1
            and number.dtype.kind in "iuf"
            and 0 < number[0] < np.inf
        ):
            step_s = float(number[0]) if word in STEPS else 1.0 / float(number[0])
            return unit, step_s, f"{step_s:g} s from sample to sample, by the attribute {key!r}"
    return unit, 0.0, ""


READER = Reader(
    name="hdf5",
    suffixes=(".h5", ".hdf5", ".hdf"),
    description="HDF5: data sets as columns (extra lab)",
    tables=_tables,
)
