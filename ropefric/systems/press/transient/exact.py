"""A start-up with slip and slack: exact steps inside each mode, and changes of mode met inside the steps of a grid.

Exact steps of dy/dt = A y + B u(t) with polynomial u: a polynomial of degree r is itself the solution of dp/dt = N p
with p_j = τ^j/j!, so one exponential of the joint matrix carries both over a step of any length: there is no error of
discretisation, however stiff A is. Ways and speeds differ by the
frequencies in size; balanced by powers of two, slow motions keep their digits beside fast ones.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from scipy.linalg import eigvals, expm, matrix_balance
from scipy.optimize import brentq

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import SolverError
from ropefric.systems.press.slip import LEAST_SLACK_N
from ropefric.systems.press.transient.drives import LOAD, ONE, Inputs
from ropefric.systems.press.transient.motion import (
    BACKWARD,
    FORWARD,
    STICK,
    ElasticPress,
    FrictionLimit,
    Mode,
    Motion,
    power_rows,
    starting_state,
    sticking,
)

TAYLOR_TERMS = 24


class Propagator:
    """Steps of z = (y, p_r … p_0), the state beside the powers of the time since the start of a piece."""

    def __init__(self, state: FloatArray, drive: FloatArray, taylor: FloatArray) -> None:
        self.state, self.drive, self.taylor = state, drive, taylor

    @cached_property
    def read(self) -> FloatArray:
        """Return the matrix that gives (y, u) from z, shape (n + m, n + r + 1)."""
        n, (m, powers) = len(self.state), self.taylor.shape
        return np.block([[np.eye(n), np.zeros((n, powers))], [np.zeros((m, n)), self.taylor[:, ::-1]]])

    def lift(self, y: FloatArray, tau_s: float) -> FloatArray:
        """Return z at the time `tau_s` after the start of the piece."""
        powers = [1.0]
        for j in range(1, self.taylor.shape[1]):
            powers.append(powers[-1] * tau_s / j)
        return np.concatenate([y, powers[::-1]])

    @cached_property
    def _balanced(self) -> tuple[FloatArray, FloatArray]:
        """Return the generator G of dz/dt = G z over z divided by powers of two, and these."""
        state, (scale, _) = matrix_balance(self.state, permute=False, separate=True)
        acting = (self.drive @ self.taylor[:, ::-1]) / scale[:, None]
        # Large inputs would make the norm large, and with it the number of doublings and their rounding.
        excess = float(np.linalg.norm(acting, 1)) / max(float(np.linalg.norm(state, 1)), 1e-300)
        share = 2.0 ** -math.ceil(math.log2(excess)) if 1.0 < excess < math.inf else 1.0
        powers = self.taylor.shape[1]
        lower = np.zeros((powers, len(state)))
        generator = np.block([[state, share * acting], [lower, np.eye(powers, k=1)]])
        return generator, np.concatenate([scale, np.full(powers, share)])

    def step(self, length_s: float) -> FloatArray:
        """Return the matrix that carries z over a step, shape (n + r + 1, n + r + 1)."""
        generator, weights = self._balanced
        return np.asarray(weights[:, None] * expm(length_s * generator) / weights)


MOST_STEPS = 500_000
"""Of a start-up; each takes some 50 µs."""


def check_steps(needed: float) -> None:
    """Refuse a start-up of more steps than anybody waits for; return quietly otherwise."""
    if not needed <= MOST_STEPS:
        raise SolverError(
            f"the start-up takes more than {MOST_STEPS} steps, the limit: its fastest oscillation is"
            " too short for the time simulated",
            code="RF524",
            key="start_up.simulate",
            fix="simulate a shorter time, or correct the inertias, masses and stiffnesses",
        )


What = Literal["slip", "stick", "hold", "release", "pressed", "taut", "strained", "friction"]

_FORCE_SHARE = 1e-10
"""A guard on a force has fired when it is below zero by this share of the preload."""
_SPEED_M_S = 1e-11


class Guard(NamedTuple):
    """The end of a mode: a row that stays above zero as long as a contact or span keeps its state."""

    row: FloatArray
    tolerance: float
    what: What
    place: int
    direction: int = 0


def guards_of(motion: Motion) -> list[Guard]:
    """Return the guards of a mode: of the drags, of slip and of slack."""
    model, mode, found = motion.model, motion.mode, []
    force_N = _FORCE_SHARE * float(model.preload_N.max())
    for i in np.flatnonzero(model.drag_N).tolist():
        if turning := mode.turning[i]:
            found.append(Guard(turning * motion.rim_speed_m_s[i], _SPEED_M_S, "hold", i))
            continue
        held_N = model.drag_N[i] * motion.inputs[LOAD]
        found += [Guard(held_N - way * motion.friction_N[i], force_N, "release", i, way) for way in (1, -1)]
    for i, contact in enumerate(mode.contact):
        if contact == STICK:
            for way, most_N in zip((FORWARD, BACKWARD), motion.limit_N, strict=True):
                found.append(Guard(most_N[i] - way * motion.friction_N[i], force_N, "slip", i, way))
        else:
            found.append(Guard(contact * motion.slip_speed_m_s[i], _SPEED_M_S, "stick", i))
    bits: tuple[tuple[What, FloatArray, tuple[bool, ...]], ...] = (
        ("pressed", motion.pressing_N, mode.pressed),
        ("taut", motion.unclipped_N, mode.taut),
        ("strained", motion.spring_N, mode.strained),
    )
    for what, rows, states in bits:
        found += [Guard(rows[i] if is_so else -rows[i], force_N, what, i) for i, is_so in enumerate(states)]
    return found + _friction_guards(motion, force_N)


_WHILE_STICKING = 3.0
"""How much farther a tangent is followed where it only says whether the belt slips: it is off by 9 times as much."""


def _friction_guards(motion: Motion, force_N: float) -> list[Guard]:
    """Return what ends where friction that follows the tensions is near enough to its tangent."""
    limit, found = motion.limit, []
    if limit is None or limit.slack_N is None:
        return []
    for (way, i), slack_N in np.ndenumerate(limit.slack_N):
        side, base_N = motion.sides_N[way][i], slack_N * motion.inputs[ONE]
        slips = motion.mode.contact[i] == (FORWARD, BACKWARD)[way]
        factor = np.exp(limit.width[way, i] * (1.0 if slips else _WHILE_STICKING))
        found.append(Guard(factor * base_N - side, force_N, "friction", i))
        if slack_N > LEAST_SLACK_N:
            found.append(Guard(side - base_N / factor, force_N, "friction", i))
    return found


def switched(motion: Motion, guard: Guard, w: FloatArray) -> tuple[Mode, FloatArray]:
    """Return the mode after a guard has fired, and the state with the speeds that the new mode ties set equal."""
    mode, place, state = motion.mode, guard.place, w[: len(motion.derivative)].copy()

    def put(name: str, value: int) -> Mode:
        states = getattr(mode, name)
        return replace(mode, **{name: (*states[:place], value, *states[place + 1 :])})

    if guard.what in {"pressed", "taut", "strained"}:
        return put(guard.what, not getattr(mode, guard.what)[place]), state
    if guard.what == "slip":
        return put("contact", guard.direction), state
    if guard.what == "stick":
        state[place - len(mode.contact)] = 0.0
        return put("contact", STICK), state
    if guard.what == "hold":
        row = int(np.flatnonzero(motion.model.driven == place)[0])
        state[motion.n_coordinates + row] -= float(motion.rim_speed_m_s[place] @ w)
    return put("turning", guard.direction), state


_STEPS_PER_PERIOD = 12
"""Guards are looked at this often in a period of the fastest oscillation; extremes between are interpolated."""
_UNITS = 2**42
"""Places of the grid between two times asked for: so near that a moment is one of them."""
_LEVELS = 6
"""Number of halvings of the longest step that gives the first step after a change."""
_TURNED = 2.0
"""‖hG‖ of the shortest part at most, whose Taylor series needs no more terms than there are."""
_BLOCK, _KEPT = 32, 64
"""Steps looked at together at most, and works taken together: products that BLAS does not share among threads."""


def lowest_between(
    first: FloatArray, last: FloatArray, falling: FloatArray, rising: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return where in a step the cubic through values and slopes at both ends is lowest, as a share, and how low.

    It is where its slope a x² + b x + c turns from falling to rising; slopes are per step.
    """
    a = 3.0 * (falling + rising - 2.0 * (last - first))
    b = rising - falling - a
    root = np.sqrt(np.maximum(b * b - 4.0 * a * falling, 0.0))
    x = np.minimum(-2.0 * falling / np.maximum(b + root, 1e-300), 1.0)
    return x, first + x * (falling + x * (0.5 * b + x * a / 3.0))


_CUBIC_ERROR = 3e-3
"""Of a guard's slope over a step: twice what the cubic is off by at most with 12 steps in a period."""


def near_zero(falling: FloatArray, rising: FloatArray) -> FloatArray:
    """Return the error of a cubic through values and slopes, from its slopes over a step."""
    return np.asarray(_CUBIC_ERROR * np.maximum(-falling, rising))


Along: TypeAlias = Callable[[float], FloatArray]
"""z as a function of the time from now on."""


class Phase(Propagator):
    """One mode during one piece of the drive, with its steps of a grid, ready to be stepped through and watched."""

    def __init__(self, motion: Motion, taylor: FloatArray, guards: list[Guard], gap_s: float) -> None:
        rows, n = motion.derivative, len(motion.derivative)
        super().__init__(rows[:, :n], rows[:, n:], taylor)
        self.motion, self.guards, self.gap_s = motion, guards, gap_s
        self.tolerances = np.array([guard.tolerance for guard in self.guards])
        # The guards, and below them their rates, as rows over z.
        n_z = self.read.shape[1]
        self.rate = np.vstack([rows @ self.read, np.eye(n_z - n, n_z, k=n + 1)])
        watched = np.vstack([guard.row for guard in self.guards]) @ self.read
        self.watch = np.vstack([watched, watched @ self.rate])

    @cached_property
    def step_s(self) -> float:
        """Return the longest step at which no oscillation is overlooked [s]."""
        rates = np.asarray(eigvals(self.state), np.complex128)
        fastest = float(np.abs(rates[rates.imag != 0.0]).max(initial=0.0))
        return min(2.0 * np.pi / (fastest * _STEPS_PER_PERIOD) if fastest else np.inf, self.gap_s)

    @cached_property
    def flows(self) -> tuple[int, list[FloatArray]]:
        """Return how often the gap is halved first, and the matrices of that part, half of it, and so on."""
        first = math.ceil(math.log2(self.gap_s / self.step_s))
        turned = float(np.linalg.norm(self._balanced[0], 1)) * self.gap_s
        last = max(first + _LEVELS, math.ceil(math.log2(max(turned, _TURNED) / _TURNED)))
        if 2**last > _UNITS:
            raise SolverError(
                "no grid is fine enough for the fastest motion",
                code="RF524",
                key="start_up.simulate",
                fix="correct the inertias, masses, stiffnesses and dampings",
            )
        flows = [self.step(self.gap_s / 2**last)]
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


def first_dip(
    phase: Phase, along: Along, z: FloatArray, after: FloatArray, length: float
) -> tuple[BoolArray, float]:
    """Return which guards dip below zero inside a step that they begin and end above it, and where the first does."""
    n, begun, ended = len(phase.guards), phase.watch @ z, phase.watch @ after
    g0, s0, g1, s1 = begun[:n], begun[n:], ended[:n], ended[n:]
    turning = np.flatnonzero((s0 < 0.0) & (s1 > 0.0))
    if turning.size:
        falling, rising = length * s0[turning], length * s1[turning]
        x, lowest = lowest_between(g0[turning], g1[turning], falling, rising)
        low = lowest - near_zero(falling, rising) < -phase.tolerances[turning]
        for k in np.argsort(x)[low[np.argsort(x)]]:
            i, place = turning[k], float(x[k]) * length
            slope = float(
                phase.watch[n + i] @ along(place)
            )  # the cubic's lowest place is not quite the guard's
            place = min(max(place - slope * length / (s1[i] - s0[i]), 0.0), length)
            if phase.watch[i] @ along(place) < -phase.tolerances[i]:
                return np.arange(n) == i, place
    return g1 < -phase.tolerances, length


_SAME = 1e-15


def first_to_fall(phase: Phase, along: Along, fired: BoolArray, bound: float) -> tuple[Guard, float]:
    """Return the guard that is the first to fall below zero, given some that have by `bound`, and when."""
    rows = phase.watch[: len(phase.guards)] / phase.tolerances[:, None]
    passed = bound
    while True:
        chosen = rows[fired]

        def margin(tau: float, chosen: FloatArray = chosen) -> float:
            return float((chosen @ along(tau)).min()) + 1.0

        if margin(0.0) <= 0.0:
            passed = 0.0
        elif margin(passed) < 0.0:  # by rounding it may not quite be
            # Not before the moment: a guard that has not quite fallen would send the mode back at once.
            root = float(brentq(margin, 0.0, passed, xtol=_SAME * passed, rtol=_SAME))
            passed = min(root + 4.0 * _SAME * passed, passed)
        margins = rows @ along(passed)
        # One that falls and rises again before the others fall is met here.
        earlier = (margins < -2.0) & ~fired
        if passed == 0.0 or not earlier.any():
            return phase.guards[int(np.argmin(np.where(fired, margins, np.inf)))], passed
        fired = earlier


_SWITCHES_AT_ONCE = 60
_MAX_SWITCHES = 3_000


class HybridSolver:
    """A start-up whose drags oppose the motion, and whose belts slip and go slack.

    `follow` gives the limit of friction from the tensions beside the rollers, where it follows them.

    Between two changes of a contact's or span's state the press is linear and what carries a step is known. All steps
    are dyadic parts of the gap between two times asked for, so that a mode costs one exponential and its squarings,
    and a mode that comes again nothing. Guards are looked at 12 times in a period of the fastest oscillation; a change
    is met by halves of a step, and in the shortest part along the Taylor series of the solution. The works are
    trapezoids of the powers and their slopes.
    """

    def __init__(
        self,
        model: ElasticPress,
        inputs: Inputs,
        limit: FrictionLimit,
        *,
        follow: Callable[[FloatArray], FrictionLimit] | None = None,
    ) -> None:
        self.model, self.inputs, self.limit, self.follow = model, inputs, limit, follow
        self.changes: list[tuple[float, Guard]] = []
        self._phases: dict[tuple[Mode, int], Phase] = {}
        self._motions: dict[Mode, Motion] = {}
        self.works = np.zeros(6)
        self._steps = 0

    def run(self, times_s: FloatArray) -> tuple[list[Motion], FloatArray, FloatArray]:
        """Return motions, states and works at evenly spaced times from 0 on; `changes` has the guards that fired."""
        mode, y = self.begin()
        gaps, starts_s = len(times_s) - 1, self.inputs.starts_s
        self._gap_s = float(times_s[-1]) / gaps
        self._unit_s = self._gap_s / _UNITS
        check_steps(float(times_s[-1]) / self.phase(mode, 0).step_s)
        starts = [round(start_s / self._unit_s) for start_s in starts_s[starts_s < times_s[-1]].tolist()]
        self._kept: list[tuple[Motion, FloatArray, FloatArray]] = [(self.motion(mode), y, self.works)]
        place = piece = 0
        for piece, (begin, stop) in enumerate(pairwise([*starts, gaps * _UNITS])):
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

    def begin(self) -> tuple[Mode, FloatArray]:
        """Return the mode and the state of the machine at rest, its drags holding it."""
        mode = sticking(self.model)
        y = starting_state(self.motion(mode), self.inputs, held=True)
        self._refresh(self.motion(mode), np.concatenate([y, self.inputs.at(0.0)]))
        return replace(mode, turning=tuple((self.model.drag_N == 0.0).astype(int).tolist())), y

    def _refresh(self, motion: Motion, w: FloatArray) -> None:
        """Let the limit follow the tensions; what was made with the one before is of no use then."""
        if self.follow is not None:
            self.limit = self.follow(np.array([side @ w for side in motion.sides_N]))
            self._motions.clear()
            self._phases.clear()

    def motion(self, mode: Mode) -> Motion:
        """Return the press in a mode."""
        if mode not in self._motions:
            self._motions[mode] = Motion(self.model, mode, self.limit)
        return self._motions[mode]

    def phase(self, mode: Mode, piece: int) -> Phase:
        """Return a mode during a piece of the drive."""
        if (mode, piece) not in self._phases:
            motion, taylor = self.motion(mode), self.inputs.taylor[piece]
            self._phases[mode, piece] = Phase(motion, taylor, guards_of(motion), self._gap_s)
        return self._phases[mode, piece]

    def _settled(self, mode: Mode, y: FloatArray, piece: int, place: int) -> tuple[Mode, FloatArray]:
        """Return mode and state after all changes of one moment."""
        mode, y = self.settle(mode, y, piece, place * self._unit_s)
        if place % _UNITS == 0:
            self._kept[-1] = (self.motion(mode), y, self.works)
        return mode, y

    def _until_change(
        self, phase: Phase, z: FloatArray, place: int, end: int
    ) -> tuple[Guard | None, int, FloatArray]:
        """Return the guard that ends the mode, or None; the place that was reached, and z there."""
        first, flows = phase.flows
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
        self, phase: Phase, ends: FloatArray, length: int, longest: int, flows: list[FloatArray]
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

    def _keep(self, phase: Phase) -> None:
        """Add the works along the path, and keep of its states those that are asked for."""
        states, places = np.concatenate(self._path), np.array(self._places)
        if len(states) > 1:
            asked = np.append(np.flatnonzero(places[1:-1] % _UNITS == 0), len(places) - 2) + 1
            works = self.works + phase.works(states, np.diff(places) * self._unit_s, asked)
            for i, work in zip(asked.tolist(), works, strict=True):
                if places[i] % _UNITS == 0:
                    self._kept.append((phase.motion, states[i, : len(phase.state)], work))
            self.works = works[-1]
        self._path, self._places = [states[-1:]], self._places[-1:]

    def settle(self, mode: Mode, y: FloatArray, piece: int, now: float) -> tuple[Mode, FloatArray]:
        """Switch until no guard is below zero."""
        for _ in range(_SWITCHES_AT_ONCE):
            phase = self.phase(mode, piece)
            z = phase.lift(y, now - float(self.inputs.starts_s[piece]))
            margins = (phase.watch[: len(phase.guards)] @ z) / phase.tolerances
            # What has just been switched stands at minus its tolerance.
            if margins.min() >= -2.0:
                return mode, y
            mode, y = self.change(phase, phase.guards[int(np.argmin(margins))], z, now)
        raise SolverError(
            f"the state of the contacts cannot be settled at t = {now:.6g} s",
            code="RF524",
            fix="give the belts some damping, or a smoother drive",
        )

    def change(self, phase: Phase, guard: Guard, z: FloatArray, now: float) -> tuple[Mode, FloatArray]:
        """Return the mode and the state after a guard has fired."""
        if guard.what == "friction":
            self._refresh(phase.motion, phase.read @ z)
            return phase.motion.mode, z[: len(phase.state)].copy()
        self.changes.append((now, guard))
        if len(self.changes) > _MAX_SWITCHES:
            raise SolverError(
                f"contacts and spans changed their state {_MAX_SWITCHES} times before t = {now:.6g} s",
                code="RF524",
                key="start_up.simulate",
                fix="give the belts some damping, or use a shorter time",
            )
        return switched(phase.motion, guard, phase.read @ z)
