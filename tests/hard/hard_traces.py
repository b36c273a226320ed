"""Recordings and trial tables that are long, far off zero, of one kind only or of numbers at the ends of floats."""

import math
from functools import cache, partial

import numpy as np
import pytest
from hard_regime import answer, fact, refusals, refused, regime

from ropefric.files.plain_text import significant
from ropefric.fitting.fit import fit_law
from ropefric.fitting.predict import predict
from ropefric.fitting.result import FitStatus
from ropefric.friction.condition import Conditions, one_condition
from ropefric.friction.laws import LAWS
from ropefric.traces.breakaway import PickSettings
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.noise import noise_std, remove_spikes
from ropefric.traces.smoothing import average_over_samples, average_over_time, smooth, window_samples
from ropefric.traces.trace import ForceTrace
from ropefric.trials.table import TrialTable

OFFSET = 1e9


def exact_means(values, n_window):
    """Return every window's mean, summed exactly and rounded once."""
    n, means = len(values), []
    for i in range(n):
        half = min(n_window // 2, i, n - 1 - i)
        there = [x for x in values[i - half : i + half + 1] if not math.isnan(x)]
        means.append(math.fsum(there) / len(there) if there else math.nan)
    return np.array(means)


def ramp_and_waves(t):
    return np.where(t < 1, 0.0, np.where(t < 3, 100 * (t - 1), 160 + 4 * np.sin(60 * t)))


@regime("offset of 1e9", 1e-12, "exact sums",
        "moving averages of a signal of 1 on an offset of 1e9, with gaps, error relative to the offset; of "
        "ordinary signals relative to the largest sample, because a running sum rounds at every step")  # fmt: skip
def large_offset():
    rng, errors = np.random.default_rng(3), []
    for offset in (OFFSET, -OFFSET, 0.0):
        values = offset + rng.normal(0.0, 1.0, 1200)
        with_gaps = values.copy()
        with_gaps[rng.random(values.size) < 0.2] = np.nan
        for signal in (values, with_gaps):
            for n_window in (3, 31, 301):
                truth = exact_means(signal, n_window)
                # A stamp at a distance of 0.4 of a step never lies on the edge of a window.
                by_time = average_over_time(np.arange(1200.0), signal, n_window - 0.2)
                by_samples = [average_over_samples(signal, n_window)] if signal is values else []
                for found in (*by_samples, by_time):
                    assert (np.isnan(found) == np.isnan(truth)).all()
                    errors.append(np.nanmax(np.abs(found - truth)) / np.nanmax(np.abs(signal)))
    return float(max(errors))


@fact
def noise_and_peak_are_found_on_the_offset_and_at_late_times():
    """The offset leaves steps of 1.2e-7 N to the samples; the clock that counts from long ago is exact in floats."""
    t = np.arange(0.0, 4.0, 0.001)
    force_N = ramp_and_waves(t) + np.random.default_rng(4).normal(0.0, 0.2, t.size)
    (plain,) = pick_breakaway(ForceTrace(time_s=t, force_N=force_N), PickSettings())
    (lifted,) = pick_breakaway(ForceTrace(time_s=t, force_N=force_N + OFFSET), PickSettings())
    assert plain.status == lifted.status == "ok"
    assert lifted.peak_N - OFFSET == pytest.approx(plain.peak_N, abs=1e-6)
    assert lifted.peak_std_N == pytest.approx(plain.peak_std_N, rel=1e-4)
    assert noise_std(force_N + OFFSET) == pytest.approx(noise_std(force_N), rel=1e-5)
    t = np.arange(0.0, 4.0, 2.0**-10)
    force_N = np.where(t < 3, 100 * t, 200 + 4 * np.sin(60 * (t + 1e9)))
    (early,) = pick_breakaway(ForceTrace(time_s=t, force_N=force_N), PickSettings())
    (late,) = pick_breakaway(ForceTrace(time_s=t + 1e9, force_N=force_N), PickSettings())
    assert early.status == "ok"
    assert (late.peak_N, late.peak_time_s - 1e9) == (early.peak_N, early.peak_time_s)


LONGEST = 10**15 + 1


def few_samples(n=999):
    return np.random.default_rng(5).normal(3.0, 1.0, n)


@regime("window longer than the trace", 1e-14, "exact sums",
        "windows of up to 1e12 traces: the middle sample is the mean of all, the first and last samples do not "
        "change")  # fmt: skip
def long_window():
    values = few_samples()
    middle = math.fsum(values) / values.size
    trace = ForceTrace(time_s=0.001 * np.arange(values.size), force_N=values)
    found = [average_over_samples(values, n)[499] for n in (1001, 99_999, LONGEST)]
    found += [average_over_time(np.arange(999.0), values, window)[499] for window in (2e3, 1e12, 1e300)]
    found += [smooth(trace, window).force_N[499] for window in (1.5, 1e9)]
    return max(abs(mean / middle - 1.0) for mean in found)


@refusals
def windows_that_cannot_be_counted():
    """Others shrink to what there is: the ends stay and nothing leaves the range."""
    for n in (1, 2, 3, 4, 50, 51):
        values = few_samples(n)
        by_time = average_over_time(np.arange(float(n)), values, 1e300)
        for found in (average_over_samples(values, LONGEST), by_time):
            assert found.shape == values.shape
            assert found[[0, -1]] == pytest.approx(values[[0, -1]], rel=1e-15)
            assert values.min() - 1e-15 <= found.min() <= found.max() <= values.max() + 1e-15
    for window, step in [(1.0, 1e-300), (1e300, 1e-9), (1e20, 1.0)]:
        yield partial(window_samples, window, step), "too many steps"


PERIOD = 1000
# Whole numbers, so that the truth is exact: a window of 1001 holds one period and its first sample once more.
PATTERN = (np.arange(PERIOD) * 7919 % PERIOD).astype(np.float64)


@regime("averages over 1e8 samples", 1e-9, "sums of whole numbers",
        "2e6 samples by default, 1e8 in the long run, on an offset of 1e9, relative to the signal of 500: "
        "the offset rounds it to steps of 2.4e-10")  # fmt: skip
def many_samples(n=2_000_000):
    found = average_over_samples(np.tile(PATTERN + OFFSET, n // PERIOD), PERIOD + 1)
    inside = found[PERIOD : n - PERIOD].reshape(-1, PERIOD)
    # Window i runs from i − 500 to i + 500, both of the same phase.
    truth = OFFSET + (PATTERN.sum() + np.roll(PATTERN, PERIOD // 2)) / (PERIOD + 1)
    return max(float(np.abs(rows - truth).max()) for rows in np.array_split(inside, 50)) / 500.0


@fact
def averages_scale_with_the_samples_or_are_refused():
    """A subnormal sample has the digits it has."""
    unit, steps = np.random.default_rng(12).integers(-8, 9, 400) / 8.0, np.arange(400.0)
    no_clock = "no clock|strictly increase"
    for scale in (5e-324, 1e-310, 1e-300, 1e-100, 1e90, 1e100, 1e160, 1e290, 1e300, 1.7e308):
        values = unit * scale
        if scale > 1e100:
            refused(partial(ForceTrace, time_s=steps, force_N=values), "which is no force")
            clock_s = np.linspace(0.5, 1.0, 400) * scale
            refused(partial(ForceTrace, time_s=clock_s, force_N=unit), no_clock)
        else:
            scaled = average_over_samples(unit, 31) * scale
            close = {"rtol": 1e-13, "atol": max(1e-13 * scale, 4 * 5e-324)}
            np.testing.assert_allclose(average_over_samples(values, 31), scaled, **close)
            trace = ForceTrace(time_s=steps * 0.001, force_N=values)
            assert np.isfinite(smooth(trace, 0.02).force_N).all()
            assert np.isfinite(noise_std(values))
            assert remove_spikes(values, noise_std(values)).values.shape == values.shape
        if scale < 1e-100:
            refused(partial(ForceTrace, time_s=steps * scale, force_N=unit), no_clock)


TRUTH = {"constant": [0.2], "constant-offset": [0.2, 0.05], "size-exponential": [0.25, -0.3, -0.2],
         "wrap-exponential": [0.3, -0.5, 0.1], "wrap-power": [0.2, -0.5, 0.1],
         "coupled": [0.25, -0.3, -0.2, -0.5, 0.05], "thickness": [0.25], "howell": [0.5, 0.9]}  # fmt: skip


def plan(radii=(0.02, 0.03, 0.05, 0.09), wraps=(2.0, 5.0, 9.0, 14.0), loads=(2.0, 10.0, 60.0), repeats=1):
    wheel, wrap, load, _ = np.meshgrid(radii, wraps, loads, np.arange(repeats), indexing="ij")
    return Conditions(wheel_radius_m=wheel.ravel(), rope_radius_m=0.005, wrap_angle_rad=wrap.ravel(),
                      end_tension_N=load.ravel())  # fmt: skip


def fitted(pulls, log_lift, name):
    """Return a fit after making sure that it is sound: finite, within its bounds, and not silent where it is not ok."""
    columns = {one: getattr(pulls, one)
               for one in ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N")}  # fmt: skip
    trials = TrialTable(trial=tuple(f"t{i}" for i in range(len(pulls))), **columns, peak_N=np.exp(log_lift))
    fit = fit_law(trials, name)
    for item in fit.parameters:
        assert math.isfinite(item.value)
        assert item.lower <= item.value <= item.upper
        if math.isinf(item.std):  # nothing tells how far off it may be, and no interval pretends to
            nothing_told = fit.statistics.interval_dof == 0.0 and np.isnan(item.ci95).all()
            assert nothing_told or item.ci95 == (item.lower, item.upper)
        else:
            assert item.at_bound or (item.std >= 0.0 and item.ci95[0] <= item.value <= item.ci95[1])
    assert np.isfinite(fit.covariance).all()
    assert fit.status is FitStatus.OK or fit.advice
    return fit


@cache
def exactly(name, repeats=1):
    pulls = plan(repeats=repeats)
    return fitted(pulls, LAWS[name].log_lift(TRUTH[name], pulls), name)


def identical():
    """Return one condition twelve times, and what was found there."""
    return plan([0.04], [6.0], [20.0], 12), np.log(20.0) + 1.2 + 0.02 * np.random.default_rng(8).normal(
        size=12
    )


@regime("degenerate fits", 1e-8, "exact sums; the truth of data without scatter",
        "identical conditions, zero scatter, n < parameters, one radius, one wrap: parameters that "
        "the data determine, against exact sums and the known truth; the others are named")  # fmt: skip
def degenerate_fits():
    fit = fitted(*identical(), "constant")
    rises = identical()[1] - math.log(20.0)
    mean = math.fsum(rises) / 12
    within = math.sqrt(math.fsum((rises - mean) ** 2) / 11)
    # Of both the digits that a fit keeps: of a value whose error nothing tells, six.
    value = significant(mean / 6.0, 6)
    errors = [abs(fit["mu"].value / value - 1), abs(fit.statistics.scatter_within / significant(within) - 1)]
    for name, theta in TRUTH.items():
        errors.append(float(np.abs(exactly(name).theta / np.array(theta) - 1).max()))
    return max(errors)


@fact
def no_scatter_is_no_failure():
    """Nothing scatters, so that nothing says how far off the law may be."""
    for name, theta in TRUTH.items():
        fit = exactly(name)
        assert fit.status in {FitStatus.OK, FitStatus.UNIDENTIFIABLE}, name
        assert all(math.isinf(item.std) for item in fit.parameters), name
        found = predict(fit, one_condition(0.04, 0.005, 7.0, 30.0))
        assert found.lift_force_N[0] > 0.0
        assert np.isnan(found.interval_N).all(), name
        assert np.allclose(exactly(name, repeats=3).theta, theta, rtol=1e-6, atol=0.0), name


@fact
def identical_conditions_show_one_parameter_only():
    for name in ("constant-offset", "size-power", "wrap-exponential", "coupled", "howell", "bending"):
        fit = fitted(*identical(), name)
        assert fit.status is FitStatus.TOO_FEW_POINTS, name
        assert not fit.trustworthy, name
        assert "1 condition" in " ".join(fit.advice), name


@fact
def fewer_trials_than_parameters_are_counted():
    for name, n in (("constant-offset", 1), ("wrap-power", 1), ("wrap-exponential", 2),
                    ("size-exponential", 3)):  # fmt: skip
        pulls = plan([0.04], (2.0, 5.0, 9.0)[:n], [20.0])
        fit = fitted(pulls, np.log(20.0) + 0.2 * pulls.wrap_angle_rad + 0.01, name)
        free = sum(item.vary for item in fit.parameters)
        assert n > 1 or not fit.trustworthy, name
        assert fit.status is FitStatus.TOO_FEW_POINTS or n >= free, name
        advice = " ".join(fit.advice)
        assert n >= free or (f"{n} condition" in advice and f"{free} parameters" in advice), name


@fact
def one_value_of_a_regressor_is_named():
    one_wheel, one_wrap, one_load = {"radii": [0.04]}, {"wraps": [6.0]}, {"loads": [20.0]}
    for name, series, said in [("size-power", one_wheel, "only one size ratio"),
                               ("constant-offset", one_wrap, "only one wrap angle"),
                               ("wrap-exponential-from-zero", one_wrap, "only one wrap angle"),
                               ("wrap-power", one_load, "only one end tension")]:  # fmt: skip
        pulls = plan(**series, repeats=2)
        scatter = 0.01 * np.random.default_rng(9).normal(size=len(pulls))
        fit = fitted(pulls, LAWS["coupled"].log_lift(TRUTH["coupled"], pulls) + scatter, name)
        assert not fit.trustworthy, name
        advice = " ".join(fit.advice)
        assert said in advice or fit.status in {FitStatus.TOO_FEW_POINTS, FitStatus.AT_BOUND}, advice
        named = [item.name for item in fit.parameters if item.vary and item.name in advice]
        assert named or fit.status is FitStatus.TOO_FEW_POINTS, advice


@refusals
def tables_without_a_trial_that_can_be_used():
    conditions = {"wheel_radius_m": 0.04, "rope_radius_m": 0.005, "wrap_angle_rad": 3.0, "end_tension_N": 20}
    nothing = TrialTable(trial=("a",), **conditions, peak_N=np.nan)
    yield partial(fit_law, nothing, "constant"), "no trial of the table can be used"


@fact
def fits_with_one_extreme_number_answer_or_refuse():
    columns = {"wheel_radius_m": np.repeat([0.02, 0.04, 0.08], 4), "rope_radius_m": np.full(12, 0.005),
               "wrap_angle_rad": np.tile([3.0, 6.0, 9.0, 12.0], 3),
               "end_tension_N": np.tile([5.0, 20.0, 80.0], 4)}  # fmt: skip
    columns["peak_N"] = columns["end_tension_N"] * np.exp(0.2 * columns["wrap_angle_rad"])
    for name, values in {"constant": (1e-300, 1e160), "size-exponential": (5e-324, 1e300)}.items():
        for column, plain in columns.items():
            for value in values:
                moved = np.where(np.arange(12) == 5, value, plain)
                trials = {"trial": tuple("abcdefghijkl")} | columns | {column: moved}
                answer(partial(_numbers_of, trials, name))


def _numbers_of(trials, name):
    fit = fit_law(TrialTable(**trials), name)
    assert fit.status is FitStatus.OK or fit.advice
    return fit.theta, fit.covariance
