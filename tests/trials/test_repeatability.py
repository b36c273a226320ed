import math
from statistics import NormalDist

import numpy as np
import pytest

from ropefric.errors import InputError
from ropefric.trials.outliers import RULES, grubbs_critical_value, summarise, trimming_bias


def test_one_pass_only():
    # Without 100 the value 30 would lie outside; the rule looks once.
    values = [0.0, 0.1, -0.1, 0.2, -0.2, 0.05, -0.05, 0.15, 30.0, 100.0]
    first = summarise(values)
    assert (first.rejected, summarise(values[:-1]).rejected) == ((9,), (8,))


def test_few_values():
    for values, mean_N, std_N in (
        ([], math.nan, math.nan), ([3.0], 3.0, math.nan), ([3.0, 5.0], 4.0, math.sqrt(2)), ([7.0] * 4, 7.0, 0)
    ):  # fmt: skip
        for rule in RULES:
            series = summarise(values, rule)
            assert (series.n, series.n_kept, series.rejected) == (len(values), len(values), ()), rule
            for found in ((series.mean_all, series.std_all), (series.mean_kept, series.std_kept)):
                assert found == pytest.approx((mean_N, std_N), nan_ok=True), rule


# Tables of what trimming does, against simulation with the rules written a second time, on whole matrices.


def keep(x, name):
    n = x.shape[1]
    z = np.abs(x - x.mean(axis=1, keepdims=True)) / x.std(axis=1, ddof=1, keepdims=True)
    if name == "two-sigma":
        return z <= 2
    if name == "grubbs":
        return (z < z.max(axis=1, keepdims=True)) | (z <= grubbs_critical_value(n))
    return np.ones_like(x, dtype=bool)


def simulate(n, name, n_series, seed=17):
    x = np.random.default_rng(seed).standard_normal((n_series, n))
    kept = keep(x, name)
    n_kept = kept.sum(axis=1)
    mean_kept = (x * kept).sum(axis=1) / n_kept
    s = np.sqrt((((x - mean_kept[:, None]) ** 2) * kept).sum(axis=1) / (n_kept - 1))
    return s.mean(), s.std() / math.sqrt(n_series), n - n_kept.mean()


@pytest.mark.parametrize("name", list(RULES))
def test_the_tables_are_what_a_simulation_finds_and_between_their_entries_good_to_a_per_cent(name):
    for n in (3, 4, 6, 8, 20, 50, 13, 25, 75):
        between = n in (13, 25, 75)
        ratio, ratio_std, n_lost = simulate(n, name, (100_000 if between else 150_000) // n)
        untrimmed = math.sqrt(2 / (n - 1)) * math.gamma(n / 2) / math.gamma((n - 1) / 2)
        tolerance = (0.004 if between else 0.001) + 4 * ratio_std
        assert untrimmed * (1 + trimming_bias(n, name)) == pytest.approx(ratio, abs=tolerance), n
        assert RULES[name].good_lost(n) == pytest.approx(n_lost, abs=0.02), n
    # The matrix arithmetic above and `flag` agree series by series.
    x = np.random.default_rng(3).standard_normal((300, 9))
    assert [RULES[name].flag(row).tolist() for row in x] == (~keep(x, name)).tolist()


def test_the_limit_of_long_series_is_the_normal_distribution_cut_at_two():
    cut = math.sqrt(1 - 4 * NormalDist().pdf(2) / (2 * NormalDist().cdf(2) - 1))
    assert trimming_bias(100_000) == pytest.approx(cut - 1, abs=0.003)
    with pytest.raises(InputError, match="series of 1 has no scatter"):
        trimming_bias(1)
