"""What a hard case declares, and how the error of a law is measured in it."""

import warnings
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass

import hard_truth
import mpmath as mp
import numpy as np

from ropefric.friction.laws import ALL_LAWS

__all__ = ["EPS", "Regime", "law_error", "once", "quiet", "relative", "worst_law_error"]

EPS = float(np.finfo(float).eps)
# Nothing smaller is a normal float: below it digits go one by one whatever the formula.
SMALLEST = float(np.finfo(float).tiny)


@dataclass(frozen=True, slots=True, kw_only=True)
class Regime:
    """A numerically hard regime: its name, what holds there, and to what relative accuracy (None: it is refused)."""

    name: str
    statement: str
    accuracy: float | None


_MEASURED: dict[str, float] = {}


def once(regime: Regime) -> Callable[[Callable[[], float]], Callable[[], float]]:
    """Make a measurement be taken once a process, though the test and the table both ask for it."""

    def decorate(measure: Callable[[], float]) -> Callable[[], float]:
        def measured() -> float:
            if regime.name not in _MEASURED:
                with quiet():
                    _MEASURED[regime.name] = float(measure())
            return _MEASURED[regime.name]

        return measured

    return decorate


@contextmanager
def quiet():
    """No warning leaves the library; outside pytest too."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def relative(found, truth, scale=0.0) -> float:
    """Return |found − truth| relative to the truth or a scale; finite, or it is no result at all."""
    found = float(found)
    assert np.isfinite(found)
    with mp.workdps(60):
        return float(abs(mp.mpf(found) - truth) / max(abs(truth), mp.mpf(scale), mp.mpf(SMALLEST)))


def law_error(name, theta, pull, *, slopes=True) -> dict[str, float]:
    """Return the relative errors of a law at one pull: ln F_A, its rise per radian, and every slope."""
    law, at = ALL_LAWS[name], hard_truth.one(pull)
    rise = hard_truth.rise(name, theta, pull)
    log_tension = mp.log(mp.mpf(pull[3]))
    errors = {"ln F_A": relative(law.log_lift(theta, at)[0], log_tension + rise, abs(log_tension))}
    if pull[2] > 1e-290:
        errors["mean"] = relative(law.average_mu(theta, at)[0], rise / mp.mpf(pull[2]))
    if slopes:
        jacobian = law.jacobian(theta, at)[0]
        by_parameter = hard_truth.parameter_slopes(name, theta, pull)
        for parameter, found, truth in zip(law.parameter_names, jacobian, by_parameter, strict=True):
            errors[f"d/d{parameter}"] = relative(found, truth)
        gradient = law.log_lift_gradient_conditions(theta, at)[0]
        by_condition = hard_truth.condition_slopes(name, theta, pull)
        for condition, found, truth in zip(("R_w", "phi", "ln F_B"), gradient, by_condition, strict=True):
            errors[f"d/d{condition}"] = relative(found, truth)
    return errors


def worst_law_error(cases, *, digits=100, slopes=True) -> float:
    """Return the worst relative error over (law, parameters, pull) cases."""
    with hard_truth.digits(digits):
        return max(max(law_error(*case, slopes=slopes).values()) for case in cases)
