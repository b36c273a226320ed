"""A third and a fourth rig: a rope as a chain of masses around a wheel, and a contact of many junctions.

Neither shares an equation with the bench or with `dynamics`. In both a motor pulls through the spring of a load cell,
at `SPEED_M_S`, and a weight hangs from the slack end; the rope breaks away when it slips for many slip distances.
"""

from collections.abc import Callable, Iterator, Mapping
from math import nan
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.rig.sampling import spread
from ropefric.rig.stories import LabelledRecording
from ropefric.traces.breakaway import Status
from ropefric.traces.picker import State

Rng = np.random.Generator
ELEMENTS, JUNCTIONS, GRAVITY_M_S2, SPEED_M_S = 16, 200, 9.81, 1e-3
STOPS = 0.15
"""How often the motor stops before the rope breaks away."""
FALL, LOWEST_FALL = 0.015, 0.005
"""A fall of this part of F_A ends the break-away; of a recording whose largest fall lies between, nobody could say."""
DAMPING, CHAIN_STEPS, JUNCTION_STEPS, KEPT_HZ = 0.1, 16.0, 24.0, 5000.0
"""Damping of the chain's springs; steps of time in a period; forces kept in a second."""


class Machine(NamedTuple):
    """One pull without a sensor: force of the cell and slip at times, and when the motor starts.

    Below `rests_m` the rope still holds, above `slips_m` it has broken away; one that does not stays below `stays_m`.
    """

    time_s: FloatArray
    force_N: FloatArray
    slip_m: FloatArray
    rests_m: float
    stays_m: float
    slips_m: float
    starts_s: float


Rig = Callable[[Rng, int], Iterator[Machine]]
Ranges = Mapping[str, tuple[float, float]]


def _drawn(rng: Rng, count: int, by_decades: Ranges, evenly: Ranges, given: Ranges) -> dict[str, FloatArray]:
    """Return numbers of shape (count, 1) from ranges, given ones in place of usual ones; and where the motor stops."""
    drawn = {}
    for name, usual in by_decades.items():
        low, high = np.log(given.get(name, usual))
        drawn[name] = np.exp(rng.uniform(low, high, (count, 1)))
    for name, usual in evenly.items():
        drawn[name] = rng.uniform(*given.get(name, usual), (count, 1))
    # As a part of the way to the break-away; mostly it does not stop.
    stops = rng.random((count, 1)) < STOPS
    return drawn | {"stop": np.where(stops, rng.uniform(0.4, 0.9, (count, 1)), np.inf)}


class _Motor:
    """A motor that rests, starts softly, and goes on, or stops on its way."""

    def __init__(self, drawn: dict[str, FloatArray], way_m: FloatArray, step_s: float) -> None:
        self.drawn, self.way_m, self.step_s = drawn, way_m, step_s
        self.at_m = np.zeros_like(way_m)

    def step(self, time_s: float) -> FloatArray:
        """Return where it is after a step that ends at a time [m]."""
        pulling_s = np.maximum(time_s - self.drawn["rest_s"], 0.0)
        soft = np.minimum(pulling_s / (self.drawn["soft_s"] * self.drawn["climb_s"]), 1.0)
        self.at_m = self.at_m + self.step_s * SPEED_M_S * soft * (self.at_m < self.drawn["stop"] * self.way_m)
        return self.at_m


CHAIN_BY_DECADES: Ranges = {
    "weight_N": (2.0, 300.0), "climb_s": (0.4, 4.0), "heal_s": (0.02, 2.0), "rope": (1.0, 20.0), "own_Hz": (15.0, 40.0),
    "distance": (0.002, 0.05), "roughness": (1e-4, 0.01),
}  # fmt: skip
CHAIN_EVENLY: Ranges = {
    "wrap": (0.8, 7.0), "static": (0.1, 0.45), "rest_s": (0.3, 1.5), "slide_s": (0.8, 3.0), "weakening": (0.6, 0.95),
    "soft_s": (0.01, 0.15), "begin": (0.0, 0.5),
}  # fmt: skip


def chains(rng: Rng, count: int, **given: tuple[float, float]) -> Iterator[Machine]:
    """Yield pulls of a chain of elements with mass and Coulomb friction on a locked wheel, joined by springs.

    The normal force on an element is the mean of the tensions beside it times its angle. Friction falls from static to
    kinetic over a slip distance and heals at rest: slip begins at the tight end and runs to the weight.
    """
    drawn = _drawn(rng, count, CHAIN_BY_DECADES, CHAIN_EVENLY, given)
    weight_N, wrap = drawn["weight_N"], drawn["wrap"]
    static = np.minimum(drawn["static"], 2.2 / wrap)
    kinetic = static * drawn["weakening"]
    # The cell's spring comes to the lift force in the time of the climb; the rope is stiffer by a factor.
    way_m = SPEED_M_S * drawn["climb_s"]
    cell_N_m = weight_N * np.exp(static * wrap) / way_m
    rope_N_m = cell_N_m * drawn["rope"] * ELEMENTS
    mass_kg = np.repeat(rope_N_m / (2.0 * np.pi * drawn["own_Hz"] * ELEMENTS) ** 2, ELEMENTS, axis=1)
    damping_N_s_m = DAMPING * np.sqrt(rope_N_m * mass_kg[:, :1])
    mass_kg[:, -1:] += np.minimum(weight_N / GRAVITY_M_S2, cell_N_m / (8.0 * np.pi) ** 2)
    step_s = 1.0 / (float(drawn["own_Hz"].max()) * ELEMENTS * CHAIN_STEPS)
    # The rope was laid on with some friction the other way: its tension falls from the weight to the cell.
    angles = wrap * np.arange(ELEMENTS) / ELEMENTS
    tension_N = weight_N * np.exp(-drawn["begin"] * static * (wrap - angles))
    stretch_m = tension_N / np.concatenate([cell_N_m, np.repeat(rope_N_m, ELEMENTS - 1, axis=1)], axis=1)
    x_m = -np.cumsum(stretch_m, axis=1)
    still_m, v_m_s, fresh = x_m[:, -1].copy(), np.zeros_like(x_m), np.ones_like(x_m)
    waves = rng.uniform(0.0, 2.0 * np.pi, (count, 3, 1))
    lengths_m = (1.0 + 4.0 * rng.random((count, 3, 1))) * way_m[:, None]
    distance_m, healed = drawn["distance"] * way_m, np.exp(-step_s / drawn["heal_s"])
    motor = _Motor(drawn, way_m, step_s)

    def step(time_s: float) -> tuple[FloatArray, FloatArray]:
        nonlocal x_m, v_m_s, fresh
        cell_N = (motor.step(time_s) - x_m[:, :1]) * cell_N_m
        beside_N = np.concatenate([cell_N, rope_N_m * (x_m[:, :-1] - x_m[:, 1:]), weight_N], axis=1)
        apart_m_s = np.concatenate([-v_m_s[:, :1], v_m_s[:, :-1] - v_m_s[:, 1:], np.zeros_like(wrap)], axis=1)
        pulled_N = beside_N + damping_N_s_m * apart_m_s
        free_m_s = v_m_s + step_s * (pulled_N[:, :-1] - pulled_N[:, 1:]) / mass_kg
        normal_N = 0.5 * np.maximum(beside_N[:, :-1] + beside_N[:, 1:], 0.0) * wrap / ELEMENTS
        rough = 1.0 + drawn["roughness"] * np.sin(2.0 * np.pi * x_m[:, None] / lengths_m + waves).sum(axis=1)
        brake_m_s = step_s * (kinetic + (static - kinetic) * fresh) * rough * normal_N / mass_kg
        v_m_s = np.sign(free_m_s) * np.maximum(np.abs(free_m_s) - brake_m_s, 0.0)
        x_m = x_m + step_s * v_m_s
        worn = fresh * np.exp(-step_s * np.abs(v_m_s) / distance_m)
        fresh = np.where(v_m_s == 0.0, 1.0 - (1.0 - fresh) * healed, worn)
        return cell_N[:, 0], x_m[:, -1] - still_m

    slips_m = np.concatenate([0.06 * distance_m, 0.1 * distance_m, 3.0 * distance_m], axis=1)
    return _run(step, drawn, step_s, slips_m)


CONTACTS_BY_DECADES: Ranges = {
    "weight_N": (2.0, 300.0), "climb_s": (0.4, 5.0), "own_Hz": (6.0, 25.0), "distance": (0.03, 0.25),
    "age_s": (1e-3, 0.3),
}  # fmt: skip
CONTACTS_EVENLY: Ranges = {
    "wrap": (0.8, 7.0), "static": (0.1, 0.45), "rest_s": (0.3, 1.5), "slide_s": (0.8, 3.0), "spread": (0.03, 0.35),
    "left": (0.2, 0.9), "ageing": (0.0, 0.06), "soft_s": (0.01, 0.15), "damping": (0.04, 0.4), "begin": (-0.4, 0.4),
}  # fmt: skip


def contacts(rng: Rng, count: int, **given: tuple[float, float]) -> Iterator[Machine]:
    """Yield pulls of a rope that many elastic junctions hold on its wheel, each until it is stretched too far.

    A junction that breaks joins again at once, stretched less, and grows stronger with the logarithm of its age. The
    coefficient μ is the mean stretch of all, and the rope is pulled by F_B e^(μφ). At rest they have all aged.
    """
    drawn = _drawn(rng, count, CONTACTS_BY_DECADES, CONTACTS_EVENLY, given)
    weight_N, wrap = drawn["weight_N"], drawn["wrap"]
    static = np.minimum(drawn["static"], 2.2 / wrap)
    way_m, is_tared = SPEED_M_S * drawn["climb_s"], rng.random((count, 1)) < 0.5
    distance_m, held_s = drawn["distance"] * way_m, 1e3
    aged = 1.0 + drawn["ageing"] * np.log1p(held_s / drawn["age_s"])
    stiff_N_m = weight_N * np.expm1(static * wrap) / way_m
    mass_kg = stiff_N_m / (2.0 * np.pi * drawn["own_Hz"]) ** 2
    damping_N_s_m = 2.0 * drawn["damping"] * np.sqrt(stiff_N_m * mass_kg)
    gain = static * wrap / -np.expm1(-static * wrap)
    fastest_Hz = drawn["own_Hz"] * np.sqrt(1.0 + gain / drawn["distance"])
    step_s = 1.0 / (float(fastest_Hz.max()) * JUNCTION_STEPS)
    # Of equal shares of a normal distribution of the logarithms, so that no draw is lopsided.
    shares = rng.permuted(np.tile((np.arange(JUNCTIONS) + 0.5) / JUNCTIONS, (count, 1)), axis=1)
    width = np.sqrt(3.0) * drawn["spread"]
    strength_m = distance_m / aged * np.exp(width * (2.0 * shares - 1.0))
    # A cell that is tared shows no force at rest, so nothing but the weight may pull there.
    begin = np.where(is_tared, 0.0, drawn["begin"])
    stretch_m = np.repeat(begin * distance_m, JUNCTIONS, axis=1)
    age_s = np.full_like(stretch_m, held_s)
    start_N = weight_N * np.expm1(static * stretch_m.mean(axis=1, keepdims=True) / distance_m * wrap)
    x_m, v_m_s = -start_N / stiff_N_m, np.zeros_like(wrap)
    still_m, motor = x_m, _Motor(drawn, way_m, step_s)

    def step(time_s: float) -> tuple[FloatArray, FloatArray]:
        nonlocal x_m, v_m_s, stretch_m, age_s
        spring_N = (motor.step(time_s) - x_m) * stiff_N_m
        mu = static * stretch_m.mean(axis=1, keepdims=True) / distance_m
        v_m_s = v_m_s + step_s * (spring_N - weight_N * np.expm1(mu * wrap) - damping_N_s_m * v_m_s) / mass_kg
        x_m = x_m + step_s * v_m_s
        stretch_m, age_s = stretch_m + step_s * v_m_s, age_s + step_s
        limit_m = strength_m * (1.0 + drawn["ageing"] * np.log1p(age_s / drawn["age_s"]))
        breaks = np.abs(stretch_m) > limit_m
        if breaks.any():
            joined_m = np.sign(stretch_m) * drawn["left"] * strength_m
            stretch_m, age_s = np.where(breaks, joined_m, stretch_m), np.where(breaks, 0.0, age_s)
        return (spring_N + np.where(is_tared, 0.0, weight_N))[:, 0], (x_m - still_m)[:, 0]

    farthest_m = distance_m * (np.exp(width) - begin)
    nearest_m = distance_m * (np.exp(-width) - begin)
    slips_m = np.concatenate([0.7 * nearest_m, 0.9 * nearest_m, 2.0 * farthest_m], axis=1)
    return _run(step, drawn, step_s, slips_m)


def _run(
    step: Callable[[float], tuple[FloatArray, FloatArray]],
    drawn: dict[str, FloatArray],
    step_s: float,
    slips_m: FloatArray,
) -> Iterator[Machine]:
    """Yield the machines whose steps of time are given, each until its end."""
    ends_s = (drawn["rest_s"] + 1.4 * drawn["climb_s"] + drawn["slide_s"])[:, 0]
    every = max(1, round(1.0 / (KEPT_HZ * step_s)))
    kept = []
    for number in range(int(np.ceil(float(ends_s.max()) / step_s))):
        found = step(number * step_s)
        if number % every == 0:
            kept.append((number * step_s, *found))
    time_s, force_N, slip_m = (np.array(one) for one in zip(*kept, strict=True))
    for k, end_s in enumerate(ends_s.tolist()):
        n = int(np.searchsorted(time_s, end_s))
        rests_m, stays_m, passes_m = slips_m[k].tolist()
        starts_s = float(drawn["rest_s"][k, 0])
        yield Machine(time_s[:n], force_N[:n, k], slip_m[:n, k], rests_m, stays_m, passes_m, starts_s)


def _truth(one: Machine) -> tuple[Status, int] | None:
    """Return status and index of the break-away; None where nobody could say."""
    force_N, slip_m = one.force_N, one.slip_m
    moved = np.flatnonzero(slip_m > one.slips_m)
    if not moved.size:
        return (Status.NO_BREAKAWAY, 0) if slip_m.max() < one.stays_m else None
    begun = int(np.flatnonzero(slip_m[: moved[0]] <= one.rests_m).max(initial=0))
    after_N = force_N[begun:]
    fall_N = np.maximum.accumulate(after_N) - after_N
    fallen = np.flatnonzero(fall_N > FALL * after_N.max())
    if not fallen.size:
        return (Status.NO_PEAK, 0) if fall_N.max() < LOWEST_FALL * after_N.max() else None
    top = begun + int(np.argmax(after_N[: fallen[0] + 1]))
    # An attempt that stopped short, as high as the break-away.
    climb_N = force_N[: top + 1]
    earlier_N = (np.maximum.accumulate(climb_N) - climb_N)[climb_N < 0.98 * climb_N[-1]]
    return None if earlier_N.max(initial=0.0) > FALL * climb_N[-1] else (Status.OK, top)


def pulls(rng: Rng, count: int, rig: Rig) -> Iterator[LabelledRecording]:
    """Yield the recordings of about so many pulls of a rig: `chains` or `contacts`; the same for the same seed."""
    for one in rig(rng, count):
        known = _truth(one)
        if known is None:
            continue
        status, top = known
        size_N = float(one.force_N.max())
        time_s = np.arange(0.0, one.time_s[-1], 1.0 / spread(rng, 150.0, 2500.0))
        noise_N = size_N * spread(rng, 2e-4, 6e-3) * rng.standard_normal(time_s.size)
        count_N = size_N * rng.uniform(1.1, 4.0) / 2.0 ** int(rng.integers(10, 17))
        read_N = np.rint((np.interp(time_s, one.time_s, one.force_N) + noise_N) / count_N) * count_N
        state = np.where(time_s < one.starts_s, State.REST, State.LOADING)
        at_s, peak_N = nan, nan
        if status is Status.OK:
            at_s, peak_N = float(one.time_s[top]), float(one.force_N[top])
            state[time_s > at_s] = State.SLIDING
        yield LabelledRecording(
            kind=rig.__name__, time_s=time_s, force_N=read_N, state=state, status=status, breakaway_s=at_s, peak_N=peak_N
        )  # fmt: skip
