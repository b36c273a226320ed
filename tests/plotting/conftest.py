"""Made-up results of one condition, as an extraction hands them over."""

import math

import numpy as np
import pytest

from ropefric.fitting.fit import fit_law
from ropefric.fitting.result import FitResult
from ropefric.traces.breakaway import Breakaway, Status
from ropefric.trials.result import Extraction, Outline, TrialResult, summarise_conditions
from ropefric.trials.table import TrialTable


def _make_trial(name, force_N, status=Status.OK, *, excluded="", spike_N=0.0, file="", peak_time_s=8.0,
    slack=False, **facts):  # fmt: skip
    """A recording that rises to its peak at 8 s and slides at nine tenths of it."""
    time_s, usable = np.linspace(0.0, 20.0, 60), status is Status.OK
    mean_N = np.where(time_s < 8.0, force_N * time_s / 8.0, 0.9 * force_N)
    high_N = mean_N + 2.0
    high_N[10] += spike_N
    picked = {"peak_N": force_N, "peak_time_s": peak_time_s, "kinetic_N": math.nan if slack
        else 0.9 * force_N}  # fmt: skip
    found = Breakaway(status=status, **(picked if usable else {}))
    outline = Outline(time_s=time_s, low_N=mean_N - 2.0, high_N=high_N, smoothed_N=mean_N)
    measured = (found.peak_N, 1.2 if usable else math.nan)
    known = (900.0 if slack else 80.0, 0.0)
    (peak_N, peak_std_N), (end_N, end_std_N) = (known, measured) if slack else (measured, known)
    about = {"wheel_radius_m": 0.04, "rope_radius_m": 0.0049, "wrap_angle_rad": 3.0 * math.pi, **facts}
    forces = {"peak_N": peak_N, "peak_std_N": peak_std_N, "end_tension_N": end_N,
        "end_tension_std_N": end_std_N}  # fmt: skip
    fate = {"kept": usable and not excluded, "excluded": excluded, "measures_slack": slack}
    shown = None if status is Status.UNREADABLE else outline
    return TrialResult(
        trial=name, file=file or f"{name}.csv", breakaway=found, outline=shown, **forces, **fate, **about
    )


@pytest.fixture(scope="session")
def make_trial():
    return _make_trial


@pytest.fixture(scope="session")
def extraction_of():
    """Put trials through the real rejection."""

    def extraction_of(trials):
        marked, conditions, problems = summarise_conditions(trials, "two-sigma")
        return Extraction(name="made up", trials=marked, conditions=conditions, problems=problems)

    return extraction_of


def _texts_of(figure):
    """Every text that can be seen, with its box."""
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    found = [*figure.texts]
    for legend in figure.legends:
        found += legend.get_texts()
    for axes in figure.axes:
        found += [axes.title, axes._left_title, axes.xaxis.label, axes.yaxis.label]
        found += list(axes.texts)
        for child in axes.child_axes:
            found += [child.xaxis.label, child.yaxis.label]
    return [(text.get_text(), text.get_window_extent(renderer)) for text in found if text.get_text()]


@pytest.fixture(scope="session")
def assert_readable():
    """No text lies outside the page or over another."""

    def assert_readable(made):
        width, height = made.figure.canvas.get_width_height()
        texts = _texts_of(made.figure)
        for i, (words, box) in enumerate(texts):
            assert box.x0 >= -1, words
            assert box.y0 >= -1, words
            assert box.x1 <= width + 1, words
            assert box.y1 <= height + 1, words
            for others, other in texts[:i]:
                assert not box.shrunk(0.9, 0.9).overlaps(other.shrunk(0.9, 0.9)), (words, others)

    return assert_readable


@pytest.fixture(scope="session")
def told():
    """Return what is drawn, which says something."""

    def told(made):
        assert made.alt.endswith(".")
        assert "nan" not in made.alt
        return made

    return told


def _pulls(mu=0.2, *, curve=0.0, seed=0):
    """Three wraps, three tensions and three wheels in a star, four pulls each, with 1 % scatter."""
    rng = np.random.default_rng(seed)
    star = [(0.04, 6.0, 20.0), (0.04, 3.0, 20.0), (0.04, 9.0, 20.0), (0.04, 6.0, 5.0), (0.04, 6.0, 80.0)]
    star += [(0.02, 6.0, 20.0), (0.06, 6.0, 20.0)]
    wheel, wrap, end = np.repeat(np.array(star).T, 4, axis=1)
    force = end * np.exp(mu * wrap * (1.0 - curve * wrap)) * np.exp(0.01 * rng.standard_normal(wheel.size))
    names = tuple(f"p{i}" for i in range(wheel.size))
    at = {"wheel_radius_m": wheel, "rope_radius_m": 0.005, "wrap_angle_rad": wrap, "end_tension_N": end}
    return TrialTable(trial=names, **at, peak_N=force, peak_std_N=0.002 * force)


@pytest.fixture(scope="session")
def pulls():
    return _pulls(curve=0.02)


@pytest.fixture(scope="session")
def fitted(pulls):
    """The same pulls under two laws."""
    return {law: fit_law(pulls, law) for law in ("constant", "wrap-power")}


@pytest.fixture(scope="session")
def stored():
    """A fit as it comes back from its file: without the trials themselves."""
    return lambda fit: FitResult.from_dict(fit.to_dict())


@pytest.fixture(scope="session")
def trials():
    """Seven good ones, one far off, one excluded, one that never slipped, one unreadable."""
    return (*(_make_trial(f"t{i}", 320.0 + i) for i in range(7)), _make_trial("wild", 360.0),
        _make_trial("knot", 300.0, excluded="knot in the rope"),
        _make_trial("held", 250.0, Status.NO_BREAKAWAY), _make_trial("torn", 0.0, Status.UNREADABLE)
    )  # fmt: skip
