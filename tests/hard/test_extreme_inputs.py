"""Subnormal and huge inputs everywhere: a finite answer, right where a float can be right, or a refusal by name."""

import numpy as np
import pytest
from hard_hoist import lifted
from hard_regime import Regime, once, worst_law_error

from ropefric.fitting.fit import fit_law, guess
from ropefric.fitting.result import FitStatus
from ropefric.friction.condition import one_condition
from ropefric.friction.law import LiftModel
from ropefric.friction.laws import ALL_LAWS
from ropefric.systems.bandsaw.beam import beam_frequencies_Hz
from ropefric.systems.bandsaw.span import CLAMPED, PINNED, Span, string_frequencies_Hz
from ropefric.systems.friction import WrapFriction
from ropefric.systems.hoist.contact import HoistProblem
from ropefric.traces.breakaway import PickSettings
from ropefric.traces.noise import noise_std, remove_spikes
from ropefric.traces.peak import choose_window, window_bias_N
from ropefric.traces.protocols import PROTOCOLS
from ropefric.traces.smoothing import average_over_samples, average_over_time, smooth
from ropefric.traces.trace import ForceTrace
from ropefric.trials.table import TrialTable

REGIME = Regime(
    name="1e-310 and 1e300",
    statement="every law with one input at a time at 1e-300, 1e300 or subnormal; every other function on a grid of "
    "such numbers: finite or refused, never a warning",
    accuracy=1e-12,
)
EXTREMES = (5e-324, 1e-310, 1e-300, 1e-160, 1e-16, 0.04, 1.0, 20.0, 1e16, 1e160, 1e300, 1.7e308)
MACHINES = (*EXTREMES, 1e-30, 1e-29, 1e29, 1e30)
START = {name: [parameter.start for parameter in law.parameters] for name, law in ALL_LAWS.items()}


@once(REGIME)
def measured():
    plain = ["constant", "constant-offset", "groove", "wrap-power-from-zero", "wrap-exponential-from-zero"]
    load = [(name, START[name], (0.04, 0.005, 6.0, tension)) for name in plain for tension in (1e-310, 1e300)]
    load += [
        (name, START[name], (0.04, 0.005, 6.0, 1e300))
        for name in ("wrap-power", "wrap-exponential", "coupled")
    ]
    load += [("howell", START["howell"], (0.04, 0.005, 6.0, tension)) for tension in (1e-300, 1e300)]
    both = [
        (name, START[name], (1e300, 1e300, 6.0, 20.0))
        for name in ("size-exponential", "size-power", "thickness")
    ]
    tiny = [
        ("constant", [1e-300], (0.04, 0.005, 6.0, 20.0)),
        ("wrap-power", [1e-300, -0.5, 0.1], (0.04, 0.005, 6.0, 20.0)),
        ("wrap-power", [0.2, -0.5, 1e-300], (0.04, 0.005, 6.0, 20.0)),
        ("wrap-exponential", [1e-300, -0.5, 0.1], (0.04, 0.005, 6.0, 20.0)),
        ("thickness", [1e-150], (0.04, 0.005, 6.0, 20.0)),
    ]
    return max(worst_law_error(load, digits=120), worst_law_error([*both, *tiny], digits=650))


def test_what_a_float_can_hold_is_right():
    assert measured() <= REGIME.accuracy


def law_calls(law, theta, pull, rng):
    at, density, speed, force = rng.choice(EXTREMES, 4)
    return (
        lambda: law.log_lift_and_jacobian(theta, pull),
        lambda: law.log_lift_gradient_conditions(theta, pull),
        lambda: law.average_mu(theta, pull),
        lambda: law.local_mu(theta, at, pull),
        lambda: LiftModel(law=law, linear_density_kg_m=density, speed_m_s=speed).log_lift(theta, pull),
        lambda: guess(law, pull, [force]),
    )


@pytest.mark.parametrize("name", ALL_LAWS)
def test_laws_answer_or_refuse(name, finite_or_refused):
    law, rng = ALL_LAWS[name], np.random.default_rng(10)
    answered = 0
    for _ in range(25):
        pull = finite_or_refused(lambda: Extreme(one_condition(*rng.choice(EXTREMES, 4))))
        if pull is None:
            continue
        theta = [
            [item.lower, item.upper, item.start, rng.choice(EXTREMES), -rng.choice(EXTREMES)][rng.integers(5)]
            for item in law.parameters
        ]
        answered += sum(finite_or_refused(call) is not None for call in law_calls(law, theta, pull.at, rng))
    assert answered > 10


class Extreme:
    """Conditions as something that is no number of its own."""

    def __init__(self, at):
        self.at = at

    def __array__(self, dtype=None, copy=None):
        return np.array(
            [self.at.size_ratio, self.at.centreline_radius_m, self.at.log_end_tension], dtype=dtype
        )


def function_calls(x):
    return (
        lambda: window_bias_N(*x[:3]),
        lambda: choose_window(*x[:3], longest_s=x[3]),
    )


def test_functions_answer_or_refuse(finite_or_refused):
    rng = np.random.default_rng(11)
    for _ in range(100):
        x = rng.choice((0.0, *EXTREMES), 5) * rng.choice([-1, 1, 1], 5)
        for call in function_calls(x):
            finite_or_refused(call)


@pytest.mark.parametrize("scale", [5e-324, 1e-310, 1e-300, 1e-100, 1e90, 1e100, 1e160, 1e290, 1e300, 1.7e308])
def test_averages_scale_with_the_samples_or_refuse(scale, refused):
    unit = np.random.default_rng(12).integers(-8, 9, 400) / 8.0
    values = unit * scale
    if scale > 1e290:
        refused(lambda: average_over_samples(values, 31), "sums of such numbers overflow")
        refused(lambda: average_over_time(np.arange(400.0), values, 31.0), "sums of such numbers overflow")
    else:
        # A subnormal sample has the digits it has.
        close = {"rtol": 1e-13, "atol": max(1e-13 * scale, 4 * 5e-324)}
        np.testing.assert_allclose(
            average_over_samples(values, 31), average_over_samples(unit, 31) * scale, **close
        )
    if scale > 1e100:
        refused(lambda: ForceTrace(time_s=np.arange(400.0), force_N=values), "which is no force")
        refused(
            lambda: ForceTrace(time_s=np.linspace(0.5, 1.0, 400) * scale, force_N=unit),
            "no clock|strictly increase",
        )
    else:
        trace = ForceTrace(time_s=np.arange(400.0) * 0.001, force_N=values)
        assert np.isfinite(smooth(trace, 0.02).force_N).all()
        assert np.isfinite(noise_std(values))
        assert remove_spikes(values, noise_std(values)).values.shape == values.shape
    if scale < 1e-100:
        refused(
            lambda: ForceTrace(time_s=np.arange(400.0) * scale, force_N=unit), "no clock|strictly increase"
        )


@pytest.mark.parametrize("name", PROTOCOLS)
@pytest.mark.parametrize("scale", [1e-320, 1e-300, 1e-99, 1e-9, 1e9, 1e97])
@pytest.mark.parametrize("slower", [1e-90, 1.0, 1e90])
def test_peaks_of_any_scale_are_finite(name, scale, slower):
    t = np.arange(0.0, 4.0, 0.004)
    pull = np.where(t < 1, 0.0, np.where(t < 3, 100 * (t - 1), 160 + 4 * np.sin(60 * t)))
    trace = ForceTrace(time_s=t * slower, force_N=pull * scale)
    for result in PROTOCOLS[name].pick(trace, PickSettings()):
        assert (result.status == "ok") == bool(np.isfinite(result.peak_N))
        if result.status == "ok":
            assert 0.0 <= result.peak_std_N < np.inf


@pytest.mark.parametrize(
    "column", ["wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N", "peak_N"]
)
@pytest.mark.parametrize("value", [5e-324, 1e-300, 1e160, 1e300])
@pytest.mark.parametrize("name", ["constant", "size-exponential", "bending"])
def test_fits_answer_or_refuse(name, value, column, finite_or_refused):
    columns = {
        "wheel_radius_m": np.repeat([0.02, 0.04, 0.08], 4),
        "rope_radius_m": np.full(12, 0.005),
        "wrap_angle_rad": np.tile([3.0, 6.0, 9.0, 12.0], 3),
        "end_tension_N": np.tile([5.0, 20.0, 80.0], 4),
    }
    columns["peak_N"] = columns["end_tension_N"] * np.exp(0.2 * columns["wrap_angle_rad"])
    columns[column][5] = value
    fit = finite_or_refused(lambda: Fitted(fit_law(TrialTable(trial=tuple("abcdefghijkl"), **columns), name)))
    assert fit is None or fit.status is FitStatus.OK or fit.advice


BLADE = {"free_span_m": 1.6, "linear_density_kg_m": 0.6, "preload_N": 3412.0, "pull_N": 100.0, "mounting_factor": 0.5,
         "wheel_speed_m_s": 35.0, "travel_speed_m_s": 35.0, "bending_stiffness_N_m2": 1.06}  # fmt: skip
HOIST = {"wheel_radius_m": 0.04, "rope_radius_m": 0.005, "wrap_angle_rad": 9.0, "end_tension_N": 80.0,
         "speed_m_s": 3.0, "linear_density_kg_m": 0.06, "hanging_length_m": 5.0,
         "bending_stiffness_N_m2": 1e-3}  # fmt: skip


def extreme(parts, rng):
    """Return parts with up to three of them moved to the ends of what floats, or machines, can be."""
    moved = {name: float(rng.choice(MACHINES)) for name in rng.choice(list(parts), 3)}
    if "mounting_factor" in moved:
        moved["mounting_factor"] = float(rng.choice([0.0, 5e-324, 1.0 - 2.0**-53, 1.0]))
    return parts | moved


def test_blades_answer_or_refuse(finite_or_refused):
    rng, answered = np.random.default_rng(13), 0
    for _ in range(150):
        parts = extreme(BLADE, rng)
        if finite_or_refused(lambda parts=parts: Span(**parts).tension_N) is None:
            continue
        span = Span(**parts)
        assert not np.isnan(span.critical_speed_m_s(CLAMPED)).any()
        answered += finite_or_refused(lambda span=span: beam_frequencies_Hz(span, CLAMPED, 2)) is not None
        finite_or_refused(lambda span=span: string_frequencies_Hz(span, 2))
        finite_or_refused(lambda span=span: beam_frequencies_Hz(span, PINNED, 2))
    assert answered > 15


def test_hoists_answer_or_refuse(finite_or_refused):
    rng, answered = np.random.default_rng(14), 0
    for mu in (0.2, 1e-300, 1e3):
        for _ in range(100):
            parts = {"friction": WrapFriction.constant(mu), **extreme(HOIST, rng)}
            found = finite_or_refused(lambda parts=parts: lifted(HoistProblem(**parts)).log_lift)
            answered += found is not None
    assert answered > 30


@pytest.mark.parametrize("value", [-1e31, 1e31, 1e160, 1.7e308])
@pytest.mark.parametrize(
    ("problem", "parts", "name"),
    [(Span, BLADE, "pull_N"), (Span, BLADE, "travel_speed_m_s"), (HoistProblem, HOIST, "speed_m_s")],
)
def test_what_no_machine_has_is_refused(problem, parts, name, value, refused):
    more = {"friction": WrapFriction.constant(0.2)} if problem is HoistProblem else {}
    refused(
        lambda: problem(**parts | more | {name: value}), f"{name} is .*, beyond anything from 1e-30 to 1e"
    )


class Fitted:
    """A fit as the numbers that must be finite."""

    def __init__(self, fit):
        self.fit, self.status, self.advice = fit, fit.status, fit.advice

    def __array__(self, dtype=None, copy=None):
        return np.concatenate([self.fit.theta, self.fit.covariance.ravel()]).astype(dtype)
