"""The figures of one recording: nothing is lost in drawing it, and the phases, the peak and the ceiling are there."""

import numpy as np
import pytest

from ropefric.plotting.recording import draw_recording, draw_trial
from ropefric.traces.breakaway import Breakaway, Status
from ropefric.traces.calibration import Calibration
from ropefric.traces.chain import Adc, ForceCell
from ropefric.traces.protocols.breakaway import pick_breakaway
from ropefric.traces.settings import PickSettings
from ropefric.traces.trace import ForceTrace
from ropefric.trials.outline import draw_outline

RATE_HZ = 3000.0
CHAIN = Calibration(cell=ForceCell(name="small", full_scale_N=1000.0), adc=Adc(bits=10), tare_N=10.0)


def ramp(*, seconds=4.0, peak_N=300.0, seed=0):
    """Idle for 0.5 s, loaded in 1.5 s, then sliding at 0.8 of the peak, with 0.5 N of noise."""
    time_s = np.arange(int(seconds * RATE_HZ)) / RATE_HZ
    force_N = np.interp(time_s, [0.5, 2.0, 2.01], [0.0, peak_N, 0.8 * peak_N])
    noise_N = 0.5 * np.random.default_rng(seed).standard_normal(time_s.size)
    return ForceTrace(time_s=time_s, force_N=force_N + noise_N, name="ramp", calibration=CHAIN)


@pytest.fixture(scope="module")
def trace():
    return ramp()


@pytest.fixture(scope="module")
def found(trace):
    return pick_breakaway(trace, PickSettings())[0]


def labels(made):
    return [text.get_text() for legend in made.figure.legends for text in legend.get_texts()]


def test_a_long_recording_keeps_its_extremes(found):
    long = ramp(seconds=60.0)
    force_N = long.force_N.copy()
    force_N[7], force_N[100_000] = -77.0, 299.0
    made = draw_recording(ForceTrace(time_s=long.time_s, force_N=force_N), found)
    table = np.array(made.tables[0].rows)
    assert table.shape == (300, 4)
    assert table[:, 1].min() == pytest.approx(-77.0, rel=1e-5)
    assert table[:, 2].max() == pytest.approx(force_N.max(), rel=1e-5)
    edges = np.arange(301) * force_N.size // 300
    for i in (0, 10, 166):
        assert table[i, 2] == pytest.approx(force_N[edges[i] : edges[i + 1]].max(), abs=1e-3)
    # Drawn, not only tabulated: the envelope reaches the peak.
    envelope = made.figure.axes[0].collections[0].get_paths()[0].vertices[:, 1]
    assert envelope.max() == pytest.approx(force_N.max(), rel=1e-5)


def test_phases_are_shaded_where_they_were_found_and_named(trace, found, assert_repeats, assert_readable):
    made = assert_repeats(lambda: draw_recording(trace, found))
    assert_readable(made)
    whole = made.figure.axes[0]
    spans = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in whole.patches]
    np.testing.assert_allclose(spans, [(phase.start_s, phase.end_s) for phase in found.phases])
    named = {text.get_text() for text in whole.texts} | set(labels(made))
    assert {"idle", "loading", "break-away", "sliding"} <= named
    looks = [(patch.get_facecolor()[:3], patch.get_hatch()) for patch in whole.patches]
    assert len(set(looks)) == len(looks)
    assert made.tables[1].rows == tuple((p.name, p.start_s, p.end_s) for p in found.phases)


def test_the_peak_and_the_sliding_force_are_marked(trace, found):
    made = draw_recording(trace, found)
    for axes in made.figure.axes:
        (peak,) = [line for line in axes.lines if line.get_marker() == "o"]
        np.testing.assert_allclose(peak.get_xydata()[0], (found.peak_time_s, found.peak_N))
        (level,) = [line for line in axes.lines if "sliding force" in str(line.get_label())]
        assert (level.get_ydata()[0], level.get_linestyle()) == (found.kinetic_N, "--")
    bottom_N, top_N = made.figure.axes[0].get_ylim()
    assert bottom_N < 0.0 < found.peak_raw_N < top_N
    assert f"F_A = {found.peak_N:.4g} N at {found.peak_time_s:.4g} s" in made.alt
    assert "ceiling is at 990 N" in made.alt


@pytest.mark.parametrize(("peak_N", "drawn"), [(300.0, False), (700.0, True)])
def test_the_ceiling_is_a_line_where_it_is_near(peak_N, drawn):
    trace = ramp(peak_N=peak_N)
    made = draw_recording(trace, pick_breakaway(trace, PickSettings())[0])
    whole = made.figure.axes[0]
    (line,) = [line for line in whole.lines if "ceiling" in str(line.get_label())]
    assert list(line.get_ydata()) == ([pytest.approx(990.0)] * 2 if drawn else [])
    assert ("far above" in line.get_label()) is not drawn
    assert bool(whole.get_ylim()[1] > 990.0) is drawn
    assert line.get_linestyle() == ":"


def test_the_right_axis_counts_steps(trace, found):
    made = draw_recording(trace, found)
    made.figure.canvas.draw()
    (right,) = made.figure.axes[0].child_axes
    assert right.get_ylabel() == "ADC counts [count]"
    bottom_N, top_N = made.figure.axes[0].get_ylim()
    # One step is 1000/1023 N, and 10 N of tare were taken off.
    np.testing.assert_allclose(right.get_ylim(), [(F + 10.0) * 1023 / 1000 for F in (bottom_N, top_N)])


def test_samples_around_the_peak_are_shown_one_by_one(trace, found):
    made = draw_recording(trace, found)
    close = np.array(next(table for table in made.tables if table.name == "close").rows)
    near = np.isin(trace.time_s, close[:, 0])
    np.testing.assert_array_equal(close[:, 1], trace.force_N[near])
    top = np.abs(close[:, 0] - found.peak_time_s).argmin()
    assert close[top, 2] == pytest.approx(found.peak_N, abs=0.2)


@pytest.mark.parametrize("status", [Status.NO_BREAKAWAY, Status.SATURATED, Status.UNREADABLE])
def test_a_flagged_recording_says_why(trace, status):
    found = Breakaway(status=status, detail="the reason, with 3 N")
    outline = None if status is Status.UNREADABLE else draw_outline(trace)
    made = draw_recording(outline, found, name="r1")
    assert "the reason, with 3 N" in made.alt
    assert "nan" not in made.alt
    assert str(status) in made.figure.get_suptitle()
    assert not [line for line in made.figure.axes[0].lines if line.get_marker() == "o"]


def test_missing_samples_leave_no_hole_in_the_figure(found):
    gappy = ramp()
    force_N = gappy.force_N.copy()
    force_N[1000:2000] = np.nan
    made = draw_recording(ForceTrace(time_s=gappy.time_s, force_N=force_N), found)
    assert np.isfinite(np.array(made.tables[0].rows)).all()


def test_a_trial_is_drawn_from_its_outline(make_trial):
    trial = make_trial("t1", 320.0)
    made = draw_trial(trial)
    assert len(made.figure.axes) == 1
    assert made.alt.startswith("Recording t1: break-away force F_A = 320 N at 8 s")
    held = make_trial("h1", 30.0, slack=True)
    assert "plateau F_B = 30 N" in draw_trial(held).alt
