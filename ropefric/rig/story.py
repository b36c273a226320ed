"""What happens in one break-away recording, and the force it makes: closed forms, one piece after the other."""

import math
from dataclasses import dataclass

import numpy as np

from ropefric.rig.teeth import Snap, Teeth
from ropefric.rig.truth import RecordingTruth
from ropefric.rig.wander import NO_WANDER, Wander
from ropefric.traces.breakaway import Phase, Status
from ropefric.traces.trace import FloatArray

__all__ = ["BreakawayStory"]

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
