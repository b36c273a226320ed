"""A TOML file as read: its tree, and the line of every key in it, which tomllib does not give."""

import os
import re
import tomllib
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

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


_PLACE = re.compile(r"\(at line (\d++), column \d++\)$")
_HOW = 'write each key once, as radius = "40 mm": text and quantities in quotes, paths with /; close quotes and brackets'


def _syntax_error(text: str, message: str, name: str) -> DataError:
    place = _PLACE.search(message)
    line = int(place[1]) if place else text.count("\n") + (not text.endswith("\n"))
    rows = text.split("\n")
    # tomllib points behind a line break where a value or key is missing at the end of the line before.
    written = rows[line - 1].strip() if line <= len(rows) else ""
    said, shown = message.partition(" (at ")[0], f": {written[:80]}" if written else ""
    return DataError(f"not valid TOML, {said}{shown}", path=name, line=max(line, 1), fix=_HOW)


_BARE_KEY = re.compile(r"[A-Za-z0-9_-]++")
# Strings first, so that no '#', bracket or line break inside one is taken for TOML's own.
_TOKEN = re.compile(
    r'''(?P<string>"""(?:\\.|(?!""")[^\\])*+(?:"""(?:"{0,2}))?|\'\'\'(?:(?!\'\'\').)*+(?:\'\'\'(?:'{0,2}))?'''
    r"""|"(?:\\.|[^"\\\n])*+"?|'[^'\n]*+'?)"""
    r"""|(?P<comment>\#[^\n]*+)|(?P<newline>\n)|(?P<space>[ \t\r]++)|(?P<mark>[\[\]{},=.])"""
    r"""|(?P<bare>[^\s"'\#,=\[\]{}.]++)|(?P<other>.)""",
    re.DOTALL,
)


def toml_lines(text: str) -> dict[KeyPath, int]:
    r"""Return the 1-based line of every key, table and array element of a TOML text."""
    return _places(text).lines


def value_spans(text: str) -> dict[KeyPath, tuple[int, int]]:
    """Return from where to where in a TOML text each value is written, by its key."""
    return _places(text).spans


def _places(text: str) -> "_Places":
    found, table = _Places(text), tuple[str | int, ...]()
    while found.tokens:
        if found.tokens[0].kind == "[":
            table = found.header()
        else:
            found.value(found.key(table), "newline")
            if found.tokens:
                found.tokens.popleft()
    return found


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


class _Token(NamedTuple):
    kind: str  # of a mark, the mark
    text: str
    line: int
    start: int


def _tokens(text: str) -> Iterator[_Token]:
    line = 1
    for match in _TOKEN.finditer(text):
        kind = match.lastgroup or "other"
        yield _Token(match[0] if kind == "mark" else kind, match[0], line, match.start())
        line += match[0].count("\n")


def _key_name(token: _Token) -> str:
    if token.kind != "string":
        return token.text
    if "\\" not in token.text:
        return token.text[1:-1]
    try:
        return str(tomllib.loads(f"key = {token.text}")["key"])
    except tomllib.TOMLDecodeError:
        return token.text


class _Places:
    """The lines of the places that were read, the stretches of text of their values, and the tokens not read yet."""

    def __init__(self, text: str) -> None:
        self.tokens = deque(token for token in _tokens(text) if token.kind not in ("comment", "space"))
        self.lines: dict[KeyPath, int] = {}
        self.spans: dict[KeyPath, tuple[int, int]] = {}
        self.end = 0
        self.repeats: dict[KeyPath, int] = {}  # arrays of tables: how many elements so far

    def key(self, path: KeyPath) -> KeyPath:
        """Read `a."b".c` and return the place it names below a path."""
        while self.tokens and self.tokens[0].kind in ("bare", "string", "."):
            if (token := self.tokens.popleft()).kind != ".":
                path = (*path, _key_name(token))
                self.lines.setdefault(path, token.line)
        return path

    def header(self) -> KeyPath:
        """Read `[a.b]` or `[[a.b]]`; names on the way mean the latest element of an array of tables."""
        head: list[_Token] = []
        while self.tokens and self.tokens[0].kind != "newline":
            head.append(self.tokens.popleft())
        is_array = [token.kind for token in head[:2]] == ["[", "["]
        parts = [token for token in head if token.kind in ("bare", "string")]
        path: KeyPath = ()
        for place, token in enumerate(parts, start=1):
            path = (*path, _key_name(token))
            self.lines.setdefault(path, token.line)
            if is_array and place == len(parts):
                self.repeats[path] = self.repeats.get(path, 0) + 1
            if path in self.repeats:
                path = (*path, self.repeats[path] - 1)
                self.lines.setdefault(path, token.line)
        return path

    def value(self, path: KeyPath, *ends: str) -> None:
        """Read up to a mark that ends the value; in it, elements of arrays and keys of inline tables."""
        start = None
        while self.tokens and self.tokens[0].kind not in ends:
            token = self._next()
            if start is None and token.kind != "=":
                start = token.start
            if token.kind in ("string", "bare", "other", "[", "{"):
                self.lines.setdefault(path, token.line)
            close = {"[": "]", "{": "}"}.get(token.kind, "")
            for number in count() if close else ():
                self.value((*path, number) if close == "]" else self.key(path), ",", close)
                if not self.tokens or self._next().kind == close:
                    break
        if start is not None:
            self.spans[path] = start, self.end

    def _next(self) -> _Token:
        token = self.tokens.popleft()
        self.end = token.start + len(token.text)
        return token


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
