"""Where modes of the blade meet excitations: over the speed, at work, and which preload keeps them apart."""

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray, IntArray
from ropefric.files.digits import significant
from ropefric.systems.bandsaw.saw import (
    AdvisedStatus,
    Saw,
    Side,
    frequencies_Hz,
    preloads_for_N,
    roots_between,
)

_SIDES = (Side.TIGHT, Side.SLACK)


class Excitation(NamedTuple):
    """A cause of vibration and its harmonics: f_h(v) = h (f_0 + v/λ)."""

    name: str
    constant_Hz: float = 0.0
    per_metre: float = 0.0
    harmonics: tuple[int, ...] = (1,)

    def frequencies_Hz(self, speed_m_s: npt.ArrayLike) -> FloatArray:
        """Return the frequencies of the harmonics at blade speeds, shape (…, n_harmonics) [Hz]."""
        basic = self.constant_Hz + self.per_metre * np.abs(np.asarray(speed_m_s, dtype=np.float64))
        return np.multiply.outer(basic, np.asarray(self.harmonics, dtype=np.float64))


def wheel_rotation(wheel_radius_m: float, harmonics: tuple[int, ...] = (1, 2, 3)) -> Excitation:
    """Return the excitation by a wheel that is out of round or balance: once a turn, v/(2πR)."""
    return Excitation("wheel rotation", per_metre=1.0 / (2.0 * math.pi * wheel_radius_m), harmonics=harmonics)


def tooth_passing(tooth_pitch_m: float, harmonics: tuple[int, ...] = (1,)) -> Excitation:
    """Return the excitation by teeth that enter the wood: once a pitch."""
    return Excitation("tooth passing", per_metre=1.0 / tooth_pitch_m, harmonics=harmonics)


def fixed_frequency(name: str, frequency_Hz: float, harmonics: tuple[int, ...] = (1,)) -> Excitation:
    """Return an excitation whose frequency does not depend on the blade's speed, such as a motor or a fan."""
    return Excitation(name, constant_Hz=frequency_Hz, harmonics=harmonics)


class Crossing(NamedTuple):
    """A blade speed at which an excitation has the frequency of a mode."""

    side: Side
    mode: int
    excitation: str
    harmonic: int
    speed_m_s: float
    frequency_Hz: float
    speed_margin: float


class Margin(NamedTuple):
    """How far a mode is from an excitation at the speed at work."""

    side: Side
    mode: int
    excitation: str
    harmonic: int
    mode_Hz: float
    excitation_Hz: float
    margin: float


def find_crossings(
    saw: Saw,
    side: Side,
    excitations: tuple[Excitation, ...],
    speeds_m_s: npt.ArrayLike,
    n_modes: int = 6,
) -> tuple[Crossing, ...]:
    """Return all crossings between the first and the last of some speeds, by speed.

    A mode's frequency falls with the speed and an excitation's does not, so a pair crosses at most once and its ends
    tell whether it does.
    """
    ends = np.asarray(speeds_m_s, dtype=np.float64)[[0, -1]]
    of_modes = frequencies_Hz(saw, side, n_modes, speed_m_s=ends)
    pairs = [
        (excitation, harmonic, mode)
        for excitation in excitations
        for column, harmonic in enumerate(excitation.harmonics)
        for above in [of_modes > excitation.frequencies_Hz(ends)[:, column, np.newaxis]]
        for mode in (np.flatnonzero(above[0] & ~above[1]) + 1).tolist()
    ]
    if not pairs:
        return ()
    modes = np.array([mode for _, _, mode in pairs])
    constant_Hz, per_metre = np.array([(h * one.constant_Hz, h * one.per_metre) for one, h, _ in pairs]).T

    def above_Hz(speed: FloatArray, cases: IntArray) -> FloatArray:
        found = frequencies_Hz(saw, side, int(modes[cases].max()), speed_m_s=speed)
        own_Hz = found[np.arange(cases.size), modes[cases] - 1]
        return np.asarray(own_Hz - constant_Hz[cases] - per_metre[cases] * speed)

    low, high = (np.full(len(pairs), end) for end in ends)
    meeting = roots_between(above_Hz, low, high)
    crossings = [
        Crossing(
            side=side,
            mode=mode,
            excitation=excitation.name,
            harmonic=harmonic,
            speed_m_s=speed,
            frequency_Hz=harmonic * (excitation.constant_Hz + excitation.per_metre * speed),
            speed_margin=speed / saw.speed_m_s - 1.0 if saw.speed_m_s > 0.0 else np.inf,
        )
        for (excitation, harmonic, mode), speed in zip(pairs, meeting.tolist(), strict=True)
    ]
    return in_order(crossings)


def in_order(crossings: list[Crossing]) -> tuple[Crossing, ...]:
    """Return crossings by speed. On a string mode n meets n turns at one speed: rounding must not order them."""
    return tuple(sorted(crossings, key=lambda one: (significant(one.speed_m_s), one.mode, one.harmonic)))


def margins(
    saw: Saw, sides: tuple[Side, ...], excitations: tuple[Excitation, ...], n_modes: int = 6
) -> tuple[Margin, ...]:
    """Return how far every mode is from every excitation at the speed at work, the nearest first."""
    found = [
        Margin(side, mode, excitation.name, harmonic, mode_Hz, excited_Hz, mode_Hz / excited_Hz - 1.0)
        for side in sides
        for mode, mode_Hz in enumerate(frequencies_Hz(saw, side, n_modes)[0].tolist(), start=1)
        for excitation in excitations
        for harmonic, excited_Hz in zip(
            excitation.harmonics, excitation.frequencies_Hz(saw.speed_m_s).tolist(), strict=True
        )
        if excited_Hz > 0.0
    ]
    return tuple(sorted(found, key=lambda one: (significant(abs(one.margin)), one.mode, one.harmonic)))


class SawChart(NamedTuple):
    """What a Campbell chart shows."""

    saw: Saw
    speed_m_s: FloatArray
    mode_Hz: dict[Side, FloatArray]
    excitations: tuple[Excitation, ...]
    crossings: tuple[Crossing, ...]


def saw_chart(
    saw: Saw, excitations: tuple[Excitation, ...], speeds_m_s: npt.ArrayLike, n_modes: int = 4
) -> SawChart:
    """Return the data of a Campbell chart of both sides at constant torque."""
    speeds = np.array(speeds_m_s, dtype=np.float64)
    found = [
        crossing for side in _SIDES for crossing in find_crossings(saw, side, excitations, speeds, n_modes)
    ]
    speeds.flags.writeable = False
    return SawChart(
        saw=saw,
        speed_m_s=speeds,
        mode_Hz={side: frequencies_Hz(saw, side, n_modes, speed_m_s=speeds) for side in _SIDES},
        excitations=excitations,
        crossings=in_order(found),
    )


_SEARCHED = 65


class StrainStatus(AdvisedStatus):
    """What is to be done about the preload."""

    KEEP = "keep: The present preload keeps every mode far enough from every excitation."
    CHANGE = "change: Set the recommended preload: the nearest that keeps the margin."
    IMPOSSIBLE = (
        "impossible: No preload in the range keeps the margin: as one mode leaves an excitation another arrives. "
        "Change the wheel speed or the free span, accept the best margin, or consider fewer harmonics."
    )


class StrainAdvice(NamedTuple):
    """A recommended preload."""

    status: StrainStatus
    preload_N: float
    margin: float
    forbidden_N: tuple[tuple[float, float], ...]


def recommend_preload(
    saw: Saw,
    excitations: tuple[Excitation, ...],
    *,
    margin: float,
    range_N: tuple[float, float],
    n_modes: int = 6,
) -> StrainAdvice:
    """Return the preload nearest to the present one at which all modes of both sides keep a margin.

    Every frequency rises with the preload, so a mode and an excitation forbid one interval of it, whose ends are
    found by inversion; what none of the intervals covers is allowed.
    """
    low_N, high_N = range_N
    forbidden = _union(
        interval
        for side in _SIDES
        for interval in _forbidden(saw, side, excitations, margin=margin, range_N=range_N, n_modes=n_modes)
    )
    present_N = min(max(saw.preload_N, low_N), high_N)
    candidates = [present_N, low_N, high_N, *(end for interval in forbidden for end in interval)]
    # The ends of the intervals are roots: a hair inside them still is outside for people.
    hair_N = 1e-9 * high_N
    allowed = [
        preload_N
        for preload_N in candidates
        if low_N <= preload_N <= high_N
        and all(not start + hair_N < preload_N < stop - hair_N for start, stop in forbidden)
    ]
    if allowed:
        nearest_N = min(allowed, key=lambda preload_N: (abs(preload_N - saw.preload_N), preload_N))
        status = StrainStatus.KEEP if nearest_N == saw.preload_N else StrainStatus.CHANGE
    else:
        tried = np.linspace(*range_N, _SEARCHED).tolist()
        nearest_N = max(tried, key=lambda preload_N: _margin_at(saw, excitations, preload_N, n_modes))
        status = StrainStatus.IMPOSSIBLE
    return StrainAdvice(
        status=status,
        preload_N=nearest_N,
        margin=_margin_at(saw, excitations, nearest_N, n_modes),
        forbidden_N=tuple((max(start, low_N), min(stop, high_N)) for start, stop in forbidden),
    )


def _forbidden(
    saw: Saw,
    side: Side,
    excitations: tuple[Excitation, ...],
    *,
    margin: float,
    range_N: tuple[float, float],
    n_modes: int,
) -> list[tuple[float, float]]:
    """Return the intervals of preload that the modes of one side forbid, cut to the range."""
    slowest, fastest = frequencies_Hz(saw, side, n_modes, preload_N=range_N)
    excited = np.concatenate([np.empty(0), *(one.frequencies_Hz(saw.speed_m_s) for one in excitations)])
    excited_Hz, mode = (
        part.ravel() for part in np.meshgrid(excited, np.arange(1, n_modes + 1), indexing="ij")
    )
    below_Hz, above_Hz = excited_Hz * (1.0 - margin), excited_Hz * (1.0 + margin)
    least_Hz, most_Hz = slowest[mode - 1], fastest[mode - 1]
    # An interval that goes on beyond the range must not leave its end allowed.
    past_N = 1e-6 * range_N[1]
    start_N = range_N[0] - past_N * (least_Hz > below_Hz)
    stop_N = range_N[1] + past_N * (most_Hz < above_Hz)
    met = (most_Hz > below_Hz) & (least_Hz < above_Hz)
    for edge_N, edge_Hz, inside in (
        (start_N, below_Hz, met & (least_Hz < below_Hz)),
        (stop_N, above_Hz, met & (most_Hz > above_Hz)),
    ):
        edge_N[inside] = preloads_for_N(saw, side, edge_Hz[inside], mode[inside])
    return list(zip(start_N[met].tolist(), stop_N[met].tolist(), strict=True))


def _union(intervals: Iterable[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    merged: list[tuple[float, float]] = []
    for start, stop in sorted(intervals):
        if merged and start <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(merged[-1][1], stop))
        else:
            merged.append((start, stop))
    return tuple(merged)


def _margin_at(saw: Saw, excitations: tuple[Excitation, ...], preload_N: float, n_modes: int) -> float:
    nearest = margins(replace(saw, preload_N=preload_N), _SIDES, excitations, n_modes)
    return abs(nearest[0].margin) if nearest else math.inf
