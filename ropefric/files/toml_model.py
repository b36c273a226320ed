"""TOML tables as pydantic models: readers of single values, and every mistake at once, in plain words, with its line."""

import datetime as dt
import types
from collections.abc import Callable, Collection, Mapping
from typing import Annotated, Any, ClassVar, NoReturn, TypeVar, Union, get_args, get_origin

import pydantic
from pydantic import BaseModel, Field, PlainValidator
from pydantic_core import PydanticCustomError
from pydantic_core.core_schema import CoreSchema, no_info_after_validator_function

from ropefric.errors import InputError, Problem
from ropefric.files.toml import KeyPath, TomlDocument, key_text
from ropefric.quantities import parse_any_quantity, parse_fraction, parse_quantity
from ropefric.registry import did_you_mean

M = TypeVar("M", bound=BaseModel)

CUSTOM = "ropefric"
"""The pydantic error type under which `reject` carries code, message, fix and key."""


class StrictTable(BaseModel):
    """A TOML table that refuses keys it does not know; of those it once knew, `gone` says what to do instead."""

    model_config = pydantic.ConfigDict(extra="forbid", frozen=True)
    gone: ClassVar[Mapping[str, str]] = {}

    @property
    def given(self) -> dict[str, Any]:
        """Return the fields that the file gives."""
        return {
            name: getattr(self, name) for name in type(self).model_fields if name in self.model_fields_set
        }


class Table:
    """How a TOML table makes an object, as annotation of a field: `Annotated[Adc, Table(Adc, {"bits": read})]`.

    Each argument of `make` has the reader or the type of its value, with its key where that is another word; what
    the file does not give is as `make` has it. An `InputError` of `make` is one of the table, with this `code` and
    without the `prefix` of its message.
    """

    def __init__(
        self,
        make: Callable[..., Any],
        arguments: Mapping[str, Any],
        *,
        needed: Collection[str] = (),
        code: str = "RF110",
        prefix: str = "",
    ) -> None:
        self._make, self._code, self._prefix = make, code, prefix
        columns: dict[str, Any] = {}
        for name, given in arguments.items():
            key, reader = given if isinstance(given, tuple) else (name, given)
            kind = reader if get_origin(reader) is not None else Annotated[Any, PlainValidator(reader)]
            columns[name] = (kind, Field(alias=key) if name in needed else Field(default=None, alias=key))
        self.model = pydantic.create_model("Table", __base__=StrictTable, **columns)

    def __get_pydantic_core_schema__(
        self, _source: Any, handler: pydantic.GetCoreSchemaHandler
    ) -> CoreSchema:
        return no_info_after_validator_function(self._made, handler.generate_schema(self.model))

    def _made(self, table: StrictTable) -> Any:
        try:
            return self._make(**table.given)
        except InputError as error:
            problem, field = error.problem, self.model.model_fields.get(error.problem.key)
            key = (field and field.alias) or problem.key
            reject(self._code, problem.message.removeprefix(self._prefix), fix=error.fix, key=key)


def reject(code: str, message: str, *, fix: str = "", key: str = "") -> NoReturn:
    """Refuse a value inside a pydantic validator."""
    raise PydanticCustomError(CUSTOM, "{message}", {"code": code, "message": message, "fix": fix, "key": key})


def got(value: object) -> str:
    """Return a TOML value as its writer would recognise it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return "a list"
    if isinstance(value, int) and value.bit_length() > 100:
        return "a huge number"
    shown = f'"{value}"' if isinstance(value, str) else str(value)
    return shown if len(shown) <= 60 else f"{shown[:57]}..."


def quantity(si_unit: str, like: str, *, above: float | None = None) -> Callable[[object], float]:
    """Return a reader of quantities written with their unit."""
    unit = like.partition(" ")[2]  # of the example, for a bare number's remedy

    def read(value: object) -> float:
        if not isinstance(value, str):
            bare = isinstance(value, int | float) and not isinstance(value, bool)
            fix = f'write it with its unit: "{got(value)} {unit}"' if bare else f'write "{like}"'
            reject("RF130" if bare else "RF110", f'expected text like "{like}", got {got(value)}', fix=fix)
        number = _converted(lambda: parse_quantity(value, si_unit), like)
        if above is not None and not number > above:
            reject("RF110", f"{got(value)} is not more than {above:g}", fix=f'write it like "{like}"')
        return number

    return read


def fraction(like: str) -> Callable[[object], float]:
    """Return a reader of shares written in per cent, from 0 to below 10 %."""

    def read(value: object) -> float:
        if not isinstance(value, str):
            reject("RF130", f'expected text like "{like}", got {got(value)}', fix=f'write it as "{like}"')
        number = _converted(lambda: parse_fraction(value), like)
        if not 0 <= number < 0.1:
            reject("RF110", f"{got(value)} is not between 0 % and 10 %", fix=f'write it like "{like}"')
        return number

    return read


def any_quantity(value: object) -> float:
    """Return a quantity of any unit, or a bare number, in SI."""
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        reject("RF110", f'expected a number or text like "490.9 mm^2", got {got(value)}')
    return _converted(lambda: parse_any_quantity(got(value).strip('"')), "490.9 mm^2")


def text(value: object) -> str:
    """Return a text, if it is one."""
    if not isinstance(value, str):
        reject("RF110", f"expected text in quotes, got {got(value)}", fix="put it in quotes")
    return value


def date_text(value: object) -> str:
    """Return a TOML date as ISO text."""
    if isinstance(value, dt.datetime):
        return value.date().isoformat()
    if not isinstance(value, dt.date):
        fix = "write it without quotes, for example 2026-01-15"
        reject("RF110", f"expected a date, got {got(value)}", fix=fix)
    return value.isoformat()


def choice(names: Callable[[], Collection[str]]) -> Callable[[object], str]:
    """Return a reader of one word out of `names()`, which is asked only when it is needed."""

    def read(value: object) -> str:
        known = names()
        if not isinstance(value, str) or value not in known:
            word = value if isinstance(value, str) else got(value)
            reject("RF120", f"{got(value)} is not known here", fix=did_you_mean(word, known))
        return value

    return read


def whole_number(lowest: int, highest: int = 2**31 - 1) -> Callable[[object], int]:
    """Return a reader of whole numbers from `lowest` to `highest`."""
    limit = f"from {lowest} to {highest}" if highest < 2**31 - 1 else f"of at least {lowest}"

    def read(value: object) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not lowest <= value <= highest:
            reject("RF110", f"expected a whole number {limit}, got {got(value)}")
        return value

    read.__doc__ = f"a whole number {limit}"  # for the documentation's page of keys
    return read


def _converted(read: Callable[[], float], like: str) -> float:
    try:
        return read()
    except InputError as error:
        message = error.problem.message.removeprefix("quantity: ")
        reject(error.code, message, fix=error.fix or f'write it like "{like}"')


def validate_document(model: type[M], document: TomlDocument) -> tuple[M | None, tuple[Problem, ...]]:
    """Return a document as a model, or its errors."""
    try:
        return model.model_validate(dict(document.data)), ()
    except pydantic.ValidationError as error:
        problems = [
            _problem(model, document, item) for item in error.errors(include_url=False, include_input=True)
        ]
    return None, tuple(sorted(problems, key=lambda p: (p.line or 0, p.key, p.message)))


def _problem(model: type[BaseModel], document: TomlDocument, item: Any) -> Problem:
    key: KeyPath = tuple(item["loc"])
    kind, value, context = item["type"], item["input"], item.get("ctx", {})
    if kind == CUSTOM:
        place = (*key, *context["key"].split(".")) if context["key"] else key
        return document.problem(place, context["code"], context["message"], fix=context["fix"])
    name, table = str(key[-1]), key_text(key[:-1])
    if kind == "missing":
        where = f"the table [{table}]" if table else "the file"
        return document.problem(key, "RF121", f"'{name}' is missing in {where}", fix=f"add {name} to {where}")
    if kind == "extra_forbidden":
        owner = _model_at(model, key[:-1])
        known = [field.alias or name for name, field in owner.model_fields.items()] if owner else []
        where, gone = f" in [{table}]" if table else "", getattr(owner, "gone", {})
        if name in gone:
            return document.problem(key, "RF120", f"there is no '{name}'{where} any more", fix=gone[name])
        return document.problem(key, "RF120", f"unknown key '{name}'{where}", fix=did_you_mean(name, known))
    if kind.removesuffix("_type") in ("model", "model_attributes", "dict"):
        fix = f"open a table with [{key_text(key)}] on a line of its own"
        return document.problem(key, "RF110", f"expected a table, got {got(value)}", fix=fix)
    expected = "a list" if kind in ("list_type", "tuple_type") else "something else"
    return document.problem(key, "RF110", f"expected {expected}, got {got(value)}")


def _model_at(model: type[BaseModel], key: KeyPath) -> type[BaseModel] | None:
    """Follow a key down the model's annotations: tables, mappings of tables, optional ones."""
    found: Any = model
    for part in key:
        found = _of_arms(_arms_of_field(found, str(part)) if _is_model(found) else get_args(found)[-1:])
    return found if _is_model(found) else None


def _is_model(found: Any) -> bool:
    return isinstance(found, type) and issubclass(found, BaseModel)


def _arms_of_field(model: type[BaseModel], key: str) -> tuple[Any, ...]:
    """Return the annotation of a field and what belongs to it, in the order of `get_args`."""
    fields = {field.alias or name: field for name, field in model.model_fields.items()}
    return (fields[key].annotation, *fields[key].metadata) if key in fields else ()


def _of_arms(arms: tuple[Any, ...]) -> Any:
    """Return the model of an annotation, or the annotation without what it has beside its type."""
    found = arms[0] if arms else None
    if get_origin(found) is Annotated:
        arms = get_args(found)
    table = next((arm for arm in arms if isinstance(arm, Table)), None)
    if table is not None:
        return table.model
    if get_origin(found) in (Union, types.UnionType):
        return next((arm for arm in get_args(found) if arm is not type(None)), None)
    return found
