"""What a scene can say, as its kind declares it: every key with unit, example, default, range and meaning."""

import inspect
import json
import re
import typing
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from pydantic import BaseModel, PlainValidator
from pydantic.fields import FieldInfo

from ropefric.files.toml_model import StrictTable
from ropefric.scenes.kind import Key

_MEANING = re.compile(r"^(\w++) : (.++)$", re.MULTILINE)


class DeclaredKey(NamedTuple):
    """A key of a scene; texts are empty where nothing is declared.

    A `…` in its name stands for a name of the user's, `[]` for the place in a list. `choices` are the words it may be.
    """

    name: str
    unit: str
    like: str
    default: str
    allowed: str
    choices: tuple[str, ...]
    meaning: str
    is_needed: bool


def declared_keys(schema: type[BaseModel], prefix: str = "") -> Iterator[DeclaredKey]:
    """Yield every key of a schema, those of its tables included."""
    meanings: dict[str, str] = {}
    for one in reversed(schema.__mro__):
        meanings |= _MEANING.findall(inspect.getdoc(one) or "")
    for name, info in schema.model_fields.items():
        tables = [one for one in _types(info.annotation) if issubclass(one, StrictTable)]
        holder = typing.get_origin(info.annotation)
        place = ".…." if holder is dict else "[]." if holder is list else "."
        for table in tables:
            yield from declared_keys(table, prefix + name + place)
        if not tables:
            yield _declared(prefix + name, info, meanings.get(name, ""))


def _declared(name: str, info: FieldInfo, meaning: str) -> DeclaredKey:
    """Return a key that holds a value."""
    types, inner = {*_types(info.annotation)}, _said_of(info.annotation)
    said = [*info.metadata, *inner]
    key = next((one for one in said if isinstance(one, Key)), Key(""))
    default, like = "", f'"{key.like}"' if key.like else ""
    if isinstance(info.default, str | float | int | bool):
        default = f"{info.default:g} {key.si_unit}" if key.like else json.dumps(info.default)
    unit = key.si_unit or ("-" if {float, int} & types else "")
    # What a number may be is not the reader's to say where the mechanics says it.
    meaning, mark, rest = meaning.partition(" (zero or more)")
    choices = _choices(said)
    return DeclaredKey(
        name=name,
        unit=unit,
        like=f"[{like}, …]" if key in inner else like,
        default=default,
        allowed="zero or more" if mark else "" if choices else _range(info.annotation, key, said),
        choices=choices,
        meaning=meaning + rest,
        is_needed=info.is_required(),
    )


def _said_of(annotation: Any) -> list[Any]:
    """Return what is said of a type, such as of the numbers in an optional list."""
    inner = [said for one in typing.get_args(annotation) for said in _said_of(one)]
    return [*getattr(annotation, "__metadata__", ()), *inner]


def _readers(said: Iterable[Any]) -> Iterator[Any]:
    return (one.func for one in said if isinstance(one, PlainValidator))


def _choices(said: Iterable[Any]) -> tuple[str, ...]:
    """Return the words that a key may be."""
    found = (inspect.getclosurevars(read).nonlocals.get("names") for read in _readers(said))
    return next((tuple(names()) for names in found if names is not None), ())


def _range(annotation: Any, key: Key, said: Iterable[Any]) -> str:
    """Return what the value of a key may be, as its reader has it."""
    if key.like:
        return "any" if key.above is None else f"more than {key.above:g}"
    for read in _readers(said):
        if read.__doc__ and not read.__doc__.startswith("Return"):
            return str(read.__doc__)
    if typing.get_origin(annotation) is dict:
        return "a table"
    return {bool: "true or false", float: "any", str: "text"}[next(_types(annotation))]


def _types(annotation: Any) -> Iterator[type]:
    """Yield the classes in an annotation, such as the table in `dict[str, Table]`."""
    inner = typing.get_args(annotation)
    for one in inner or (annotation,):
        if inner:
            yield from _types(one)
        elif isinstance(one, type):
            yield one
