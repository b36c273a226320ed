"""The reading of the unloaded rig and how well an idle interval tells it."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ropefric.errors import DataError, Problem
from ropefric.traces.noise import MAX_SPIKE_SAMPLES, noise_std, remove_spikes
from ropefric.traces.saturation import Saturation

MIN_TARE_SAMPLES = 10
_BLOCKS = 8
_RESTLESS = 4.0  # block means of white noise spread by 1 of this unit; 4 is out of reach of chance
_CLIPPED_SHARE = 0.02  # fewer samples at the floor are spikes or the tail of the noise
_DITHERED = 0.5  # in counts: noise this strong leaves less than 0.01 count of quantisation in a mean


@dataclass(frozen=True, slots=True, kw_only=True)
class Tare:
    """Mean reading of the unloaded rig."""

    force_N: float
    std_N: float
    n: int
    problems: tuple[Problem, ...] = ()


def measure_tare(force_N: NDArray[np.float64], saturation: Saturation, *, lsb_N: float) -> Tare:
    """Return the mean of an idle interval, its uncertainty, and warnings.

    The uncertainty comes from the scatter of the means of 8 blocks as well as from that of single samples,
    and the larger counts: hum and drift, whose samples are not independent, are not averaged away on paper.
    Isolated spikes are left out.
    """
    present_N = force_N[np.isfinite(force_N)]
    if present_N.size:
        # A spike of two samples at full scale moves the mean of a quarter second by more than a count.
        present_N = np.delete(present_N, remove_spikes(present_N, noise_std(present_N)).bad)
    if present_N.size < MIN_TARE_SAMPLES or 2 * present_N.size < force_N.size:
        raise DataError(
            f"the tare interval holds {present_N.size} usable of {force_N.size} samples; at least "
            f"{MIN_TARE_SAMPLES} and half of them are needed",
            code="RF212",
            key="tare",
            fix="name a longer idle interval",
        )
    if saturation.longest_high > MAX_SPIKE_SAMPLES:
        raise DataError(
            f"{saturation.n_high} samples of the tare interval are at the ADC ceiling: the rig is not idle",
            code="RF212",
            key="tare",
            fix="name an interval in which the rope hangs free",
        )
    mean_N, sample_std_N = float(present_N.mean()), float(present_N.std(ddof=1))
    n_blocks = min(_BLOCKS, present_N.size // 4)
    blocks = np.array_split(present_N, n_blocks)
    block_std_N = float(np.std([block.mean() for block in blocks], ddof=1))
    slow_std_N = block_std_N / math.sqrt(n_blocks)
    quantisation_N = 0.0 if sample_std_N >= _DITHERED * lsb_N else lsb_N / math.sqrt(12.0)
    std_N = math.hypot(max(sample_std_N / math.sqrt(present_N.size), slow_std_N), quantisation_N)

    problems = _restless(present_N, n_blocks, block_std_N, lsb_N) + _clipped(saturation, present_N)
    return Tare(force_N=mean_N, std_N=std_N, n=present_N.size, problems=problems)


def _restless(
    present_N: NDArray[np.float64], n_blocks: int, block_std_N: float, lsb_N: float
) -> tuple[Problem, ...]:
    # Differences of neighbours hold the noise and next to nothing of a drift.
    noise_N = float(np.sqrt(np.mean(np.diff(present_N) ** 2) / 2.0))
    if block_std_N <= max(lsb_N, _RESTLESS * noise_N / math.sqrt(present_N.size / n_blocks)):
        return ()
    return (
        Problem(
            code="RF212",
            message=f"the force is not constant in the tare interval: the means of its {n_blocks} parts "
            f"spread by {block_std_N:.3g} N, against {noise_N:.3g} N of noise of one sample",
            key="tare",
            fix="name an interval that ends before the motor starts",
            severity="warning",
        ),
    )


def _clipped(saturation: Saturation, present_N: NDArray[np.float64]) -> tuple[Problem, ...]:
    share = saturation.n_low / present_N.size
    if share < _CLIPPED_SHARE:
        return ()
    return (
        Problem(
            code="RF212",
            message=f"{100 * share:.0f} % of the tare interval is at the ADC floor: a zero below it cannot "
            f"be seen, and the tare of {float(present_N.mean()):.3g} N may be too high",
            key="tare",
            fix="set the transmitter's zero a few counts above the floor",
            severity="warning",
        ),
    )
