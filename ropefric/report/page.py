"""A report as data, and as one HTML page that needs nothing else."""

import re
from functools import cache
from typing import Literal, NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined, pass_context
from jinja2.runtime import Context
from markupsafe import Markup, escape

from ropefric import __version__
from ropefric.files.plain_text import localized, visible
from ropefric.report.section import Section

_SYMBOL = re.compile(r"\b([RFuUkνμδ]|mu)_(w|r|A|B|R|c|eff|tr|lin|hys|sm|q|inf|rope)\b")


class Alert(NamedTuple):
    """Something to know before a result is used."""

    grade: Literal["stop", "doubt", "note"]
    title: str
    text: str


class Fact(NamedTuple):
    """A key number: what it is, its value, and what belongs to it."""

    name: str
    value: str
    remark: str = ""


class Picture(NamedTuple):
    """A figure on the page, and the files of its numbers beside the page."""

    stem: str
    svg: str
    caption: str
    files: tuple[str, ...] = ()
    narrow: bool = False


class Particulars(NamedTuple):
    """What a report is about, as names and values."""

    rows: tuple[tuple[str, str], ...]


class Formula(NamedTuple):
    """Statements of an equation, each as MathML."""

    statements: tuple[str, ...]


class Fold(NamedTuple):
    """A section that is shown on demand, and not printed."""

    title: str
    section: Section


Block = Section | Picture | Particulars | Formula | Fold | list[Fact] | list[Alert]


class Chapter(NamedTuple):
    """A heading with blocks under it; `key` is its anchor."""

    key: str
    title: str
    blocks: tuple[Block, ...]


class Report(NamedTuple):
    """A whole report; its chapter `result` is what a reader may skip to.

    `language` is that of its numbers and dates; `names` are kept as they are.
    """

    title: str
    lead: str
    chapters: tuple[Chapter, ...]
    language: str = "en"
    names: frozenset[str] = frozenset()


def as_html(report: Report) -> str:
    """Return a report as an HTML page; the same report gives the same text.

    Everything but the figures is escaped. There is no script, and nothing is fetched.
    """
    blocks = [block for chapter in report.chapters for block in chapter.blocks]
    stems = [block.stem for block in blocks if isinstance(block, Picture)]
    page = (
        _environment()
        .get_template("report.html.j2")
        .render(
            report=report,
            numbers={stem: place for place, stem in enumerate(stems, start=1)},
            made_by=f"ropefric {__version__}",
        )
    )
    return visible(page) + "\n"


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("ropefric.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"kind": _kind, "markup": Markup, "symbols": _symbols}
    return environment


def _kind(block: Block) -> str:
    """Return what kind of block it is, by which the template chooses its form."""
    return type(block[0] if isinstance(block, list) else block).__name__.lower()


@pass_context
def _symbols(context: Context, text: str) -> Markup:
    """Return text with the index of each symbol set low and numbers in the report's language, all else escaped."""
    report = context["report"]
    shown = escape(localized(text, report.language, report.names))
    return Markup(_SYMBOL.sub(r"\1<sub>\2</sub>", str(shown)))  # noqa: S704  (escaped just now)
