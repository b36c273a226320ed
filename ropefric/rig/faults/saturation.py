"""The force exceeds what cell and converter can show."""

from dataclasses import replace

import numpy as np

from ropefric.rig.faults.fault import Fault, Setup, breakaway_story
from ropefric.rig.settings import Bench
from ropefric.traces.breakaway import Status

__all__ = ["FAULT", "MARGIN"]

MARGIN = 1.02


def _apply(setup: Setup, bench: Bench, rng: np.random.Generator) -> Setup:
    """Use a cell that is too small; if all are large enough, let the rope jam, which raises F_A itself."""
    story = breakaway_story(setup, FAULT.name)
    sensors = [replace(setup.sensor, cell=cell) for cell in reversed(bench.cells)]
    for sensor in sensors:
        if story.lift_force_N >= MARGIN * sensor.ceiling_N:
            return Setup(story=story, sensor=sensor)
    lift_N = setup.sensor.ceiling_N * rng.uniform(MARGIN, 1.2)
    factor = lift_N / story.lift_force_N
    teeth = replace(story.teeth, top_N=factor * story.teeth.top_N, bottom_N=factor * story.teeth.bottom_N)
    jammed = replace(
        story,
        lift_force_N=lift_N,
        ramp_top_N=lift_N,
        kinetic_N=factor * story.kinetic_N,
        holding_N=factor * story.holding_N,
        teeth=teeth,
    )
    return Setup(story=jammed, sensor=setup.sensor)


FAULT = Fault(
    name="saturation",
    meaning="the break-away force lies above the converter's ceiling",
    expected_status=Status.SATURATED,
    rate=0.01,
    protocols=("breakaway",),
    on_setup=_apply,
)
