"""From one set of data every command says the same, however the table is written."""

import math
from dataclasses import replace

import numpy as np
import pytest
from pulled import table_at

from ropefric.fitting.budgets import state_lift
from ropefric.fitting.compare import choose_law, compare_laws
from ropefric.fitting.diagnose import diagnose
from ropefric.fitting.fit import fit_law
from ropefric.fitting.next_tests import Outlook, planned_fit
from ropefric.fitting.next_tests import _outlook as outlook
from ropefric.fitting.predict import predict
from ropefric.friction.condition import SETTINGS, Conditions, one_condition
from ropefric.friction.laws import LAWS

WHEEL = one_condition(0.035, 0.0049, 7.0, 60.0)


def conditions(n=12, repeats=3):
    """Every wrap at every load, repeat by repeat."""
    i = np.repeat(np.arange(n), repeats)
    return Conditions(wheel_radius_m=0.03, rope_radius_m=0.0049,
        wrap_angle_rad=np.pi * np.array([0.5, 1.0, 2.0, 4.0])[i % 4],
        end_tension_N=np.array([10.0, 40.0, 120.0])[(i // 4) % 3])  # fmt: skip


def roped(seed=1, repeats=3, law="constant", theta=(0.2,), **more):
    """Each condition pulled with each of three ropes, whose μ differ by 4 %."""
    at, rng = conditions(repeats=repeats), np.random.default_rng(seed)
    rope = np.arange(len(at)) % 3
    log_lift = LAWS[law].log_lift(theta, at)
    log_lift += 0.04 * rng.standard_normal(3)[rope] * (log_lift - at.log_end_tension)
    log_lift += 0.02 * rng.standard_normal(12).repeat(repeats) + 0.02 * rng.standard_normal(len(at))
    return table_at(at, log_lift, labels={"rope_id": tuple(f"r{i}" for i in rope)} | more)


def before(planned, at, level=0.95) -> Outlook:
    """What a plan expects of a prediction with no new test."""
    return outlook(planned, planned.known, planned.gradients(at), level)


def test_one_pull_with_each_rope_shows_what_repeats_scatter_by():
    """Before, a cell of one pull counted as no repeat, and a budget of one pull left the repeats' scatter out."""
    fit = fit_law(roped(repeats=3), "constant")
    assert fit.statistics.scatter_within == pytest.approx(fit.scatter.std("repeat"), rel=1e-5)
    assert 0.01 < fit.statistics.scatter_within < 0.03
    assert fit.covariance_kind == "clustered"
    assert not any("no condition is repeated" in note for note in fit.notes)
    pull, found = state_lift(fit, WHEEL, {}, one_pull=True), predict(fit, WHEEL)
    ends_N = found.prediction_interval_N[0]
    assert pull.budget.expanded == pytest.approx(0.5 * np.ptp(ends_N), rel=0.05)


@pytest.mark.parametrize("repeats", [3, 9])
@pytest.mark.parametrize(("law", "theta"), [("constant", (0.2,)), ("wrap-power", (0.25, -0.4, 0.1))])
def test_a_plan_starts_from_the_interval_that_predict_gives(law, theta, repeats):
    """With three ropes it was 2.3 times too narrow, and no plan said that more ropes are needed."""
    fit = fit_law(roped(repeats=repeats, law=law, theta=theta), law)
    found, expected = predict(fit, WHEEL, method="linear"), before(planned_fit(fit), WHEEL)
    assert expected.std_log == pytest.approx(found.std_log, rel=0.03)
    # The plan holds the variances as they were estimated.
    assert expected.half_width_log == pytest.approx(found.log_half_width, rel=0.25)


def test_more_pulls_with_the_same_ropes_hardly_narrow_the_plan():
    fit = fit_law(roped(), "constant")
    planned, more = planned_fit(fit), conditions(repeats=1)
    both = planned.known.joined(planned.evidence(more, 10**6))
    many, rise = outlook(planned, both, planned.gradients(WHEEL), 0.95), 0.2 * 7.0
    assert many.std_log > 0.95 * rise * fit.scatter.std("rope") / math.sqrt(3)
    assert many.shared_log > 0.8 * many.std_log


def test_a_rival_without_an_answer_at_one_wheel_widens_the_others():
    """It was left out for all of them."""
    at = conditions()
    law = LAWS["constant"]
    rng = np.random.default_rng(0)
    table = table_at(at, law.log_lift((0.2,), at) + 0.02 * rng.standard_normal(len(at)))
    fit, rival = fit_law(table, "constant"), fit_law(table, "wrap-power")
    rivals = replace(fit, rivals=(rival,))
    wheels = Conditions(wheel_radius_m=0.03, rope_radius_m=0.0049, wrap_angle_rad=np.array([20.0, 20.0]),
        end_tension_N=np.array([60.0, 1e-3]))  # fmt: skip
    answers = rival.friction_law.answers(rival.theta, wheels)
    alone = predict(rivals, wheels.select(np.array([0])), method="linear")
    both = predict(rivals, wheels, method="linear")
    assert both.interval_N[0] == pytest.approx(alone.interval_N[0], rel=1e-12), answers


# ---- however the table is written ----


def numbers(table):
    """Everything that commands say of a table, without where it comes from."""
    fit, ranked = fit_law(table, "wrap-power"), compare_laws(table, ["constant", "wrap-power"])
    tree = fit.to_dict()
    kept = {
        name: tree[name] for name in ("parameters", "covariance", "statistics", "status", "advice", "notes")
    }
    causes = [
        cause
        for cause in diagnose(table, ranked).to_dict()["causes"]
        if cause["cause"] in ("rope", "wrap effect")
    ]
    return kept | {"ranking": ranked.to_dict()["ranking"], "verdict": choose_law(ranked).verdict.to_dict(),
        "causes": causes, "predicted": predict(fit, WHEEL).to_dict(), "plan": before(planned_fit(fit), WHEEL)._asdict(),
    }  # fmt: skip


def in_order(table, order):
    columns = {name: np.asarray(getattr(table, name))[order] for name in SETTINGS}
    labels = {name: tuple(np.array(words)[order].tolist()) for name, words in table.labels.items()}
    return table_at(Conditions(**columns), np.log(table.peak_N[order]), labels=labels)


def assert_same(one, other, rel, where=""):
    if isinstance(one, dict):
        assert one.keys() == other.keys(), where
        for name in one:
            assert_same(one[name], other[name], rel, f"{where}.{name}")
    elif isinstance(one, (list, tuple, np.ndarray)) and not isinstance(one, str):
        assert len(one) == len(other), where
        for i, pair in enumerate(zip(one, other, strict=True)):
            assert_same(*pair, rel, f"{where}[{i}]")
    elif isinstance(one, float):
        assert one == pytest.approx(other, rel=rel, abs=1e-12, nan_ok=True), where
    else:
        assert one == other, where


def test_order_names_a_column_of_one_value_and_a_copy_set_aside_change_nothing():
    table = roped(repeats=6, law="wrap-power", theta=(0.25, -0.4, 0.1))
    expected, n = numbers(table), len(table)
    assert_same(numbers(in_order(table, np.random.default_rng(0).permutation(n))), expected, 1e-4)
    words = {"r0": "zinc", "r1": "a", "r2": "Öse 7"}
    labels = {"rope_id": tuple(words[word] for word in table.labels["rope_id"])}
    labels |= {"operator": ("Li",) * n, "day": ("1",) * n}
    assert_same(numbers(replace(table, labels=labels)), expected, 1e-6)
    more = in_order(table, np.append(np.arange(n), 5))
    assert_same(numbers(replace(more, kept=np.arange(n + 1) < n)), expected, 1e-9)
