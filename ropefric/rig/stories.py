"""Recordings drawn piece by piece with known truth: no equation of motion, so that nothing of the two rigs is in them.

A recording is a sequence: a rest, weights that are hung, disturbances, a climb with its partial slips, the slip and
the sliding after it, an end. Each piece is a shape of the force over its time with the state of the rope; a sensor makes
samples of it. Force is in units of the break-away, time in seconds; everything is drawn over ranges far wider than any
one bench has, so that a picker learns the break-away and not the habits of one machine.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import nan

import numpy as np

from ropefric.arrays import FloatArray, IntArray, frozen_array
from ropefric.rig.sampling import (
    DAMAGED,
    Rng,
    coloured,
    damaged_state,
    kept,
    maybe,
    sampled,
    seen_top,
    spoil,
    spread,
    visible_fall,
)
from ropefric.traces.breakaway import Status
from ropefric.traces.picker import State

Shape = Callable[[FloatArray], FloatArray]
"""Force over the part of a piece's time that has passed, 0 to 1."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LabelledRecording:
    """A recording and its truth.

    Attributes
    ----------
    kind : str
        What was drawn, a name of `KINDS`.
    time_s, force_N : ndarray, shape (n,)
        The samples.
    state : ndarray of int, shape (n,)
        The `State` at each sample.
    status : Status
        `ok` where the break-away can be seen, `doubtful` where the file is damaged, else why it can't.
    breakaway_s, peak_N : float
        When the force was highest as it broke away, as the sensor shows it, and F_A without noise or zero error; NaN
        where there is none.
    zero_N : float
        What the sensor shows without force.
    """

    kind: str
    time_s: FloatArray
    force_N: FloatArray
    state: IntArray
    status: Status
    breakaway_s: float = nan
    peak_N: float = nan
    zero_N: float = 0.0

    def __post_init__(self) -> None:
        for key in ("time_s", "force_N"):
            object.__setattr__(self, key, frozen_array(getattr(self, key)))
        self.state.setflags(write=False)


class _Story:
    """A force as it is put together, and when it broke away."""

    def __init__(self, rng: Rng, climb_s: float) -> None:
        self.rng, self.climb_s = rng, climb_s
        self._keep(np.zeros(1), np.zeros(1), np.zeros(1, int))
        self.now_s = self.level = 0.0
        self.broke_s = nan
        self.peak = nan

    def _keep(self, time_s: FloatArray, force: FloatArray, state: IntArray) -> None:
        self._time_s, self._force, self._state = [time_s], [force], [state]

    def piece(self, state: State, lasting_s: float, shape: Shape) -> None:
        """Go on along a shape."""
        knots = int(np.clip(300 * lasting_s / self.climb_s, 6, 600))
        part = np.arange(1, knots + 1) / knots
        self._time_s.append(self.now_s + lasting_s * part)
        self._force.append(np.broadcast_to(shape(part), part.shape).astype(float))
        self._state.append(np.full(knots, int(state)))
        self.now_s += lasting_s
        self.level = float(self._force[-1][-1])

    def stay(self, state: State, lasting_s: float, creep: float = 0.0) -> None:
        """Stay at a level, or lose a part of it to creep, which slows down."""
        level, quick = self.level, self.rng.choice((1.0, 10.0, 100.0))
        self.piece(
            state, lasting_s, lambda part: level * (1.0 - creep * np.log1p(quick * part) / np.log1p(quick))
        )

    def line(self, state: State, lasting_s: float, to: float) -> None:
        """Go straight to a level."""
        begin = self.level
        self.piece(state, lasting_s, lambda part: begin + (to - begin) * part)

    def rough(self, lasting_s: float, size: float, rise: float = 0.0) -> None:
        """Slide over what differs along the wheel, while the level rises by a part of itself."""
        begin, knots = self.level, int(np.clip(300 * lasting_s / self.climb_s, 6, 600))
        wave = coloured(self.rng, knots, spread(self.rng, 2.0, 100.0), self.rng.uniform(0.4, 1.0))
        wave = size * begin * (wave - wave[0] * np.exp(-20.0 * np.arange(knots) / knots))
        bend = self.rng.uniform(0.5, 1.0)
        self.piece(
            State.SLIDING, lasting_s, lambda part: begin * (1.0 + rise * part**bend) + wave[: part.size]
        )

    def begin_again(self, level: float) -> None:
        """Forget all that was, as a logger does that starts only now."""
        self._keep(np.zeros(1), np.full(1, level), np.full(1, int(State.SLIDING)))
        self.now_s, self.level, self.broke_s, self.peak = 0.0, level, nan, nan

    def start_late(self, part: float) -> None:
        """Forget what was before the force first came to a part of the break-away, as a logger with a trigger does."""
        time_s, force, state = self.knots()
        first = int(np.argmax(force >= part))
        if first > 0 and not time_s[first] >= self.broke_s:
            self._keep(time_s[first:] - time_s[first], force[first:], state[first:])
            self.now_s, self.broke_s = self.now_s - time_s[first], self.broke_s - time_s[first]

    def stop_at(self, knot: int) -> None:
        """Forget what comes after a knot, as a logger does that stops there."""
        time_s, force, state = self.knots()
        self._keep(time_s[: knot + 1], force[: knot + 1], state[: knot + 1])
        self.now_s, self.level, self.broke_s, self.peak = float(time_s[knot]), float(force[knot]), nan, nan

    def knots(self) -> tuple[FloatArray, FloatArray, IntArray]:
        """Return times, forces and states."""
        return np.concatenate(self._time_s), np.concatenate(self._force), np.concatenate(self._state)


def _fall(story: _Story, to: float, lasting_s: float, state: State) -> None:
    """Fall: straight, softly at both ends, as a mass on a spring rings, or ever more slowly."""
    rng, begin = story.rng, story.level
    depth, kind = begin - to, rng.integers(4)
    if kind == 0:
        story.line(state, lasting_s, to)
    elif kind == 1:
        story.piece(state, lasting_s, lambda part: to + depth * 0.5 * (1.0 + np.cos(np.pi * part)))
    elif kind == 2:
        turns, damping = rng.uniform(3.0, 12.0) * np.pi, rng.uniform(0.05, 0.5)
        ringing = lambda part: to + depth * np.exp(-damping * turns * part) * np.cos(turns * part)  # noqa: E731
        story.piece(state, 4.0 * lasting_s, ringing)
    else:
        story.piece(
            state, 3.0 * lasting_s, lambda part: to + depth * (np.exp(-4.0 * part) - np.exp(-4.0) * part)
        )


def _rest(story: _Story) -> None:
    """Begin with a long or very short rest, with or without weights that hang already."""
    rng = story.rng
    if maybe(rng, 0.2):
        story.level = rng.uniform(0.01, 0.95 if maybe(rng, 0.3) else 0.5)
    lasting_s = (
        min(spread(rng, 0.02, 6.0), 40.0 * story.climb_s) if maybe(rng, 0.72) else 0.02 * story.climb_s
    )
    story.stay(State.REST, lasting_s)


def _hang_weights(story: _Story) -> None:
    """Hang one to three weights, each of which may swing."""
    rng = story.rng
    whole, n = (
        (rng.uniform(0.02, 0.7) if maybe(rng, 0.7) else rng.uniform(0.7, 0.96)),
        int(rng.integers(1, 4)),
    )
    for number in range(n):
        begin, end = story.level, max(story.level, whole * (number + 1) / n)
        comes = lambda part: begin + (end - begin) * part**2 * (3.0 - 2.0 * part)  # noqa: B023, E731
        story.piece(State.HUNG, spread(rng, 0.02, 0.4), comes)
        if maybe(rng, 0.5):
            size, turns = (end - begin) * rng.uniform(0.02, 0.5), rng.uniform(2, 9) * np.pi
            damping = spread(rng, 0.05, 1.0)
            story.piece(
                State.HUNG, spread(rng, 0.2, 2.0),
                lambda part: end + size * np.exp(-damping * turns * part) * np.sin(turns * part),  # noqa: B023
            )  # fmt: skip
        story.level = end
        story.stay(State.HUNG, spread(rng, 0.05, 1.0))


def _disturb(story: _Story) -> None:
    """Let the rope catch and come free, hit the rig, or jog the motor forth and back."""
    rng, level = story.rng, story.level
    lasting_s = spread(rng, 0.004, 1.0)
    # What is pulled slowly, higher than the pull itself, and lets go would be a break-away of its own.
    size = rng.uniform(0.03, 1.15 if lasting_s < 0.1 * story.climb_s else 0.8)
    kind = rng.integers(3)
    if kind == 0:
        story.piece(State.DISTURBED, lasting_s, lambda part: level + size * np.sin(np.pi * part))
    elif kind == 1:
        story.line(State.DISTURBED, lasting_s, level + size)
        _fall(story, level, lasting_s * spread(rng, 0.02, 1.0), State.DISTURBED)
    else:
        for top in (level + 0.7 * size, level):
            story.line(State.DISTURBED, 2.0 * lasting_s, top)
            story.stay(State.DISTURBED, lasting_s * rng.random())
    story.level = level
    story.stay(State.REST, spread(rng, 0.05, 1.0))


@dataclass(frozen=True, slots=True)
class _Climb:
    """How a machine loads: its rate, how softly it starts, how the force bends before the top, what slips on the way."""

    rate: float
    soft: float
    bend: float
    slips: tuple[tuple[float, float], ...] = ()
    rest_s: float = 0.0
    ripple: float = 0.0


def _draw_climb(rng: Rng, story: _Story) -> _Climb:
    slips: list[tuple[float, float]] = []
    room = 1.0 - story.level
    if maybe(rng, 0.35):
        n, most = (1 if maybe(rng, 0.5) else int(rng.integers(2, 12))), spread(rng, 0.01, 0.45)
        parts = np.sort(rng.uniform(0.2, 0.97, n))
        # Near the top a large slip and a small rise after it would be the break-away itself.
        drops = np.minimum(most * rng.uniform(0.1, 1.0, n), 2.0 * (1.0 - parts) + 0.02) * parts
        slips = [
            (story.level + room * part, room * drop)
            for part, drop in zip(parts.tolist(), drops.tolist(), strict=True)
        ]
    # A blow on the way is a negative slip, as it goes up.
    for _ in range(int(rng.integers(1, 4)) if maybe(rng, 0.08) else 0):
        slips.append((story.level + room * rng.uniform(0.1, 0.95), -rng.uniform(0.1, 1.5)))
    slips.sort()
    return _Climb(
        rate=1.0 / story.climb_s,
        soft=rng.choice((0.0, rng.uniform(0.0, 1.5))),
        bend=rng.choice((0.0, 0.0, rng.uniform(0.0, 0.15), rng.uniform(0.1, 1.0))),
        slips=tuple(slips),
        rest_s=spread(rng, 0.1, 2.0) if maybe(rng, 0.08) else 0.0,
        ripple=spread(rng, 1e-3, 2e-2) if maybe(rng, 0.1) else 0.0,
    )


def _climb(story: _Story, top: float, how: _Climb) -> None:
    """Load up to a top, with partial slips on the way, after which the machine loads on at its rate."""
    rng, begin, soft = story.rng, story.level, how.soft
    goals = [(level, drop) for level, drop in how.slips if begin + 0.02 * (top - begin) < level < top]
    for level, drop in [*goals, (top, 0.0)]:
        start, rise = story.level, level - story.level
        if rise <= 0.0:
            continue
        bend = how.bend if level == top else 0.0
        lasting_s = rise / how.rate * (1.0 + soft) * (1.0 + bend)
        turns = 2.0 * np.pi * max(1.0, round(rng.uniform(3.0, 30.0)))
        ripple = how.ripple * rise

        def shape(part: FloatArray) -> FloatArray:
            way = part ** (1.0 + soft)  # noqa: B023
            bent = 1.0 - (1.0 - way) ** (1.0 + 6.0 * bend) if bend > 0.02 else way  # noqa: B023
            return start + rise * bent + ripple * np.sin(turns * part) * (1.0 - part)  # noqa: B023

        story.piece(State.LOADING, lasting_s, shape)
        soft = 0.0
        if drop < 0.0:
            blow = lambda part: level - drop * np.sin(np.pi * part)  # noqa: B023, E731
            story.piece(State.DISTURBED, spread(rng, 0.005, 0.05) * min(1.0, (top - begin) / how.rate), blow)
            story.level = level
        elif level != top:
            quick_s = spread(rng, 0.0005, 0.05) * min(1.0, (top - begin) / how.rate)
            _fall(story, level - drop, quick_s, State.PARTIAL_SLIP)
            if how.rest_s and maybe(rng, 0.5):
                story.stay(State.HELD, how.rest_s, rng.uniform(0.0, 0.02))


def _climb_by_weights(story: _Story) -> None:
    """Hang weights one by one until the last one makes the rope slip, while it is still going down."""
    rng = story.rng
    steps = np.cumsum(rng.uniform(0.5, 1.5, int(rng.integers(3, 12))))
    begin, levels = story.level, story.level + (1.0 - story.level) * steps / steps[-1]
    lasting_s = story.climb_s / levels.size
    swings, turns, damping = rng.uniform(0.0, 0.4), rng.uniform(2.0, 8.0) * np.pi, rng.uniform(0.1, 0.4)
    for level in levels[:-1]:
        height = level - begin
        if maybe(rng, 0.7):

            def comes(part: FloatArray) -> FloatArray:
                swing = np.exp(-damping * turns * part) * np.cos(turns * part)
                left = swings * swing + (1.0 - swings) * np.exp(-8.0 * part)
                return np.asarray(level - height * left)  # noqa: B023  (used at once)

            story.piece(State.HUNG, lasting_s * rng.uniform(0.4, 1.6), comes)
        else:
            story.line(State.HUNG, lasting_s * rng.uniform(0.05, 0.5), level)
            story.stay(State.HUNG, lasting_s * rng.uniform(0.4, 1.6))
        begin = story.level
    story.line(State.LOADING, lasting_s * spread(rng, 0.03, 1.0), 1.0)


def _break_away(story: _Story, how: _Climb) -> None:
    """Break away from where the climb has come to, and slide on smoothly, roughly or in teeth."""
    rng = story.rng
    story.broke_s, story.peak = story.now_s, story.level
    quick, is_train = maybe(rng, 0.7), maybe(rng, 0.5)
    drop = rng.uniform(0.65, 0.98) if is_train and maybe(rng, 0.15) else spread(rng, 0.015, 0.65)
    roughness = rng.choice((0.0, spread(rng, 1e-3, 0.03)))
    if not (quick or is_train or roughness):
        drop = max(
            drop, 0.06
        )  # a smaller fall that is slow and quiet is that of a rope that is held and creeps
    kinetic = story.level * (1.0 - drop)
    fall_s = (
        spread(rng, 5e-4, 3.0) * min(1.0, story.climb_s) if quick else story.climb_s * spread(rng, 0.05, 1.5)
    )
    if maybe(rng, 0.15):
        story.stay(State.SLIP, 0.1 * fall_s)
    if is_train:
        _fall(story, kinetic, min(fall_s, 0.15 * drop * story.climb_s + 0.02), State.SLIP)
        height, bottom = drop * story.peak * rng.uniform(0.4, 1.15), kinetic
        if maybe(rng, 0.4):  # far smaller teeth than the first one, somewhere within its fall
            height = drop * story.peak * spread(rng, 0.04, 0.4)
            bottom += (drop * story.peak - height) * rng.uniform(0.0, 0.7)
        if maybe(rng, 0.06):  # the contact is stronger the second time
            _climb(story, story.peak * rng.uniform(1.02, 1.4), _Climb(how.rate, 0.0, 0.0))
            _fall(story, max(0.02, bottom * rng.uniform(0.6, 1.1)), fall_s, State.SLIP)
        _teeth(story, how, bottom, height, fall_s)
        if maybe(rng, 0.4):  # the motor stops before the next slip
            top = story.level + rng.uniform(0.1, 1.1) * height
            _climb(
                story, min(top, max(story.peak, story.level)), _Climb(how.rate, 0.0, rng.uniform(0.0, 0.1))
            )
            story.stay(State.HELD, spread(rng, 0.05, 2.0) * story.climb_s, rng.choice((0.0, 0.02)))
        return
    _fall(story, kinetic, fall_s, State.SLIP)
    wear = rng.choice((0.0, 0.0, rng.uniform(-0.25, 0.5), rng.uniform(0.0, 1.2)))
    story.rough(spread(rng, 0.2, 10.0) * story.climb_s, roughness, wear)
    for _ in range(int(rng.integers(1, 4)) if maybe(rng, 0.15) else 0):  # something is in the way
        level, faster = story.level, spread(rng, 0.7, 10.0)
        _climb(story, max(level, story.peak * rng.uniform(0.7, 1.6)), _Climb(how.rate * faster, 0.0, 0.0))
        _fall(story, level, fall_s, State.SLIP)
        story.rough(spread(rng, 0.1, 2.0) * story.climb_s, roughness)


def _teeth(story: _Story, how: _Climb, bottom: float, height: float, fall_s: float) -> None:
    """Stick and slip: up to thirty teeth that the machine loads at its own rate."""
    rng = story.rng
    trend, scatter = rng.choice((0.0, rng.uniform(-0.03, 0.08))), rng.choice((0.01, 0.1, 0.3))
    fall_s = min(fall_s, 0.15 * height / how.rate + 0.02)
    rises = rng.choice((0.0, 0.0, 0.0, rng.uniform(0.0, 0.4) * height))
    for number in range(int(rng.integers(0, 30))):
        top = bottom + height * max(0.1, 1.0 + scatter * rng.standard_normal()) * (1.0 + trend * number)
        if maybe(rng, 0.03):
            top = story.peak * (1.0 + rng.uniform(0.02, 0.3))
        if top > story.level + 1e-3:
            bend = rng.choice((0.0, rng.uniform(0.0, 0.3)))
            _climb(story, top, _Climb(how.rate * rng.uniform(0.85, 1.05), 0.0, bend))
            low = max(0.02, bottom + 0.25 * scatter * height * rng.standard_normal())
            _fall(story, low, fall_s, State.SLIP)
        bottom += rises


def _let_down(story: _Story) -> None:
    """Hold for a while, let the load down in part or whole, and rest."""
    rng, level = story.rng, story.level
    if maybe(rng, 0.5):
        story.stay(State.HELD, spread(rng, 0.02, 2.0), rng.uniform(0.0, 0.06))
    left = 0.0 if maybe(rng, 0.5) else level * rng.uniform(0.0, 0.9)
    story.line(State.LET_DOWN, story.climb_s * spread(rng, 0.02, 1.5), left)
    story.stay(State.REST, spread(rng, 0.05, 1.0))


def _strokes(story: _Story) -> None:
    """Go back and forth afterwards, one to thirty times, with peaks of their own or without."""
    rng, forth = story.rng, story.level
    back, peak, size = rng.uniform(-1.2, 0.8), rng.choice((0.0, rng.uniform(0.0, 0.4))), rng.uniform(0.8, 1.2)
    lasting_s = story.climb_s * spread(rng, 0.5, 100.0)
    for _ in range(int(rng.integers(1, 30))):
        for level in (back * rng.uniform(0.9, 1.1), forth * size * rng.uniform(0.95, 1.05)):
            story.line(State.LOADING, story.climb_s * rng.uniform(0.3, 2.0), level * (1.0 + peak))
            if peak:
                _fall(story, level, story.climb_s * spread(rng, 0.01, 1.0), State.SLIP)
            story.rough(lasting_s * rng.uniform(0.5, 1.0), spread(rng, 1e-3, 0.05))


def _slips(story: _Story) -> Status:
    how = _draw_climb(story.rng, story)
    _climb(story, 1.0, how)
    _break_away(story, how)
    return Status.OK


def _slips_under_weights(story: _Story) -> Status:
    _climb_by_weights(story)
    _break_away(story, _draw_climb(story.rng, story))
    return Status.OK


def _slips_after_a_hold(story: _Story) -> Status:
    """Stop on the way, hold, and go on to the break-away."""
    rng, how = story.rng, _draw_climb(story.rng, story)
    _climb(story, rng.uniform(max(0.3, story.level), 0.97), how)
    lasting_s = spread(rng, 0.2, 4.0) * story.climb_s
    story.stay(State.HELD, lasting_s, rng.choice((0.0, spread(rng, 0.002, 0.2))))
    _climb(story, max(1.0, 1.02 * story.level), how)
    _break_away(story, how)
    return Status.OK


def _slides_without_a_peak(story: _Story) -> Status:
    rng, how = story.rng, _draw_climb(story.rng, story)
    _climb(story, 1.0, _Climb(how.rate, how.soft, rng.uniform(0.03, 1.5), how.slips, how.rest_s))
    rise = rng.choice((0.0, rng.uniform(0.0, 0.3)))
    story.rough(spread(rng, 0.3, 4.0) * story.climb_s, rng.choice((0.0, spread(rng, 1e-3, 0.02))), rise)
    return Status.NO_PEAK


def _swing(story: _Story, rate: float) -> None:
    """Swing about a level as a mass does whose motor stops, until that dies away; it begins no faster than the climb."""
    rng, level = story.rng, story.level
    turns, damping = rng.uniform(3.0, 16.0) * np.pi, rng.uniform(0.05, 0.4)
    size = level * spread(rng, 2e-3, 0.1)
    swing = lambda part: level + size * np.exp(-damping * turns * part) * np.sin(turns * part)  # noqa: E731
    story.piece(State.HELD, size * turns / (rate * rng.uniform(0.2, 1.0)), swing)
    story.level = level


def _comes_off(story: _Story) -> Status:
    """Lose the rope or its load: nothing holds any more, so that the force swings about nothing."""
    rng, how = story.rng, _draw_climb(story.rng, story)
    _climb(story, rng.uniform(max(0.3, story.level), 1.0), how)
    top, turns, damping = story.level, rng.uniform(4.0, 30.0) * np.pi, rng.uniform(0.03, 0.3)
    free = lambda part: top * np.exp(-damping * turns * part) * np.cos(turns * part)  # noqa: E731
    story.piece(State.LET_DOWN, story.climb_s * spread(rng, 0.1, 2.0), free)
    story.level = 0.0
    story.stay(State.REST, spread(rng, 0.05, 1.0))
    return Status.NO_BREAKAWAY


def _turn_round(story: _Story, how: _Climb) -> None:
    """Let down about as fast as it was loaded and for the most part: a faster or smaller fall may be a slip."""
    rng, top = story.rng, story.level
    left, lasting_s = top * rng.uniform(0.0, 0.4), top / how.rate * spread(rng, 0.3, 4.0)
    power, is_soft = rng.uniform(1.0, 2.0), maybe(rng, 0.3)

    def comes_down(part: FloatArray) -> FloatArray:
        lost = 0.5 * (1.0 - np.cos(np.pi * part)) if is_soft else part**power
        return np.asarray(top - (top - left) * lost)

    story.piece(State.LET_DOWN, lasting_s, comes_down)
    if maybe(rng, 0.5):
        story.stay(State.REST, spread(rng, 0.05, 1.0))


def _is_held(story: _Story) -> Status:
    """Load up to less than it takes, hold or turn round at once, and let go of it one way or another."""
    rng, how = story.rng, _draw_climb(story.rng, story)
    _climb(story, rng.uniform(max(0.3, story.level), 0.97), how)
    if maybe(rng, 0.25):
        for _ in range(int(rng.integers(0, 20)) if maybe(rng, 0.4) else 0):
            _turn_round(story, how)
            _climb(story, max(story.level + 0.05, rng.uniform(0.5, 0.97)), how)
        _turn_round(story, how)
        return Status.NO_BREAKAWAY
    if maybe(rng, 0.4):
        _swing(story, how.rate)
    lasting_s = spread(rng, 0.2, 4.0) * story.climb_s
    story.stay(State.HELD, lasting_s, rng.choice((0.0, spread(rng, 0.002, 0.2))))
    if maybe(rng, 0.5):
        story.line(State.LET_DOWN, lasting_s * spread(rng, 0.01, 1.0), story.level * rng.uniform(0.0, 0.5))
        story.stay(State.REST, spread(rng, 0.05, 1.0))
    return Status.NO_BREAKAWAY


def _ends_early(story: _Story) -> Status:
    """Stop the logger before the rope breaks away, under swinging weights or where the force is as high as it was."""
    (_slips_under_weights if maybe(story.rng, 0.3) else _slips)(story)
    time_s, force, state = story.knots()
    begun = np.flatnonzero((state != State.REST) & (time_s < story.broke_s))
    first = int(story.rng.choice(begun)) if begun.size else 1
    is_clear = np.isin(state, (State.HUNG, State.DISTURBED)) | (force >= 0.98 * np.maximum.accumulate(force))
    story.stop_at(first + int(np.argmax(is_clear[first:])))
    return Status.NO_BREAKAWAY


def _still_climbs(story: _Story) -> Status:
    how = _draw_climb(story.rng, story)
    _climb(story, story.rng.uniform(max(0.3, story.level), 0.97), how)
    return Status.NO_BREAKAWAY


def _slides_already(story: _Story) -> Status:
    """Start the logger when the rope has broken away."""
    story.begin_again(0.9)
    story.rough(spread(story.rng, 0.5, 4.0) * story.climb_s, spread(story.rng, 0.002, 0.05))
    return Status.NO_PEAK


def _rests_on(story: _Story) -> Status:
    story.stay(State.REST, story.climb_s)
    return Status.NO_BREAKAWAY


KINDS: dict[str, tuple[float, Callable[[_Story], Status]]] = {
    "slips": (0.59, _slips),
    "slips-under-weights": (0.03, _slips_under_weights),
    "held-then-slips": (0.06, _slips_after_a_hold),
    "no-peak": (0.08, _slides_without_a_peak),
    "held": (0.11, _is_held),
    "comes-off": (0.02, _comes_off),
    "climbing": (0.03, _still_climbs),
    "ends-early": (0.04, _ends_early),
    "late-start": (0.03, _slides_already),
    "idle": (0.01, _rests_on),
}
"""Stories of a rope by name: how often each is drawn, and what tells it and returns the visible truth."""


def _told(rng: Rng, kind: str) -> tuple[_Story, Status]:
    """Return a whole sequence: the part before the pull, the pull, and the part after it."""
    story = _Story(rng, spread(rng, 0.04, 15.0))
    _rest(story)
    if maybe(rng, 0.3):
        _hang_weights(story)
    for _ in range(int(rng.integers(1, 3)) if maybe(rng, 0.18) else 0):
        _disturb(story)
    status = KINDS[kind][1](story)
    slid = status in {Status.OK, Status.NO_PEAK}
    if slid and maybe(rng, 0.12):  # slides on, far longer than it was loaded
        story.rough(spread(rng, 20.0, 800.0) * story.climb_s, spread(rng, 1e-3, 0.04))
    if slid and maybe(rng, 0.2):
        _strokes(story)
    if kind not in {"climbing", "ends-early", "idle"} and maybe(rng, 0.55):
        _let_down(story)
    if status is Status.OK and maybe(rng, 0.12) and story.level < 0.6:
        top = rng.uniform(0.7, 1.2)  # pulled again: lower, as high, or higher
        _climb(story, top, _Climb(1.0 / story.climb_s, 0.0, rng.choice((0.0, 0.2))))
        _fall(story, top * rng.uniform(0.5, 0.95), spread(rng, 1e-3, 0.3), State.SLIP)
        _let_down(story)
    if kind != "ends-early" and maybe(rng, 0.1):  # somebody forgets to stop the logger
        story.stay(State.REST if story.level < 0.05 else State.HELD, story.climb_s * spread(rng, 2.0, 1000.0))
    if maybe(rng, 0.14):
        story.start_late(spread(rng, 0.02, 0.5))
    return story, status


def draw_recording(rng: Rng, kind: str | None = None) -> LabelledRecording:
    """Return one recording, of a kind or of any; what nobody could judge is drawn again.

    Parameters
    ----------
    rng : numpy.random.Generator
        Where everything is drawn from.
    kind : str or None
        A name of `KINDS`.

    Examples
    --------
    >>> one = draw_recording(np.random.default_rng(1), "slips")
    >>> one.status.value, bool(one.time_s[0] < one.breakaway_s < one.time_s[-1])
    ('ok', True)
    """
    while True:
        shares = np.array([share for share, _ in KINDS.values()])
        chosen = kind or list(KINDS)[int(rng.choice(len(shares), p=shares))]
        story, status = _told(rng, chosen)
        samples = sampled(rng, *story.knots()[:2], story.climb_s)
        if samples is None:
            continue
        top = seen_top(samples, story.broke_s) if status is Status.OK else 0
        if status is Status.OK and not visible_fall(samples, top):
            continue
        spoil(samples)
        if status is Status.OK and maybe(rng, 0.05):
            ceiling = rng.uniform(0.6, 0.97) * story.peak
            samples.force, status = np.minimum(samples.force, ceiling), Status.SATURATED
        broke_s = float(samples.time_s[top])
        keep, scale_N = kept(samples, broke_s if top else nan), spread(rng, 1.0, 1000.0)
        knot_s, _, states = story.knots()
        state = states[np.minimum(np.searchsorted(knot_s, samples.time_s), states.size - 1)]
        if maybe(rng, DAMAGED) and (spoilt := damaged_state(samples, state)) is not None:
            state, status, keep = spoilt, Status.DOUBTFUL, np.ones(spoilt.size, dtype=bool)
        seen = status is Status.OK
        return LabelledRecording(
            kind=chosen, time_s=samples.time_s[keep], force_N=samples.force[keep] * scale_N, state=state[keep],
            status=status, breakaway_s=broke_s if seen else nan, peak_N=story.peak * scale_N if seen else nan,
            zero_N=samples.zero * scale_N,
        )  # fmt: skip


def draw_recordings(seed: int, count: int, kind: str | None = None) -> Iterator[LabelledRecording]:
    """Yield this many recordings, each from a seed of its own: the n-th does not depend on their number."""
    for number in range(count):
        yield draw_recording(np.random.default_rng([seed, number]), kind)
