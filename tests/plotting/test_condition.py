"""The figure of a condition: what it shows, that it says so with units, and that its bytes do not change."""

import csv
import math
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import matplotlib as mpl
import numpy as np
import pytest

from ropefric.errors import InputError, UnknownNameError
from ropefric.plotting.campaign import write_condition_figures
from ropefric.plotting.condition import condition_stems, draw_condition
from ropefric.plotting.labels import condition_stem, condition_title, typeset
from ropefric.plotting.save import save_figure
from ropefric.traces.breakaway import Breakaway, Status


def make_trial(name, peak_N, status=Status.OK, *, kept=True, excluded="", spike_N=0.0):
    """A recording that rises to its peak at 8 s and slides at nine tenths of it."""
    time_s = np.linspace(0.0, 20.0, 60)
    smoothed_N = np.where(time_s < 8.0, peak_N * time_s / 8.0, 0.9 * peak_N)
    high_N = smoothed_N + 2.0
    high_N[10] += spike_N
    usable = status == Status.OK
    found = Breakaway(
        status=status,
        peak_N=peak_N if usable else math.nan,
        peak_time_s=8.0 if usable else math.nan,
        kinetic_N=0.9 * peak_N if usable else math.nan,
    )
    outline = SimpleNamespace(
        time_s=time_s, low_N=smoothed_N - 2.0, high_N=high_N, smoothed_time_s=time_s, smoothed_N=smoothed_N
    )
    return SimpleNamespace(
        trial=name,
        file=f"{name}.csv",
        breakaway=found,
        peak_std_N=1.2 if usable else math.nan,
        kept=kept and usable,
        excluded=excluded,
        outline=None if status == Status.UNREADABLE else outline,
    )


def make_condition(trials, **changes):
    values_N = [t.breakaway.peak_N for t in trials if t.breakaway.status == Status.OK and not t.excluded]
    kept_N = [t.breakaway.peak_N for t in trials if t.kept]
    facts = {
        "wheel_radius_m": 0.04,
        "wrap_angle_rad": 3.0 * math.pi,
        "end_tension_N": 80.0,
        "n": len(values_N),
        "n_kept": len(kept_N),
        "rejected": tuple(
            t.trial for t in trials if t.breakaway.status == Status.OK and not t.kept and not t.excluded
        ),
        "mean_all_N": float(np.mean(values_N)) if values_N else math.nan,
        "std_all_N": float(np.std(values_N, ddof=1)) if len(values_N) > 1 else math.nan,
        "mean_kept_N": float(np.mean(kept_N)) if kept_N else math.nan,
        "std_kept_N": float(np.std(kept_N, ddof=1)) if len(kept_N) > 1 else math.nan,
        "trials": tuple(t.trial for t in trials),
    }
    return SimpleNamespace(**(facts | changes))


@pytest.fixture
def trials():
    good = [make_trial(f"t{i}", 320.0 + i) for i in range(7)]
    return [
        *good,
        make_trial("wild", 360.0, kept=False),
        make_trial("knot", 300.0, kept=False, excluded="knot in the rope"),
        make_trial("held", 250.0, Status.NO_BREAKAWAY),
        make_trial("torn", 0.0, Status.UNREADABLE),
    ]


@pytest.fixture
def drawn(trials):
    return draw_condition(make_condition(trials), trials)


def words(axes):
    return [text.get_text() for text in axes.texts]


def legend(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def lines_of(axes, label):
    return [line for line in axes.lines if line.get_label() == label]


def test_axes_say_what_they_show_with_units(drawn):
    left, right = drawn.figure.axes
    assert (left.get_xlabel(), left.get_ylabel()) == ("Time t [s]", "Force F [N]")
    assert right.get_ylabel() == r"Break-away force $F_{\mathrm{A}}$ [N]"
    title = drawn.figure.get_suptitle()
    assert all(part in title for part in ("40 mm", "540°", "80 N", "7 of 8"))


def test_every_recording_is_drawn_and_every_peak_marked(drawn, trials):
    left, _ = drawn.figure.axes
    assert len(left.collections) == 10  # all but the unreadable one
    peaks = [line.get_xydata()[0] for line in left.lines if line.get_marker() == "o"]
    expected = [(8.0, t.breakaway.peak_N) for t in trials if t.breakaway.status == Status.OK]
    np.testing.assert_allclose(peaks, expected)
    (band,) = [patch for patch in left.patches if "sliding" in patch.get_label()]
    np.testing.assert_allclose((band.get_y(), band.get_y() + band.get_height()), (270.0, 324.0))


def test_the_strip_shows_each_trial_in_order_with_the_two_sigma_band_of_all(drawn, trials):
    _, right = drawn.figure.axes
    points = {tuple(bars[0].get_xydata()[0]) for bars in right.containers}
    usable = {(i + 1.0, t.breakaway.peak_N) for i, t in enumerate(trials) if t.breakaway.status == Status.OK}
    assert points == usable
    summary = make_condition(trials)
    (band,) = [patch for patch in right.patches if "±2s" in patch.get_label()]
    assert band.get_y() == pytest.approx(summary.mean_all_N - 2 * summary.std_all_N)
    assert band.get_height() == pytest.approx(4 * summary.std_all_N)


def test_rejected_is_hollow_excluded_a_diamond_flagged_a_cross_with_its_status(drawn):
    _, right = drawn.figure.axes
    faces = {bars[0].get_xdata()[0]: bars[0] for bars in right.containers}
    assert faces[8].get_markerfacecolor() == "white"
    assert faces[9].get_marker() == "D"
    assert faces[1].get_markerfacecolor() != "white"
    assert [line.get_xdata()[0] for line in lines_of(right, "flagged")] == [10, 11]
    assert words(right) == ["no-breakaway", "unreadable"]
    assert {"kept", "rejected", "excluded", "flagged"} <= set(legend(right))


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


def test_long_forces_still_fit():
    trials = [make_trial(f"t{i}", 123456.0 + i, spike_N=1e6) for i in range(4)]
    test_nothing_is_clipped_and_no_text_overlaps_another(draw_condition(make_condition(trials), trials))


def test_a_spike_does_not_squeeze_the_traces_and_is_not_hidden_in_silence(trials):
    trials[0] = make_trial("t0", 320.0, spike_N=5000.0)
    left = draw_condition(make_condition(trials), trials).figure.axes[0]
    assert left.get_ylim()[1] < 500.0
    assert "single samples as far as 5138 N" in left.get_title(loc="left")


def test_few_values_carry_the_warning_that_nothing_can_be_rejected(trials):
    few = trials[:5]
    assert "cannot reject" in draw_condition(make_condition(few), few).figure.axes[1].get_title(loc="left")


@pytest.mark.parametrize("status", [Status.UNREADABLE, Status.NO_PEAK])
def test_a_condition_without_a_single_value_is_drawn_and_says_so(status, tmp_path):
    trials = [make_trial("a", 100.0, status)]
    made = draw_condition(make_condition(trials), trials)
    assert "no usable break-away force" in words(made.figure.axes[1])
    save_figure(made, tmp_path, "empty")


def test_one_trial_alone_is_drawn(tmp_path):
    trials = [make_trial("a", 100.0)]
    save_figure(draw_condition(make_condition(trials), trials), tmp_path, "one")


def test_trials_of_other_conditions_are_passed_over_and_missing_ones_refused(trials):
    summary = make_condition(trials[:3])
    assert len(draw_condition(summary, trials).tables[0].rows) == 3
    with pytest.raises(UnknownNameError, match="t2"):
        draw_condition(summary, trials[:2])


def test_a_measured_end_tension_is_left_out_of_the_condition():
    assert condition_stem(0.04, math.pi, math.nan) == "Rw40mm_phi180deg"
    assert "B" not in condition_title(0.04, math.pi, math.nan)


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_the_same_input_gives_the_same_bytes(trials, tmp_path, suffix):
    contents = []
    for folder in ("a", "b"):
        made = draw_condition(make_condition(trials), trials)
        paths = save_figure(made, tmp_path / folder, "figure", formats=(suffix,))
        contents.append([path.read_bytes() for path in paths])
    assert contents[0] == contents[1]


def test_the_users_own_style_changes_nothing(trials, tmp_path):
    plain = save_figure(draw_condition(make_condition(trials), trials), tmp_path / "a", "figure")
    with mpl.rc_context({"font.size": 30.0, "axes.facecolor": "black", "savefig.dpi": 20}):
        styled = save_figure(draw_condition(make_condition(trials), trials), tmp_path / "b", "figure")
    assert plain[0].read_bytes() == styled[0].read_bytes()


def test_the_data_lies_beside_the_picture(trials, tmp_path):
    made = draw_condition(make_condition(trials), trials)
    picture, main, traces = save_figure(made, tmp_path, "figure")
    assert (picture.name, main.name, traces.name) == ("figure.png", "figure.csv", "figure_traces.csv")
    with main.open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["trial"] for row in rows] == [t.trial for t in trials]
    assert float(rows[7]["peak_N"]) == 360.0
    assert (rows[7]["kept"], rows[7]["status"]) == ("false", "ok")
    assert (rows[9]["peak_N"], rows[9]["status"]) == ("", "no-breakaway")
    with traces.open(encoding="utf-8") as stream:
        assert len(list(csv.DictReader(stream))) == 10 * 60


def test_an_unknown_format_is_refused(drawn, tmp_path):
    with pytest.raises(InputError, match="did you mean 'png'"):
        save_figure(drawn, tmp_path, "figure", formats=("pgn",))


def test_conditions_that_read_alike_get_files_of_their_own(trials):
    near = make_condition(trials, wheel_radius_m=0.04 + 1e-12)
    assert condition_stems([make_condition(trials), near]) == [
        "Rw40mm_phi540deg_FB80N",
        "Rw40mm_phi540deg_FB80N_2",
    ]


def test_pyplot_is_never_loaded(drawn):
    import sys

    assert "matplotlib.pyplot" not in sys.modules


def test_a_campaign_in_parallel_is_the_same_as_one_after_the_other(trials, tmp_path):
    other = [make_trial(f"u{i}", 200.0 + i) for i in range(6)]
    extraction = SimpleNamespace(
        conditions=(make_condition(trials), make_condition(other, end_tension_N=40.0)),
        trials=(*trials, *other),
    )
    seen = []
    alone = write_condition_figures(extraction, tmp_path / "a", progress=lambda *call: seen.append(call))
    assert seen == [(1, 2, "Rw40mm_phi540deg_FB80N"), (2, 2, "Rw40mm_phi540deg_FB40N")]
    with ThreadPoolExecutor(1) as executor:
        together = write_condition_figures(extraction, tmp_path / "b", executor=executor)
    assert [path.name for path in alone] == [path.name for path in together]
    assert [path.read_bytes() for path in alone] == [path.read_bytes() for path in together]


def test_typesetting_leaves_plain_words_alone():
    assert typeset("Wheel radius [m]") == "Wheel radius [m]"
    assert typeset("sliding force F_k, 3 N") == r"sliding force $F_{\mathrm{k}}$, 3 N"
    assert typeset("F_A,raw") == r"$F_{\mathrm{A,raw}}$"
