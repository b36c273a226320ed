"""A recording reduced to what a drawing can show."""

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.traces.trace import ForceTrace
from ropefric.trials.result import Outline

BINS = 300
DIGITS = 6


def draw_outline(trace: ForceTrace) -> Outline | None:
    """Return the min-max envelope and the means of about 300 bins; None where no sample is there.

    Numbers are rounded to six digits: no eye sees more, and a stored outline is a third as long.
    """
    time_s, force_N = trace.time_s, trace.force_N
    present = np.isfinite(force_N)
    if not present.all():
        time_s, force_N = time_s[present], force_N[present]
    if force_N.size == 0:
        return None
    n_bins = min(BINS, force_N.size)
    starts = np.arange(n_bins) * force_N.size // n_bins
    counts = np.diff(np.append(starts, force_N.size))
    middle_s = _rounded(0.5 * (time_s[starts] + time_s[starts + counts - 1]))
    return Outline(
        time_s=middle_s,
        low_N=_rounded(np.minimum.reduceat(force_N, starts)),
        high_N=_rounded(np.maximum.reduceat(force_N, starts)),
        smoothed_time_s=middle_s,
        smoothed_N=_rounded(np.add.reduceat(force_N, starts) / counts),
    )


def _rounded(values: FloatArray) -> FloatArray:
    largest = float(np.abs(values).max())
    if largest == 0.0:
        return values + 0.0  # no negative zeros in stored files
    return np.round(values, DIGITS - 1 - int(np.floor(np.log10(largest)))) + 0.0
