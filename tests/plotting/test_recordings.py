"""Small multiples and single recordings: nothing is lost of a recording, a page stays small, laws keep their colour."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex

from ropefric.fitting.compare import compare_laws
from ropefric.friction.laws import ALL_LAWS, LAWS
from ropefric.plotting.campaign import MOST, _in_cell, draw_recording, draw_recordings, pages_of_recordings
from ropefric.plotting.design import draw_ladder
from ropefric.plotting.figure import figure_files
from ropefric.plotting.fits import draw_capstan, draw_fit_band, draw_mu_facets
from ropefric.plotting.style import law_look
from ropefric.traces.trace import ForceTrace
from ropefric.trials.result import Outline, draw_outline
from ropefric.trials.table import TrialTable


def outline(n=900, spike=371):
    force_N = np.linspace(10.0, 20.0, n)
    force_N[spike] = 90.0
    curve = {"low_N": force_N - 1.0, "high_N": force_N + 1.0, "smoothed_N": force_N}
    return Outline(time_s=np.linspace(0.0, 3.0, n), **curve)


@pytest.fixture
def trial(make_trial):
    return lambda name, force=90.0, **more: replace(make_trial(name, force, **more), outline=outline())


def test_a_peak_of_one_sample_is_not_lost_in_its_cell(trial):
    curve, _, numbers = _in_cell(trial("a"), outline())
    assert len(curve) <= 2 * 44
    assert curve[:, 1].min() == pytest.approx(0.86 - 0.5)  # the spike, on top of the cell
    assert (numbers[0][2], numbers[1][2]) == ("9.0 to 91.0 N", "3 s")


def test_a_cell_says_the_extremes_and_the_length_of_the_recording_itself(trial):
    time_s = np.arange(1600) / 200.0
    force_N = np.interp(time_s, [0.0, 1.0, 3.7, 3.74, 8.0], [-0.004, 0.0, 134.9, 80.0, 80.0])
    drawn = draw_outline(ForceTrace(time_s=time_s, force_N=force_N))
    _, _, numbers = _in_cell(trial("a"), drawn)
    assert (numbers[0][2], numbers[1][2]) == ("0 to 135 N", "8 s")


def test_the_pick_stands_on_the_curve(trial):
    found = trial("a")
    found = replace(found, breakaway=replace(found.breakaway, peak_time_s=float(outline().time_s[371])))
    curve, pick, _ = _in_cell(found, found.outline)
    assert np.abs(curve - np.array(pick)).sum(axis=1).min() < 1e-9


def test_a_campaign_of_thousands_stays_a_few_pages_and_a_small_one_is_whole(trial):
    one = trial("t")
    many = [replace(one, trial=f"t{i:04d}") for i in range(3000)]
    many[2900] = replace(many[2900], excluded="by hand")
    pages = list(pages_of_recordings(many))
    names = [one.trial for page in pages for one in page]
    assert len(names) == MOST
    assert "t2900" in names
    assert names == sorted(names)
    assert [one for page in pages_of_recordings(many[:150]) for one in page] == many[:150]
    texts = [text.get_text() for text in draw_recordings(pages[0]).figure.axes[0].texts]
    assert {one.trial for one in pages[0]} <= {*texts}


def test_one_recording_names_its_pick_and_is_the_same_in_every_format(trial):
    first, second = (draw_recording(trial("a", 88.25)) for _ in "ab")
    assert "88.25 N" in first.alt
    assert any("88.25 N" in text.get_text() for text in first.figure.legends[0].get_texts())
    files = figure_files(first, "f", formats=("svg", "pdf"))
    assert files.items() >= figure_files(second, "f", formats=("svg",)).items()
    assert files["f.svg"].startswith(b"<?xml")
    assert files["f.pdf"].startswith(b"%PDF")
    assert b"Date" not in files["f.svg"] + files["f.pdf"]


@pytest.fixture(scope="module")
def comparison():
    rng, wraps = np.random.default_rng(3), np.repeat([2.0, 4.0, 6.0, 8.0, 10.0, 12.0], 3)
    wheels = np.tile([0.02, 0.03, 0.05], 6)
    table = TrialTable(
        trial=tuple(map(str, range(wraps.size))), wheel_radius_m=wheels, rope_radius_m=0.005,
        wrap_angle_rad=wraps, end_tension_N=20.0,
        peak_N=20.0 * np.exp((0.1 + wheels) * wraps + 0.01 * rng.standard_normal(wraps.size)),
    )  # fmt: skip
    return compare_laws(table, ["constant", "size-power"])


def test_no_two_laws_look_alike_and_variants_look_like_their_law():
    looks = {str(sorted(law_look(law).items(), key=str)) for law in LAWS}
    assert len(looks) == len(LAWS)
    for law in ALL_LAWS:
        assert law_look(law) == law_look(law.removesuffix("-from-zero"))


def test_a_law_has_one_colour_in_every_figure(comparison):
    fits = [entry.fit for entry in comparison.ranking]
    for drawn in (draw_mu_facets(fits), draw_capstan(fits)):
        lines = {
            line.get_label(): to_hex(line.get_color()) for axes in drawn.figure.axes for line in axes.lines
        }
        for fit in fits:
            label = (
                fit.law if fit.law in lines else next(name for name in lines if name.startswith("straight"))
            )
            assert lines[label] == to_hex(law_look(fit.law)["color"])
    for fit in fits:
        wanted = to_hex(law_look(fit.law)["color"])
        band = draw_fit_band(fit).figure.axes[0]
        assert to_hex(next(one for one in band.lines if one.get_label() == "mean law").get_color()) == wanted
    ladder = draw_ladder(comparison).figure.axes[0]
    marks = [line for line in ladder.lines if line.get_marker() in {"D", "o"}]
    ranked = [entry.law for entry in comparison.ranking if entry.counted]
    assert [to_hex(mark.get_color()) for mark in marks] == [to_hex(law_look(law)["color"]) for law in ranked]


def numbers(axis):
    """The numbers an axis of a figure that is drawn shows within its frame."""
    low, high = sorted(axis.get_view_interval())
    ticks = [*axis.get_major_ticks(), *axis.get_minor_ticks()]
    return {tick.label1.get_text() for tick in ticks if low <= tick.get_loc() <= high} - {""}


def test_every_axis_has_numbers_however_short_it_is(comparison):
    for over in ("wheel_radius_m", "wrap_angle_rad"):
        figure = draw_fit_band(comparison.ranking[0].fit, over=over).figure
        figure.canvas.draw()
        panels = figure.axes
        for axis in (*(axes.yaxis for axes in panels), panels[-1].xaxis):
            assert len(numbers(axis)) >= 2
