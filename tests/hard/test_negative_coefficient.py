"""e^{a r + b} > 1: the coefficient would be negative, which no friction is; refused by name."""

import numpy as np
import pytest
from hard_regime import Regime

from ropefric.friction.condition import Conditions, one_condition
from ropefric.friction.laws import ALL_LAWS

REGIME = Regime(
    name="e^(a r + b) > 1",
    statement="negative μ: refused, with the condition that is to blame",
    accuracy=None,
)
WAYS = ("log_lift", "jacobian", "log_lift_and_jacobian", "log_lift_gradient_conditions", "average_mu")


def measured():
    return None


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("b", [0.8 + 1e-12, 0.9, 20.0, 1e300])
def test_size_laws_refuse(way, b, refused):
    pull = one_condition(0.02, 0.005, 6.0, 20.0)  # a r = -0.8
    theta = [0.2, -0.2, b]
    error = refused(
        lambda: getattr(ALL_LAWS["size-exponential"], way)(theta, pull), r"so e\^\(a r \+ b\) > 1"
    )
    assert "condition 0" in str(error)
    assert error.fix
    for name in ("coupled", "coupled-from-zero"):
        refused(
            lambda name=name: getattr(ALL_LAWS[name], way)([*theta, -0.4, 0.05], pull), r"e\^\(a r \+ b\) > 1"
        )


def test_the_wheel_to_blame_is_named_and_the_others_have_an_answer(refused):
    pulls = Conditions(
        wheel_radius_m=[0.04, 0.03, 0.01], rope_radius_m=0.005, wrap_angle_rad=6.0, end_tension_N=20
    )
    law, theta = ALL_LAWS["size-exponential"], [0.2, -0.2, 0.5]
    refused(lambda: law.log_lift(theta, pulls), "condition 2")
    assert len(law.validity(theta, pulls)) == 1
    assert not law.admissible(theta, pulls)
    assert np.isfinite(law.log_lift(theta, pulls.select([0, 1]))).all()


def test_just_at_the_edge_there_is_an_answer():
    pull = one_condition(0.02, 0.005, 6.0, 20.0)
    edge = 0.2 * float(pull.size_ratio[0])
    assert ALL_LAWS["size-exponential"].average_mu([0.2, -0.2, edge], pull)[0] == 0.0
    inside = ALL_LAWS["size-exponential"].average_mu([0.2, -0.2, edge - 1e-12], pull)[0]
    assert inside == pytest.approx(0.2e-12, rel=1e-3)  # as exact as a r + b itself, which cancels here


@pytest.mark.parametrize(
    ("name", "theta", "said"),
    [
        ("constant", [-1e-300], "negative"),
        ("wrap-power", [-1e-300, -0.4, 0.1], "coefficient of φ\\^k is .* negative"),
        ("wrap-power", [0.2, -0.4, -1e-300], "constant part of μ is .* negative"),
        ("wrap-exponential", [-1e-300, -0.4, 0.1], "negative: μ would rise"),
        ("wrap-exponential", [0.2, -0.4, -1e-300], "negative: μ turns negative"),
        ("thickness", [-1e-300], "negative"),
        ("groove", [-1e-300, 0.3], "negative"),
        ("howell", [0.0, 0.9], "needs it positive"),
        ("bending", [-1e-300, 1e-4], "negative"),
    ],
)
def test_every_law_refuses_a_negative_coefficient(name, theta, said, refused):
    refused(lambda: ALL_LAWS[name].log_lift(theta, one_condition(0.04, 0.005, 6.0, 20.0)), said)
