"""What happens in one break-away recording, and the force it makes: closed forms, one piece after the other."""

import math
from dataclasses import dataclass
from math import nan

import numpy as np

from ropefric.traces.breakaway import Phase, Status
from ropefric.traces.trace import FloatArray, frozen_array

__all__ = [
    "BreakawayStory",
    "RecordingTruth",
    "SimulatedRecording",
    "Snap",
    "Teeth",
    "draw_wander",
    "lay_teeth",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingTruth:
    """What is true of one simulated recording, before noise, conversion and damage; NaN where nothing is.

    Attributes
    ----------
    status : Status
        What an honest reading of the recording must end in.
    lift_force_N : float
        Static friction F_A [N]. Also given where the recording cannot show it: `no-breakaway` (never reached),
        `saturated` (above the ceiling), `no-peak` (the level it slides at).
    breakaway_time_s : float
        When the rope breaks away [s].
    kinetic_N : float
        Mean force while sliding [N], from 30 ms after break-away until the motor is off.
    faults : tuple of str
        Names of the faults put in.
    cell : str
        The force cell used.
    dwell_s : float
        Time under load before the pull [s].
    tooth_tops_N, tooth_times_s : tuple of float
        Top [N] and time [s] of every stick-slip tooth; the first is the break-away.
    plateaus_N : tuple of float
        Protocol `held`: the force each plateau settles to [N].
    phases : tuple of Phase
        What happens when.

    Examples
    --------
    >>> RecordingTruth(status=Status.OK, lift_force_N=320.7).faults
    ()
    """

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
    """One recording of the virtual rig.

    Attributes
    ----------
    time_s : ndarray, shape (n,)
        Time stamps [s] as the logger wrote them; a fault may make them repeat.
    counts : ndarray, shape (n,)
        ADC counts, whole numbers as float64; NaN where a sample is missing.
    true_time_s, true_force_N : ndarray, shape (m,)
        The force on the rope before sensor and damage [N], on the undamaged clock [s].
    truth : RecordingTruth
        What is true of it.
    """

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
    """A sum of tones that sets in with sliding.

    Attributes
    ----------
    amplitude_N, frequency_Hz, phase_rad : ndarray, shape (k,)
        The tones; none for perfectly smooth sliding.
    """

    amplitude_N: FloatArray
    frequency_Hz: FloatArray
    phase_rad: FloatArray

    def force_N(self, elapsed_s: FloatArray) -> FloatArray:
        """Return the force above the level [N] at times since sliding began [s]."""
        angle = 2.0 * np.pi * np.multiply.outer(elapsed_s, self.frequency_Hz) + self.phase_rad
        return np.asarray(-np.expm1(-elapsed_s / ONSET_S) * (np.sin(angle) @ self.amplitude_N))


NO_WANDER = Wander(amplitude_N=np.empty(0), frequency_Hz=np.empty(0), phase_rad=np.empty(0))


def draw_wander(rng: np.random.Generator, std_N: float) -> Wander:
    """Return tones between 3 and 15 Hz whose sum has a standard deviation of `std_N` [N].

    Examples
    --------
    >>> wander = draw_wander(np.random.default_rng(0), 2.0)
    >>> bool(abs(wander.force_N(np.arange(1.0, 60.0, 1e-3)).std() - 2.0) < 0.1)
    True
    """
    share = rng.dirichlet(np.full(TONES, 3.0))
    return Wander(
        amplitude_N=std_N * np.sqrt(2.0 * share),
        frequency_Hz=rng.uniform(*BAND_HZ, TONES),
        phase_rad=rng.uniform(0.0, 2.0 * np.pi, TONES),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Snap:
    """How the force falls when the rope slips: a mass on a spring, released.

    Attributes
    ----------
    natural_Hz : float
        Undamped natural frequency [Hz].
    damping_ratio : float
        Damping ratio [-], below 1.

    Examples
    --------
    >>> Snap(natural_Hz=100.0, damping_ratio=0.3).remaining(np.array([0.0, 0.005])).round(3).tolist()
    [1.0, -0.368]
    """

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

    Attributes
    ----------
    time_s : ndarray, shape (n,)
        When each top is reached [s] after break-away; the first is 0.
    top_N, bottom_N : ndarray, shape (n,)
        The top of each tooth and the level it slips back to, as deviations from the kinetic level [N].

    Examples
    --------
    >>> teeth = lay_teeth(top_N=np.array([9.0, 1, 2]), bottom_N=np.array([-1.0, -1, -1]), reload_N_s=20.0)
    >>> teeth.force_N(np.array([0.0, 0.1, 0.25]), Snap(natural_Hz=100.0, damping_ratio=0.3)).round(6).tolist()
    [9.0, 1.0, 2.0]
    """

    time_s: FloatArray
    top_N: FloatArray
    bottom_N: FloatArray

    def force_N(self, elapsed_s: FloatArray, snap: Snap) -> FloatArray:
        """Return the deviation from the kinetic level at times after break-away [N].

        Continuous: what an earlier snap still rings with when the next top is due is taken off the reload.

        Parameters
        ----------
        elapsed_s : ndarray, shape (m,)
            Times after break-away [s], from 0 to the last tooth.
        snap : Snap
            How each slip falls.
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
    """Return teeth that follow each other as the reload allows: stiffness times speed, the same for all.

    Parameters
    ----------
    top_N, bottom_N : ndarray, shape (n,)
        Tops and bottoms as deviations from the kinetic level [N], n >= 2.
    reload_N_s : float
        Rate at which the force rises between slips [N/s].

    Examples
    --------
    >>> lay_teeth(top_N=np.array([9.0, 1, 2]), bottom_N=np.array([-1.0, -1, -1]), reload_N_s=20.0).time_s
    array([0.  , 0.1 , 0.25])
    """
    period_s = (top_N[1:] - bottom_N[:-1]) / reload_N_s
    return Teeth(time_s=np.concatenate(([0.0], np.cumsum(period_s))), top_N=top_N, bottom_N=bottom_N)


SETTLED_S = 0.03  # after break-away from which the sliding force counts as kinetic
RELAXATION_S = 0.4  # in which a held rope relaxes


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BreakawayStory:
    """One recording of the PRTH bench: idle, weights hung, dwell, motor ramp, break-away, sliding, motor off.

    Attributes
    ----------
    hang_s, settle_s, ramp_s, breakaway_s, off_s, end_s : float
        When the weights are hung, when they hang, when the motor ramp starts, when the rope breaks away (or
        the ramp stops), when the motor goes off, and the end [s].
    pretension_N : float
        Force the cell reads once the weights hang [N].
    bounce_N, bounce_Hz, bounce_decay_s : float
        Amplitude, frequency and decay time of their bounce.
    lift_force_N : float
        Static friction: the force at which the rope breaks away [N].
    ramp_top_N : float
        Force at the end of the ramp [N]; below `lift_force_N` the rope never breaks away.
    soft_start, micro_slip, micro_slip_loss : float
        Shape of the ramp, see `Bench`.
    kinetic_N : float
        Kinetic level right after break-away [N].
    drift : float
        Relative drift of that level by the time the motor goes off.
    teeth : Teeth
        Stick-slip teeth on that level.
    snap : Snap
        How the force falls at each slip.
    holding_N, release_s : float
        Force the standing wheel holds after the motor is off [N], and how fast it is reached [s].
    wander : Wander
        Roughness of sliding beside the teeth.
    hold_loss : float
        Part of `ramp_top_N` the rope relaxes by where the ramp stops short of break-away.
    has_peak : bool
        False where the rope slides without a static peak.
    """

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
        """Return the true force at increasing times [N].

        Parameters
        ----------
        time_s : ndarray, shape (n,)
            Times from 0 to `end_s` [s], increasing.
        """
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
