"""Made-up results of one condition, as an extraction hands them over."""

import math

import numpy as np
import pytest

from ropefric.traces.breakaway import Breakaway, Status
from ropefric.trials.conditions import summarise_conditions
from ropefric.trials.result import Extraction, Outline, TrialResult


def _make_trial(
    name,
    force_N,
    status=Status.OK,
    *,
    excluded="",
    spike_N=0.0,
    file="",
    peak_time_s=8.0,
    slack=False,
    **facts,
):
    """A recording that rises to its peak at 8 s and slides at nine tenths of it."""
    time_s = np.linspace(0.0, 20.0, 60)
    mean_N = np.where(time_s < 8.0, force_N * time_s / 8.0, 0.9 * force_N)
    high_N = mean_N + 2.0
    high_N[10] += spike_N
    usable = status is Status.OK
    found = Breakaway(
        status=status,
        peak_N=force_N if usable else math.nan,
        peak_time_s=peak_time_s if usable else math.nan,
        kinetic_N=0.9 * force_N if usable and not slack else math.nan,
    )
    outline = Outline(
        time_s=time_s, low_N=mean_N - 2.0, high_N=high_N, smoothed_time_s=time_s, smoothed_N=mean_N
    )
    measured = (found.peak_N, 1.2 if usable else math.nan)
    known = (900.0 if slack else 80.0, 0.0)
    (peak_N, peak_std_N), (end_N, end_std_N) = (known, measured) if slack else (measured, known)
    condition = {"wheel_radius_m": 0.04, "rope_radius_m": 0.0049, "wrap_angle_rad": 3.0 * math.pi}
    return TrialResult(
        trial=name,
        file=file or f"{name}.csv",
        end_tension_N=end_N,
        end_tension_std_N=end_std_N,
        peak_N=peak_N,
        peak_std_N=peak_std_N,
        breakaway=found,
        kept=usable and not excluded,
        excluded=excluded,
        measures_slack=slack,
        outline=None if status is Status.UNREADABLE else outline,
        **(condition | facts),
    )


@pytest.fixture
def make_trial():
    return _make_trial


@pytest.fixture
def extraction_of():
    """Put trials through the real rejection."""

    def extraction_of(trials):
        marked, conditions, problems = summarise_conditions(trials, "two-sigma")
        return Extraction(name="made up", trials=marked, conditions=conditions, problems=problems)

    return extraction_of


@pytest.fixture
def trials():
    """Seven good ones, one far off, one excluded, one that never slipped, one unreadable."""
    return [
        *(_make_trial(f"t{i}", 320.0 + i) for i in range(7)),
        _make_trial("wild", 360.0),
        _make_trial("knot", 300.0, excluded="knot in the rope"),
        _make_trial("held", 250.0, Status.NO_BREAKAWAY),
        _make_trial("torn", 0.0, Status.UNREADABLE),
    ]
