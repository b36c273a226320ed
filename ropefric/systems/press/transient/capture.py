"""A start-up whose contacts change their state, on a grid: what carries a step is known, and changes are met inside it.

All steps are dyadic parts of one, so that a mode costs one exponential and its squarings, and a mode that comes again
nothing. Guards are looked at as often as in the search for exact moments; a change is met by halves of a step, and in
the shortest part along the Taylor series of the solution. The works are trapezoids of the powers and their slopes.
"""

import math
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import SolverError
from ropefric.systems.press.transient.exact import (
    TAYLOR_TERMS,
    Along,
    Guard,
    HybridSolver,
    Phase,
    check_steps,
    first_dip,
    first_to_fall,
    lowest_between,
    near_zero,
)
from ropefric.systems.press.transient.motion import Mode, Motion, power_rows

_UNITS = 2**42
"""Places of the grid in a step: so near that a moment is one of them."""
_LEVELS = 6
"""Number of halvings of the longest step that gives the first step after a change."""
_TURNED = 2.0
"""‖hG‖ of the shortest part at most, whose Taylor series needs no more terms than there are."""
_LONGER = 2.0
"""Than in the search for exact moments: 12 steps in a period."""
_BLOCK, _KEPT = 32, 64
"""Steps looked at together at most, and works taken together: products that BLAS does not share among threads."""


class _GridPhase(Phase):
    """One mode during one piece of the drive, with its steps of a grid."""

    @lru_cache(maxsize=1)  # noqa: B019  (a phase lives as long as its start-up)
    def flows(self, step_s: float, longest_s: float) -> tuple[int, list[FloatArray]]:
        """Return how often the step is halved first, and the matrices of that part, half of it, and so on."""
        first = math.ceil(math.log2(max(step_s / longest_s, 1.0)))
        turned = float(np.linalg.norm(self._balanced[0], 1)) * step_s
        last = max(first + _LEVELS, math.ceil(math.log2(max(turned, _TURNED) / _TURNED)))
        if 2**last > _UNITS:
            raise SolverError("no grid is fine enough for the fastest motion", code="RF524")
        flows = [self.step(step_s / 2**last)]
        while len(flows) <= last - first:
            flows.insert(0, flows[0] @ flows[0])
        return first, flows

    def along(self, z: FloatArray, within_s: float) -> Along:
        """Return z as a function of the time from now on, within a part so short that its Taylor series is exact."""
        generator, weights = self._balanced
        rows = [z / weights]
        for order in range(1, TAYLOR_TERMS):
            rows.append((within_s / order) * (generator @ rows[-1]))
        series, orders = weights[:, np.newaxis] * np.transpose(rows), np.arange(TAYLOR_TERMS)
        return lambda tau_s: np.asarray(series @ (tau_s / within_s) ** orders)

    @cached_property
    def firing(self) -> tuple[FloatArray, FloatArray]:
        """Return the guards, and their rates, over the guards' tolerances, as columns over z."""
        margins, rates = np.split(self.watch, 2)
        return (margins / self.tolerances[:, np.newaxis]).T, (rates / self.tolerances[:, np.newaxis]).T

    def suspects(self, states: FloatArray, length_s: float) -> BoolArray:
        """Return in which of equal steps a guard ends below zero, or may have been there between."""
        margins, rates = (states @ rows for rows in self.firing)
        rates *= length_s
        low, falling, rising = margins[1:].copy(), rates[:-1], rates[1:]
        turning = (falling < 0.0) & (rising > 0.0)
        if turning.any():
            falling, rising = falling[turning], rising[turning]
            lowest = lowest_between(margins[:-1][turning], low[turning], falling, rising)[1]
            low[turning] = np.minimum(low[turning], lowest - near_zero(falling, rising))
        return np.asarray((low < -1.0).any(axis=1))

    def works(self, states: FloatArray, lengths_s: FloatArray, asked: IntArray) -> FloatArray:
        """Return the works up to some of these states, shape (n, 6): by trapezoids and the slopes at their ends."""
        (forces, speeds), (harder, faster), starts = self._rows
        powers = np.add.reduceat((states @ forces.T) * (states @ speeds.T), starts, axis=1)
        half_s = 0.5 * lengths_s[:, np.newaxis]
        made = np.cumsum(half_s * (powers[:-1] + powers[1:]), axis=0)[asked - 1]
        # Σ h²/12 (p'_i − p'_(i+1)): among equal steps all but the ends cancel.
        squares = np.diff(lengths_s**2, prepend=0.0) / 12.0
        corners = np.flatnonzero(squares)
        some = states[np.concatenate([corners, asked])]
        slopes = (some @ harder.T) * (some @ speeds.T) + (some @ forces.T) * (some @ faster.T)
        ahead, here = np.split(np.add.reduceat(slopes, starts, axis=1), [len(corners)])
        gained = np.vstack([np.zeros(6), np.cumsum(squares[corners, np.newaxis] * ahead, axis=0)])
        gained = gained[np.searchsorted(corners, asked)] - lengths_s[asked - 1, np.newaxis] ** 2 / 12.0 * here
        return np.asarray(made + gained)

    @cached_property
    def _rows(self) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray], list[int]]:
        forces, speeds, starts = power_rows(self.motion)
        forces, speeds = forces @ self.read, speeds @ self.read
        return (forces, speeds), (forces @ self.rate, speeds @ self.rate), starts


class GridSolver(HybridSolver):
    """A start-up at evenly spaced times."""

    phase_type = _GridPhase

    def run(self, times_s: FloatArray) -> tuple[list[Motion], FloatArray, FloatArray]:
        """Return motions, states and works at evenly spaced times from 0 on."""
        mode, y = self.begin()
        self._longest_s: dict[Mode, float] = {}
        gaps = len(times_s) - 1
        steps = max(1, math.ceil(float(times_s[-1]) / gaps / self._longest(self.phase(mode, 0))))
        check_steps(float(gaps * steps))
        self._step_s = float(times_s[-1]) / (gaps * steps)
        self._unit_s, self._each = self._step_s / _UNITS, steps * _UNITS
        end, starts_s = gaps * self._each, self.inputs.starts_s
        starts = [round(start_s / self._unit_s) for start_s in starts_s[starts_s < times_s[-1]].tolist()]
        self._kept: list[tuple[Motion, FloatArray, FloatArray]] = [(self.motion(mode), y, self.works)]
        place = piece = 0
        for piece, (begin, stop) in enumerate(pairwise([*starts, end])):
            place = begin
            while place < stop:
                mode, y = self._settled(mode, y, piece, place)
                phase = self.phase(mode, piece)
                z = phase.lift(y, place * self._unit_s - float(starts_s[piece]))
                guard, place, z = self._until_change(phase, z, place, stop)
                y = z[: len(y)]
                if guard is not None:
                    mode, y = self.change(phase, guard, z, place * self._unit_s)
        self._settled(mode, y, piece, place)
        motions, states, works = zip(*self._kept, strict=True)
        return list(motions), np.array(states), np.array(works)

    def _settled(self, mode: Mode, y: FloatArray, piece: int, place: int) -> tuple[Mode, FloatArray]:
        """Return mode and state after all changes of one moment."""
        mode, y = self.settle(mode, y, piece, place * self._unit_s)
        if place % self._each == 0:
            self._kept[-1] = (self.motion(mode), y, self.works)
        return mode, y

    def _longest(self, phase: _GridPhase) -> float:
        """Return the longest step of a mode; tangents of its friction do not change that."""
        mode = phase.motion.mode
        if mode not in self._longest_s:
            self._longest_s[mode] = _LONGER * phase.step_s
        return self._longest_s[mode]

    def _until_change(
        self, phase: _GridPhase, z: FloatArray, place: int, end: int
    ) -> tuple[Guard | None, int, FloatArray]:
        """Return the guard that ends the mode, or None; the place that was reached, and z there."""
        first, flows = phase.flows(self._step_s, self._longest(phase))
        longest, shortest = _UNITS >> first, _UNITS >> (first + len(flows) - 1)
        begun, block, guard = place, 1, None
        self._path, self._places = [z[np.newaxis]], [place]
        while place < end and guard is None:
            # As long as what has passed since the change, from one of its own multiples to the next.
            length = min(longest, end - place, max(place - begun, shortest), (place & -place) or longest)
            if length < shortest:
                length = min(shortest - place % shortest, end - place)
                states = np.array([z, phase.along(z, shortest * self._unit_s)(length * self._unit_s)])
            else:
                length = 1 << (length.bit_length() - 1)
                count = min(block, (end - place) // length) if length == longest else 1
                flow, states = flows[(longest // length).bit_length() - 1], np.empty((count + 1, len(z)))
                states[0] = z
                for i in range(count):
                    np.dot(flow, states[i], out=states[i + 1])
            self._steps += len(states) - 1
            check_steps(self._steps)
            suspects = phase.suspects(states, length * self._unit_s)
            good = int(np.argmax(suspects)) if suspects.any() else len(suspects)
            self._walk(states[: good + 1], length)
            if good < len(suspects):
                guard, block = self._meet(phase, states[good : good + 2], length, longest, flows), 1
            else:
                block = min(2 * block, _BLOCK)
            place, z = self._places[-1], self._path[-1][-1]
            if len(self._places) > _KEPT:
                self._keep(phase)
        self._keep(phase)
        return guard, place, z

    def _meet(
        self, phase: _GridPhase, ends: FloatArray, length: int, longest: int, flows: list[FloatArray]
    ) -> Guard | None:
        """Return the first guard that falls below zero in a step, gone up to there; None where none does after all."""
        z, after = ends
        shortest = longest >> (len(flows) - 1)
        while length > shortest:
            length //= 2
            halved = np.array([z, flows[(longest // length).bit_length() - 1] @ z])
            if phase.suspects(halved, length * self._unit_s)[0]:
                after = halved[1]
            else:
                self._walk(halved, length)
                z = halved[1]
        along, guard = phase.along(z, shortest * self._unit_s), None
        fired, bound_s = first_dip(phase, along, z, after, length * self._unit_s)
        if fired.any():
            guard, passed_s = first_to_fall(phase, along, fired, bound_s)
            length = min(math.ceil(passed_s / self._unit_s), length)
            after = along(length * self._unit_s)
        if length:
            self._walk(np.array([z, after]), length)
        return guard

    def _walk(self, states: FloatArray, length: int) -> None:
        """Go along equal steps, the first of which begins where the last one ended."""
        begin = self._places[-1]
        if len(states) > 1:
            self._path.append(states[1:])
        self._places.extend(range(begin + length, begin + length * len(states), length))

    def _keep(self, phase: _GridPhase) -> None:
        """Add the works along the path, and keep of its states those that are asked for."""
        states, places = np.concatenate(self._path), np.array(self._places)
        if len(states) > 1:
            asked = np.append(np.flatnonzero(places[1:-1] % self._each == 0), len(places) - 2) + 1
            works = self.works + phase.works(states, np.diff(places) * self._unit_s, asked)
            for i, work in zip(asked.tolist(), works, strict=True):
                if places[i] % self._each == 0:
                    self._kept.append((phase.motion, states[i, : len(phase.state)], work))
            self.works = works[-1]
        self._path, self._places = [states[-1:]], self._places[-1:]
