"""Units, formulas, counts and clock on the way to a force trace."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ropefric.errors import DataError, RopefricError
from ropefric.traces.assemble import assemble_trace
from ropefric.traces.calibration import as_counts
from ropefric.traces.formulas import evaluate_derived
from ropefric.traces.readers.profile import ImportProfile, RawRecording
from ropefric.traces.signals import si_scale


def raw(units=None, first_line=0, **columns):
    arrays = {name: np.array(values, dtype=np.float64) for name, values in columns.items()}
    return RawRecording(
        name="run.csv", source="run.csv", sample="", columns=arrays, units=units or {}, first_line=first_line
    )


@dataclass
class Doubling:
    adc = True

    def checked(self, counts):
        return as_counts(counts)

    def apply(self, counts):
        return np.where(counts < 0, np.nan, counts * 2.0), None


def refused(recording, profile=None, calibration=None):
    with pytest.raises(DataError) as caught:
        assemble_trace(recording, profile or ImportProfile(), calibration=calibration)
    assert caught.value.problem.path == "run.csv"
    return caught.value


def test_units_come_to_si():
    for channel, unit, factor in (
        ("time", "s", 1), ("time", "ms", 1e-3), ("time", "us", 1e-6), ("time", "min", 60), ("time", "h", 3600),
        ("force", "N", 1), ("force", "kN", 1e3), ("force", "kgf", 9.80665), ("force", "mN", 1e-3),
        ("pressure", "bar", 1e5), ("x", "mm", 1e-3), ("angle", "deg", np.pi / 180), ("area", "mm^2", 1e-6),
        ("u", "mV", 1e-3), ("n", "", 1), ("share", "%", 0.01), ("m", "g", 1e-3), ("counts", "anything", 1),
    ):  # fmt: skip
        assert si_scale(channel, unit)[0] == pytest.approx(factor, rel=1e-12), unit


def test_units_nobody_knows_are_told_at_once():
    for channel, unit, fix in (
        ("time", "", 'unit = "s"'), ("force", "", 'unit = "kN"'), ("force", "kn", "write 'kN'"),
        ("time", "N", "such as 's'"), ("force", "s", "such as 'N'"), ("force", "newt on", ""),
        ("pull", "kn", "write 'kN'"), ("x", "furlongs per dog", ""), ("temperature", "degC", ""), ("time", "(", ""),
        # A TDMS property or a header may hold any text; pint would evaluate it.
        *((channel, unit, "") for channel in ("force", "time", "pressure") for unit in (
            "10**10**10 N", "9**9**9**9", "a" * 30 + "!", "_" * 20_000, "N" + "²" * 40, "(" * 20_000)),
    ):  # fmt: skip
        with pytest.raises(DataError) as caught:
            si_scale(channel, unit, path="run.csv")
        assert caught.value.code == "RF106"
        assert fix in caught.value.fix
        assert caught.value.where == f"run.csv [import.channels] {channel}"
        assert len(caught.value.problem.message) < 200


def test_time_comes_from_the_rate_only_without_a_time_channel():
    profile = ImportProfile(sampling_rate_Hz=3000.0)
    trace = assemble_trace(raw({"force": "N"}, force=np.arange(3001)), profile)
    assert trace.time_s[3000] == 1.0
    both = raw({"force": "N", "time": "s"}, force=[1, 2], time=[0, 1])
    assert assemble_trace(both, ImportProfile()).time_s.tolist() == [0, 1]
    error = refused(both, profile)
    assert (error.code, "1 Hz, the profile 3000 Hz" in str(error)) == ("RF203", True)
    for rate_Hz in (None, 0.0, -1.0, np.nan):
        error = refused(raw({"force": "N"}, force=[1, 2]), ImportProfile(sampling_rate_Hz=rate_Hz))
        assert error.code == "RF105"
        assert "sampling_rate" in error.fix


def test_counts_become_force_and_stay():
    recording = raw({"time": "s"}, time=[0, 1, 2, 3], counts=[5, np.nan, 1023, 0])
    trace = assemble_trace(recording, ImportProfile(), calibration=Doubling())
    np.testing.assert_array_equal(trace.force_N, [10, np.nan, 2046, 0])
    assert (trace.counts.tolist(), trace.counts.dtype) == ([5, -1, 1023, 0], np.int64)


def test_counts_need_a_calibration_and_whole_numbers():
    error = refused(raw({"time": "s"}, time=[0, 1], counts=[1, 2]))
    assert (error.code, error.fix) == ("RF210", "name the cell in trials.csv and [adc] in campaign.toml")
    for counts in ([1, 2.5], [1, -3]):
        assert refused(raw({"time": "s"}, time=[0, 1], counts=counts), None, Doubling()).code == "RF211"
    forces = raw({"time": "s", "force": "N"}, time=[0, 1], force=[1, 2], counts=[7, 8])
    trace = assemble_trace(forces, ImportProfile())  # a measured force goes before counts
    assert (trace.force_N.tolist(), trace.counts) == ([1, 2], None)


def test_a_value_too_large_for_si_and_a_force_that_is_not_there_are_told():
    assert refused(raw({"time": "s", "force": "kN"}, time=[0, 1], force=[1, 1e307])).code == "RF102"
    assert "frce" in str(refused(raw({"time": "s"}, time=[0, 1], frce=[1, 2])))


def test_the_clock_is_mended_and_named_by_line():
    trace = assemble_trace(
        raw({"time": "s", "force": "N"}, time=[0, 1, np.nan], force=[1, 2, np.nan]), ImportProfile()
    )
    assert trace.notes == ("1 empty rows dropped",)
    error = refused(raw({"time": "ms", "force": "N"}, first_line=8, time=[0, 1, 0], force=[1, 2, 3]))
    assert (error.code, error.where) == ("RF202", "run.csv:10 time")


def test_a_derived_force_is_computed_in_si():
    profile = ImportProfile(constants={"area": 4e-4}, derived={"force": "pull - pressure * area"})
    recording = raw(
        {"time": "ms", "pull": "kN", "pressure": "bar"}, time=[0, 10], pull=[0.05, 0.06], pressure=[1, 1]
    )
    trace = assemble_trace(recording, profile)
    assert (trace.force_N, trace.time_s) == (pytest.approx([10, 20]), pytest.approx([0, 0.01]))
    # Volts that are turned round are volts: they were taken for newtons.
    turned = ImportProfile(derived={"force": "-force"})
    with pytest.raises(DataError, match="holds V, and nothing says how much force that is"):
        assemble_trace(raw({"time": "s", "force": "V"}, time=[0, 1], force=[-1, -2]), turned)


CHANNELS = {"a": np.array([1.0, 4.0, np.nan]), "b": np.array([2.0, -2.0, 1.0])}


def test_formulas_see_earlier_results():
    found = evaluate_derived({"c": "-a ** 2 + k", "d": "c / b", "b": "2 * b"}, CHANNELS, {"k": 1.0})
    np.testing.assert_allclose(found["d"], [0, 7.5, np.nan])
    np.testing.assert_array_equal(found["b"], [4, -4, 2])
    assert CHANNELS["b"][1] == -2.0


def test_formulas_can_do_no_more_than_arithmetic():
    for formula, words in (
        ("aa + 1", "unknown name 'aa'"), ("b ** 0.5", "gives nan at sample 2"), ("b / 0", "gives inf"),
        ("a.__class__", "Attribute"), ("__import__('os')", "Call"), ("a[0]", "Subscript"), ("a > b", "Compare"),
        ("'x' * b", "Constant"), ("a +", "not a formula"), ("", "not a formula"), ("x = a", "not a formula"),
        ("2 + 3", "uses no channel"), ("1j * b", "Constant"), ("True * b", "Constant"), ("9**9**9**9 * b", "gives inf"),
        ("9" * 390 + " * b", "not a formula"), ("b << 2", "BinOp"), ("(" * 300 + "b", "not a"), ("~b", "UnaryOp"),
        ("b / (1 / 0)", "gives inf in '1 / 0'"), ("b / 9**9**9**9", "gives inf in"),
        ("b\n+a; b", "not a formula"), ("b + " * 400 + "b", "longer than"),
    ):  # fmt: skip
        with pytest.raises(DataError) as caught:
            evaluate_derived({"force": formula}, CHANNELS, {}, path="run.csv")
        assert caught.value.code == "RF109"
        assert words in str(caught.value)
        assert caught.value.where == "run.csv [import.derived] force"


def test_a_constant_may_not_hide_a_channel():
    with pytest.raises(DataError, match="a constant and a channel"):
        evaluate_derived({"force": "a"}, CHANNELS, {"a": 1.0})


@settings(deadline=None, max_examples=50)
@given(st.text(alphabet="ab01.+-*/() ,<=[]'_", max_size=25))
def test_any_formula_gives_a_force_or_a_refusal(formula):
    try:
        found = evaluate_derived({"force": formula}, CHANNELS, {})
    except RopefricError:
        return
    assert found["force"].shape == (3,)
    assert np.isfinite(found["force"][:2]).all()
