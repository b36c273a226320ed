"""The sliding force climbs until it is above the break-away."""

from dataclasses import replace

import numpy as np

from ropefric.rig.faults.fault import Fault, Setup, breakaway_story
from ropefric.rig.settings import Bench

__all__ = ["FAULT"]


def _apply(setup: Setup, bench: Bench, rng: np.random.Generator) -> Setup:  # noqa: ARG001
    story = breakaway_story(setup, FAULT.name)
    # `drift` counts 1/1.03 of itself at the end, see BreakawayStory.
    climb = 1.03 * (rng.uniform(1.03, 1.08) * story.lift_force_N / story.kinetic_N - 1.0)
    return Setup(story=replace(story, drift=climb), sensor=setup.sensor)


FAULT = Fault(
    name="drift",
    meaning="the sliding level climbs slowly to 3 to 8 % above the break-away",
    expected_status=None,
    rate=0.02,
    protocols=("breakaway",),
    on_setup=_apply,
)
