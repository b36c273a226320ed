"""A sweep as a figure: what is drawn is what was found, and the axes say what and in which unit."""

import numpy as np
import pytest

from ropefric.errors import InputError
from ropefric.plotting.machines import draw_sweep
from ropefric.scenes.sweep import Axis, Sweep

DEG = np.pi / 180.0


def made(*sizes):
    """A sweep whose lift force is the number of the point; its third point has no answer."""
    keys = [("wheel.wrap", "deg", DEG), ("load.end_tension", "N", 1.0), ("wheel.radius", "mm", 1e-3)]
    axes = tuple(
        Axis(key=key, values=factor * np.linspace(1.0, size, size), unit=unit, factor=factor)
        for (key, unit, factor), size in zip(keys, sizes, strict=False)
    )
    force = np.arange(float(np.prod(sizes)))
    force[2] = np.nan
    return Sweep(
        axes=axes,
        columns={"lift_force_N": force, "mu_average": 0.1 + 0.0 * force},
        failed=1,
        first_failure="lifts off",
        simulated=("size",),
        error_bound=0.0,
    )


def test_one_axis_is_a_line_with_units():
    figure = draw_sweep(made(5))
    (axes,) = figure.figure.axes
    assert axes.get_xlabel() == "wheel.wrap [deg]"
    assert "[N]" in axes.get_ylabel()
    (line,) = axes.get_lines()
    assert line.get_xdata() == pytest.approx([1, 2, 3, 4, 5])
    assert line.get_ydata() == pytest.approx([0, 1, np.nan, 3, 4], nan_ok=True)
    assert figure.tables[0].header == ("wheel.wrap", "lift_force_N")
    assert figure.tables[0].rows[4] == pytest.approx((5.0, 4.0))


def test_few_values_of_a_second_axis_are_lines_told_apart_without_colour():
    figure = draw_sweep(made(3, 4))
    axes = figure.figure.axes[0]
    looks = {line.get_linestyle() for line in axes.get_lines()}
    assert len(looks) == 3
    assert axes.get_lines()[1].get_ydata() == pytest.approx([4, 5, 6, 7])
    assert "wheel.wrap = 2 deg" in [line.get_label() for line in axes.get_lines()]
    assert figure.tables[0].rows[7] == pytest.approx((2.0, 4.0, 7.0))


def test_many_values_are_a_map_and_a_fine_grid_is_thinned_evenly():
    figure = draw_sweep(made(600, 700))
    table = figure.tables[0]
    assert len(table.rows) == 200 * 234
    places = {row[0] for row in table.rows}
    assert len(places) == 200
    assert table.rows[1] == pytest.approx((1.0, 4.0, 3.0))
    assert "[deg]" in figure.figure.axes[0].get_ylabel()


def test_another_number_is_drawn_on_demand_and_an_unknown_one_is_not():
    assert draw_sweep(made(5), quantity="mu_average").tables[0].header[-1] == "mu_average"
    with pytest.raises(InputError, match="lift_force_N"):
        draw_sweep(made(5), quantity="lift")
    with pytest.raises(InputError, match="one or two axes"):
        draw_sweep(made(2, 2, 2))
