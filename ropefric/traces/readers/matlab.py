"""MATLAB files up to version 7."""

import io
from collections.abc import Mapping
from typing import Any

import numpy as np

from ropefric.files.text import Source
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.readers.table import Reader, Table, array_table, check_choice, foreign

_HDF5 = b"\x89HDF\r\n\x1a\n"


def _tables(source: Source, profile: ImportProfile) -> tuple[Table, ...]:
    """Return the file's one table: a matrix, a struct of vectors, or the vectors of the workspace."""
    variables = _load(source)
    check_choice(profile.table, variables, "variable", source)
    columns = _columns(profile.table, variables[profile.table]) if profile.table else _first(variables)
    if not columns:
        why = f"no variable holds columns of numbers; the file has {', '.join(variables) or 'no variables'}"
        fix = "save vectors, a matrix, or a struct of vectors; a MATLAB table by table2struct(T, 'ToScalar', true)"
        raise source.error(why, fix=fix)
    return (array_table(columns, source),)


def _load(source: Source) -> dict[str, np.ndarray[Any, Any]]:
    from scipy.io import loadmat  # noqa: PLC0415  (slow to load, and few campaigns hold MATLAB files)

    raw = source.raw_bytes()
    if _HDF5 in (raw[:8], raw[512:520]) or raw.startswith(b"MATLAB 7.3"):
        fix = "save it in MATLAB with save('run.mat', ..., '-v7'), or export CSV"
        raise source.error("this is a MATLAB v7.3 (HDF5) file, which is not read here", fix=fix)
    fix = "save it again with save('run.mat', ..., '-v7'), or name its format in [import] format"
    # Variables that cannot be read are reported missing.
    with foreign(source, "this is not a readable MATLAB file", fix):
        content = loadmat(io.BytesIO(raw))  # type: ignore[arg-type]
    return {
        str(name): value
        for name, value in content.items()
        if not str(name).startswith("__") and isinstance(value, np.ndarray)
    }


def _first(variables: Mapping[str, np.ndarray[Any, Any]]) -> dict[str, np.ndarray[Any, Any]]:
    """Return the workspace's vectors of the most common length, else the first struct, else the first matrix."""
    vectors = {name: value.ravel() for name, value in variables.items() if _is_vector(value)}
    if len(vectors) > 1:
        return vectors
    structs = {name: value for name, value in variables.items() if value.dtype.names}
    matrices = {name: value for name, value in variables.items() if min(value.shape, default=0) > 1}
    found = (_columns(name, value) for name, value in (*structs.items(), *matrices.items()))
    return next(filter(None, found), vectors)


def _columns(name: str, value: np.ndarray[Any, Any]) -> dict[str, np.ndarray[Any, Any]]:
    """Return the columns of a struct of vectors, a vector or a matrix; none of anything else."""
    if value.dtype.names:
        fields = {key: np.asarray(value[key].item()) for key in value.dtype.names if value.size == 1}
        return {key: field.ravel() for key, field in fields.items() if _is_vector(field)}
    if _is_vector(value):
        return {name: value.ravel()}
    if not _is_numeric(value) or value.ndim != 2 or value.size == 0:
        return {}
    # Blank names: a matrix has numbered columns only, and a blank cannot be a MATLAB name.
    return {" " * (i + 1): value[:, i] for i in range(value.shape[1])}


def _is_numeric(value: np.ndarray[Any, Any]) -> bool:
    return value.dtype.kind in "iuf"


def _is_vector(value: np.ndarray[Any, Any]) -> bool:
    return _is_numeric(value) and value.size > 1 and value.size == max(value.shape, default=0)


READER = Reader(
    name="matlab",
    suffixes=(".mat",),
    description="MATLAB up to version 7: vectors, a struct of vectors, or a matrix",
    tables=_tables,
)
