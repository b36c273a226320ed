"""What the virtual rig is built of and how it is driven, and its chain from force to ADC counts."""

import math
from dataclasses import dataclass, field, fields

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.registry import Registry
from ropefric.traces.calibration import Adc, ForceCell

Range = tuple[float, float]
"""Lower and upper limit of a quantity that differs from recording to recording (uniform)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Bench:
    """The PRTH test bench: load cell at the rope's fixed end, weights at the other, a motor on the wheel.

    A pair is a range; each recording draws its own value from it, uniformly.
    """

    sampling_rate_Hz: float = 3000.0
    adc: Adc = field(default_factory=Adc)
    cells: tuple[ForceCell, ...] = (
        ForceCell(name="K1", full_scale_N=1000.0),
        ForceCell(name="K5", full_scale_N=5000.0),
    )
    cell_use: float = 0.8
    rope_stiffness_N_m: float = 1.0e5
    cell_stiffness_N_m: float = 1.0e7
    moving_mass_kg: float = 0.12
    stiffness_factor: Range = (0.5, 2.0)
    damping_ratio: Range = (0.25, 0.5)
    trial_scatter: float = 0.017
    condition_scatter: float = 0.0
    idle_s: Range = (0.3, 0.6)
    hang_s: Range = (0.1, 0.25)
    dwell_s: Range = (0.3, 0.8)
    load_s: Range = (1.0, 2.0)
    slide_s: Range = (0.7, 1.1)
    off_s: Range = (0.2, 0.3)
    release_s: Range = (0.02, 0.06)
    pretension: Range = (0.7, 1.0)
    bounce: Range = (0.05, 0.25)
    bounce_Hz: Range = (4.0, 10.0)
    soft_start: Range = (0.05, 0.2)
    micro_slip: Range = (0.02, 0.1)
    micro_slip_loss: Range = (0.0, 0.4)
    kinetic_ratio: Range = (0.75, 0.93)
    tooth_height: Range = (0.1, 0.8)
    tooth_Hz: Range = (5.0, 25.0)
    kinetic_drift: float = 0.02
    zero_counts: Range = (6.0, 15.0)
    noise_counts: Range = (0.3, 1.0)
    zero_drift_counts: float = 0.2
    hum_counts: float = 0.0
    hum_Hz: float = 50.0
    gain_error: float = 0.0

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if item.type == Range and not 0.0 <= value[0] <= value[1] < math.inf:
                raise InputError(
                    f"{item.name} = {value} is not a range: lower and upper limit, neither negative",
                    key=item.name,
                )
        for key in ("sampling_rate_Hz", "rope_stiffness_N_m", "cell_stiffness_N_m", "moving_mass_kg"):
            if not 0.0 < getattr(self, key) < math.inf:
                raise InputError(f"{key} = {getattr(self, key)} is not a positive number", key=key)
        if not self.cells:
            raise InputError("the bench has no force cell", key="cells")

    def cell_for(self, lift_force_N: float) -> ForceCell:
        """Return the smallest cell that measures a lift force with headroom, or the largest there is."""
        good = (cell for cell in self.cells if lift_force_N <= self.cell_use * cell.full_scale_N)
        return next(good, self.cells[-1])

    def cell_named(self, name: str) -> ForceCell:
        """Return the cell of that name."""
        return Registry("force cell", self.cells)[name]

    def natural_frequency_Hz(self, stiffness_factor: float) -> float:
        """Return the frequency at which the rope snaps back, √(k/m)/2π with rope and cell in series [Hz]."""
        rope_N_m = stiffness_factor * self.rope_stiffness_N_m
        series_N_m = 1.0 / (1.0 / rope_N_m + 1.0 / self.cell_stiffness_N_m)
        return math.sqrt(series_N_m / self.moving_mass_kg) / (2.0 * math.pi)


HELD_BENCH = Bench(
    sampling_rate_Hz=50.0,
    adc=Adc(bits=12),
    cells=(ForceCell(name="K50", full_scale_N=50.0), ForceCell(name="K500", full_scale_N=500.0)),
    idle_s=(1.5, 2.5),
    load_s=(2.0, 5.0),
    dwell_s=(8.0, 15.0),
    slide_s=(1.0, 3.0),
    zero_counts=(10.0, 30.0),
)
"""A hand-held spring-scale test, for protocol `held`: slack side measured, 50 Hz, 12 bit, cells of 50 and 500 N."""


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
