"""A figure together with the numbers it shows."""

from collections.abc import Mapping
from dataclasses import dataclass

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from ropefric.glossary import counted
from ropefric.plotting.labels import figure_text
from ropefric.plotting.words import plain_text


@dataclass(frozen=True, slots=True, kw_only=True)
class DataTable:
    """Numbers behind a figure, as a table."""

    name: str = ""
    header: tuple[str, ...]
    rows: tuple[tuple[object, ...], ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FigureWithData:
    """A figure and the tables of what it shows."""

    figure: Figure
    tables: tuple[DataTable, ...]
    alt: str = ""

    def __post_init__(self) -> None:
        # Names of trials and machine parts are anybody's: the one place that keeps them from being taken for TeX.
        for text in self.figure.findobj(Text):
            shown = text.get_text()
            if shown and (safe := figure_text(shown)) != shown:
                text.set_text(safe)
        for axes in self.figure.axes:
            for axis in (axes.xaxis, axes.yaxis):
                # Ticks with words of their own: matplotlib asks for these again at each drawing.
                words = getattr(getattr(axis.get_major_formatter(), "func", None), "args", ())
                for named in words:
                    if isinstance(named, dict):
                        named.update({place: figure_text(word) for place, word in named.items()})
        if not self.alt.strip():
            object.__setattr__(self, "alt", self._named_axes())

    def _named_axes(self) -> str:
        pairs = [(axes.get_ylabel(), axes.get_xlabel()) for axes in self.figure.axes]
        named = [" over ".join(word for word in pair if word) for pair in pairs]
        panels = plain_text("; ".join(words for words in named if words)) or "Figure"
        rows = len(self.tables[0].rows) if self.tables else 0
        return f"{panels} ({counted(rows, 'row')} of data)."


def new_figure(
    width_inch: float = 10.0, height_inch: float = 5.0, *, margins: Mapping[str, float] | None = None
) -> Figure:
    """Return an empty figure on a raster canvas."""
    figure = Figure(figsize=(width_inch, height_inch), layout="constrained" if margins is None else None)
    FigureCanvasAgg(figure)
    if margins is not None:
        figure.subplots_adjust(**margins)
    return figure
