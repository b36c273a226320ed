"""What can go wrong in a recording of the virtual rig, where it acts, and what an honest reading makes of it."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.registry import Registry
from ropefric.rig.protocols import Story, draw_teeth
from ropefric.rig.sensing import Sensor
from ropefric.rig.settings import Bench
from ropefric.rig.story import BreakawayStory, draw_wander, lay_teeth
from ropefric.traces.breakaway import Status


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """What happens in a recording and what measures it."""

    story: Story
    sensor: Sensor


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Samples:
    """What the logger wrote."""

    time_s: FloatArray
    counts: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """Something that goes wrong in a recording; acts on the mechanics, on the samples or on the file."""

    name: str
    meaning: str
    expected_status: Status | None
    rate: float
    protocols: tuple[str, ...] = ()
    on_setup: Callable[[Setup, Bench, np.random.Generator], Setup] | None = None
    on_samples: Callable[[Samples, Setup, np.random.Generator], Samples] | None = None
    on_bytes: Callable[[bytes, np.random.Generator], bytes] | None = None


def breakaway_story(setup: Setup, fault: str) -> BreakawayStory:
    """Return the break-away story a fault wants to change."""
    if not isinstance(setup.story, BreakawayStory):
        raise InputError(
            f"fault '{fault}' changes a break-away, and this recording has none",
            key="faults",
            fix="leave it out, or use protocol 'breakaway'",
        )
    return setup.story


def near(time_s: FloatArray, setup: Setup, within_s: float) -> tuple[int, int]:
    """Return first and one past last sample index within some time of the break-away; (0, 0) if there is none."""
    peak_s = setup.story.truth().breakaway_time_s
    if not np.isfinite(peak_s):
        return 0, 0
    first, last = np.searchsorted(time_s, (peak_s - within_s, peak_s + within_s)).tolist()
    return first, last


NEAR_S = 0.03


def _spike(samples: Samples, setup: Setup, rng: np.random.Generator) -> Samples:
    counts = samples.counts.copy()
    top = setup.sensor.adc.max_count
    first, last = near(samples.time_s, setup, NEAR_S)
    for _ in range(int(rng.integers(1, 4))):
        # The motor is loudest when it works hardest: one spike in four falls close to the peak.
        close = last > first and rng.random() < 0.25
        at = int(rng.integers(first, last) if close else rng.integers(counts.size))
        size = top * rng.uniform(0.03, 1.0) * rng.choice((-1.0, 1.0))
        span = slice(at, at + int(rng.integers(1, 3)))
        counts[span] = np.clip(np.rint(counts[span] + size), 0, top)
    return Samples(time_s=samples.time_s, counts=counts)


SPIKE = Fault(
    name="spike",
    meaning="one to three spikes of one or two samples, up to full scale",
    expected_status=None,
    rate=0.07,
    on_samples=_spike,
)


CLEAR_S = 0.012
LONGEST = 30


def _dropout(samples: Samples, setup: Setup, rng: np.random.Generator) -> Samples:
    counts = samples.counts.copy()
    first, last = near(samples.time_s, setup, CLEAR_S)
    for _ in range(int(rng.integers(1, 3))):
        length = int(rng.integers(1, LONGEST + 1))
        starts = np.arange(1, counts.size - length)
        # The peak itself stays: losing it is another matter.
        starts = starts[(starts + length <= first) | (starts >= last)]
        if not starts.size:
            continue
        at = int(rng.choice(starts))
        lost = slice(at, at + length)
        counts[lost] = np.nan if rng.random() < 0.6 else counts[at - 1]
    return Samples(time_s=samples.time_s, counts=counts)


DROPOUT = Fault(
    name="dropout",
    meaning="one or two gaps of up to 30 samples, empty or stuck at the last value; never at the peak",
    expected_status=None,
    rate=0.03,
    on_samples=_dropout,
)


SATURATION_MARGIN = 1.02


def _saturation(setup: Setup, bench: Bench, rng: np.random.Generator) -> Setup:
    """Use a cell that is too small; if all are large enough, let the rope jam, which raises F_A itself."""
    story = breakaway_story(setup, SATURATION.name)
    sensors = [replace(setup.sensor, cell=cell) for cell in reversed(bench.cells)]
    for sensor in sensors:
        if story.lift_force_N >= SATURATION_MARGIN * sensor.ceiling_N:
            return Setup(story=story, sensor=sensor)
    lift_N = setup.sensor.ceiling_N * rng.uniform(SATURATION_MARGIN, 1.2)
    factor = lift_N / story.lift_force_N
    teeth = replace(story.teeth, top_N=factor * story.teeth.top_N, bottom_N=factor * story.teeth.bottom_N)
    jammed = replace(
        story,
        lift_force_N=lift_N,
        ramp_top_N=lift_N,
        kinetic_N=factor * story.kinetic_N,
        holding_N=factor * story.holding_N,
        teeth=teeth,
    )
    return Setup(story=jammed, sensor=setup.sensor)


SATURATION = Fault(
    name="saturation",
    meaning="the break-away force lies above the converter's ceiling",
    expected_status=Status.SATURATED,
    rate=0.01,
    protocols=("breakaway",),
    on_setup=_saturation,
)


def _no_breakaway(setup: Setup, bench: Bench, rng: np.random.Generator) -> Setup:  # noqa: ARG001
    story = breakaway_story(setup, NO_BREAKAWAY.name)
    reached = rng.uniform(0.7, 0.95)
    top_N = story.pretension_N + reached * (story.lift_force_N - story.pretension_N)
    stopped = replace(
        story,
        ramp_top_N=top_N,
        hold_loss=rng.uniform(0.0, 0.02),
        holding_N=min(story.holding_N, 0.9 * top_N),
    )
    kind = rng.random()
    if kind < 0.4:  # the logger stops while the force still rises
        cut_s = story.ramp_s + rng.uniform(0.6, 0.95) * (story.breakaway_s - story.ramp_s)
        stopped = replace(stopped, end_s=cut_s)
    elif kind < 0.6:  # the motor is held only briefly
        off_s = story.breakaway_s + rng.uniform(0.1, 0.3)
        stopped = replace(stopped, off_s=off_s, end_s=off_s + (story.end_s - story.off_s))
    return Setup(story=stopped, sensor=setup.sensor)


NO_BREAKAWAY = Fault(
    name="no-breakaway",
    meaning="the ramp stops below the static friction and is held, or the recording ends while it rises",
    expected_status=Status.NO_BREAKAWAY,
    rate=0.01,
    protocols=("breakaway",),
    on_setup=_no_breakaway,
)


ROUGHNESS = (0.007, 0.02)  # standard deviation of the sliding force over the force; dry seals show 2-6 %


def _no_peak(setup: Setup, bench: Bench, rng: np.random.Generator) -> Setup:  # noqa: ARG001
    """Let the whole slope be lost to micro-slip, and slide on roughly at the force reached, without teeth."""
    story = breakaway_story(setup, NO_PEAK.name)
    nothing_N = np.zeros_like(story.teeth.top_N)
    smooth = replace(
        story,
        micro_slip=rng.uniform(0.15, 0.4),
        micro_slip_loss=1.0,
        kinetic_N=story.lift_force_N,
        drift=rng.uniform(0.0, 0.015),
        wander=draw_wander(rng, story.lift_force_N * rng.uniform(*ROUGHNESS)),
        teeth=replace(story.teeth, top_N=nothing_N, bottom_N=nothing_N),
        has_peak=False,
    )
    return Setup(story=smooth, sensor=setup.sensor)


NO_PEAK = Fault(
    name="no-peak",
    meaning="the loading rounds off into rough sliding; no static peak",
    expected_status=Status.NO_PEAK,
    rate=0.01,
    protocols=("breakaway",),
    on_setup=_no_peak,
)


def _too_short(samples: Samples, setup: Setup, rng: np.random.Generator) -> Samples:  # noqa: ARG001
    n = int(rng.integers(5, 50))
    return Samples(time_s=samples.time_s[:n].copy(), counts=samples.counts[:n].copy())


TOO_SHORT = Fault(
    name="too-short",
    meaning="the recording ends after 5 to 49 samples, still idle",
    expected_status=Status.TOO_SHORT,
    rate=0.005,
    on_samples=_too_short,
)


def _high_tooth(setup: Setup, bench: Bench, rng: np.random.Generator) -> Setup:  # noqa: ARG001
    """Raise one to three of the first later teeth to 2-8 % above F_A; each then takes longer to reload."""
    story = breakaway_story(setup, HIGH_TOOTH.name)
    sliding_s = story.off_s - story.breakaway_s
    drop_N = story.lift_force_N - story.kinetic_N
    # Where one tooth can stand so high, all teeth are large: redraw them.
    height_N, rate_Hz = 0.6 * drop_N, float(rng.uniform(8.0, 25.0))
    teeth = draw_teeth(rng, drop_N=drop_N, height_N=height_N, rate_Hz=rate_Hz, lasting_s=4.0 * sliding_s)
    n = int(rng.integers(1, 4))
    chosen = rng.choice(np.arange(2, 5), size=n, replace=False)
    top_N = teeth.top_N.copy()
    top_N[chosen] = story.lift_force_N * rng.uniform(1.02, 1.08, n) - story.kinetic_N
    # The last of them must come before the motor is off, if need be by a faster reload.
    needed_N_s = float((top_N[1:5] - teeth.bottom_N[:4]).sum()) / (0.8 * sliding_s)
    laid = lay_teeth(top_N=top_N, bottom_N=teeth.bottom_N, reload_N_s=max(height_N * rate_Hz, needed_N_s))
    return Setup(story=replace(story, teeth=laid, drift=0.0), sensor=setup.sensor)


HIGH_TOOTH = Fault(
    name="high-tooth",
    meaning="one to three later teeth stand 2 to 8 % above the break-away",
    expected_status=None,
    rate=0.02,
    protocols=("breakaway",),
    on_setup=_high_tooth,
)


def _drift(setup: Setup, bench: Bench, rng: np.random.Generator) -> Setup:  # noqa: ARG001
    story = breakaway_story(setup, DRIFT.name)
    # `drift` counts 1/1.03 of itself at the end, see BreakawayStory.
    climb = 1.03 * (rng.uniform(1.03, 1.08) * story.lift_force_N / story.kinetic_N - 1.0)
    return Setup(story=replace(story, drift=climb), sensor=setup.sensor)


DRIFT = Fault(
    name="drift",
    meaning="the sliding level climbs slowly to 3 to 8 % above the break-away",
    expected_status=None,
    rate=0.02,
    protocols=("breakaway",),
    on_setup=_drift,
)


FACTOR = 4.0


def _noisy(setup: Setup, bench: Bench, rng: np.random.Generator) -> Setup:  # noqa: ARG001
    louder = replace(setup.sensor, noise_counts=FACTOR * setup.sensor.noise_counts)
    return Setup(story=setup.story, sensor=louder)


NOISY = Fault(
    name="noisy",
    meaning="four times the noise",
    expected_status=None,
    rate=0.01,
    on_setup=_noisy,
)


def _clock_jitter(samples: Samples, setup: Setup, rng: np.random.Generator) -> Samples:  # noqa: ARG001
    time_s = samples.time_s
    if time_s.size > 1:
        step_s = float(time_s[1] - time_s[0])
        if rng.random() < 0.5:
            time_s = time_s + step_s * rng.uniform(-0.4, 0.4, time_s.size)
            time_s = time_s - time_s[0]
        else:
            time_s = np.rint(time_s / (3.0 * step_s)) * (3.0 * step_s)  # three samples share a stamp
    return Samples(time_s=time_s, counts=samples.counts)


CLOCK_JITTER = Fault(
    name="clock-jitter",
    meaning="time stamps jitter by up to 0.4 of a step, or three in a row are the same",
    expected_status=None,
    rate=0.01,
    on_samples=_clock_jitter,
)


def _unreadable(data: bytes, rng: np.random.Generator) -> bytes:
    if rng.random() < 0.5:
        return data[: int(len(data) * rng.uniform(0.2, 0.8))]
    head = rng.integers(0, 256, 64, dtype=np.uint8).tobytes()
    return b"\x00" + head[1:] + data[64:]  # whatever the draw, this is no gzip header


UNREADABLE = Fault(
    name="unreadable",
    meaning="the file is cut off, or its beginning overwritten",
    expected_status=Status.UNREADABLE,
    rate=0.0025,
    on_bytes=_unreadable,
)


FAULTS: Registry[Fault] = Registry(
    "fault",
    [
        *(SPIKE, DROPOUT, SATURATION, NO_BREAKAWAY, NO_PEAK, TOO_SHORT),
        *(HIGH_TOOTH, DRIFT, NOISY, CLOCK_JITTER, UNREADABLE),
    ],
)
"""Every fault by name."""
