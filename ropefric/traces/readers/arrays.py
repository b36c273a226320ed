"""A table out of arrays that a binary format holds."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.traces.readers.source import Source
from ropefric.traces.readers.table import Table


def array_table(
    columns: Mapping[str, np.ndarray[Any, Any]],
    source: Source,
    *,
    units: Mapping[str, str] | None = None,
    time_s: FloatArray | None = None,
) -> Table:
    """Return a table of named arrays; blank names are columns that have numbers only."""
    keys = list(columns)

    def values(indices: Sequence[int]) -> list[FloatArray]:
        found = [_real(keys[index], index, columns[keys[index]], source) for index in indices]
        sizes = {index: array.size for index, array in zip(indices, found, strict=True)}
        if len(set(sizes.values())) > 1:
            told = ", ".join(
                f"{keys[i].strip() or f'column {i + 1}'} has {size}{' values' if i == indices[0] else ''}"
                for i, size in sizes.items()
            )
            raise source.error(
                f"the columns differ in length: {told}", code="RF103", fix="save them with one length"
            )
        if found and found[0].size == 0:
            raise source.error("there are no data rows")
        return found

    return Table(
        names=tuple(key.strip() for key in keys),
        units=tuple((units or {}).get(key, "") for key in keys),
        values=values,
        has_header=any(key.strip() for key in keys),
        time_s=time_s,
    )


def _real(name: str, index: int, values: np.ndarray[Any, Any], source: Source) -> FloatArray:
    key = name.strip() or f"column {index + 1}"
    if values.dtype.kind not in "iuf":
        raise source.error(
            f"the column holds {values.dtype} values, not real numbers",
            code="RF102",
            key=key,
            fix="name another column, or save this one as numbers",
        )
    array = values.astype(np.float64)
    infinite = np.isinf(array)
    if infinite.any():
        raise source.error(
            f"sample {int(np.argmax(infinite)) + 1} is infinite, which is no measurement",
            code="RF102",
            key=key,
            fix="save NaN where a sample is missing",
        )
    return array
