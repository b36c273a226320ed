"""From force to counts, checked against the calibration that goes the other way."""

import numpy as np
import pytest
from drawn import record

from ropefric.rig.bench import Sensor
from ropefric.traces.calibration import Adc, Calibration, ForceCell

K1 = ForceCell(name="K1", full_scale_N=1000.0)


def test_calibration_undoes_the_sensor_to_half_a_count():
    cell = ForceCell(name="K", full_scale_N=800.0, zero_V=0.5, full_scale_V=4.5)
    sensor = Sensor(cell=cell, adc=Adc(bits=12))
    force_N = np.linspace(0.0, 800.0, 3001)
    counts = sensor.read(force_N, np.arange(3001) / 3000.0, np.random.default_rng(0))
    calibration = Calibration(cell=cell, adc=Adc(bits=12))
    read_N, _ = calibration.apply(counts)
    assert np.abs(read_N - force_N).max() <= 0.5 * calibration.lsb_N * (1 + 1e-9)


def test_zero_offset_drift_hum_and_noise_are_what_they_say():
    sensor = Sensor(cell=K1, adc=Adc(), zero_counts=10.0, drift_counts=4.0, hum_counts=2.0, hum_Hz=50.0)
    time_s = np.arange(30_001) / 3000.0
    counts = sensor.ideal_counts(np.full(time_s.size, 500.0), time_s)
    assert counts.mean() == pytest.approx(511.5 + 10.0 + 2.0, abs=0.01)
    assert counts[-1] - counts[0] == pytest.approx(4.0, abs=1e-6)
    spectrum = np.abs(np.fft.rfft(counts - np.polyval(np.polyfit(time_s, counts, 1), time_s)))
    assert np.argmax(spectrum) / 10.0 == pytest.approx(50.0, abs=0.1)
    noisy = Sensor(cell=K1, adc=Adc(), zero_counts=100.0, noise_counts=3.0)
    read = noisy.read(np.zeros(50_000), np.arange(50_000) / 3000.0, np.random.default_rng(1))
    assert read.std() == pytest.approx(np.sqrt(9.0 + 1.0 / 12.0), rel=0.02)


def test_counts_are_clipped_to_the_converter():
    sensor = Sensor(cell=K1, adc=Adc(), zero_counts=10.0)
    counts = sensor.read(np.array([-50.0, 2000.0]), np.array([0.0, 1.0]), np.random.default_rng(0))
    assert (counts.tolist(), sensor.ceiling_N) == ([0.0, 1023.0], pytest.approx(1000.0 * 1013 / 1023))


def test_the_idle_rig_reads_its_zero_offset_and_never_the_floor():
    for seed in range(8):
        recording = record(seed)
        idle = recording.counts[recording.time_s < 0.25]
        assert 5.0 < idle.mean() < 16.0
        assert idle.min() > 0
        assert recording.counts.max() < 1023
        assert np.array_equal(recording.counts, np.rint(recording.counts))
        # Tared and calibrated, the recording follows the true force to noise and quantisation.
        calibration, _ = Calibration(cell=K1).with_tare(recording.counts[recording.time_s < 0.25])
        read_N, _ = calibration.apply(recording.counts)
        assert abs((read_N - recording.true_force_N).mean()) < 0.25
        assert np.abs(read_N - recording.true_force_N).max() < 7.0


def test_the_cell_follows_the_force():
    for lift, name in ((300.0, "K1"), (800.0, "K1"), (801.0, "K5"), (4900.0, "K5")):
        assert record(0, lift_N=lift, end_N=100.0).truth.cell == name
