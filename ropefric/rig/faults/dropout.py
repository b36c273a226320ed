"""Samples the logger lost."""

import numpy as np

from ropefric.rig.faults.fault import Fault, Samples, Setup, near

__all__ = ["FAULT"]

CLEAR_S = 0.012
LONGEST = 30


def _apply(samples: Samples, setup: Setup, rng: np.random.Generator) -> Samples:
    counts = samples.counts.copy()
    first, last = near(samples.time_s, setup, CLEAR_S)
    for _ in range(int(rng.integers(1, 3))):
        length = int(rng.integers(1, LONGEST + 1))
        starts = np.arange(1, counts.size - length)
        # The peak itself stays: losing it is another matter.
        starts = starts[(starts + length <= first) | (starts >= last)]
        if not starts.size:
            continue
        at = int(rng.choice(starts))
        lost = slice(at, at + length)
        counts[lost] = np.nan if rng.random() < 0.6 else counts[at - 1]
    return Samples(time_s=samples.time_s, counts=counts)


FAULT = Fault(
    name="dropout",
    meaning="one or two gaps of up to 30 samples, empty or stuck at the last value; never at the peak",
    expected_status=None,
    rate=0.03,
    on_samples=_apply,
)
