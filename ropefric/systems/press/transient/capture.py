"""A start-up whose contacts change their state on a grid: exact steps between, no search for the moment.

A step that ends with a guard below zero is tried again in halves, down to a part of it, where the change is made. All
steps are dyadic parts of one, so that a mode costs one exponential and its squarings, and a mode that comes again
nothing. The works are trapezoids of the powers.
"""

import math
from functools import cached_property, lru_cache

import numpy as np
from scipy.linalg import eigvals

from ropefric.arrays import FloatArray
from ropefric.errors import SolverError
from ropefric.systems.press.transient.drives import LOAD
from ropefric.systems.press.transient.exact import Guard, HybridSolver, Phase, lowest_between
from ropefric.systems.press.transient.integrators import rk4_limit_s
from ropefric.systems.press.transient.motion import FORWARD, Mode, Motion, PowerRows, power_rows, powers_W

_LEVELS = 6
_PARTS = 2**_LEVELS
"""A change of a contact is met to this part of a step."""
_SAME_PLACE = 1e-6
"""Of a part: a piece of the drive that begins so near to a place of the grid begins there."""
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

    def lowest(self, states: FloatArray, margins: FloatArray, step_s: float) -> FloatArray:
        """Return how low the guards are in steps from the first state on, and between their ends; margins at these."""
        rates = states @ (self.watch[len(self.guards) :] * (step_s / self.tolerances[:, np.newaxis])).T
        before = np.vstack([self.firing @ states[0], margins[:-1]])
        turning = (rates[:-1] < 0.0) & (rates[1:] > 0.0)
        found = np.minimum(before, margins)
        pieces = before[turning], margins[turning], rates[:-1][turning], rates[1:][turning]
        found[turning] = lowest_between(*pieces)[1]
        return np.asarray(found)

    @cached_property
    def sticking(self) -> tuple[list[int], list[int]]:
        """Return the first of both guards of every contact that sticks, and its roller."""
        firsts = [i for i, one in enumerate(self.guards) if one.what == "slip" and one.direction == FORWARD]
        return firsts, [self.guards[i].place for i in firsts]

    def powers(self, z: FloatArray) -> FloatArray:
        """Return all powers at states z of shape (n, n_z), shape (n, 6)."""
        return powers_W(self.rows, z)

    @cached_property
    def rows(self) -> PowerRows:
        """Return the rows of the powers over z."""
        forces, speeds, starts = power_rows(self.motion)
        return forces @ self.read, speeds @ self.read, starts


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
    looks_between = False
    """Whether a guard that is below zero between steps is a change that is not a drag's."""

    def run(self, times_s: FloatArray) -> tuple[list[Motion], FloatArray, FloatArray]:
        """Return motions, states and works at evenly spaced times from 0 on."""
        self.changes, self.works, self.late, self.only_drags = [], np.zeros(6), 0.0, True
        self.spare = np.ones(len(self.model.press.rollers))
        self._step_s = float(times_s[-1]) / ((len(times_s) - 1) * self.steps)
        part_s, last = self._step_s / _PARTS, (len(times_s) - 1) * self.steps * _PARTS
        mode, y = self.begin()
        mode, y = self.settle(mode, y, 0, 0.0)
        self._kept: list[tuple[Motion, FloatArray, FloatArray]] = [(self.motion(mode), y, self.works)]
        place, past_s, each, last_s = 0, 0.0, self.steps * _PARTS, last * part_s
        for piece, next_s in enumerate([*self.inputs.starts_s[1:].tolist(), last_s]):
            start_s, ends_s = float(self.inputs.starts_s[piece]), min(next_s, last_s)
            if past_s:  # the piece begins between two places of the grid
                length_s = min(ends_s - place * part_s, part_s) - past_s
                y = self._between(piece, mode, y, place * part_s + past_s - start_s, length_s)
                past_s += length_s
                if past_s > (1.0 - _SAME_PLACE) * part_s:
                    place, past_s = place + 1, 0.0
                    self._kept += [(self.motion(mode), y, self.works)] * (place % each == 0)
            end = int(ends_s / part_s + _SAME_PLACE)
            while place < end:
                mode, y = self.settle(mode, y, piece, place * part_s)
                if place % each == 0:  # what is asked for is what holds after the change
                    self._kept[-1] = (self.motion(mode), y, self.works)
                phase = self.phase(mode, piece)
                z = phase.lift(y, place * part_s - start_s)
                guard, place, z = self._until_change(phase, z, place, end)
                y = z[: len(y)]
                if guard is not None:
                    mode, y = self.change(phase, guard, z, place * part_s)
            rest_s = ends_s - place * part_s - past_s
            if rest_s > _SAME_PLACE * part_s:
                y = self._between(piece, mode, y, place * part_s + past_s - start_s, rest_s)
                past_s += rest_s
        motions, states, works = zip(*self._kept, strict=True)
        return list(motions), np.array(states), np.array(works)

    def _between(self, piece: int, mode: Mode, y: FloatArray, since_s: float, length_s: float) -> FloatArray:
        """Return the state after less than a part of a step, where a piece of the drive begins or ends."""
        phase = self.phase(mode, piece)
        z = phase.lift(y, since_s)
        after = phase.step(length_s) @ z
        self.works = self.works + 0.5 * length_s * phase.powers(np.array([z, after])).sum(axis=0)
        return np.asarray(after[: len(y)])

    def change(self, phase: Phase, guard: Guard, z: FloatArray, now: float) -> tuple[Mode, FloatArray]:
        """Return the mode and the state after a guard has fired, and note what its being late can do at most.

        As √(2 energy): a drag that lets go or takes hold too late is a wrong force for a part of a step, and its work is
        all that an error lives of, as drags, springs and dampers give no energy to a difference of two motions.
        """
        motion, place = phase.motion, guard.place
        if guard.what in {"hold", "release"}:
            w, drag_N = phase.read @ z, self.model.drag_N[place]
            force_N = -guard.row @ w if guard.what == "release" else 2.0 * drag_N * (motion.inputs[LOAD] @ w)
            mass_kg = self.model.roller_mass_kg[place] + self.model.arc_mass_kg[place]
            self.late += max(float(force_N), 0.0) * self._step_s / _PARTS / math.sqrt(mass_kg)
        else:
            self.only_drags &= guard.what == "friction"
        return super().change(phase, guard, z, now)

    @property
    def late_tension_N(self) -> float:
        """Return what `late` can be worth in any tension at most: k e of a spring and η k de/dt of its damping."""
        return self.late * float(self.model.tension_per_root_energy.max())

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
                if good:
                    low = phase.lowest(states[: good + 1], margins[:good], self._step_s)
                    self.only_drags &= not self.looks_between or bool(low.min() >= -1.0)
                    self._note_spare(phase, low)
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
                both = np.array([z, after])
                self._keep(phase, both, place, part)
                self._note_spare(phase, phase.lowest(both, margins[np.newaxis], part / _PARTS * self._step_s))
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
