"""One mode during one piece of the drive, ready to be stepped through and watched."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import eigvals

from ropefric.arrays import BoolArray, FloatArray
from ropefric.systems.press.transient.energy import power_forms
from ropefric.systems.press.transient.exponential import Propagator
from ropefric.systems.press.transient.guards import Guard, guards_of
from ropefric.systems.press.transient.integrators import check_steps
from ropefric.systems.press.transient.motion import Motion

_STEPS_PER_PERIOD = 24
"""Guards are looked at this often in a period of the fastest oscillation; extremes between are interpolated."""

_FIRST_STEPS = (64.0, 64.0, 32.0, 16.0, 8.0, 4.0, 2.0)
"""What the longest step is divided by after a change of mode."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Phase:
    """One mode during one piece of the drive."""

    motion: Motion
    taylor: FloatArray

    @cached_property
    def propagator(self) -> Propagator:
        """Return the exact steps."""
        n = 2 * self.motion.n_coordinates
        rows = self.motion.derivative
        return Propagator(state=rows[:, :n], drive=rows[:, n:], taylor=self.taylor)

    @cached_property
    def guards(self) -> list[Guard]:
        """Return what ends the mode."""
        return guards_of(self.motion)

    @cached_property
    def tolerances(self) -> FloatArray:
        """Return the tolerance of each guard."""
        return np.array([guard.tolerance for guard in self.guards])

    @cached_property
    def watch(self) -> FloatArray:
        """Return the guards, and below them their rates, as rows over z."""
        rows = np.array([guard.row for guard in self.guards])
        read = self.propagator.read
        n, n_z = len(self.propagator.state), read.shape[1]
        rate = np.zeros((n_z, n_z))
        rate[:n] = self.motion.derivative @ read
        rate[n:, n:] = np.eye(n_z - n, k=1)
        return np.vstack([rows @ read, rows @ read @ rate])

    @cached_property
    def step_s(self) -> float:
        """Return the longest step at which no oscillation is overlooked [s]."""
        eigenvalues = eigvals(self.propagator.state)
        swinging = np.abs(eigenvalues[eigenvalues.imag != 0.0])
        return 2.0 * np.pi / (float(swinging.max()) * _STEPS_PER_PERIOD) if swinging.size else np.inf

    def lengths(self, whole_s: float, *, fresh: bool) -> list[float]:
        """Return steps that cover a time; where the mode is fresh, short ones first, since fast motions die early."""
        longest = min(self.step_s, whole_s)
        first = [longest / part for part in _FIRST_STEPS] if fresh else []
        left = whole_s - sum(first)
        check_steps(left / longest)
        count = max(1, int(np.ceil(left / longest)))
        # Rounding makes equal steps differ in their last digits; one matrix serves them all.
        return [*first, *[float(f"{left / count:.11e}")] * count]

    def flow(self, length_s: float) -> FloatArray:
        """Return the matrix of a step of z."""
        return self.propagator.step(length_s)

    def work(self, length_s: float) -> FloatArray:
        """Return the matrices of the works during a step."""
        return self.propagator.integrals(power_forms(self.motion), length_s)

    def grid_step(self, length_s: float) -> tuple[FloatArray, FloatArray]:
        """Return `flow` and `work` of a length that comes again and again."""
        if length_s not in self._known:
            self._known[length_s] = (self.flow(length_s), self.work(length_s))
        return self._known[length_s]

    @cached_property
    def _known(self) -> dict[float, tuple[FloatArray, FloatArray]]:
        return {}


def first_dip(
    phase: Phase, z: FloatArray, values: tuple[FloatArray, FloatArray, FloatArray, FloatArray], length: float
) -> tuple[BoolArray, float]:
    """Return which guards dip below zero inside a step that they begin and end above it, and where the first does."""
    g0, s0, g1, s1 = values
    fired = np.zeros(len(g0), dtype=np.bool_)
    candidates = np.flatnonzero((s0 < 0.0) & (s1 > 0.0))
    first = length
    for i in candidates:
        # The cubic through both values and rates, lowest where its slope vanishes.
        a, b = length * s0[i], length * s1[i]
        rise = g1[i] - g0[i]
        slope = np.array([3.0 * (a + b - 2.0 * rise), 2.0 * (3.0 * rise - 2.0 * a - b), a])
        for root in np.roots(slope):
            place = float(root.real)
            if abs(root.imag) > 1e-9 or not 0.0 < place < 1.0:
                continue
            cubic = g0[i] + place * (a + place * (0.5 * slope[1] + place * slope[0] / 3.0))
            if cubic >= -phase.tolerances[i]:
                continue
            value = float(phase.watch[i] @ (phase.flow(place * length) @ z))
            if value < -phase.tolerances[i] and place * length <= first:
                fired[:] = False
                fired[i], first = True, place * length
    return fired, first
