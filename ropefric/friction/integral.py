"""The integral of the local coefficient over the wrap, eqs. (11)-(17), in closed form and all in ln F.

These are the wrap laws by themselves, on plain arrays and with a reference force of one's own; a
`FrictionLaw` adds the wheel's size and holds F_0 = 1 N.
"""

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.friction.end_tension import exponential_start_rad, power_log_start
from ropefric.friction.exponential_wrap import exponential_rise, exponential_rise_slopes
from ropefric.friction.power_span import power_span


def power_integral(
    wrap_rad: npt.ArrayLike,
    a: npt.ArrayLike,
    b: npt.ArrayLike,
    c: npt.ArrayLike = 0.0,
    *,
    start_rad: npt.ArrayLike = 0.0,
) -> FloatArray:
    """Return ∫ (a φ^b + c) dφ over [start, start + wrap], eq. (15) in eq. (11).

    Exact through b = −1, where it is a logarithm; the wrap is passed by itself because a difference of two
    angles would lose it.
    """
    delta, p, a, b, c = _arrays(wrap_rad=wrap_rad, start_rad=start_rad, a=a, b=b, c=c)
    _check_start(p, b)
    some = delta > 0.0
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        span = power_span(np.log(p), np.where(some, delta, 1.0), b)
        return _all_finite(np.where(some, a * span.integral() + c * delta, 0.0))


def power_integral_slopes(
    wrap_rad: npt.ArrayLike, a: npt.ArrayLike, b: npt.ArrayLike, *, start_rad: npt.ArrayLike = 0.0
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the derivatives of `power_integral` by a, b and c; arguments and refusals are its own."""
    delta, p, a, b = _arrays(wrap_rad=wrap_rad, start_rad=start_rad, a=a, b=b)
    _check_start(p, b)
    some = delta > 0.0
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        span = power_span(np.log(p), np.where(some, delta, 1.0), b)
        by_a, by_b = np.where(some, span.integral(), 0.0), np.where(some, a * span.slope(), 0.0)
    return _all_finite(by_a), _all_finite(by_b), delta.copy()


def exponential_integral(
    wrap_rad: npt.ArrayLike,
    a: npt.ArrayLike,
    b: npt.ArrayLike,
    c: npt.ArrayLike = 0.0,
    *,
    start_rad: npt.ArrayLike = 0.0,
) -> FloatArray:
    """Return ∫ (a e^{bφ} + c) dφ over [start, start + wrap], eq. (14) in eq. (11); exact through b = 0."""
    delta, p, a, b, c = _arrays(wrap_rad=wrap_rad, start_rad=start_rad, a=a, b=b, c=c)
    with np.errstate(over="ignore", invalid="ignore"):
        return _all_finite(exponential_rise(p, delta, a, b, c))


def exponential_integral_slopes(
    wrap_rad: npt.ArrayLike, a: npt.ArrayLike, b: npt.ArrayLike, *, start_rad: npt.ArrayLike = 0.0
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the derivatives of `exponential_integral` by a, b and c; arguments and refusals are its own."""
    delta, p, a, b = _arrays(wrap_rad=wrap_rad, start_rad=start_rad, a=a, b=b)
    with np.errstate(over="ignore", invalid="ignore"):
        by_a, by_b, by_c = exponential_rise_slopes(p, delta, a, b)
    return _all_finite(by_a), _all_finite(by_b), by_c.copy()


def log_force_ratio(end_tension_N: npt.ArrayLike, reference_N: npt.ArrayLike = 1.0) -> FloatArray:
    """Return y = ln(F_B/F_0), to full precision also for F_B → F_0."""
    F_B, F_0 = _arrays(end_tension_N=end_tension_N, reference_N=reference_N)
    _refuse_where(F_0 <= 0.0, F_0, "the reference force F_0 is {} N; it must be positive")
    _refuse_where(
        F_B < F_0, F_B, "F_B = {} N is below the reference force F_0, so no wrap angle stands for it"
    )
    # Near F_0 the difference is exact and the quotient is not; far from it the quotient may be no float.
    with np.errstate(over="ignore"):
        near, quotient = F_B < 2.0 * F_0, F_B / F_0
        return np.select(
            [near, np.isfinite(quotient)],
            [np.log1p((F_B - F_0) / F_0), np.log(quotient)],
            np.log(F_B) - np.log(F_0),
        )


def log_lift_power(
    a: npt.ArrayLike,
    b: npt.ArrayLike,
    c: npt.ArrayLike,
    *,
    wrap_rad: npt.ArrayLike,
    end_tension_N: npt.ArrayLike,
    reference_N: npt.ArrayLike = 1.0,
) -> FloatArray:
    """Return ln(F_A / 1 N) of μ = a φ^b + c with the end tension counted as wrap, eqs. (15), (17)."""
    y = log_force_ratio(end_tension_N, reference_N)
    delta, a, b, c = _arrays(wrap_rad=wrap_rad, a=a, b=b, c=c)
    _check_coefficients(a, c, y)
    _refuse_where(b <= -1.0, b, "the exponent b is {}; for b <= -1 the integral from 0 diverges: no φ0")
    some = delta > 0.0
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        span = power_span(power_log_start(y, a, b, c), np.where(some, delta, 1.0), b)
        rise = np.where(some, a * span.integral() + c * delta, 0.0)
        return _all_finite(np.log(end_tension_N) + rise)


def log_lift_exponential(
    a: npt.ArrayLike,
    b: npt.ArrayLike,
    c: npt.ArrayLike,
    *,
    wrap_rad: npt.ArrayLike,
    end_tension_N: npt.ArrayLike,
    reference_N: npt.ArrayLike = 1.0,
) -> FloatArray:
    """Return ln(F_A / 1 N) of μ = a e^{bφ} + c with the end tension counted as wrap, eqs. (14), (17).

    Arguments and refusals are those of `log_lift_power`, with b in 1/rad and zero or less; c = 0 also needs
    ln(F_B/F_0) < a/|b|, where the integral saturates.
    """
    y = log_force_ratio(end_tension_N, reference_N)
    delta, a, b, c = _arrays(wrap_rad=wrap_rad, a=a, b=b, c=c)
    _check_coefficients(a, c, y)
    _refuse_where(b > 0.0, b, "the rate b is {} per rad; it must be zero or negative")
    with np.errstate(over="ignore", invalid="ignore"):
        saturated = (c == 0.0) & (y > 0.0) & (-b * y >= a)
        _refuse_where(
            saturated, y + 0.0 * a, "ln(F_B/F_0) = {} is beyond a/|b|, where the integral saturates: no φ0"
        )
        rise = exponential_rise(exponential_start_rad(y, a, b, c), delta, a, b, c)
        return _all_finite(np.log(end_tension_N) + rise)


def _arrays(**values: npt.ArrayLike) -> list[FloatArray]:
    """Return float arrays, finite; those called `…_rad` zero or more."""
    arrays = []
    for name, value in values.items():
        array = np.asarray(value, dtype=np.float64)
        _refuse_where(~np.isfinite(array), array, f"{name} is {{}}; it must be finite")
        if name.endswith("_rad"):
            _refuse_where(array < 0.0, array, f"{name} is {{}} rad; an angle is zero or more")
        arrays.append(array)
    return arrays


def _check_start(p: FloatArray, b: FloatArray) -> None:
    _refuse_where(
        (p == 0.0) & (b <= -1.0), b + 0.0 * p, "the exponent b is {}; from zero the integral diverges"
    )


def _check_coefficients(a: FloatArray, c: FloatArray, y: FloatArray) -> None:
    _refuse_where(a < 0.0, a, "a is {}, negative: μ must not be")
    _refuse_where(c < 0.0, c, "c is {}, negative: μ must not be")
    nothing = (a <= 0.0) & (c <= 0.0) & (y > 0.0)
    _refuse_where(nothing, np.zeros_like(y), "μ is {} everywhere: no wrap stands for F_B")


def _refuse_where(where: npt.ArrayLike, values: FloatArray, message: str) -> None:
    mask, values = np.broadcast_arrays(np.asarray(where, dtype=np.bool_), values)
    if mask.any():
        first = int(np.argmax(mask))
        place = f" at index {first}" if mask.size > 1 else ""
        raise InputError(message.format(f"{values.ravel()[first]:g}") + place, code="RF420")


def _all_finite(values: FloatArray) -> FloatArray:
    _refuse_where(
        ~np.isfinite(values), values, "the integral is {}: a coefficient is so large that floats overflow"
    )
    return values
