"""What figures of a press have in common: the quantity they are drawn over, names beside lines, numbers of a span."""

from typing import TYPE_CHECKING

import numpy as np

from ropefric.errors import InputError
from ropefric.plotting.labels import typeset
from ropefric.plotting.style import GREY

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from ropefric.friction.condition import FloatArray
    from ropefric.systems.press.sweep import PressSweep

__all__ = ["PRELOAD_LABEL", "SPEED_LABEL", "grid_of", "line_axis", "name_lines", "same_lines", "span_of"]

SPEED_LABEL = "Belt speed v [m/s]"
PRELOAD_LABEL = "Preload of the tensioners F [N]"


def line_axis(sweep: "PressSweep") -> "tuple[str, str, FloatArray]":
    """Return column name, label and values of the one quantity a sweep goes over.

    Raises
    ------
    InputError
        If it goes over both or has one point only.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> line_axis(SimpleNamespace(preload_N=np.empty(0), speed_m_s=np.array([0.0, 1.0])))[1]
    'Belt speed v [m/s]'
    """
    if sweep.speed_m_s.size > 1 and sweep.preload_N.size <= 1:
        return "speed_m_s", SPEED_LABEL, sweep.speed_m_s
    if sweep.preload_N.size > 1 and sweep.speed_m_s.size == 1:
        return "preload_N", PRELOAD_LABEL, sweep.preload_N
    raise InputError(
        f"a sweep of {sweep.preload_N.size} preloads and {sweep.speed_m_s.size} speeds is not one line a roller",
        fix="take over_speed or over_preload, or draw a map",
    )


def grid_of(sweep: "PressSweep") -> "tuple[FloatArray, FloatArray]":
    """Return speeds and preloads of a sweep over both.

    Raises
    ------
    InputError
        If it goes over one of them only.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> line = SimpleNamespace(preload_N=np.empty(0), speed_m_s=np.array([0.0, 1.0]))
    >>> grid_of(line)
    Traceback (most recent call last):
    ...
    ropefric.errors.InputError: a map needs several preloads and speeds; the sweep has 0 and 2 Fix: take \
over_preload_and_speed
    """
    if min(sweep.speed_m_s.size, sweep.preload_N.size) < 2:
        raise InputError(
            "a map needs several preloads and speeds; "
            f"the sweep has {sweep.preload_N.size} and {sweep.speed_m_s.size}",
            fix="take over_preload_and_speed",
        )
    return sweep.speed_m_s, sweep.preload_N


def same_lines(names: "Sequence[str]", lines: "FloatArray", prefix: str) -> "list[tuple[str, FloatArray]]":
    """Return each different line once, with all its names.

    Parameters
    ----------
    names : sequence of str
        A name a column.
    lines : ndarray, shape (n, n_lines)
        The lines.
    prefix : str
        The symbol; the names become its indices.

    Examples
    --------
    >>> [name for name, _ in same_lines(("3", "4", "5"), np.array([[1.0, 1.0, 2.0]]), "T")]
    ['T_3, T_4', 'T_5']
    """
    groups: list[tuple[list[str], FloatArray]] = []
    for name, line in zip(names, lines.T, strict=True):
        for members, other in groups:
            if np.allclose(line, other, rtol=1e-9, atol=1e-12):
                members.append(name)
                break
        else:
            groups.append(([name], line))
    return [(", ".join(f"{prefix}_{name}" for name in members), line) for members, line in groups]


def name_lines(axes: "Axes", ends: "Sequence[tuple[str, float]]", *, gap: float = 0.042) -> None:
    """Write names at the right end of lines, pushed apart where they would touch; call it with the limits set.

    Parameters
    ----------
    axes : Axes
        With its lines and limits.
    ends : sequence of (str, float)
        Name and last value of each line.
    gap : float
        Least distance of two names as a share of the axes' height.

    Examples
    --------
    >>> from ropefric.plotting.figure import new_figure
    >>> axes = new_figure().subplots()
    >>> name_lines(axes, [("a", 0.5), ("b", 0.5)])
    >>> [round(text.xyann[1], 3) for text in axes.texts]
    [0.479, 0.521]
    """
    to_axes = axes.transData + axes.transAxes.inverted()
    right = axes.get_xlim()[1]
    wanted = sorted((float(to_axes.transform((right, value))[1]), name) for name, value in ends)
    # Names in order that are too close form a block about its mean; blocks that meet join.
    blocks = [[place] for place, _ in wanted]
    i = 0
    while i < len(blocks) - 1:
        low, high = _spread(blocks[i], gap), _spread(blocks[i + 1], gap)
        if high[0] - low[-1] < gap - 1e-9:
            blocks[i : i + 2] = [blocks[i] + blocks[i + 1]]
            i = max(i - 1, 0)
        else:
            i += 1
    spread = [place for block in blocks for place in _spread(block, gap)]
    for (true, name), place in zip(wanted, spread, strict=True):
        axes.annotate(
            typeset(name),
            xy=(1.0, true),
            xytext=(1.03, place),
            xycoords="axes fraction",
            textcoords="axes fraction",
            va="center",
            fontsize=9.0,
            annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": GREY, "linewidth": 0.6, "shrinkA": 0.0, "shrinkB": 0.0},
        )


def span_of(values: "FloatArray") -> str:
    """Return the range of some numbers in words.

    Examples
    --------
    >>> span_of(np.array([3.0, 1.0]))
    '1 to 3'
    """
    return f"{values.min():.4g} to {values.max():.4g}"


def _spread(block: "Sequence[float]", gap: float) -> "list[float]":
    middle = sum(block) / len(block)
    return [middle + gap * (i - 0.5 * (len(block) - 1)) for i in range(len(block))]
