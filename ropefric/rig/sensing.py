"""From the force on the rope to ADC counts: cell, transmitter, zero, noise, converter."""

from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.rig.settings import Bench
from ropefric.traces.calibration import Adc, ForceCell


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """The measuring chain of one recording, with its imperfections.

    Written on its own, as the physics goes, so that it can test `ropefric.traces.calibration`, which goes the
    other way.
    """

    cell: ForceCell
    adc: Adc
    zero_counts: float = 0.0
    drift_counts: float = 0.0
    noise_counts: float = 0.0
    hum_counts: float = 0.0
    hum_Hz: float = 50.0
    hum_phase_rad: float = 0.0
    gain_error: float = 0.0

    @property
    def ceiling_N(self) -> float:
        """Return the force that takes the converter to its largest count [N], drift and noise aside."""
        line = self.cell.line
        top_V = self.adc.high_V - self.zero_counts * self.adc.lsb_V
        return (top_V - line.zero_V) * line.gain_N_V / (1.0 + self.gain_error)

    def ideal_counts(self, force_N: FloatArray, time_s: FloatArray) -> FloatArray:
        """Return what the converter is given, in counts: neither noisy nor rounded nor clipped."""
        line = self.cell.line
        voltage_V = line.zero_V + force_N * (1.0 + self.gain_error) / line.gain_N_V
        counts = (voltage_V - self.adc.low_V) / self.adc.lsb_V + self.zero_counts
        if time_s.size > 1:
            counts = counts + self.drift_counts * (time_s - time_s[0]) / (time_s[-1] - time_s[0])
        if self.hum_counts:
            counts = counts + self.hum_counts * np.sin(2 * np.pi * self.hum_Hz * time_s + self.hum_phase_rad)
        return np.asarray(counts, dtype=np.float64)

    def read(self, force_N: FloatArray, time_s: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Return ADC counts: ideal counts with noise, rounded and clipped to the converter's range."""
        counts = self.ideal_counts(force_N, time_s)
        counts += self.noise_counts * rng.standard_normal(counts.size)
        return np.clip(np.rint(counts), 0, self.adc.max_count)


def draw_sensor(bench: Bench, cell: ForceCell, rng: np.random.Generator) -> Sensor:
    """Return the chain of one recording, drawn from the bench."""
    return Sensor(
        cell=cell,
        adc=bench.adc,
        zero_counts=rng.uniform(*bench.zero_counts),
        drift_counts=bench.zero_drift_counts * rng.uniform(-1.0, 1.0),
        noise_counts=rng.uniform(*bench.noise_counts),
        hum_counts=bench.hum_counts,
        hum_Hz=bench.hum_Hz,
        hum_phase_rad=rng.uniform(0.0, 2.0 * np.pi),
        gain_error=bench.gain_error,
    )
