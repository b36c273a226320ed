"""The simulated campaign in `data/prth-bench`: the PRTH paper's series with a truth chosen here."""

import math

from ropefric.rig.plan import CampaignPlan, RigCondition
from ropefric.rig.settings import Bench

PRTH_SEED = 20260
"""The seed `data/prth-bench` was written with."""

# Recordings as short as the paper's phases allow: 432 of them are kept under version control.
_BENCH = Bench(
    idle_s=(0.27, 0.4), dwell_s=(0.3, 0.5), load_s=(1.0, 1.5), slide_s=(0.6, 0.8), off_s=(0.15, 0.25)
)
_CENTRE = (30.0, 540.0, 60.0)  # mm, deg, N
_RADII = (15.0, 20.0, 40.0, 60.0)
_WRAPS = (90.0, 180.0, 270.0, 360.0, 720.0, 900.0, 1080.0)
_LOADS = (20.0, 40.0, 100.0, 150.0, 200.0)
# One factor at a time cannot tell a wrap effect from a load effect; these corners vary several at once. All keep
# F_A above 60 N: below, a drop of a few counts would be lost in the noise of the 1 kN cell.
_CORNERS = (
    (15.0, 180.0, 150.0),
    (60.0, 180.0, 150.0),
    (15.0, 360.0, 200.0),
    (60.0, 360.0, 200.0),
    (20.0, 270.0, 200.0),
    (40.0, 270.0, 100.0),
    (15.0, 720.0, 40.0),
    (60.0, 720.0, 40.0),
    (20.0, 720.0, 20.0),
    (40.0, 720.0, 15.0),
    (15.0, 900.0, 10.0),
    (60.0, 720.0, 10.0),
    (20.0, 1080.0, 80.0),
    (40.0, 900.0, 120.0),
    (15.0, 1080.0, 30.0),
    (60.0, 720.0, 5.0),
    (15.0, 1080.0, 200.0),
    (60.0, 900.0, 60.0),
    (60.0, 810.0, 150.0),
)
_UNSEEN = ((25.0, 450.0, 50.0), (50.0, 630.0, 30.0))


def prth_bench_plan() -> CampaignPlan:
    """Return the plan of `data/prth-bench`: 36 conditions of 12 repeats on five wheels, law `coupled`.

    The paper prints no fitted parameter; these were chosen so that the average μ runs from 0.20 to 0.10 and
    F_A/F_B from 1.3 to about 16.
    """
    radius, wrap, load = _CENTRE
    points = [
        _CENTRE,
        *((other, wrap, load) for other in _RADII),
        *((radius, other, load) for other in _WRAPS),
        *((radius, wrap, other) for other in _LOADS),
        *_CORNERS,
    ]
    return CampaignPlan(
        name="prth-bench",
        law="coupled",
        parameters={"mu_inf": 0.46, "a": -0.22, "b": -0.3, "c": -0.48, "d": 0.055},
        rope_diameter_m=0.0098,
        conditions=tuple(_condition(*point) for point in points),
        design=_condition(35.0, 400.0, 60.0),
        bench=_BENCH,
        unseen=tuple(_condition(*point) for point in _UNSEEN),
    )


def _condition(radius_mm: float, wrap_deg: float, end_tension_N: float) -> RigCondition:
    return RigCondition(
        wheel_radius_m=radius_mm / 1e3, wrap_angle_rad=math.radians(wrap_deg), end_tension_N=end_tension_N
    )
