"""Where in a TOML text each key stands: tomllib tells what a file says, but not on which line."""

import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass

KeyPath = tuple[str | int, ...]
"""A place in a TOML tree: names of keys and 0-based numbers of array elements."""

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
    locator = _Locator([token for token in _tokens(text) if token.kind not in ("comment", "space")])
    locator.run()
    return locator.lines


def endless_key(text: str, most: int) -> int | None:
    r"""Return the line of the first key with more than `most` dotted parts, whose cost grows with their square."""
    dots = 0
    for token in _tokens(text):
        if token.is_mark("."):
            dots += 1
            if dots >= most:
                return token.line
        elif token.kind not in ("bare", "string", "space"):
            dots = 0
    return None


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


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str
    text: str
    line: int

    def is_mark(self, mark: str) -> bool:
        return self.kind == "mark" and self.text == mark


def _tokens(text: str) -> Iterator[_Token]:
    line = 1
    for match in _TOKEN.finditer(text):
        yield _Token(match.lastgroup or "other", match[0], line)
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


class _Locator:
    """One pass over the tokens; nesting is kept on a stack of its own, so depth costs no recursion."""

    def __init__(self, tokens: list[_Token]) -> None:
        self.tokens = tokens
        self.at = 0
        self.lines: dict[KeyPath, int] = {}
        self.repeats: dict[KeyPath, int] = {}  # arrays of tables: how many elements so far

    def run(self) -> None:
        table: KeyPath = ()
        while self.at < len(self.tokens):
            before = self.at
            token = self.tokens[self.at]
            if token.kind == "newline":
                self.at += 1
            elif token.is_mark("["):
                table = self._header()
            else:
                self._value(self._key(table))
            if self.at == before:
                self.at += 1

    def _note(self, path: KeyPath, line: int) -> None:
        self.lines.setdefault(path, line)

    def _key(self, base: KeyPath) -> KeyPath:
        """Read `a."b".c` and return the place it names below `base`."""
        path = base
        while self.at < len(self.tokens):
            token = self.tokens[self.at]
            if token.kind in ("bare", "string"):
                path = (*path, _key_name(token))
                self._note(path, token.line)
            elif not token.is_mark("."):
                break
            self.at += 1
        return path

    def _header(self) -> KeyPath:
        """Read `[a.b]` or `[[a.b]]`; names on the way mean the latest element of an array of tables."""
        self.at += 1
        is_array = self.at < len(self.tokens) and self.tokens[self.at].is_mark("[")
        self.at += is_array
        parts: list[_Token] = []
        while self.at < len(self.tokens):
            token = self.tokens[self.at]
            if token.kind in ("bare", "string"):
                parts.append(token)
            elif not token.is_mark("."):
                break
            self.at += 1
        path: KeyPath = ()
        for place, token in enumerate(parts):
            path = (*path, _key_name(token))
            self._note(path, token.line)
            if is_array and place == len(parts) - 1:
                self.repeats[path] = self.repeats.get(path, 0) + 1
            if path in self.repeats:
                path = (*path, self.repeats[path] - 1)
                self._note(path, token.line)
        while self.at < len(self.tokens) and self.tokens[self.at].kind != "newline":
            self.at += 1
        return path

    def _value(self, path: KeyPath) -> None:
        """Read the rest of a statement; note keys of inline tables and elements of arrays."""
        slot = path
        stack: list[tuple[KeyPath, int | None]] = []  # container and element number, None in a table
        while self.at < len(self.tokens):
            token = self.tokens[self.at]
            if token.kind == "newline" and not stack:
                return
            self.at += 1
            if token.is_mark("["):
                self._note(slot, token.line)
                stack.append((slot, 0))
                slot = (*slot, 0)
            elif token.is_mark("{"):
                self._note(slot, token.line)
                stack.append((slot, None))
                slot = self._key(slot)
            elif (token.is_mark("]") or token.is_mark("}")) and stack:
                slot = stack.pop()[0]
            elif token.is_mark(",") and stack:
                base, number = stack.pop()
                stack.append((base, None if number is None else number + 1))
                slot = self._key(base) if number is None else (*base, number + 1)
            elif token.kind not in ("newline", "mark"):
                self._note(slot, token.line)
