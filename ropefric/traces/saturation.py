"""Where the converter sat at its limits."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Saturation", "find_saturation"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Saturation:
    """Where a recording sat at the converter's ceiling and floor.

    At the ceiling the force is at least that high and unknown. At the floor it need not be a fault: an
    unloaded cell with 0 V at zero reads count 0.

    Attributes
    ----------
    high_runs, low_runs : ndarray of int64, shape (k, 2)
        Runs of samples at the ceiling and at the floor: index of the first sample, and one past the last.

    Examples
    --------
    >>> saturation = find_saturation(np.array([0, 9, 1023, 1023]), 1023)
    >>> saturation.high, saturation.n_high, saturation.n_low
    (True, 2, 1)
    """

    high_runs: NDArray[np.int64]
    low_runs: NDArray[np.int64]

    @property
    def high(self) -> bool:
        """Return whether any sample is at the ceiling."""
        return len(self.high_runs) > 0

    @property
    def low(self) -> bool:
        """Return whether any sample is at the floor."""
        return len(self.low_runs) > 0

    @property
    def n_high(self) -> int:
        """Return the number of samples at the ceiling."""
        return int((self.high_runs[:, 1] - self.high_runs[:, 0]).sum())

    @property
    def n_low(self) -> int:
        """Return the number of samples at the floor."""
        return int((self.low_runs[:, 1] - self.low_runs[:, 0]).sum())

    @property
    def first_high(self) -> int | None:
        """Return the index of the first sample at the ceiling; None if there is none."""
        return int(self.high_runs[0, 0]) if self.high else None

    @property
    def longest_high(self) -> int:
        """Return the number of samples in the longest run at the ceiling."""
        return int((self.high_runs[:, 1] - self.high_runs[:, 0]).max(initial=0))

    def longest_high_s(self, time_s: NDArray[np.float64]) -> float:
        """Return how long the longest run at the ceiling lasted [s]: first to last sample and one step more.

        Parameters
        ----------
        time_s : ndarray, shape (n,)
            Time stamps of the recording [s].
        """
        if not self.high:
            return 0.0
        step_s = float(np.median(np.diff(time_s))) if len(time_s) > 1 else 0.0
        lasted_s = time_s[self.high_runs[:, 1] - 1] - time_s[self.high_runs[:, 0]]
        return float(lasted_s.max()) + step_s

    def describe(self, time_s: NDArray[np.float64], *, ceiling_N: float) -> str:
        """Return what sat at the ceiling, for how long and what it means; empty if nothing did.

        Parameters
        ----------
        time_s : ndarray, shape (n,)
            Time stamps of the recording [s].
        ceiling_N : float
            Force at the ceiling [N], `Calibration.ceiling_N`.
        """
        if not self.high:
            return ""
        return (
            f"at the ADC ceiling for {self.n_high} samples, longest run {self.longest_high} "
            f"({1e3 * self.longest_high_s(time_s):.3g} ms): the force is {ceiling_N:.4g} N or more, unknown"
        )


def find_saturation(counts: NDArray[np.int64], max_count: int) -> Saturation:
    """Return the runs of samples at count 0 and at `max_count`.

    Parameters
    ----------
    counts : ndarray of int, shape (n,)
        Raw counts; negative ones, missing samples, are at neither limit and end a run.
    max_count : int
        Count at the ceiling.

    Examples
    --------
    >>> find_saturation(np.array([7, 15, 15, 3]), 15).high_runs.tolist()
    [[1, 3]]
    """
    return Saturation(high_runs=_runs(counts == max_count), low_runs=_runs(counts == 0))


def _runs(mask: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the start and stop of every run of True, shape (k, 2)."""
    if not mask.any():
        runs = np.empty((0, 2), dtype=np.int64)
    else:
        edges = np.flatnonzero(mask[1:] != mask[:-1]) + 1
        first = [0] if mask[0] else []
        last = [mask.size] if mask[-1] else []
        runs = np.concatenate([first, edges, last]).astype(np.int64).reshape(-1, 2)
    runs.flags.writeable = False
    return runs
