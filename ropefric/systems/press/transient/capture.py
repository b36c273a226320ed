"""A start-up whose contacts change their state on a grid: exact steps between, no search for the moment.

A step that ends with a guard below zero is tried again in halves, down to a part of it, where the change is made. All
steps are dyadic parts of one, so that a mode costs one exponential and its squarings, and a mode that comes again
nothing. The works are trapezoids of the powers.
"""

from functools import cached_property, lru_cache

import numpy as np
from scipy.linalg import eigvals

from ropefric.arrays import FloatArray
from ropefric.errors import SolverError
from ropefric.systems.press.transient.drives import SPEED
from ropefric.systems.press.transient.exact import Guard, HybridSolver, Phase
from ropefric.systems.press.transient.integrators import rk4_limit_s
from ropefric.systems.press.transient.motion import FORWARD, Motion, power_pairs

_LEVELS = 4
_PARTS = 2**_LEVELS
"""A change of a contact is met to this part of a step."""
_BLOCK = 64
"""Steps that are looked at together, at most."""


class _GridPhase(Phase):
    """One mode during one piece of the drive, with its steps of a grid."""

    _made: tuple[float, list[FloatArray]] = 0.0, []

    def flows(self, step_s: float) -> list[FloatArray]:
        """Return the matrices that carry z over a step, half of it, and so on; those of the last grid are known."""
        known_s, flows = self._made
        if known_s != step_s:
            smallest = self.step(step_s / _PARTS)
            flows = [*flows[1:], smallest] if known_s == 2.0 * step_s else [smallest]
            while len(flows) <= _LEVELS:
                flows.insert(0, flows[0] @ flows[0])
            self._made = step_s, flows
        return flows

    @cached_property
    def firing(self) -> FloatArray:
        """Return the guards over their tolerances, as rows over z."""
        return np.asarray(self.watch[: len(self.guards)] / self.tolerances[:, np.newaxis])

    @cached_property
    def sticking(self) -> tuple[list[int], list[int]]:
        """Return the first of both guards of every contact that sticks, and its roller."""
        firsts = [i for i, one in enumerate(self.guards) if one.what == "slip" and one.direction == FORWARD]
        return firsts, [self.guards[i].place for i in firsts]

    def powers(self, z: FloatArray) -> FloatArray:
        """Return all powers at states z of shape (n, n_z), shape (n, 6)."""
        forces, speeds, starts = self.pairs
        return np.asarray(np.add.reduceat((z @ forces.T) * (z @ speeds.T), starts, axis=1))

    @cached_property
    def pairs(self) -> tuple[FloatArray, FloatArray, list[int]]:
        """Return forces and speeds whose products are the powers, as rows over z, and where each power's begin."""
        pairs = power_pairs(self.motion)
        starts = np.cumsum([0, *(len(force) for force, _ in pairs[:-1])]).tolist()
        forces, speeds = (np.vstack(rows) @ self.read for rows in zip(*pairs, strict=True))
        return forces, speeds, starts


class _RK4Phase(_GridPhase):
    """One mode whose steps are those of the classical Runge-Kutta method, each part of a step by a step of its own."""

    def step(self, length_s: float) -> FloatArray:
        """Return the matrix of one step, 1 + hG + … + (hG)⁴/24; a step that amplifies is refused."""
        limit_s = rk4_limit_s(eigvals(self.state))
        if length_s > limit_s:
            slipping = np.flatnonzero(self.motion.mode.contact)
            names = ", ".join(self.motion.model.press.rollers[i].name for i in slipping)
            raise SolverError(
                f"the step of {length_s:.6g} s is not within RK4's limit of stability, {limit_s:.6g} s"
                + (f" while the belt slips on roller {names}" if names else ""),
                code="RF524",
                key="step_s",
                fix=f"take {limit_s:.4g} s or less, or the integrator 'exact'",
            )
        generator, weights = self._balanced
        flow = term = np.eye(len(generator))
        for order in range(1, 5):
            term = (length_s / order) * term @ generator
            flow = flow + term
        return np.asarray(weights[:, None] * flow / weights)

    @lru_cache(maxsize=4)  # noqa: B019  (a phase lives as long as its start-up)
    def flows(self, step_s: float) -> list[FloatArray]:
        """Return the matrices of a step, of half of it, and so on."""
        return [self.step(step_s / 2**level) for level in range(_LEVELS + 1)]


class GridSolver(HybridSolver):
    """A start-up at evenly spaced times, in so many `steps` from one to the next; it may be run again with others."""

    phase_type: type[_GridPhase] = _GridPhase
    steps = 1

    def run(self, times_s: FloatArray) -> tuple[list[Motion], FloatArray, FloatArray]:
        """Return motions, states and works at evenly spaced times from 0 on."""
        self.changes, self.works = [], np.zeros(6)
        self.spare = np.ones(len(self.model.press.rollers))
        self._step_s = float(times_s[-1]) / ((len(times_s) - 1) * self.steps)
        part_s, last = self._step_s / _PARTS, (len(times_s) - 1) * self.steps * _PARTS
        mode, y = self.begin()
        mode, y = self.settle(mode, y, 0, 0.0)
        self._kept: list[tuple[Motion, FloatArray, FloatArray]] = [(self.motion(mode), y, self.works)]
        # A piece of the drive ends where the grid has reached its end.
        ends = [min(last, int(np.ceil(one / part_s - 1e-6))) for one in self.inputs.starts_s[1:].tolist()]
        place = 0
        for piece, end in enumerate([*ends, last]):
            start_s, now_s = float(self.inputs.starts_s[piece]), place * part_s
            # The drive before has gone on a little too long; the rims keep their speed, not what they lag behind it.
            jump_m_s = self.inputs.at(now_s, max(piece - 1, 0)) - self.inputs.at(now_s, piece)
            n_q, y = len(y) // 2, y.copy()
            y[n_q : n_q + len(self.model.driven)] += jump_m_s[SPEED]
            while place < end:
                mode, y = self.settle(mode, y, piece, place * part_s)
                if place % (self.steps * _PARTS) == 0:  # what is asked for is what holds after the change
                    self._kept[-1] = (self.motion(mode), y, self.works)
                phase = self.phase(mode, piece)
                z = phase.lift(y, place * part_s - start_s)
                guard, place, z = self._until_change(phase, z, place, end)
                y = z[: len(y)]
                if guard is not None:
                    mode, y = self.change(phase, guard, z, place * part_s)
        motions, states, works = zip(*self._kept, strict=True)
        return list(motions), np.array(states), np.array(works)

    def _until_change(
        self, phase: _GridPhase, z: FloatArray, place: int, end: int
    ) -> tuple[Guard | None, int, FloatArray]:
        """Return the guard that ends the mode, or None; the place that was reached, and z there."""
        flows, block = phase.flows(self._step_s), 4
        while place < end:
            if place % _PARTS == 0 and end - place >= _PARTS:
                count, flow = min(block, (end - place) // _PARTS), flows[0]
                states = np.empty((count + 1, len(z)))
                states[0] = z
                for i in range(count):
                    np.dot(flow, states[i], out=states[i + 1])
                margins = states[1:] @ phase.firing.T
                fired = (margins < -1.0).any(axis=1)
                good = int(np.argmax(fired)) if fired.any() else count
                self._note_spare(phase, margins[:good])
                self._keep(phase, states[: good + 1], place, _PARTS)
                place, z, block = place + good * _PARTS, states[good], min(2 * block, _BLOCK)
                if good == count:
                    continue
            stop, part = min(place - place % _PARTS + _PARTS, end), _PARTS
            while place < stop:
                while part > stop - place:
                    part //= 2
                after = flows[_LEVELS + 1 - part.bit_length()] @ z
                margins = phase.firing @ after
                if margins.min() < -1.0 and part > 1:
                    part //= 2
                    continue
                self._keep(phase, np.array([z, after]), place, part)
                self._note_spare(phase, margins[np.newaxis])
                place, z = place + part, after
                if margins.min() < -1.0:
                    return phase.guards[int(np.argmin(margins))], place, z
        return None, place, z

    def _note_spare(self, phase: _GridPhase, margins: FloatArray) -> None:
        """Note the least share of its friction that each roller has left: the guards are limit − F and limit + F."""
        firsts, rollers = phase.sticking
        one, other = margins[:, firsts], margins[:, [i + 1 for i in firsts]]
        limit = 0.5 * (one + other)
        share = np.divide(np.minimum(one, other), limit, out=np.ones_like(limit), where=limit > 1.0)
        self.spare[rollers] = np.minimum(self.spare[rollers], share.min(axis=0, initial=1.0))

    def _keep(self, phase: _GridPhase, states: FloatArray, place: int, part: int) -> None:
        """Add the works of equal steps, and keep what is asked for of where they end."""
        powers = phase.powers(states)
        made = np.cumsum(powers[:-1] + powers[1:], axis=0) * (0.5 * part / _PARTS * self._step_s)
        n_y, each = len(phase.state), self.steps * _PARTS
        for i in range(1, len(states)):
            if (place + i * part) % each == 0:
                self._kept.append((phase.motion, states[i, :n_y], self.works + made[i - 1]))
        if len(made):
            self.works = self.works + made[-1]


class RK4Solver(GridSolver):
    """The same with the classical Runge-Kutta method between the changes of contacts."""

    phase_type = _RK4Phase
