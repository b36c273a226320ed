"""Raised and lowered over one wheel: μ = ln(T_raise/T_lower)/(2φ), whatever the weight and the scale of the sensor."""

import math
from itertools import product

import numpy as np
import pytest

import ropefric as rf
from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.protocols import PROTOCOLS
from ropefric.traces.trace import ForceTrace
from ropefric.trials.campaign import check_campaign

WEIGHT_N = 30.0
PROTOCOL = '[protocol]\nname = "two-way"\n'


def recording(
    mu,
    wrap_rad,
    *,
    seed=0,
    weight_N=WEIGHT_N,
    teeth=0.0,
    drift=0.0,
    noise_N=0.1,
    scale=1.0,
    hung=False,
    stop_s=0.0,
):
    """Idle, a ramp and a static peak, raising for 2 s, a reversal, perhaps with a stop, lowering for 2 s, let down."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(6000) / 1000
    high_N, low_N = weight_N * math.exp(mu * wrap_rad), weight_N * math.exp(-mu * wrap_rad)
    first_N = weight_N if hung else 0.0
    knots = {0.3: first_N, 1.0: 1.15 * high_N, 1.01: high_N, 3.0: high_N * (1 + drift), 3.3: low_N,
        5.3: low_N}  # fmt: skip
    force_N = np.interp(time_s, [*knots, 5.4], [*knots.values(), first_N])
    moving = (time_s > 1.01) & (time_s < 3.0) | (time_s > 3.3) & (time_s < 5.3)
    force_N += moving * teeth * force_N * ((time_s / 0.1) % 1.0 - 0.5)
    at = np.searchsorted(time_s, 3.15)
    force_N = np.insert(force_N, at, np.full(round(1000 * stop_s), force_N[at]))
    return np.arange(force_N.size) / 1000, scale * (force_N + noise_N * rng.standard_normal(force_N.size))


def pick(*args, **kwargs):
    time_s, force_N = recording(*args, **kwargs)
    (found,) = PROTOCOLS["two-way"].pick(ForceTrace(time_s=time_s, force_N=force_N), PickSettings())
    return found


def coefficient(found, wrap_rad):
    return math.log(found.peak_N / found.trough_N) / (2 * wrap_rad)


WAYS = [{"teeth": 0.1}, {"drift": 0.005}, {"scale": 1.1}, {"hung": True}, {"noise_N": 0.5}, {"stop_s": 1.5}]
CASES = [*product((math.pi / 2, math.pi, 2 * math.pi), (0.05, 0.15, 0.3), [{}])]
CASES += [(wrap_rad, mu, how) for how in WAYS for wrap_rad, mu in ((math.pi / 2, 0.05), (2 * math.pi, 0.3))]


def test_the_coefficient_is_found():
    for case in CASES:
        wrap_rad, mu, how = case
        found = pick(mu, wrap_rad, **how)
        assert found.status is Status.OK, case
        assert coefficient(found, wrap_rad) == pytest.approx(mu, rel=0.01, abs=1e-3), case
        assert found.end_tension_N == pytest.approx(how.get("scale", 1.0) * WEIGHT_N, rel=0.01), case
        log_rise = math.log(found.peak_N / found.end_tension_N)
        assert log_rise == pytest.approx(coefficient(found, wrap_rad) * wrap_rad), case


@pytest.mark.parametrize("how", [{}, {"teeth": 0.1}])
def test_its_uncertainty_covers(how):
    wrap_rad, mu = math.pi, 0.2
    pulls = [pick(mu, wrap_rad, seed=seed, noise_N=0.5, **how) for seed in range(12)]
    z = [(coefficient(one, wrap_rad) - mu) * wrap_rad / (one.peak_std_N / one.peak_N) for one in pulls]
    assert np.abs(np.mean(z)) < 1.0
    assert 0.3 < np.sqrt(np.mean(np.square(z))) < 1.6


def test_a_recording_that_is_never_lowered_or_first_lowered_has_no_pair():
    time_s, force_N = recording(0.2, math.pi)
    up = time_s < 2.9
    for times_s, forces_N, said in (
        (time_s[up], force_N[up], "no steady force of raising"), (time_s, force_N[::-1], "")
    ):  # fmt: skip
        (found,) = PROTOCOLS["two-way"].pick(ForceTrace(time_s=times_s, force_N=forces_N), PickSettings())
        assert found.status is Status.NO_BREAKAWAY
        assert said in found.detail


@pytest.fixture
def two_way(lab):
    """Return a campaign of three wraps, four recordings each or the first `n`, made with a coefficient of 0.18."""

    def two_way(mu=0.18, scale=1.0, n=12, **cells):
        rows = []
        for i in range(n):
            wrap_deg = (90, 180, 360)[i // 4]
            time_s, force_N = recording(
                mu * (1 + 0.004 * (i % 4 - 1.5)), math.radians(wrap_deg), seed=i, scale=scale
            )
            lab.record(f"p{i:02}.csv", time_s=time_s, force_N=force_N)
            row = lab.row(f"p{i:02}.csv", wrap_angle_deg=wrap_deg, **cells)
            rows.append({key: value for key, value in row.items() if value != ""})
        return lab.write(rows, PROTOCOL)

    return two_way


@pytest.mark.parametrize("hung_N", ["", WEIGHT_N])
def test_pairs_are_trials_that_a_law_fits(two_way, hung_N):
    lab = two_way(end_tension_N=hung_N)
    assert not [problem for problem in check_campaign(lab.path) if problem.severity == "error"]
    extraction = lab.extract()
    assert [trial.trial for trial in extraction.trials][:2] == ["p00", "p01"]
    assert [trial.mu for trial in extraction.trials] == pytest.approx([0.18] * 12, rel=0.015)
    assert [trial.end_tension_N for trial in extraction.trials] == pytest.approx([WEIGHT_N] * 12, rel=0.01)
    fit = rf.fit(extraction, "constant")
    assert fit["mu"].value == pytest.approx(0.18, rel=3e-3)
    assert fit.statistics.n_conditions == (3 if hung_N else fit.statistics.n_conditions)
    warned = {problem.code for problem in extraction.problems if problem.severity == "warning"}
    assert warned <= {"RF310"}


def test_a_scale_of_the_sensor_cancels_and_a_weight_that_is_not_there_is_told(two_way):
    extraction = two_way(scale=1.2, n=4, end_tension_N=WEIGHT_N).extract()
    assert [trial.mu for trial in extraction.trials] == pytest.approx([0.18] * 4, rel=0.015)
    (*told,) = (problem for problem in extraction.problems if problem.code == "RF243")
    assert len(told) == 1  # of a condition
    assert "is 36 N, the weight of the list 30 N" in told[-1].message


def test_the_uncertainty_of_the_pair_is_half_that_of_each_force_and_holds_the_chain(lab):
    settings = PROTOCOL + '[cells.K1]\nfull_scale = "200 N"\n[adc]\nbits = 16\nhigh = "5 V"\n'
    settings += '[import.channels]\ntime = { column = "time_s", unit = "s" }\ncounts = "force_N"\n'
    time_s, force_N = recording(0.18, math.pi / 2)
    lab.record("counts.csv", time_s=time_s, force_N=np.maximum(0, force_N * 65535 / 200).astype(int))
    (trial,) = lab.write([lab.row("counts.csv", cell="K1")], settings).extract().trials
    chain_N = 200.0 * math.hypot(*[2e-4 / math.sqrt(3)] * 3, 1e-3 / math.sqrt(3))
    ratio = trial.peak_N / trial.breakaway.trough_N
    expected_N = math.hypot(trial.breakaway.peak_std_N, 0.5 * chain_N, 0.5 * ratio * chain_N)
    assert (trial.peak_std_N, trial.end_tension_std_N) == (pytest.approx(expected_N, rel=0.01), 0.0)
    assert trial.mu_std == pytest.approx(trial.peak_std_N / trial.peak_N / trial.wrap_angle_rad)
