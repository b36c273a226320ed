"""The design chart shows what the law says, marks what was not tested, and writes its data."""

import csv
from pathlib import Path

import numpy as np
import pytest

from ropefric.cli.app import main
from ropefric.fitting.design import design, design_chart
from ropefric.fitting.predict import predict
from ropefric.fitting.store import load_fit
from ropefric.friction.condition import Conditions
from ropefric.plotting.design import draw_design_chart
from ropefric.plotting.figure import save_figure

FIT = Path(__file__).parents[2] / "fits" / "prth-coupled.json"


def chart():
    radii_m, wraps_rad = np.array([0.02, 0.05]), np.linspace(1.0, 25.0, 13)
    return design_chart(load_fit(FIT), radii_m, wraps_rad, 60.0, rope_radius_m=0.0049)


def test_lines_are_the_predictions_and_pale_outside_the_tested_range():
    made = chart()
    (axes,) = draw_design_chart(made, required_N=900.0).figure.axes
    assert axes.get_yscale() == "log"
    assert axes.get_xlabel() == "Wrap angle φ [deg]"
    assert "Lift force" in axes.get_ylabel()
    assert "[N]" in axes.get_ylabel()
    whole, tested = axes.lines[0], axes.lines[1]
    at = Conditions(
        wheel_radius_m=0.02, rope_radius_m=0.0049, wrap_angle_rad=made.wrap_angle_rad, end_tension_N=60.0
    )
    wanted_N = predict(load_fit(FIT), at, check=False).lift_force_N
    np.testing.assert_allclose(whole.get_ydata(), wanted_N, rtol=1e-12)
    shown = np.isfinite(tested.get_ydata())
    np.testing.assert_array_equal(shown, ~made.extrapolated[0])
    assert 0 < shown.sum() < shown.size
    assert axes.lines[-1].get_ydata()[0] == 900.0
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert len(labels) == 3
    assert "required: 900 N" in labels
    assert whole.get_linestyle() == "-"
    assert axes.lines[2].get_linestyle() == "--"


def test_the_same_chart_gives_the_same_bytes_and_its_data(tmp_path):
    first = save_figure(draw_design_chart(chart()), tmp_path / "a", "chart")
    second = save_figure(draw_design_chart(chart()), tmp_path / "b", "chart")
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]
    with first[1].open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 26
    assert float(rows[0]["lift_force_N"]) > float(rows[0]["lower_bound_N"]) > 0


def test_design_draws_it_if_asked(tmp_path, capsys):
    words = ["--lift", "900 N", "--solve-for", "wrap", "--wheel-radius", "35 mm", "--end-tension", "60 N"]
    assert main(["design", "--fit", str(FIT), *words, "--chart", str(tmp_path / "chart"), "--json"]) == 0
    assert '"files": [' in capsys.readouterr().out
    assert {path.name for path in (tmp_path / "chart").glob("[!.]*")} == {
        "design_chart.png",
        "design_chart.csv",
        "design_chart_smallest_wrap.csv",
    }


def test_the_line_of_the_load_and_the_smallest_wraps_that_reach_it():
    made = chart()
    figure = draw_design_chart(made, required_N=600.0)
    (axes,) = figure.figure.axes
    assert float(axes.lines[-1].get_ydata()[0]) == 600.0
    rows = figure.tables[1].rows
    fit = load_fit(FIT)
    for (wheel_m, required_N, safety, wrap_rad), bound_N in zip(rows, made.lower_bound_N, strict=True):
        assert (required_N, safety) == (600.0, 1.0)
        if not (bound_N >= 600.0).any():
            assert np.isnan(wrap_rad)
            continue
        found = design(
            fit,
            lift_N=600.0,
            rope_radius_m=0.0049,
            wheel_radius_m=wheel_m,
            end_tension_N=60.0,
            probability=0.95,
        )
        # The chart is straight in ln F between its thirteen columns, 2 rad apart.
        assert wrap_rad == pytest.approx(float(found.value[0]), abs=0.02)
    assert np.isfinite(rows[1][3])
    assert f"50 mm needs {np.degrees(rows[1][3]):.4g} deg" in figure.alt
    assert "For 600 N, lifted" in figure.alt


def test_wheels_differ_in_marker_too_and_turns_stand_above():
    (axes,) = draw_design_chart(chart()).figure.axes
    assert axes.lines[1].get_marker() != axes.lines[5].get_marker()
    (above,) = axes.child_axes
    assert above.get_xlabel() == "Wrap [turns]"


@pytest.mark.parametrize("required_N", [None, 10.0])
def test_a_law_without_an_answer_leaves_a_gap(required_N):
    made = chart()
    made.lift_force_N[0, 3] = np.nan
    figure = draw_design_chart(made, required_N=required_N)
    assert np.isnan(figure.tables[0].rows[3][3])
