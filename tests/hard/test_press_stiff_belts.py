"""EA → 1e10: a press whose decay rates lie nine powers of ten apart."""

import numpy as np
from hard_press import linear_start, small_press, true_state
from hard_regime import Regime, once

from ropefric.systems.press.transient.drives import DRIVE_LAWS
from ropefric.systems.press.transient.integrators import INTEGRATORS

REGIME = Regime(
    name="EA → 1e10 N",
    statement="a press starting up with EA = 1e6 … 1e10 N and η = 0 … 0.1 s: every tension after 1.3 s",
    accuracy=1e-8,
)
CASES = [(1e6, 0.0), (1e8, 1e-3), (1e8, 0.1), (1e10, 1e-3), (1e10, 0.1)]
TIME_S = 1.3


def tensions(problem, state):
    return problem.motion.tension_N @ np.concatenate([state, problem.inputs.at(np.array([TIME_S]))[0]])


@once(REGIME)
def measured():
    speed = DRIVE_LAWS["s-curve"](speed_m_s=1.0, duration_s=2.0)
    worst = 0.0
    for EA_N, eta_s in CASES:
        problem = linear_start(small_press(EA_N=EA_N, eta_s=eta_s), speed)
        true = tensions(problem, true_state(problem, TIME_S))
        for times_s in ([TIME_S], np.linspace(0.0, TIME_S, 131)):
            states = INTEGRATORS["exact"](problem, np.array(times_s))
            found = tensions(problem, states[-1, : problem.n_state])
            worst = max(worst, float((np.abs(found - true) / true).max()))
    return worst


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy
