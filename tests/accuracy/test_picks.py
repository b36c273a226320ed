"""The benchmark of pickers: each finds a plain break, and the score counts what it says."""

from dataclasses import replace
from math import nan

import numpy as np
import pytest

from ropefric.accuracy.studies import STUDIES
from ropefric.accuracy.studies.picks import PICKERS, Known, score
from ropefric.accuracy.study import Measured
from ropefric.traces.trace import ForceTrace


def pull(peak_N=100.0, sliding_N=70.0, noise_N=0.05, rate_Hz=1000.0):
    """Idle, a climb of a second, a fall within 10 ms, rough sliding."""
    time_s = np.arange(0.0, 4.0, 1.0 / rate_Hz)
    force_N = np.interp(time_s, [0.0, 1.0, 2.0, 2.01, 4.0], [0.0, 0.0, peak_N, sliding_N, sliding_N])
    rng = np.random.default_rng(3)
    sliding = time_s > 2.01
    force_N[sliding] += 0.01 * sliding_N * np.sin(60.0 * time_s[sliding])
    return ForceTrace(time_s=time_s, force_N=force_N + noise_N * rng.standard_normal(time_s.size))


def test_every_picker_finds_a_plain_break_and_survives_missing_samples_and_nothing_at_all():
    plain = pull()
    force_N = plain.force_N.copy()
    force_N[100:120] = nan
    with_a_gap = ForceTrace(time_s=plain.time_s, force_N=force_N)
    flat = [ForceTrace(time_s=np.arange(float(n)), force_N=np.zeros(n)) for n in (1, 12, 400)]
    for method, setting, pick, _quick in PICKERS:
        force_N, std_N, in_doubt = pick(plain)
        assert force_N == pytest.approx(100.0, rel=0.01), (method, setting)
        assert np.isfinite(std_N) == (method == "ropefric")
        assert not in_doubt, (method, setting)
        assert pick(with_a_gap)[0] == pytest.approx(100.0, rel=0.01), (method, setting)
        assert not any(abs(pick(one)[0]) > 1e-6 for one in flat), (method, setting)


def test_the_score_counts_every_outcome_once():
    trace = pull()
    known = [Known(trace, 100.0, "sharp")] * 5 + [Known(trace, nan, "held")] * 4
    picked = [(100.1, 0.1, False), (101.0, 0.1, False), (150.0, 0.1, False), (nan, nan, False),
              (nan, nan, True), (nan, nan, False), (nan, nan, True), (80.0, 0.1, False), (nan, nan, False)]  # fmt: skip
    found = score(picked, known)
    assert dict(found.shares) == {"recordings": 9.0, "right": 0.4, "wrong": 0.2, "missed": 0.2,
                                  "doubtful": 0.2, "false": 0.25, "within_2u": pytest.approx(1 / 3)}  # fmt: skip
    assert dict(found.kinds) == {"sharp": 0.4, "held": 0.75}
    assert found.bias == pytest.approx(0.0055)
    assert found.noise == pytest.approx(0.009 / np.sqrt(2))
    assert found.error == pytest.approx(np.quantile([0.001, 0.01, 0.5], 0.95))
    assert score([(nan, nan, False)], [Known(trace, 100.0)]).error == np.inf


def test_where_ropefric_loses_it_says_so():
    def point(method, **shares):
        return Measured(case="lab", method=method, setting="", error=0.1, evaluations=1.0, shares=shares)

    losing = (point("ropefric", right=0.5, wrong=0.0, false=0.0),
              point("mean", right=0.9, wrong=0.1, false=1.0))  # fmt: skip
    assert STUDIES["picks"].findings(losing) == ("lab: ropefric loses to mean: right 50 % against 90 %.",)
    winning = (point("ropefric", right=1.0, wrong=0.0, false=0.0),
               point("mean", right=0.9, wrong=0.1, false=1.0))  # fmt: skip
    assert STUDIES["picks"].findings(winning) == ()


def test_the_kinds_that_are_not_all_right_are_named_the_worst_first():
    def said(**kinds):
        shares = {"right": 1.0, "wrong": 0.0, "false": 0.0}
        point = Measured(case="lab", method="ropefric", setting="", error=0.1, evaluations=1.0, shares=shares)
        return STUDIES["picks"].findings((replace(point, kinds=kinds), point))

    assert said(sharp=1.0, held=0.75, knock=0.25) == (
        "lab: kinds that are not all right: knock (25 % right), held (75 % right); the other 1 are.",)  # fmt: skip
    assert said(sharp=1.0, held=1.0) == ("lab: all 2 kinds are all right.",)
