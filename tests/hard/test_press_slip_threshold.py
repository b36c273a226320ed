"""The moment at which a roller begins to slip: the tensions in many digits stand exactly at e^M."""

import numpy as np
from hard_press import WRAP_RAD, linear_start, small_press, true_state
from hard_regime import Regime, once

from ropefric.systems.press.transient.drives import DRIVE_LAWS
from ropefric.systems.press.transient.start_up import start_up

REGIME = Regime(
    name="slip threshold",
    statement="tight over slack tension at the computed start of slip, μ = 0.02 … 0.6, over e^M with the belt's mass",
    accuracy=1e-8,
)
CASES = [(2e5, 2e-3, 0.02), (2e5, 2e-3, 0.3), (1e7, 1e-3, 0.6), (1e8, 0.1, 0.3)]
MASS_KG = 8.0 * 0.1 * WRAP_RAD
DRIVE_MASS_KG = 8.0 * 0.1 * 3.0


def ratio_over_limit(EA_N, eta_s, mu):
    """Return T'_tight/T'_slack over e^M at the first slip, with q = ρAR²θ''/μ as in eq. (37)."""
    press = small_press(EA_N=EA_N, eta_s=eta_s, load_N_m=30.0)
    speed = DRIVE_LAWS["s-curve"](speed_m_s=1.0, duration_s=0.5)
    found = start_up(press, speed=speed, time_s=[0.5], friction=mu)
    slip = found.slips[0]
    problem = linear_start(press, speed)
    state = true_state(problem, slip.start_s)
    w = np.concatenate([state, problem.inputs.at(np.array([slip.start_s]))[0]])
    T = problem.motion.tension_N @ w - 8.0 * float(speed(slip.start_s)) ** 2
    if slip.roller == "drive":
        wrap, mass, before, behind, way = 3.0, DRIVE_MASS_KG, T[2], T[0], -1.0
        acceleration = float(speed.derivative()(slip.start_s))
    else:
        assert slip.roller == "load"
        wrap, mass, before, behind, way = WRAP_RAD, MASS_KG, T[0], T[1], 1.0
        acceleration = (T[1] - T[0] - 300.0 * float(speed(slip.start_s))) / (0.3 / 0.01 + mass)
    q = way * mass * acceleration / (mu * wrap)
    tight, slack = (behind, before) if way > 0 else (before, behind)
    return (tight + q) / (slack + q) / np.exp(mu * wrap)


@once(REGIME)
def measured():
    return max(abs(ratio_over_limit(*case) - 1.0) for case in CASES)


def test_it_is_met():
    assert measured() <= REGIME.accuracy
