"""Ways of running the virtual rig: one break-away a recording, slow stick-slip, plateaus held on the slack side."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol as TypingProtocol

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.registry import Registry
from ropefric.rig.settings import Bench
from ropefric.rig.story import BreakawayStory, RecordingTruth, Snap, Teeth, lay_teeth
from ropefric.traces.breakaway import Phase, Status


class Story(TypingProtocol):
    """What happens in one recording."""

    @property
    def end_s(self) -> float:
        """The end of the recording [s]."""
        ...

    def force_N(self, time_s: FloatArray) -> FloatArray:
        """Return the true force [N]."""
        ...

    def truth(self) -> RecordingTruth:
        """Return what is true of it."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class RigProtocol:
    """A way of running the rig."""

    name: str
    meaning: str
    scatters_inside: bool
    measures_lift: bool
    draw: Callable[[Bench, float, float, np.random.Generator], Story]


def draw_teeth(
    rng: np.random.Generator, *, drop_N: float, height_N: float, rate_Hz: float, lasting_s: float
) -> Teeth:
    """Return jittered teeth of a mean height and rate that last at least some time."""
    n = int(2.0 * lasting_s * rate_Hz) + 4
    half_N = 0.5 * height_N
    top_N = half_N * rng.uniform(0.5, 1.5, n)
    bottom_N = -half_N * rng.uniform(0.7, 1.3, n)
    top_N[0] = drop_N
    return lay_teeth(top_N=top_N, bottom_N=bottom_N, reload_N_s=height_N * rate_Hz)


def draw_breakaway(
    bench: Bench, lift_force_N: float, end_tension_N: float, rng: np.random.Generator
) -> BreakawayStory:
    """Return what happens in one recording, drawn from the bench; it breaks away at exactly `lift_force_N`."""
    hang_s = rng.uniform(*bench.idle_s)
    settle_s = hang_s + rng.uniform(*bench.hang_s)
    dwell_s = rng.uniform(*bench.dwell_s)
    ramp_s = settle_s + dwell_s
    breakaway_s = ramp_s + rng.uniform(*bench.load_s)
    off_s = breakaway_s + rng.uniform(*bench.slide_s)
    end_s = off_s + rng.uniform(*bench.off_s)
    # The cell cannot read more than the static friction before the pull, however the weights bounce.
    pretension_N = min(end_tension_N * rng.uniform(*bench.pretension), 0.9 * lift_force_N)
    bounce_N = min(pretension_N * rng.uniform(*bench.bounce), 0.6 * (lift_force_N - pretension_N))
    kinetic_N = lift_force_N * rng.uniform(*bench.kinetic_ratio)
    drop_N = lift_force_N - kinetic_N
    return BreakawayStory(
        hang_s=hang_s,
        settle_s=settle_s,
        ramp_s=ramp_s,
        breakaway_s=breakaway_s,
        off_s=off_s,
        end_s=end_s,
        pretension_N=pretension_N,
        bounce_N=bounce_N,
        bounce_Hz=rng.uniform(*bench.bounce_Hz),
        bounce_decay_s=dwell_s * rng.uniform(0.1, 0.2),
        lift_force_N=lift_force_N,
        ramp_top_N=lift_force_N,
        soft_start=rng.uniform(*bench.soft_start),
        micro_slip=rng.uniform(*bench.micro_slip),
        micro_slip_loss=rng.uniform(*bench.micro_slip_loss),
        kinetic_N=kinetic_N,
        drift=bench.kinetic_drift * rng.uniform(-1.0, 1.0),
        teeth=draw_teeth(
            rng,
            drop_N=drop_N,
            height_N=drop_N * rng.uniform(*bench.tooth_height),
            rate_Hz=rng.uniform(*bench.tooth_Hz),
            lasting_s=off_s - breakaway_s,
        ),
        snap=Snap(
            natural_Hz=bench.natural_frequency_Hz(rng.uniform(*bench.stiffness_factor)),
            damping_ratio=rng.uniform(*bench.damping_ratio),
        ),
        holding_N=pretension_N + (kinetic_N - pretension_N) * rng.uniform(0.3, 0.8),
        release_s=rng.uniform(*bench.release_s),
    )


_BREAKAWAY = RigProtocol(
    name="breakaway",
    meaning="one static peak a recording, then sliding",
    scatters_inside=False,
    measures_lift=True,
    draw=draw_breakaway,
)


_TEETH = (8, 16)
_TEETH_HZ = (2.0, 6.0)


def _draw_stick_slip(
    bench: Bench, lift_force_N: float, end_tension_N: float, rng: np.random.Generator
) -> BreakawayStory:
    n = int(rng.integers(_TEETH[0], _TEETH[1], endpoint=True))
    tops_N = lift_force_N * (1.0 + bench.trial_scatter * rng.standard_normal(n + 1))
    story = draw_breakaway(bench, float(tops_N[0]), end_tension_N, rng)
    drop_N = story.lift_force_N - story.kinetic_N
    # Static tops stand on the static friction, not on the kinetic level, so that level must not drift here.
    teeth = lay_teeth(
        top_N=tops_N - story.kinetic_N,
        bottom_N=-drop_N * rng.uniform(0.6, 1.0, n + 1),
        reload_N_s=1.8 * drop_N * rng.uniform(*_TEETH_HZ),
    )
    off_s = story.breakaway_s + float(teeth.time_s[-2] + 0.7 * (teeth.time_s[-1] - teeth.time_s[-2]))
    end_s = off_s + (story.end_s - story.off_s)
    return replace(story, teeth=teeth, drift=0.0, off_s=off_s, end_s=end_s)


_STICK_SLIP = RigProtocol(
    name="stick-slip",
    meaning="slow teeth after the first break-away, each a trial",
    scatters_inside=True,
    measures_lift=True,
    draw=_draw_stick_slip,
)


_CYCLES = 3
_JERKS = 5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HeldStory:
    """One recording of a spring scale on the slack side: pulled in jerks, held, let go, several times."""

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


def _draw_held(
    bench: Bench, lift_force_N: float, end_tension_N: float, rng: np.random.Generator
) -> HeldStory:
    plateau_N = end_tension_N * (1.0 + bench.trial_scatter * rng.standard_normal(_CYCLES))
    creep_N = plateau_N * rng.uniform(0.005, 0.015, _CYCLES)
    now_s = rng.uniform(*bench.idle_s)
    knot_s, knot_N, hold_s = [0.0, now_s], [0.0, 0.0], []
    for level_N, excess_N in zip(plateau_N, creep_N, strict=True):
        # A hand pulls in jerks: quick rises with short rests between them.
        lasting_s = rng.uniform(*bench.load_s)
        steps = np.sort(rng.uniform(0.1, 0.9, _JERKS))
        for number, part in enumerate(np.append(steps, 1.0)):
            arrive_s = now_s + lasting_s * (number + 0.4) / (_JERKS + 1)
            knot_s += [arrive_s, now_s + lasting_s * (number + 1) / (_JERKS + 1)]
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
        creep_s=rng.uniform(0.5, 1.2, _CYCLES),
        plateau_N=plateau_N,
        lift_force_N=lift_force_N,
        end_s=now_s,
    )


_HELD = RigProtocol(
    name="held",
    meaning="plateaus held on the slack side, several loads a recording",
    scatters_inside=True,
    measures_lift=False,
    draw=_draw_held,
)


RIG_PROTOCOLS: Registry[RigProtocol] = Registry("rig protocol", [_BREAKAWAY, _STICK_SLIP, _HELD])
"""Every protocol by name: `RIG_PROTOCOLS["held"].measures_lift` is False."""
