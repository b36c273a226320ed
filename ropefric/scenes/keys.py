"""Every key that a scene can hold, from the declarations of its schema: unit, example, default, range and meaning."""

import inspect
import json
import tomllib
import typing
from collections.abc import Iterable, Iterator

from pydantic import BaseModel, PlainValidator
from pydantic.fields import FieldInfo

from ropefric.scenes.kind import Key, tables_in, types_in
from ropefric.scenes.kinds import KINDS
from ropefric.scenes.scene_templates import scene_text


class SceneKey(typing.NamedTuple):
    """One key; in the table `[wheel]` its name is `wheel.radius`, and a `…` is a name that the user chooses.

    A `[]` is the place in a list; `choices` are the words that the key may be, where it is one of some.
    """

    name: str
    unit: str
    example: str
    default: str
    allowed: str
    meaning: str
    choices: tuple[str, ...] = ()


def keys_of(names: Iterable[str]) -> dict[str, tuple[SceneKey, ...]]:
    """Return all keys of the systems of some bundled scenes, by system.

    >>> keys = {key.name: key for key in keys_of(["climbing-hoist"])["hoist"]}
    >>> keys["wheel.radius"].example, keys["wheel.radius"].default
    ('"40 mm"', 'needed')
    """
    systems = dict.fromkeys(tomllib.loads(scene_text(name))["system"] for name in names)
    return {system: tuple(scene_keys(KINDS[system].schema)) for system in systems}


def scene_keys(schema: type[BaseModel], prefix: str = "") -> Iterator[SceneKey]:
    """Yield each key of a schema, those of its tables included."""
    meanings = _meanings(schema)
    for name, info in schema.model_fields.items():
        tables = tables_in(info)
        holder = typing.get_origin(info.annotation)
        for table in tables:
            between = ".…." if holder is dict else "[]." if holder is list else "."
            yield from scene_keys(table, prefix + name + between)
        if not tables:
            yield _scene_key(prefix + name, info, meanings.get(name, ""))


def _meanings(schema: type[BaseModel]) -> dict[str, str]:
    """Return what the docstrings of a schema and its bases say of their keys, a line `name : meaning` each."""
    lines = [
        line.partition(" : ")
        for one in reversed(schema.__mro__)
        for line in (inspect.getdoc(one) or "").splitlines()
    ]
    return {name: meaning for name, mark, meaning in lines if mark and name.isidentifier()}


def _scene_key(name: str, info: FieldInfo, text: str) -> SceneKey:
    """Return the key of a field that is no table."""
    declared = [*info.metadata, *_declared(info.annotation)]
    key = next((one for one in declared if isinstance(one, Key)), Key(""))
    default = "needed" if info.is_required() else ""
    if isinstance(info.default, str | float | int | bool):
        default = f"{info.default:g} {key.si_unit}" if key.like else json.dumps(info.default)
    example = f'"{key.like}"' if key.like else ""
    if key.like and key in _declared(info.annotation):
        example = f"[{example}, …]"
    unit = key.si_unit or ("-" if {float, int} & {*types_in(info.annotation)} else "")
    choices = _choices(declared)
    allowed = ", ".join(choices) or _range(info.annotation, key, declared)
    return SceneKey(name, unit, example, default, allowed, text, choices)


def _declared(annotation: typing.Any) -> list[typing.Any]:
    """Return the declarations of a type, and of the types in it, such as the numbers of an optional list."""
    inner = [one for part in typing.get_args(annotation) for one in _declared(part)]
    return [*getattr(annotation, "__metadata__", ()), *inner]


def _readers(declared: Iterable[typing.Any]) -> Iterator[typing.Any]:
    return (one.func for one in declared if isinstance(one, PlainValidator))


def _choices(declared: Iterable[typing.Any]) -> tuple[str, ...]:
    """Return the words that a key may be."""
    found = (inspect.getclosurevars(read).nonlocals.get("names") for read in _readers(declared))
    return next((tuple(names()) for names in found if names is not None), ())


def _range(annotation: typing.Any, key: Key, declared: Iterable[typing.Any]) -> str:
    """Return the range of a key, as its reader has it."""
    if key.like:
        return key.range
    for read in _readers(declared):
        if read.__doc__ and not read.__doc__.startswith("Return"):
            return str(read.__doc__)
    if typing.get_origin(annotation) is dict:
        return "a table"
    return {bool: "true or false", float: "any", str: "text"}[next(types_in(annotation))]
