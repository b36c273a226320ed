"""The figure of a condition: what it shows, that it says so with units, and that its bytes do not change."""

import csv
import math
from concurrent.futures import ThreadPoolExecutor

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.collections import LineCollection

from ropefric.plotting.campaign import conditions_of, draw_condition, start_condition_figures
from ropefric.plotting.figure import save_figure
from ropefric.plotting.style import typeset
from ropefric.traces.breakaway import Status

USABLE_N = [*(320.0 + i for i in range(7)), 360.0]  # the rejected one too


def draw(trials, extraction_of):
    """Draw the one condition that the trials make."""
    extraction = extraction_of(trials)
    (summary,) = extraction.conditions
    return draw_condition(summary, extraction.trials)


@pytest.fixture(scope="module")
def drawn(trials, extraction_of):
    return draw(trials, extraction_of)


def words(axes):
    return [text.get_text() for text in axes.texts]


def legend(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def collection_of(axes, *labels):
    (found,) = [one for one in axes.collections if one.get_label().startswith(labels)]
    return found


def test_every_recording_is_drawn_and_every_peak_marked(drawn, trials):
    left, right = drawn.figure.axes
    assert (left.get_xlabel(), left.get_ylabel()) == ("Time t [s]", "Force F [N]")
    assert right.get_ylabel() == r"Break-away force $F_{\mathrm{A}}$ [N]"
    title = drawn.figure.get_suptitle()
    assert all(part in title for part in ("40 mm", "540°", "4.9 mm", "80 N", "7 of 11"))
    for label in ("recorded, min to max", "recorded, mean"):
        assert len(collection_of(left, label).get_paths()) == 10  # all but the unreadable one
    expected = [(8.0, t.breakaway.peak_N) for t in trials if t.breakaway.status == Status.OK]
    np.testing.assert_allclose(collection_of(left, "break-away").get_offsets(), expected)
    (band,) = [patch for patch in left.patches if "sliding" in patch.get_label()]
    np.testing.assert_allclose((band.get_y(), band.get_y() + band.get_height()), (270.0, 324.0))


def test_the_strip_shows_each_trial_with_its_fate_and_the_two_sigma_band_of_all(drawn, trials):
    _, right = drawn.figure.axes
    kept, rejected, excluded = (collection_of(right, label) for label in ("kept", "rejected", "excluded"))
    points = {tuple(at) for one in (kept, rejected, excluded) for at in one.get_offsets()}
    assert points == {
        (i + 1.0, t.breakaway.peak_N) for i, t in enumerate(trials) if t.breakaway.status == Status.OK
    }
    (band,) = [patch for patch in right.patches if "±2s" in patch.get_label()]
    mean_N, std_N = np.mean(USABLE_N), np.std(USABLE_N, ddof=1)
    assert (band.get_y(), band.get_height()) == (pytest.approx(mean_N - 2 * std_N), pytest.approx(4 * std_N))
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
    for axes in drawn.figure.axes:
        assert len(legend(axes)) == len(set(legend(axes)))


def test_the_words_for_it_carry_the_numbers(drawn, make_trial, extraction_of):
    assert drawn.alt.startswith("R_w = 40 mm, R_r = 4.9 mm, φ = 540°, F_B = 80 N: break-away force")
    assert f"{np.mean(USABLE_N):.4g} N on average over 8 usable trials" in drawn.alt
    assert f"sample standard deviation {np.std(USABLE_N, ddof=1):.3g} N" in drawn.alt
    assert "7 of 11 trials kept, wild set aside by the rule two-sigma" in drawn.alt
    assert "no usable force in 1 trial" in draw([make_trial("a", 1.0, Status.NO_PEAK)], extraction_of).alt


def test_nothing_is_clipped_and_no_text_overlaps_another(drawn, make_trial, extraction_of):
    """Room for labels is given by fixed margins, so it has to be held by a test; forces of six digits fit too."""
    wide = draw([make_trial(f"t{i}", 123456.0 + i, spike_N=1e6) for i in range(4)], extraction_of)
    for figure in (drawn.figure, wide.figure):
        figure.canvas.draw()
        renderer = figure.canvas.get_renderer()
        width, height = figure.canvas.get_width_height()
        named = [
            part for axes in figure.axes for part in (axes.get_legend(), axes.xaxis.label, axes.yaxis.label)
        ]
        named += [axes.title for axes in figure.axes if axes.get_title()] + figure.texts
        boxes = [one.get_window_extent(renderer) for one in named]
        left, right = figure.axes
        assert right.get_tightbbox(renderer).x0 > left.get_window_extent(renderer).x1
        for i, box in enumerate(boxes):
            assert min(box.x0, box.y0, width - box.x1, height - box.y1) >= 0
            assert not any(box.overlaps(other) for other in boxes[:i])


def test_a_spike_does_not_squeeze_the_traces_and_is_not_hidden_in_silence(make_trial, trials, extraction_of):
    left = draw([make_trial("t0", 320.0, spike_N=5000.0), *trials[1:]], extraction_of).figure.axes[0]
    assert left.get_ylim()[1] < 500.0
    assert "single samples as far as 5138 N" in left.get_title(loc="left")


def test_few_values_carry_the_warning_that_nothing_can_be_rejected(trials, extraction_of):
    for n, said in ((5, "n = 5, the ±2s rule cannot reject anything"), (6, "")):
        assert draw(trials[:n], extraction_of).figure.axes[1].get_title(loc="left") == said


def test_a_condition_of_one_trial_is_drawn_whatever_became_of_it(make_trial, extraction_of, tmp_path):
    for status in (Status.UNREADABLE, Status.OK):
        made = draw([make_trial("a", 100.0, status)], extraction_of)
        assert ("no usable force" in words(made.figure.axes[1])) == (status is not Status.OK)
        save_figure(made, tmp_path, "one")


def test_a_recording_with_several_trials_is_drawn_once_with_all_its_forces(make_trial, extraction_of):
    trials = [make_trial(f"r#{i}", 300.0 + i, file="r.csv", peak_time_s=4.0 * i) for i in range(1, 5)]
    made = draw(trials, extraction_of)
    left = made.figure.axes[0]
    assert len(collection_of(left, "recorded, mean").get_paths()) == 1
    assert collection_of(left, "break-away").get_offsets()[:, 0].tolist() == [4.0, 8.0, 12.0, 16.0]
    assert len(made.tables[1].rows) == 60


def test_where_the_slack_side_is_measured_the_end_tension_is_what_repeats(make_trial, extraction_of):
    made = draw([make_trial(f"h{i}", 30.0 + i, slack=True) for i in range(6)], extraction_of)
    left, right = made.figure.axes
    assert right.get_ylabel() == r"End tension $F_{\mathrm{B}}$ [N]"
    assert r"$F_{\mathrm{A}}$ = 900 N" in made.figure.get_suptitle()
    assert collection_of(right, "kept").get_offsets()[:, 1].tolist() == [30.0, 31.0, 32.0, 33.0, 34.0, 35.0]
    (bars,) = [one for one in right.collections if isinstance(one, LineCollection)]
    ends_N = [segment[:, 1].tolist() for segment in bars.get_segments()]
    np.testing.assert_allclose(ends_N, [(30.0 + i - 1.2, 30.0 + i + 1.2) for i in range(6)])
    assert any("plateau" in text for text in legend(left))
    assert "end tension" in made.alt


def test_the_same_input_gives_the_same_bytes_whatever_the_users_own_style(trials, extraction_of, tmp_path):
    plain = save_figure(draw(trials, extraction_of), tmp_path / "a", "figure")
    with mpl.rc_context({"font.size": 30.0, "axes.facecolor": "black", "savefig.dpi": 20}):
        styled = save_figure(draw(trials, extraction_of), tmp_path / "b", "figure")
    assert [path.read_bytes() for path in plain] == [path.read_bytes() for path in styled]
    picture, main, traces = plain
    assert (picture.name, main.name, traces.name) == ("figure.png", "figure.csv", "figure_traces.csv")
    rows = list(csv.DictReader(main.read_text(encoding="utf-8").splitlines()))
    assert [row["trial"] for row in rows] == [t.trial for t in trials]
    assert (float(rows[7]["peak_N"]), rows[7]["kept"], rows[7]["status"]) == (360.0, "false", "ok")
    assert (rows[9]["peak_N"], rows[9]["status"]) == ("", "no-breakaway")
    assert len(traces.read_text(encoding="utf-8").splitlines()) == 1 + 10 * 60


@pytest.mark.slow
def test_a_campaign_in_parallel_is_the_same_as_one_after_the_other(
    extraction_of, make_trial, trials, tmp_path
):
    turn = {"wrap_angle_rad": 2.0 * math.pi}
    other = [make_trial(f"u{i}", 200.0 + i, **turn) for i in range(6)]
    thin = [make_trial(f"v{i}", 210.0 + i, **turn, rope_radius_m=0.004) for i in range(6)]
    # Conditions that differ in the rope alone would share a file name.
    names = ["Rw40mm_phi360deg_FB80N", "Rw40mm_phi360deg_FB80N_2", "Rw40mm_phi540deg_FB80N"]
    assert sorted(conditions_of(extraction_of([*trials, *other, *thin]))) == names
    extraction = extraction_of([*other, *thin])
    seen = []
    alone = start_condition_figures(extraction, tmp_path / "a")(lambda *call: seen.append(call))
    assert sorted((done, of) for done, of, _ in seen) == [(1, 2), (2, 2)]
    assert sorted(item for _, _, item in seen) == names[:2]
    with ThreadPoolExecutor(1) as executor:
        together = start_condition_figures(extraction, tmp_path / "b", executor=executor)(None)
    assert [*alone] == [*together]
    for stem, (_, paths) in alone.items():
        assert [path.read_bytes() for path in paths] == [path.read_bytes() for path in together[stem][1]]


def test_a_condition_is_named_by_the_tension_that_is_known(extraction_of, make_trial):
    for slack, stem in ((False, "Rw40mm_phi540deg_FB80N"), (True, "Rw40mm_phi540deg_FA900N")):
        found = conditions_of(extraction_of([make_trial("a", 30.0, slack=slack)]))
        assert list(found) == [stem]
        assert "nan" not in draw_condition(*found[stem]).figure.get_suptitle()


def test_typesetting_leaves_plain_words_alone():
    assert typeset("Wheel radius [m]") == "Wheel radius [m]"
    assert typeset("sliding force F_k, 3 N") == r"sliding force $F_{\mathrm{k}}$, 3 N"
    assert typeset("F_A,raw") == r"$F_{\mathrm{A,raw}}$"
