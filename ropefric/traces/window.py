"""The smoothing window that fits a trace: its bias on a ramp against the noise it leaves."""

import math

from ropefric.errors import InputError
from ropefric.traces.smoothing import window_samples


def window_bias_N(loading_rate_N_s: float, window_s: float, step_s: float) -> float:
    """Return by how much a centred window lowers the top of a ramp that ends in a sudden drop [N].

    The window that lies wholly on the ramp and ends at its top has its mean half a window earlier:
    −rate (w − step)/2, to first order. Zero for a window of one sample.
    """
    rate, beyond_s = max(float(loading_rate_N_s), 0.0), max(float(window_s) - float(step_s), 0.0)
    return _finite(-rate * (beyond_s / 2.0), "bias", rate, beyond_s)


def peak_uncertainty_N(loading_rate_N_s: float, noise_std_N: float, window_s: float, step_s: float) -> float:
    """Return the standard uncertainty of a smoothed peak: noise that is left, and the window's bias [N]."""
    _check(noise_std_N, step_s)
    n_window = max(float(window_s) / float(step_s), 1.0)
    bias_N = window_bias_N(loading_rate_N_s, window_s, step_s)
    return _finite(math.hypot(noise_std_N / math.sqrt(n_window), bias_N), "uncertainty", noise_std_N, bias_N)


def choose_window(loading_rate_N_s: float, noise_std_N: float, step_s: float, *, longest_s: float) -> float:
    """Return the window with the smallest uncertainty of the peak [s].

    Minimises (rate·w/2)² + σ²·step/w, whose minimum is at w³ = 2 σ² step / rate².
    """
    _check(noise_std_N, step_s)
    rate = max(float(loading_rate_N_s), 0.0)
    wanted_s = longest_s
    if rate > 0:
        noise_s = float(noise_std_N) / rate  # squares of the two alone may leave the range of a float
        wanted_s = min(longest_s, math.cbrt(2.0 * noise_s * noise_s * float(step_s)))
    return _finite(window_samples(wanted_s, step_s) * float(step_s), "window", wanted_s, step_s)


def _check(noise_std_N: float, step_s: float) -> None:
    if not (0 < step_s < math.inf and 0 <= noise_std_N < math.inf):
        raise InputError(
            f"a step of {step_s} s with noise of {noise_std_N} N makes no sense",
            code="RF220",
            fix="give a positive step and a noise of zero or more",
        )


def _finite(value: float, what: str, *of: float) -> float:
    if not math.isfinite(value):
        raise InputError(
            f"the {what} is {value:g}: {' and '.join(f'{number:g}' for number in of)} are beyond what a float holds",
            code="RF220",
            fix="check the units",
        )
    return value
