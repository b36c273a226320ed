"""Legends that hide no data and say everything once."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["legend_below"]


def legend_below(axes: "Axes", *, columns: int = 2) -> None:
    """Put a legend under the axes with one entry for each label; none where nothing is labelled.

    Examples
    --------
    >>> from ropefric.plotting.figure import new_figure
    >>> axes = new_figure().subplots()
    >>> for i in range(3):
    ...     _ = axes.plot([i], [i], label="kept")
    >>> legend_below(axes)
    >>> [text.get_text() for text in axes.get_legend().get_texts()]
    ['kept']
    """
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
