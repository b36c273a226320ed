"""How often a fuller law is preferred on data of a simpler one, and how often on its own: simulated campaigns.

A campaign is simulated as its condition means and the scatter of its repeats, and judged by the very functions a
comparison uses; what a fit's own status may still hold against a law can only make a false preference rarer.
"""

from dataclasses import replace

import numpy as np
import pytest

from ropefric.fitting.problem import FitProblem
from ropefric.fitting.standing import Contest, lead_by_chance, leave_one_out, nested_test, searched, standing
from ropefric.fitting.statistics import ConditionMeans, aicc, scatter_fit
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import LAWS

WITHIN = 0.015
# Wheels [m], end tensions [N], wraps [deg].
DESIGNS = {6: ((0.03,), (10, 60), (90, 270, 720)), 8: ((0.02, 0.05), (10, 60), (90, 540)),
    12: ((0.02, 0.05), (10, 60), (90, 270, 720)), 20: ((0.02, 0.05), (10, 60), (90, 180, 360, 540, 720)),
    36: ((0.02, 0.03, 0.05), (5, 20, 80), (90, 180, 360, 720))}  # fmt: skip


def preferred_shares(n_conditions, repeats, between, n, *, law="constant", theta=(0.2,), seed=1):
    """Return the share of campaigns in which a fuller law than the constant is preferred, or it is undecided."""
    rng = np.random.default_rng([seed, n_conditions, repeats, round(1e4 * between)])
    wheels, loads, wraps = DESIGNS[n_conditions]
    grid = [axis.ravel() for axis in np.meshgrid(wheels, loads, np.radians(wraps), indexing="ij")]
    at = Conditions(wheel_radius_m=grid[0], rope_radius_m=0.005, end_tension_N=grid[1],
        wrap_angle_rad=grid[2])  # fmt: skip
    K, spare = n_conditions, n_conditions * (repeats - 1)
    scale = np.hypot(between, WITHIN / np.sqrt(repeats))
    log_lift = LAWS[law].log_lift(list(theta), at) + scale * rng.standard_normal((n, K))
    within = WITHIN * np.sqrt(rng.chisquare(spare, n) / spare) if spare else np.full(n, np.nan)
    std = within / np.sqrt(repeats) if spare else np.ones(n)

    def means_of(i, rows=slice(None)):
        size = np.full(K, repeats)
        return ConditionMeans(at, log_lift[rows][i], np.full(K, std[i]), size, float(within[i]))

    def problem_of(name, i):
        return FitProblem.plain(LAWS[name], at, log_lift[i])

    shape = replace(means_of(0), std=np.ones(K), scatter_within=1.0 if spare else np.nan)
    criteria, fits = {}, {}
    for name in (name for name in LAWS if name != "groove"):
        problem = problem_of(name, 0)
        k = problem.n_varying + 1
        if k + 2 > K or (len(wheels) == 1 and LAWS[name].effects == {"size"}):
            continue
        fits[name] = searched(problem, log_lift, problem.start)
        missed = LAWS[name].log_lift(fits[name], at) - log_lift
        deviance = scatter_fit(missed, shape, std**2).deviance
        criteria[name] = np.array([aicc(value, K, k) for value in deviance.tolist()])
    found = dict.fromkeys(("fuller", "simpler", "undecided"), 0)
    for i in range(n):
        leader = min(criteria, key=lambda name: criteria[name][i])
        if leader == "constant":
            found["simpler"] += 1
            continue
        means = means_of(i)
        family = {name: standing(problem_of(name, i), means, fits[name][i]) for name in criteria}
        plain, fuller = family.pop("constant"), family[leader]
        # As in a comparison, nothing is simulated where the F-test is that clear.
        tested = nested_test(plain, fuller)
        clear = tested is not None and tested.p_value < 1e-5
        contest = Contest(simpler="constant", fuller=leader, lead=plain.aicc - fuller.aicc,
            p_value=tested.p_value if clear else lead_by_chance(plain, fuller, family.values(), means),
            loco_ratio=leave_one_out(fuller) / leave_one_out(plain))  # fmt: skip
        found[contest.preferred] += 1
    return {word: count / n for word, count in found.items()}


ALL_DESIGNS = [(K, m, between) for K in DESIGNS for m in (1, 3, 5, 12) for between in (0.0, 0.02)]


def test_a_fuller_law_is_rarely_preferred_on_constant_data():
    """At a true share of 5 %, 10 of 80 and more are seen once in 200 times."""
    assert preferred_shares(6, 3, 0.02, n=80)["fuller"] <= 0.11


@pytest.mark.hours
@pytest.mark.parametrize("design", ALL_DESIGNS)
def test_a_fuller_law_is_preferred_in_a_twentieth_of_constant_campaigns_at_most(design):
    """1000 campaigns a design: 5 % and two standard errors of that share."""
    assert preferred_shares(*design, n=1000)["fuller"] <= 0.05 + 2.0 * np.sqrt(0.05 * 0.95 / 1000)
