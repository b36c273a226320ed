"""The lift force itself and the running rope."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ropefric.errors import InputError
from ropefric.friction.condition import Conditions
from ropefric.friction.law import LiftModel
from ropefric.friction.laws import LAWS


def pull(wrap=10.0, tension=20.0):
    return Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=wrap, end_tension_N=tension)


def test_running_rope_at_rest_is_the_static_law():
    for name in ("constant", "howell"):
        law = LAWS[name]
        theta = [parameter.start for parameter in law.parameters]
        moving = LiftModel(law=law, linear_density_kg_m=0.06, speed_m_s=0.0).log_lift([theta, theta], pull())
        assert moving.tolist() == [law.log_lift(theta, pull()).tolist()] * 2


@pytest.mark.parametrize("speed", [1.0, 17.0])
def test_running_rope_solves_its_differential_equation(speed):
    """dF/dφ = μ (F − ρv²), with μ of eq. (15) where the pressing tension has started from 1 N."""
    inertia = 0.06 * speed**2
    a, b, c = 0.2, -0.5, 0.1
    # Backwards from F_B to where the pressing tension is 1 N, then forwards over φ0 + φ.
    low, high = 0.0, np.log(20 - inertia) / c
    for _ in range(100):
        middle = 0.5 * (low + high)
        short = 2 * a * np.sqrt(middle) + c * middle < np.log(20 - inertia)
        low, high = (middle, high) if short else (low, middle)
    solved = solve_ivp(
        lambda phi, F: (a * phi**b + c) * (F - inertia), (low, low + 10.0), [20.0], rtol=1e-11, atol=1e-9
    )
    model = LiftModel(law=LAWS["wrap-power"], linear_density_kg_m=0.06, speed_m_s=speed)
    answer = model.log_lift([a, b, c], pull())
    assert answer[0] == pytest.approx(np.log(solved.y[0, -1]), rel=1e-8)


def test_end_tension_just_above_the_inertia():
    inertia = 0.0625 * 16.0**2  # 16 N, exact in floats
    barely = pull(tension=inertia * (1 + 2**-50))
    fast = LiftModel(law=LAWS["constant"], linear_density_kg_m=0.0625, speed_m_s=16.0)
    answer = fast.log_lift([0.2], barely)
    pressing = inertia * 2**-50 * np.exp(2.0)
    assert answer[0] == pytest.approx(np.log(inertia + pressing), rel=1e-15)
    assert answer[0] > np.log(inertia)
    with pytest.raises(InputError, match=r"rho v\^2 = 16 N is not below F_B.*lifts off"):
        fast.log_lift([0.2], pull(tension=16.0))
    with pytest.raises(InputError, match="zero or more"):
        LiftModel(law=LAWS["constant"], linear_density_kg_m=-1.0, speed_m_s=1.0).log_lift([0.2], pull())
