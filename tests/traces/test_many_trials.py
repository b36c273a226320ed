"""Protocols that find several trials in one recording."""

import numpy as np
from drawn import drawn, loaded
from rigged import rigged_trace

from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.protocols import pick_plateaus, pick_teeth
from ropefric.traces.trace import ForceTrace

AUTO = PickSettings()


def test_every_tooth_is_found_once_and_right():
    for seed in range(3):
        tops_N = (120.0, 320.0, 600.0)[seed % 3] * np.random.default_rng(seed).normal(1.0, 0.017, 10)
        teeth = loaded(*((top_N, 0.8 * tops_N[0]) for top_N in tops_N), rate_N_s=0.5 * tops_N[0])
        time_s = np.arange(0.0, teeth[-1][0] + 0.3, 0.001)
        force_N = drawn(*teeth, noise_N=2e-3 * tops_N[0], seed=seed, time_s=time_s)
        found = pick_teeth(ForceTrace(time_s=time_s, force_N=force_N), AUTO)
        assert [tooth.status for tooth in found] == [Status.OK] * tops_N.size
        np.testing.assert_allclose(
            [tooth.peak_time_s for tooth in found], [at_s for at_s, _ in teeth[2::2]], atol=0.03
        )
        np.testing.assert_allclose([tooth.peak_N for tooth in found], tops_N, rtol=0.006)


def test_a_recording_without_a_slip_gives_the_reason_once():
    trace, _ = rigged_trace(3, faults=("no-breakaway",))
    (result,) = pick_teeth(trace, AUTO)
    assert result.status is Status.NO_BREAKAWAY


def test_plateaus_are_found_where_the_rope_has_settled():
    time_s, held_N = np.arange(0.0, 46.0, 0.02), (60.0, 58.8, 61.2)
    for seed in range(2):
        corners = [(0.0, 0.0)]
        for n, level_N in enumerate(held_N):
            begin_s = 2.0 + 15.0 * n  # pulled in two jerks, held, let go
            corners += [(begin_s, 0.5), (begin_s + 1, 0.6 * level_N), (begin_s + 2, 0.6 * level_N),
                (begin_s + 3, 1.01 * level_N), (begin_s + 4, level_N), (begin_s + 12, level_N),
                (begin_s + 12.5, 0.5)]  # fmt: skip
        force_N = drawn(*corners, seed=seed, time_s=time_s)
        found = pick_plateaus(ForceTrace(time_s=time_s, force_N=force_N), AUTO)
        np.testing.assert_allclose([plateau.peak_N for plateau in found], held_N, rtol=0.003)
        for n, plateau in enumerate(found):
            held = plateau.phases[0]
            assert 4.5 + 15.0 * n <= held.start_s < held.end_s <= 14.5 + 15.0 * n


def test_no_plateau_no_load_and_too_few_samples_are_said():
    time_s = np.arange(0, 40, 0.02)
    up_and_down = ForceTrace(time_s=time_s, force_N=np.abs(((time_s - 20) % 20) - 10))
    assert {p.status for p in pick_plateaus(up_and_down, AUTO)} == {Status.NO_BREAKAWAY}
    (idle,) = pick_plateaus(ForceTrace(time_s=time_s, force_N=0.01 * np.sin(1e4 * time_s)), AUTO)
    assert "never loaded" in idle.detail
    (short,) = pick_plateaus(ForceTrace(time_s=time_s[:9], force_N=time_s[:9]), AUTO)
    assert short.status is Status.TOO_SHORT
