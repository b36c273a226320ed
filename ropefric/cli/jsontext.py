"""Results as strict JSON: sorted keys, no NaN, plain ASCII, so that any program can read it."""

import json
import math
from collections.abc import Mapping
from os import PathLike, fspath
from typing import Any


def json_text(data: Any) -> str:
    """Return `data` as one strict JSON document, keys sorted, NaN and infinities as null."""
    return json.dumps(_plain(data), indent=2, sort_keys=True, allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, PathLike):
        return fspath(value)
    if hasattr(value, "tolist"):  # NumPy scalars and arrays, without loading NumPy to ask
        return _plain(value.tolist())
    raise TypeError(f"{type(value).__name__} has no place in a JSON result")
