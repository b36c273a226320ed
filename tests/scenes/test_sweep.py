"""Sweeps: the grid's answers are the scenes' own, one by one, whichever way they are reached."""

from itertools import product

import numpy as np
import pytest

from ropefric.errors import DataError, InputError, UnknownNameError
from ropefric.scenes.draws import draw_scene
from ropefric.scenes.scene import load_scene, number_keys, replaced
from ropefric.scenes.solve import solve_scene
from ropefric.scenes.sweep import columns_text, parse_axis, sweep_scene


def test_ranges_and_lists_in_any_unit(hoist_of):
    scene = hoist_of()
    wrap = parse_axis(scene, "wheel.wrap = 90deg : 450deg : 3")
    assert np.degrees(wrap.values).tolist() == pytest.approx([90.0, 270.0, 450.0])
    load = parse_axis(scene, "load.end_tension=10N:1000N:3:log")
    assert load.values.tolist() == pytest.approx([10, 100, 1000])
    assert parse_axis(scene, "rope.diameter=8 mm,1 cm").values.tolist() == pytest.approx([0.008, 0.01])
    assert parse_axis(hoist_of(friction={"mu": 0.2}), "friction.mu=0.1,0.3").values.tolist() == [0.1, 0.3]


def test_axes_that_are_none_are_refused(hoist_of):
    for text, error, words in [
        ("wheel.wrap", InputError, "START:STOP:COUNT"),
        ("wheel.wrap=90deg:180deg", InputError, "count from 2"),
        ("wheel.wrap=90deg:180deg:1", InputError, "count from 2"),
        ("wheel.wrap=90deg:180deg:5:cubic", InputError, "count from 2"),
        ("wheel.warp=90deg:180deg:5", UnknownNameError, "did you mean 'wheel.wrap'"),
        ("rope.bending_stiffness=1 N*m^2,2 N*m^2", UnknownNameError, "written into it first"),
        ("wheel.wrap=90:180:5", DataError, "no unit"),
        ("wheel.wrap=90mm,180mm", DataError, "angle"),
        ("wheel.radius=-1mm:1mm:5", DataError, "not more than 0"),
    ]:
        with pytest.raises(error, match=words):
            parse_axis(hoist_of(), text)


def test_what_can_be_swept_is_what_the_scene_gives(hoist_of):
    scene = hoist_of()
    keys = number_keys(scene.document, scene.table)
    assert "wheel.speed" in keys
    assert "friction.fit" not in keys
    assert "accuracy" not in keys


FIT = {"fit": "../../fits/prth-coupled.json"}
SWEPT = {
    "hoist": ("wheel.wrap=200deg:2000deg:4", "rope.diameter=9.8mm,20mm"),
    "climbing-hoist": ("load.end_tension=20N,80N,300N",),
    "traction": ("sheave.wrap=150deg,160deg,170deg",),
    "belt-press": ("belts.upper.width=1m,1.2m",),  # point by point
    "belt-drive": ("driving.wrap=30deg,180deg,700deg", "tension.force=5250N"),
}


@pytest.mark.parametrize("name", SWEPT)
def test_a_sweep_is_each_scene_alone_and_says_where_it_extrapolates(name, loaded, tmp_path, scene_of):
    scene = loaded(name)
    scene = scene_of(**{**scene.document.data, "friction": FIT, "effects": "all"})
    axes = tuple(parse_axis(scene, text) for text in SWEPT[name])
    swept = sweep_scene(scene, axes)
    alone = []
    for values in product(*(axis.values for axis in axes)):
        data = scene.document.data
        for axis, value in zip(axes, values, strict=True):
            data = replaced(data, axis.key, f"{float(value) / axis.factor!r} {axis.unit}")
        alone.append(solve_scene(scene_of(**data)))
    assert swept.shape == tuple(axis.values.size for axis in axes)
    for place, solution in enumerate(alone):
        for one in solution.quantities:
            wanted = pytest.approx(one.value[0], rel=1e-12, nan_ok=True)
            assert swept.columns[one.name][place] == wanted, (place, one.name)
    assert swept.columns["extrapolated"].tolist() == [float(bool(one.extrapolation)) for one in alone]
    assert bool(swept.extrapolated_at) == any(one.extrapolation for one in alone)
    told = [one for one in swept.warnings if "extrapolated" in one]
    assert len(told) == len(swept.extrapolated_at)
    for what, n in swept.extrapolated_at.items():
        assert sum(any(words.startswith(what) for words in one.extrapolation) for one in alone) == n
        words = f"at {n} of {len(alone)} points extrapolated: the {what} is outside"
        assert any(words in one for one in told)


def test_a_bare_coefficient_extrapolates_nowhere_and_draws_count_where_they_do(hoist_of):
    scene = hoist_of(friction={"mu": 0.2})
    swept = sweep_scene(scene, (parse_axis(scene, "wheel.wrap=200deg:2000deg:4"),))
    assert ("extrapolated" in swept.columns, swept.extrapolated_at) == (False, {})
    drawn = draw_scene(hoist_of(wheel={"wrap": "2000 deg"}), 100)
    assert drawn.extrapolated_at == {"wrap": 100}
    assert "extrapolated" not in drawn.numbers
    assert any("in 100 of 100 draws extrapolated: the wrap is" in one for one in drawn.warnings)
    assert drawn.to_dict()["extrapolated_in"] == {"wrap": 100}


def test_points_without_answer_are_counted_and_left_empty(hoist_of):
    scene = hoist_of(effects="all")
    axes = (parse_axis(scene, "wheel.speed=1m/s:61m/s:61"), parse_axis(scene, "wheel.wrap=1turn,2turn"))
    swept = sweep_scene(scene, axes)
    speed = np.repeat(axes[0].values, 2)
    # Below F_0 = 1 N the law has no answer, below 0 N nothing presses.
    floating = 80.0 - 0.062 * speed**2 < 1.0
    assert np.isnan(swept.columns["lift_force_N"]).tolist() == floating.tolist()
    assert swept.failed == floating.sum()
    assert "lifts off the wheel" in swept.first_failure
    with pytest.raises(InputError, match="no point of the sweep has an answer"):
        sweep_scene(scene, (parse_axis(scene, "wheel.speed=50m/s,60m/s"),))


def test_columns_are_written_row_by_row_with_empty_cells_for_what_is_not_known():
    columns = {"time_s": np.array([0.0, 0.5]), "tension_N": np.array([1.25, np.nan])}
    assert columns_text(columns) == "time_s,tension_N\n0,1.25\n0.5,\n"


def test_a_key_is_swept_once_and_progress_counts_all_points(hoist_of):
    scene, seen = hoist_of(), []
    axis = parse_axis(scene, "wheel.wrap=1turn,2turn")
    with pytest.raises(InputError, match="each key once"):
        sweep_scene(scene, (axis, axis))
    sweep_scene(scene, (parse_axis(scene, "wheel.wrap=90deg:900deg:70000"),),
                progress=lambda done, total, what: seen.append((done, total)))  # fmt: skip
    assert seen == [(50_000, 70_000), (70_000, 70_000)]


def test_start_ups_are_swept_one_by_one(scenes_folder):
    path = scenes_folder / "press-start-up.toml"
    short = {"start_up.duration": "2 s", "start_up.simulate": "2.2 s", "start_up.points": 111}
    scene = load_scene(path, short)
    swept = sweep_scene(scene, (parse_axis(scene, "press.preload=1100N,2500N"),))
    assert swept.failed == 0
    assert "transient" in swept.simulated
    largest = swept.columns["largest_utilisation"]
    assert largest[0] > 1.0 > largest[1] > 0.0
    assert swept.columns["start_up.slips"].tolist() == [1.0, 0.0]
    assert swept.columns["start_up.slip_loss_J"][0] > swept.columns["start_up.slip_loss_J"][1] == 0.0
    alone = solve_scene(load_scene(path, short | {"press.preload": "2500 N"})).answer.start_up.summary()
    assert swept.columns["start_up.peak_tension_N"][1] == max(alone["peak_tension_N"].values())
    assert swept.columns["start_up.peak_utilisation"][1] == max(alone["peak_utilisation"].values())
