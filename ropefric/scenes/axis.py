"""An axis of a sweep: a key of the scene and the values it is to take."""

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import BaseModel

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, UnknownNameError
from ropefric.files.toml import TomlDocument
from ropefric.registry import did_you_mean
from ropefric.scenes.scene import Scene, read_scene

MOST_POINTS = 10_000_000
"""Of an axis, and of a whole grid: some 2.5 GB."""
_NUMBER = re.compile(r"\s*+([+-]?[\d.]++(?:[eE][+-]?\d++)?)")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Axis:
    """A key of a scene and its values."""

    key: str
    values: FloatArray
    unit: str
    factor: float


def parse_axis(scene: Scene, text: str) -> Axis:
    """Return the axis that "KEY=START:STOP:COUNT" or "KEY=A,B,C" asks for."""
    key, equals, values = (part.strip() for part in text.partition("="))
    if not equals or not key or not values:
        raise InputError(
            f"--sweep {text!r} is not KEY=START:STOP:COUNT or KEY=A,B,C",
            key="--sweep",
            fix='write it like  --sweep "wheel.wrap=90deg:1440deg:50"',
        )
    known = scalar_keys(scene)
    if key not in known:
        raise UnknownNameError(
            f"the scene gives no number {key!r} that could be swept",
            key="--sweep",
            fix=f"{did_you_mean(key, known)}; a key that the scene leaves out must be written into it first",
        )
    if ":" in values:
        return _range(scene, key, values)
    texts = [part.strip() for part in values.split(",")]
    found = np.array([_si(scene, key, part) for part in texts])
    unit, factor = _unit(texts[-1], float(found[-1]))
    return Axis(key=key, values=found, unit=unit, factor=factor)


def _range(scene: Scene, key: str, text: str) -> Axis:
    parts = [part.strip() for part in text.split(":")]
    spaced = parts[3] if len(parts) == 4 else "linear"
    counted = len(parts) in (3, 4) and parts[2].isdecimal() and len(parts[2]) < 20
    count = int(parts[2]) if counted else 0
    if not 2 <= count <= MOST_POINTS or spaced not in {"linear", "log"}:
        raise InputError(
            f"{text!r} is not START:STOP:COUNT with a count from 2 to {MOST_POINTS}",
            key="--sweep",
            fix="write it like  90deg:1440deg:50  or, in equal ratios,  90deg:1440deg:50:log",
        )
    start, stop = (_si(scene, key, part) for part in parts[:2])
    if spaced == "log":
        if not (start > 0.0 and stop > 0.0):
            raise InputError(f"{text!r} has no equal ratios: both ends must be positive", key="--sweep")
        values = np.geomspace(start, stop, count)
    else:
        values = np.linspace(start, stop, count)
    unit, factor = _unit(parts[1], stop)
    return Axis(key=key, values=values, unit=unit, factor=factor)


def _si(scene: Scene, key: str, text: str) -> float:
    """Return a value in SI, read and checked by the scene itself."""
    now = _at(scene.document.data, key)
    written: Any = text if isinstance(now, str) else _bare(key, text)
    changed = read_scene(
        TomlDocument(path=scene.document.path, data=_with(scene.document.data, key, written), lines={}),
        scene.folder,
    )
    return float(_at(changed.table, key))


def _bare(key: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(
            f"{key}: {text!r} is no number", key="--sweep", fix="write it without unit"
        ) from None


def _unit(text: str, si_value: float) -> tuple[str, float]:
    """Return the unit in which a value was written, and how much of SI one of it is."""
    found = _NUMBER.match(text)
    unit = text[found.end() :].strip() if found else text
    if not unit:
        return "", 1.0
    written = float(found[1]) if found else 1.0
    return unit, si_value / written if written else 1.0


def scalar_keys(scene: Scene) -> tuple[str, ...]:
    """Return the keys of a scene that hold a number, with or without unit."""
    return tuple(
        key
        for key, _ in _leaves(scene.document.data)
        if isinstance(_at(scene.table, key), int | float) and key != "accuracy"
    )


def _leaves(tree: Any, prefix: str = "") -> list[tuple[str, Any]]:
    found = []
    for name, value in tree.items():
        key = f"{prefix}.{name}" if prefix else str(name)
        found += _leaves(value, key) if isinstance(value, dict) else [(key, value)]
    return found


def _at(tree: Any, key: str) -> Any:
    """Return what stands at a key of a TOML tree or of the table made from it; None where nothing does."""
    for name in key.split("."):
        if isinstance(tree, BaseModel):
            fields = {field.alias or own: own for own, field in type(tree).model_fields.items()}
            tree = getattr(tree, fields[name]) if name in fields else None
        else:
            tree = tree.get(name) if isinstance(tree, dict) else None
    return tree


def _with(tree: Any, key: str, value: Any) -> dict[str, Any]:
    name, _, rest = key.partition(".")
    return {**tree, name: _with(tree[name], rest, value) if rest else value}


def replaced(table: Any, key: str, value: float) -> Any:
    """Return a checked table with another SI value at a key; the value itself is not checked again."""
    name, _, rest = key.partition(".")
    if isinstance(table, dict):
        return {**table, name: replaced(table[name], rest, value) if rest else value}
    fields = {field.alias or own: own for own, field in type(table).model_fields.items()}
    own = fields[name]
    new = replaced(getattr(table, own), rest, value) if rest else value
    return table.model_copy(update={own: new})
