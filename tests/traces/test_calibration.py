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


@given(slope=st.floats(1e-4, 1.0), zero_V=st.floats(-1.0, 1.0),
    forces=st.lists(st.integers(0, 1000), min_size=2, max_size=8, unique=True))  # fmt: skip
def test_points_on_a_line_give_that_line(slope, zero_V, forces):
    points = tuple((float(f), zero_V + slope * f) for f in sorted(forces))
    line = ForceCell(name="cell", full_scale_N=1000.0, points=points).line
    assert line.gain_N_V == pytest.approx(1 / slope, rel=1e-9)
    assert line.zero_V == pytest.approx(zero_V, abs=1e-9 * (1 + 1000 * slope))
    assert line.scatter_N <= 1e-9 * (1 + 1 / slope)


def test_least_squares_agrees_with_polyfit():
    rng = np.random.default_rng(5)
    force_N = np.linspace(0.0, 1000.0, 11)
    voltage_V = 0.02 + 0.00497 * force_N + rng.normal(0, 0.002, 11)
    cell = ForceCell(name="cell", full_scale_N=1000.0, points=tuple(zip(force_N, voltage_V, strict=True)))
    (slope, zero), squares, *_ = np.polyfit(force_N, voltage_V, 1, full=True)
    assert (cell.line.gain_N_V, cell.line.zero_V) == (pytest.approx(1 / slope), pytest.approx(zero))
    assert (cell.line.scatter_N, cell.line.dof) == (pytest.approx(np.sqrt(squares[0] / 9) / slope), 9)
    assert Calibration(cell=cell).lsb_N == pytest.approx(5 / 1023 / slope)


def test_points_replace_the_nominal_line():
    cell = ForceCell(name="cell", full_scale_N=1000.0, points=((0.0, 0.5), (1000.0, 4.5)))
    force_N, _ = Calibration(cell=cell, adc=Adc(bits=1)).apply([0, 1])
    assert force_N.tolist() == pytest.approx([-125.0, 1125.0])


IMPOSSIBLE = [
    (Adc, {"bits": 0}, "bits = 0"), (Adc, {"bits": 10.0}, "bits = 10.0"), (Adc, {"bits": True}, "bits = True"),
    (Adc, {"low_V": 5.0}, "from 5 V to 5 V is empty"), (Adc, {"high_V": "5"}, "high_V = '5'"),
    (ForceCell, {"full_scale_N": 0}, "full scale 0 N is not positive"),
    (ForceCell, {"full_scale_N": float("nan")}, "full_scale_N = nan"),
    (ForceCell, {"full_scale_N": 10**400}, "is not a finite number"),
    (ForceCell, {"zero_V": 5.0}, "5 V at full scale is not above 5 V"),
    (ForceCell, {"linearity": 0.2}, "0.0002 for 0.02 %FS"), (ForceCell, {"hysteresis": -0.1}, "hysteresis = -0.1"),
    *((ForceCell, {"points": points}, words) for points, words in (
        (((0, 0),), "one calibration point"), (((0, 0), (0, 1)), "1 and 2.*do not increase"),
        (((0, 1), (1, 1)), "do not increase"), (((0, 1), (50, 2)), "50 N, is far beyond"),
        (((0, 1), (1, np.inf)), "2 is not finite"), ((1, 2), "pairs of force and voltage"),
        ("12", "pairs of force and voltage"), (5, "pairs of force and voltage"),
        (((0, 0), (1e-300, 1)), "too steep"))),
    (ForceCell, {"full_scale_N": 1e300, "full_scale_V": 1e-300}, "too steep"),
    (Calibration, {"cell": SMALL, "tare_N": float("nan")}, "tare_N = nan"),
    (Calibration, {"cell": SMALL, "tare_std_N": -1.0}, "tare_std_N = -1 is negative"),
]  # fmt: skip


def test_impossible_values_are_refused_in_words():
    for kind, keys, message in IMPOSSIBLE:
        ordinary = {"name": "c", "full_scale_N": 9.0} if kind is ForceCell else {}
        with pytest.raises(InputError, match=message) as error:
            kind(**(ordinary | keys))
        assert error.value.code == "RF210"


def test_numpy_numbers_are_numbers():
    assert Adc(bits=np.int64(12)) == Adc(bits=12)
    assert ForceCell(name="c", full_scale_N=np.float32(2.0)) == ForceCell(name="c", full_scale_N=2)


def test_a_calibration_is_json_with_the_same_bytes():
    cell = dataclasses.replace(SMALL, points=((0, 0.01), (1000, 5)), serial="A1", calibrated="2024-05-01")
    calibration = Calibration(cell=cell, adc=Adc(bits=12), tare_N=3, tare_std_N=0.1)
    again = Calibration(cell=dataclasses.replace(cell), adc=Adc(bits=12), tare_N=3.0, tare_std_N=0.1)
    assert (again, hash(again)) == (calibration, hash(calibration))
    text = json.dumps(calibration.to_dict(), sort_keys=True, allow_nan=False)
    assert json.dumps(again.to_dict(), sort_keys=True) == text
    assert json.loads(text)["cell"]["points"] == [[0.0, 0.01], [1000.0, 5.0]]
