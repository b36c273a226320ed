"""A TOML file as read: its tree, and the line of every key in it, which tomllib does not give."""

import os
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ropefric.errors import DataError, Problem
from ropefric.files.disk import read_file

KeyPath = tuple[str | int, ...]
"""A place in a TOML tree: names of keys and 0-based numbers of array elements."""

MOST_BYTES = 1_000_000
"""A TOML file larger than this was not written by hand."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TomlDocument:
    """Contents of a TOML file, with their lines."""

    path: str
    data: Mapping[str, Any]
    lines: Mapping[KeyPath, int]

    def line_of(self, key: KeyPath) -> int | None:
        """Return the line of a key; of the table it is missing from where there is no such key."""
        for size in range(len(key), 0, -1):
            if key[:size] in self.lines:
                return self.lines[key[:size]]
        return None

    def table(self, *names: str) -> Mapping[str, Any]:
        """Return a table of the tree; an empty one where there is none of this name."""
        table: Any = self.data
        for name in names:
            table = table.get(name) if isinstance(table, dict) else None
        return table if isinstance(table, dict) else {}

    def problem(
        self, key: KeyPath, code: str, message: str, *, fix: str = "", warning: bool = False
    ) -> Problem:
        """Return a problem that points at a key of this file."""
        place, line = key_text(key), self.line_of(key)
        problem = Problem(code=code, message=message, path=self.path, line=line, key=place, fix=fix)
        return replace(problem, severity="warning") if warning else problem


def read_toml(path: str | os.PathLike[str], what: str = "TOML file") -> TomlDocument:
    r"""Return a TOML file's tree with the line of every key."""
    name = Path(path).as_posix()
    return parse_toml(read_file(path, what, shown=name, limit=MOST_BYTES), name, what)


def parse_toml(content: bytes, name: str, what: str = "TOML file") -> TomlDocument:
    """Return the tree of a TOML file's content with the line of every key; `name` is the file, for messages."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        fix = "save the file as UTF-8; TOML knows no other encoding"
        raise DataError(f"the {what} is not in UTF-8", path=name, line=line, fix=fix) from None
    text = text.replace("\r\n", "\n")
    # Its time grows with the square of the parts of a key.
    if endless := _ENDLESS.search(_TEXT.sub(lambda found: "q" + "\n" * found[0].count("\n"), text)):
        line = text.count("\n", 0, endless.start()) + 1
        fix = "write tables, each under a heading of its own"
        raise DataError("a key has more than 32 parts", path=name, line=line, fix=fix)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise _syntax_error(text, str(error), name) from None
    except RecursionError:
        raise DataError(f"the {what} is nested too deeply", path=name) from None
    except ValueError:
        # tomllib lets Python's own limits through: thousands of digits, dates that do not exist.
        raise DataError(f"the {what} holds a number or date that cannot be read", path=name) from None
    return TomlDocument(path=name, data=data, lines=toml_lines(text))


_QUOTED = 'put text and quantities in quotes: "40 mm"'
_QUOTED_NAME = 'close the bracket, and put a name with blanks in quotes: [wheels."my wheel"]'
_CLOSE = "close the quote"
# How a message of tomllib begins, what it means, and what to do.
_MEANINGS = (
    ("Cannot overwrite a value", "this key is given a second time", "remove one of the two"),
    ("Cannot declare", "this table is given a second time", "join both under one heading"),
    ("Expected ']' at the end of a table", "the name of the table is not closed", _QUOTED_NAME),
    ("Invalid value", "the value is not TOML", _QUOTED),
    ("Expected newline or end", "something follows the value", _QUOTED),
    ("Expected '='", "there is no '=' after the key", 'write key = "value"'),
    ("Illegal character", "a character is not allowed here, or a quote is not closed", _CLOSE),
    (("Unterminated string", 'Expected \'"""\''), "a quote is not closed", _CLOSE),
    ("Unescaped '\\'", "there is a lone backslash in the text", "use / in paths, or single quotes"),
)
_ANY = 'write each key once, as radius = "40 mm", and close quotes and brackets'
_PLACE = re.compile(r"\(at line (\d++), column \d++\)$")
_BARE_QUANTITY = re.compile(
    r"([\w.-]++)\s*+=\s*+([+-]?\d[\d.,]*+\s*+[A-Za-z%/°µ*^][A-Za-z%/°µ*^\d]*+)\s*+(?:#.*+)?"
)


def _syntax_error(text: str, message: str, name: str) -> DataError:
    place = _PLACE.search(message)
    line = int(place[1]) if place else text.count("\n") + (not text.endswith("\n"))
    rows = text.split("\n")
    # tomllib points behind a line break where a value or key is missing at the end of the line before.
    written = rows[line - 1].strip() if line <= len(rows) else ""
    said, shown = message.partition(" (at ")[0], f": {written[:80]}" if written else ""
    said, fix = next(
        ((meaning, fix) for start, meaning, fix in _MEANINGS if said.startswith(start)), (said, _ANY)
    )
    if bare := _BARE_QUANTITY.fullmatch(written):
        fix = f'write {bare[1]} = "{bare[2].strip().replace(",", ".")}"'
    return DataError(f"not valid TOML, {said}{shown}", path=name, line=max(line, 1), fix=fix)


_BARE_KEY = re.compile(r"[A-Za-z0-9_-]++")
_NAME = r"""(?:[A-Za-z0-9_-]++|"[^"\n]*+"|'[^'\n]*+')"""
_NAMES = rf"{_NAME}(?:[ \t]*+\.[ \t]*+{_NAME})*+"
_ONE_NAME = re.compile(_NAME)
HEADING = re.compile(rf"[ \t]*+(\[\[?)[ \t]*+({_NAMES})[ \t]*+\]\]?[ \t\r]*+(?:#.*+)?")
KEY = re.compile(rf"[ \t]*+({_NAMES})[ \t]*+=")
# Long texts; strings and comments beside them, so that no mark within one is taken for the begin of another.
_LONG = r"'''(?:(?!''').)*+'''(?:'{0,2})|" + r'"""(?:\\.|(?!""")[^\\])*+"""(?:"{0,2})'
_TEXT = re.compile(rf"""({_LONG})|"(?:\\.|[^"\\\n])*+"|'[^'\n]*+'|\#[^\n]*+""", re.DOTALL)
_ENDLESS = re.compile(r"(?<![\w-])(?:[\w-]++[ \t]*+\.[ \t]*+){32}")


def names_of(key: str) -> tuple[str, ...]:
    """Return the names of a key as it is written, such as `a."b c"`."""
    return tuple(one.strip("\"'") for one in _ONE_NAME.findall(key))


def toml_lines(text: str) -> dict[KeyPath, int]:
    r"""Return the 1-based line of every table and of every key that begins a line of a TOML text.

    What stands within a value, such as an element of an array, has the line of its key.
    """
    lines, repeats = dict[KeyPath, int](), dict[KeyPath, int]()
    table: KeyPath = ()
    bare = _TEXT.sub(lambda found: "\n" * found[0].count("\n") if found[1] else found[0], text)
    for number, line in enumerate(bare.split("\n"), start=1):
        heading, key = HEADING.fullmatch(line), KEY.match(line)
        if heading:
            table, names = (), names_of(heading[2])
            for place, name in enumerate(names, start=1):
                table = (*table, name)
                lines.setdefault(table, number)
                if heading[1] == "[[" and place == len(names):
                    repeats[table] = repeats.get(table, -1) + 1
                if table in repeats:  # on the way, the latest element of an array of tables
                    table = (*table, repeats[table])
                    lines.setdefault(table, number)
        elif key:
            path = table
            for name in names_of(key[1]):
                path = (*path, name)
                lines.setdefault(path, number)
    return lines


def key_text(path: KeyPath) -> str:
    """Return a place as people write it."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            name = part if _BARE_KEY.fullmatch(part) else f'"{part}"'
            text += f".{name}" if text else name
    return text


# None of these is a key of any scene.
_OF_CAMPAIGNS = ("trials", "wheels", "cells", "protocol", "rejection", "import")


def is_scene(data: Mapping[str, Any]) -> bool:
    """Return whether a TOML tree says of which system it is, as every scene does and no campaign."""
    return "system" in data


def is_campaign(data: Mapping[str, Any]) -> bool:
    """Return whether a TOML tree has what only campaigns have, and names no system."""
    schema = str(data.get("schema", ""))
    named = schema.startswith("ropefric.campaign") or any(key in data for key in _OF_CAMPAIGNS)
    return named and not is_scene(data)
