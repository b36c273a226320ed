"""Static and kinetic friction are the same: a rounded knee into rough sliding, no peak.

Sliding without any roughness could not be told from a held rope by the force alone; nobody has measured such a rope.
"""

from dataclasses import replace

import numpy as np

from ropefric.rig.faults.fault import Fault, Setup, breakaway_story
from ropefric.rig.settings import Bench
from ropefric.rig.wander import draw_wander
from ropefric.traces.breakaway import Status

__all__ = ["FAULT"]

ROUGHNESS = (0.007, 0.02)  # standard deviation of the sliding force over the force; dry seals show 2-6 %


def _apply(setup: Setup, bench: Bench, rng: np.random.Generator) -> Setup:  # noqa: ARG001
    """Let the whole slope be lost to micro-slip, and slide on roughly at the force reached, without teeth."""
    story = breakaway_story(setup, FAULT.name)
    nothing_N = np.zeros_like(story.teeth.top_N)
    smooth = replace(
        story,
        micro_slip=rng.uniform(0.15, 0.4),
        micro_slip_loss=1.0,
        kinetic_N=story.lift_force_N,
        drift=rng.uniform(0.0, 0.015),
        wander=draw_wander(rng, story.lift_force_N * rng.uniform(*ROUGHNESS)),
        teeth=replace(story.teeth, top_N=nothing_N, bottom_N=nothing_N),
        has_peak=False,
    )
    return Setup(story=smooth, sensor=setup.sensor)


FAULT = Fault(
    name="no-peak",
    meaning="the loading rounds off into rough sliding; no static peak",
    expected_status=Status.NO_PEAK,
    rate=0.01,
    protocols=("breakaway",),
    on_setup=_apply,
)
