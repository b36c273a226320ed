"""A loose shield: four times the noise."""

from dataclasses import replace

import numpy as np

from ropefric.rig.faults.fault import Fault, Setup
from ropefric.rig.settings import Bench

__all__ = ["FAULT"]

FACTOR = 4.0


def _apply(setup: Setup, bench: Bench, rng: np.random.Generator) -> Setup:  # noqa: ARG001
    louder = replace(setup.sensor, noise_counts=FACTOR * setup.sensor.noise_counts)
    return Setup(story=setup.story, sensor=louder)


FAULT = Fault(
    name="noisy",
    meaning="four times the noise",
    expected_status=None,
    rate=0.01,
    on_setup=_apply,
)
