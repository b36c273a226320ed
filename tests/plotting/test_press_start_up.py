"""The figure of a start-up shows the numbers of its result, marks every slip, and is the same each time."""

import csv

import numpy as np
import pytest

from ropefric.plotting.figure import save_figure
from ropefric.plotting.machines import draw_press_start_up, name_lines
from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.transient.drives import DRIVE_LAWS
from ropefric.systems.press.transient.start_up import start_up


@pytest.fixture(scope="module")
def press():
    take_up = Tensioner(spring_N_m=1e4, travel_m=0.01, force_N=900.0, mass_kg=30.0, damping_N_s_m=200.0)
    rollers = (
        Roller(name="drive", radius_m=0.1, wrap_angle_rad=3.0, role="driver"),
        Roller(name="load", radius_m=0.1, wrap_angle_rad=2.0, squeeze_torque_N_m=20.0, inertia_kg_m2=0.3),
        Roller(
            name="take-up",
            radius_m=0.08,
            wrap_angle_rad=3.0,
            role="tensioner",
            tensioner=take_up,
            inertia_kg_m2=0.2,
        ),
    )
    belt = Belt(
        name="belt", loop=("drive", "load", "take-up"), linear_density_kg_m=8.0, thickness_m=0.005, width_m=1.0,
        axial_stiffness_N=2e5, damping_s=2e-3, span_lengths_m=(0.8, 1.0, 1.3),
    )  # fmt: skip
    return Press(rollers=rollers, belts=(belt,), speed_m_s=1.0)


def started(press, friction):
    speed = DRIVE_LAWS["ramp"](speed_m_s=1.0, duration_s=0.5)
    return start_up(press, speed=speed, time_s=np.linspace(0.0, 1.5, 76), friction=friction)


def test_panels_show_tensions_speeds_slips_and_the_balance(press):
    found = started(press, 0.12)
    assert found.slips
    drawn = draw_press_start_up(found)
    tension, speed, slip, energy = drawn.figure.axes
    for i, line in enumerate(tension.lines):
        np.testing.assert_array_equal(line.get_ydata(), found.tension_N[:, i])
    np.testing.assert_allclose(speed.lines[1].get_ydata(), 0.1 * found.roller_speed_rad_s[:, 1])
    np.testing.assert_array_equal(speed.lines[-1].get_ydata(), found.drive_speed_m_s)
    assert [(bar.get_x(), bar.get_x() + bar.get_width()) for bar in slip.patches] == [
        (one.start_s, pytest.approx(one.end_s)) for one in found.slips
    ]
    named = {text.get_text() for text in slip.get_yticklabels()}
    assert named == {f"roller {one.roller}" for one in found.slips}
    assert (energy.lines[0].get_ydata() < 1e-8).all()
    assert "the belt slips on roller" in drawn.alt
    for axes, unit in zip(drawn.figure.axes, ("[N]", "[m/s]", "Slip", "[-]"), strict=True):
        assert unit in axes.get_ylabel()


def test_a_start_without_slip_says_so(press):
    drawn = draw_press_start_up(started(press, 2.0))
    assert [text.get_text() for text in drawn.figure.axes[2].texts] == ["no belt slips"]
    assert drawn.alt.endswith("no belt slips.")
    assert drawn.tables[1].rows == ()


def test_the_same_start_gives_the_same_bytes_and_its_data(press, tmp_path):
    found = started(press, 0.12)
    first = save_figure(draw_press_start_up(found), tmp_path / "a", "start")
    second = save_figure(draw_press_start_up(started(press, 0.12)), tmp_path / "b", "start")
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]
    assert {path.name for path in first} == {"start.png", "start.csv", "start_slips.csv"}
    with (tmp_path / "a" / "start.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 76
    assert float(rows[-1]["tension_2_N"]) == pytest.approx(found.tension_N[-1, 1], rel=1e-7)
    assert float(rows[-1]["rim_speed_load_m_s"]) == pytest.approx(
        0.1 * found.roller_speed_rad_s[-1, 1], abs=1e-7
    )


def test_names_never_touch_and_keep_their_order():
    from ropefric.plotting.figure import new_figure

    axes = new_figure().subplots()
    values = [0.5, 0.505, 0.51, 0.8, 0.2, 0.515]
    name_lines(axes, [(str(i), value) for i, value in enumerate(values)])
    places = {text.get_text(): text.xyann[1] for text in axes.texts}
    heights = [places[str(i)] for i in np.argsort(values)]
    assert (np.diff(heights) > 0.042 - 1e-9).all()
    assert places["3"] == pytest.approx(0.8)
