"""Trial tables with known truth, and the 21 trials of a rope on a cylinder."""

import numpy as np
import pytest
from pulled import table_at

from ropefric.fitting.compare import compare_laws
from ropefric.fitting.fit import fit_law
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import ALL_LAWS
from ropefric.trials.table import TrialTable

# F_hold [N] per trial at seven measured wraps [rad], load 7.8816 N: phy_mini_ia_capstan, student-grade rig.
WEIGHT_N = 7.8816
HOLD_N = {0.924659: (6.591050, 6.594155, 6.603858), 1.544442: (6.116782, 6.094271, 6.068656),
    2.314410: (5.213459, 5.354149, 5.274198), 3.050048: (4.582977, 4.576574, 4.589381),
    4.138666: (3.345494, 3.572731, 3.655787), 4.749059: (3.490064, 3.595630, 3.263021),
    5.472672: (2.824070, 2.910619, 2.996779)}  # fmt: skip


@pytest.fixture(scope="session")
def cylinder_table():
    wrap = np.repeat(list(HOLD_N), 3)
    hold = np.concatenate([np.array(values) for values in HOLD_N.values()])
    return TrialTable(trial=tuple(f"t{i}" for i in range(21)), wheel_radius_m=0.02, rope_radius_m=0.003,
        wrap_angle_rad=wrap, end_tension_N=hold, peak_N=WEIGHT_N)  # fmt: skip


def make_campaign(law, theta, *, radii=(0.03,), loads=(5.0, 20.0, 80.0), wraps_deg=(90, 180, 360, 540, 720),
        repeats=5, within=0.01, between=0.0, seed=0):  # fmt: skip
    """Pulls that obey a law, wheel by wheel, load by load, wrap by wrap."""
    rng = np.random.default_rng(seed)
    axes = [axis.ravel() for axis in np.meshgrid(radii, loads, np.radians(wraps_deg), indexing="ij")]
    R, F, phi = (np.repeat(axis, repeats) for axis in axes)
    at = Conditions(wheel_radius_m=R, rope_radius_m=0.005, end_tension_N=F, wrap_angle_rad=phi)
    shared = np.repeat(between * rng.standard_normal(axes[0].size), repeats)
    return table_at(at, ALL_LAWS[law].log_lift(theta, at) + shared + within * rng.standard_normal(len(at)))


@pytest.fixture(scope="session")
def campaign():
    return make_campaign


@pytest.fixture(scope="session")
def cylinder_comparison(cylinder_table):
    return compare_laws(cylinder_table)


@pytest.fixture(scope="session")
def wrap_fit():
    return fit_law(make_campaign("wrap-power", [0.2, -0.5, 0.1], between=0.005), "wrap-power")


@pytest.fixture(scope="session")
def constant_fit():
    return fit_law(make_campaign("constant", [0.2], between=0.005), "constant")


@pytest.fixture(scope="session")
def coupled_fit():
    truth = [0.25, -0.2, -0.3, -0.4, 0.05]
    return fit_law(make_campaign("coupled", truth, radii=(0.02, 0.03, 0.05, 0.08), repeats=3), "coupled")
