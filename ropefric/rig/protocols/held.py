"""Plateaus held by hand on the slack side, load after load."""

from dataclasses import dataclass

import numpy as np

from ropefric.rig.protocols.protocol import RigProtocol
from ropefric.rig.settings import Bench
from ropefric.rig.truth import RecordingTruth
from ropefric.traces.breakaway import Phase, Status
from ropefric.traces.trace import FloatArray

__all__ = ["PROTOCOL", "HeldStory"]

CYCLES = 3
JERKS = 5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HeldStory:
    """One recording of a spring scale on the slack side: pulled in jerks, held, let go, several times.

    Attributes
    ----------
    knot_s, knot_N : ndarray, shape (m,)
        Corners of the pull and release, joined by straight lines.
    hold_s : ndarray, shape (cycles, 2)
        When each plateau starts and ends [s].
    creep_N, creep_s : ndarray, shape (cycles,)
        Excess at the start of each plateau [N] and the time in which it dies away [s].
    plateau_N : ndarray, shape (cycles,)
        Force each plateau settles to [N].
    lift_force_N : float
        The weight on the tight side [N].
    end_s : float
        The end [s].
    """

    knot_s: FloatArray
    knot_N: FloatArray
    hold_s: FloatArray
    creep_N: FloatArray
    creep_s: FloatArray
    plateau_N: FloatArray
    lift_force_N: float
    end_s: float

    def force_N(self, time_s: FloatArray) -> FloatArray:
        """Return the true force on the slack side [N]."""
        force_N = np.interp(time_s, self.knot_s, self.knot_N)
        for (start_s, end_s), creep_N, creep_s, plateau_N in zip(
            self.hold_s, self.creep_N, self.creep_s, self.plateau_N, strict=True
        ):
            held = (time_s >= start_s) & (time_s < end_s)
            force_N[held] = plateau_N + creep_N * np.exp(-(time_s[held] - start_s) / creep_s)
        return force_N

    def truth(self) -> RecordingTruth:
        """Return the plateaus and when they were held."""
        return RecordingTruth(
            status=Status.OK,
            lift_force_N=self.lift_force_N,
            plateaus_N=tuple(self.plateau_N.tolist()),
            phases=tuple(Phase(name="held", start_s=a, end_s=b) for a, b in self.hold_s.tolist()),
        )


def _draw(bench: Bench, lift_force_N: float, end_tension_N: float, rng: np.random.Generator) -> HeldStory:
    plateau_N = end_tension_N * (1.0 + bench.trial_scatter * rng.standard_normal(CYCLES))
    creep_N = plateau_N * rng.uniform(0.005, 0.015, CYCLES)
    now_s = rng.uniform(*bench.idle_s)
    knot_s, knot_N, hold_s = [0.0, now_s], [0.0, 0.0], []
    for level_N, excess_N in zip(plateau_N, creep_N, strict=True):
        # A hand pulls in jerks: quick rises with short rests between them.
        lasting_s = rng.uniform(*bench.load_s)
        steps = np.sort(rng.uniform(0.1, 0.9, JERKS))
        for number, part in enumerate(np.append(steps, 1.0)):
            arrive_s = now_s + lasting_s * (number + 0.4) / (JERKS + 1)
            knot_s += [arrive_s, now_s + lasting_s * (number + 1) / (JERKS + 1)]
            knot_N += [part * (level_N + excess_N)] * 2
        start_s = knot_s[-1]
        end_s = start_s + rng.uniform(*bench.dwell_s)
        let_go_s = end_s + rng.uniform(0.3, 0.8)
        now_s = let_go_s + rng.uniform(*bench.slide_s)
        slack_N = level_N * rng.uniform(0.01, 0.05)
        knot_s += [end_s, let_go_s, now_s]
        knot_N += [level_N, slack_N, slack_N]
        hold_s.append((start_s, end_s))
    return HeldStory(
        knot_s=np.array(knot_s),
        knot_N=np.array(knot_N),
        hold_s=np.array(hold_s),
        creep_N=creep_N,
        creep_s=rng.uniform(0.5, 1.2, CYCLES),
        plateau_N=plateau_N,
        lift_force_N=lift_force_N,
        end_s=now_s,
    )


PROTOCOL = RigProtocol(
    name="held",
    meaning="plateaus held on the slack side, several loads a recording",
    scatters_inside=True,
    measures_lift=False,
    draw=_draw,
)
