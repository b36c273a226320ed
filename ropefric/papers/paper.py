"""What a paper prints, item by item, beside the numbers of a machine; the same as data and in words.

A paper is read for the machine it publishes, or for a scene, a fit or trials of one's own.
"""

import math
import tomllib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from decimal import Decimal
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from ropefric import scenes
from ropefric.errors import InputError, UnknownNameError
from ropefric.files.plain_text import significant
from ropefric.files.toml import TomlDocument
from ropefric.registry import did_you_mean
from ropefric.scenes.kind import FrictionTable
from ropefric.scenes.scene import Scene, load_scene, read_scene, source_of
from ropefric.scenes.scene_templates import scene_text
from ropefric.section import Chart, Line, Section, in_words
from ropefric.systems.checks import checked
from ropefric.trials.table import TrialTable

PAPERS = ("prth", "press", "saw")


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
        return bool(abs(self.value - float(self.printed)) <= half * (1.0 + 1e-9))


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
        if isinstance(one, bool):
            return one
        return None if one is None or not math.isfinite(one) else significant(one)

    numbers = {"value": plain(row.value), "deviation": plain(row.deviation)}
    said = {"of": row.of, "printed": row.printed or None, "agrees": row.agrees, "remark": row.remark}
    return said | numbers


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


class Given(NamedTuple):
    """What a paper is read for: a scene, and whether it is the published one; trials where given; F_0 [N]."""

    scene: Scene
    published: bool
    trials: TrialTable | None
    reference_N: float


def read_paper(
    name: str,
    *,
    scene: Path | None = None,
    trials: TrialTable | None = None,
    fit: Path | None = None,
    reference_N: float | None = None,
) -> Reading:
    """Return a paper with its numbers for a scene, a fit or trials; for the machine that it publishes by default."""
    if name not in PAPERS:
        raise UnknownNameError(f"unknown paper {name!r}", key="PAPER", fix=did_you_mean(name, PAPERS))
    paper: Paper = import_module(f"ropefric.papers.{name}").PAPER
    of_prth = (
        (trials, "--trials", "reduces trials"),
        (reference_N, "--reference-tension", "has a reference tension"),
    )
    for given, key, what in of_prth:
        if given is not None and name != "prth":
            raise InputError(f"only prth {what}", key=key, fix=f"leave {key} out")
    F_0 = 1.0 if reference_N is None else float(checked("reference_tension", reference_N))
    if scene is None:
        document = TomlDocument(path=paper.scene, data=tomllib.loads(scene_text(paper.scene)), lines={})
        loaded = read_scene(document, Path(str(scenes.__file__)).parent)
    else:
        loaded = load_scene(scene)
    if loaded.kind.name != paper.system:
        why = f"the scene is one of a {loaded.kind.name}, the paper of a {paper.system}"
        fix = f'give one with system = "{paper.system}"'
        raise InputError(why, key="--scene", path=str(scene), fix=fix)
    if fit is not None:
        table = loaded.table.model_copy(update={"friction": FrictionTable(fit=fit.name)})
        source = source_of(loaded.kind, table, fit.parent)
        problem = loaded.kind.problem(table, None if source is None else source.friction)
        loaded = replace(loaded, table=table, source=source, problem=problem)
    case = Given(loaded, scene is None and fit is None, trials, F_0)
    machine = paper.machine(case)
    rows = tuple((item, tuple(_of(case, item.rows(machine)))) for item in paper.items)
    whose = paper.of if scene is None else str(scene)
    with_fit, beside = (f"the fit {fit}" if fit else ""), (trials.source if trials is not None else "")
    own = paper.beside if scene is None and not with_fit and not beside else ""
    of = "; ".join(filter(None, (whose, with_fit, beside, own)))
    return Reading(name=name, paper=paper, of=of, machine=machine, rows=rows)


def _of(given: Given, rows: Iterable[Row]) -> Iterator[Row]:
    """Yield rows; what is printed belongs to the published machine alone, a word on it to where the two differ."""
    for row in rows:
        if row.printed and not given.published:
            yield row._replace(printed="", remark="")
        else:
            yield row._replace(remark="") if row.agrees else row
