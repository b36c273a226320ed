"""Figures into files: the same input gives the same bytes."""

import csv
import io
import math
import os
from pathlib import Path

from ropefric.errors import InputError
from ropefric.files.folder import Folder, as_folder
from ropefric.files.plain_text import to_spreadsheet
from ropefric.plotting.figure import DataTable, FigureWithData
from ropefric.plotting.style import house_style
from ropefric.registry import did_you_mean

# Dates and version strings would change the bytes of an unchanged figure.
FORMATS: dict[str, dict[str, None]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}
"""File formats and the metadata left out of them."""


def save_figure(
    figure: FigureWithData,
    folder: Folder | str | os.PathLike[str],
    stem: str,
    *,
    formats: tuple[str, ...] = ("png",),
) -> tuple[Path, ...]:
    """Write a figure and the CSV of its data; return the paths, pictures first."""
    return as_folder(folder).write(figure_files(figure, stem, formats=formats))


def figure_files(
    figure: FigureWithData, stem: str, *, formats: tuple[str, ...] = ("png",)
) -> dict[str, bytes]:
    """Return what `save_figure` writes, by file name."""
    for name in formats:
        if name not in FORMATS:
            raise InputError(f"no figures in format {name!r}", fix=did_you_mean(name, FORMATS))
    contents: dict[str, bytes] = {}
    with house_style():
        for name in formats:
            stream = io.BytesIO()
            figure.figure.savefig(stream, format=name, metadata=FORMATS[name])
            contents[f"{stem}.{name}"] = stream.getvalue()
    for table in figure.tables:
        contents[f"{stem}_{table.name}.csv" if table.name else f"{stem}.csv"] = _csv_text(table).encode()
    return contents


def _csv_text(table: DataTable) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(table.header)
    writer.writerows([_cell(value) for value in row] for row in table.rows)
    return stream.getvalue()


def _cell(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.8g}"
    return to_spreadsheet(value) if isinstance(value, str) else str(value)
