"""b → −1 from both sides, and c + 1 → 0: the power becomes a logarithm, and from zero it diverges."""

import mpmath as mp
import numpy as np
import pytest
from hard_regime import EPS, Regime, once, relative, worst_law_error

from ropefric.friction.condition import one_condition
from ropefric.friction.integral import PowerSpan, power_integral
from ropefric.friction.laws import ALL_LAWS

REGIME = Regime(
    name="b → −1, c + 1 → 0",
    statement="∫ φ^b over [p, p + δ] with b + 1 = ±1e-3 … ±2e-16 and 0, δ = 1e-12 … 1e3 rad, with slopes; the "
    "laws from above",
    accuracy=1e-12,
)
# Far from φ = 1 rad, where ln φ changes sign and the slope by b with it.
START = 3.7


def _stretches():
    for b in (-1.0, *(-1 + side * s for side in (1, -1) for s in (1e-3, 1e-9, 2.0**-52))):
        for delta in (1e-12, 0.3, 1e3):
            with mp.workdps(90):
                s, low, high = mp.mpf(b) + 1, mp.mpf(START), mp.mpf(START) + mp.mpf(delta)
                l0, l1 = mp.log(low), mp.log(high)
                value = l1 - l0 if s == 0 else (mp.exp(s * l1) - mp.exp(s * l0)) / s
                slope = (
                    (l1**2 - l0**2) / 2
                    if s == 0
                    else ((s * l1 - 1) * mp.exp(s * l1) - (s * l0 - 1) * mp.exp(s * l0)) / s**2
                )
            yield b, delta, value, slope


@once(REGIME)
def measured():
    worst = worst_law_error(
        [
            ("wrap-power-from-zero", [0.2, s - 1, 0.1], (0.04, 0.005, 7.0, 20.0))
            for s in (1e-3, 1e-9, 2.0**-52)
        ]
        + [
            (name, [0.2, -0.2, -0.3, s - 1, 0.1], (0.04, 0.005, 7.0, 20.0))
            for name in ("coupled", "coupled-from-zero")
            for s in (1e-3, 2.0**-52)
        ],
        digits=520,
    )
    for b, delta, value, slope in _stretches():
        span = PowerSpan(np.log(START), delta, b)
        worst = max(
            worst,
            relative(power_integral(delta, 1.0, b, start_rad=START), value),
            relative(span.integral(), value),
            relative(span.slope(), slope),
        )
    return worst


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


@pytest.mark.parametrize("s", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("start", [0.05, 0.7, 4.0])
def test_where_the_problem_itself_is_ill_conditioned(s, start):
    # ln φ0 = ln(y s/a)/s, so ∂ ln φ0/∂ ln y = ∂ ln φ0/∂ ln a = 1/s: where φ0 is of the size of the wrap, one
    # rounding of y or a moves the rise by κ = 1/s roundings, whatever the method.
    a, b = 0.2, s - 1.0
    tension = min(float(mp.exp(a * start**s / s)), 1e300)
    assert (
        worst_law_error([("wrap-power", [a, b, 0.0], (0.04, 0.005, 3.0, tension))], slopes=False)
        < 8 * EPS / s
    )


@pytest.mark.parametrize("b", [-1.0, -1.0 - 2.0**-52, -1.5, -1e300])
def test_from_zero_the_integral_diverges_and_is_refused(b, refused):
    pull = one_condition(0.04, 0.005, 7.0, 20.0)
    for name in ("wrap-power", "wrap-power-from-zero"):
        refused(lambda name=name: ALL_LAWS[name].log_lift([0.2, b, 0.1], pull), "diverges for k <= -1")
    for name in ("coupled", "coupled-from-zero"):
        refused(
            lambda name=name: ALL_LAWS[name].log_lift([0.2, -0.2, -0.3, b, 0.1], pull), "diverges for k <= -1"
        )
