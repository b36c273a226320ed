"""Whether a fit that came from a file can be one: numbers that no fit ever gives are damage, not results."""

from collections.abc import Iterator, Mapping
from math import isfinite, isnan

import numpy as np

from ropefric.fitting.result import FitResult, FittedParameter
from ropefric.fitting.status import FitStatus

_REGRESSORS = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N")
_ROUNDING = 1e-9


def faults(fit: FitResult) -> Iterator[str]:
    """Yield what no fit can be like, in words; nothing for a sound one.

    A file may be cut, merged or edited by hand, and a prediction from it would look like any other.
    """
    plain = "intervals" not in fit.provenance
    for item in fit.parameters:
        yield from _of_parameter(item, plain=plain)
    yield from _of_covariance(fit)
    yield from _of_statistics(fit)
    yield from _of_origin(fit)
    yield from _of_verdict(fit)


def _of_origin(fit: FitResult) -> Iterator[str]:
    for name in _REGRESSORS:
        low, high = fit.validity.get(name, (1.0, 0.0))
        if not (isfinite(low) and isfinite(high) and 0.0 <= low <= high):
            yield f"validity.{name} is no range"
    for name in ("input", "settings", "versions"):
        if not isinstance(fit.provenance.get(name, {}), Mapping):
            yield f"provenance.{name} is no object"


def _of_verdict(fit: FitResult) -> Iterator[str]:
    if fit.status is FitStatus.OK and any(item.at_bound for item in fit.parameters):
        yield "the status is ok, but a parameter lies on its bound"
    if fit.status is FitStatus.OK and not all(isfinite(item.std) for item in fit.parameters):
        yield "the status is ok, but a parameter has no standard error"
    if fit.status is not FitStatus.OK and not fit.advice:
        yield f"the status is {fit.status}, but there is no advice"
    texts: tuple[object, ...] = (*fit.advice, *fit.notes)
    for text in texts:
        if not isinstance(text, str):
            yield f"{text!r:.40} is no advice"


def _of_parameter(item: FittedParameter, *, plain: bool) -> Iterator[str]:
    if not (isfinite(item.value) and item.lower <= item.value <= item.upper):
        yield f"{item.name} = {item.value:g} does not lie between its bounds {item.lower:g} and {item.upper:g}"
    if item.std < 0.0 or (isnan(item.std) and not item.at_bound):
        yield f"the standard error of {item.name} is {item.std:g}"
    low, high = item.ci95
    # Only the intervals of the covariance are drawn about the estimate; on a bound there are none.
    slack = _ROUNDING * abs(item.value)
    unlike = not (low <= high) or (plain and not low - slack <= item.value <= high + slack)
    if unlike and not item.at_bound:
        yield f"the interval of {item.name} from {low:g} to {high:g} is none of {item.value:g}"


def _of_covariance(fit: FitResult) -> Iterator[str]:
    covariance = np.asarray(fit.covariance)
    if not np.isfinite(covariance).all():
        yield "the covariance is not finite"
        return
    variance = np.diag(covariance)
    if (variance < 0.0).any():
        yield "the covariance has a negative variance"
        return
    most = np.sqrt(variance)[:, None] * np.sqrt(variance)[None, :]
    if (covariance != covariance.T).any() and not np.allclose(
        covariance, covariance.T, rtol=_ROUNDING, atol=0.0
    ):
        yield "the covariance is not symmetric"
    elif (np.abs(covariance) > most * (1.0 + _ROUNDING)).any():
        yield "the covariance has a correlation above 1"
    for i, item in enumerate(fit.parameters):
        if isfinite(item.std) and not np.isclose(item.std, np.sqrt(variance[i]), rtol=1e-6, atol=0.0):
            yield f"the standard error of {item.name} is not that of the covariance"


def _of_statistics(fit: FitResult) -> Iterator[str]:
    found = fit.statistics
    for name in ("n", "n_conditions", "dof"):
        if not isinstance(getattr(found, name), int):
            yield f"statistics.{name} is no whole number"
    if not (found.n >= found.n_conditions >= 1 and found.dof <= found.n):
        yield f"{found.n} trials of {found.n_conditions} conditions with {found.dof} degrees of freedom"
    if not (isfinite(found.chi2) and found.chi2 >= 0.0):
        yield f"chi2 is {found.chi2:g}"
    for name in ("scatter_within", "scatter_between", "interval_dof"):
        if getattr(found, name) < 0.0:
            yield f"statistics.{name} is {getattr(found, name):g}, negative"
