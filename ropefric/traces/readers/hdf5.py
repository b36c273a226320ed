"""HDF5: data sets as columns, called by their paths; needs the extra `lab`."""

import io
import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.files.text import Source
from ropefric.registry import did_you_mean
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import Reader, Table, array_table, foreign, needs_package

RATES = (
    "sampling_rate",
    "sample_rate",
    "sampling_rate_hz",
    "sample_rate_hz",
    "sampling_frequency",
    "fs",
    "rate_hz",
)
"""Attributes that tell samples per second, of a data set, its group or the file, whatever their case and blanks."""
STEPS = ("dt", "dt_s", "wf_increment", "sampling_interval", "sample_interval", "time_step")
"""Attributes that tell seconds from sample to sample."""
_UNITS = ("unit", "units", "unit_string")


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return the data sets of the group that the profile names, else all of the most common length."""
    try:
        import h5py  # noqa: PLC0415  (an extra that is not always there)
    except ImportError:
        raise needs_package("HDF5 needs the package h5py", source) from None
    fix = "copy it again, or name its format in [import] format"
    with (
        foreign(source, "this is not a readable HDF5 file", fix),
        h5py.File(io.BytesIO(source.raw_bytes())) as file,
    ):
        found = dict(_columns(file, h5py))
        group = profile.table.strip("/")
        under = re.compile(rf"{re.escape(group)}(?:$|[/\[])" if group else "")
        chosen = {path: column for path, column in found.items() if under.match(path)}
        if not chosen:
            listed = ", ".join(found) or "none"
            why = (
                f"no numbers under {group!r}" if group and found else "no data set holds a column of numbers"
            )
            fix = (
                did_you_mean(group, {path.rpartition("/")[0] for path in found})
                if group
                else "record it again"
            )
            raise source.error(
                f"{why}; the file has {listed[:300]}", code="RF105", key="[import] table", fix=fix
            )
        columns = {path.removeprefix(f"{group}/"): column for path, column in chosen.items()}
    steps = {path: step_s for path, (_, _, step_s, _) in columns.items() if step_s is not None}
    said = [f"HDF5: {', '.join(found)[:300]}"]
    said += dict.fromkeys(f"{step_s:g} s from sample to sample, by the attribute {attribute!r}"
                          for _, _, step_s, attribute in columns.values() if step_s is not None)  # fmt: skip
    arrays = {path: values for path, (values, *_) in columns.items()}
    names = [*arrays]

    def clock(index: int) -> FloatArray | None:
        step_s = steps.get(names[index])
        return None if step_s is None else np.arange(arrays[names[index]].size, dtype=np.float64) * step_s

    units = {path: unit for path, (_, unit, _, _) in columns.items()}
    return (array_table(arrays, source, units=units, clock=clock if steps else None, notes=said),)


_Column = tuple[np.ndarray[Any, Any], str, float | None, str]


def _columns(file: Any, h5py: Any) -> Iterator[tuple[str, _Column]]:
    """Yield path and content of every column of numbers; links out of the file are not followed."""
    paths: list[str] = []
    file.visit(paths.append)
    for path in paths:
        item = file[path]
        if not isinstance(item, h5py.Dataset) or item.is_virtual or item.external or item.size < 2:
            continue
        unit = next((_text(item.attrs[key]) for key in item.attrs if key.lower() in _UNITS), "")
        step_s, attribute = _step_s((item, item.parent, file))
        shape = [size for size in item.shape if size > 1]
        if item.dtype.names and len(shape) == 1:
            for name in item.dtype.names:
                if item.dtype[name].kind in "iuf":
                    yield f"{path}/{name}", (np.ravel(item[name]), unit, step_s, attribute)
        elif item.dtype.kind in "iuf" and len(shape) == 1:
            yield path, (np.ravel(item[()]), unit, step_s, attribute)
        elif item.dtype.kind in "iuf" and len(shape) == 2:
            matrix = np.squeeze(item[()])
            for number, row in enumerate(matrix.T if matrix.shape[0] > matrix.shape[1] else matrix, start=1):
                yield f"{path}[{number}]", (row, unit, step_s, attribute)


def _step_s(places: tuple[Any, ...]) -> tuple[float | None, str]:
    """Return the time from sample to sample that the nearest attribute tells, and its name."""
    for place in places:
        for key, value in place.attrs.items():
            word = "_".join(key.lower().split())
            number = np.ravel(value)
            if number.size == 1 and number.dtype.kind in "iuf" and 0 < float(number[0]) < np.inf:
                if word in RATES:
                    return 1.0 / float(number[0]), key
                if word in STEPS:
                    return float(number[0]), key
    return None, ""


def _text(value: Any) -> str:
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)


READER = Reader(
    name="hdf5",
    suffixes=(".h5", ".hdf5", ".hdf"),
    description="HDF5: data sets as columns (extra lab)",
    tables=_tables,
)
