"""A fit, trials made by hand, and central differences."""

from types import SimpleNamespace

import numpy as np
import pytest
from pulled import grid, table_at

from ropefric.fitting.fit import fit_law
from ropefric.friction.laws import LAWS
from ropefric.traces.breakaway import Breakaway, Status
from ropefric.traces.calibration import Calibration, ForceCell
from ropefric.trials.result import Extraction, TrialResult, summarise_conditions


def central_slopes(model):
    """Return ∂f/∂x of a measurement model by central differences."""
    at = model.inputs
    slopes = []
    for i, value in enumerate(at):
        step = np.zeros_like(at)
        step[i] = 1e-5 * max(abs(value), 0.1)
        ends = model.evaluate(np.stack([at + step, at - step]))
        slopes.append((ends[0] - ends[1]) / (2 * step[i]))
    return np.array(slopes)


@pytest.fixture(scope="session")
def slopes_of():
    return central_slopes


@pytest.fixture(scope="session")
def wrap_fit():
    """wrap-power fitted to 18 conditions of three pulls."""
    at = grid([0.04], np.pi * np.array([0.5, 1, 2, 3, 4, 6]), [5.0, 30.0, 150.0], repeats=3)
    noise = 0.017 * np.random.default_rng(11).standard_normal(len(at))
    return fit_law(table_at(at, LAWS["wrap-power"].log_lift([0.2, -0.5, 0.1], at) + noise), "wrap-power")


@pytest.fixture(scope="session")
def pulls():
    """A factory of extractions whose trials were never recorded."""

    def make(*series, tare_N=None, cell=None, rule="none", slack=False):
        trials = []
        for condition, forces in enumerate(series):
            for repeat, force in enumerate(forces):
                tare = 9.0 + 0.01 * repeat if tare_N is None else tare_N
                known = cell or ForceCell(name="K1", full_scale_N=1000.0)
                own = Calibration(cell=known, tare_N=tare, tare_std_N=0.2)
                picked = Breakaway(status=Status.OK, peak_N=force, peak_std_N=0.3, bias_N=-0.12)
                pulled = TrialResult(trial=f"{condition}-{repeat}", file="", wheel_radius_m=0.04,
                    rope_radius_m=0.005, wrap_angle_rad=3.0 * (condition + 1),
                    end_tension_N=force if slack else 60.0, peak_N=60.0 if slack else force, breakaway=picked,
                    kept=True, measures_slack=slack, calibration=own)  # fmt: skip
                trials.append(pulled)
        marked, conditions, problems = summarise_conditions(trials, rule)
        return Extraction(name="made", trials=marked, conditions=conditions, problems=problems)

    return make


@pytest.fixture(scope="session")
def lines_of():
    """The quantities of a measurement model by name."""
    return lambda model: SimpleNamespace(**{item.name.replace(" ", "_"): item for item in model.quantities})
