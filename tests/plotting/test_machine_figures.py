"""Figures of scenes: a start-up of a press, the Campbell chart of a saw, a design's chart, a sweep."""

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ropefric.errors import InputError
from ropefric.fitting.design import design_chart
from ropefric.fitting.predict import predict
from ropefric.fitting.store import load_fit
from ropefric.friction.condition import Conditions
from ropefric.plotting.design import draw_design_chart
from ropefric.plotting.figure import figure_files, new_figure
from ropefric.plotting.machines import draw_press_start_up, draw_saw_chart, draw_sweep, name_lines
from ropefric.scenes.sweep import Axis, Sweep
from ropefric.systems.bandsaw.answer import SawProblem, frequencies_Hz
from ropefric.systems.bandsaw.effects import SYSTEM
from ropefric.systems.bandsaw.resonance import fixed_frequency, saw_chart, tooth_passing, wheel_rotation
from ropefric.systems.bandsaw.saw import Side
from ropefric.systems.effect import assemble
from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.transient.drives import DRIVE_LAWS
from ropefric.systems.press.transient.start_up import start_up


def rows_of(table):
    return list(csv.DictReader(table.decode().splitlines()))


def texts(axes):
    return [text.get_text() for text in axes.texts]


def legend(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


# The start-up of a press.


@pytest.fixture(scope="module")
def press():
    take_up = Tensioner(spring_N_m=1e4, travel_m=0.01, force_N=900.0, mass_kg=30.0, damping_N_s_m=200.0)
    rollers = (
        Roller(name="drive", radius_m=0.1, wrap_angle_rad=3.0, role="driver"),
        Roller(name="load", radius_m=0.1, wrap_angle_rad=2.0, squeeze_torque_N_m=20.0, inertia_kg_m2=0.3),
        Roller(
            name="take-up", radius_m=0.08, wrap_angle_rad=3.0, role="tensioner", tensioner=take_up, inertia_kg_m2=0.2
        ),
    )  # fmt: skip
    belt = Belt(
        name="belt", loop=("drive", "load", "take-up"), linear_density_kg_m=8.0, thickness_m=0.005, width_m=1.0,
        axial_stiffness_N=2e5, damping_s=2e-3, span_lengths_m=(0.8, 1.0, 1.3),
    )  # fmt: skip
    return Press(rollers=rollers, belts=(belt,), speed_m_s=1.0)


def started(press, friction):
    speed = DRIVE_LAWS["ramp"](speed_m_s=1.0, duration_s=0.5)
    return start_up(press, speed=speed, time_s=np.linspace(0.0, 1.5, 76), friction=friction)


def test_panels_show_tensions_speeds_and_slips(press, told):
    found = started(press, 0.12)
    assert found.slips
    drawn = told(draw_press_start_up(found))
    tension, speed, slip = drawn.figure.axes
    for i, line in enumerate(tension.lines):
        np.testing.assert_array_equal(line.get_ydata(), found.tension_N[:, i])
    np.testing.assert_allclose(speed.lines[1].get_ydata(), 0.1 * found.roller_speed_rad_s[:, 1])
    np.testing.assert_array_equal(speed.lines[-1].get_ydata(), found.drive_speed_m_s)
    bars = [(bar.get_x(), bar.get_x() + bar.get_width()) for bar in slip.patches]
    assert bars == [(one.start_s, pytest.approx(one.end_s)) for one in found.slips]
    assert {text.get_text() for text in slip.get_yticklabels()} == {
        f"roller {one.roller}" for one in found.slips
    }
    assert "the belt slips on roller" in drawn.alt
    for axes, unit in zip(drawn.figure.axes, ("[N]", "[m/s]", "Slip"), strict=True):
        assert unit in axes.get_ylabel()
    files = figure_files(drawn, "start", formats=())
    assert {*files} == {"start.csv", "start_slips.csv"}
    rows = rows_of(files["start.csv"])
    assert len(rows) == 76
    assert float(rows[-1]["tension_2_N"]) == pytest.approx(found.tension_N[-1, 1], rel=1e-7)
    rim_m_s = 0.1 * found.roller_speed_rad_s[-1, 1]
    assert float(rows[-1]["rim_speed_load_m_s"]) == pytest.approx(rim_m_s, abs=1e-7)


def test_a_start_without_slip_says_so(press):
    drawn = draw_press_start_up(started(press, 2.0))
    assert texts(drawn.figure.axes[2]) == ["no belt slips"]
    assert drawn.alt.endswith("no belt slips.")
    assert drawn.tables[1].rows == ()


def test_names_never_touch_and_keep_their_order():
    axes = new_figure().subplots()
    values = [0.5, 0.505, 0.51, 0.8, 0.2, 0.515]
    name_lines(axes, [(str(i), value) for i, value in enumerate(values)])
    places = {text.get_text(): text.xyann[1] for text in axes.texts}
    assert (np.diff([places[str(i)] for i in np.argsort(values)]) > 0.042 - 1e-9).all()
    assert places["3"] == pytest.approx(0.8)


# The Campbell chart of a saw.

SAW = SawProblem(
    n_modes=2, free_span_m=1.6, linear_density_kg_m=0.5967, preload_N=3412.0, wheel_radius_m=0.35,
    wheel_speed_rad_s=970 * math.pi / 30, tension_difference_N=210.95,
)  # fmt: skip
SPEEDS = np.linspace(0.0, 60.0, 25)


def saw_chart_of(saw=SAW):
    shakes = (wheel_rotation(0.35), tooth_passing(0.04), fixed_frequency("fan", 500.0))
    return saw_chart(assemble(SYSTEM, saw, SYSTEM.effects), shakes, SPEEDS, n_modes=2)


def test_lines_are_the_modes_and_circles_the_crossings(told):
    made = saw_chart_of()
    drawn = told(draw_saw_chart(made))
    (axes,) = drawn.figure.axes
    lines = [line for line in axes.lines if line.get_label() in {"tight side", "slack side"}]
    modes = [(side, mode) for side in (Side.TIGHT, Side.SLACK) for mode in (0, 1)]
    for line, (side, mode) in zip(lines, modes, strict=True):
        wanted_Hz = frequencies_Hz(assemble(SYSTEM, SAW, SYSTEM.effects), side, 2, speed_m_s=SPEEDS)[:, mode]
        np.testing.assert_allclose(line.get_ydata(), wanted_Hz, rtol=1e-12)
    circles = {(float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in axes.lines
        if line.get_marker() == "o"}  # fmt: skip
    assert circles == {(crossing.speed_m_s, crossing.frequency_Hz) for crossing in made.crossings}
    work = [line for line in axes.lines if line.get_label() == "speed at work"]
    assert work[0].get_xdata()[0] == pytest.approx(35.552, abs=1e-3)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("Blade speed v [m/s]", "Frequency f [Hz]")
    excitations = ["wheel rotation", "tooth passing", "fan (above the chart)"]
    assert legend(axes) == ["tight side", "slack side", *excitations, "speed at work"]
    assert {"mode 1", "mode 2", "1×", "2×", "3×"} <= set(texts(axes))
    files = figure_files(drawn, "saw", formats=())
    assert [*files] == ["saw.csv", "saw_crossings.csv"]
    assert len(rows_of(files["saw.csv"])) == 4 * SPEEDS.size
    rows = rows_of(files["saw_crossings.csv"])
    assert len(rows) == len(made.crossings)
    assert float(rows[0]["speed_m_s"]) == pytest.approx(made.crossings[0].speed_m_s, rel=1e-7)


def test_a_saw_at_rest_has_no_speed_at_work():
    (axes,) = draw_saw_chart(saw_chart_of(replace(SAW, wheel_speed_rad_s=0.0))).figure.axes
    assert not [line for line in axes.lines if line.get_label() == "speed at work"]


# The chart of a design.

FIT = Path(__file__).parents[2] / "fits" / "prth-coupled.json"


def chart():
    radii_m, wraps_rad = np.array([0.02, 0.05]), np.linspace(1.0, 25.0, 13)
    return design_chart(load_fit(FIT), radii_m, wraps_rad, 60.0, rope_radius_m=0.0049)


def test_lines_are_the_predictions_and_pale_outside_the_tested_range(told):
    made = chart()
    drawn = told(draw_design_chart(made))
    (axes,) = drawn.figure.axes
    assert (axes.get_yscale(), axes.get_xlabel()) == ("log", "Wrap angle φ [deg]")
    assert all(words in axes.get_ylabel() for words in ("Lift force", "[N]"))
    whole, tested = axes.lines[0], axes.lines[1]
    at = Conditions(
        wheel_radius_m=0.02, rope_radius_m=0.0049, wrap_angle_rad=made.wrap_angle_rad, end_tension_N=60.0
    )
    np.testing.assert_allclose(whole.get_ydata(), predict(load_fit(FIT), at).lift_force_N, rtol=1e-12)
    shown = np.isfinite(tested.get_ydata())
    np.testing.assert_array_equal(shown, ~made.extrapolated[0])
    assert 0 < shown.sum() < shown.size
    assert legend(axes)[2:] == ["not tested: extrapolated"]
    assert axes.lines[1].get_marker() != axes.lines[3].get_marker()
    ends_N = axes.collections[0].get_paths()[0].vertices[:, 1]
    assert {made.lower_bound_N[0, 0], made.lift_force_N[0, 0]} <= {*ends_N.tolist()}
    hatched = [patch for patch in axes.patches if patch.get_hatch()]
    nowhere = np.degrees(made.wrap_angle_rad[made.extrapolated.all(axis=0)])
    for wrap_deg in nowhere:
        assert any(patch.get_x() <= wrap_deg <= patch.get_x() + patch.get_width() for patch in hatched)
    tested_deg = np.degrees(made.wrap_angle_rad[~made.extrapolated.all(axis=0)])
    for wrap_deg in tested_deg:
        assert not any(patch.get_x() < wrap_deg < patch.get_x() + patch.get_width() for patch in hatched)
    assert (axes.child_axes[0].get_xlabel(), len(drawn.tables[0].rows)) == ("Wrap [turns]", 26)


def test_the_design_is_marked_with_its_interval():
    at = Conditions(wheel_radius_m=0.05, rope_radius_m=0.0049, wrap_angle_rad=7.0, end_tension_N=60.0)
    found = predict(load_fit(FIT), at)
    (axes,) = draw_design_chart(chart(), design=found).figure.axes
    (mark,) = axes.containers
    assert (mark[0].get_xdata()[0], mark[0].get_ydata()[0]) == (np.degrees(7.0), found.lift_force_N[0])
    np.testing.assert_allclose(mark.lines[2][0].get_segments()[0][:, 1], found.prediction_interval_N[0])
    assert f"design: {found.lift_force_N[0]:.4g} N" in legend(axes)


def test_a_law_without_an_answer_leaves_a_gap_and_one_without_a_size_effect_has_one_line():
    made = chart()
    made.lift_force_N[0, 3] = np.nan
    assert np.isnan(draw_design_chart(made).tables[0].rows[3][3])
    made.lift_force_N[1] = made.lift_force_N[0]
    (axes,) = draw_design_chart(made).figure.axes
    assert legend(axes) == ["$R_{\\mathrm{w}}$ = 20 to 50 mm, the same", "not tested: extrapolated"]


# A sweep.


def swept(*sizes):
    """A sweep whose lift force is the number of the point; its third point has no answer."""
    keys = [("wheel.wrap", "deg", np.pi / 180.0), ("load.end_tension", "N", 1.0),
        ("wheel.radius", "mm", 1e-3)]  # fmt: skip
    axes = tuple(Axis(key=key, values=factor * np.linspace(1.0, size, size), unit=unit, factor=factor)
        for (key, unit, factor), size in zip(keys, sizes, strict=False))  # fmt: skip
    force = np.arange(float(np.prod(sizes)))
    force[2] = np.nan
    columns = {"lift_force_N": force, "mu_average": 0.1 + 0.0 * force}
    failed = {"failed": 1, "first_failure": "lifts off"}
    return Sweep(axes=axes, columns=columns, simulated=("size",), error_bound=0.0, **failed)


def test_one_axis_is_a_line_with_units():
    figure = draw_sweep(swept(5))
    (axes,) = figure.figure.axes
    assert axes.get_xlabel() == "wheel.wrap [deg]"
    assert "[N]" in axes.get_ylabel()
    (line,) = axes.get_lines()
    assert line.get_xdata() == pytest.approx([1, 2, 3, 4, 5])
    assert line.get_ydata() == pytest.approx([0, 1, np.nan, 3, 4], nan_ok=True)
    assert figure.tables[0].header == ("wheel.wrap", "lift_force_N")
    assert figure.tables[0].rows[4] == pytest.approx((5.0, 4.0))


def test_a_second_axis_is_lines_told_apart_without_colour_or_a_map():
    figure = draw_sweep(swept(3, 4))
    lines = figure.figure.axes[0].get_lines()
    assert len({line.get_linestyle() for line in lines}) == 3
    assert lines[1].get_ydata() == pytest.approx([4, 5, 6, 7])
    assert "wheel.wrap = 2 deg" in [line.get_label() for line in lines]
    assert figure.tables[0].rows[7] == pytest.approx((2.0, 4.0, 7.0))
    # A fine grid is thinned evenly.
    figure = draw_sweep(swept(600, 700))
    rows = figure.tables[0].rows
    assert (len(rows), len({row[0] for row in rows})) == (200 * 234, 200)
    assert rows[1] == pytest.approx((1.0, 4.0, 3.0))
    assert "[deg]" in figure.figure.axes[0].get_ylabel()


@pytest.mark.parametrize("shape", [(5,), (3, 4), (60, 70)])
def test_points_outside_of_what_was_tested_are_marked(shape):
    sweep = swept(*shape)
    outside = (np.arange(np.prod(shape)) % 3 > 1).astype(float)
    marked = replace(sweep, columns=sweep.columns | {"extrapolated": outside}, extrapolated_at={"wrap": 1})
    figure = draw_sweep(marked)
    assert figure.tables[0].header[-1] == "extrapolated"
    assert [row[-1] for row in figure.tables[0].rows] == outside.tolist()
    axes = figure.figure.axes[0]
    if shape[0] < 10:
        masks = outside.reshape(-1, shape[-1]) > 0.0
        hatched = [patch for patch in axes.patches if patch.get_hatch()]
        assert len(hatched) == masks.all(axis=0).sum() == (1 if shape == (5,) else 0)
        if hatched:
            assert (hatched[0].get_x(), hatched[0].get_x() + hatched[0].get_width()) == (2.0, 4.0)
        pale = [line for line in axes.get_lines() if line.get_label() == "this line not tested"]
        known = sum(int(np.isfinite(line.get_ydata()).sum()) for line in pale)
        alone = (masks & ~masks.all(axis=0)).ravel()
        assert known == (alone & np.isfinite(sweep.columns["lift_force_N"])).sum()
        assert {*legend(axes)} & {"not tested: extrapolated", "this line not tested"}
    else:
        assert any(hatch for one in axes.collections for hatch in getattr(one, "hatches", []))


def test_lines_that_are_the_same_are_drawn_once_under_all_their_values():
    (axes,) = draw_sweep(swept(3, 4), quantity="mu_average").figure.axes
    # The first has a gap.
    assert [line.get_label() for line in axes.get_lines()] == ["wheel.wrap = 1 deg", "wheel.wrap = 2, 3 deg"]


def test_another_number_is_drawn_on_demand_and_an_unknown_one_is_not():
    assert draw_sweep(swept(5), quantity="mu_average").tables[0].header[-1] == "mu_average"
    with pytest.raises(InputError, match="lift_force_N"):
        draw_sweep(swept(5), quantity="lift")
    with pytest.raises(InputError, match="one or two axes"):
        draw_sweep(swept(2, 2, 2))
