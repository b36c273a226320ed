"""A static peak that falls slowly, as on a soft machine, against loads that are let down without a slip."""

from itertools import product

import numpy as np
import pytest
from thinned import thinned

from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.trace import ForceTrace

PEAK_N = 15.0
IDLE_S = 0.3
AUTO = PickSettings()
RATES_HZ = (500.0, 1000.0, 3000.0)
EACH_RATE = pytest.mark.parametrize("rate_Hz", [*RATES_HZ[:2], pytest.param(3000.0, marks=pytest.mark.slow)])
SEEDS = range(3)


def recorded(shape, *, seconds, rate_Hz, noise_N, seed):
    """The recording of a force that is a function of time, with white noise."""
    time_s = np.arange(0.0, seconds, 1.0 / rate_Hz)
    noise = np.random.default_rng(seed).normal(0.0, noise_N, time_s.size)
    return ForceTrace(time_s=time_s, force_N=shape(time_s) + noise)


def pull(*, fall_s, share, load_s=2.0, hold_s=0.0, stay_s=3.0, curve="line", **sampling):
    """A ramp to the peak, a hold, a fall to a share of it along a line, a cosine or an exponential, a quiet level."""
    off_s = IDLE_S + load_s + hold_s

    def shape(time_s):
        since = np.maximum(time_s - off_s, 0.0) / fall_s
        done = {
            "line": lambda: np.minimum(since, 1.0),
            "cosine": lambda: 0.5 - 0.5 * np.cos(np.pi * np.minimum(since, 1.0)),
            "exponential": lambda: -np.expm1(-3.0 * since),
        }[curve]()
        risen = np.interp(time_s, [IDLE_S, IDLE_S + load_s], [0.0, PEAK_N])
        return risen * (1.0 - (1.0 - share) * done)

    return recorded(shape, seconds=off_s + stay_s, **sampling)


def picked(trace, settings=AUTO):
    (result,) = pick_breakaway(trace, settings)
    return result


def refused(traces):
    """Whether no recording gives a force: the rope never slipped, or it is not clear whether it did.

    At times noise passes for the roughness of sliding: `no-peak`, which gives no force either.
    """
    found = [picked(trace) for trace in traces]
    assert all(np.isnan(result.peak_N) for result in found), found
    assert {result.status for result in found} <= {Status.NO_BREAKAWAY, Status.NO_PEAK, Status.DOUBTFUL}
    return all(result.candidates for result in found if result.status is Status.DOUBTFUL)


@EACH_RATE
@pytest.mark.parametrize("fall_s", thinned([0.005, 0.01, 0.02, 0.035, 0.05, 0.1, 0.2], 2))
def test_a_clean_peak_is_found_however_slowly_it_falls(fall_s, rate_Hz):
    # The steps are at least eight standard deviations of the mean of 4 ms: 0.2 N of noise at 500 Hz for the larger.
    cases = [(0.6, 0.2), (0.75, 0.2), (0.6, 0.05), (0.813, 0.05), (0.9, 0.05)]
    if fall_s <= 0.1:
        cases += [(0.813, 0.2), (0.95, 0.02)]
    for (share, noise_N), seed in product(cases, SEEDS):
        found = picked(pull(fall_s=fall_s, share=share, rate_Hz=rate_Hz, noise_N=noise_N, seed=seed))
        assert found.status is Status.OK, (share, noise_N, seed, found.detail)
        assert found.peak_N == pytest.approx(PEAK_N, abs=0.075 + 1.0 * noise_N)
        assert found.peak_time_s == pytest.approx(2.3, abs=0.06)
        assert found.kinetic_N == pytest.approx(share * PEAK_N, rel=0.005)


@pytest.mark.parametrize("curve", ["line", "cosine", "exponential"])
@pytest.mark.parametrize("load_s", [1.0, 3.0, 8.0])
def test_neither_the_curve_of_the_fall_nor_the_speed_of_the_motor_matters(load_s, curve):
    for rate_Hz, seed in product(RATES_HZ, SEEDS):
        trace = pull(
            fall_s=0.08, share=0.8, load_s=load_s, curve=curve, rate_Hz=rate_Hz, noise_N=0.05, seed=seed
        )
        found = picked(trace)
        assert found.status is Status.OK, (rate_Hz, seed, found.detail)
        assert found.peak_N == pytest.approx(PEAK_N, rel=0.01)


def test_the_doubt_that_is_left_is_said():
    found = picked(pull(fall_s=0.1, share=0.8, rate_Hz=1000.0, noise_N=0.05, seed=1))
    (note,) = found.notes
    assert "slower than a slip, and stays at 80% of the peak" in note
    assert "unless the motor was let back at that moment" in note
    sudden = picked(pull(fall_s=0.002, share=0.8, rate_Hz=1000.0, noise_N=0.05, seed=1))
    assert sudden.status is Status.OK
    assert sudden.notes == ()


def test_the_smallest_step_counts_for_slow_falls_too():
    trace = pull(fall_s=0.1, share=0.8, rate_Hz=1000.0, noise_N=0.05, seed=1)
    assert picked(trace, PickSettings(min_step_N=2.5)).status is Status.OK
    assert picked(trace, PickSettings(min_step_N=4.0)).status is not Status.OK


@pytest.mark.parametrize("bends_s", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("roughness_N", [0.3, 1.0, 2.0])
def test_a_slow_break_must_stand_out_of_the_sliding_or_end_a_straight_climb(roughness_N, bends_s):
    """What bends before it falls by as much as the sliding goes up and down may be a rope without a peak."""
    status = Status.NO_PEAK if roughness_N == 2.0 and bends_s == 1.0 else Status.OK

    def shape(time_s):
        slides = np.clip(time_s - 2.38, 0.0, 0.1) / 0.1
        rough_N = roughness_N * slides * (np.sin(31.0 * time_s) + np.sin(53.0 * time_s))
        bent = [0.3, 2.3 - bends_s, 2.3 - 0.5 * bends_s, 2.3, 2.38], [0.0, 0.85 * PEAK_N, 0.96 * PEAK_N]
        straight = [0.3, 2.3, 2.38], [0.0]
        at_s, climb_N = bent if bends_s else straight
        return np.interp(time_s, at_s, [*climb_N, PEAK_N, 11.5]) + rough_N

    for seed in SEEDS:
        found = picked(recorded(shape, seconds=6.0, rate_Hz=1000.0, noise_N=0.1, seed=seed))
        assert found.status is status, found.detail
        if status is Status.OK:
            assert found.peak_N == pytest.approx(PEAK_N, rel=0.015)


@pytest.mark.parametrize("rate_Hz", [500.0, pytest.param(3000.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("fall_s", "share"),
    thinned([(0.05, 0.0), (0.05, 0.3), *product((0.1, 0.3, 1.0, 3.0), (0.0, 0.3, 0.5))]),
)
def test_a_load_let_down_to_half_or_less_never_slipped(fall_s, share, rate_Hz):
    """At up to ten times the rate of the loading; at twenty times, a force that stays at half of it has slipped."""
    assert refused(
        pull(fall_s=fall_s, share=share, hold_s=hold_s, rate_Hz=rate_Hz, noise_N=noise_N, seed=seed)
        for noise_N, hold_s, seed in product((0.05, 0.2), (0.0, 0.3), SEEDS)
    )


@pytest.mark.parametrize("curve", ["line", "exponential"])
@pytest.mark.parametrize("share", thinned([0.6, 0.75, 0.9]))
@pytest.mark.parametrize("hold_s", [0.3, 1.0])
def test_a_load_held_for_a_moment_and_let_down_a_little_never_slipped(hold_s, share, curve):
    # A release with a time constant of 20 ms or less is as sudden as a slip, and a hold of a tenth of a second before
    # a fall that is as short looks like a slip that begins slowly. The fall must stand out of the noise.
    noise_N = 0.1 if share < 0.9 else 0.03
    assert refused(
        pull(
            fall_s=fall_s,
            share=share,
            hold_s=hold_s,
            curve=curve,
            rate_Hz=rate_Hz,
            noise_N=noise_N,
            seed=seed,
        )
        for rate_Hz, fall_s, seed in product(RATES_HZ, (0.09, 0.15), SEEDS)
    )


@pytest.mark.parametrize("share", thinned([0.6, 0.75, 0.9], 2))
@pytest.mark.parametrize(("load_s", "fall_s"), [(1.0, 0.25), (2.0, 0.5), (2.0, 1.5), (8.0, 0.6)])
def test_a_load_let_down_slowly_from_the_ramp_never_slipped(load_s, fall_s, share):
    """Slowly against the loading, or against any machine."""
    assert refused(
        pull(fall_s=fall_s, load_s=load_s, share=share, rate_Hz=rate_Hz, noise_N=0.1, seed=seed)
        for rate_Hz, seed in product(RATES_HZ, SEEDS)
    )


def test_the_creep_of_a_held_rope_is_no_break_away():
    assert refused(pull(fall_s=0.1, share=0.97, rate_Hz=1000.0, noise_N=0.05, seed=seed) for seed in SEEDS)


def test_a_step_of_the_converter_is_no_break_away():
    smooth = [pull(fall_s=0.1, share=0.9, rate_Hz=1000.0, noise_N=0.2, seed=seed) for seed in SEEDS]
    assert refused(ForceTrace(time_s=trace.time_s, force_N=np.round(trace.force_N)) for trace in smooth)


@pytest.mark.parametrize(("fall_s", "stay_s", "sinks_N"), [(0.45, 0.4, 0.0), (0.08, 3.0, 4.0)])
def test_a_level_that_ends_soon_or_sinks_is_no_sliding(fall_s, stay_s, sinks_N):
    """The motor no longer pulls: it may have let the load down as fast as it was loaded, or a held rope relaxes."""
    level_s, end_s = 2.3 + fall_s, 2.3 + fall_s + stay_s

    def shape(time_s):
        return np.interp(time_s, [0.3, 2.3, level_s, end_s], [0.0, PEAK_N, 12.0, 12.0 - sinks_N])

    assert refused(recorded(shape, seconds=end_s, rate_Hz=1000.0, noise_N=0.1, seed=seed) for seed in SEEDS)
