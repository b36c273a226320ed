"""A start-up with slip and slack: exact steps inside each mode, and a search for the moment at which one ends."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import SolverError
from ropefric.systems.press.transient.guards import Guard, switched
from ropefric.systems.press.transient.inputs import Inputs
from ropefric.systems.press.transient.integrators import check_steps
from ropefric.systems.press.transient.mode import Mode, sticking
from ropefric.systems.press.transient.model import ElasticPress
from ropefric.systems.press.transient.motion import FrictionLimit, Motion
from ropefric.systems.press.transient.phase import Phase, first_dip
from ropefric.systems.press.transient.problem import starting_state

_SWITCHES_AT_ONCE = 60
_MAX_SWITCHES = 3_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """A change of mode."""

    time_s: float
    what: str
    place: int
    direction: int = 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HybridSolution:
    """States at the times asked for."""

    states: FloatArray
    works: FloatArray
    motions: tuple[Motion, ...]
    changes: tuple[Change, ...]


def solve_hybrid(
    model: ElasticPress, inputs: Inputs, limit: FrictionLimit, times_s: FloatArray
) -> HybridSolution:
    """Return a start-up in which belts may slip and go slack.

    Between two changes of a contact's or span's state the press is linear and is solved by matrix exponentials; the
    guards of the mode are looked at 24 times in a period of its fastest oscillation.
    """
    solver = _Solver(model=model, inputs=inputs, limit=limit)
    return solver.run(times_s)


@dataclass(kw_only=True, eq=False)
class _Solver:
    model: ElasticPress
    inputs: Inputs
    limit: FrictionLimit

    def __post_init__(self) -> None:
        self.phases: dict[tuple[Mode, int], Phase] = {}
        self.motions: dict[Mode, Motion] = {}
        self.changes: list[Change] = []
        self.works = np.zeros(6)
        self.steps = 0

    def motion(self, mode: Mode) -> Motion:
        if mode not in self.motions:
            self.motions[mode] = Motion(model=self.model, mode=mode, limit=self.limit)
        return self.motions[mode]

    def phase(self, mode: Mode, piece: int) -> Phase:
        key = (mode, piece)
        if key not in self.phases:
            self.phases[key] = Phase(motion=self.motion(mode), taylor=self.inputs.taylor[piece])
        return self.phases[key]

    def run(self, times_s: FloatArray) -> HybridSolution:
        mode = sticking(self.model)
        y = starting_state(self.motion(mode), self.inputs)
        starts = self.inputs.starts_s
        stops = np.union1d(times_s, starts[starts < times_s[-1]])
        states = np.zeros((len(times_s), len(y)))
        works, motions = np.zeros((len(times_s), 6)), []
        wanted = set(times_s.tolist())
        now, row = 0.0, 0
        for stop in stops.tolist():
            if stop > now:
                piece = int(np.searchsorted(starts, now, side="right")) - 1
                mode, y = self._advance(mode, y, piece, now, stop)
                now = stop
            if stop in wanted:
                piece = int(np.searchsorted(starts, now, side="right")) - 1
                mode, y = self._settle(mode, y, piece, now)
                states[row], works[row] = y, self.works
                motions.append(self.motion(mode))
                row += 1
        return HybridSolution(states=states, works=works, motions=tuple(motions), changes=tuple(self.changes))

    def _advance(
        self, mode: Mode, y: FloatArray, piece: int, now: float, stop: float
    ) -> tuple[Mode, FloatArray]:
        start = float(self.inputs.starts_s[piece])
        remaining, fresh = stop - now, now == start
        while remaining > 0.0:
            mode, y = self._settle(mode, y, piece, stop - remaining)
            phase = self.phase(mode, piece)
            z = phase.propagator.lift(y, stop - remaining - start)
            n = len(y)
            for length in phase.lengths(remaining, fresh=fresh):
                ended, passed, z = self._try(phase, z, length)
                remaining -= passed
                if ended is not None:
                    u = (phase.propagator.read @ z)[n:]
                    mode, y = self._change(phase, ended, z[:n], u, stop - max(remaining, 0.0))
                    fresh = True
                    break
            else:
                y, remaining = z[:n], 0.0
        return mode, y

    def _try(self, phase: Phase, z: FloatArray, length: float) -> tuple[Guard | None, float, FloatArray]:
        """Return the guard that ends the mode within a step, or None; the time that passed, and z after it."""
        self.steps += 1
        check_steps(self.steps)
        flow, integrals = phase.grid_step(length)
        after = flow @ z
        n = len(phase.guards)
        before_values, after_values = phase.watch @ z, phase.watch @ after
        g0, s0, g1, s1 = before_values[:n], before_values[n:], after_values[:n], after_values[n:]
        fired, bound = first_dip(phase, z, (g0, s0, g1, s1), length)
        if not fired.any():
            fired, bound = g1 < -phase.tolerances, length
        if not fired.any():
            self.works = self.works + (integrals @ z) @ z
            return None, length, after
        guard, passed = _first(phase, z, fired, bound)
        if passed > 0.0:
            self.works = self.works + (phase.work(passed) @ z) @ z
            z = phase.flow(passed) @ z
        return guard, passed, z

    def _settle(self, mode: Mode, y: FloatArray, piece: int, now: float) -> tuple[Mode, FloatArray]:
        """Switch until no guard is below zero."""
        for _ in range(_SWITCHES_AT_ONCE):
            phase = self.phase(mode, piece)
            z = phase.propagator.lift(y, now - float(self.inputs.starts_s[piece]))
            margins = (phase.watch[: len(phase.guards)] @ z) / phase.tolerances
            # What has just been switched stands at minus its tolerance.
            if margins.min() >= -2.0:
                return mode, y
            u = (phase.propagator.read @ z)[len(y) :]
            mode, y = self._change(phase, phase.guards[int(np.argmin(margins))], y, u, now)
        raise SolverError(
            f"the state of the contacts cannot be settled at t = {now:.6g} s",
            code="RF524",
            fix="give the belts some damping, or a smoother drive",
        )

    def _change(
        self, phase: Phase, guard: Guard, y: FloatArray, u: FloatArray, now: float
    ) -> tuple[Mode, FloatArray]:
        self.changes.append(Change(time_s=now, what=guard.what, place=guard.place, direction=guard.direction))
        if len(self.changes) > _MAX_SWITCHES:
            raise SolverError(
                f"contacts and spans changed their state {_MAX_SWITCHES} times before t = {now:.6g} s",
                code="RF524",
                fix="give the belts some damping, or ask for a shorter time",
            )
        return switched(phase.motion, guard, y, u)


def _first(phase: Phase, z: FloatArray, fired: BoolArray, bound: float) -> tuple[Guard, float]:
    """Return the guard that is the first to fall below zero, given some that have by `bound`, and when."""
    rows = phase.watch[: len(phase.guards)] / phase.tolerances[:, None]
    passed = bound
    while True:
        chosen = rows[fired]

        def margin(tau: float, chosen: FloatArray = chosen) -> float:
            there = phase.flow(tau) @ z if tau > 0.0 else z
            return float((chosen @ there).min()) + 1.0

        if margin(0.0) <= 0.0:
            passed = 0.0
        else:
            passed = float(brentq(margin, 0.0, passed, xtol=1e-15 + 1e-12 * passed, rtol=1e-13))
        margins = rows @ (phase.flow(passed) @ z if passed > 0.0 else z)
        # One that falls and rises again before the others fall is met here.
        earlier = (margins < -2.0) & ~fired
        if passed == 0.0 or not earlier.any():
            return phase.guards[int(np.argmin(np.where(fired, margins, np.inf)))], passed
        fired = earlier
