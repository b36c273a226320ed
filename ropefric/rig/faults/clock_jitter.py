"""A clock that jitters, or is printed with too few digits."""

import numpy as np

from ropefric.rig.faults.fault import Fault, Samples, Setup

__all__ = ["FAULT"]


def _apply(samples: Samples, setup: Setup, rng: np.random.Generator) -> Samples:  # noqa: ARG001
    time_s = samples.time_s
    if time_s.size > 1:
        step_s = float(time_s[1] - time_s[0])
        if rng.random() < 0.5:
            time_s = time_s + step_s * rng.uniform(-0.4, 0.4, time_s.size)
            time_s = time_s - time_s[0]
        else:
            time_s = np.rint(time_s / (3.0 * step_s)) * (3.0 * step_s)  # three samples share a stamp
    return Samples(time_s=time_s, counts=samples.counts)


FAULT = Fault(
    name="clock-jitter",
    meaning="time stamps jitter by up to 0.4 of a step, or three in a row are the same",
    expected_status=None,
    rate=0.01,
    on_samples=_apply,
)
