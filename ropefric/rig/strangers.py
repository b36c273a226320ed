"""Recordings of rigs unlike the first, with known truth: families of mechanics, of sensors and of what goes wrong.

`recordings(seed)` draws rigs over wide ranges (1 N to 5 kN, 50 Hz to 10 kHz, micro-slip from a thousandth of the climb's
way to more than what stays stable), integrates them (`dynamics`) and passes the spring's force through a sensor.
The truth comes from the noise-free force of the spring alone.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy.signal

from ropefric.arrays import BoolArray, FloatArray, frozen_array
from ropefric.registry import Registry
from ropefric.rig.dynamics import Motion, Slider, simulate, stops
from ropefric.rig.pulls import NO_PEAK, SLOW, Truth, draw_numbers, draw_slider, truth_of
from ropefric.traces.breakaway import Status
from ropefric.traces.calibration import Adc, Calibration, ForceCell, Saturation
from ropefric.traces.clock import mend_clock
from ropefric.traces.trace import ForceTrace


@dataclass(slots=True, kw_only=True, eq=False)
class Take:
    """A recording in the making: what was drawn, and what the sensor has made of it so far."""

    rng: np.random.Generator
    drawn: dict[str, Any]
    slider: Slider
    truth: Truth
    time_s: FloatArray = field(default_factory=lambda: np.empty(0))
    force_N: FloatArray = field(default_factory=lambda: np.empty(0))
    calibration: Calibration | None = None
    saturation: Saturation | None = None


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
    take.force_N += take.rng.uniform(0.1, 0.95) * room_N * form


def _impact(take: Take) -> None:
    form, _ = touched(take.time_s, take.rng, _pull_s(take.slider), IMPACT_S)
    take.force_N += take.rng.uniform(0.2, 1.3) * _size_N(take) * form


def _pull_s(slider: Slider) -> float:
    return slider.profile[1][0]


def _size_N(take: Take) -> float:
    return take.truth.peak_N if take.truth.status == Status.OK else take.slider.scale_N


def _filtered(take: Take) -> None:
    """Apply an anti-alias filter of 10 to 60 Hz, but not below the frequencies of the climb."""
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
        take.force_N += part * take.drawn["hum"] * _size_N(take) * wave


def _pink(take: Take) -> None:
    n = take.time_s.size
    spectrum = np.fft.rfft(take.rng.standard_normal(n)) / np.sqrt(np.maximum(np.arange(n // 2 + 1), 1.0))
    noise = np.fft.irfft(spectrum, n)
    take.force_N += noise / noise.std() * take.rng.uniform(1.0, 2.5) * take.drawn["noise"] * _size_N(take)


def _shifted(take: Take) -> None:
    take.force_N += take.rng.choice((-1.0, 1.0)) * take.rng.uniform(0.05, 0.1) * _size_N(take)


def _drifted(take: Take) -> None:
    drift_N = take.rng.choice((-1.0, 1.0)) * take.rng.uniform(0.02, 0.1) * _size_N(take)
    take.force_N += drift_N * (take.time_s / take.time_s[-1])


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
        peak = int(np.searchsorted(take.time_s, take.truth.time_s))
        room = max(6, int(0.02 * n * take.rng.random()))
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
    counts = np.clip(np.rint((volts - adc.low_V) / adc.lsb_V), 0, adc.max_count)
    take.calibration = Calibration(cell=cell, adc=adc)
    take.force_N, take.saturation = take.calibration.apply(counts.astype(np.int64))


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
    rate_Hz = max(drawn["rate_Hz"], 40.0 / end_s, drawn.get("per_climb", 80.0) / drawn["climb_s"])
    rate_Hz = min(rate_Hz, 5e4 / end_s)
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
    take.force_N += drawn["noise"] * _size_N(take) * rng.standard_normal(take.time_s.size)
    lsb_N = _size_N(take) * rng.uniform(1.2, 6.0) / 2.0 ** drawn.get("bits", 16)
    take.force_N = np.rint(take.force_N / lsb_N) * lsb_N
    for name in faults:
        if name in _DIGITAL:
            _DIGITAL[name](take)


TIERS = ("clean", "lab", "nasty")
_BATCH, _ATTEMPTS = 240, 15


class Recording(NamedTuple):
    """One recording as a stranger sends it; `loaded_s` is when the motor last began to pull before the top."""

    name: str
    family: str
    tier: str
    time_s: FloatArray
    force_N: FloatArray
    truth: Truth
    loaded_s: float
    calibration: Calibration | None = None
    saturation: Saturation | None = None

    def trace(self) -> ForceTrace:
        """Return the recording as the picker gets it: clock mended, counts with their saturation."""
        keep, time_s, notes = mend_clock(self.time_s, [self.force_N], name=self.name)
        read: dict[str, Any] = {"calibration": self.calibration, "saturation": self.saturation}
        return ForceTrace(time_s=time_s, force_N=self.force_N[keep], name=self.name, notes=notes, **read)


class Family(NamedTuple):
    """Recordings of one kind: how they are drawn, and what the sensor does to them."""

    name: str
    tier: str
    ranges: Mapping[str, Any]
    faults: tuple[str, ...]
    expects: Status


_LAB = {"noise": (1e-3, 6e-3), "rough": (0.0, 0.012), "bits": 12, "rate_Hz": (150.0, 1e4)}
_NASTY = {"noise": (3e-3, 1.5e-2), "rough": (0.0, 0.02), "bits": 11, "rate_Hz": (100.0, 1e4)}
_TEETH = {"direct": (0.3, 0.7), "laws": ("ageing", "slip"), "slide_s": (1.5, 4.0)}
_NONE, _PEAKLESS, _CUT = Status.NO_BREAKAWAY, Status.NO_PEAK, Status.SATURATED


def _family(name: str, tier: str, *faults: str, expects: Status = Status.OK, **ranges: Any) -> Family:
    like = ranges.pop("like", {})
    basis = {"clean": {}, "lab": _LAB, "nasty": _NASTY}[tier]
    return Family(name=name, tier=tier, ranges=basis | like | ranges, faults=faults, expects=expects)


FAMILIES: Registry[Family] = Registry("family of recordings", [
    _family("sharp", "clean"),
    _family("sharp-slip-law", "clean", laws="slip", critical=(0.01, 0.2)),
    _family("bristles", "clean", laws="lugre"),
    _family("rounded", "clean", like=SLOW, fall_s=(0.05, 0.3), climb_s=(0.5, 4.0)),
    _family("fall-20-80-ms", "clean", like=SLOW, fall_s=(0.02, 0.08), climb_s=(0.4, 2.0)),
    _family("fall-0.1-0.6-s", "clean", like=SLOW, fall_s=(0.1, 0.6), climb_s=(0.8, 6.0)),
    _family("strong-stick-slip", "clean", like=_TEETH, drop=(0.3, 0.6), critical=(0.02, 0.2)),
    _family("weak-stick-slip", "clean", like=_TEETH, drop=(0.06, 0.15), critical=(0.3, 0.9)),
    _family("hardening", "clean", wear=(0.03, 0.12)),
    _family("second-higher", "clean", teeth="second", critical=(0.03, 0.2)),
    _family("rests", "clean", rests=True),
    _family("held-quiet", "clean", expects=_NONE, held=(0.4, 0.85), laws=("ageing", "slip"), slide_s=(0.5, 2.0)),
    _family("climbing", "clean", expects=_NONE, stopped=(0.3, 0.9)),
    _family("no-peak", "clean", like=NO_PEAK, expects=_PEAKLESS),
    _family("lab", "lab"),
    _family("lab-bristles", "lab", laws="lugre"),
    _family("lab-rounded", "lab", like=SLOW, fall_s=(0.03, 0.4)),
    _family("fall-0.3-2-s", "lab", like=SLOW, fall_s=(0.3, 2.0), climb_s=(1.5, 8.0)),
    _family("lab-stick-slip", "lab", like=_TEETH, critical=(0.03, 0.7)),
    _family("one-precursor", "lab", partials="one"),
    _family("many-precursors", "lab", partials="many"),
    _family("snag", "lab", "snag", idle_s=(0.5, 2.0)),
    _family("jog", "lab", jog=(0.1, 0.8)),
    _family("impact", "lab", "impact", idle_s=(0.4, 2.0)),
    _family("late-higher", "lab", teeth="late", slide_s=(1.5, 4.0)),
    _family("wear", "lab", like=SLOW, fall_s=(0.02, 0.2), wear=(0.1, 0.5), slide_s=(1.0, 3.0)),
    _family("two-pulls", "lab", pulls=2),
    _family("strokes", "lab", pulls=4, slide_s=(0.3, 1.0), climb_s=(0.2, 1.5)),
    _family("short", "lab", idle_s=(0.05, 0.15), slide_s=(0.1, 0.4), ending="cut", climb_s=(0.2, 0.8), hang=0.0),
    _family("few-samples", "lab", rate_Hz=(50.0, 100.0), climb_s=(0.3, 1.0), per_climb=8.0),
    _family("hum", "lab", "hum", hum=(1e-3, 8e-3), rate_Hz=(400.0, 1e4)),
    _family("pink", "lab", "pink", noise=(1e-3, 3e-3)),
    _family("filter", "lab", "filter", climb_s=(1.0, 6.0)),
    _family("held-creeping", "lab", expects=_NONE, held=(0.7, 0.95), slide_s=(0.8, 3.0)),
    _family("held-let-down", "lab", expects=_NONE, held=(0.5, 0.9), ending="let-down"),
    _family("lab-climbing", "lab", expects=_NONE, stopped=(0.3, 0.93)),
    _family("lab-no-peak", "lab", like=NO_PEAK, expects=_PEAKLESS),
    _family("nasty", "nasty"),
    _family("ringing", "nasty", "ringing", rate_Hz=(800.0, 1e4), critical=(0.03, 0.15)),
    _family("tare-shift", "nasty", "tare-shift"),
    _family("drift", "nasty", "drift"),
    _family("spikes", "nasty", "spikes"),
    _family("double-spikes", "nasty", "double-spikes"),
    _family("dropouts", "nasty", "dropouts"),
    _family("gaps", "nasty", "gaps"),
    _family("jitter", "nasty", "jitter"),
    _family("duplicated-rows", "nasty", "doubled"),
    _family("coarse", "nasty", "coarse"),
    _family("loud-hum", "nasty", "hum", hum=(8e-3, 3e-2), rate_Hz=(300.0, 5e3)),
    _family("hard-snag", "nasty", "snag", "hum", hum=(1e-3, 1e-2), idle_s=(0.5, 2.0)),
    _family("hard-impact", "nasty", "impact", "ringing", idle_s=(0.4, 2.0), rate_Hz=(500.0, 1e4)),
    _family("hard-precursor", "nasty", "spikes", partials="one"),
    _family("everything", "nasty", "snag", "filter", "hum", "drift", "spikes", hum=(1e-3, 1e-2), climb_s=(1.0, 5.0)),
    _family("clipped", "nasty", "clipped", expects=_CUT),
    _family("clipped-counts", "nasty", "clipped-counts", expects=_CUT),
    _family("late-start", "nasty", "late", like=SLOW, expects=_PEAKLESS, fall_s=(0.02, 0.2), slide_s=(1.5, 3.0)),
    _family("hard-held", "nasty", "hum", "drift", hum=(1e-3, 1e-2), expects=_NONE, held=(0.5, 0.9)),
])  # fmt: skip
"""Every kind of recording by name."""


def recordings(
    seed: int,
    *,
    per_family: int = 8,
    families: Sequence[str] = (),
    tiers: Sequence[str] = TIERS,
) -> Iterator[Recording]:
    """Yield recordings of unfamiliar rigs with known truth; the same for the same seed, whichever families are asked.

    Parameters
    ----------
    seed : int
        The same seed draws the same recordings.
    per_family : int
        How many of each family.
    families, tiers : sequence of str
        Only these families, only these tiers; all by default.

    Examples
    --------
    >>> one = next(recordings(1, per_family=1, families=("sharp",)))
    >>> one.truth.status.value, one.tier, one.force_N.size == one.time_s.size
    ('ok', 'clean', True)
    """
    chosen = [FAMILIES[name] for name in families or FAMILIES]
    jobs = [(one, number) for one in chosen if one.tier in tiers for number in range(per_family)]
    for start in range(0, len(jobs), _BATCH):
        yield from _made(seed, jobs[start : start + _BATCH])


def _loaded_s(slider: Slider, top_s: float) -> float:
    """Return when the motor last began to pull before a top, from rest or after it had let down."""
    begun_s, is_forth = 0.0, False
    for (at_s, _), (_, speed) in pairwise(slider.profile):
        if at_s >= top_s:
            break
        if speed > 0.0 and not is_forth:
            begun_s = at_s
        is_forth = speed > 0.0 or (is_forth and speed == 0.0)
    return begun_s


def _made(seed: int, jobs: list[tuple[Family, int]]) -> Iterator[Recording]:
    """Draw until the truth of every recording is defined; other draws are discarded."""
    order = list(FAMILIES)
    done: dict[int, Recording] = {}
    for attempt in range(_ATTEMPTS):
        drawn = []
        for i, (family, number) in enumerate(jobs):
            if i not in done:
                rng = np.random.default_rng([seed, order.index(family.name), number, attempt])
                numbers = draw_numbers(rng, family.ranges)
                drawn.append((i, rng, numbers, draw_slider(rng, numbers)))
        for (i, rng, numbers, slider), motion in zip(drawn, simulate([one[3] for one in drawn]), strict=True):
            family, number = jobs[i]
            truth = truth_of(motion, slider, noise=6.0 * numbers["noise"] + 3.0 * numbers.get("hum", 0.0))
            if truth is None:
                continue
            take = Take(rng=rng, drawn=numbers, slider=slider, truth=truth)
            sense(take, motion, family.faults)
            if take.truth.status == family.expects:
                done[i] = Recording(
                    name=f"{family.name}-{number:03d}", family=family.name, tier=family.tier, truth=take.truth,
                    time_s=frozen_array(take.time_s), force_N=frozen_array(take.force_N),
                    loaded_s=_loaded_s(slider, truth.time_s if truth.status is Status.OK else np.inf),
                    calibration=take.calibration, saturation=take.saturation,
                )  # fmt: skip
        if len(done) == len(jobs):
            break
    yield from (done[i] for i in sorted(done))
