"""Figures of a press show the sweep's numbers, name their lines, draw the limit, and refuse what they cannot show."""

import csv

import numpy as np
import pytest

from ropefric.errors import InputError, UnknownNameError
from ropefric.plotting.figure import save_figure
from ropefric.plotting.press import (
    MEASURE_LABELS,
    draw_press_map,
    draw_press_slip,
    draw_press_tension,
    draw_roller_maps,
    name_lines,
)
from ropefric.systems.press.critical import PressSweep
from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.slip import MEASURES
from ropefric.systems.press.statics import solve_statics

SPEEDS, PRELOADS = np.linspace(0.0, 8.0, 9), np.linspace(100.0, 1000.0, 10)


@pytest.fixture(scope="module")
def statics():
    """One belt over a driver, a loaded roller, an idler and a take-up."""
    rollers = (
        Roller(name="drive", radius_m=0.1, wrap_angle_rad=3.0, role="driver"),
        Roller(name="load", radius_m=0.1, wrap_angle_rad=1.0, squeeze_torque_N_m=12.0),
        Roller(name="idler", radius_m=0.1, wrap_angle_rad=1.0),
        Roller(
            name="take-up", radius_m=0.1, wrap_angle_rad=3.0, role="tensioner",
            tensioner=Tensioner(spring_N_m=0.0, travel_m=0.0, force_N=600.0),
        ),
    )  # fmt: skip
    loop = tuple(roller.name for roller in rollers)
    belt = Belt(name="belt", loop=loop, linear_density_kg_m=1.0, thickness_m=0.005, width_m=1.0)
    return solve_statics(Press(rollers=rollers, belts=(belt,), speed_m_s=2.0))


@pytest.fixture(scope="module")
def grid(statics):
    return PressSweep(statics, 0.6, preload_N=PRELOADS, speed_m_s=SPEEDS)


def test_tensions_are_drawn_once_and_named(statics):
    sweep = PressSweep(statics, 0.6, speed_m_s=SPEEDS)
    made = draw_press_tension(sweep)
    (axes,) = made.figure.axes
    assert [text.get_text() for text in axes.texts] == [
        "$T_{\\mathrm{1}}$", "$T_{\\mathrm{2}}$, $T_{\\mathrm{3}}$, $T_{\\mathrm{4}}$",
    ]  # fmt: skip
    np.testing.assert_array_equal(axes.lines[1].get_ydata(), sweep.effective_tension_N[0, :, 1])
    assert axes.get_xlabel() == "Belt speed v [m/s]"
    assert "[N]" in axes.get_ylabel()
    assert len(made.tables[0].rows) == SPEEDS.size * 4
    assert "T1 116 to 180 N" in made.alt


def test_slip_is_drawn_over_preload_with_its_limit(statics):
    sweep = PressSweep(statics, 0.6, preload_N=PRELOADS[3:])
    made = draw_press_slip(sweep)
    (axes,) = made.figure.axes
    assert axes.get_yscale() == "log"
    assert axes.get_xlabel().endswith("F [N]")
    drawn = [line for line in axes.lines if len(line.get_xdata()) == PRELOADS[3:].size]
    np.testing.assert_array_equal(drawn[1].get_ydata(), sweep.slip.of("load")[:, 0])
    assert any(list(line.get_ydata()) == [1.0, 1.0] for line in axes.lines)
    assert axes.get_title().endswith("without torque: idler, take-up")
    assert "roller load" in made.alt


@pytest.mark.parametrize("measure", MEASURES)
def test_every_measure_can_be_drawn(statics, measure):
    made = draw_press_slip(PressSweep(statics, 0.6, speed_m_s=SPEEDS), measure=measure, rollers=["load"])
    assert made.tables[0].header == ("speed_m_s", "roller", measure)
    assert made.figure.axes[0].get_ylabel().startswith(MEASURE_LABELS[measure][:10])
    assert all(np.isfinite(row[2]) for row in made.tables[0].rows)


def test_the_map_has_the_line_where_slip_begins(grid):
    made = draw_press_map(grid)
    axes = made.figure.axes[0]
    # U = 120 / ((F/2 − 120 − v²) (e^0.6 − 1)) = 1 for the roller `load`, on the line drawn.
    line = next(each for each in axes.collections if each.get_linewidth()[0] == 2.5)
    speed, preload = np.concatenate([path.vertices for path in line.get_paths()]).T
    wanted_N = 2.0 * (120.0 / np.expm1(0.6) + 120.0 + speed**2)
    np.testing.assert_allclose(preload, wanted_N, atol=0.25 * np.diff(PRELOADS)[0])
    rows = made.tables[0].rows
    assert len(rows) == SPEEDS.size * PRELOADS.size
    assert {row[3] for row in rows if row[2] > 1.0} >= {"load"}
    assert rows[0][4] is True
    assert any(each.hatches == ["///"] for each in axes.collections if hasattr(each, "hatches"))
    assert "a roller slips at" in made.alt


def test_maps_of_rollers_and_spans_stand_side_by_side(grid):
    made = draw_roller_maps(grid, ["load", "drive"])
    titles = [axes.get_title() for axes in made.figure.axes]
    assert titles[:2] == ["Roller load", "Roller drive"]
    assert made.tables[0].header == ("preload_N", "speed_m_s", "roller", "as_plotted")
    wanted = np.stack([grid.slip.of(roller, "as_plotted") for roller in ("load", "drive")]).ravel()
    np.testing.assert_array_equal([row[3] for row in made.tables[0].rows], wanted)


def test_a_sweep_of_the_wrong_kind_is_refused(statics, grid):
    line = PressSweep(statics, 0.6, speed_m_s=SPEEDS)
    for draw in (draw_press_tension, draw_press_slip):
        with pytest.raises(InputError, match="a sweep of 10 preloads and 9 speeds"):
            draw(grid)
    for draw in (
        draw_press_map,
        lambda s: draw_roller_maps(s, ["load"]),
    ):
        with pytest.raises(InputError, match="a map needs several preloads and speeds"):
            draw(line)
    with pytest.raises(UnknownNameError, match="no measure 'utilisation' of a roller 'laod'"):
        draw_press_slip(line, rollers=["laod"])


def test_names_never_touch_and_keep_their_order():
    from ropefric.plotting.figure import new_figure

    axes = new_figure().subplots()
    values = [0.5, 0.505, 0.51, 0.8, 0.2, 0.515]
    name_lines(axes, [(str(i), value) for i, value in enumerate(values)])
    places = {text.get_text(): text.xyann[1] for text in axes.texts}
    heights = [places[str(i)] for i in np.argsort(values)]
    assert (np.diff(heights) > 0.042 - 1e-9).all()
    assert places["3"] == pytest.approx(0.8)


def test_the_same_sweep_gives_the_same_bytes_and_its_data(statics, grid, tmp_path):
    for i, made in enumerate((draw_press_map, lambda s: draw_roller_maps(s, ["load"]))):
        first = save_figure(made(grid), tmp_path / "a", f"map{i}")
        second = save_figure(made(grid), tmp_path / "b", f"map{i}")
        assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]
    with (tmp_path / "a" / "map0.csv").open(encoding="utf-8") as stream:
        assert len(list(csv.DictReader(stream))) == SPEEDS.size * PRELOADS.size
