"""The PRTH bench: its settings, its chain from force to ADC counts, what happens to the rope, and the force it makes."""

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from itertools import accumulate
from math import nan
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.registry import Registry
from ropefric.traces.breakaway import Phase, Status
from ropefric.traces.calibration import Adc, ForceCell

_SETTLED_S = 0.03  # after break-away from which the sliding force counts as kinetic
_RELAXATION_S = 0.4  # in which a held rope relaxes
_ONSET_S = 0.05
_TONES, _BAND_HZ = 6, (3.0, 15.0)

Range = tuple[float, float]
"""Lower and upper limit of a quantity that differs from recording to recording (uniform)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Bench:
    """The PRTH test bench: load cell at the rope's fixed end, weights at the other, a motor on the wheel.

    A pair is a range; each recording draws its own value from it, uniformly.
    """

    adc: ClassVar[Adc] = Adc()
    cells: ClassVar[tuple[ForceCell, ...]] = (
        ForceCell(name="K1", full_scale_N=1000.0),
        ForceCell(name="K5", full_scale_N=5000.0),
    )
    sampling_rate_Hz: float = 3000.0
    cell_use: float = 0.8
    rope_stiffness_N_m: float = 1.0e5
    cell_stiffness_N_m: float = 1.0e7
    moving_mass_kg: float = 0.12
    stiffness_factor: Range = (0.5, 2.0)
    damping_ratio: Range = (0.25, 0.5)
    trial_scatter: float = 0.017
    condition_scatter: float = 0.0
    idle_s: Range = (0.3, 0.6)
    hang_s: Range = (0.1, 0.25)
    dwell_s: Range = (0.3, 0.8)
    load_s: Range = (1.0, 2.0)
    slide_s: Range = (0.7, 1.1)
    off_s: Range = (0.2, 0.3)
    release_s: Range = (0.02, 0.06)
    pretension: Range = (0.7, 1.0)
    bounce: Range = (0.05, 0.25)
    bounce_Hz: Range = (4.0, 10.0)
    soft_start: Range = (0.05, 0.2)
    micro_slip: Range = (0.02, 0.1)
    micro_slip_loss: Range = (0.0, 0.4)
    kinetic_ratio: Range = (0.75, 0.93)
    tooth_height: Range = (0.1, 0.8)
    tooth_Hz: Range = (5.0, 25.0)
    kinetic_drift: float = 0.02
    zero_counts: Range = (6.0, 15.0)
    noise_counts: Range = (0.3, 1.0)
    zero_drift_counts: float = 0.2

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if item.type == Range and not 0.0 <= value[0] <= value[1] < math.inf:
                message = f"{item.name} = {value} is not a range: lower and upper limit, neither negative"
                raise InputError(message, key=item.name)
        for key in ("sampling_rate_Hz", "rope_stiffness_N_m", "cell_stiffness_N_m", "moving_mass_kg"):
            if not 0.0 < getattr(self, key) < math.inf:
                raise InputError(f"{key} = {getattr(self, key)} is not a positive number", key=key)
        if not self.cells:
            raise InputError("the bench has no force cell", key="cells")

    def cell_for(self, lift_force_N: float) -> ForceCell:
        """Return the smallest cell that measures a lift force with headroom, or the largest there is."""
        good = (cell for cell in self.cells if lift_force_N <= self.cell_use * cell.full_scale_N)
        return next(good, self.cells[-1])

    def cell_named(self, name: str) -> ForceCell:
        """Return the cell of that name."""
        return Registry("force cell", self.cells)[name]

    def natural_frequency_Hz(self, stiffness_factor: float) -> float:
        """Return the frequency at which the rope snaps back, √(k/m)/2π with rope and cell in series [Hz]."""
        rope_N_m = stiffness_factor * self.rope_stiffness_N_m
        series_N_m = 1.0 / (1.0 / rope_N_m + 1.0 / self.cell_stiffness_N_m)
        return math.sqrt(series_N_m / self.moving_mass_kg) / (2.0 * math.pi)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """The measuring chain of one recording, with its imperfections.

    Written on its own, as the physics goes, so that it can test `ropefric.traces.calibration`, which goes the
    other way.
    """

    cell: ForceCell
    adc: Adc
    zero_counts: float = 0.0
    drift_counts: float = 0.0
    noise_counts: float = 0.0
    hum_counts: float = 0.0
    hum_Hz: float = 50.0
    hum_phase_rad: float = 0.0

    @property
    def ceiling_N(self) -> float:
        """Return the force that takes the converter to its largest count [N], drift and noise aside."""
        line = self.cell.line
        top_V = self.adc.high_V - self.zero_counts * self.adc.lsb_V
        return (top_V - line.zero_V) * line.gain_N_V

    def ideal_counts(self, force_N: FloatArray, time_s: FloatArray) -> FloatArray:
        """Return what the converter is given, in counts: neither noisy nor rounded nor clipped."""
        line = self.cell.line
        voltage_V = line.zero_V + force_N / line.gain_N_V
        counts = (voltage_V - self.adc.low_V) / self.adc.lsb_V + self.zero_counts
        if time_s.size > 1:
            counts = counts + self.drift_counts * (time_s - time_s[0]) / (time_s[-1] - time_s[0])
        if self.hum_counts:
            counts = counts + self.hum_counts * np.sin(2 * np.pi * self.hum_Hz * time_s + self.hum_phase_rad)
        return np.asarray(counts, dtype=np.float64)

    def read(self, force_N: FloatArray, time_s: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Return ADC counts: ideal counts with noise, rounded and clipped to the converter's range."""
        counts = self.ideal_counts(force_N, time_s)
        counts += self.noise_counts * rng.standard_normal(counts.size)
        return np.clip(np.rint(counts), 0, self.adc.max_count)


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingTruth:
    """Truth of one simulated recording, before noise, conversion and damage; NaN where there is none."""

    status: Status
    lift_force_N: float
    breakaway_time_s: float = nan
    kinetic_N: float = nan
    faults: tuple[str, ...] = ()
    cell: str = ""
    dwell_s: float = nan
    tooth_tops_N: tuple[float, ...] = ()
    tooth_times_s: tuple[float, ...] = ()
    phases: tuple[Phase, ...] = ()


def draw_roughness(rng: np.random.Generator, std_N: float) -> Callable[[FloatArray], FloatArray]:
    """Return the force [N] of tones between 3 and 15 Hz, of a standard deviation, at times since sliding began [s]."""
    amplitude_N = std_N * np.sqrt(2.0 * rng.dirichlet(np.full(_TONES, 3.0)))
    frequency_Hz, phase_rad = rng.uniform(*_BAND_HZ, _TONES), rng.uniform(0.0, 2.0 * np.pi, _TONES)

    def force_N(elapsed_s: FloatArray) -> FloatArray:
        angle = 2.0 * np.pi * np.multiply.outer(elapsed_s, frequency_Hz) + phase_rad
        return np.asarray(-np.expm1(-elapsed_s / _ONSET_S) * (np.sin(angle) @ amplitude_N))

    return force_N


class Snap(NamedTuple):
    """How the force falls when the rope slips: a mass on a spring, released."""

    natural_Hz: float
    damping_ratio: float

    def remaining(self, elapsed_s: FloatArray) -> FloatArray:
        """Return the part of the fall still to come: 1 at the slip, with slope 0, then a decaying overshoot.

        Solves x'' + 2ζω x' + ω² x = 0, x(0) = 1, x'(0) = 0.
        """
        omega = 2.0 * np.pi * self.natural_Hz
        zeta = self.damping_ratio
        root = np.sqrt(1.0 - zeta**2)
        phase = omega * root * elapsed_s
        answer = np.exp(-zeta * omega * elapsed_s) * (np.cos(phase) + zeta / root * np.sin(phase))
        return np.asarray(answer, dtype=np.float64)


class Teeth(NamedTuple):
    """Stick-slip teeth after break-away, as deviations from the kinetic level.

    Tooth 0 is the break-away itself: its top is reached by the loading, not by a reload.
    """

    time_s: FloatArray
    top_N: FloatArray
    bottom_N: FloatArray

    def scaled(self, factor: float) -> "Teeth":
        """Return teeth that slip at the same times and are scaled in height."""
        return Teeth(time_s=self.time_s, top_N=factor * self.top_N, bottom_N=factor * self.bottom_N)

    def force_N(self, elapsed_s: FloatArray, snap: Snap) -> FloatArray:
        """Return the deviation from the kinetic level at times after break-away [N].

        Continuous: what an earlier snap still rings with when the next top is due is taken off the reload.
        """
        period_s = np.diff(self.time_s)
        fall_N = (self.top_N - self.bottom_N)[:-1]
        left = snap.remaining(period_s)
        slope_N_s = (self.top_N[1:] - self.bottom_N[:-1] - fall_N * left) / (period_s * (1.0 - left))
        tooth = np.clip(np.searchsorted(self.time_s, elapsed_s, side="right") - 1, 0, period_s.size - 1)
        since_s = elapsed_s - self.time_s[tooth]
        left = snap.remaining(since_s)
        # The reload sets in as the fall does its work, so that no top is passed after its slip has begun.
        reload_N = slope_N_s[tooth] * since_s * (1.0 - left)
        return self.bottom_N[tooth] + reload_N + fall_N[tooth] * left


def lay_teeth(*, top_N: FloatArray, bottom_N: FloatArray, reload_N_s: float) -> Teeth:
    """Return teeth that follow each other as the reload allows: stiffness times speed, the same for all."""
    time_s = np.concatenate(([0.0], np.cumsum((top_N[1:] - bottom_N[:-1]) / reload_N_s)))
    return Teeth(time_s=time_s, top_N=top_N, bottom_N=bottom_N)


def draw_teeth(
    rng: np.random.Generator, *, drop_N: float, height_N: float, rate_Hz: float, lasting_s: float
) -> Teeth:
    """Return jittered teeth of a mean height and rate that last at least some time."""
    n = int(2.0 * lasting_s * rate_Hz) + 4
    top_N = 0.5 * height_N * rng.uniform(0.5, 1.5, n)
    bottom_N = -0.5 * height_N * rng.uniform(0.7, 1.3, n)
    top_N[0] = drop_N
    return lay_teeth(top_N=top_N, bottom_N=bottom_N, reload_N_s=height_N * rate_Hz)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BreakawayPull:
    """One recording of the PRTH bench: idle, weights hung, dwell, motor ramp, break-away, sliding, motor off."""

    hang_s: float
    settle_s: float
    ramp_s: float
    breakaway_s: float
    off_s: float
    end_s: float
    pretension_N: float
    bounce_N: float
    bounce_Hz: float
    bounce_decay_s: float
    lift_force_N: float
    ramp_top_N: float
    soft_start: float
    micro_slip: float
    micro_slip_loss: float
    kinetic_N: float
    drift: float
    teeth: Teeth
    snap: Snap
    holding_N: float
    release_s: float
    roughness: Callable[[FloatArray], FloatArray] | None = None
    hold_loss: float = 0.0
    has_peak: bool = True

    def raised(self, factor: float) -> "BreakawayPull":
        """Return the pull with static and kinetic friction scaled."""
        forces = ("lift_force_N", "ramp_top_N", "kinetic_N", "holding_N")
        raised: dict[str, Any] = {name: factor * getattr(self, name) for name in forces}
        return replace(self, teeth=self.teeth.scaled(factor), **raised)

    @property
    def breaks_away(self) -> bool:
        """Return whether the ramp reaches the static friction."""
        return self.ramp_top_N >= self.lift_force_N

    def force_N(self, time_s: FloatArray) -> FloatArray:
        """Return the true force at increasing times [N]."""
        limits = (self.hang_s, self.settle_s, self.ramp_s, self.breakaway_s, self.off_s)
        hang, settle, ramp, slip, off = np.searchsorted(time_s, limits, side="left").tolist()
        force_N = np.zeros_like(time_s)
        rise = (time_s[hang:settle] - self.hang_s) / (self.settle_s - self.hang_s)
        force_N[hang:settle] = self.pretension_N * 0.5 * (1.0 - np.cos(np.pi * rise))
        force_N[settle:ramp] = self.pretension_N
        force_N[ramp:slip] = self._loading_N(time_s[ramp:slip])
        force_N[settle:slip] += self._bounce_N(time_s[settle:slip])
        force_N[slip:off] = self._after_ramp_N(time_s[slip:off])
        last_N = float(self._after_ramp_N(np.array([self.off_s]))[0])
        released = np.exp(-(time_s[off:] - self.off_s) / self.release_s)
        force_N[off:] = self.holding_N + (last_N - self.holding_N) * released
        return force_N

    def _bounce_N(self, time_s: FloatArray) -> FloatArray:
        elapsed_s = time_s - self.settle_s
        swing = np.sin(2.0 * np.pi * self.bounce_Hz * elapsed_s)
        # Faded to exactly nothing by break-away, which must happen at the static friction and nowhere else.
        fade = 1.0 - elapsed_s / (self.breakaway_s - self.settle_s)
        return np.asarray(self.bounce_N * fade * np.exp(-elapsed_s / self.bounce_decay_s) * swing)

    def _loading_N(self, time_s: FloatArray) -> FloatArray:
        """Return the ramp: its slope grows over the soft start, is steady, and falls while the slip arc grows."""
        a, b, loss = self.soft_start, 1.0 - self.micro_slip, self.micro_slip_loss
        u = (time_s - self.ramp_s) / (self.breakaway_s - self.ramp_s)
        late = np.maximum(u - b, 0.0)
        risen = np.where(u < a, u**2 / (2.0 * a), u - 0.5 * a) - loss * late**2 / (2.0 * (1.0 - b))
        whole = 1.0 - 0.5 * a - 0.5 * loss * (1.0 - b)
        return np.asarray(self.pretension_N + (self.ramp_top_N - self.pretension_N) * risen / whole)

    def _after_ramp_N(self, time_s: FloatArray) -> FloatArray:
        elapsed_s = time_s - self.breakaway_s
        if not self.breaks_away:
            relaxed = -np.expm1(-elapsed_s / _RELAXATION_S)
            return np.asarray(self.ramp_top_N * (1.0 - self.hold_loss * relaxed))
        part = elapsed_s / (self.off_s - self.breakaway_s)
        # A straight drift would be a trend line any fit removes; half a sine on it is still slow.
        drift = self.drift * (part + 0.2 * np.sin(np.pi * part)) / 1.03
        rough_N = self.teeth.force_N(elapsed_s, self.snap)
        if self.roughness is not None:
            rough_N = rough_N + self.roughness(elapsed_s)
        return np.asarray(self.kinetic_N * (1.0 + drift) + rough_N)

    def truth(self) -> RecordingTruth:
        """Return what a perfect reading of this recording would find."""
        ends_s = (self.hang_s, self.breakaway_s, self.off_s, self.end_s)
        names = ("idle", "loading", "sliding" if self.breaks_away else "held", "unloading")
        spans = zip(names, (0.0, *ends_s), ends_s, strict=False)
        phases = tuple(Phase(name=name, start_s=start_s, end_s=end_s) for name, start_s, end_s in spans)
        dwell_s = self.ramp_s - self.settle_s
        held: dict[str, Any] = {"lift_force_N": self.lift_force_N, "dwell_s": dwell_s, "phases": phases}
        if not self.breaks_away:
            return RecordingTruth(status=Status.NO_BREAKAWAY, **held)
        sliding_s = np.linspace(min(self.breakaway_s + _SETTLED_S, self.off_s), self.off_s, 4001)
        held["kinetic_N"] = float(self._after_ramp_N(sliding_s).mean())
        if not self.has_peak:
            return RecordingTruth(status=Status.NO_PEAK, **held)
        top_s = self.teeth.time_s[self.teeth.time_s < self.off_s - self.breakaway_s] + self.breakaway_s
        held["tooth_tops_N"] = tuple(self._after_ramp_N(top_s).tolist())
        held["tooth_times_s"] = tuple(top_s.tolist())
        return RecordingTruth(status=Status.OK, breakaway_time_s=self.breakaway_s, **held)


def draw_breakaway(
    bench: Bench, lift_force_N: float, end_tension_N: float, rng: np.random.Generator
) -> BreakawayPull:
    """Return what happens in one recording, drawn from the bench; it breaks away at exactly `lift_force_N`."""
    spans = (bench.idle_s, bench.hang_s, bench.dwell_s, bench.load_s, bench.slide_s, bench.off_s)
    lasting_s = [rng.uniform(*span) for span in spans]
    ends_s = list(accumulate(lasting_s))
    # The cell cannot read more than the static friction before the pull, however the weights bounce.
    pretension_N = min(end_tension_N * rng.uniform(*bench.pretension), 0.9 * lift_force_N)
    bounce_N = min(pretension_N * rng.uniform(*bench.bounce), 0.6 * (lift_force_N - pretension_N))
    kinetic_N = lift_force_N * rng.uniform(*bench.kinetic_ratio)
    drop_N = lift_force_N - kinetic_N
    drawn: dict[str, Any] = {"bounce_Hz": rng.uniform(*bench.bounce_Hz)}  # in the order of the draws
    drawn["bounce_decay_s"] = lasting_s[2] * rng.uniform(0.1, 0.2)
    for key in ("soft_start", "micro_slip", "micro_slip_loss"):
        drawn[key] = rng.uniform(*getattr(bench, key))
    drawn["drift"] = bench.kinetic_drift * rng.uniform(-1.0, 1.0)
    height_N, rate_Hz = drop_N * rng.uniform(*bench.tooth_height), rng.uniform(*bench.tooth_Hz)
    sliding_s = ends_s[4] - ends_s[3]
    drawn["teeth"] = draw_teeth(rng, drop_N=drop_N, height_N=height_N, rate_Hz=rate_Hz, lasting_s=sliding_s)
    natural_Hz = bench.natural_frequency_Hz(rng.uniform(*bench.stiffness_factor))
    drawn["snap"] = Snap(natural_Hz=natural_Hz, damping_ratio=rng.uniform(*bench.damping_ratio))
    drawn |= zip(("hang_s", "settle_s", "ramp_s", "breakaway_s", "off_s", "end_s"), ends_s, strict=True)
    drawn["holding_N"] = pretension_N + (kinetic_N - pretension_N) * rng.uniform(0.3, 0.8)
    drawn |= {"release_s": rng.uniform(*bench.release_s), "pretension_N": pretension_N, "bounce_N": bounce_N}
    return BreakawayPull(lift_force_N=lift_force_N, ramp_top_N=lift_force_N, kinetic_N=kinetic_N, **drawn)
