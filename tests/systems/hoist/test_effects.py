"""Each effect of a hoist changes the answer by what its own formula says."""

import math
from dataclasses import replace

import numpy as np
import pytest
from paper import law_of
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from ropefric.errors import InputError
from ropefric.friction.condition import one_condition
from ropefric.friction.laws.bending import lifted_arc_rad
from ropefric.systems.effect import log_change
from ropefric.systems.hoist.contact import GRAVITY_M_S2, HoistProblem
from ropefric.systems.hoist.effects import SYSTEM


def own(problem):
    return one_condition(problem.wheel_radius_m[0], problem.rope_radius_m[0], problem.wrap_angle_rad[0],
                         problem.end_tension_N[0])  # fmt: skip


def test_without_effects_it_is_the_capstan_with_the_coefficient_of_the_reference(full_problem, solved):
    friction = full_problem.friction
    mu = friction.law.average_mu(friction.theta, friction.reference)[0]
    lift = solved(full_problem, [])
    assert lift.lift_force_N[0] == pytest.approx(80.0 * math.exp(mu * 9.42), rel=1e-14)


def test_with_what_a_law_may_be_told_it_is_the_law_itself(full_problem, solved):
    lift = solved(full_problem, ["wrap-dependence", "size", "end-tension"])
    law, theta = full_problem.friction.law, full_problem.friction.theta
    assert lift.log_lift[0] == pytest.approx(law.log_lift(theta, own(full_problem))[0], rel=1e-14)


def test_each_effect_alone_tells_the_law_one_thing(full_problem, solved):
    for effect, at_the_reference in [
        ("wrap-dependence", {"wheel_radius_m", "rope_radius_m", "end_tension_N"}),
        ("size", {"wrap_angle_rad", "end_tension_N"}),
        ("end-tension", {"wheel_radius_m", "rope_radius_m", "wrap_angle_rad"}),
    ]:
        friction = full_problem.friction
        seen = {name: getattr(friction.reference if name in at_the_reference else full_problem, name)[0]
                for name in ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N")}  # fmt: skip
        mu = friction.law.average_mu(friction.theta, one_condition(**seen))[0]
        assert solved(full_problem, [effect]).log_lift[0] == pytest.approx(
            math.log(80.0) + mu * 9.42, rel=1e-14
        ), effect


def test_all_effects_together_are_what_the_rope_element_integrates_to(full_problem, solved):
    """An independent solution: dF/dφ = μ(φ) (F − c − E) along the arc in contact, its ends found by bisection."""
    problem, friction = full_problem, full_problem.friction
    mu_inf, a, b, c_power, d = friction.theta
    ratio = problem.wheel_radius_m[0] / problem.rope_radius_m[0]
    mu_R = mu_inf * (1.0 - math.exp(a * ratio + b))
    circling = 0.062 * 3.0**2
    stiff = 1e-3 / (2.0 * (0.04 + 0.0049) ** 2)
    slack_N = 80.0 + 0.062 * GRAVITY_M_S2 * 5.0
    pressing = slack_N - circling - stiff
    exponent = c_power + 1.0
    phi_0 = brentq(lambda phi: mu_R * phi**exponent / exponent + d * phi - math.log(pressing), 1e-9, 1e3,
                   xtol=1e-14, rtol=1e-15)  # fmt: skip

    def tight_N(contact):
        run = solve_ivp(lambda phi, F: (mu_R * phi**c_power + d) * (F - circling - stiff),
                        (phi_0, phi_0 + contact), [slack_N], method="DOP853", rtol=1e-13, atol=1e-10)  # fmt: skip
        return run.y[0, -1]

    def gap(contact):
        ends = [float(lifted_arc_rad(stiff / (F - circling))) for F in (slack_N, tight_N(contact))]
        return 9.42 - sum(ends) - contact

    contact = brentq(gap, 8.0, 9.42, xtol=1e-13)
    lift = solved(problem)
    assert lift.contact_rad[0] == pytest.approx(contact, rel=1e-11)
    assert lift.lift_force_N[0] == pytest.approx(tight_N(contact), rel=1e-10)


def test_what_cannot_be_is_refused_by_name(full_problem, solved):
    for change, words in [({"speed_m_s": 40.0}, "lifts off the wheel"),
                          ({"bending_stiffness_N_m2": 1.0}, "too stiff to follow"),
                          ({"bending_stiffness_N_m2": 0.1, "wrap_angle_rad": 0.4}, "never touches")]:  # fmt: skip
        with pytest.raises(InputError, match=words):
            solved(replace(full_problem, **change))


def test_numbers_out_of_range_are_refused(full_problem):
    for name in ["wheel_radius_m", "end_tension_N", "bending_stiffness_N_m2", "speed_m_s"]:
        with pytest.raises(InputError, match=name):
            replace(full_problem, **{name: math.nan if name == "speed_m_s" else -1.0})


def test_a_law_that_has_the_stiffness_in_it_does_not_get_it_twice():
    friction = law_of("bending", [0.2, 1e-3], (0.04, 0.005, 3.0, 60.0))
    rope = HoistProblem(friction=friction, wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=6.0,
                        end_tension_N=60.0, bending_stiffness_N_m2=1e-3)  # fmt: skip
    assert SYSTEM.effects["bending-stiffness"].needs(rope)


def test_a_law_that_helps_the_rope_to_slip_is_refused(solved):
    friction = law_of("constant-offset", [0.1, -0.3], (0.04, 0.005, 6.0, 60.0))
    rope = HoistProblem(
        friction=friction, wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=2.0, end_tension_N=60.0
    )
    assert solved(rope, []).log_lift > np.log(60.0)
    with pytest.raises(InputError, match="negative coefficient"):
        solved(rope, ["wrap-dependence"])


def test_an_answer_that_one_side_alone_has_is_an_infinite_change():
    numbers = np.array([1.0, np.nan, np.inf])
    assert log_change(numbers, numbers) == 0.0
    for others in ([np.nan, np.nan, np.inf], [1.0, 2.0, np.inf], [1.0, np.nan, 3.0]):
        assert log_change(numbers, np.array(others)) == np.inf
