"""What happens in one break-away recording, and the force it makes: closed forms, one piece after the other."""

import math
from dataclasses import dataclass
from math import nan

import numpy as np

from ropefric.arrays import FloatArray, frozen_array
from ropefric.traces.breakaway import Phase, Status


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingTruth:
    """What is true of one simulated recording, before noise, conversion and damage; NaN where nothing is."""

    status: Status
    lift_force_N: float
    breakaway_time_s: float = nan
    kinetic_N: float = nan
    faults: tuple[str, ...] = ()
    cell: str = ""
    dwell_s: float = nan
    tooth_tops_N: tuple[float, ...] = ()
    tooth_times_s: tuple[float, ...] = ()
    plateaus_N: tuple[float, ...] = ()
    phases: tuple[Phase, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SimulatedRecording:
    """One recording of the virtual rig."""

    time_s: FloatArray
    counts: FloatArray
    true_time_s: FloatArray
    true_force_N: FloatArray
    truth: RecordingTruth

    def __post_init__(self) -> None:
        for key in ("time_s", "counts", "true_time_s", "true_force_N"):
            object.__setattr__(self, key, frozen_array(getattr(self, key)))


ONSET_S = 0.05
TONES = 6
BAND_HZ = (3.0, 15.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Wander:
    """A sum of tones that sets in with sliding."""

    amplitude_N: FloatArray
    frequency_Hz: FloatArray
    phase_rad: FloatArray

    def force_N(self, elapsed_s: FloatArray) -> FloatArray:
        """Return the force above the level [N] at times since sliding began [s]."""
        angle = 2.0 * np.pi * np.multiply.outer(elapsed_s, self.frequency_Hz) + self.phase_rad
        return np.asarray(-np.expm1(-elapsed_s / ONSET_S) * (np.sin(angle) @ self.amplitude_N))


NO_WANDER = Wander(amplitude_N=np.empty(0), frequency_Hz=np.empty(0), phase_rad=np.empty(0))


def draw_wander(rng: np.random.Generator, std_N: float) -> Wander:
    """Return tones between 3 and 15 Hz whose sum has a standard deviation of `std_N` [N]."""
    share = rng.dirichlet(np.full(TONES, 3.0))
    return Wander(
        amplitude_N=std_N * np.sqrt(2.0 * share),
        frequency_Hz=rng.uniform(*BAND_HZ, TONES),
        phase_rad=rng.uniform(0.0, 2.0 * np.pi, TONES),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Snap:
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Teeth:
    """Stick-slip teeth after break-away, as deviations from the kinetic level.

    Tooth 0 is the break-away itself: its top is reached by the loading, not by a reload.
    """

    time_s: FloatArray
    top_N: FloatArray
    bottom_N: FloatArray

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
    period_s = (top_N[1:] - bottom_N[:-1]) / reload_N_s
    return Teeth(time_s=np.concatenate(([0.0], np.cumsum(period_s))), top_N=top_N, bottom_N=bottom_N)


SETTLED_S = 0.03  # after break-away from which the sliding force counts as kinetic
RELAXATION_S = 0.4  # in which a held rope relaxes


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BreakawayStory:
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
    wander: Wander = NO_WANDER
    hold_loss: float = 0.0
    has_peak: bool = True

    @property
    def breaks_away(self) -> bool:
        """Return whether the ramp reaches the static friction."""
        return self.ramp_top_N >= self.lift_force_N

    def force_N(self, time_s: FloatArray) -> FloatArray:
        """Return the true force at increasing times [N]."""
        limits = (self.hang_s, self.settle_s, self.ramp_s, self.breakaway_s, self.off_s)
        cuts = np.searchsorted(time_s, limits, side="left").tolist()
        hang, settle, ramp, slip, off = cuts
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
            relaxed = -np.expm1(-elapsed_s / RELAXATION_S)
            return np.asarray(self.ramp_top_N * (1.0 - self.hold_loss * relaxed))
        part = elapsed_s / (self.off_s - self.breakaway_s)
        # A straight drift would be a trend line any fit removes; half a sine on it is still slow.
        drift = self.drift * (part + 0.2 * np.sin(np.pi * part)) / 1.03
        level_N = self.kinetic_N * (1.0 + drift)
        rough_N = self.teeth.force_N(elapsed_s, self.snap) + self.wander.force_N(elapsed_s)
        return np.asarray(level_N + rough_N)

    def truth(self) -> RecordingTruth:
        """Return what a perfect reading of this recording would find."""
        phases = (
            Phase(name="idle", start_s=0.0, end_s=self.hang_s),
            Phase(name="loading", start_s=self.hang_s, end_s=self.breakaway_s),
            Phase(name="sliding" if self.breaks_away else "held", start_s=self.breakaway_s, end_s=self.off_s),
            Phase(name="unloading", start_s=self.off_s, end_s=self.end_s),
        )
        dwell_s = self.ramp_s - self.settle_s
        if not self.breaks_away:
            return RecordingTruth(
                status=Status.NO_BREAKAWAY, lift_force_N=self.lift_force_N, dwell_s=dwell_s, phases=phases
            )
        start_s = min(self.breakaway_s + SETTLED_S, self.off_s)
        sliding_s = np.linspace(start_s, self.off_s, 4001)
        top_s = self.teeth.time_s[self.teeth.time_s < self.off_s - self.breakaway_s] + self.breakaway_s
        return RecordingTruth(
            status=Status.OK if self.has_peak else Status.NO_PEAK,
            lift_force_N=self.lift_force_N,
            breakaway_time_s=self.breakaway_s if self.has_peak else math.nan,
            kinetic_N=float(self._after_ramp_N(sliding_s).mean()),
            tooth_tops_N=tuple(self._after_ramp_N(top_s).tolist()) if self.has_peak else (),
            tooth_times_s=tuple(top_s.tolist()) if self.has_peak else (),
            dwell_s=dwell_s,
            phases=phases,
        )
