"""One recording of the virtual rig: mechanics, sensor, converter, and what goes wrong in them or in the file."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.registry import Registry
from ropefric.rig import bench as benches
from ropefric.rig.bench import Bench, BreakawayPull, Sensor, draw_breakaway
from ropefric.rig.strangers import IMPACT_S, SNAG_S, touched
from ropefric.traces.breakaway import Status

SATURATION_MARGIN = 1.02
_NEAR_PEAK_S, _CLEAR_OF_PEAK_S = 0.03, 0.012
_LONGEST_GAP = 30
_ROUGHNESS = (0.007, 0.02)  # standard deviation of the sliding force over the force; dry seals show 2-6 %
# The worse hides the lesser: a file that cannot be read shows no saturation.
_SEVERITY = tuple(map(Status, ("unreadable", "too-short", "saturated", "no-breakaway", "no-peak", "ok")))

Rng = np.random.Generator
Samples = tuple[FloatArray, FloatArray]
"""Output of the logger: times [s] and counts."""


class SimulatedRecording(NamedTuple):
    """One recording of the virtual rig."""

    time_s: FloatArray
    counts: FloatArray
    true_time_s: FloatArray
    true_force_N: FloatArray
    truth: benches.RecordingTruth


@dataclass(frozen=True, slots=True)
class Fault:
    """Something that goes wrong in a recording, and what an honest reading makes of it.

    It acts on the pull, on the sensor, on the force, on the samples, or on the bytes of the file.
    """

    name: str
    rate: float
    expected_status: Status | None = None
    on_pull: Callable[[BreakawayPull, Rng], BreakawayPull] | None = None
    on_setup: Callable[[Any, Sensor, Bench, Rng], tuple[Any, Sensor]] | None = None
    on_force: Callable[[FloatArray, BreakawayPull, Rng], FloatArray] | None = None
    on_samples: Callable[[Samples, Sensor, float, Rng], Samples] | None = None
    on_bytes: Callable[[bytes, Rng], bytes] | None = None

    @property
    def is_mechanical(self) -> bool:
        """Return whether it befalls the pull, of which each recording has one."""
        return (self.on_pull or self.on_setup or self.on_force) is not None


def _near(time_s: FloatArray, peak_s: float, within_s: float) -> tuple[int, int]:
    """Return first and one past last sample index within some time of the peak; (0, 0) if there is none."""
    if not math.isfinite(peak_s):
        return 0, 0
    first, last = np.searchsorted(time_s, (peak_s - within_s, peak_s + within_s)).tolist()
    return first, last


def _spike(samples: Samples, sensor: Sensor, peak_s: float, rng: Rng) -> Samples:
    """Add one to three spikes of one or two samples, up to full scale."""
    time_s, counts = samples[0], samples[1].copy()
    top = sensor.adc.max_count
    first, last = _near(time_s, peak_s, _NEAR_PEAK_S)
    for _ in range(int(rng.integers(1, 4))):
        # The motor is loudest when it works hardest: one spike in four falls close to the peak.
        close = last > first and rng.random() < 0.25
        at = int(rng.integers(first, last) if close else rng.integers(counts.size))
        size = top * rng.uniform(0.03, 1.0) * rng.choice((-1.0, 1.0))
        span = slice(at, at + int(rng.integers(1, 3)))
        counts[span] = np.clip(np.rint(counts[span] + size), 0, top)
    return time_s, counts


def _dropout(samples: Samples, _sensor: Sensor, peak_s: float, rng: Rng) -> Samples:
    """Make one or two gaps of up to 30 samples, empty or stuck at the last value; never at the peak."""
    time_s, counts = samples[0], samples[1].copy()
    first, last = _near(time_s, peak_s, _CLEAR_OF_PEAK_S)
    for _ in range(int(rng.integers(1, 3))):
        length = int(rng.integers(1, _LONGEST_GAP + 1))
        starts = np.arange(1, counts.size - length)
        # The peak itself stays: losing it is another matter.
        starts = starts[(starts + length <= first) | (starts >= last)]
        if starts.size:
            at = int(rng.choice(starts))
            counts[at : at + length] = np.nan if rng.random() < 0.6 else counts[at - 1]
    return time_s, counts


def _too_short(samples: Samples, _sensor: Sensor, _peak_s: float, rng: Rng) -> Samples:
    """End the recording after 5 to 49 samples, still idle."""
    n = int(rng.integers(5, 50))
    return samples[0][:n].copy(), samples[1][:n].copy()


def _clock_jitter(samples: Samples, _sensor: Sensor, _peak_s: float, rng: Rng) -> Samples:
    """Let time stamps jitter by up to 0.4 of a step, or three in a row be the same."""
    time_s, counts = samples
    if time_s.size > 1:
        step_s = float(time_s[1] - time_s[0])
        if rng.random() < 0.5:
            time_s = time_s + step_s * rng.uniform(-0.4, 0.4, time_s.size)
            return time_s - time_s[0], counts
        time_s = np.rint(time_s / (3.0 * step_s)) * (3.0 * step_s)
    return time_s, counts


def _unreadable(data: bytes, rng: Rng) -> bytes:
    """Cut the file off, or write over its beginning."""
    if rng.random() < 0.5:
        return data[: int(len(data) * rng.uniform(0.2, 0.8))]
    head = rng.integers(0, 256, 64, dtype=np.uint8).tobytes()
    return b"\x00" + head[1:] + data[64:]  # whatever the draw, this is no gzip header


def _saturation(pull: BreakawayPull, sensor: Sensor, bench: Bench, rng: Rng) -> tuple[BreakawayPull, Sensor]:
    """Use a cell that is too small; if all are large enough, let the rope jam, which raises F_A itself."""
    for cell in reversed(bench.cells):
        smaller = replace(sensor, cell=cell)
        if pull.lift_force_N >= SATURATION_MARGIN * smaller.ceiling_N:
            return pull, smaller
    lift_N = sensor.ceiling_N * rng.uniform(SATURATION_MARGIN, 1.2)
    return pull.raised(lift_N / pull.lift_force_N), sensor


def _no_breakaway(pull: BreakawayPull, rng: Rng) -> BreakawayPull:
    """Stop the ramp below the static friction and hold it, or end the recording while it rises."""
    reached = rng.uniform(0.7, 0.95)
    top_N = pull.pretension_N + reached * (pull.lift_force_N - pull.pretension_N)
    hold_loss = rng.uniform(0.0, 0.02)
    stopped = replace(pull, ramp_top_N=top_N, hold_loss=hold_loss, holding_N=min(pull.holding_N, 0.9 * top_N))
    kind = rng.random()
    if kind < 0.4:  # the logger stops while the force still rises
        cut_s = pull.ramp_s + rng.uniform(0.6, 0.95) * (pull.breakaway_s - pull.ramp_s)
        stopped = replace(stopped, end_s=cut_s)
    elif kind < 0.6:  # the motor is held only briefly
        off_s = pull.breakaway_s + rng.uniform(0.1, 0.3)
        stopped = replace(stopped, off_s=off_s, end_s=off_s + (pull.end_s - pull.off_s))
    return stopped


def _no_peak(pull: BreakawayPull, rng: Rng) -> BreakawayPull:
    """Let the whole slope be lost to micro-slip, and slide on roughly at the force reached, without teeth."""
    slope: dict[str, Any] = {"micro_slip": rng.uniform(0.15, 0.4), "micro_slip_loss": 1.0, "has_peak": False}
    slides: dict[str, Any] = {"kinetic_N": pull.lift_force_N, "drift": rng.uniform(0.0, 0.015)}
    roughness = benches.draw_roughness(rng, pull.lift_force_N * rng.uniform(*_ROUGHNESS))
    return replace(pull, roughness=roughness, teeth=pull.teeth.scaled(0.0), **slope, **slides)


def _high_tooth(pull: BreakawayPull, rng: Rng) -> BreakawayPull:
    """Raise one to three of the first later teeth to 2-8 % above F_A; each then takes longer to reload."""
    sliding_s = pull.off_s - pull.breakaway_s
    drop_N = pull.lift_force_N - pull.kinetic_N
    # Where one tooth can stand so high, all teeth are large: redraw them.
    height_N, rate_Hz = 0.6 * drop_N, float(rng.uniform(8.0, 25.0))
    size = {"drop_N": drop_N, "height_N": height_N, "rate_Hz": rate_Hz}
    teeth = benches.draw_teeth(rng, lasting_s=4.0 * sliding_s, **size)
    n = int(rng.integers(1, 4))
    chosen = rng.choice(np.arange(2, 5), size=n, replace=False)
    top_N = teeth.top_N.copy()
    top_N[chosen] = pull.lift_force_N * rng.uniform(1.02, 1.08, n) - pull.kinetic_N
    # The last of them must come before the motor is off, if need be by a faster reload.
    needed_N_s = float((top_N[1:5] - teeth.bottom_N[:4]).sum()) / (0.8 * sliding_s)
    reload_N_s = max(height_N * rate_Hz, needed_N_s)
    laid = benches.lay_teeth(top_N=top_N, bottom_N=teeth.bottom_N, reload_N_s=reload_N_s)
    return replace(pull, teeth=laid, drift=0.0)


def _drift(pull: BreakawayPull, rng: Rng) -> BreakawayPull:
    """Let the sliding level climb slowly to 3 to 8 % above the break-away."""
    # `drift` counts 1/1.03 of itself at the end, see BreakawayPull.
    climb = 1.03 * (rng.uniform(1.03, 1.08) * pull.lift_force_N / pull.kinetic_N - 1.0)
    return replace(pull, drift=climb)


def _noisy(pull: Any, sensor: Sensor, _bench: Bench, _rng: Rng) -> tuple[Any, Sensor]:
    """Make the noise four times as loud."""
    return pull, replace(sensor, noise_counts=4.0 * sensor.noise_counts)


def _hum(pull: Any, sensor: Sensor, _bench: Bench, rng: Rng) -> tuple[Any, Sensor]:
    """Let the mains in, with 0.1 to 3 % of F_A."""
    part, mains_Hz = np.exp(rng.uniform(*np.log((1e-3, 0.03)))), float(rng.choice((50.0, 60.0)))
    return pull, replace(sensor, hum_counts=part * _counts(sensor, pull.lift_force_N), hum_Hz=mains_Hz)


def _zero_drift(pull: Any, sensor: Sensor, _bench: Bench, rng: Rng) -> tuple[Any, Sensor]:
    """Let the zero drift by 5 to 10 % of F_A from the first sample to the last."""
    part, whole = rng.choice((-1.0, 1.0)) * rng.uniform(0.05, 0.1), _counts(sensor, pull.lift_force_N)
    zero_counts = sensor.zero_counts - min(part, 0.0) * whole  # stays on scale
    return pull, replace(sensor, drift_counts=part * whole, zero_counts=zero_counts)


def _counts(sensor: Sensor, force_N: float) -> float:
    return force_N / sensor.cell.line.gain_N_V / sensor.adc.lsb_V


def _push(time_s: FloatArray, pull: BreakawayPull, rng: Rng, *, lasting_s: tuple[float, float]) -> FloatArray:
    """Catch the rope before the pull and let it go, at 0.1 to 0.95 of F_A, or hit the rig: half a sine of 6 to 30 ms."""
    # While the weights hang; before, the zero is taken.
    form, _ = touched(time_s - pull.hang_s, rng, pull.ramp_s - pull.hang_s, lasting_s)
    room_N = pull.lift_force_N - pull.force_N(np.array([pull.ramp_s]))
    return np.asarray(rng.uniform(0.1, 0.95) * room_N * form)


def _precursor(time_s: FloatArray, pull: BreakawayPull, rng: Rng) -> FloatArray:
    """Let part of the rope slip by 2 to 12 % of F_A at 78 to 96 % of it; the climb makes good for it."""
    fine_s = np.linspace(pull.ramp_s, pull.breakaway_s, 2001)
    reached = pull.force_N(fine_s) >= rng.uniform(0.78, 0.96) * pull.lift_force_N
    at_s, lasting_s = float(fine_s[np.argmax(reached)]), rng.uniform(0.002, 0.02)
    left = np.clip((pull.breakaway_s - time_s) / (pull.breakaway_s - at_s), 0.0, 1.0)
    slipped = np.clip((time_s - at_s) / lasting_s, 0.0, 1.0)
    return np.asarray(-rng.uniform(0.02, 0.12) * pull.lift_force_N * slipped * left)


def _rounded(pull: BreakawayPull, rng: Rng) -> BreakawayPull:
    """Let the climb bend over to nothing while micro-slip spreads, and the force fall over 40 to 200 ms."""
    bent = replace(pull, micro_slip=rng.uniform(0.1, 0.4), micro_slip_loss=rng.uniform(0.7, 1.0))
    return _slow_fall(bent, rng, (0.04, 0.2))


def _slow_fall(pull: BreakawayPull, rng: Rng, lasting_s: tuple[float, float] = (0.2, 0.6)) -> BreakawayPull:
    """Let the force fall over 0.2 to 0.6 s to sliding without teeth."""
    # A snap damped so much that it hardly swings back has fallen by nine tenths after 0.65 of its period.
    natural_Hz = 0.65 / float(np.exp(rng.uniform(*np.log(lasting_s))))
    rough = benches.draw_roughness(rng, pull.lift_force_N * rng.uniform(0.0005, 0.003))
    drop_N = pull.lift_force_N - pull.kinetic_N
    teeth = benches.Teeth(time_s=np.array([0.0, 1e3]), top_N=np.array([drop_N, 0.0]), bottom_N=np.zeros(2))
    snap = benches.Snap(natural_Hz=natural_Hz, damping_ratio=0.9)
    return replace(pull, snap=snap, teeth=teeth, roughness=rough)


FAULTS: Registry[Fault] = Registry(
    "fault",
    [
        Fault("spike", 0.07, on_samples=_spike),
        Fault("dropout", 0.03, on_samples=_dropout),
        Fault("saturation", 0.01, Status.SATURATED, on_setup=_saturation),
        Fault("no-breakaway", 0.01, Status.NO_BREAKAWAY, _no_breakaway),
        Fault("no-peak", 0.01, Status.NO_PEAK, _no_peak),
        Fault("too-short", 0.005, Status.TOO_SHORT, on_samples=_too_short),
        Fault("high-tooth", 0.02, None, _high_tooth),
        Fault("drift", 0.02, None, _drift),
        Fault("noisy", 0.01, on_setup=_noisy),
        Fault("clock-jitter", 0.01, on_samples=_clock_jitter),
        Fault("unreadable", 0.0025, Status.UNREADABLE, on_bytes=_unreadable),
        # Not in an ordinary campaign, unless they are asked for.
        Fault("hum", 0.0, on_setup=_hum),
        Fault("zero-drift", 0.0, None, on_setup=_zero_drift),
        Fault("snag", 0.0, None, on_force=partial(_push, lasting_s=SNAG_S)),
        Fault("impact", 0.0, None, on_force=partial(_push, lasting_s=IMPACT_S)),
        Fault("precursor", 0.0, None, on_force=_precursor),
        Fault("rounded", 0.0, None, _rounded),
        Fault("slow-fall", 0.0, None, _slow_fall),
    ],
)
"""Every fault by name, with the fraction of recordings it befalls in an ordinary campaign."""
ORDINARY = {fault.name: fault.rate for fault in FAULTS.values() if fault.rate}


def simulate_recording(
    bench: Bench,
    *,
    lift_force_N: float,
    end_tension_N: float,
    rng: Rng,
    faults: Sequence[str] = (),
    cell: str = "",
) -> SimulatedRecording:
    """Return one recording with known truth.

    The mechanics, the noise and the faults draw from generators of their own, so the same seed with and without
    a fault of the samples differs by that fault alone.
    """
    if not 0.0 < end_tension_N < lift_force_N < math.inf:
        what = f"the end tension {end_tension_N:g} N must be positive and below the lift force {lift_force_N:g} N"
        fix = "give the slack-side force as end_tension_N and the larger, tight-side force as lift_force_N"
        raise InputError(what, key="end_tension_N", fix=fix)
    chosen = [FAULTS[name] for name in faults]
    draw_rng, fault_rng, noise_rng = (np.random.default_rng(seed) for seed in rng.integers(2**63, size=3))
    pull = draw_breakaway(bench, lift_force_N, end_tension_N, draw_rng)
    counts = {"zero_counts": draw_rng.uniform(*bench.zero_counts)}  # in the order of the draws
    counts["drift_counts"] = bench.zero_drift_counts * draw_rng.uniform(-1.0, 1.0)
    counts["noise_counts"] = draw_rng.uniform(*bench.noise_counts)
    used = bench.cell_named(cell) if cell else bench.cell_for(lift_force_N)
    sensor = Sensor(cell=used, adc=bench.adc, hum_phase_rad=draw_rng.uniform(0.0, 2.0 * np.pi), **counts)
    for fault in chosen:
        if fault.on_setup:
            pull, sensor = fault.on_setup(pull, sensor, bench, fault_rng)
        elif fault.on_pull:
            pull = fault.on_pull(pull, fault_rng)
    true_time_s = np.arange(math.floor(pull.end_s * bench.sampling_rate_Hz) + 1) / bench.sampling_rate_Hz
    true_force_N = pull.force_N(true_time_s)
    for fault in chosen:
        if fault.on_force:
            true_force_N = true_force_N + fault.on_force(true_time_s, pull, fault_rng)
    truth = pull.truth()
    samples = (true_time_s, sensor.read(true_force_N, true_time_s, noise_rng))
    for fault in chosen:
        if fault.on_samples:
            samples = fault.on_samples(samples, sensor, truth.breakaway_time_s, fault_rng)
    statuses = [truth.status, *(fault.expected_status for fault in chosen if fault.expected_status)]
    befallen = tuple(fault.name for fault in chosen)
    truth = replace(truth, status=min(statuses, key=_SEVERITY.index), faults=befallen, cell=sensor.cell.name)
    true = {"true_time_s": true_time_s, "true_force_N": true_force_N}
    return SimulatedRecording(time_s=samples[0], counts=samples[1], truth=truth, **true)
