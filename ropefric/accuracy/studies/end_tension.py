"""The wrap φ0 that is equivalent to an end tension: the root of G(φ0) = ln(F_B/F_0), eqs. (11)-(13)."""

from collections.abc import Callable
from functools import partial

import numpy as np
import numpy.typing as npt
from scipy.special import wrightomega

from ropefric.accuracy.study import Case, Setting, Study, against
from ropefric.arrays import FloatArray
from ropefric.friction.integral import exponential_start_rad, power_log_start

Values = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""G − y and its slope μ at angles."""

LOG_TENSION = (0.25, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
COPIES = 125
A, C = 0.2, 0.1
A_EXP, B_EXP, C_EXP = 0.1, -0.5, 0.2

# 50-digit ln φ0 for these loads; the tests compute them again with mpmath.
POWER = {
    -0.5: (-1.1974574990493562477, -9.2518585385429709419e-17, 1.1096743620009965952, 2.1287175470634258113,
           2.6862266176512102655, 3.0665169503991575628, 3.3536207888480985081, 3.5835189384561099322),
    -0.95: (-55.451774444795558849, -41.588830833596664977, -27.725887222399590087, -13.862944564872306872,
            -5.7557512458986801751, -0.35403898428073482156, 1.8220768906775640969, 2.66082662189850809),
    -0.999: (-6684.6117276679205265, -5991.4645471079758327, -5298.3173665480311389, -4605.1701859880864452,
             -4199.7050778799224233, -3912.0230054281417514, -3688.8794541139321938, -3506.5578973199777295),
}  # fmt: skip
EXPONENTIAL = (-0.11583262364226936619, 0.63599172530242845292, 1.4175527240162307304, 2.198451357946814366,
               2.6391224322449871322, 2.9444429185812412516, 3.1780540863559743644, 3.3672958473777681421)  # fmt: skip

_HALVINGS = (5, 10, 15, 20, 25, 30, 40, 50, 60, 80, 100)
_STEPS = (1, 2, 3, 4, 5, 6, 8, 12)


def bisection(values: Values, upper: FloatArray, n: int) -> FloatArray:
    """Return ln φ0 after n halvings of [0, upper]: one bit a step, and none of a φ0 far below the bracket."""
    low, high = np.zeros_like(upper), upper
    for _ in range(n):
        middle = 0.5 * (low + high)
        above = values(middle)[0] > 0.0
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return _log(0.5 * (low + high))


def newton(values: Values, upper: FloatArray, n: int) -> FloatArray:
    """Return ln φ0 after n Newton steps in φ from `upper`, halved where a step would leave the positive angles.

    G is concave, so that the first step may overshoot to the left and all later ones rise to the root.
    """
    phi = upper
    for _ in range(n):
        gap, slope = values(phi)
        stepped = phi - gap / slope
        phi = np.where(stepped > 0.0, stepped, 0.5 * phi)
    return _log(phi)


def log_newton(y: FloatArray, b: float, n: int) -> FloatArray:
    """Return ln φ0 of μ = 0.2 φ^b + 0.1 after n Newton steps on ln G in u = ln φ: convex, so the steps only descend."""
    u = _log_start(y, b)
    for _ in range(n):
        u = u - _log_step(u, y, b)
    return u


def _log_start(y: FloatArray, b: float) -> FloatArray:
    s = b + 1.0
    return np.asarray(np.minimum((np.log(y) - np.log(A / s)) / s, np.log(y / C)))


def _log_step(u: FloatArray, y: FloatArray, b: float) -> FloatArray:
    s = b + 1.0
    linear = np.log(C) + u
    total = np.logaddexp(np.log(A / s) + s * u, linear)
    return np.asarray((total - np.log(y)) / (s + (1.0 - s) * np.exp(linear - total)))


def _steps_to_stop(y: FloatArray, b: float) -> float:
    """Return how many steps the library takes, which stops where none is longer than 1e-8 and does not report it."""
    u, step, steps = _log_start(y, b), np.ones(1), 0
    while (step > 1e-8).any():
        step, steps = _log_step(u, y, b), steps + 1
        u = u - step
    return float(steps)


def _own(_answer: FloatArray, n: float) -> float:
    """Return the work of n steps of a method that evaluates G in its own way."""
    return n


def omega(y: FloatArray) -> FloatArray:
    """Return ln φ0 of μ = 0.1 e^{−0.5 φ} + 0.2 by Wright's omega function, without a step of iteration."""
    shifted = y + A_EXP / B_EXP
    argument = B_EXP * shifted / C_EXP + np.log(A_EXP / C_EXP)
    return _log(shifted / C_EXP - wrightomega(argument) / B_EXP)


def _log(phi: FloatArray) -> FloatArray:
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(phi))


def _error_of_angle(answer: npt.ArrayLike, reference: npt.ArrayLike) -> float:
    """Return the largest relative error of φ0 from its logarithm; infinite where there is no number, 1 for φ0 = 0."""
    with np.errstate(over="ignore"):
        errors = np.abs(np.expm1(np.asarray(answer) - np.asarray(reference)))
    return float(errors.max()) if np.isfinite(errors).all() else float("inf")


def _iterated(values: Values, upper: FloatArray, exact: FloatArray) -> tuple[Setting, ...]:
    judged = partial(against, exact, work="calls", error=_error_of_angle)
    return (
        *judged("bisection", "{} halvings", lambda n, at: bisection(at, upper, n), values, over=_HALVINGS),
        *judged("Newton in φ", "{} steps", lambda n, at: newton(at, upper, n), values, over=_STEPS),
    )


def _power_settings(b: float) -> tuple[Setting, ...]:
    y, exact = (np.tile(np.array(values), COPIES) for values in (LOG_TENSION, POWER[b]))
    s = b + 1.0
    upper = np.minimum((y * s / A) ** (1.0 / s), y / C)
    judged = partial(against, exact, error=_error_of_angle)

    def values(phi: FloatArray) -> tuple[FloatArray, FloatArray]:
        # A φ0 below every float makes the slope infinite; the method then stays where it is, and the error shows it.
        with np.errstate(divide="ignore", invalid="ignore"):
            power = A * phi**b
            return np.where(phi > 0.0, power * phi, 0.0) / s + C * phi - y, power + C

    return (
        *_iterated(values, upper, exact),
        *judged("Newton in ln φ", "{} steps", partial(log_newton, y, b), over=_STEPS, work=_own),
        *judged("ropefric", "", partial(power_log_start, y, A, b, C), work=_steps_to_stop(y, b)),
    )


def _exponential_settings() -> tuple[Setting, ...]:
    y, exact = (np.tile(np.array(values), COPIES) for values in (LOG_TENSION, EXPONENTIAL))
    judged = partial(against, exact, error=_error_of_angle)

    def values(phi: FloatArray) -> tuple[FloatArray, FloatArray]:
        return A_EXP * np.expm1(B_EXP * phi) / B_EXP + C_EXP * phi - y, A_EXP * np.exp(B_EXP * phi) + C_EXP

    def house() -> FloatArray:
        return np.asarray(np.log(exponential_start_rad(y, A_EXP, B_EXP, C_EXP)))

    def stepped(label: str, n_steps: int) -> tuple[Setting, ...]:
        after = partial(newton, values, np.exp(omega(y)))
        return judged("Wright omega", label, after, over=(n_steps,), work=_own)

    return (
        *_iterated(values, y / C_EXP, exact),
        *judged("Wright omega", "alone", partial(omega, y), work=0.0),
        *stepped("{} step", 1),
        *stepped("{} steps", 2),
        # One step from there moves φ0 by less than the library's 1e-9, where it stops.
        *judged("ropefric", "", house, work=1.0),
    )


STUDY = Study(
    name="end-tension",
    title="Wrap angle φ0 equivalent to an end tension, the root of G(φ0) = ln(F_B/F_0)",
    question="Which iteration finds φ0, also where it is smaller than any number a computer holds?",
    reference="root in 50-digit arithmetic (mpmath)",
    counted="evaluations of G and its slope, each for all loads at once",
    used="Newton in ln φ from a start that is near at both ends; Wright omega for the exponential law",
    cases=(
        *(
            Case(name, f"1000 loads, μ = 0.2 φ^−{-b:g} + 0.1{remark}", partial(_power_settings, b))
            for name, b, remark in (
                ("power", -0.5, ""),
                ("power-steep", -0.95, ": φ0 from 1e-24 to 14 rad"),
                ("power-underflow", -0.999, ": φ0 below e^−3500 rad, no float"),
            )
        ),
        Case("exponential", "1000 loads, μ = 0.1 exp(−0.5 φ) + 0.2", _exponential_settings),
    ),
)
