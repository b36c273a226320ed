"""What the second rig's sensor and logger make of the spring's force, and everything that goes wrong on the way."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.signal

from ropefric.arrays import BoolArray, FloatArray
from ropefric.rig.dynamics import Motion, Slider, stops
from ropefric.rig.pulls import Truth
from ropefric.traces.breakaway import Status
from ropefric.traces.calibration import Adc, Calibration, ForceCell


@dataclass(slots=True, kw_only=True, eq=False)
class Take:
    """A recording in the making: what was drawn, and what the sensor has made of it so far."""

    rng: np.random.Generator
    drawn: dict[str, Any]
    slider: Slider
    truth: Truth
    time_s: FloatArray = field(default_factory=lambda: np.empty(0))
    force_N: FloatArray = field(default_factory=lambda: np.empty(0))
    counts: FloatArray | None = None
    calibration: Calibration | None = None


def touched(
    time_s: FloatArray, rng: np.random.Generator, before_s: float, lasting_s: tuple[float, float]
) -> tuple[FloatArray, float]:
    """Return what something that pushes on the rope before it is pulled adds, 0 to 1, and when it begins [s].

    Longer than 50 ms it is a snag, which is pulled up, holds for a while and lets go; shorter, an impact, half a sine.
    """
    lasting = min(float(np.exp(rng.uniform(*np.log(lasting_s)))), 0.7 * before_s)
    at_s = rng.uniform(0.1, 0.95) * (before_s - lasting)
    part = np.clip((time_s - at_s) / lasting, 0.0, 1.0)
    up, down = np.sort(rng.uniform(0.1, 0.95, 2))
    snag = np.minimum(part / up, (1.0 - part) / (1.0 - down)).clip(0.0, 1.0)
    return snag if lasting_s[1] > SNAG_S[0] else np.sin(np.pi * part) * (part < 1.0), at_s


SNAG_S, IMPACT_S = (0.05, 0.8), (0.006, 0.03)


def _snag(take: Take) -> None:
    form, at_s = touched(take.time_s, take.rng, _pull_s(take.slider), SNAG_S)
    room_N = _size_N(take) - float(np.interp(at_s, take.time_s, take.force_N))
    take.force_N = take.force_N + take.rng.uniform(0.1, 0.95) * room_N * form


def _impact(take: Take) -> None:
    form, _ = touched(take.time_s, take.rng, _pull_s(take.slider), IMPACT_S)
    take.force_N = take.force_N + take.rng.uniform(0.2, 1.3) * _size_N(take) * form


def _pull_s(slider: Slider) -> float:
    return slider.profile[1][0]


def _size_N(take: Take) -> float:
    return take.truth.peak_N if take.truth.status == Status.OK else take.slider.scale_N


def _filtered(take: Take) -> None:
    """Let an anti-alias filter pass what is slower than 10 to 60 Hz, but no less than the climb needs."""
    rate_Hz = 1.0 / (take.time_s[1] - take.time_s[0])
    corner_Hz = max(float(np.exp(take.rng.uniform(*np.log((10.0, 60.0))))), 40.0 / take.drawn["climb_s"])
    if corner_Hz < 0.4 * rate_Hz:
        parts = scipy.signal.butter(int(take.rng.integers(1, 4)), corner_Hz, fs=rate_Hz, output="sos")
        start = scipy.signal.sosfilt_zi(parts) * take.force_N[0]
        take.force_N = scipy.signal.sosfilt(parts, take.force_N, zi=start)[0]


def _rung(take: Take) -> None:
    """Let a light cell ring at its own frequency after every jump of the force."""
    rate_Hz = 1.0 / (take.time_s[1] - take.time_s[0])
    own_Hz = min(take.rng.uniform(40.0, 200.0), rate_Hz / 8.0)
    omega, zeta = 2.0 * np.pi * own_Hz, take.rng.uniform(0.01, 0.08)
    top, bottom = scipy.signal.bilinear([omega**2], [1.0, 2.0 * zeta * omega, omega**2], fs=rate_Hz)
    start = scipy.signal.lfilter_zi(top, bottom) * take.force_N[0]
    take.force_N = scipy.signal.lfilter(top, bottom, take.force_N, zi=start)[0]


def _hummed(take: Take) -> None:
    mains_Hz = float(take.rng.choice((50.0, 60.0))) * (1.0 + take.rng.uniform(-2e-3, 2e-3))
    for harmonic, part in ((1, 1.0), (2, take.rng.uniform(0.0, 0.3)), (3, take.rng.uniform(0.0, 0.4))):
        phase = take.rng.uniform(0.0, 2.0 * np.pi)
        wave = np.sin(2.0 * np.pi * harmonic * mains_Hz * take.time_s + phase)
        take.force_N = take.force_N + part * take.drawn["hum"] * _size_N(take) * wave


def _pink(take: Take) -> None:
    n = take.time_s.size
    spectrum = np.fft.rfft(take.rng.standard_normal(n)) / np.sqrt(np.maximum(np.arange(n // 2 + 1), 1.0))
    noise = np.fft.irfft(spectrum, n)
    take.force_N = take.force_N + noise / noise.std() * take.rng.uniform(1.0, 2.5) * take.drawn[
        "noise"
    ] * _size_N(take)


def _shifted(take: Take) -> None:
    take.force_N = take.force_N + take.rng.choice((-1.0, 1.0)) * take.rng.uniform(0.05, 0.1) * _size_N(take)


def _drifted(take: Take) -> None:
    part = take.time_s / take.time_s[-1]
    take.force_N = (
        take.force_N + take.rng.choice((-1.0, 1.0)) * take.rng.uniform(0.02, 0.1) * _size_N(take) * part
    )


def _spiked(take: Take, *, double: bool = False) -> None:
    force_N, rng = take.force_N.copy(), take.rng
    for _ in range(int(rng.integers(1, 6))):
        near = take.truth.status == Status.OK and rng.random() < 0.3
        where = take.truth.time_s + rng.uniform(-0.1, 0.1) if near else rng.uniform(0.0, take.time_s[-1])
        at = int(np.clip(np.searchsorted(take.time_s, where), 1, force_N.size - 12))
        for start in (at, at + int(rng.integers(2, 9)))[: 2 if double else 1]:
            height = rng.choice((-1.0, 1.0)) * rng.uniform(0.05, 1.2) * _size_N(take)
            force_N[start : start + int(rng.integers(1, 4))] += height
    take.force_N = force_N


def _clear(take: Take, length: int) -> int:
    """Return where a stretch of samples may be lost: not where the peak is."""
    n = take.time_s.size
    starts = np.arange(1, max(n - length - 1, 2))
    if take.truth.status == Status.OK:
        peak, room = (
            int(np.searchsorted(take.time_s, take.truth.time_s)),
            max(6, int(0.02 * n * take.rng.random())),
        )
        starts = starts[(starts + length < peak - room) | (starts > peak + room)]
    return int(take.rng.choice(starts)) if starts.size else 1


def _dropped(take: Take) -> None:
    force_N = take.force_N.copy()
    for _ in range(int(take.rng.integers(1, 4))):
        length = int(take.rng.integers(2, max(4, force_N.size // 60)))
        at = _clear(take, length)
        force_N[at : at + length] = np.nan if take.rng.random() < 0.5 else force_N[at - 1]
    take.force_N = force_N


def _kept(take: Take, keep: BoolArray) -> None:
    take.time_s, take.force_N = take.time_s[keep], take.force_N[keep]


def _gapped(take: Take) -> None:
    keep = np.ones(take.time_s.size, dtype=bool)
    for _ in range(int(take.rng.integers(1, 3))):
        length = int(take.rng.integers(3, max(5, keep.size // 40)))
        at = _clear(take, length)
        keep[at : at + length] = False
    _kept(take, keep)


def _jittered(take: Take) -> None:
    step_s = take.time_s[1] - take.time_s[0]
    take.time_s = take.time_s + step_s * take.rng.uniform(-0.4, 0.4, take.time_s.size)


def _doubled(take: Take) -> None:
    rows = np.sort(np.concatenate([np.arange(take.time_s.size), take.rng.integers(0, take.time_s.size, 9)]))
    take.time_s, take.force_N = take.time_s[rows], take.force_N[rows]


def _coarse(take: Take) -> None:
    lsb_N = _size_N(take) * take.rng.uniform(1.1, 2.5) / 2.0 ** int(take.rng.integers(8, 11))
    take.force_N = np.rint(take.force_N / lsb_N) * lsb_N


def _clip_at(take: Take) -> float:
    part = take.rng.uniform(0.6, 0.97)
    if take.truth.status == Status.OK:
        peak_N, take.truth = take.truth.peak_N, Truth(status=Status.SATURATED, time_s=take.truth.time_s)
        return part * peak_N
    return 1.5 * _size_N(take)


def _clipped(take: Take) -> None:
    take.force_N = np.minimum(take.force_N, _clip_at(take))


def _clipped_counts(take: Take) -> None:
    adc = Adc(bits=int(take.rng.choice((10, 12, 16))))
    cell = ForceCell(name="S", full_scale_N=_clip_at(take), zero_V=0.5)
    volts = cell.line.zero_V + take.force_N / cell.line.gain_N_V
    take.counts = np.clip(np.rint((volts - adc.low_V) / adc.lsb_V), 0, adc.max_count)
    take.calibration = Calibration(cell=cell, adc=adc)
    take.force_N = take.calibration.apply(take.counts.astype(np.int64))[0]


def _late(take: Take) -> None:
    """Let the recording begin while the rope slides steadily."""
    if take.truth.status == Status.OK:
        stop_s = min(stops(take.slider, take.truth.time_s), float(take.time_s[-1]))
        begins_s = take.truth.time_s + take.rng.uniform(0.5, 0.7) * (stop_s - take.truth.time_s)
        _kept(take, take.time_s > begins_s)
        take.truth = Truth(status=Status.NO_PEAK)


_ANALOG: dict[str, Callable[[Take], None]] = {
    "snag": _snag, "impact": _impact, "filter": _filtered, "ringing": _rung,
}  # fmt: skip
_DIGITAL: dict[str, Callable[[Take], None]] = {
    "hum": _hummed, "pink": _pink, "tare-shift": _shifted, "drift": _drifted, "spikes": _spiked,
    "double-spikes": lambda take: _spiked(take, double=True), "dropouts": _dropped, "gaps": _gapped, "jitter": _jittered,
    "doubled": _doubled, "coarse": _coarse, "clipped": _clipped, "clipped-counts": _clipped_counts, "late": _late,
}  # fmt: skip


def sense(take: Take, motion: Motion, faults: Sequence[str]) -> None:
    """Turn the spring's force into samples."""
    rng, drawn = take.rng, take.drawn
    end_s = float(motion.time_s[-1])
    rate_Hz = min(
        max(drawn["rate_Hz"], 40.0 / end_s, drawn.get("per_climb", 80.0) / drawn["climb_s"]), 5e4 / end_s
    )
    finer = int(np.ceil(2e3 / rate_Hz)) if any(name in _ANALOG for name in faults) else 1
    take.time_s = np.arange(int(end_s * rate_Hz * finer)) / (rate_Hz * finer)
    take.force_N = motion.spring_N(take.time_s)
    if not take.slider.tared:  # the weights are hung while it records
        hung_s = rng.uniform(0.4, 0.7) * min(drawn["idle_s"], _pull_s(take.slider))
        rise_s = rng.uniform(0.1, 0.3) * hung_s
        part = np.clip((take.time_s - hung_s) / rise_s, 0.0, 1.0)
        take.force_N = take.force_N * part**2 * (3.0 - 2.0 * part)
    for name in faults:
        if name in _ANALOG:
            _ANALOG[name](take)
    take.time_s, take.force_N = take.time_s[::finer], take.force_N[::finer]
    take.force_N = take.force_N + drawn["noise"] * _size_N(take) * rng.standard_normal(take.time_s.size)
    lsb_N = _size_N(take) * rng.uniform(1.2, 6.0) / 2.0 ** drawn.get("bits", 16)
    take.force_N = np.rint(take.force_N / lsb_N) * lsb_N
    for name in faults:
        if name in _DIGITAL:
            _DIGITAL[name](take)
