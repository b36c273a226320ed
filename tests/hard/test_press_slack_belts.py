"""Full speed at once: belts go slack and tight again, and nothing may push or vanish."""

import numpy as np
import pytest
from hard_press import small_press
from hard_regime import Regime, once

from ropefric.systems.press.transient.drives import DRIVE_LAWS
from ropefric.systems.press.transient.start_up import start_up

REGIME = Regime(
    name="slack belts",
    statement="a press thrown to full speed, EA = 1e5 … 1e8 N: what drive, loads, belts, slip and motion leave over "
    "of the energy, and how far any belt pushes",
    accuracy=1e-8,
)
CASES = [(1e5, 0.0), (2e5, 2e-3), (1e7, 1e-3), (1e8, 1e-4)]


def thrown(EA_N, eta_s):
    speed = DRIVE_LAWS["constant"](speed_m_s=1.0)
    return start_up(
        small_press(EA_N=EA_N, eta_s=eta_s), speed=speed, time_s=np.linspace(0.0, 0.3, 601), friction=0.6
    )


@once(REGIME)
def measured():
    worst = 0.0
    for case in CASES:
        found = thrown(*case)
        pushed = max(0.0, -float(found.tension_N.min())) / found.tension_N.max()
        worst = max(worst, found.energy.relative_residual, pushed)
    return worst


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


@pytest.mark.parametrize("case", CASES)
def test_belts_do_go_slack(case):
    assert (thrown(*case).tension_N == 0.0).sum() > 3
