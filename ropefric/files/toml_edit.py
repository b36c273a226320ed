"""Single values of a TOML file changed in its text, so that comments, order and all other keys stay as they are."""

import json
import re
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from ropefric.errors import DataError
from ropefric.files.toml import key_text, value_spans

Keys = tuple[str, ...]
"""The keys that lead from the top of a TOML file to a value, none of them in an array."""

_HEADING = re.compile(r"^(# ?)?\[([^\[\]\n]+)\][ \t]*(?:#[^\n]*)?\r?(?:\n|\Z)", re.MULTILINE)
_ANY_HEADING = re.compile(r"^(?:# ?)?\[", re.MULTILINE)
_WAITING = r'^# ?({} *= *)(?:"[^"\n]*"|\[[^]\n]*\]|[^\s#"\[]+)'
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def with_values(text: str, values: Mapping[Keys, Any]) -> str:
    r"""Return a TOML text in which some keys have other values; None for one that is removed.

    A table or key that waits as a comment (`# [tare]`, `# interval = ...`) is put to use; any other new key follows the
    heading of its table, and a new table the end of the text. A table that has lost its last key is removed.

    Raises
    ------
    DataError
        RF105 if a key cannot be changed without others being changed too.

    Examples
    --------
    >>> text = 'name = "A"  # mine\n[rope]\n# diameter = "1 mm"\n'
    >>> print(with_values(text, {("rope", "diameter"): "9 mm"}), end="")
    name = "A"  # mine
    [rope]
    diameter = "9 mm"
    """
    for path, value in values.items():
        wanted = _changed(tomllib.loads(text), path, value)
        text = _without(text, path) if value is None else _with_value(text, path, value)
        try:
            is_done = tomllib.loads(text) == wanted
        except tomllib.TOMLDecodeError:
            is_done = False
        if not is_done:
            why = "this key shares its line or table with others, and is not changed here"
            raise DataError(why, code="RF105", key=key_text(path), fix="change it in an editor")
    return text


def toml_value(value: Any) -> str:
    """Return a text, number, list or mapping as TOML writes it in one line."""
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{toml_key(key)} = {toml_value(one)}' for key, one in value.items())} }}"
    # JSON's escapes are TOML's, but for the delete character.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def toml_key(key: str) -> str:
    """Return a key as TOML writes it: in quotes where it is more than a bare word."""
    return key if _BARE_KEY.fullmatch(key) else toml_value(key)


def _changed(tree: dict[str, Any], path: Keys, value: Any) -> dict[str, Any]:
    """Return a tree with another value at a place; for None without it, and without tables that are then empty."""
    *above, last = path
    table, tables = tree, [tree]
    for name in above:
        table = table.setdefault(name, {})
        if not isinstance(table, dict):
            fix = f"write [{name}] with its keys, or remove {name}"
            raise DataError(f"{name} is a value where a table is needed", key=name, fix=fix)
        tables.append(table)
    table[last] = value
    if value is None:
        del table[last]
        for outer, name, inner in reversed([*zip(tables, above, tables[1:], strict=False)]):
            if not inner:
                del outer[name]
    return tree


def _with_value(text: str, path: Keys, value: Any) -> str:
    """Return a text in which a key has a value: in its place, in an inline table, or in a line of its own."""
    spans, table, last = value_spans(text), path[:-1], path[-1]
    if path in spans:
        start, stop = spans[path]
        return text[:start] + toml_value(value) + text[stop:]
    if isinstance(value, Mapping) and _heading(text, path):
        old = _value_at(text, path)
        changed = [key for key in {**old, **value} if old.get(key) != value.get(key)]
        return with_values(text, {(*path, key): value.get(key) for key in changed})
    if table in spans:
        return _with_value(text, table, {**_value_at(text, table), last: value})
    return _with_line(text, table, last, value)


def _with_line(text: str, table: Keys, key: str, value: Any) -> str:
    """Return a text with a new key: in the line that waits for it, below the heading of its table, or at the end."""
    end = "\r\n" if "\r\n" in text else "\n"
    line, heading, start = f"{toml_key(key)} = {toml_value(value)}{end}", _heading(text, table), 0
    if table and heading is None:
        gap = "" if text.endswith(2 * end) else end if text.endswith(end) else 2 * end
        return f"{text}{gap}[{'.'.join(map(toml_key, table))}]{end}{line}"
    if heading is not None:
        mark = heading[1] or ""
        text = text[: heading.start()] + text[heading.start() + len(mark) :]
        start = heading.end() - len(mark)
    following = _ANY_HEADING.search(text, start)
    stop = following.start() if following else len(text)
    waiting = re.compile(_WAITING.format(re.escape(toml_key(key))), re.MULTILINE).search(text, start, stop)
    if waiting is None:
        return text[:start] + line + text[start:]
    return text[: waiting.start()] + waiting[1] + toml_value(value) + text[waiting.end() :]


def _heading(text: str, table: Keys) -> re.Match[str] | None:
    """Return the line that begins a table, perhaps as a comment."""
    for found in _HEADING.finditer(text):
        with suppress(tomllib.TOMLDecodeError):
            if _value_at(f"[{found[2]}]", table) == {}:
                return found
    return None


def _value_at(text: str, path: Keys) -> Any:
    value: Any = tomllib.loads(text)
    for name in path:
        value = value.get(name) if isinstance(value, dict) else None
    return value


def _without(text: str, path: Keys) -> str:
    """Return a text without the line of a key, and without the headings of tables that are then empty."""
    start, stop = value_spans(text).get(path, (0, 0))
    if not stop:
        return text
    text = text[: text.rfind("\n", 0, start) + 1] + text[text.find("\n", stop) + 1 or len(text) :]
    for size in range(len(path) - 1, 0, -1):
        heading = _heading(text, path[:size])
        if heading is not None and not heading[1] and _value_at(text, path[:size]) == {}:
            text = text[: heading.start()] + text[heading.end() :]
    return text
