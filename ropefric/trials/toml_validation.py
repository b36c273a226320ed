"""A TOML tree against a pydantic model: every problem at once, in plain words, each with its line."""

import types
from typing import Any, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError

from ropefric.errors import Problem
from ropefric.registry import did_you_mean
from ropefric.trials.toml_document import TomlDocument
from ropefric.trials.toml_fields import CUSTOM, got
from ropefric.trials.toml_lines import KeyPath, key_text

M = TypeVar("M", bound=BaseModel)


def validate_document(model: type[M], document: TomlDocument) -> tuple[M | None, tuple[Problem, ...]]:
    """Return a document as a model, or what is wrong with it."""
    try:
        return model.model_validate(dict(document.data)), ()
    except ValidationError as error:
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
    if kind == "missing":
        return _missing(document, key)
    if kind == "extra_forbidden":
        return _unknown(model, document, key)
    expected = {
        "model_type": "a table",
        "model_attributes_type": "a table",
        "dict_type": "a table",
        "list_type": "a list",
        "tuple_type": "a list",
    }.get(kind, "something else")
    return document.problem(
        key,
        "RF110",
        f"expected {expected}, got {got(value)}",
        fix=_table_fix(key) if "table" in expected else "",
    )


def _table_fix(key: KeyPath) -> str:
    return f"open a table with [{key_text(key)}] on a line of its own"


def _missing(document: TomlDocument, key: KeyPath) -> Problem:
    table = key_text(key[:-1])
    where = f"the table [{table}]" if table else "the file"
    name = key[-1]
    return document.problem(key, "RF121", f"'{name}' is missing in {where}", fix=f"add {name} to {where}")


def _unknown(model: type[BaseModel], document: TomlDocument, key: KeyPath) -> Problem:
    owner = _model_at(model, key[:-1])
    known = [] if owner is None else [field.alias or name for name, field in owner.model_fields.items()]
    message = f"unknown key '{key[-1]}'" + (f" in [{key_text(key[:-1])}]" if key[:-1] else "")
    return document.problem(key, "RF120", message, fix=did_you_mean(str(key[-1]), known))


def _model_at(model: type[BaseModel], key: KeyPath) -> type[BaseModel] | None:
    """Follow a key down the model's annotations: tables, mappings of tables, optional ones."""
    found: Any = model
    for part in key:
        if isinstance(found, type) and issubclass(found, BaseModel):
            fields = {field.alias or name: field for name, field in found.model_fields.items()}
            found = fields[str(part)].annotation if part in fields else None
        else:
            found = get_args(found)[-1] if get_args(found) else None
        if get_origin(found) in (Union, types.UnionType):
            found = next((arm for arm in get_args(found) if arm is not type(None)), None)
    return found if isinstance(found, type) and issubclass(found, BaseModel) else None
