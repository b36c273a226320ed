"""The force on the rope: what is said to happen happens, when and as high as it is said to."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.signal
from drawn import record
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from ropefric.errors import InputError, UnknownNameError
from ropefric.rig.bench import Bench, Snap
from ropefric.traces.breakaway import Status


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), lift=st.floats(10.0, 4000.0), ratio=st.floats(1.3, 12.0))
def test_the_largest_force_is_the_static_peak_and_stands_where_the_truth_says(seed, lift, ratio):
    recording = record(seed, lift_N=lift, end_N=lift / ratio)
    time_s, force_N, truth = recording.true_time_s, recording.true_force_N, recording.truth
    top = int(np.argmax(force_N))
    # Break-away falls between two samples: at most one step of loading is missing, never a newton too much.
    step_N = 2.0 * lift / 0.8 / 3000.0
    assert lift - step_N <= force_N[top] <= lift * (1 + 1e-6)
    assert abs(time_s[top] - truth.breakaway_time_s) <= 1.001 / 3000.0
    assert force_N.min() >= 0.0
    assert truth.lift_force_N == lift
    assert truth.status is Status.OK
    assert 0.70 * lift < truth.kinetic_N < 0.97 * lift
    assert max(truth.tooth_tops_N[1:]) < lift


def test_the_snap_solves_the_spring_mass_equation():
    snap = Snap(natural_Hz=140.0, damping_ratio=0.3)
    omega = 2 * np.pi * 140.0
    time_s = np.linspace(0.0, 0.02, 50)
    exact = {"t_eval": time_s, "rtol": 1e-10, "atol": 1e-12}
    answer = solve_ivp(
        lambda _, y: [y[1], -(omega**2) * y[0] - 2 * 0.3 * omega * y[1]], (0.0, 0.02), [1.0, 0.0], **exact
    )
    assert snap.remaining(time_s) == pytest.approx(answer.y[0], abs=1e-8)


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0])
def test_the_drop_rings_with_rope_and_cell_in_series(factor):
    quiet = {"damping_ratio": (0.02, 0.02), "tooth_Hz": (5.0, 5.0), "noise_counts": (0, 0)}
    bench = Bench(stiffness_factor=(factor, factor), **quiet)
    recording = record(0, bench=bench)
    after_s = recording.true_time_s - recording.truth.breakaway_time_s
    ringing_N = recording.true_force_N[(after_s > 0.0) & (after_s < 0.08)]
    ringing_N = scipy.signal.detrend(ringing_N)
    spectrum = np.abs(np.fft.rfft(ringing_N * np.hanning(ringing_N.size), 65536))
    found_Hz = np.fft.rfftfreq(65536, 1 / 3000.0)[np.argmax(spectrum)]
    stiffness_N_m = 1 / (1 / (factor * 1.0e5) + 1 / 1.0e7)
    expected_Hz = np.sqrt(stiffness_N_m / 0.12) / (2 * np.pi)
    assert found_Hz == pytest.approx(expected_Hz, rel=0.03)
    assert 60.0 < expected_Hz < 300.0


def test_the_kinetic_level_is_the_mean_of_the_sliding_samples():
    for seed in range(10):
        recording = record(seed)
        (slide,) = [p for p in recording.truth.phases if p.name == "sliding"]
        sliding = (recording.true_time_s > slide.start_s + 0.03) & (recording.true_time_s < slide.end_s)
        assert recording.true_force_N[sliding].mean() == pytest.approx(recording.truth.kinetic_N, rel=1e-3)


def test_bad_forces_and_names_are_refused():
    with pytest.raises(InputError, match="end tension 80 N must be positive and below the lift force 60 N"):
        record(0, lift_N=60.0)
    for lift, end in ((np.nan, 1.0), (np.inf, 1.0), (10.0, 0.0), (10.0, np.nan)):
        with pytest.raises(InputError):
            record(0, lift_N=lift, end_N=end)
    for keys, words in (({"faults": ["spikes"]}, "did you mean 'spike'"),
        ({"cell": "K2"}, "unknown force cell 'K2'")):  # fmt: skip
        with pytest.raises(UnknownNameError, match=words):
            record(0, *keys.pop("faults", ()), **keys)
    with pytest.raises(InputError, match="idle_s"):
        Bench(idle_s=(0.5, 0.1))
    with pytest.raises(InputError, match="moving_mass_kg"):
        replace(Bench(), moving_mass_kg=0.0)
