"""The linear start-up as every integrator sees it: dy/dt = A y + B u(t), and powers that are squares of it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.systems.press.transient.energy import power_forms
from ropefric.systems.press.transient.inputs import ACCELERATION, SPEED, Inputs
from ropefric.systems.press.transient.mode import sticking
from ropefric.systems.press.transient.model import ElasticPress
from ropefric.systems.press.transient.motion import Motion
from ropefric.systems.press.transient.rest import resting_coordinates
from ropefric.systems.press.transient.spectrum import spectrum_of


def starting_state(motion: Motion, inputs: Inputs) -> FloatArray:
    """Return (q, dq/dt) of a machine at rest in balance with the loads of the first moment, shape (2 n_q,).

    Where the drive begins with a speed, all but the drivers still stand: relative to the drive they move backward.
    """
    first = inputs.at(np.zeros(1))[0]
    n_q, n_driven = motion.n_coordinates, len(motion.model.driven)
    still = first.copy()
    still[[SPEED, ACCELERATION]] = 0.0
    still[SPEED + 2 :] = 0.0
    state = np.zeros(2 * n_q)
    state[:n_q] = resting_coordinates(motion, still)
    state[n_q : n_q + n_driven] = -first[SPEED]
    return state


@dataclass(frozen=True, kw_only=True, eq=False)
class LinearStartUp:
    """A start-up in which no belt slips or goes slack."""

    model: ElasticPress
    inputs: Inputs

    @cached_property
    def motion(self) -> Motion:
        """Return the equations of motion."""
        return Motion(model=self.model, mode=sticking(self.model))

    @cached_property
    def n_state(self) -> int:
        """Return the size of the state y = (q, dq/dt)."""
        return 2 * self.motion.n_coordinates

    @cached_property
    def forms(self) -> FloatArray:
        """Return the powers, shape (6, n_w, n_w), see `ropefric.systems.press.transient.energy.POWERS`."""
        return power_forms(self.motion)

    @cached_property
    def start(self) -> FloatArray:
        """Return the state at t = 0."""
        return starting_state(self.motion, self.inputs)

    @cached_property
    def scale(self) -> FloatArray:
        """Return what counts as large for each state and work, for absolute tolerances, shape (n_state + 6,)."""
        model = self.model
        way = float((model.preload_N / model.stiffness_N_m).max())
        speed = max(float(np.abs(self.inputs.taylor[:, SPEED, 0]).max()), 1e-3)
        mass = float(model.roller_mass_kg.sum() + model.arc_mass_kg.sum())
        n_q = self.n_state // 2
        return np.concatenate([np.full(n_q, way), np.full(n_q, speed), np.full(6, 0.5 * mass * speed**2)])

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """Return the eigenvalues of A [1/s]."""
        return spectrum_of(self.model).eigenvalues

    def rate(self, y: FloatArray, u: FloatArray) -> FloatArray:
        """Return d(state, works)/dt, shape (n_state + 6,)."""
        w = np.concatenate([y[: self.n_state], u])
        return np.concatenate([self.motion.derivative @ w, (self.forms @ w) @ w])

    def jacobian(self, y: FloatArray, u: FloatArray) -> FloatArray:
        """Return the derivative of `rate` by (state, works), shape (n_state + 6, n_state + 6)."""
        n = self.n_state
        w = np.concatenate([y[:n], u])
        whole = np.zeros((n + 6, n + 6))
        whole[:n, :n] = self.motion.derivative[:, :n]
        whole[n:, :n] = 2.0 * (self.forms @ w)[:, :n]
        return whole

    def pieces(self, times_s: FloatArray) -> list[tuple[int, float, float, npt.NDArray[np.intp]]]:
        """Return (piece, start, end, indices of times in (start, end]) up to the last of sorted times."""
        starts = self.inputs.starts_s
        ends = np.append(starts[1:], np.inf)
        found = []
        for piece, (start, end) in enumerate(zip(starts, ends, strict=True)):
            if start >= times_s[-1]:
                break
            inside = np.flatnonzero((times_s > start) & (times_s <= end))
            found.append((piece, float(start), float(min(end, times_s[-1])), inside))
        return found

    def input_at(self, piece: int, time_s: float) -> FloatArray:
        """Return u at a time as its piece says, also at the piece's very end."""
        tau = time_s - self.inputs.starts_s[piece]
        taylor = self.inputs.taylor[piece]
        value = np.zeros(len(taylor))
        for order in reversed(range(taylor.shape[1])):
            value = taylor[:, order] + value * tau / (order + 1.0)
        return value
