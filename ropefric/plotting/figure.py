"""A figure together with the numbers it shows and its words for those who cannot see it; its legends and files."""

import gc
import io
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from matplotlib import font_manager
from matplotlib.artist import Artist
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
from matplotlib.figure import Figure
from matplotlib.mathtext import MathTextParser
from matplotlib.text import Text

from ropefric.files.folder import Folder, as_folder
from ropefric.files.plain_text import csv_cell, csv_text, localized
from ropefric.glossary import counted
from ropefric.plotting.style import figure_text, house_style, plain_text

T = TypeVar("T")

# Without date and matplotlib's version, which would change an unchanged figure.
FORMATS = {
    "png": ("Software",),
    "svg": ("Date", "Creator"),
    "pdf": ("CreationDate", "Creator", "Producer"),
}
"""What a figure can be written as, and what is not to be said in it."""

_PARSERS: dict[str, Any] = {}


def begin(
    jobs: Mapping[str, Callable[[], T]], executor: Executor | None
) -> Callable[[], Iterable[tuple[str, T]]]:
    """Begin to draw, if there is an executor; return what gives the name and the outcome of each job as it is done."""
    if executor is None:
        return lambda: ((name, _done(job)) for name, job in jobs.items())
    forget_fonts()  # the executor may fork here, and this process goes on drawing
    names = {executor.submit(_done, job): name for name, job in jobs.items()}
    return lambda: ((names[future], future.result()) for future in as_completed(names))


def _done(job: Callable[[], T]) -> T:
    """Do a job, and look for garbage only after it: a tenth of a figure's time goes into looking while it is made."""
    looked = gc.isenabled()
    gc.disable()
    try:
        return job()
    finally:
        if looked:
            gc.enable()


def forget_fonts() -> None:
    """Let go of every open font: processes forked with one share its place in the file and read each other's glyphs."""
    _PARSERS.clear()
    MathTextParser._parse_cached.cache_clear()  # type: ignore[attr-defined]  # noqa: SLF001  (they keep fonts)
    font_manager._get_font.cache_clear()  # type: ignore[attr-defined]  # noqa: SLF001
    gc.collect()  # figures that are done with hold them in cycles


@dataclass(frozen=True, slots=True)
class DataTable:
    """Numbers behind a figure: columns of one length, each under its heading."""

    columns: Mapping[str, Iterable[object]]
    name: str = ""

    @classmethod
    def of_rows(cls, header: Sequence[str], rows: Sequence[Sequence[object]], name: str = "") -> "DataTable":
        """Return the table of rows under a header."""
        columns = zip(*rows, strict=True) if rows else [()] * len(header)
        return cls(dict(zip(header, columns, strict=True)), name)

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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FigureWithData:
    """A figure and the tables of what it shows."""

    figure: Figure
    tables: tuple[DataTable, ...]
    alt: str = ""

    def __post_init__(self) -> None:
        # Names of trials and machine parts are anybody's: the one place that keeps them from being taken for TeX.
        rewrite_words(self.figure, figure_text)
        if not self.alt.strip():
            pairs = [(axes.get_ylabel(), axes.get_xlabel()) for axes in self.figure.axes]
            named = [" over ".join(word for word in pair if word) for pair in pairs]
            panels = plain_text("; ".join(words for words in named if words)) or "Figure"
            rows = len(self.tables[0].rows) if self.tables else 0
            object.__setattr__(self, "alt", f"{panels} ({counted(rows, 'row')} of data).")


def rewrite_words(figure: Figure, rewrite: Callable[[str], str]) -> None:
    """Rewrite every text of a figure, the words at its ticks too."""
    for text in _texts(figure):
        shown = text.get_text()
        if shown and (new := rewrite(shown)) != shown:
            text.set_text(new)
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            # Ticks with words of their own: matplotlib asks for these again at each drawing.
            for named in getattr(getattr(axis.get_major_formatter(), "func", None), "args", ()):
                if isinstance(named, dict):
                    named.update({place: rewrite(word) for place, word in named.items()})


def localize(figure: Figure, language: str, names: Collection[str] = ()) -> None:
    """Set the numbers of a figure as a language writes them, in its words and at its axes; names stay."""
    if language == "en":
        return
    local = partial(localized, language=language, names=names)
    rewrite_words(figure, local)
    for axes in figure.axes:
        for part in (axes, *axes.child_axes):
            for axis in (part.xaxis, part.yaxis):
                for formatter in (axis.get_major_formatter(), axis.get_minor_formatter()):
                    formatter.format_ticks = partial(_local_ticks, formatter.format_ticks, local)  # type: ignore[method-assign]


def _local_ticks(
    format_ticks: Callable[[Any], list[str]], local: Callable[[str], str], values: Any
) -> list[str]:
    return [local(text) for text in format_ticks(values)]


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


@contextmanager
def drawing(
    width_inch: float = 10.0, height_inch: float = 5.0, *, margins: Mapping[str, float] | None = None
) -> Iterator[Figure]:
    """Give an empty figure to draw on, in the house's style."""
    with house_style():
        yield new_figure(width_inch, height_inch, margins=margins)


def save_figure(
    figure: FigureWithData, folder: Folder | str | os.PathLike[str], stem: str
) -> tuple[Path, ...]:
    """Write a figure as PNG and the CSV of its data; return the paths, the picture first."""
    return as_folder(folder).write(figure_files(figure, stem))


def figure_files(figure: FigureWithData, stem: str, *, formats: Iterable[str] = ("png",)) -> dict[str, bytes]:
    """Return a figure in some formats and the CSV of its data, by file name: the same input gives the same bytes."""
    contents: dict[str, bytes] = {}
    for form in formats:
        stream = io.BytesIO()
        with house_style():
            figure.figure.savefig(stream, format=form, metadata=dict.fromkeys(FORMATS[form]))
        contents[f"{stem}.{form}"] = stream.getvalue()
    for table in figure.tables:
        rows = zip(*(_cells(_listed(column)) for column in table.columns.values()), strict=True)
        text = csv_text([table.header, *rows])
        contents[f"{stem}_{table.name}.csv" if table.name else f"{stem}.csv"] = text.encode()
    return contents


def _cells(column: list[object]) -> list[object]:
    if all(type(value) is float for value in column):
        # All in one go: the traces of a campaign are half a million numbers.
        return [*("%.8g\n" * len(column) % tuple(column)).replace("nan", "").split("\n")[:-1]]
    if all(type(value) is str for value in column):
        shown = {word: csv_cell(word) for word in set(column)}  # names of trials, at each of their samples
        return [shown[word] for word in column]
    return [
        f"{value:.8g}".replace("nan", "") if isinstance(value, float) else csv_cell(value) for value in column
    ]
