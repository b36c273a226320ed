"""Figures: the only room that knows matplotlib. Each figure carries the data it shows.

In come results; out go a figure with its tables and its words, as PNG and CSV files or as SVG for a page.
- `figure`: a figure with its data and its files, and as SVG for the inside of a page
- `style`: how figures look, the words on them and their legends
- `results`: the figure behind `plot()` of every result
- `campaign`: each condition's recordings and repeatability, one recording, and a selection of them
- `fits`: fitted laws against what was measured; `design`: laws, budgets and swings in order of size, a design's chart
- `machines`: scenes, their sweeps and machines; `work_precision`: what accuracy costs in time
"""

import os


def _load_matplotlib() -> None:
    """Import matplotlib, which ends there if MPLBACKEND names no backend: figures are drawn to files without one."""
    named = os.environ.pop("MPLBACKEND", None)
    try:
        import matplotlib as mpl  # noqa: PLC0415
    finally:
        if named is not None:
            os.environ["MPLBACKEND"] = named
    if named:
        try:
            mpl.rcParams["backend"] = named  # what matplotlib itself does, for a notebook that shows figures
        except ValueError:
            return


_load_matplotlib()
