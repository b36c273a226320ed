"""Slip: the paper's factor and its inversion, and measures that are 1 exactly where friction ends."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from paper import law_of, with_roller

from ropefric.errors import InputError
from ropefric.friction.condition import Conditions, one_condition
from ropefric.friction.laws import LAWS
from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.slip import SlipTable
from ropefric.systems.press.statics import solve_statics, steady_state


def steady_tension_N(press, closure="share"):
    return steady_state(solve_statics(press, closure=closure)).effective_tension_N


@pytest.fixture(scope="module")
def paper_slip(paper_press, paper_data):
    return SlipTable(paper_press, steady_tension_N(paper_press), paper_data["mu"])


# --- what the paper says of its figures ------------------------------------------------------------------


@pytest.fixture(scope="module")
def trends(paper_press, paper_data):
    """Slip over the preload and over the speed, and the tensions over the speed."""
    statics = solve_statics(paper_press)
    preload = steady_state(statics, preload_N=np.linspace(1500, 4000, 11)[:, None])
    speed = steady_state(statics, speed_m_s=2 * np.pi / 60 * 0.175 * np.linspace(0, 100, 11))
    over = [SlipTable(paper_press, one.effective_tension_N, paper_data["mu"]) for one in (preload, speed)]
    return (*over, speed.effective_tension_N)


def test_the_inverted_ratio_follows_the_text_and_the_printed_one_contradicts_it(trends):
    """Λ2 and Λ5 fall with preload and rise with speed; (38) as printed does the opposite on these very rollers."""
    preload, speed, _ = trends
    for roller in ["2", "5"]:
        for name, way in (("as_plotted", 1.0), ("as_printed", -1.0)):
            assert (way * np.diff(preload.of(roller, name)) < 0).all(), (roller, name)
            assert (way * np.diff(speed.of(roller, name)) > 0).all(), (roller, name)


def test_only_the_inverted_ratio_lets_rollers_2_and_4_exceed_one(trends):
    above = {name: {roller for roller in trends[1].rollers if (trends[1].of(roller, name) > 1.0).any()}
             for name in ("as_printed", "as_plotted")}  # fmt: skip
    assert above == {"as_plotted": {"2", "4"}, "as_printed": {"4"}}


def test_the_rollers_called_small_are_the_smallest_as_plotted(paper_slip):
    order = [paper_slip.rollers[i] for i in np.argsort(paper_slip.as_plotted)]
    assert set(order[:6]) == {"1", "3", "6", "7", "8", "13"}
    printed = [paper_slip.rollers[i] for i in np.argsort(paper_slip.as_printed)]
    assert set(printed[:6]) == {"1", "3", "6", "7", "8", "13"}  # the statement does not tell the two apart


def test_unloaded_rollers_keep_their_printed_factor(trends):
    """Λ4, Λ11 and Λ12 are constant, which says that (38) is not 0 without torque."""
    for roller in ("4", "11", "12"):
        factor = trends[1].of(roller, "as_plotted")
        np.testing.assert_allclose(factor, factor[0], rtol=1e-12)
        assert factor[0] > 0.2
        np.testing.assert_allclose(trends[1].of(roller), 0.0, atol=1e-12)


def test_tensions_fall_only_slightly_with_speed(trends):
    falling = trends[2]
    assert (np.diff(falling, axis=0) < 0).all()
    assert ((falling[0] - falling[-1]) / falling[0] < 0.065).all()


# --- exactly 1 at the limit ------------------------------------------------------------------------------


def law_friction(b, *, a=0.5, c=0.1):
    return law_of("wrap-power", [a, b, c], (0.2, 0.0025, 2.0, 500.0))


def test_utilisation_is_one_at_the_limit(paper_press):
    """Tensions of which the tight one is e^M times the slack one, on a driven roller and on a driver."""
    for friction in [0.8, law_friction(-0.5), law_friction(-0.8)]:
        for turned in [False, True]:
            law = friction if isinstance(friction, WrapFriction) else WrapFriction.constant(friction)
            roller = paper_press.rollers[1]
            exponent = law.exponent(wheel_radius_m=roller.radius_m, rope_radius_m=0.0025,
                                    wrap_angle_rad=roller.wrap_angle_rad, slack_tension_N=500.0)  # fmt: skip
            tension_N = np.full(14, 500.0)
            tension_N[0 if turned else 1] *= float(np.exp(exponent))
            table = SlipTable(paper_press, tension_N, friction)
            assert float(table.of("2")) == pytest.approx(1.0, abs=1e-12), (friction, turned)
            assert float(table.of("2", "log")) == pytest.approx(1.0, abs=1e-12), (friction, turned)
            wanted = float(exponent) / roller.wrap_angle_rad
            assert float(table.of("2", "mu_required")) == pytest.approx(wanted, rel=1e-12), (friction, turned)


# --- friction laws ---------------------------------------------------------------------------------------


def test_a_law_sees_radius_thickness_and_slack_tension_of_each_roller(paper_press):
    law, theta = LAWS["coupled"], np.array([0.4, -0.02, -0.3, -0.4, 0.1])
    friction = WrapFriction(law=law, theta=theta, reference=one_condition(0.1, 0.0025, 2.0, 500.0))
    tension_N = steady_tension_N(paper_press)
    found = SlipTable(paper_press, tension_N, friction).exponent
    slack = np.minimum(tension_N @ paper_press.into.T, tension_N @ paper_press.out_of.T)
    at = Conditions(wheel_radius_m=np.array([roller.radius_m for roller in paper_press.rollers]),
                    rope_radius_m=0.0025,
                    wrap_angle_rad=np.array([roller.wrap_angle_rad for roller in paper_press.rollers]),
                    end_tension_N=slack)  # fmt: skip
    np.testing.assert_allclose(found, law.log_lift(theta, at) - np.log(slack), rtol=1e-12)


def test_a_coefficient_is_positive(paper_press):
    for mu in [0.0, -1.0, float("nan"), float("inf")]:
        with pytest.raises(InputError, match="mu is"):
            SlipTable(paper_press, steady_tension_N(paper_press), mu)


def test_a_law_without_friction_holds_what_has_no_torque(paper_press):
    friction = law_of("constant", [0.0], (0.2, 0.0025, 2.0, 500.0))
    table = SlipTable(paper_press, steady_tension_N(paper_press), friction)
    usual = SlipTable(paper_press, steady_tension_N(paper_press), 1.2)
    for measure in ("utilisation", "log"):
        loaded = getattr(usual, measure) > 1e-12
        assert (getattr(table, measure) == np.where(loaded, np.inf, 0.0)).all()
    assert table.mu_required == pytest.approx(usual.mu_required, rel=1e-13)


def test_a_belt_that_lifts_off_has_no_grip(paper_press):
    state = steady_state(solve_statics(paper_press), preload_N=[100.0, 2000.0], on_slack="flag")
    table = SlipTable(paper_press, state.effective_tension_N, 1.2)
    for name in ("utilisation", "log", "mu_required"):
        values = getattr(table, name)
        assert np.isinf(values[0, :2]).all()  # span 1 is slack: rollers 1 and 2
        assert np.isfinite(values[0, 2:]).all()
        assert np.isfinite(values[1]).all()


# --- tendencies ------------------------------------------------------------------------------------------

PROVABLE = st.sampled_from(["share", "equal-torque"])


@given(closure=PROVABLE, mu=st.floats(0.05, 2.0), speed_m_s=st.floats(0.0, 4.0), load=st.floats(0.01, 1.0),
       preload_N=st.floats(1600.0, 5000.0), more=st.floats(1e-3, 0.4))  # fmt: skip
@settings(max_examples=20, deadline=None)
def test_more_preload_never_raises_utilisation_nor_does_more_load_lower_it(
    paper_press, *, closure, mu, speed_m_s, load, preload_N, more
):
    """Constant μ, all tensioners and all loads together, closures that split by the loads alone."""
    state = steady_state(solve_statics(paper_press, closure=closure), speed_m_s=speed_m_s, on_slack="flag",
                         preload_N=[preload_N, preload_N * (1.0 + more), preload_N],
                         load_factor=[load, load, load + more])  # fmt: skip
    less, tighter, heavier = SlipTable(state.press, state.effective_tension_N, mu).utilisation
    assert (tighter <= less * (1 + 1e-12) + 1e-12).all()
    assert (heavier >= less * (1 - 1e-12) - 1e-12).all()


def test_outside_that_domain_it_does_not_hold(paper_press):
    """One load alone tightens another roller's slack side; `equal` moves load between the drivers; μ may fall."""
    machine = with_roller(paper_press, "3", gravity_torque_N_m=60.0)
    heavier = SlipTable(machine, steady_tension_N(machine), 1.2).utilisation
    base = SlipTable(paper_press, steady_tension_N(paper_press), 1.2).utilisation
    assert heavier[4] < base[4]
    more = replace(paper_press.tensioners["3"], force_N=3000.0)
    tighter = with_roller(paper_press, "3", tensioner=more)
    one, other = (SlipTable(press, steady_tension_N(press, closure="equal"), 1.2).utilisation
                  for press in (paper_press, tighter))  # fmt: skip
    assert other[9] > one[9]
    friction = law_friction(-0.9, a=0.5, c=0.0)
    state = steady_state(solve_statics(paper_press), preload_N=[2000.0, 4000.0])
    less, tighter = SlipTable(state.press, state.effective_tension_N, friction).utilisation
    loaded = SlipTable(paper_press, steady_tension_N(paper_press), 1.2).mu_required > 5e-5
    assert (tighter > less)[loaded].any()
