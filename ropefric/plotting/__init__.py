"""Figures: the only room that knows matplotlib. Each figure carries the data it shows."""

__all__: list[str] = []

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
