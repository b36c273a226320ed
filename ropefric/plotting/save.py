"""Figures into files: the same input gives the same bytes."""

import csv
import math
from pathlib import Path

from ropefric.errors import InputError
from ropefric.files.plain_text import to_spreadsheet
from ropefric.plotting.figure import DataTable, FigureWithData
from ropefric.plotting.style import house_style
from ropefric.registry import did_you_mean

__all__ = ["FORMATS", "save_figure"]

# Dates and version strings would change the bytes of an unchanged figure.
FORMATS: dict[str, dict[str, None]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
"""File formats and the metadata left out of them."""


def save_figure(
    figure: FigureWithData, folder: Path, stem: str, *, formats: tuple[str, ...] = ("png",)
) -> tuple[Path, ...]:
    """Write a figure and the CSV of its data; return the paths, pictures first.

    Parameters
    ----------
    figure : FigureWithData
        What to write.
    folder : Path
        Made where it is missing.
    stem : str
        File name without suffix; tables beyond the main one add their name to it.
    formats : tuple of str
        "png", "svg", "pdf".

    Raises
    ------
    InputError
        For another format.

    Examples
    --------
    >>> import tempfile
    >>> from ropefric.plotting.figure import new_figure
    >>> made = FigureWithData(figure=new_figure(), tables=(DataTable(header=("n",), rows=((12,),)),))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [path.name for path in save_figure(made, Path(folder), "empty")]
    ['empty.png', 'empty.csv']
    """
    for name in formats:
        if name not in FORMATS:
            raise InputError(f"no figures in format {name!r}", fix=did_you_mean(name, FORMATS))
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    with house_style():
        for name in formats:
            paths.append(folder / f"{stem}.{name}")
            figure.figure.savefig(paths[-1], format=name, metadata=FORMATS[name])
    for table in figure.tables:
        paths.append(folder / (f"{stem}_{table.name}.csv" if table.name else f"{stem}.csv"))
        _write_csv(table, paths[-1])
    return tuple(paths)


def _write_csv(table: DataTable, path: Path) -> None:
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(table.header)
        writer.writerows([_cell(value) for value in row] for row in table.rows)


def _cell(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.8g}"
    return to_spreadsheet(value) if isinstance(value, str) else str(value)
