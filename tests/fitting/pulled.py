"""Tables of trials that tests make up: conditions, and what was pulled at them."""

import numpy as np

from ropefric.friction.condition import Conditions
from ropefric.trials.table import TrialTable


def grid(radii, wraps, loads, repeats=1, rope_radius_m=0.005):
    """Every wheel at every wrap at every load, each as often as it is repeated."""
    axes = np.meshgrid(radii, wraps, loads, np.arange(repeats), indexing="ij")
    R, phi, F = (axis.ravel() for axis in axes[:3])
    return Conditions(wheel_radius_m=R, rope_radius_m=rope_radius_m, wrap_angle_rad=phi, end_tension_N=F)


def table_at(at, log_lift, **more):
    """The table of one trial at each condition, in which the rope lifted so much."""
    names = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N")
    settings = {name: getattr(at, name) for name in names}
    trial = tuple(f"t{i}" for i in range(len(at)))
    return TrialTable(trial=trial, peak_N=np.exp(log_lift), **settings, **more)
