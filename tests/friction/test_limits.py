"""Laws turn into each other at their limits, agree with the numbers on paper, and with their own definitions."""

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ropefric.friction.condition import Conditions
from ropefric.friction.laws import LAWS


def pulls(**changes):
    base = {"wheel_radius_m": 0.04, "rope_radius_m": 0.005, "wrap_angle_rad": [0.5, 3.0, 20.0],
            "end_tension_N": 20}  # fmt: skip
    return Conditions(**base | changes)


EULER = np.log(20.0) + 0.2 * np.array([0.5, 3.0, 20.0])


def test_limits_are_eulers_equation():
    for name, theta, change in (
        ("constant", [0.2], {}), ("constant-offset", [0.2, 0.0], {}),
        ("size-power", [0.0, 1.0, 0.2], {}), ("size-power", [0.15, 0.0, 0.05], {}),
        ("size-power", [0.15, 2.0, 0.05], {"wheel_radius_m": 1e16}),
        ("size-exponential", [0.2, -1.0, -50.0], {}), ("size-exponential", [0.2, -1.0, 0.0], {"wheel_radius_m": 1e3}),
        ("wrap-power", [0.0, -0.5, 0.2], {}), ("wrap-power", [0.15, 0.0, 0.05], {}),
        ("wrap-power", [1e-300, -0.5, 0.2], {}),
        ("wrap-exponential", [0.0, -0.5, 0.2], {}), ("wrap-exponential", [0.15, 0.0, 0.05], {}),
        ("wrap-exponential", [0.15, -1e-300, 0.05], {}),
        ("coupled", [0.15, -1.0, -50.0, 0.0, 0.05], {}),
        ("coupled", [0.15, -1.0, 0.0, 0.0, 0.05], {"wheel_radius_m": 1e3}),
        ("thickness", [0.2], {"rope_radius_m": 1e-18}), ("bending", [0.2, 0.0], {}),
        ("howell", [0.2, 1.0], {}), ("howell", [0.2, 1.0 - 1e-15], {}), ("groove", [0.2, np.pi / 2], {}),
    ):  # fmt: skip
        found = LAWS[name].log_lift(theta, pulls(**change))
        np.testing.assert_allclose(found, EULER, rtol=1e-13, err_msg=f"{name} {theta}")


def test_thickness_numbers_on_paper():
    # rope_wheel.md §7.1: μ = .2, R_r = 5 mm, R_w = 20, 30, 50, 100 mm
    wheels = pulls(wheel_radius_m=[0.02, 0.03, 0.05, 0.1], wrap_angle_rad=1.0)
    ratio = LAWS["thickness"].average_mu([0.2], wheels) / 0.2
    assert np.allclose(ratio, [0.795, 0.853, 0.906, 0.951], atol=5e-4)
    # and the printed expression itself
    A = mp.mpf("0.005") / mp.mpf("0.025")
    printed = (-1 + mp.sqrt(1 + 4 * A * mp.mpf("0.04") * (1 - A))) / (2 * A * mp.mpf("0.2"))
    assert float(printed) / 0.2 == pytest.approx(ratio[0], rel=1e-14)


@pytest.mark.parametrize("law_name", ["wrap-power", "wrap-exponential"])
def test_end_tension_is_wrap_in_disguise(law_name):
    """Pulling on from a first pull's F_A is the same as one pull over both wraps."""
    law, theta = LAWS[law_name], [0.2, -0.5, 0.1]
    first = law.log_lift(theta, pulls(wrap_angle_rad=4.0))
    second = law.log_lift(theta, pulls(wrap_angle_rad=7.0, end_tension_N=np.exp(first)))
    assert second[0] == pytest.approx(law.log_lift(theta, pulls(wrap_angle_rad=11.0))[0], rel=1e-13)
    free = law.variant
    light, heavy = (free.average_mu(theta, pulls(end_tension_N=one)) for one in (3, 300))
    np.testing.assert_allclose(light, heavy, rtol=1e-13)


@pytest.mark.parametrize("n", [0.0, 0.9, 1.05])
def test_howell_solves_its_differential_equation(n):
    # dT = A N^n R dφ with N = T/R, R the centreline radius
    R, A = 0.045, 0.3 * (20 / 0.045) ** (1 - n)
    solved = solve_ivp(
        lambda _phi, T: A * (T / R) ** n * R, (0, 6.0), [20.0], rtol=1e-11, atol=1e-9, t_eval=[0.5, 3.0, 6.0]
    )
    answer = LAWS["howell"].log_lift([A, n], pulls(wrap_angle_rad=[0.5, 3.0, 6.0]))
    assert np.allclose(answer, np.log(solved.y[0]), rtol=1e-8)


def test_howell_shows_all_three_trends():
    law, theta = LAWS["howell"], [0.5, 0.8]
    base = law.average_mu(theta, pulls())
    assert (law.average_mu(theta, pulls(end_tension_N=40)) < base).all()
    assert (law.average_mu(theta, pulls(wheel_radius_m=0.08)) > base).all()
    assert base[0] > base[1] > base[2]


def test_bending_starts_from_nothing_where_the_rope_just_touches():
    E = 1e-3 / (2 * 0.045**2)
    touching = 2 * np.arccos(1 - E / 20.0)
    just = pulls(wrap_angle_rad=touching * (1 + 1e-9))
    assert LAWS["bending"].average_mu([0.2, 1e-3], just)[0] == pytest.approx(0.0, abs=1e-8)


def test_groove_is_confounded_with_mu(plan):
    law = LAWS["groove"]
    wide, narrow = law.log_lift([0.1, np.pi / 6], plan), law.log_lift([0.2, np.pi / 2], plan)
    assert np.allclose(wide, narrow, rtol=1e-14)
    J = law.jacobian([0.1, 0.4], plan)
    assert np.linalg.matrix_rank(J) == 1
    assert law.theta_from({"mu": 0.1})[1] == pytest.approx(np.radians(20))
