"""Single values of a TOML file changed in its text, so that comments, order and all other keys stay as they are."""

import json
import re
import tomllib
from collections.abc import Mapping
from typing import Any

from ropefric.errors import DataError
from ropefric.files.toml import HEADING, KEY, key_text, names_of, toml_lines

Keys = tuple[str, ...]
"""The keys that lead from the top of a TOML file to a value, none of them in an array."""

_VALUE = re.compile(r"""[^=\n]*=[ \t]*("(?:\\.|[^"\\\n])*"|'[^'\n]*'|\[[^\n]*\]|\{[^\n]*\}|[^\s#"'\[{]+)""")
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def with_values(text: str, values: Mapping[Keys, Any]) -> str:
    r"""Return a TOML text in which some keys have other values; None for one that is removed.

    A new key follows the heading of its table, and a new table the end of the text. A table that has lost its last key
    is removed.

    Raises
    ------
    DataError
        RF105 if a key cannot be changed without others being changed too.

    Examples
    --------
    >>> text = 'name = "A"  # mine\n[rope]\n'
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


def _line_of(text: str, path: Keys) -> tuple[int, int]:
    """Return from where to where the line of a key or heading goes; (0, 0) where it has none."""
    lines, number = text.split("\n"), toml_lines(text).get(path)
    if number is None:
        return 0, 0
    heading, key = HEADING.fullmatch(lines[number - 1]), KEY.match(lines[number - 1])
    is_there = names_of(heading[2]) == path if heading else key and names_of(key[1])[-1] == path[-1]
    start = sum(len(line) + 1 for line in lines[: number - 1])
    return (start, min(start + len(lines[number - 1]) + 1, len(text))) if is_there else (0, 0)


def _with_value(text: str, path: Keys, value: Any) -> str:
    """Return a text in which a key has a value: in its place, or in a line of its own."""
    written = _VALUE.match(text, *_line_of(text, path))
    if written:
        return text[: written.start(1)] + toml_value(value) + text[written.end(1) :]
    end = "\r\n" if "\r\n" in text else "\n"
    table, line = path[:-1], f"{toml_key(path[-1])} = {toml_value(value)}{end}"
    _, stop = _line_of(text, table)
    if table and not stop:
        gap = "" if text.endswith(2 * end) else end if text.endswith(end) else 2 * end
        return f"{text}{gap}[{'.'.join(map(toml_key, table))}]{end}{line}"
    return text[:stop] + line + text[stop:]


def _value_at(text: str, path: Keys) -> Any:
    value: Any = tomllib.loads(text)
    for name in path:
        value = value.get(name) if isinstance(value, dict) else None
    return value


def _without(text: str, path: Keys) -> str:
    """Return a text without the line of a key, and without the headings of tables that are then empty."""
    start, stop = _line_of(text, path)
    text = text[:start] + text[stop:]
    for size in range(len(path) - 1, 0, -1):
        if _value_at(text, path[:size]) == {}:
            start, stop = _line_of(text, path[:size])
            text = text[:start] + text[stop:]
    return text
