"""The roughness of sliding: a force that wanders about its level, too slowly for a slip."""

from dataclasses import dataclass

import numpy as np

from ropefric.traces.trace import FloatArray

__all__ = ["NO_WANDER", "Wander", "draw_wander"]

ONSET_S = 0.05
TONES = 6
BAND_HZ = (3.0, 15.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Wander:
    """A sum of tones that sets in with sliding.

    Attributes
    ----------
    amplitude_N, frequency_Hz, phase_rad : ndarray, shape (k,)
        The tones; none for perfectly smooth sliding.
    """

    amplitude_N: FloatArray
    frequency_Hz: FloatArray
    phase_rad: FloatArray

    def force_N(self, elapsed_s: FloatArray) -> FloatArray:
        """Return the force above the level [N] at times since sliding began [s]."""
        angle = 2.0 * np.pi * np.multiply.outer(elapsed_s, self.frequency_Hz) + self.phase_rad
        return np.asarray(-np.expm1(-elapsed_s / ONSET_S) * (np.sin(angle) @ self.amplitude_N))


NO_WANDER = Wander(amplitude_N=np.empty(0), frequency_Hz=np.empty(0), phase_rad=np.empty(0))


def draw_wander(rng: np.random.Generator, std_N: float) -> Wander:
    """Return tones between 3 and 15 Hz whose sum has a standard deviation of `std_N` [N].

    Examples
    --------
    >>> wander = draw_wander(np.random.default_rng(0), 2.0)
    >>> bool(abs(wander.force_N(np.arange(1.0, 60.0, 1e-3)).std() - 2.0) < 0.1)
    True
    """
    share = rng.dirichlet(np.full(TONES, 3.0))
    return Wander(
        amplitude_N=std_N * np.sqrt(2.0 * share),
        frequency_Hz=rng.uniform(*BAND_HZ, TONES),
        phase_rad=rng.uniform(0.0, 2.0 * np.pi, TONES),
    )
