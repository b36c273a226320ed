"""Plans carried out: pulls simulated from the law with scatter, and on the virtual rig, fitted and predicted."""

import math
from dataclasses import replace

import numpy as np
import pytest
from pulled import table_at
from thinned import thinned

from ropefric.fitting.exchange import Exchange, best_plan
from ropefric.fitting.fit import fit_law
from ropefric.fitting.next_tests import allowed_conditions, plan_tests
from ropefric.fitting.predict import predict
from ropefric.fitting.resolution import MeanScatter
from ropefric.fitting.result import CommonError

# What a plan must be better by in the width of the interval of the wanted lift force.
WORTHWHILE = 1.5


@pytest.fixture
def compared(bench, guessed, wanted, *, campaigns, usual):
    """Carry out a plan and one factor at a time, n campaigns each."""

    def run(name, where, n):
        planned, target = guessed(name), wanted(where)
        plan = plan_tests(planned, bench, target, repeats=4, starts=2)
        return tuple(campaigns(planned, at, target, n=n) for at in (plan.conditions, usual(planned)))

    return run


def test_the_promised_error_is_the_error_found(bench, guessed, wanted, campaigns):
    planned, target = guessed("howell"), wanted("strong")
    plan = plan_tests(planned, bench, target, repeats=4, starts=2)
    found = campaigns(planned, plan.conditions, target, n=15)
    # An rms of 15 errors is itself known to 1/√30 = 18 %; two of these.
    assert math.sqrt((found.errors**2).mean()) == pytest.approx(plan.after.std_log[0], rel=0.39)
    # The width is 2 t s, and s² has 10 degrees of freedom in each of 15 campaigns.
    assert found.widths.mean() == pytest.approx(2 * plan.after.half_width_log[0], rel=0.15)
    assert found.covered >= 0.85


@pytest.mark.parametrize(("name", "where"), thinned([("size-exponential", "large wheel"),
    ("howell", "strong")]))  # fmt: skip
def test_a_plan_carried_out_beats_one_factor_at_a_time(compared, name, where):
    ours, theirs = compared(name, where, n=4)
    assert np.median(theirs.widths) > WORTHWHILE * np.median(ours.widths)


def test_a_plan_knows_which_error_all_its_tests_share(bench, guessed, wanted):
    """A cell whose gain is 3 % too large: searched as if each test had its own error, a plan is no better."""
    scatter, error = (
        MeanScatter(within=0.017, between=0.01),
        CommonError("cell", "-", 0.03, (), "cell", "cell"),
    )
    planned = replace(guessed("wrap-power", scatter), chain="cell", common=(error,))
    target = wanted("strong")
    grid = bench.conditions()
    places = np.flatnonzero(allowed_conditions(planned, bench, grid)[0])
    alone = planned.evidence(grid.select(places), 4)
    alone = alone._replace(own=np.ones(places.size), shares={})
    search = Exchange(alone, planned.known, planned.gradients(target))
    plan = plan_tests(planned, bench, target, repeats=4, starts=2)
    errors = []
    for at in (plan.conditions, grid.select(places[best_plan(search, 12, starts=2)])):
        pulls = at.select(np.repeat(np.arange(12), 4))
        read = planned.law.log_lift(planned.theta, pulls) + 0.03
        scattered = read + np.tile([0.02, -0.02, 0.01, -0.01], 12)
        fit = fit_law(table_at(pulls, scattered, cell_std_N=0.03 * np.exp(scattered)), planned.law)
        off = predict(fit, target, method="linear").log_lift - planned.law.log_lift(planned.theta, target)
        errors.append(float(abs(off)[0]))
    # The fit knows of the error too, so that both do; the plan that knew of it is no worse.
    assert errors[0] < 1.1 * errors[1]
    assert errors[0] < 2.0 * plan.after.std_log[0]


@pytest.mark.slow
def test_a_plan_pulled_on_the_virtual_rig_beats_one_factor_at_a_time(bench, guessed, wanted, usual, tmp_path):
    """Recordings with ramp, noise, converter and tare, extracted, fitted, predicted: the whole way, three times."""
    scatter = MeanScatter(within=0.017, between=0.01)
    planned, target = guessed("size-exponential", scatter), wanted("large wheel")
    plan = plan_tests(planned, bench, target, repeats=4, starts=4)
    widths = {"ours": [], "theirs": []}
    for name, conditions in (("ours", plan.conditions), ("theirs", usual(planned))):
        for seed in range(3):
            table = pulled(planned, conditions, tmp_path / f"{name}-{seed}", seed)
            low, high = predict(fit_law(table, planned.law), target, method="linear").interval_N[0]
            widths[name].append(math.log(high / low))
    assert np.mean(widths["theirs"]) > WORTHWHILE * np.mean(widths["ours"])


def pulled(planned, conditions, folder, seed):
    from ropefric.api import trial_table
    from ropefric.rig.bench import Bench
    from ropefric.rig.campaign import CampaignPlan, RigCondition, simulate_campaign
    from ropefric.trials.campaign import load_campaign
    from ropefric.trials.extract import extract_campaign

    settings = (conditions.wheel_radius_m, conditions.wrap_angle_rad, conditions.end_tension_N)
    rows = tuple(RigCondition(wheel_radius_m=R, wrap_angle_rad=phi, end_tension_N=F)
        for R, phi, F in np.transpose(settings).tolist())  # fmt: skip
    plan = CampaignPlan(name="planned", law=planned.law.name,
        parameters=planned.law.as_mapping(planned.theta), rope_diameter_m=0.0098, conditions=rows,
        design=rows[0], repeats=4, faults={}, bench=Bench(trial_scatter=planned.scatter.within,
        condition_scatter=planned.scatter.between))  # fmt: skip
    simulate_campaign(folder, plan, seed=seed)
    return trial_table(extract_campaign(load_campaign(folder / "campaign.toml")))
