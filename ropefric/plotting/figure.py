"""A figure together with the numbers it shows and its words for those who cannot see it; its files, and its SVG.

Inside a page text stays text, and names do not collide.
"""

import gc
import hashlib
import io
import os
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from contextlib import contextmanager
from contextvars import ContextVar
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree as ET

import matplotlib as mpl
import numpy as np
from matplotlib import font_manager
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
from matplotlib.figure import Figure, SubFigure
from matplotlib.mathtext import MathTextParser
from matplotlib.text import Text

from ropefric.errors import InputError
from ropefric.files.folder import Folder, as_folder
from ropefric.files.plain_text import csv_cell, csv_text, visible
from ropefric.glossary import counted
from ropefric.plotting.style import (
    GREY,
    LINE_STYLES,
    TYPESET,
    figure_text,
    house_style,
    legend_below,
    plain_text,
)
from ropefric.section import Chart

Draw = Callable[[], "FigureWithData"]
Progress = Callable[[int, int, str], None]

# Without date and matplotlib's version, which would change an unchanged figure.
FORMATS = {"png": ("Software",), "svg": ("Date", "Creator"), "pdf": ("CreationDate", "Creator", "Producer")}
"""File formats of a figure, and the metadata left out of each."""

_PARSERS: dict[str, Any] = {}


def forget_fonts() -> None:
    """Let go of every open font: processes forked with one share its place in the file and read each other's glyphs."""
    _PARSERS.clear()
    MathTextParser._parse_cached.cache_clear()  # type: ignore[attr-defined]  # noqa: SLF001  (they keep fonts)
    font_manager._get_font.cache_clear()  # type: ignore[attr-defined]  # noqa: SLF001
    gc.collect()  # figures that are done with hold them in cycles


class DataTable(NamedTuple):
    """Numbers behind a figure: columns of one length, each under its heading."""

    columns: Mapping[str, Iterable[object]]
    name: str = ""

    @classmethod
    def of_rows(cls, header: Sequence[str], rows: Sequence[Sequence[object]], name: str = "") -> "DataTable":
        """Return the table of rows under a header."""
        columns = zip(*rows, strict=True) if rows else [()] * len(header)
        return cls(dict(zip(header, columns, strict=True)), name)

    @classmethod
    def of(cls, records: Iterable[Any], paths: Sequence[str], name: str = "") -> "DataTable":
        """Return the table of some attributes of records, given by their paths, under the last of their names."""
        found = [*records]
        return cls({path.rpartition(".")[2]: [*map(attrgetter(path), found)] for path in paths}, name)

    @property
    def header(self) -> tuple[str, ...]:
        """Return the headings."""
        return tuple(self.columns)

    @property
    def rows(self) -> tuple[tuple[object, ...], ...]:
        """Return the rows."""
        return tuple(zip(*map(_listed, self.columns.values()), strict=True))


def _listed(column: Iterable[object]) -> list[object]:
    return column.tolist() if isinstance(column, np.ndarray) else list(column)


class FigureWithData:
    """A figure, the tables of what it shows, and its words, made of the labels of its axes where there are none.

    Where it was drawn on given axes, `figure` is these, or the part of the figure that took their place.
    """

    def __init__(self, figure: Any, tables: tuple[DataTable, ...], alt: str = "") -> None:
        # Names of trials and machine parts are anybody's: the one place that keeps them from being taken for TeX.
        rewrite_words(figure, figure_text)
        if not alt.strip():
            pairs = [(axes.get_ylabel(), axes.get_xlabel()) for axes in panels_of(figure)]
            named = [" over ".join(word for word in pair if word) for pair in pairs]
            panels = plain_text("; ".join(words for words in named if words)) or "Figure"
            alt = f"{panels} ({counted(len(tables[0].rows) if tables else 0, 'row')} of data)."
        self.figure, self.tables, self.alt = figure, tables, alt


def panels_of(figure: Any) -> list[Axes]:
    """Return the axes of a figure or a part of one; of axes, these alone."""
    return figure.axes if isinstance(figure.axes, list) else [figure]


def rewrite_words(figure: Any, rewrite: Callable[[str], str]) -> None:
    """Rewrite every text of a figure or of axes, the words at the ticks too."""
    for text in _texts(figure):
        shown = text.get_text()
        if shown and (new := rewrite(shown)) != shown:
            text.set_text(new)
    for axes in panels_of(figure):
        for axis in (axes.xaxis, axes.yaxis):
            # Ticks with words of their own: matplotlib asks for these again at each drawing.
            for named in getattr(getattr(axis.get_major_formatter(), "func", None), "args", ()):
                if isinstance(named, dict):
                    named.update({place: rewrite(word) for place, word in named.items()})


def _texts(artist: Artist) -> Iterator[Text]:
    """Give every text but those of ticks, which are made in drawing and cost as much as all else."""
    for child in artist.get_children():
        if isinstance(child, Text):
            yield child
        elif isinstance(child, Axis):
            yield child.label
        else:
            yield from _texts(child)


class _Canvas(FigureCanvasAgg):
    """A raster canvas that remembers the formulas of other figures: to parse them takes longer than to draw them."""

    def get_renderer(self) -> RendererAgg:
        renderer: RendererAgg = super().get_renderer()  # type: ignore[no-untyped-call]
        renderer.mathtext_parser = _PARSERS.setdefault("raster", renderer.mathtext_parser)
        return renderer


def new_figure(
    width_inch: float = 10.0, height_inch: float = 5.0, *, margins: Mapping[str, float] | None = None
) -> Figure:
    """Return an empty figure on a raster canvas."""
    figure = Figure(figsize=(width_inch, height_inch), layout="constrained" if margins is None else None)
    _Canvas(figure)
    if margins is not None:
        figure.subplots_adjust(**margins)
    return figure


_GIVEN: ContextVar[Axes | None] = ContextVar("given", default=None)


@contextmanager
def on_axes(axes: Axes | None) -> Iterator[None]:
    """Let the next figure be drawn on these axes instead of a page of its own; several panels take their place."""
    token = _GIVEN.set(axes)
    try:
        yield
    finally:
        _GIVEN.reset(token)


@contextmanager
def drawing(
    width_inch: float, height_inch: float, *, margins: Mapping[str, float] | None = None, **panels: Any
) -> Iterator[tuple[Any, Any]]:
    """Give an empty figure to draw on, in the house's style, and its axes, an array of them where they are several."""
    given = _GIVEN.get()
    with house_style():
        if given is None:
            figure = new_figure(width_inch, height_inch, margins=margins)
            yield figure, figure.subplots(**panels)
        elif panels:
            yield (part := _in_place_of(given)), part.subplots(**panels)
        else:
            yield given, given


def _in_place_of(axes: Axes) -> SubFigure:
    """Return a part of the figure that takes the place of axes of a grid."""
    place, figure = axes.get_subplotspec(), axes.figure
    if place is None:
        raise InputError("these axes belong to no grid", key="ax", fix="make them by figure.subplots()")
    axes.remove()
    return figure.add_subfigure(place)


def draw_chart(chart: Chart) -> FigureWithData:
    """Return the figure of a chart: its lines, thin grey ones for limits, a point where a line has one value."""
    with drawing(9.0, 6.0) as (figure, axes):
        drawn = 0
        for line in chart.lines:
            if line.limit:
                axes.plot(line.x, line.y, color=GREY, linewidth=1.0, label=line.name)
                continue
            dot: dict[str, Any] = {"marker": "os^Dv*"[drawn % 6], "linestyle": "none"}
            look = dot if line.x.size == 1 else {"linestyle": LINE_STYLES[drawn % 4]}
            axes.plot(line.x, line.y, label=line.name, **look)
            drawn += 1
        axes.set(xlabel=chart.x_label, ylabel=chart.y_label)
        axes.set_title(chart.title)
        legend_below(axes)
    names = [line.name for line in chart.lines]
    columns = {
        "line": np.repeat(names, [line.x.size for line in chart.lines]),
        chart.x_column: np.concatenate([line.x for line in chart.lines], dtype=np.float64),
        chart.y_column: np.concatenate([line.y for line in chart.lines], dtype=np.float64),
    }
    alt = f"{chart.title}: {chart.y_label} over {chart.x_label} of {', '.join(names)}."
    return FigureWithData(figure, (DataTable(columns),), alt)


def save_figure(
    figure: FigureWithData, folder: Folder | str | os.PathLike[str], stem: str
) -> tuple[Path, ...]:
    """Write a figure as PNG and the CSV of its data; return the paths, the picture first."""
    return as_folder(folder).write(figure_files(figure, stem))


def start_drawing(
    drawings: Mapping[str, Draw], folder: Folder, executor: Executor | None, **how: Any
) -> Callable[[Progress | None], dict[str, tuple[str, tuple[Path, ...]]]]:
    """Begin to draw figures, if there is an executor; return what writes their files.

    That returns for each figure its SVG, where it is to stand on a page, and the paths of its files.
    """
    jobs = {stem: partial(_drawn, draw, stem, **how) for stem, draw in drawings.items()}
    if executor is not None:
        forget_fonts()  # the executor may fork here, and this process goes on drawing
        futures = {executor.submit(job): stem for stem, job in jobs.items()}

    def write(progress: Progress | None = None) -> dict[str, tuple[str, tuple[Path, ...]]]:
        drawn: Iterable[tuple[str, tuple[str, dict[str, bytes]]]]
        if executor is None:
            drawn = ((stem, job()) for stem, job in jobs.items())
        else:
            drawn = ((futures[one], one.result()) for one in as_completed(futures))
        made: dict[str, tuple[str, tuple[Path, ...]]] = dict.fromkeys(jobs, ("", ()))
        for done, (stem, (svg, files)) in enumerate(drawn, start=1):
            # Workers draw, and this process alone writes.
            made[stem] = svg, folder.write(files)
            if progress is not None:
                progress(done, len(jobs), stem)
        return made

    return write


def _drawn(
    draw: Draw, stem: str, *, under: str = "", on_page: bool = False, formats: Collection[str] = ("png",)
) -> tuple[str, dict[str, bytes]]:
    """Draw a figure; return its SVG for a page, "" if it is not `on_page`, and its files `under` a folder."""
    figure = draw()
    files = figure_files(figure, f"{under}{stem}", formats=formats)
    return svg_text(figure, stem=stem) if on_page else "", files


def figure_files(figure: FigureWithData, stem: str, *, formats: Iterable[str] = ("png",)) -> dict[str, bytes]:
    """Return a figure in some formats and the CSV of its data, by file name: the same input gives the same bytes."""
    contents: dict[str, bytes] = {}
    for form in formats:
        stream = io.BytesIO()
        with house_style():
            figure.figure.savefig(stream, format=form, metadata=dict.fromkeys(FORMATS[form]))
        contents[f"{stem}.{form}"] = stream.getvalue()
    for table in figure.tables:
        text = csv_text([table.header, *([_cell(value) for value in row] for row in table.rows)])
        contents[f"{stem}_{table.name}.csv" if table.name else f"{stem}.csv"] = text.encode()
    return contents


def _cell(value: object) -> str:
    return f"{value:.8g}".replace("nan", "") if isinstance(value, float) else csv_cell(value)


_NUMBER = re.compile(r"[-.\d]+")
_REFERENCE = re.compile(r"(?<=url\(#)[^)]+|(?<=^#).+")  # a colour such as #ccc is none
_REFERRING = ("href", "clip-path", "style")
_FONT = "'DejaVu Sans'"
_FALLBACK = "Verdana,sans-serif"  # of nearly the same width
# Words with a symbol are drawn as plain words, the index between marks that no eye sees and every font has.
_MARK = "\u2063"
_INDEX = re.compile(f"(?<![A-Za-zφμρσ])([A-Za-zφμρσ]+){_MARK}([^{_MARK}]+){_MARK}")


def svg_text(figure: FigureWithData, *, stem: str = "") -> str:
    """Return a figure as an `<svg>` element for the inside of an HTML page; the same figure gives the same text.

    Text is text, so it can be selected and found, and no font is embedded. There is no date and no style sheet that
    would reach other parts of the page. Ids differ from those of any other figure with another stem.
    """
    stream, drawn = io.BytesIO(), figure.figure
    engine = drawn.get_layout_engine()
    rewrite_words(drawn, lambda text: TYPESET.sub(rf"\1{_MARK}\2{_MARK}", text))
    with house_style(), mpl.rc_context({"svg.fonttype": "none"}):
        try:
            if engine is not None and drawn.axes:
                # The layout is made once and held: left to itself, matplotlib draws everything twice to find it.
                engine.execute(drawn)
                drawn.set_layout_engine(None)
            drawn.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
        finally:
            rewrite_words(drawn, lambda text: _INDEX.sub(r"$\1_{\\mathrm{\2}}$", text))
            drawn.set_layout_engine(engine)
    root = ET.fromstring(stream.getvalue())  # noqa: S314  (what matplotlib has just written)
    for element in list(root.iter()):
        _clean(element)
    _name_in_turn(root, hashlib.sha256((stem or figure.alt).encode()).hexdigest()[:8])
    root.attrib = {
        "role": "img",
        "aria-label": visible(figure.alt),
        "viewBox": root.attrib["viewBox"],
        "class": "figure",
        "style": f"stroke-linejoin:round;stroke-linecap:butt;white-space:pre;font-family:{_FONT},{_FALLBACK}",
    }
    return ET.tostring(root, encoding="unicode")


def _clean(element: ET.Element) -> None:
    """Remove namespaces, metadata, the style sheet, and invisible digits, in which processors differ."""
    element.tag = element.tag.rpartition("}")[2]
    element[:] = [child for child in element if not child.tag.endswith(("}metadata", "}style"))]
    for key, value in [*element.attrib.items()]:
        del element.attrib[key]
        element.attrib[key.rpartition("}")[2]] = _NUMBER.sub(_rounded, value)
    if element.tag == "text":
        element.attrib["style"] = element.get("style", "").replace(_FONT, f"{_FONT},{_FALLBACK}")
        _set_indices(element)


def _rounded(number: re.Match[str]) -> str:
    decimals = number[0].partition(".")[2]
    if len(decimals) < 3 or not decimals.isdigit():
        return number[0]
    return f"{float(number[0]):.2f}".replace("-0.00", "0.00")


def _set_indices(text: ET.Element) -> None:
    """Set the index of every symbol in a text low and small, and what follows back on the line."""
    text.text, *rest = _INDEX.split(text.text or "")
    back: dict[str, str] = {}
    for symbol, index, behind in zip(rest[::3], rest[1::3], rest[2::3], strict=True):
        ET.SubElement(text, "tspan", {"font-style": "italic"} | back).text = symbol
        ET.SubElement(text, "tspan", {"dy": "2", "font-size": "70%"}).text = index
        back = {"dy": "-2"}
        if behind:
            ET.SubElement(text, "tspan", back).text = behind
            back = {}


def _name_in_turn(root: ET.Element, stem: str) -> None:
    """Name ids in turn, those referred to: matplotlib's are hashes of floats whose last bits the processor decides."""
    values = [value for element in root.iter() for value in element.attrib.values()]
    used = {name for value in values for name in _REFERENCE.findall(value)}
    names: dict[str, str] = {}
    for element in root.iter():
        name = element.attrib.pop("id", "")
        if name in used:
            element.attrib["id"] = names[name] = f"f{stem}_{len(names)}"
    for element in root.iter():
        for key in element.attrib.keys() & _REFERRING:
            element.attrib[key] = _REFERENCE.sub(lambda found: names[found.group()], element.attrib[key])
