import dataclasses
import json
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ropefric.errors import DataError, InputError
from ropefric.traces.calibration import Adc, Calibration, ForceCell, as_counts

SMALL = ForceCell(name="small", full_scale_N=1000.0)
LARGE = ForceCell(name="large", full_scale_N=5000.0)


def test_one_count_is_worth_what_the_conventions_print():
    assert Calibration(cell=SMALL).lsb_N == pytest.approx(0.978, abs=5e-4)
    assert Calibration(cell=LARGE).lsb_N == pytest.approx(4.888, abs=5e-4)


@given(count=st.integers(0, 1023), full_scale_N=st.floats(1.0, 1e5), zero_V=st.floats(-1.0, 2.0),
    tare_N=st.floats(-100.0, 100.0))  # fmt: skip
def test_counts_become_newtons_as_exact_arithmetic_says(count, full_scale_N, zero_V, tare_N):
    cell = ForceCell(name="cell", full_scale_N=full_scale_N, zero_V=zero_V, full_scale_V=4.5)
    calibration = Calibration(cell=cell, adc=Adc(low_V=-0.5, high_V=5.5), tare_N=tare_N)
    voltage = Fraction(-1, 2) + Fraction(count, 1023) * 6
    zero = Fraction(zero_V)
    truth = (voltage - zero) / (Fraction(9, 2) - zero) * Fraction(full_scale_N) - Fraction(tare_N)
    force_N, _ = calibration.apply(np.array([count]))
    assert force_N[0] == pytest.approx(float(truth), abs=1e-11 * (full_scale_N + abs(tare_N)))


def test_input_is_not_changed_and_counts_stay_whole():
    counts = np.array([1, 2, -1], dtype=np.int16)
    force_N, _ = Calibration(cell=SMALL).apply(counts)
    assert (counts.tolist(), force_N.dtype) == ([1, 2, -1], np.float64)
    assert np.isnan(force_N).tolist() == [False, False, True]


def test_a_count_above_the_converter_names_the_sample_and_the_bits():
    for top, bits in ((1024, 11), (4095, 12), (65535, 16)):
        words = rf"sample 2 .* count 1024.*1023.*10-bit.*largest count is {top}.*bits = {bits}"
        with pytest.raises(DataError, match=words) as error:
            Calibration(cell=SMALL).apply([0, -1, 1024, top])
        assert error.value.code == "RF211"
    with pytest.raises(DataError, match="above the 1023"):  # no missing one
        Calibration(cell=SMALL).apply(np.array([2**64 - 1], dtype=np.uint64))


def test_floats_from_a_text_file_are_counts_or_refused():
    assert (as_counts([5.0, np.nan, 0.0]).tolist(), as_counts([]).size) == ([5, -1, 0], 0)
    for bad, found in (([1.0, 2.5], "sample 1 .* 2.5"), ([-3.0], "-3"), ([np.inf], "inf"), ([1e18], "1e.18")):
        with pytest.raises(DataError, match=found) as error:
            as_counts(bad)
        assert error.value.code == "RF211"
    for bad in ([[1, 2]], ["a"], [True], 3):
        with pytest.raises(InputError, match="row of whole numbers"):
            as_counts(bad)


@given(st.lists(st.sampled_from([-1, 0, 1, 512, 1022, 1023]), max_size=40))
def test_saturation_runs_are_those_a_plain_loop_finds(counts):
    def loop(level):
        runs, start = [], None
        for i, count in enumerate([*counts, None]):
            if count == level and start is None:
                start = i
            elif count != level and start is not None:
                runs.append([start, i])
                start = None
        return runs

    _, saturation = Calibration(cell=SMALL).apply(np.array(counts, dtype=np.int64))
    assert (saturation.high_runs.tolist(), saturation.low_runs.tolist()) == (loop(1023), loop(0))
    assert saturation.n_high == counts.count(1023)


IMPOSSIBLE = [
    (Adc, {"bits": 0}, "bits = 0"), (Adc, {"bits": 33}, "bits = 33"), (Adc, {"low_V": 5.0}, "from 5 V to 5 V is empty"),
    (ForceCell, {"full_scale_N": 0}, "full scale 0 N is not positive"),
    (ForceCell, {"full_scale_N": float("nan")}, "full scale nan N"),
    (ForceCell, {"zero_V": 5.0}, "5 V at full scale is not above 5 V"),
    (ForceCell, {"linearity": 0.2}, "0.0002 for 0.02 %FS"), (ForceCell, {"hysteresis": -0.1}, "hysteresis = -0.1"),
    (ForceCell, {"full_scale_N": 1e300, "full_scale_V": 1e-300}, "too steep"),
    (Calibration, {"cell": SMALL, "tare_std_N": -1.0}, "tare_std_N = -1 is negative"),
]  # fmt: skip


def test_impossible_values_are_refused_in_words():
    for kind, keys, message in IMPOSSIBLE:
        ordinary = {"name": "c", "full_scale_N": 9.0} if kind is ForceCell else {}
        with pytest.raises(InputError, match=message) as error:
            kind(**(ordinary | keys))
        assert error.value.code == "RF210"


def test_a_calibration_is_json_with_the_same_bytes():
    cell = dataclasses.replace(SMALL, serial="A1", calibrated="2024-05-01")
    calibration = Calibration(cell=cell, adc=Adc(bits=12), tare_N=3.0, tare_std_N=0.1)
    again = Calibration(cell=dataclasses.replace(cell), adc=Adc(bits=12), tare_N=3.0, tare_std_N=0.1)
    assert (again, hash(again)) == (calibration, hash(calibration))
    text = json.dumps(calibration.to_dict(), sort_keys=True, allow_nan=False)
    assert json.dumps(again.to_dict(), sort_keys=True) == text
