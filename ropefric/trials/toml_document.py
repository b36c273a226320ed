"""A TOML file as read: its tree, and the line of every key in it."""

import os
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ropefric.errors import DataError, Problem
from ropefric.files.read import kind_of_file, read_file
from ropefric.trials.toml_lines import KeyPath, endless_key, key_text, toml_lines

MOST_BYTES = 1_000_000
"""A TOML file larger than this was not written by hand."""

_MAX_PARTS = 32


@dataclass(frozen=True, slots=True, kw_only=True)
class TomlDocument:
    """What a TOML file says, and where."""

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
        return Problem(
            code=code,
            message=message,
            path=self.path,
            line=self.line_of(key),
            key=key_text(key),
            fix=fix,
            severity="warning" if warning else "error",
        )


def read_toml(path: str | os.PathLike[str], what: str = "TOML file") -> TomlDocument:
    r"""Return a TOML file's tree with the line of every key."""
    name = _shown(path)
    try:
        content = read_file(path, what, shown=name, limit=MOST_BYTES)
    except DataError:
        if kind_of_file(path) != "folder":
            raise
        fix = _file_in(Path(path), what)
        raise DataError(f"this is a folder, not a {what}", path=name, fix=fix) from None
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        fix = "save the file as UTF-8; TOML knows no other encoding"
        raise DataError(f"the {what} is not in UTF-8", path=name, line=line, fix=fix) from None
    text = text.replace("\r\n", "\n")
    endless = endless_key(text, _MAX_PARTS)
    if endless is not None:
        raise DataError(
            f"a key has more than {_MAX_PARTS} parts", path=name, line=endless, fix="shorten the key"
        )
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


def _file_in(folder: Path, what: str) -> str:
    """Return which TOML file of a folder may be meant."""
    names = sorted(path.name for path in folder.glob("*.toml"))
    if "campaign.toml" in names and what != "campaign file":
        return f"it holds a campaign: `ropefric run {_shown(folder)}`"
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    if not names:
        return "name a file; this folder holds no *.toml"
    return f"name a file of it: {', '.join(names[:3])}{more}"


def _shown(path: str | os.PathLike[str]) -> str:
    return Path(path).as_posix()


_MEANINGS = (
    ("Cannot overwrite a value", "this key is given a second time", "remove one of the two"),
    ("Cannot declare", "this table is given a second time", "join both under one heading"),
    (
        "Cannot mutate immutable",
        "this table is complete where it was first written",
        "join both in one place",
    ),
    ("Invalid value", "the value is not TOML", 'put text and quantities in quotes: "40 mm"'),
    ("Expected newline or end", "something follows the value", 'put text and quantities in quotes: "40 mm"'),
    ("Expected '='", "there is no '=' after the key", 'write key = "value"'),
    ("Illegal character", "a character is not allowed here, or a quote is not closed", "close the quote"),
    ("Unterminated string", "a quote is not closed", "close the quote"),
    ('Expected \'"""\'', "a quote is not closed", "close the quote"),
    ("Unclosed array", "a bracket is not closed", "close it with ]"),
    ("Unescaped '\\'", "a lone backslash stands in the text", "use / in paths, or single quotes"),
)


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
    said = message[: place.start()].strip() if place else message.removesuffix("(at end of document)").strip()
    meaning, fix = next(((m, f) for start, m, f in _MEANINGS if said.startswith(start)), ("", ""))
    bare = _BARE_QUANTITY.fullmatch(written)
    if bare:
        fix = f'write {bare[1]} = "{bare[2].strip().replace(",", ".")}"'
    shown = f": {written[:80]}" if written else ""
    return DataError(f"not valid TOML, {meaning or said}{shown}", path=name, line=max(line, 1), fix=fix)
