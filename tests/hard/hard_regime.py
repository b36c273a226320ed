"""What a hard regime declares, how the error of a law is measured in it, and what is held beside it.

A module of regimes declares each by `regime` over the function that measures it; `fact` is over what holds there
besides, with assertions of its own, and `refusals` over what yields calls with the words that refuse them.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import hard_truth
import mpmath as mp
import numpy as np
import pytest

from ropefric.errors import RopefricError
from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS

__all__ = ["EPS", "FACTS", "REFUSALS", "REGIMES", "START", "Regime", "answer", "fact", "refusals",
           "refused", "regime", "relative", "worst_law_error"]  # fmt: skip

EPS = float(np.finfo(float).eps)
# Nothing smaller is a normal float: below it digits go one by one whatever the formula.
SMALLEST = float(np.finfo(float).tiny)
START = {name: [parameter.start for parameter in law.parameters] for name, law in ALL_LAWS.items()}
_LEAST_SHOWN = 1e-15


@dataclass(frozen=True, slots=True, kw_only=True)
class Regime:
    """A numerically hard regime: what is asked in it, of whom, to what relative accuracy (None: it is refused)."""

    name: str
    asks: str
    reference: str
    tolerance: float | None
    measure: Callable[[], float]

    def row(self, error: float | None) -> tuple[str, ...]:
        """Return it as the docs show it, with the worst error that was measured."""
        stated, measured = "refused", "refused"
        if self.tolerance is not None:
            stated, measured = _power(self.tolerance), f"≤ {_power(shown(error))}"
        return self.name, self.asks, self.reference, stated, measured


def shown(error: float) -> float:
    """Return the next power of ten with half a decade to spare: another machine's last bit changes nothing."""
    return 10.0 ** math.ceil(math.log10(max(math.sqrt(10.0) * error, _LEAST_SHOWN)) - 1e-9)


def _power(value: float) -> str:
    return f"1e{round(math.log10(value))}"


# By the name of the function: whatever imports a module of regimes twice declares each of them once.
REGIMES: dict[str, Regime] = {}
FACTS: dict[str, Callable[[], None]] = {}
REFUSALS: dict[str, Callable[[], Iterator[tuple[Callable[[], object], str]]]] = {}


def regime(name, tolerance, reference, asks):
    """Declare a regime over the function that measures its worst error, or yields its refusals."""

    def declare(measure):
        REGIMES[measure.__name__] = Regime(
            name=name, asks=asks, reference=reference, tolerance=tolerance, measure=measure
        )
        return measure

    return declare


def fact(function):
    FACTS[function.__name__] = function
    return function


def refusals(function):
    """Declare calls that are refused, with words of each refusal."""
    REFUSALS[function.__name__] = function
    return function


def refused(call, said):
    """Assert that a call is refused: what it says, and that it says more than a type."""
    with pytest.raises(RopefricError, match=said) as caught:
        call()
    assert len(caught.value.problem.message) > 15
    return caught.value


def answer(call):
    """Return a call's numbers, which must be finite; None where it is refused with words."""
    refusal, found = None, ()
    try:
        found = call()
    except RopefricError as error:
        refusal = error
    if refusal is not None:
        assert len(refusal.problem.message) > 15
        return None
    for part in found if isinstance(found, tuple) else (found,):
        assert np.isfinite(np.asarray(part, dtype=np.float64)).all()
    return found


def relative(found, truth, scale=0.0) -> float:
    """Return |found − truth| relative to the truth or a scale; finite, or it is no result at all."""
    found = float(found)
    assert np.isfinite(found)
    with mp.workdps(60):
        return float(abs(mp.mpf(found) - truth) / max(abs(truth), mp.mpf(scale), mp.mpf(SMALLEST)))


def _law_errors(name, theta, pull, slopes) -> Iterator[float]:
    """Yield the relative errors of a law at one pull: ln F_A, its rise per radian, and every slope."""
    law, at = ALL_LAWS[name], one_condition(*pull)
    rise, log_tension = hard_truth.rise(name, theta, pull), mp.log(mp.mpf(pull[3]))
    yield relative(law.log_lift(theta, at)[0], log_tension + rise, abs(log_tension))
    if pull[2] > 1e-290:
        yield relative(law.average_mu(theta, at)[0], rise / mp.mpf(pull[2]))
    if slopes:
        found = [*law.jacobian(theta, at)[0], *law.log_lift_gradient_conditions(theta, at)[0]]
        truth = [*hard_truth.parameter_slopes(name, theta, pull),
                 *hard_truth.condition_slopes(name, theta, pull)]  # fmt: skip
        yield from (relative(*pair) for pair in zip(found, truth, strict=True))


def worst_law_error(cases, *, digits=100, slopes=True) -> float:
    """Return the worst relative error over (law, parameters, pull) cases."""
    with mp.workdps(digits):
        return max(error for case in cases for error in _law_errors(*case, slopes))
