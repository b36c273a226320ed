"""What a paper prints, item by item, beside the numbers of a machine; the same as data and in words."""

import math
from collections.abc import Callable, Iterable, Iterator
from decimal import Decimal
from typing import Any, NamedTuple

from ropefric.files.plain_text import significant
from ropefric.section import Chart, Line, Section, in_words


class Row(NamedTuple):
    """One number, or whether a statement holds; what stands in print, digit by digit, and a word on the difference."""

    of: str
    value: float | bool | None
    printed: str = ""
    remark: str = ""

    @property
    def deviation(self) -> float | None:
        """Return our number less the printed one."""
        if not self.printed or self.value is None or isinstance(self.value, bool):
            return None
        return self.value - float(self.printed)

    @property
    def agrees(self) -> bool | None:
        """Return whether it is the printed one to its last digit; None where nothing is printed."""
        if not self.printed or self.value is None:
            return None
        if isinstance(self.value, bool):
            return self.value == (self.printed == "yes")
        half = 0.5 * 10.0 ** int(Decimal(self.printed).as_tuple().exponent)
        return abs(self.value - float(self.printed)) <= half * (1.0 + 1e-9)


class Shown(NamedTuple):
    """A figure of a paper as a chart, with the stem of its file's name."""

    stem: str
    chart: Chart


def shown(
    stem: str, title: str, across: tuple[str, str], up: tuple[str, str], lines: Iterable[Line]
) -> Shown:
    """Return a figure: across and up each a column's name and an axis label."""
    return Shown(stem, Chart(title, *across, *up, tuple(lines)))


def nothing(_: Any) -> Iterable[Any]:
    """Return that there is none."""
    return ()


class Item(NamedTuple):
    """An equation, table or figure of a paper.

    Attributes
    ----------
    number, says, where : str
        Its number, its formula or caption, and the section of the paper.
    rows : callable
        `rows(machine)` returns its numbers for a machine.
    charts : callable
        `charts(machine)` returns its figures.
    unit : str
        Of its numbers.
    remark : str
        A misprint, or what the paper leaves open.
    given : bool
        Whether its numbers are put in, so that they agree anyway.
    """

    number: str
    says: str
    where: str
    rows: Callable[[Any], Iterable[Row]] = nothing
    charts: Callable[[Any], Iterable[Shown]] = nothing
    unit: str = ""
    remark: str = ""
    given: bool = False


class Paper(NamedTuple):
    """A paper: what it is, the scene of its machine in words, what that is made into, its items, and what to know."""

    title: str
    source: str
    system: str
    scene: str
    machine: Callable[[Any], Any]
    items: tuple[Item, ...]
    of: str = "the published machine"
    beside: str = ""
    notes: tuple[str, ...] = ()


class Reading(NamedTuple):
    """A paper as read for a machine: the rows of all its items."""

    name: str
    paper: Paper
    of: str
    machine: Any
    rows: tuple[tuple[Item, tuple[Row, ...]], ...]

    @property
    def printed(self) -> tuple[tuple[Item, Row], ...]:
        """Return every row that stands in print, too, with its item; not those that were put in."""
        found = ((item, row) for item, rows in self.rows if not item.given for row in rows)
        return tuple((item, row) for item, row in found if row.agrees is not None)

    def charts(self) -> Iterator[Shown]:
        """Yield the figures, each by the name of its file."""
        for item in self.paper.items:
            yield from item.charts(self.machine)

    def to_dict(self) -> dict[str, Any]:
        """Return the reading as a JSON tree."""
        paper, names = self.paper, ("number", "says", "where", "unit", "remark", "given")
        items = [
            {name: getattr(item, name) for name in names} | {"rows": [_tree(row) for row in rows]}
            for item, rows in self.rows
        ]
        agree = sum(bool(row.agrees) for _, row in self.printed)
        about = {"paper": self.name, "title": paper.title, "source": paper.source, "of": self.of}
        counts = {"printed": len(self.printed), "agree": agree}
        return {**about, **counts, "items": items, "notes": list(paper.notes)}

    def parts(self) -> Iterator[Section]:
        """Yield the reading in words: what agrees, then item by item."""
        agree = sum(bool(row.agrees) for _, row in self.printed)
        said = f"{agree} of {len(self.printed)} printed numbers and statements come out to the last digit printed"
        lines = (
            self.paper.source,
            f"for {self.of}",
            *([said + "; the others have a remark" * (agree < len(self.printed))] if self.printed else []),
        )
        yield Section(self.paper.title, lines=lines, notes=self.paper.notes)
        for item, rows in self.rows:
            yield part_of(item, rows)


def part_of(item: Item, rows: Iterable[Row]) -> Section:
    """Return an item and its rows in words."""
    title = f"{item.number}  {item.says}" + (f" [{item.unit}]" if item.unit else "")
    where, table = f"section {item.where} of the paper", _table(tuple(rows))
    if not table and item.rows is not nothing:
        where += "; no number of it follows from what is given"
    return Section(title, lines=(where,), notes=(item.remark,) if item.remark else (), **table)


def _tree(row: Row) -> dict[str, Any]:
    def plain(one: Any) -> Any:
        if one is None or isinstance(one, bool) or not math.isfinite(one):
            return one if isinstance(one, bool) else None
        return significant(one)

    numbers = {"value": plain(row.value), "deviation": plain(row.deviation)}
    return {
        "of": row.of,
        **numbers,
        "printed": row.printed or None,
        "agrees": row.agrees,
        "remark": row.remark,
    }


def _table(rows: tuple[Row, ...]) -> dict[str, Any]:
    """Return headings and rows of what there is: columns in which nothing stands are left out."""
    if not rows:
        return {}
    columns = {
        "": [row.of for row in rows],
        "computed": [_shown(row) for row in rows],
        "printed": [row.printed for row in rows],
        "deviation": [in_words(row.deviation, "+.2g") if row.deviation is not None else "" for row in rows],
        "remark ": [row.remark for row in rows],
    }
    kept = {name: cells for name, cells in columns.items() if any(cells)}
    return {"headings": tuple(kept), "rows": tuple(zip(*kept.values(), strict=True))}


def _shown(row: Row) -> str:
    """Return a number with two digits more than are printed, else with six."""
    if row.value is None or isinstance(row.value, bool) or not row.printed:
        return in_words(row.value, ".6g")
    return in_words(row.value, f".{max(0, 2 - int(Decimal(row.printed).as_tuple().exponent))}f")
