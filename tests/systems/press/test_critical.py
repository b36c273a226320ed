"""Where each roller begins to slip, against the closed form where there is one."""

from dataclasses import replace

import numpy as np
import pytest

from ropefric.friction.condition import one_condition
from ropefric.friction.laws import LAWS
from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.critical import CHANGES, critical_values, first_to_slip
from ropefric.systems.press.slip import SlipTable
from ropefric.systems.press.statics import solve_statics
from ropefric.systems.press.steady import steady_state


@pytest.fixture(scope="module")
def statics(paper_press):
    return solve_statics(paper_press)


def test_roller_2_is_first_at_the_printed_preload_and_friction(statics):
    roller, preload_N = first_to_slip(critical_values(statics, 1.2, "preload"), "preload")
    assert roller == "2"
    assert preload_N == pytest.approx(1276.6, abs=0.05)
    roller, mu = first_to_slip(critical_values(statics, 1.2, "friction"), "friction")
    assert roller == "2"
    assert mu == pytest.approx(0.732, abs=5e-4)
    for change in ("speed", "load"):
        assert first_to_slip(critical_values(statics, 1.2, change), change)[0] == "2"


def test_the_critical_preload_in_closed_form(statics):
    """T'_2 = T'_1 e^{μα} with T'_2 − T'_1 = M_2/R_2 and (35)."""
    swell, c, pull_N = np.expm1(1.2 * np.radians(28.1)), 15 * statics.press.speed_m_s**2, 26.2 / 0.075
    T2 = pull_N / swell + pull_N + c
    cosine = np.cos(np.radians(19.9))
    wanted = T2 * (1 + cosine) + 26.2 / 0.075 * cosine - 600.0
    assert critical_values(statics, 1.2, "preload")["2"] == pytest.approx(wanted, rel=1e-12)


CALLS = {
    "preload": lambda x: {"preload_N": x},
    "speed": lambda x: {"speed_m_s": x},
    "load": lambda x: {"load_factor": x},
}


@pytest.mark.parametrize("change", CALLS)
@pytest.mark.parametrize(
    "friction",
    [
        1.2,
        0.5,
        WrapFriction(
            law=LAWS["wrap-power"],
            theta=np.array([1.2, -0.3, 0.2]),
            reference=one_condition(0.1, 0.0025, 2, 500),
        ),
    ],
    ids=["constant", "slippery", "law"],
)
def test_the_utilisation_there_is_one(statics, change, friction):
    values = critical_values(statics, friction, change)
    checked = 0
    for i, value in enumerate(values.values()):
        if value:  # 0.0 and None: slips at rest, or never
            state = steady_state(statics, **CALLS[change](value), on_slack="flag")
            assert SlipTable(state.press, state.effective_tension_N, friction).utilisation[
                i
            ] == pytest.approx(1.0, abs=1e-9)
            checked += 1
    assert checked >= 1


def test_the_critical_friction_is_where_utilisation_is_one(statics):
    tension_N = steady_state(statics).effective_tension_N
    for i, mu in enumerate(critical_values(statics, 1.2, "friction").values()):
        if mu is not None:
            assert SlipTable(statics.press, tension_N, mu).utilisation[i] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("change", CHANGES)
def test_rollers_without_torque_never_slip(statics, change):
    values = critical_values(statics, 1.2, change)
    assert [name for name in ("4", "11", "12") if values[name] is not None] == []


def test_a_roller_that_slips_already_says_so(statics):
    """With μ = 0.3 roller 2 slips at rest, at 2000 N; more preload would hold it."""
    assert critical_values(statics, 0.3, "speed")["2"] == 0.0
    assert critical_values(statics, 0.3, "preload")["2"] > 2000.0


def test_nothing_slips_in_an_unloaded_press(paper_press):
    rollers = tuple(replace(r, gravity_torque_N_m=0.0, squeeze_torque_N_m=0.0) for r in paper_press.rollers)
    free = solve_statics(replace(paper_press, rollers=rollers))
    for change in CHANGES:
        assert first_to_slip(critical_values(free, 1.2, change), change) is None
