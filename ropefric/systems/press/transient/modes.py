"""A start-up in closed form: a path on which nothing swings, and the modes that swing about it, each with its worth.

While belts stick and drags oppose the motion, dy/dt = A y + B u with u a polynomial on each piece of the drive. So is
one solution, y = Σ a_k τ^k/k! with A a_k = a_(k+1) − B u_k: the press that follows its drive as if it always had. What
is left are swings, Σ_j V_j b_j e^(λ_j τ), which the start and the corners of the drive excite. Where those of a mode
are left out, it follows as if at rest, and a force r y is off by Σ_j |r V_j b_j| e^(Re λ_j τ) at most.

A drag is a wrong force, by up to twice what it is, as long as the rim turns backward with all swings in. Springs,
dampers and drags that oppose each its motion give no energy to the difference of two: with v of the one that is wrong,
the other has −(drag' − drag) (v' − v) ≤ 2 drag |v| where v' ≤ 0, and none elsewhere. So E ≤ ∫ 2 drag |v| dt.
"""

import math
from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev

from ropefric.arrays import BoolArray, FloatArray
from ropefric.systems.press.slip import LEAST_SLACK_N
from ropefric.systems.press.transient.drives import LOAD, SPEED, Inputs
from ropefric.systems.press.transient.exact import lowest_between
from ropefric.systems.press.transient.motion import (
    ElasticPress,
    FrictionLimit,
    Motion,
    kinetic_energy_J,
    power_rows,
    powers_W,
    starting_state,
    sticking,
)

_CLEAR = 0.01
"""Of its friction: a roller that has so much left, whatever may swing, does not slip."""
_BETWEEN = 0.005
"""Of its range: how far a polynomial may go beyond its values at the places looked at."""
_MORE = 1.05
"""What bounds are raised by, for what lies between the places looked at."""
_HALVINGS = 24
_STEPS_PER_RADIAN = 24.0 / math.tau
_MOST_STEPS = 500
_MOST_PIECES = 50
_DECAYED = 16.0
_RADIANS, _MORE_ORDERS, _MOST_PANELS = 6.0, 14, 1_000
_RESOLVED = 1e-8


Following: TypeAlias = tuple[Callable[[FloatArray], FloatArray], Callable[[FloatArray], FrictionLimit]]
"""M, and the limit of slip, at slack sides of the rollers, where friction follows the tensions."""


class _Forces(NamedTuple):
    """Of spans T_0 + k e, T and T'; of rollers F, m b'' and the rim's speed: at n places, or what they are off by."""

    spring_N: FloatArray
    tension_N: FloatArray
    pressing_N: FloatArray
    friction_N: FloatArray
    arc_N: FloatArray
    rim_m_s: FloatArray


class SwingingStartUp:
    """A start-up whose belts stick, with its modes in the order of their speed, the slowest first.

    `bound` is for those whose belts do stick; friction may be `following` the tensions.
    """

    def __init__(
        self,
        model: ElasticPress,
        inputs: Inputs,
        limit: FrictionLimit,
        end_s: float,
        *,
        slips: bool,
        following: Following | None = None,
    ) -> None:
        self.model, self.limit, self._following = model, limit, following
        self.motion = Motion(model, sticking(model))
        held, free = (starting_state(self.motion, inputs, held=one) for one in (True, False))
        # Drags that hold rollers before belts pull at them begin with another state than loads that drag all along.
        self.sticks = np.array_equal(held, free) and len(inputs.starts_s) <= _MOST_PIECES
        if not self.sticks:
            return
        self._n = n = len(self.motion.derivative)
        state, drive = np.split(self.motion.derivative, [n], axis=1)
        rates, vectors = np.linalg.eig(state)
        order = np.argsort(np.abs(rates), kind="stable")  # two conjugates stay side by side
        self.rates, self._vectors = rates[order], vectors[:, order]
        self._mode = np.cumsum(self.rates.imag >= 0.0) - 1
        self.n_modes = int(self._mode[-1]) + 1
        self.every, self._power_rows = np.ones(self.n_modes, dtype=np.bool_), power_rows(self.motion)
        inverse = np.linalg.inv(self._vectors)
        off = np.abs((self._vectors * self.rates) @ inverse - state).max(axis=1)
        self.sticks = bool((off <= _RESOLVED * np.abs(state).max(axis=1)).all())
        if not self.sticks:
            return
        self._starts_s = inputs.starts_s[inputs.starts_s < end_s]
        self._lengths_s = np.diff(np.append(self._starts_s, end_s))
        # w = (y, u) on the path by its Taylor coefficients, and how the modes begin to swing, on each piece.
        self._paths, self._swings, y = [], [], free
        for taylor, length_s in zip(inputs.taylor, self._lengths_s, strict=False):
            path = np.vstack([_path(state, drive, taylor), taylor])
            self._paths.append(path)
            self._swings.append(inverse @ (y - path[:n, 0]))
            y = path[:n] @ _powers(length_s, path.shape[1])
            y = y + (self._vectors @ (np.exp(self.rates * length_s) * self._swings[-1])).real
        self._look()
        self.sticks = not slips or self._holds()

    def _look(self) -> None:
        """Look at the path, and how far modes may swing from it, at places so near that little lies between."""
        motion, n = self.motion, self._n
        arc_N = self.model.arc_mass_kg[:, np.newaxis] * motion.belt_acceleration_m_s2
        parts = (motion.spring_N, motion.unclipped_N, motion.pressing_N, motion.friction_N, arc_N)
        rows = np.vstack([*parts, motion.rim_speed_m_s])
        self._ends = np.cumsum([len(one) for one in parts])
        pieces = list(zip(self._paths, self._swings, self._lengths_s, strict=True))
        self._reach = [np.abs(rows[:, :n] @ self._vectors) * np.abs(swing) for _, swing, _ in pieces]
        self._tau_s = [_places(path.shape[1] - 1) * length_s for path, _, length_s in pieces]
        self._w = [
            (path @ _powers(tau_s, path.shape[1])).T
            for path, tau_s in zip(self._paths, self._tau_s, strict=True)
        ]
        values = [w @ rows.T for w in self._w]
        self._values = _Forces(*np.split(np.vstack(values), self._ends, axis=1))
        between = [np.broadcast_to(_BETWEEN * np.ptp(one, axis=0), one.shape) for one in values]
        self._between = _Forces(*np.split(np.vstack(between), self._ends, axis=1))
        self._find_late_drags()
        self._others = self._shares_of_others()
        self._use = self._uses()[1]
        powers = [powers_W(self._power_rows, w)[:, 0] for w in self._w]
        done_J = sum(np.trapezoid(one, tau_s) for one, tau_s in zip(powers, self._tau_s, strict=True))
        start, end = kinetic_energy_J(self.motion, np.stack([self._w[0][0], self._w[-1][-1]]))
        self._certain_J = max(abs(float(done_J)), abs(float(end - start)))

    def _swinging(self, modes: BoolArray) -> _Forces:
        """Return how far some modes move each force and speed at most."""
        chosen = modes[self._mode]
        decays = [np.exp(np.outer(tau_s, self.rates.real[chosen])) for tau_s in self._tau_s]
        most = [decay @ reach[:, chosen].T for decay, reach in zip(decays, self._reach, strict=True)]
        return _Forces(*np.split(np.vstack(most), self._ends, axis=1))

    def _find_late_drags(self) -> None:
        """Find √(2E) of what drags do where rims turn backward, with all swings [√J], and which of them may."""
        mass_kg, drag_N = self.model.roller_mass_kg + self.model.arc_mass_kg, self.model.drag_N
        energy_J, lows, loads = 0.0, [], []
        for piece, places_s in enumerate(self._tau_s):
            tau_s = places_s
            low, load = self._lowest_speeds(piece, tau_s, np.zeros_like(self.rates, dtype=np.bool_))
            unsure = np.flatnonzero((low <= 0.0).any(axis=1))
            if unsure.size:
                # Where swings may turn a rim back those are looked at themselves that take few steps.
                first, last = tau_s[unsure[0]], tau_s[unsure[-1] + 1]
                tau_s = np.union1d(tau_s, np.linspace(first, last, _MOST_STEPS))
                slow = np.abs(self.rates) * (last - first) <= _MOST_STEPS / _STEPS_PER_RADIAN
                low, load = self._lowest_speeds(piece, tau_s, slow)
            energy_J += float((2.0 * load * drag_N * np.maximum(-low, 0.0)).sum(axis=1) @ np.diff(tau_s))
            lows.append(low)
            loads.append(load)
        self.late = math.sqrt(2.0 * energy_J)
        may_turn = np.vstack(lows) <= self.late / np.sqrt(mass_kg)
        self._backward = (may_turn * np.vstack(loads)).max(axis=0)
        self._ends_forward = bool((~may_turn[-1])[drag_N > 0.0].all())

    def _lowest_speeds(
        self, piece: int, tau_s: FloatArray, swings: BoolArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return how slow rims may be from one time to the next, and the loads' factor; some swings are looked at."""
        path, rows = self._paths[piece], self.motion.rim_speed_m_s
        speeds, slopes = ((rows @ one @ _powers(tau_s, one.shape[1])).T for one in (path, path[:, 1:]))
        moving = (rows[:, : self._n] @ self._vectors) * self._swings[piece]
        turning = np.exp(np.outer(tau_s, self.rates[swings]))
        speeds += (turning @ moving[:, swings].T).real
        slopes += (turning @ (moving * self.rates)[:, swings].T).real
        step_s, first, last = np.diff(tau_s)[:, np.newaxis], speeds[:-1], speeds[1:]
        falling, rising = slopes[:-1] * step_s, slopes[1:] * step_s
        turns = (falling < 0.0) & (rising > 0.0)
        low = np.minimum(first, last)
        low[turns] = lowest_between(first[turns], last[turns], falling[turns], rising[turns])[1]
        low -= np.exp(np.outer(tau_s[:-1], self.rates.real[~swings])) @ np.abs(moving[:, ~swings]).T
        load = np.abs(path[self._n + LOAD] @ _powers(tau_s, path.shape[1]))
        return low, np.maximum(load[:-1], load[1:])[:, np.newaxis] + _BETWEEN * np.ptp(load)

    def _off(self, modes: BoolArray) -> _Forces:
        """Return what forces are off by at most, at all places, where the swings of some modes are left out."""
        model, off = self.model, self._swinging(modes)
        mass_kg = model.roller_mass_kg + model.arc_mass_kg
        tension_N = self.late * model.tension_per_root_energy
        net_N = np.abs(model.press.incidence) @ tension_N
        drag_N = 2.0 * self._backward * model.drag_N
        arc = model.arc_mass_kg / mass_kg * model.press.is_driven
        late = (tension_N, tension_N, tension_N, (1.0 - arc) * net_N + arc * drag_N, arc * (net_N + drag_N))
        return _Forces(*map(np.add, off, (*late, self.late / np.sqrt(mass_kg))))

    def _sides(self, forces: _Forces) -> FloatArray:
        """Return T' on the slack sides of slip forward and backward, shape (2, n, n_rollers)."""
        press = self.model.press
        return np.stack([forces.pressing_N @ beside.T for beside in (press.into, press.out_of)])

    def _shares_of_others(self) -> FloatArray:
        """Return the least and largest 1/κ − 1 of slip forward and backward, shape (2, 2, n_rollers)."""
        own = np.broadcast_to(1.0 / self.limit.share - 1.0, (2, len(self.limit.share)))
        if self._following is None:
            return np.stack([own, own])
        slack_N, off_N = self._sides(self._values), self._sides(self._off(self.every))
        ends = ((slack_N - off_N).min(axis=1), (slack_N + off_N).max(axis=1))
        found = [own, *(1.0 / self._following[1](end_N).share - 1.0 for end_N in ends)]
        return np.stack([np.min(found, axis=0), np.max(found, axis=0)])

    def _uses(self, off: _Forces | None = None) -> tuple[FloatArray, FloatArray]:
        """Return the least and the most that the rollers may use of their friction, shape (n, n_rollers).

        Where nothing is off both are U = |F| / (T'_slack (e^M − 1) ± m b'' (1/κ − 1)).
        """
        values, others = self._values, self._others
        if off is None:
            off, others = _Forces(*map(np.zeros_like, values)), others[:1]
        slack_N, off_N = self._sides(values), self._sides(off)
        slack_N = np.stack([slack_N - off_N, slack_N + off_N])
        grip = np.broadcast_to(self.limit.growth - 1.0, slack_N.shape)
        if self._following is not None:
            grip = np.sort(np.expm1(self._following[0](np.maximum(slack_N, LEAST_SLACK_N))), axis=0)
        ways = np.array([1.0, -1.0])[:, np.newaxis, np.newaxis]
        pull_N, push_N = ways * values.friction_N, ways * values.arc_N
        more = others[:, :, np.newaxis]
        least_N = slack_N[0] * grip[0] + ((push_N - off.arc_N) * more).min(axis=0)
        most_N = slack_N[1] * grip[1] + ((push_N + off.arc_N) * more).max(axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            highest, lowest = (pull_N + off.friction_N) / least_N, (pull_N - off.friction_N) / most_N
        highest = np.where(pull_N + off.friction_N > 0.0, np.where(least_N > 0.0, highest, np.inf), 0.0)
        return np.maximum(lowest, 0.0).max(axis=0), highest.max(axis=0)

    def _holds(self) -> bool:
        """Return whether no belt slips or goes slack, whatever swings, and the rims turn forward at the end."""
        off = _Forces(*map(np.add, self._off(self.every), self._between))
        taut = all(bool((self._values[i] > off[i]).all()) for i in (0, 2))
        return taut and self._ends_forward and bool((self._uses(off)[1] <= 1.0 - _CLEAR).all())

    def bound(self, modes: BoolArray) -> float:
        """Return how far the numbers of the start-up are off at most, where the swings of some modes are left out."""
        if not self.sticks:
            return math.inf
        off = self._off(modes)
        peak_N, off_N = self._values.tension_N.max(axis=0), off.tension_N.max(axis=0)
        use, (least, most) = self._use, self._uses(off)
        with np.errstate(invalid="ignore"):
            apart = np.maximum(use - least, most - use).max(axis=0)
        if not ((off_N < peak_N).all() and np.isfinite(apart).all()):
            return math.inf
        shares = (
            float((off_N / (peak_N - off_N)).max()),
            float((apart / np.maximum(1.0, use.max(axis=0) - apart)).max()),
            self._share_of_work(modes, off),
        )
        return _MORE * max(shares)

    def _share_of_work(self, modes: BoolArray, off: _Forces) -> float:
        """Return how far the drives' work is off at most, of the greatest energy that is certain.

        A swing e^(λτ) does no more work on a speed v than ∫|v| dτ, and than (|v_0| + |v_1| + ∫|dv|)/|λ|.
        """
        model, chosen = self.model, modes[self._mode]
        drivers, ahead = model.drivers, 1.0 + float(model.overspeed.max(initial=0.0))
        late_N = float((off.friction_N - self._swinging(modes).friction_N)[0, drivers].sum())
        off_J, pulls = 0.0, self._ends[2] + drivers
        for w, tau_s, reach in zip(self._w, self._tau_s, self._reach, strict=True):
            speed_m_s = ahead * w[:, self._n + SPEED]
            way_m = float(np.abs(speed_m_s).max() * tau_s[-1])
            varies = float(np.abs(speed_m_s[[0, -1]]).sum() + np.abs(np.diff(speed_m_s)).sum())
            pull_N = reach[pulls].sum(axis=0)[chosen]
            swing_J = pull_N @ np.minimum(way_m, varies / np.abs(self.rates[chosen]))
            off_J += float(swing_J) + late_N * way_m
        certain_J = self._certain_J - off_J
        return off_J / certain_J if certain_J > 0.0 else math.inf

    def slowest(self, count: int) -> BoolArray:
        """Return which modes are the slowest so many."""
        return np.arange(self.n_modes) < count

    def fewest(self, room: float) -> int:
        """Return how few of the slowest modes are enough, where all faster ones may move any tension by that share."""
        faster = np.cumsum(self._shares_of_tension.max(axis=0)[::-1])[::-1]
        return int((faster > room).sum())

    def rigid_belts(self, room: float) -> tuple[str, ...]:
        """Return the belts in whose spans no swing moves the tension by more than that share."""
        press, swing = self.model.press, self._shares_of_tension.sum(axis=1) > room
        return tuple(
            belt.name
            for belt, on in zip(press.belts, press.carried > 0.0, strict=True)
            if not swing[on].any()
        )

    @cached_property
    def _shares_of_tension(self) -> FloatArray:
        """Return what each mode moves the tension of each span by at most, over its peak, (n_spans, n_modes)."""
        pulls, peak_N = slice(self._ends[0], self._ends[1]), self._values.tension_N.max(axis=0)
        first = np.flatnonzero(np.diff(self._mode, prepend=-1))
        moved_N = np.max([np.add.reduceat(reach[pulls], first, axis=1) for reach in self._reach], axis=0)
        return np.asarray(moved_N / peak_N[:, np.newaxis])

    def run(self, times_s: FloatArray, modes: BoolArray) -> tuple[FloatArray, FloatArray] | None:
        """Return states and works at sorted times with the swings of these modes; None where that takes very long."""
        chosen, n, rows = modes[self._mode], self._n, self._power_rows
        rates, vectors = self.rates[chosen], self._vectors[:, chosen]
        edges = [_edges(rates, float(length_s)) for length_s in self._lengths_s]
        if sum(map(len, edges)) > _MOST_PANELS:
            return None
        states, works, done_J = np.zeros((len(times_s), n)), np.zeros((len(times_s), 6)), np.zeros(6)
        which = np.searchsorted(self._starts_s, times_s, side="right") - 1
        for piece, (path, edges_s) in enumerate(zip(self._paths, edges, strict=True)):
            begins, powers = self._swings[piece][chosen], path.shape[1]

            def at(tau_s: FloatArray, path: FloatArray = path, begins: FloatArray = begins) -> FloatArray:
                w = (path @ _powers(tau_s, path.shape[1])).T
                w[:, :n] += ((begins * np.exp(np.outer(tau_s, rates))) @ vectors.T).real
                return np.asarray(w)

            half_s, middles_s = 0.5 * np.diff(edges_s), 0.5 * (edges_s[1:] + edges_s[:-1])
            order = 2 * powers + _MORE_ORDERS * bool(len(rates))
            nodes = chebyshev.chebpts1(order)
            found = powers_W(rows, at((middles_s[:, np.newaxis] + np.outer(half_s, nodes)).ravel()))
            series = 2.0 / order * chebyshev.chebvander(nodes, order - 1).T
            series[0] *= 0.5
            whole = chebyshev.chebint(series, lbnd=-1.0) @ found.reshape(-1, order, 6)
            whole *= half_s[:, np.newaxis, np.newaxis]
            before = np.cumsum(np.vstack([done_J, whole.sum(axis=1)]), axis=0)
            here = which == piece
            tau_s = times_s[here] - self._starts_s[piece]
            panel = np.clip(np.searchsorted(edges_s, tau_s, side="right") - 1, 0, len(half_s) - 1)
            shapes = chebyshev.chebvander((tau_s - middles_s[panel]) / half_s[panel], order)
            states[here] = at(tau_s)[:, :n]
            works[here] = before[panel] + np.einsum("ij,ijk->ik", shapes, whole[panel])
            done_J = before[-1]
        return states, works


def _edges(rates: npt.NDArray[np.complex128], length_s: float) -> FloatArray:
    """Return the ends of panels of a piece in which no swing that has not died turns by more than some radians."""
    dies_s = np.minimum(_DECAYED / np.maximum(-rates.real, _DECAYED / length_s), length_s)
    found = [np.zeros(1)]
    for end_s in np.unique(np.append(dies_s, length_s)).tolist():
        begin_s, fastest = float(found[-1][-1]), float(np.abs(rates[dies_s >= end_s]).max(initial=0.0))
        count = min(math.ceil((end_s - begin_s) * fastest / _RADIANS), _MOST_PANELS) or 1
        found.append(np.linspace(begin_s, end_s, count + 1)[1:])
    return np.concatenate(found)


def _path(state: FloatArray, drive: FloatArray, taylor: FloatArray) -> FloatArray:
    """Return the Taylor coefficients of the solution that is a polynomial as the inputs are."""
    forced, found = drive @ taylor, np.zeros((len(state), taylor.shape[1] + 1))
    for order in reversed(range(taylor.shape[1])):
        found[:, order] = np.linalg.solve(state, found[:, order + 1] - forced[:, order])
    return found[:, :-1]


def _powers(tau_s: FloatArray | float, count: int) -> FloatArray:
    """Return τ^k/k!, shape (count, ...)."""
    tau = np.asarray(tau_s, dtype=np.float64)
    orders = np.arange(1, count).reshape(-1, *(1,) * tau.ndim)
    return np.cumprod(np.concatenate([np.ones((1, *tau.shape)), tau / orders]), axis=0)


def _places(degree: int) -> FloatArray:
    """Return shares of a piece: even ones, between which a polynomial goes no further, and many at the start.

    Between two that are h apart it goes beyond its ends by h²/8 |p''| at most, and by Markov |p''| is no more than
    d² (d² − 1)/3 times twice its range.
    """
    count = 2 + math.ceil(degree * math.sqrt(max(degree**2 - 1, 0) / (12.0 * _BETWEEN)))
    return np.union1d(np.linspace(0.0, 1.0, count), 0.5 ** np.arange(1.0, _HALVINGS))
