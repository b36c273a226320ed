"""A recording at a glance: block means on which phases are told apart before the peak is measured finely."""

from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.traces.noise import noise_std, resolution

BLOCK_S = 0.004
"""Length of a block [s]: a fifth of the shortest stick-slip tooth of such rigs, long enough to average noise."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Glance:
    """Block means of a recording."""

    force_N: FloatArray
    time_s: FloatArray
    size: int
    noise_N: float
    resolution_N: float

    def samples(self, first_block: int, stop_block: int, n_samples: int) -> slice:
        """Return the samples of blocks `first_block` up to `stop_block`, cut to the recording."""
        return slice(self.first_sample(first_block), self.last_sample(stop_block - 1, n_samples) + 1)

    def first_sample(self, block: int) -> int:
        """Return the first sample of a block, or of the first block if there is no such block before it."""
        return max(0, block) * self.size

    def last_sample(self, block: int, n_samples: int) -> int:
        """Return the last sample of a block of a recording of `n_samples`; the last block holds the rest."""
        return n_samples - 1 if block >= self.force_N.size - 1 else max(0, block + 1) * self.size - 1


def glance(time_s: FloatArray, force_N: FloatArray) -> Glance:
    """Return the block means of a recording without gaps in its samples."""
    n = force_N.size
    span_s = float(time_s[-1] - time_s[0])
    size = int(np.clip(round(BLOCK_S * (n - 1) / span_s), 1, max(1, n // 16))) if span_s > 0 else 1
    m = n // size
    body = force_N[: (m - 1) * size].reshape(m - 1, size).mean(axis=1)
    means = np.append(body, force_N[(m - 1) * size :].mean())
    # A converter coarser than its noise repeats itself, so that averaging helps less than by the square root.
    step_N = resolution(force_N)
    return Glance(
        force_N=means,
        time_s=time_s[: m * size : size],
        size=size,
        noise_N=max(noise_std(means), step_N / np.sqrt(12.0 * size)),
        resolution_N=step_N,
    )
