"""Figures do not depend on what else a machine or a process is set up for."""

import io
import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from ropefric.plotting.figure import DataTable, FigureWithData, figure_files, forget_fonts, new_figure
from ropefric.plotting.style import house_style


@pytest.mark.slow
def test_threads_draw_what_one_draws():
    def draw(_):
        with house_style():
            figure = new_figure()
            axes = figure.subplots()
            axes.plot([0, 1, 2], [3.0, 1.0, 2.0], label="a line")
            axes.set(xlabel="wrap angle [deg]", ylabel="force [N]")
            axes.legend()
        made = FigureWithData(figure=figure, tables=(DataTable.of_rows(("x",), ((1.0,),)),))
        return figure_files(made, "figure")

    alone = draw(0)
    with ThreadPoolExecutor(3) as threads:
        assert all(one == alone for one in threads.map(draw, range(3)))


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="open files are listed on Linux only")
def test_a_process_to_be_forked_holds_no_font_open():
    """Two processes that share an open font read each other's glyphs: "invalid outline", or a wrong letter."""

    def fonts():
        return [
            name for name in map(os.path.realpath, Path("/proc/self/fd").iterdir()) if name.endswith(".ttf")
        ]

    def draw():
        figure = new_figure()
        axes = figure.add_subplot()
        axes.set(title="Force $F_A$", xlabel=r"$\varphi$")
        for name in ("png", "svg"):
            figure.savefig(io.BytesIO(), format=name)

    draw()
    assert fonts()
    forget_fonts()
    assert not fonts()
