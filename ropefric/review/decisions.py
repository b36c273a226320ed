"""A person's decision about one trial, written into the trial list: every byte that it does not touch stays."""

import codecs
import io
import re
from collections.abc import Mapping

from ropefric.errors import InputError
from ropefric.files.plain_text import to_spreadsheet
from ropefric.quantities import unit_factor
from ropefric.trials.cells import CellTable, is_row, separator_of, stem_of, word_of
from ropefric.trials.trial_list import DECIDED, QUANTITIES, TEXTS

COLUMNS = ("pick_s", "exclude", "why", "by", "when")
"""What a decision is written to; columns that the list lacks are added at its right side."""

_MARKS = {
    codecs.BOM_UTF32_LE: "utf-32-le",
    codecs.BOM_UTF32_BE: "utf-32-be",
    codecs.BOM_UTF16_LE: "utf-16-le",
    codecs.BOM_UTF16_BE: "utf-16-be",
    codecs.BOM_UTF8: "utf-8",
}


def with_decision(content: bytes, line: int, values: Mapping[str, str | float], path: str = "") -> bytes:
    """Return a trial list with these cells of one of its lines set; a number is in SI, "" empties the cell."""
    mark, codec, text = _decoded(content)
    lines = [*io.StringIO(text, newline="")]  # with their ends as they are
    rows = [number for number, one in enumerate(lines, start=1) if is_row(one)]
    head = rows[0]
    separator = separator_of(lines[head - 1])
    header = tuple(_value(raw) for raw in _split(lines[head - 1], separator))
    table = CellTable(path=path, separator=separator, header=header, header_line=head, rows=())
    is_decided = {"why", "by"} <= {word_of(name) for name in header}
    columns, others, _ = table.bind({**QUANTITIES, **(DECIDED if is_decided else {})}, TEXTS)
    places = {name: column.index for name, column in columns.items()}
    places |= {word_of(name): header.index(name) for name in others}
    added = [name for name in COLUMNS if values.get(name, "") != "" and name not in places]
    other = next((name for name in others if stem_of(name) == "peak"), "")
    if other and {"why", "by"} & {*added}:
        why = f"with the columns why and by, the forces in '{other}' would be decisions too"
        fix = "rename that column, for example to reference_N, or give the list why and by yourself"
        raise InputError(why, code="RF122", path=path, line=head, fix=fix)

    def written(name: str) -> str:
        value = values.get(name, "")
        if isinstance(value, str):
            words = to_spreadsheet(" ".join(value.split()))
            quoted = separator in words or '"' in words
            return '"{}"'.format(words.replace('"', '""')) if quoted else words
        scale = unit_factor(columns[name].unit, "s") if name in columns else 1.0
        numbers = (_split(lines[row - 1], separator) for row in rows[1:]) if separator != "," else ()
        cells = tuple((0, tuple(map(_value, raws))) for raws in numbers)
        mark = CellTable(path=path, separator=separator, header=header, header_line=head, rows=cells)
        return f"{value / scale:.12g}".replace(".", mark.decimal_mark(columns))

    for number in rows if added else (line,):
        bare = lines[number - 1].rstrip("\r\n")
        cells = _split(bare, separator)
        if number == line:
            for name in values.keys() & places.keys():
                new = written(name)
                if _value(cells[places[name]]) != _value(new):
                    cells[places[name]] = new
        cells += added if number == head else [written(name) if number == line else "" for name in added]
        lines[number - 1] = separator.join(cells) + lines[number - 1][len(bare) :]
    try:
        return mark + "".join(lines).encode(codec)
    except UnicodeEncodeError as error:
        odd = error.object[error.start : error.end]
        why = f"the list is a text in {codec}, which has no '{odd}'"
        fix = "say it in other letters, or save the list as UTF-8"
        raise InputError(why, code="RF108", path=path, line=line, fix=fix) from None


def _decoded(content: bytes) -> tuple[bytes, str, str]:
    """Return a list's byte-order mark, encoding and text, found as everybody who reads it does."""
    for mark, codec in _MARKS.items():
        if content.startswith(mark):
            return mark, codec, content[len(mark) :].decode(codec)
    try:
        return b"", "utf-8", content.decode()
    except UnicodeDecodeError:
        return b"", "cp1252", content.decode("cp1252")


def _split(line: str, separator: str) -> list[str]:
    """Return the cells of a line as they are written, with blanks and quotes around them."""
    cell = re.compile(rf' *"(?:[^"]|"")*"|[^{separator}]*')
    bare, found, place = line.rstrip("\r\n"), list[str](), 0
    while place <= len(bare):
        raw = cell.match(bare, place)
        found.append(raw[0] if raw is not None else "")
        place += len(found[-1]) + 1
    return found


def _value(raw: str) -> str:
    text = raw.strip()
    return text[1:-1].replace('""', '"').strip() if len(text) > 1 and text[0] == text[-1] == '"' else text
