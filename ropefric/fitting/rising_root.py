"""Where rising functions cross zero, for a million of them at once: Newton's method kept between bounds."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray

Rising = Callable[[FloatArray, npt.NDArray[np.intp]], tuple[FloatArray, FloatArray]]
"""`f(x, rows) -> (values, slopes)` of the functions numbered `rows` at one x each; −inf where there is no answer."""

_MAX_STEPS = 200
_SCAN = 24


def rising_root(
    function: Rising,
    low: FloatArray,
    high: FloatArray,
    *,
    start: FloatArray | None = None,
    tolerance: float = 1e-13,
) -> FloatArray:
    """Return the zeros of n functions that rise from below zero at `low` to zero or more at `high`.

    A Newton step that leaves the bracket, or that does not shrink, is replaced by halving the bracket, so every
    function is done after at most about 50 more steps than it takes to halve.
    """
    low, high = low.astype(np.float64), high.astype(np.float64)
    x = 0.5 * (low + high) if start is None else np.clip(start, low, high)
    rows = np.arange(x.size)
    last_x, last_value, last_step = np.full(x.size, np.nan), np.full(x.size, np.nan), high - low
    for _ in range(_MAX_STEPS):
        at = x[rows]
        value, slope = function(at, rows)
        below = value < 0.0
        low[rows] = np.where(below, at, low[rows])
        high[rows] = np.where(below, high[rows], at)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            secant = (value - last_value[rows]) / (at - last_x[rows])
            # Close to the root the chord knows what the slope leaves out.
            slope = np.where((secant > 0.5 * slope) & (secant < 2.0 * slope), secant, slope)
            new = at - value / slope
        middle = 0.5 * (low[rows] + high[rows])
        bad = ~np.isfinite(new) | (new < low[rows]) | (new > high[rows])
        bad |= np.abs(new - at) > 0.9 * np.abs(last_step[rows])
        new = np.where(bad, middle, new)
        new = np.where(value == 0.0, at, new)
        last_x[rows], last_value[rows], last_step[rows] = at, value, new - at
        x[rows] = new
        small = tolerance * (1.0 + np.abs(new))
        moving = (np.abs(new - at) > small) & (high[rows] - low[rows] > small)
        rows = rows[moving]
        if not rows.size:
            break
    return x


def first_crossing(function: Rising, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return brackets (low, high) of the first place where functions reach zero; high is NaN where none does.

    For functions that rise at first but may fall later, such as a bound that widens with extrapolation: they are
    looked at in 24 steps that grow from `low`, so a crossing and return within one step goes unseen.
    """
    left, right = low.astype(np.float64), np.full(low.size, np.nan)
    rows = np.arange(low.size)
    for step in range(1, _SCAN + 1):
        at = low[rows] + (high[rows] - low[rows]) * (step / _SCAN) ** 4
        value, _slope = function(at, rows)
        found = value >= 0.0
        right[rows[found]] = at[found]
        left[rows[~found]] = at[~found]
        rows = rows[~found]
        if not rows.size:
            break
    return left, right
