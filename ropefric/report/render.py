"""A report as one HTML page that needs nothing else."""

import re
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from ropefric.files.plain_text import visible
from ropefric.report.chapter import Block, Fold, Picture, Report
from ropefric.report.section import Section

_SYMBOL = re.compile(r"\b([RFuUkνμδ]|mu)_(w|r|A|B|R|c|eff|tr|lin|hys|sm|q|inf|rope)\b")
_KINDS = {Section: "section", Picture: "picture", Fold: "fold"}


def as_html(report: Report) -> str:
    """Return a report as an HTML page; the same report gives the same text.

    Everything but the figures is escaped. There is no script, and nothing is fetched.
    """
    pictures = [
        block.stem for chapter in report.chapters for block in chapter.blocks if isinstance(block, Picture)
    ]
    environment = _environment()
    template = environment.get_template("report.html.j2")
    numbers = {stem: place for place, stem in enumerate(pictures, start=1)}
    page = template.render(report=report, numbers=numbers, style=Markup(_style()))  # noqa: S704  (our own file)
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
    environment.filters["kind"] = _kind
    environment.filters["svg"] = Markup
    environment.filters["symbols"] = _symbols
    return environment


@cache
def _style() -> str:
    loader = _environment().loader
    assert loader is not None  # noqa: S101  (given above)
    return loader.get_source(_environment(), "report.css")[0].strip()


def _kind(block: Block) -> str:
    """Return what kind of block it is, by which the template chooses its form."""
    if isinstance(block, tuple):
        return "facts" if hasattr(block[0], "value") else "alerts"
    return _KINDS[type(block)]


def _symbols(text: str) -> Markup:
    """Return text with the index of each symbol set low, everything else escaped."""
    return Markup(_SYMBOL.sub(r"\1<sub>\2</sub>", str(escape(text))))  # noqa: S704  (escaped just now)
