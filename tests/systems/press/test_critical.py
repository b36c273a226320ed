"""Where each roller begins to slip, against the closed form where there is one."""

from dataclasses import replace

import numpy as np
import pytest
from paper import law_of

from ropefric.systems.press.critical import CHANGES, critical
from ropefric.systems.press.slip import SlipTable
from ropefric.systems.press.statics import solve_statics, steady_state


@pytest.fixture(scope="module")
def statics(paper_press):
    return solve_statics(paper_press)


def test_the_critical_preload_in_closed_form(statics):
    """T'_2 = T'_1 e^{μα} with T'_2 − T'_1 = M_2/R_2 and (35)."""
    swell, c, pull_N = np.expm1(1.2 * np.radians(28.1)), 15 * statics.press.speed_m_s**2, 26.2 / 0.075
    T2 = pull_N / swell + pull_N + c
    cosine = np.cos(np.radians(19.9))
    wanted = T2 * (1 + cosine) + 26.2 / 0.075 * cosine - 600.0
    assert critical(statics, 1.2, "preload").value == pytest.approx(wanted, rel=1e-12)


CALLS = {"preload": lambda x: {"preload_N": x}, "speed": lambda x: {"speed_m_s": x},
         "load": lambda x: {"load_factor": x}}  # fmt: skip


def test_the_utilisation_of_a_law_there_is_one(statics):
    friction = law_of("wrap-power", [1.2, -0.3, 0.2], (0.1, 0.0025, 2, 500))
    for change, call in CALLS.items():
        found = critical(statics, friction, change)
        state = steady_state(statics, **call(found.value), on_slack="flag")
        slip = SlipTable(state.press, state.effective_tension_N, friction)
        assert slip.utilisation.max() == pytest.approx(1.0, abs=1e-9), change
        assert slip.of(found.roller) == slip.utilisation.max()


def test_the_critical_friction_is_where_utilisation_is_one(statics):
    tension_N, found = steady_state(statics).effective_tension_N, critical(statics, 1.2, "friction")
    use = SlipTable(statics.press, tension_N, found.value)
    assert use.of(found.roller) == pytest.approx(1.0, abs=1e-12)
    assert use.utilisation.max() == use.of(found.roller)


def test_a_roller_that_slips_already_says_where_it_stops(statics):
    """With μ = 0.3 roller 2 slips at rest, at 2000 N; more preload would hold it, but no slower run."""
    assert critical(statics, 0.3, "speed")[:4] == ("slips", None, None, None)
    found = critical(statics, 0.3, "preload")
    assert found[:3] == ("slips", "rises", "2")
    assert found.value > 2000.0


def test_nothing_slips_in_an_unloaded_press(paper_press):
    rollers = tuple(replace(r, gravity_torque_N_m=0.0, squeeze_torque_N_m=0.0) for r in paper_press.rollers)
    free = solve_statics(replace(paper_press, rollers=rollers))
    for change in CHANGES:
        assert critical(free, 1.2, change)[:4] == ("holds", None, None, None)


def utilisations(statics, friction, change, value):
    state = steady_state(statics, **CALLS[change](value), on_slack="flag")
    return SlipTable(state.press, state.effective_tension_N, friction).utilisation


def test_the_first_and_the_last_are_those_of_a_scan_from_today(paper_press):
    """Four hundred operating points on the way: all hold, or some slip, up to the value; after it, not."""
    for closure in ["share", "equal", "equal-torque"]:
        for change in CALLS:
            for mu in [0.25, 0.55, 1.2]:
                statics = solve_statics(paper_press, closure=closure)
                today = {"preload": 2000.0, "speed": paper_press.speed_m_s, "load": 1.0}[change]
                found = critical(statics, mu, change)
                holds = bool(utilisations(statics, mu, change, today).max() <= 1.0)
                assert (found.state == "holds") == holds, (closure, change, mu)
                ways = {"rises": np.linspace(today, 5.0 * today, 401),
                        "falls": np.linspace(today, 0.05 * today, 401)}  # fmt: skip
                for way, places in ways.items():
                    some_slip = utilisations(statics, mu, change, places).max(axis=-1) > 1.0
                    turns = np.flatnonzero(some_slip == holds)
                    if way == found.direction:
                        assert found.value is not None, (closure, change, mu)
                        assert (found.value > today) == (way == "rises"), (closure, change, mu)
                        step = 1.01 * abs(places[1] - places[0])
                        reached = turns.size and abs(places[turns[0]] - found.value) <= step
                        assert (reached or abs(found.value - today) > abs(places[-1] - today)
                                or abs(found.value) < 0.05 * today), (closure, change, mu)  # fmt: skip
                        use = utilisations(statics, mu, change, found.value)
                        first = statics.press.rollers[int(np.argmax(use))].name
                        assert (use.max(), first) == (pytest.approx(1.0, abs=1e-9), found.roller)
                    elif found.direction is None:
                        assert not turns.size, (closure, change, mu)


def test_a_law_that_sees_the_roller_names_the_one_that_needs_most_of_its_own(statics):
    """As all coefficients fall in proportion; not the one whose coefficient is largest where it slips."""
    steep = law_of("wrap-power", [1.5, -0.9, 0.05], (0.1, 0.0025, 2, 500))
    found = critical(statics, steep, "friction")
    tension_N = steady_state(statics).effective_tension_N
    slip = SlipTable(statics.press, tension_N, steep)
    assert found.roller == slip.rollers[int(np.argmax(slip.log))]
    assert (found.state, found.direction) == (
        ("slips", "rises") if slip.log.max() > 1 else ("holds", "falls")
    )
