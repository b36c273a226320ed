"""The Campbell chart shows the modes, circles every crossing, and writes its data."""

import csv
import math
from dataclasses import replace

import numpy as np
import pytest

from ropefric.plotting.figure import save_figure
from ropefric.plotting.machines import draw_saw_chart
from ropefric.systems.bandsaw.resonance import fixed_frequency, saw_chart, tooth_passing, wheel_rotation
from ropefric.systems.bandsaw.saw import Saw, Side, frequencies_Hz

SAW = Saw(
    free_span_m=1.6,
    linear_density_kg_m=0.5967,
    preload_N=3412.0,
    wheel_radius_m=0.35,
    wheel_speed_rad_s=970 * math.pi / 30,
    tension_difference_N=210.95,
)
SPEEDS = np.linspace(0.0, 60.0, 25)


def chart(saw=SAW):
    shakes = (wheel_rotation(0.35), tooth_passing(0.04), fixed_frequency("fan", 500.0))
    return saw_chart(saw, shakes, SPEEDS, n_modes=2)


def texts(axes):
    return [text.get_text() for text in axes.texts]


def test_lines_are_the_modes_and_circles_the_crossings():
    made = chart()
    (axes,) = draw_saw_chart(made).figure.axes
    lines = [line for line in axes.lines if line.get_label() in {"tight side", "slack side"}]
    assert len(lines) == 4
    for line, (side, mode) in zip(
        lines, [(s, m) for s in (Side.TIGHT, Side.SLACK) for m in (0, 1)], strict=True
    ):
        np.testing.assert_allclose(
            line.get_ydata(), frequencies_Hz(SAW, side, 2, speed_m_s=SPEEDS)[:, mode], rtol=1e-12
        )
    circles = {
        (float(line.get_xdata()[0]), float(line.get_ydata()[0]))
        for line in axes.lines
        if line.get_marker() == "o"
    }
    assert circles == {(crossing.speed_m_s, crossing.frequency_Hz) for crossing in made.crossings}
    work = [line for line in axes.lines if line.get_label() == "speed at work"]
    assert work[0].get_xdata()[0] == pytest.approx(35.552, abs=1e-3)
    assert axes.get_xlabel() == "Blade speed v [m/s]"
    assert axes.get_ylabel() == "Frequency f [Hz]"
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    excitations = ["wheel rotation", "tooth passing", "fan (above the chart)"]
    assert labels == ["tight side", "slack side", *excitations, "speed at work"]


def test_the_nearest_crossing_has_its_margin_written():
    made = chart()
    (axes,) = draw_saw_chart(made).figure.axes
    nearest = min(made.crossings, key=lambda crossing: abs(crossing.speed_margin))
    assert f"{100 * nearest.speed_margin:+.0f} %".replace("-", "\N{MINUS SIGN}") in texts(axes)
    assert {"mode 1", "mode 2", "1×", "2×", "3×"} <= set(texts(axes))
    written = sum("%" in text for text in texts(axes))
    assert 4 <= written <= len(made.crossings)


def test_no_two_written_numbers_overlap():
    figure = draw_saw_chart(chart()).figure
    figure.canvas.draw()
    boxes = [text.get_window_extent() for text in figure.axes[0].texts if "%" in text.get_text()]
    for i, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:i])


def test_a_saw_at_rest_has_no_speed_at_work():
    (axes,) = draw_saw_chart(chart(replace(SAW, wheel_speed_rad_s=0.0))).figure.axes
    assert not [line for line in axes.lines if line.get_label() == "speed at work"]
    assert not [text for text in texts(axes) if "%" in text]


def test_the_same_chart_gives_the_same_bytes_and_its_data(tmp_path):
    made = chart()
    first = save_figure(draw_saw_chart(made), tmp_path / "a", "saw")
    second = save_figure(draw_saw_chart(made), tmp_path / "b", "saw")
    assert [path.name for path in first] == ["saw.png", "saw.csv", "saw_crossings.csv"]
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]
    with first[1].open(encoding="utf-8") as stream:
        assert len(list(csv.DictReader(stream))) == 4 * SPEEDS.size
    with first[2].open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == len(made.crossings)
    assert float(rows[0]["speed_m_s"]) == pytest.approx(made.crossings[0].speed_m_s, rel=1e-7)
