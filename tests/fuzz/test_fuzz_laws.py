"""Laws with any parameters inside their bounds: friction adds to the load, and every tendency has its sign."""

import numpy as np
from fuzz_kit import answered, fuzzed
from hypothesis import strategies as st

from ropefric.friction.condition import Conditions
from ropefric.friction.laws import ALL_LAWS

# A part of the way from the lower to the upper bound, or so many decades below the typical value.
PLACE = st.floats(0, 1) | st.integers(-300, -1).map(float) | st.sampled_from([0.0, 1.0])
WRAPS = np.array([0.0, 1e-9, 0.5, 3.0, 9.0, 60.0, 700.0])


def _theta(law, places):
    theta = []
    for item, place in zip(law.parameters, places, strict=False):
        inside = item.lower + place * (item.upper - item.lower)
        theta.append(inside if place >= 0 else min(max(item.start * 10.0**place, item.lower), item.upper))
    return theta


def check_tendencies(name, places, wheel, rope, tension):
    """F_A rises with the wrap and with F_B, is never below F_B, and the slopes say the same."""
    law = ALL_LAWS[name]
    theta = _theta(law, places)
    along = Conditions(wheel_radius_m=wheel, rope_radius_m=rope, wrap_angle_rad=WRAPS, end_tension_N=tension)
    said = []
    lift = answered(lambda: law.log_lift(theta, along), said)
    if lift is None:
        # Either the law says why, or a number on the way is beyond every float.
        assert law.validity(theta, along) or "floats overflow" in said[0]
        return
    if name != "constant-offset":  # whose constant may be negative
        assert (lift >= along.log_end_tension).all()
    slack = 4e-15 * np.abs(lift).max()
    assert (np.diff(lift) >= -slack).all()
    heavier = Conditions(wheel_radius_m=wheel, rope_radius_m=rope, wrap_angle_rad=WRAPS,
        end_tension_N=tension * 1.5)  # fmt: skip
    more = answered(lambda: law.log_lift(theta, heavier))
    if more is not None:
        assert (more >= lift - 2 * slack).all()
    slopes = answered(lambda: law.log_lift_gradient_conditions(theta, along))
    if slopes is not None:
        assert (slopes[:, 1] >= 0.0).all()
        assert (slopes[:, 2] >= 0.0).all()
        if "size" in law.effects and name != "bending":
            assert (slopes[:, 0] >= 0.0).all()
        if "wrap-dependence" in law.effects:
            assert (np.diff(slopes[:, 1]) <= 1e-12 * slopes[:-1, 1]).all()
    force = answered(lambda: law.log_lift(theta, along.select([0, 1, 2])))
    assert force is None or np.isfinite(force).all()


test_tendencies, test_tendencies_long = fuzzed(check_tendencies, short=100, share=0.13,
    name=st.sampled_from(sorted(ALL_LAWS)), places=st.lists(PLACE, min_size=5, max_size=5),
    wheel=st.sampled_from([0.04, 0.04, 1e-12, 1e9]) | st.floats(0.005, 1.0),
    rope=st.sampled_from([0.005, 0.005, 1e-9]) | st.floats(0.0005, 0.05),
    tension=st.sampled_from([1.0, 1.0 + 2**-52, 20.0, 0.5, 1e-300, 1e9, 1e300]) | st.floats(0.1,
    1e4))  # fmt: skip
