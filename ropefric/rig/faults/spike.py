"""Electrical spikes of one or two samples."""

import numpy as np

from ropefric.rig.faults.fault import Fault, Samples, Setup, near

__all__ = ["FAULT"]

NEAR_S = 0.03


def _apply(samples: Samples, setup: Setup, rng: np.random.Generator) -> Samples:
    counts = samples.counts.copy()
    top = setup.sensor.adc.max_count
    first, last = near(samples.time_s, setup, NEAR_S)
    for _ in range(int(rng.integers(1, 4))):
        # The motor is loudest when it works hardest: one spike in four falls close to the peak.
        close = last > first and rng.random() < 0.25
        at = int(rng.integers(first, last) if close else rng.integers(counts.size))
        size = top * rng.uniform(0.03, 1.0) * rng.choice((-1.0, 1.0))
        span = slice(at, at + int(rng.integers(1, 3)))
        counts[span] = np.clip(np.rint(counts[span] + size), 0, top)
    return Samples(time_s=samples.time_s, counts=counts)


FAULT = Fault(
    name="spike",
    meaning="one to three spikes of one or two samples, up to full scale",
    expected_status=None,
    rate=0.07,
    on_samples=_apply,
)
