"""The logger stopped, or was triggered, after a few samples."""

import numpy as np

from ropefric.rig.faults.fault import Fault, Samples, Setup
from ropefric.traces.breakaway import Status

__all__ = ["FAULT"]


def _apply(samples: Samples, setup: Setup, rng: np.random.Generator) -> Samples:  # noqa: ARG001
    n = int(rng.integers(5, 50))
    return Samples(time_s=samples.time_s[:n].copy(), counts=samples.counts[:n].copy())


FAULT = Fault(
    name="too-short",
    meaning="the recording ends after 5 to 49 samples, still idle",
    expected_status=Status.TOO_SHORT,
    rate=0.005,
    on_samples=_apply,
)
