"""Traces of every nasty kind: a result that keeps its promises, or a refusal."""

import math

import numpy as np
from fuzz_kit import answered, fuzzed
from hypothesis import strategies as st

from ropefric.traces.breakaway import ENDINGS, PickSettings, Status
from ropefric.traces.clock import mend_clock
from ropefric.traces.protocols import PROTOCOLS
from ropefric.traces.smoothing import smooth
from ropefric.traces.trace import ForceTrace

SIZES = (1, 2, 3, 5, 49, 50, 51, 64, 120, 400)
STEPS = (1e-320, 1e-101, 1e-12, 1e-4, 1e-3, 0.02, 1.0, 1e3, 1e99, 1e300)
SCALES = (1.0, 1.0, 1.0, 5e-324, 1e-310, 1e-160, 1e-9, 1e9, 1e97, 1e160, 1e306)
OFFSETS = (0.0, 0.0, 1e-300, -50.0, 1e9, -1e16, 1e99, 1e300)
SHAPES = ("pull", "noise", "flat", "chaos", "ramp", "teeth", "counts", "drop", "steps")
WINDOWS = (None, None, 0.0, 1e-300, 1e-3, 0.02, 1.0, 1e9, 1e300)
NAN, INF = math.nan, math.inf


@np.errstate(all="ignore")
def nasty(*, shape, n, step, scale, offset, seed, damage):
    """Return time stamps and forces."""
    rng = np.random.default_rng(seed)
    i = np.arange(n)
    top = max(1, int(rng.uniform(0.1, 0.95) * n))
    climb = np.minimum(i / top, 1.0) * 100
    force = {"pull": lambda: np.where(i < top, climb, 80 + rng.normal(0, 2, n)),
        "noise": lambda: rng.normal(0, 1, n), "flat": lambda: np.full(n, 7.0),
        "chaos": lambda: rng.choice([0.0, 5e-324, 1e-160, 1.0, -1.0, 1e9, -1e99, 1e100], n),
        "ramp": lambda: climb, "teeth": lambda: 50 + 20 * np.mod(i, max(top // 4, 2)) / max(top // 4,
        2) + rng.normal(0, 0.1, n), "counts": lambda: np.round(np.where(i < top, climb,
        80 + rng.normal(0, 2, n))), "drop": lambda: np.where(i < top, climb, 0.0),
        "steps": lambda: np.floor(i / max(n // 5, 1)) * rng.choice([-10, 10])}[shape]()  # fmt: skip
    force = force * scale + offset
    time = i * step + rng.choice([0.0, 0.0, 1e9, -1e9]) if step < 1e10 else i * step
    for kind in damage:
        at = rng.integers(0, n)
        match kind:
            case "missing":
                force[rng.random(n) < rng.choice([0.02, 0.5, 0.99])] = NAN
            case "spike":
                force[at] = rng.choice([1e99, -1e99, 1e308, 0.0, 1e6, INF, -INF])
            case "gap":
                time[at:] += rng.choice([10, 1e6]) * step
            case "repeat":
                time[at] = time[max(at - 1, 0)]
            case "jitter":
                time = np.sort(time + rng.normal(0, step, n))
            case "lost stamp":
                time[at] = NAN
    return time, force


RECORDINGS = {"shape": st.sampled_from(SHAPES), "n": st.sampled_from(SIZES),
    "step": st.sampled_from(STEPS) | st.just(0.004), "scale": st.sampled_from(SCALES),
    "offset": st.sampled_from(OFFSETS), "seed": st.integers(0, 10**6),
    "damage": st.lists(st.sampled_from(["missing", "spike", "gap", "repeat", "jitter", "lost stamp"]),
    max_size=2)}  # fmt: skip


def check_averages(window, **recording):
    """An average lies between the smallest and the largest sample, and is missing only where all are."""
    time, force = nasty(**recording)
    window = 0.01 if window is None else window
    found = answered(lambda: smooth(ForceTrace(time_s=time, force_N=force), window).force_N)
    if found is None:
        return
    assert found.shape == force.shape
    there = np.isfinite(force)
    assert np.isfinite(found[there]).all()
    if there.any():
        slack = 1e-12 * np.abs(force[there]).max() + 1e-321  # subnormal numbers round to a few steps
        means = found[np.isfinite(found)]
        assert force[there].min() - slack <= means.min()
        assert means.max() <= force[there].max() + slack


def check_clock(**recording):
    """A mended clock strictly increases, and moves no sample that it keeps by more than a step."""
    time, force = nasty(**recording)
    mended = answered(lambda: mend_clock(time, [force]))
    if mended is not None:
        keep, stamps, notes = mended
        assert np.isfinite(stamps).all()
        assert (np.diff(stamps) > 0).all()
        assert stamps.size == time[keep].size
        assert stamps.size == time.size or notes


def check_picking(*, protocol, window, ending, min_step, part, **recording):
    """Whatever is picked has a force exactly where it is ok, and no standard deviation below zero."""
    time, force = nasty(**recording)
    trace = answered(lambda: ForceTrace(time_s=time, force_N=force))
    if trace is None:
        return
    middle = float(time[time.size // 2])
    settings = PickSettings(window_s=window, ending=ending, min_step_N=min_step,
        start_s=middle if part == "late" else None, stop_s=middle if part == "early" else None)  # fmt: skip
    results = answered(lambda: PROTOCOLS[protocol].pick(trace, settings))
    if results is None:
        return
    assert results
    present = force[np.isfinite(force)]
    for result in results:
        assert result.advice
        stds = ("kinetic_std_N", "noise_std_N", "peak_std_N", "window_s")
        assert not any(math.isinf(getattr(result, name)) for name in (*stds, "kinetic_N", "bias_N"))
        assert not any(getattr(result, name) < 0.0 for name in stds)
        if result.status is not Status.OK:
            assert math.isnan(result.peak_N)
            assert result.detail
            continue
        assert math.isfinite(result.peak_N)
        assert math.isfinite(result.peak_std_N)
        assert time[0] <= result.peak_time_s <= time[-1]
        slack = 1e-9 * np.abs(present).max()
        assert present.min() - slack <= result.peak_raw_N <= present.max() + slack
        for phase in result.phases:
            assert phase.start_s <= phase.end_s


test_averages, test_averages_long = fuzzed(check_averages, short=40, share=0.14,
    window=st.sampled_from(WINDOWS),
    **RECORDINGS)  # fmt: skip
test_clock, test_clock_long = fuzzed(check_clock, short=40, share=0.43, **RECORDINGS)
USUAL = {"window": None, "ending": "sliding", "min_step": None, "part": "all", "scale": 1.0}
test_picking, test_picking_long = fuzzed(
    check_picking, short=80, share=0.1,
    examples=[
        # A held plateau of two samples had no scatter: its second half was one sample.
        USUAL | {"protocol": "held", "shape": "pull", "n": 50, "step": 0.004, "offset": 0.0, "seed": 3,
                 "damage": ["missing"]},
        # Noise on an offset that rounds it away: neither noise nor climb, and a division by their size.
        USUAL | {"protocol": "breakaway", "shape": "noise", "n": 400, "step": 0.001, "offset": -1e16, "seed": 34634,
                 "damage": []},
        # Steps that no clock makes gave an infinite rate.
        USUAL | {"protocol": "breakaway", "shape": "pull", "n": 120, "step": 1e-320, "offset": 0.0, "seed": 1,
                 "damage": []},
    ],
    protocol=st.sampled_from(sorted(PROTOCOLS)), window=st.sampled_from(WINDOWS),
    ending=st.sampled_from(ENDINGS), min_step=st.sampled_from([None, None, 0.0, 1.0, 1e300]),
    part=st.sampled_from(["all", "all", "late", "early"]), **RECORDINGS,
)  # fmt: skip
