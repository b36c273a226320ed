"""The figure of a condition: what it shows, that it says so with units, and that its bytes do not change."""

import csv
import math
from concurrent.futures import ThreadPoolExecutor

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.collections import LineCollection

from ropefric.plotting.campaign import (
    conditions_of,
    draw_condition,
    start_condition_figures,
)
from ropefric.plotting.figure import save_figure
from ropefric.plotting.style import typeset
from ropefric.traces.breakaway import Status


@pytest.fixture
def draw(extraction_of):
    """Draw the one condition that the trials make."""

    def draw(trials):
        extraction = extraction_of(trials)
        (summary,) = extraction.conditions
        return draw_condition(summary, extraction.trials)

    return draw


@pytest.fixture
def drawn(draw, trials):
    return draw(trials)


def words(axes):
    return [text.get_text() for text in axes.texts]


def legend(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def collection_of(axes, label):
    (found,) = [one for one in axes.collections if one.get_label() == label]
    return found


def picked(axes):
    """The forces picked from the recordings, as points."""
    (found,) = [one for one in axes.collections if one.get_label().startswith(("break-away", "plateau"))]
    return found.get_offsets()


def bars_of(axes):
    """Both ends of each error bar."""
    (found,) = [one for one in axes.collections if isinstance(one, LineCollection)]
    return [segment[:, 1].tolist() for segment in found.get_segments()]


def test_axes_say_what_they_show_with_units(drawn):
    left, right = drawn.figure.axes
    assert (left.get_xlabel(), left.get_ylabel()) == ("Time t [s]", "Force F [N]")
    assert right.get_ylabel() == r"Break-away force $F_{\mathrm{A}}$ [N]"
    title = drawn.figure.get_suptitle()
    assert all(part in title for part in ("40 mm", "540°", "4.9 mm", "80 N", "7 of 11"))


def test_every_recording_is_drawn_and_every_peak_marked(drawn, trials):
    left, _ = drawn.figure.axes
    for label in ("recorded, min to max", "recorded, mean"):
        assert len(collection_of(left, label).get_paths()) == 10  # all but the unreadable one
    peaks = picked(left)
    expected = [(8.0, t.breakaway.peak_N) for t in trials if t.breakaway.status == Status.OK]
    np.testing.assert_allclose(peaks, expected)
    (band,) = [patch for patch in left.patches if "sliding" in patch.get_label()]
    np.testing.assert_allclose((band.get_y(), band.get_y() + band.get_height()), (270.0, 324.0))


def test_the_strip_shows_each_trial_in_order_with_the_two_sigma_band_of_all(drawn, trials):
    _, right = drawn.figure.axes
    points = {tuple(at) for label in ("kept", "rejected") for at in collection_of(right, label).get_offsets()}
    points |= {tuple(at) for at in collection_of(right, "excluded").get_offsets()}
    usable = {(i + 1.0, t.breakaway.peak_N) for i, t in enumerate(trials) if t.breakaway.status == Status.OK}
    assert points == usable
    values_N = [*(320.0 + i for i in range(7)), 360.0]  # all that are usable, the rejected one too
    mean_N, std_N = np.mean(values_N), np.std(values_N, ddof=1)
    (band,) = [patch for patch in right.patches if "±2s" in patch.get_label()]
    assert band.get_y() == pytest.approx(mean_N - 2 * std_N)
    assert band.get_height() == pytest.approx(4 * std_N)


def test_rejected_is_hollow_excluded_a_diamond_flagged_a_cross_with_its_status(drawn):
    _, right = drawn.figure.axes
    kept, rejected, excluded = (collection_of(right, label) for label in ("kept", "rejected", "excluded"))
    assert kept.get_offsets()[:, 0].tolist() == [1, 2, 3, 4, 5, 6, 7]
    assert (kept.get_facecolors()[:, :3] < 1.0).any(axis=1).all()
    for hollow, order, corners in ((rejected, 8, 26), (excluded, 9, 5)):
        assert hollow.get_offsets()[:, 0].tolist() == [order]
        assert hollow.get_facecolors().tolist() == [[1.0] * 4]
        assert len(hollow.get_paths()[0].vertices) == corners  # a circle, and a diamond
    (flags,) = [line for line in right.lines if line.get_label() == "flagged"]
    assert (flags.get_xdata().tolist(), flags.get_marker()) == ([10, 11], "x")
    assert words(right) == ["the ±2s rule", "knot in the rope", "no-breakaway", "unreadable"]
    assert {"kept", "rejected", "excluded", "flagged"} <= set(legend(right))


def test_the_words_for_it_carry_the_numbers(drawn, draw, make_trial):
    values_N = [*(320.0 + i for i in range(7)), 360.0]
    alt = drawn.alt
    assert alt.startswith("R_w = 40 mm, R_r = 4.9 mm, φ = 540°, F_B = 80 N: break-away force")
    assert f"{np.mean(values_N):.4g} N on average over 8 usable trials" in alt
    assert f"sample standard deviation {np.std(values_N, ddof=1):.3g} N" in alt
    assert "7 of 11 trials kept, wild set aside by the rule two-sigma" in alt
    assert "no usable force in 1 trial" in draw([make_trial("a", 1.0, Status.NO_PEAK)]).alt
    assert "end tension" in draw([make_trial("h", 30.0, slack=True)]).alt


def test_the_strip_alone_is_the_same_strip(extraction_of, trials):
    extraction = extraction_of(trials)
    (summary,) = extraction.conditions
    both, alone = (draw_condition(summary, extraction.trials, traces=with_) for with_ in (True, False))
    (axes,) = alone.figure.axes
    assert words(axes) == words(both.figure.axes[1])
    assert (alone.tables, alone.alt) == (both.tables[:1], both.alt)


def test_a_legend_says_everything_once(drawn):
    for axes in drawn.figure.axes:
        assert len(legend(axes)) == len(set(legend(axes)))


def test_nothing_is_clipped_and_no_text_overlaps_another(drawn):
    """Room for labels is given by fixed margins, so it has to be held by a test."""
    figure = drawn.figure
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    width, height = figure.canvas.get_width_height()
    boxes = [axes.get_legend().get_window_extent(renderer) for axes in figure.axes]
    boxes += [axes.xaxis.label.get_window_extent(renderer) for axes in figure.axes]
    boxes += [axes.yaxis.label.get_window_extent(renderer) for axes in figure.axes]
    boxes += [axes.title.get_window_extent(renderer) for axes in figure.axes if axes.get_title()]
    boxes += [text.get_window_extent(renderer) for text in figure.texts]
    left, right = figure.axes
    assert right.get_tightbbox(renderer).x0 > left.get_window_extent(renderer).x1
    for i, box in enumerate(boxes):
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= width
        assert box.y1 <= height
        assert not any(box.overlaps(other) for other in boxes[:i])


def test_long_forces_still_fit(draw, make_trial):
    trials = [make_trial(f"t{i}", 123456.0 + i, spike_N=1e6) for i in range(4)]
    test_nothing_is_clipped_and_no_text_overlaps_another(draw(trials))


def test_a_spike_does_not_squeeze_the_traces_and_is_not_hidden_in_silence(draw, make_trial, trials):
    trials[0] = make_trial("t0", 320.0, spike_N=5000.0)
    left = draw(trials).figure.axes[0]
    assert left.get_ylim()[1] < 500.0
    assert "single samples as far as 5138 N" in left.get_title(loc="left")


def test_few_values_carry_the_warning_that_nothing_can_be_rejected(draw, trials):
    assert (
        draw(trials[:5]).figure.axes[1].get_title(loc="left") == "n = 5, the ±2s rule cannot reject anything"
    )
    assert draw(trials[:6]).figure.axes[1].get_title(loc="left") == ""


@pytest.mark.parametrize("status", [Status.UNREADABLE, Status.NO_PEAK])
def test_a_condition_without_a_single_value_is_drawn_and_says_so(draw, make_trial, status, tmp_path):
    made = draw([make_trial("a", 100.0, status)])
    assert "no usable force" in words(made.figure.axes[1])
    save_figure(made, tmp_path, "empty")


def test_one_trial_alone_is_drawn(draw, make_trial, tmp_path):
    save_figure(draw([make_trial("a", 100.0)]), tmp_path, "one")


def test_a_recording_with_several_trials_is_drawn_once_with_all_its_forces(draw, make_trial):
    trials = [make_trial(f"r#{i}", 300.0 + i, file="r.csv", peak_time_s=4.0 * i) for i in range(1, 5)]
    made = draw(trials)
    left = made.figure.axes[0]
    assert len(collection_of(left, "recorded, mean").get_paths()) == 1
    assert picked(left)[:, 0].tolist() == [4.0, 8.0, 12.0, 16.0]
    assert len(made.tables[1].rows) == 60


def test_where_the_slack_side_is_measured_the_end_tension_is_what_repeats(draw, make_trial):
    made = draw([make_trial(f"h{i}", 30.0 + i, slack=True) for i in range(6)])
    left, right = made.figure.axes
    assert right.get_ylabel() == r"End tension $F_{\mathrm{B}}$ [N]"
    assert r"$F_{\mathrm{A}}$ = 900 N" in made.figure.get_suptitle()
    assert collection_of(right, "kept").get_offsets()[:, 1].tolist() == [30.0, 31.0, 32.0, 33.0, 34.0, 35.0]
    np.testing.assert_allclose(bars_of(right), [(30.0 + i - 1.2, 30.0 + i + 1.2) for i in range(6)])
    assert any("plateau" in text for text in legend(left))


def test_the_same_input_gives_the_same_bytes(draw, trials, tmp_path):
    contents = []
    for folder in ("a", "b"):
        paths = save_figure(draw(trials), tmp_path / folder, "figure")
        contents.append([path.read_bytes() for path in paths])
    assert contents[0] == contents[1]


def test_the_users_own_style_changes_nothing(draw, trials, tmp_path):
    plain = save_figure(draw(trials), tmp_path / "a", "figure")
    with mpl.rc_context({"font.size": 30.0, "axes.facecolor": "black", "savefig.dpi": 20}):
        styled = save_figure(draw(trials), tmp_path / "b", "figure")
    assert plain[0].read_bytes() == styled[0].read_bytes()


def test_the_data_lies_beside_the_picture(drawn, trials, tmp_path):
    picture, main, traces = save_figure(drawn, tmp_path, "figure")
    assert (picture.name, main.name, traces.name) == ("figure.png", "figure.csv", "figure_traces.csv")
    with main.open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["trial"] for row in rows] == [t.trial for t in trials]
    assert float(rows[7]["peak_N"]) == 360.0
    assert (rows[7]["kept"], rows[7]["status"]) == ("false", "ok")
    assert (rows[9]["peak_N"], rows[9]["status"]) == ("", "no-breakaway")
    with traces.open(encoding="utf-8") as stream:
        assert len(list(csv.DictReader(stream))) == 10 * 60


def test_pyplot_is_never_loaded(drawn):
    import sys

    assert "matplotlib.pyplot" not in sys.modules


def test_a_campaign_in_parallel_is_the_same_as_one_after_the_other(
    extraction_of, make_trial, trials, tmp_path
):
    other = [make_trial(f"u{i}", 200.0 + i, wrap_angle_rad=2.0 * math.pi) for i in range(6)]
    thin = [
        make_trial(f"v{i}", 210.0 + i, wrap_angle_rad=2.0 * math.pi, rope_radius_m=0.004) for i in range(6)
    ]
    extraction = extraction_of([*trials, *other, *thin])
    seen = []
    alone = start_condition_figures(extraction, tmp_path / "a")(lambda *call: seen.append(call))
    # Conditions that differ in the rope alone would share a file name.
    names = ["Rw40mm_phi360deg_FB80N", "Rw40mm_phi360deg_FB80N_2", "Rw40mm_phi540deg_FB80N"]
    assert sorted(seen) == sorted((seen[i][0], 3, seen[i][2]) for i in range(3))
    assert sorted(item for _, _, item in seen) == names
    with ThreadPoolExecutor(1) as executor:
        together = start_condition_figures(extraction, tmp_path / "b", executor=executor)(None)
    assert [path.name for path in alone] == [path.name for path in together]
    assert [path.read_bytes() for path in alone] == [path.read_bytes() for path in together]


@pytest.mark.parametrize(
    ("slack", "stem"), [(False, "Rw40mm_phi540deg_FB80N"), (True, "Rw40mm_phi540deg_FA900N")]
)
def test_a_condition_is_named_by_the_tension_that_is_known(extraction_of, make_trial, slack, stem):
    extraction = extraction_of([make_trial("a", 30.0, slack=slack)])
    assert list(conditions_of(extraction)) == [stem]
    assert "nan" not in draw_condition(*conditions_of(extraction)[stem]).figure.get_suptitle()


def test_typesetting_leaves_plain_words_alone():
    assert typeset("Wheel radius [m]") == "Wheel radius [m]"
    assert typeset("sliding force F_k, 3 N") == r"sliding force $F_{\mathrm{k}}$, 3 N"
    assert typeset("F_A,raw") == r"$F_{\mathrm{A,raw}}$"
