"""Legends that hide no data and say everything once."""

from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def legend_below(axes: "Axes", *, columns: int = 2) -> None:
    """Put a legend under the axes with one entry for each label; none where nothing is labelled."""
    handles, labels = axes.get_legend_handles_labels()
    first = dict(zip(reversed(labels), reversed(handles), strict=True))
    order = list(dict.fromkeys(labels))
    if order:
        axes.legend(
            [first[label] for label in order],
            order,
            loc="upper center",
            bbox_to_anchor=(0.5, -0.15),
            ncols=columns,
        )


def legend_of_figure(figure: "Figure", *, columns: int = 5) -> None:
    """Put one legend under all axes of a figure, one entry for each label.

    A figure with constrained layout makes room for it; one with margins of its own needs to have it.
    """
    entries: dict[str, Any] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    if entries:
        fixed = figure.get_layout_engine() is None
        place: Literal["lower center", "outside lower center"] = (
            "lower center" if fixed else "outside lower center"
        )
        figure.legend(list(entries.values()), list(entries), loc=place, ncols=columns)
