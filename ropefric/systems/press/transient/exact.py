"""A start-up with slip and slack: exact steps inside each mode, and a search for the moment at which one ends.

Exact steps of dy/dt = A y + B u(t) with polynomial u, and exact integrals of squares of the solution: a polynomial of
degree r is itself the solution of dp/dt = N p with p_j = τ^j/j!, so one exponential of the joint matrix carries both
over a step of any length: there is no error of discretisation, however stiff A is. Ways and speeds differ by the
frequencies in size; balanced by powers of two, slow motions keep their digits beside fast ones.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.linalg import eigvals, expm, matrix_balance
from scipy.optimize import brentq

from ropefric.arrays import BoolArray, FloatArray
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
    power_forms,
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

    def integrals(self, forms: FloatArray, length_s: float) -> FloatArray:
        """Return the matrices X with zᵀ X z = ∫ wᵀ S w dt over a step that starts at z."""
        generator, weights = self._balanced
        reading = self.read * weights
        doublings = max(
            0, math.ceil(math.log2(max(float(np.linalg.norm(generator, 1)) * length_s, 1e-300))) + 1
        )
        h = length_s / 2.0**doublings
        term = h * (reading.T @ forms @ reading)
        total = term.copy()
        for order in range(2, TAYLOR_TERMS):
            product = term @ generator
            term = (h / order) * (product + product.transpose(0, 2, 1))
            total += term
        flow = np.asarray(expm(h * generator))
        for _ in range(doublings):
            total = total + flow.T @ total @ flow
            flow = flow @ flow
        return np.asarray(total / np.outer(weights, weights))


MOST_STEPS = 500_000
"""Of a start-up; each takes some 50 µs."""


def check_steps(needed: float) -> None:
    """Refuse a start-up of more steps than anybody waits for; return quietly otherwise."""
    if not needed <= MOST_STEPS:
        raise SolverError(
            f"the start-up takes more than {MOST_STEPS} steps, the limit: its fastest oscillation, or the step or"
            " tolerance asked for, is too short for the time simulated",
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
    """Return the guards of a mode: of the drags, and where friction has a limit of slip and slack."""
    model, mode, found = motion.model, motion.mode, []
    force_N = _FORCE_SHARE * float(model.preload_N.max())
    for i in np.flatnonzero(model.drag_N).tolist():
        if turning := mode.turning[i]:
            found.append(Guard(turning * motion.rim_speed_m_s[i], _SPEED_M_S, "hold", i))
            continue
        held_N = model.drag_N[i] * motion.inputs[LOAD]
        found += [Guard(held_N - way * motion.friction_N[i], force_N, "release", i, way) for way in (1, -1)]
    if motion.limit is None:
        return found
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


_STEPS_PER_PERIOD = 24
"""Guards are looked at this often in a period of the fastest oscillation; extremes between are interpolated."""

_FIRST_HALVINGS = 6
"""Of the longest step after a change of mode; more where a motion that only dies does so in less than that."""


class Phase(Propagator):
    """One mode during one piece of the drive, ready to be stepped through and watched."""

    def __init__(self, motion: Motion, taylor: FloatArray, guards: list[Guard]) -> None:
        rows, n = motion.derivative, len(motion.derivative)
        super().__init__(rows[:, :n], rows[:, n:], taylor)
        self.motion, self.guards = motion, guards
        self.tolerances = np.array([guard.tolerance for guard in self.guards])
        # The guards, and below them their rates, as rows over z.
        n_w, n_z = self.read.shape
        rate = np.vstack([rows @ self.read, np.eye(n_z - n, n_z, k=n + 1)])
        watched = np.vstack([np.empty((0, n_w)), *(guard.row for guard in self.guards)]) @ self.read
        self.rate, self.watch = rate, np.vstack([watched, watched @ rate])
        self._flows, self._works = dict[float, FloatArray](), dict[float, FloatArray]()

    @cached_property
    def forms(self) -> FloatArray:
        """Return the powers as symmetric matrices."""
        return power_forms(self.motion)

    @cached_property
    def step_s(self) -> float:
        """Return the longest step at which no oscillation is overlooked [s]; any, where nothing is watched."""
        swinging = self._rates[self._rates.imag != 0.0]
        fastest = float(np.abs(swinging).max(initial=0.0))
        return 2.0 * np.pi / (fastest * _STEPS_PER_PERIOD) if fastest else np.inf

    @cached_property
    def _rates(self) -> npt.NDArray[np.complex128]:
        return np.asarray(eigvals(self.state), np.complex128) if self.guards else np.zeros(0, np.complex128)

    def lengths(self, whole_s: float, since_s: float) -> list[float]:
        """Return steps that cover a time; short ones soon after a change, since fast motions die early."""
        longest, halvings = min(self.step_s, whole_s), 0
        if self.guards:
            dies = float(np.abs(self._rates).max(initial=0.0)) * longest
            halvings = max(_FIRST_HALVINGS, math.ceil(math.log2(max(dies, 1.0))))
            if since_s > 0.0:
                halvings = min(halvings, math.ceil(math.log2(max(longest / since_s, 1.0))))
        first = [longest / 2**k for k in (halvings, *range(halvings, 0, -1))] if halvings else []
        left = whole_s - sum(first)
        check_steps(left / longest)
        count = max(1, int(np.ceil(left / longest)))
        # Rounding makes equal steps differ in their last digits; one matrix serves them all.
        return [*first, *[float(f"{left / count:.11e}")] * count]

    def flow_over(self, length_s: float) -> FloatArray:
        """Return the matrix of z after a step, kept for a length that comes again."""
        if length_s not in self._flows:
            self._flows[length_s] = self.step(length_s)
        return self._flows[length_s]

    def works_over(self, length_s: float) -> FloatArray:
        """Return the matrices of the works during a step, kept as well; they take longer than all else."""
        if length_s not in self._works:
            self._works[length_s] = self.integrals(self.forms, length_s)
        return self._works[length_s]


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
    """A start-up whose drags oppose the motion, and in which belts slip and go slack where friction has a limit.

    Without `drags` the loads are as given whichever way their rollers turn, eqs. (10)-(20): with no limit either the
    press is linear. `follow` gives the limit from the tensions beside the rollers, where it follows them.

    Between two changes of a contact's or span's state the press is linear and is solved by matrix exponentials; the
    guards of the mode are looked at 24 times in a period of its fastest oscillation.
    """

    phase_type = Phase

    def __init__(
        self,
        model: ElasticPress,
        inputs: Inputs,
        limit: FrictionLimit | None,
        *,
        drags: bool = True,
        follow: Callable[[FloatArray], FrictionLimit] | None = None,
    ) -> None:
        self.model, self.inputs, self.limit, self.drags, self.follow = model, inputs, limit, drags, follow
        self.changes: list[tuple[float, Guard]] = []
        self._phases: dict[tuple[Mode, int], Phase] = {}
        self._motions: dict[Mode, Motion] = {}
        self.works = np.zeros(6)
        self._changed_s = 0.0
        self._steps = 0

    def run(self, times_s: FloatArray) -> tuple[list[Motion], FloatArray, FloatArray]:
        """Return motions, states and works at sorted times; the changes of mode are kept beside the guards."""
        mode, y = self.begin()
        check_steps(float(times_s[-1]) / self.phase(mode, 0).step_s)
        starts, wanted = self.inputs.starts_s, set(times_s.tolist())
        motions, states, works = [], [], []
        now = 0.0
        for stop in np.union1d(times_s, starts[starts < times_s[-1]]).tolist():
            if stop > now:
                mode, y = self._advance(mode, y, now, stop)
                now = stop
            if stop in wanted:
                mode, y = self.settle(mode, y, self._piece(now), now)
                motions.append(self.motion(mode))
                states.append(y)
                works.append(self.works)
        return motions, np.array(states), np.array(works)

    def begin(self) -> tuple[Mode, FloatArray]:
        """Return the mode and the state of the machine at rest, its drags holding it."""
        mode = sticking(self.model)
        y = starting_state(self.motion(mode), self.inputs, held=self.drags)
        self._refresh(self.motion(mode), np.concatenate([y, self.inputs.at(0.0)]))
        if self.drags:
            mode = replace(mode, turning=tuple((self.model.drag_N == 0.0).astype(int).tolist()))
        return mode, y

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

    def phase(self, mode: Mode, piece: int) -> Any:
        """Return a mode during a piece of the drive."""
        if (mode, piece) not in self._phases:
            motion = self.motion(mode)
            guards = guards_of(motion) if self.drags else []
            self._phases[mode, piece] = self.phase_type(motion, self.inputs.taylor[piece], guards)
        return self._phases[mode, piece]

    def _piece(self, now: float) -> int:
        return int(np.searchsorted(self.inputs.starts_s, now, side="right")) - 1

    def _advance(self, mode: Mode, y: FloatArray, now: float, stop: float) -> tuple[Mode, FloatArray]:
        piece, n = self._piece(now), len(y)
        start = float(self.inputs.starts_s[piece])
        remaining = stop - now
        if now == start:
            self._changed_s = now
        while remaining > 0.0:
            mode, y = self.settle(mode, y, piece, stop - remaining)
            phase = self.phase(mode, piece)
            z = phase.lift(y, stop - remaining - start)
            for length in phase.lengths(remaining, stop - remaining - self._changed_s):
                ended, passed, z = self._try(phase, z, length)
                remaining -= passed
                if ended is not None:
                    self._changed_s = stop - max(remaining, 0.0)
                    mode, y = self.change(phase, ended, z, self._changed_s)
                    break
            else:
                y, remaining = z[:n], 0.0
        return mode, y

    def _try(self, phase: Phase, z: FloatArray, length: float) -> tuple[Guard | None, float, FloatArray]:
        """Return the guard that ends the mode within a step, or None; the time that passed, and z after it."""
        self._steps += 1
        check_steps(self._steps)
        flow = phase.flow_over(length)

        def along(tau: float) -> FloatArray:
            return phase.step(tau) @ z

        fired, passed = first_dip(phase, along, z, flow @ z, length)
        guard = None
        if fired.any():
            guard, passed = first_to_fall(phase, along, fired, passed)
            if passed == 0.0:
                return guard, passed, z
            flow, integrals = phase.step(passed), phase.integrals(phase.forms, passed)
        else:
            integrals = phase.works_over(length)
        strained = z.copy()
        strained[: len(self._unmoved)] = self._unmoved @ z[: len(self._unmoved)]
        self.works = self.works + (integrals @ strained) @ strained
        return guard, passed, flow @ z

    @cached_property
    def _unmoved(self) -> FloatArray:
        """Return the projection that removes motions without strain: of turned rims and slipped belts.

        Squares of these times stiffnesses, which cancel, would drown the works in their rounding.
        """
        motion = self.motion(sticking(self.model))
        n_q = motion.n_coordinates
        strains = np.vstack([motion.spring_N / self.model.stiffness_N_m[:, np.newaxis], motion.travel_m])[
            :, :n_q
        ]
        return np.asarray(np.linalg.pinv(strains) @ strains)

    def settle(self, mode: Mode, y: FloatArray, piece: int, now: float) -> tuple[Mode, FloatArray]:
        """Switch until no guard is below zero."""
        for _ in range(_SWITCHES_AT_ONCE):
            phase = self.phase(mode, piece)
            if not phase.guards:
                return mode, y
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
