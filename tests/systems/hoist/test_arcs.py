"""Slip and stick under a payload: Euler's arc, the wrap's own coefficient against an integration, and the limits."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ropefric.friction.condition import one_condition
from ropefric.friction.laws import LAWS
from ropefric.systems.friction import WrapFriction
from ropefric.systems.hoist.contact import GRAVITY_M_S2, HoistProblem

LIGHT = ("wrap-dependence", "size", "end-tension")


def hoist(friction, payload_N, **more):
    given = {"wheel_radius_m": 0.04, "rope_radius_m": 0.0049, "wrap_angle_rad": 9.42, "end_tension_N": 80.0}
    return HoistProblem(friction=friction, payload_kg=np.asarray(payload_N) / GRAVITY_M_S2, **given | more)


def test_a_constant_coefficient_gives_eulers_arc(solved):
    payload_N = np.array([100.0, 200.0, 400.0])
    arcs = solved(hoist(WrapFriction.constant(0.2), payload_N)).arcs
    np.testing.assert_allclose(arcs.slip_rad, np.log(payload_N / 80.0) / 0.2, rtol=1e-12)
    np.testing.assert_allclose(arcs.slip_rad + arcs.stick_rad, 9.42, rtol=1e-14)


@pytest.mark.parametrize(("name", "theta"),
                         [("wrap-power", (0.2, -0.5, 0.1)), ("wrap-exponential", (0.15, -0.1, 0.1)),
                          ("coupled", (0.46, -0.22, -0.3, -0.48, 0.055)),
                          ("wrap-power-from-zero", (0.1, -0.3, 0.1)), ("howell", (0.3, 0.9))])  # fmt: skip
def test_the_arc_of_a_coefficient_that_changes_is_where_an_integration_reaches_the_payload(
    solved, name, theta
):
    """dT/dφ = μ(φ) T from F_B on, the step at which T is the payload's weight: no closed form, no root."""
    law = {**LAWS, LAWS["wrap-power"].variant.name: LAWS["wrap-power"].variant}[name]
    friction = WrapFriction(law=law, theta=np.array(theta), reference=one_condition(0.05, 0.0049, 6.0, 60.0))
    at = one_condition(0.04, 0.0049, 1.0, 80.0)
    payload_N = 160.0
    # From zero the coefficient begins infinite: the first bit is the law's own.
    start = 1e-3
    first = float(law.log_lift(theta, replace(at, wrap_angle_rad=np.array([start])))[0])

    def reached(angle, y):
        return y[0] - np.log(payload_N)

    reached.terminal = True
    run = solve_ivp(lambda angle, y: law.local_mu(theta, angle, at), (start, 9.42), [first], events=reached,
                    rtol=1e-10, atol=1e-12)  # fmt: skip
    arcs = solved(hoist(friction, payload_N)).arcs
    assert arcs.slip_rad[0] == pytest.approx(run.t_events[0][0], rel=1e-7)


def test_all_of_it_slips_at_the_lift_force_and_beyond_and_none_without_a_pull(solved, coupled):
    lift_N = float(solved(hoist(coupled, 100.0)).lift_force_N[0])
    arcs = solved(hoist(coupled, np.array([80.0, lift_N * (1.0 - 1e-9), lift_N * 1.001, 5.0 * lift_N]))).arcs
    assert arcs.slip_rad[0] == 0.0
    assert arcs.slip_rad[1] == pytest.approx(9.42, rel=1e-6)
    assert arcs.slip_rad[1] < 9.42
    assert arcs.slip_rad[2:].tolist() == [9.42, 9.42]
    assert arcs.stick_rad[2:].tolist() == [0.0, 0.0]


def test_more_payload_slips_farther_and_more_end_tension_less(solved, coupled):
    slip = solved(hoist(coupled, np.linspace(90.0, 300.0, 9))).arcs.slip_rad
    assert (np.diff(slip) > 0.0).all()
    held = solved(hoist(coupled, 250.0, end_tension_N=np.linspace(60.0, 200.0, 9))).arcs.slip_rad
    assert (np.diff(held) < 0.0).all()


def test_what_does_not_press_is_taken_off_both_sides(solved):
    """P = F − ρv² − EI/2R² counts, the arcs where a stiff rope stands off do not."""
    density, speed, stiffness = 0.062, 12.0, 1e-3
    problem = hoist(WrapFriction.constant(0.2), 200.0, linear_density_kg_m=density, speed_m_s=speed,
                    bending_stiffness_N_m2=stiffness)  # fmt: skip
    lift = solved(problem, ["centrifugal", "bending-stiffness"])
    circling_N, bent_N = density * speed**2, stiffness / (2.0 * 0.0449**2)
    idle_N = circling_N + bent_N
    assert lift.arcs.slip_rad[0] == pytest.approx(np.log((200.0 - idle_N) / (80.0 - idle_N)) / 0.2, rel=1e-12)
    away_rad = sum(np.arccos(1.0 - bent_N / (force_N - circling_N)) for force_N in (80.0, 200.0))
    assert lift.arcs.slip_rad[0] + lift.arcs.stick_rad[0] == pytest.approx(9.42 - away_rad, rel=1e-12)
    assert np.isnan(solved(replace(problem, payload_kg=0.5), ["centrifugal"]).arcs.slip_rad[0])


def test_a_payload_below_the_end_tension_slips_the_other_way(solved):
    arcs = solved(hoist(WrapFriction.constant(0.2), 40.0)).arcs
    assert arcs.slip_rad[0] == pytest.approx(np.log(2.0) / 0.2, rel=1e-12)


def test_a_payload_that_the_law_has_no_answer_to_leaves_the_lift_force(solved, coupled):
    """Below F_0 = 1 N no wrap stands for a tension."""
    lift = solved(hoist(coupled, 0.5))
    assert np.isnan(lift.arcs.slip_rad[0])
    assert lift.lift_force_N[0] == solved(hoist(coupled, 100.0)).lift_force_N[0]


def test_without_a_payload_there_is_no_such_arc(solved, full_problem):
    assert solved(full_problem).arcs is None
