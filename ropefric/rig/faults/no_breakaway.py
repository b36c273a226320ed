"""The motor gives up before the rope slips."""

from dataclasses import replace

import numpy as np

from ropefric.rig.faults.fault import Fault, Setup, breakaway_story
from ropefric.rig.settings import Bench
from ropefric.traces.breakaway import Status

__all__ = ["FAULT"]


def _apply(setup: Setup, bench: Bench, rng: np.random.Generator) -> Setup:  # noqa: ARG001
    story = breakaway_story(setup, FAULT.name)
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


FAULT = Fault(
    name="no-breakaway",
    meaning="the ramp stops below the static friction and is held, or the recording ends while it rises",
    expected_status=Status.NO_BREAKAWAY,
    rate=0.01,
    protocols=("breakaway",),
    on_setup=_apply,
)
