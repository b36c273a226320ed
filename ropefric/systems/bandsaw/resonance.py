"""Where modes of the blade meet excitations: over the speed, at work, and which preload keeps them apart."""

import math
from collections.abc import Callable
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BarycentricInterpolator

from ropefric.arrays import FloatArray, frozen_array
from ropefric.files.plain_text import significant
from ropefric.glossary import AdvisedStatus
from ropefric.systems.bandsaw.saw import Saw, Side, frequencies_Hz
from ropefric.systems.roots import roots_of_cases

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


def _harmonics(excitations: tuple[Excitation, ...]) -> list[tuple[Excitation, int]]:
    return [(one, harmonic) for one in excitations for harmonic in one.harmonics]


def _excited_Hz(excitations: tuple[Excitation, ...], speed_m_s: npt.ArrayLike) -> FloatArray:
    """Return the frequencies of all harmonics of all excitations at blade speeds, shape (…, n_all) [Hz]."""
    none = np.empty((*np.shape(speed_m_s), 0))
    return np.concatenate([none, *(one.frequencies_Hz(speed_m_s) for one in excitations)], axis=-1)


_MOST_NODES = 128
_SQUARED_ERROR = 1e-11
"""Of an interpolated f²: a tenth of the accuracy of the frequencies that it is made from."""


def modes_over(
    saw: Saw, side: Side, n_modes: int, what: str, *, ends: tuple[float, float]
) -> Callable[[FloatArray], FloatArray]:
    """Return the frequencies as a function of "speed_m_s" or "preload_N" between two ends, shape (m, n_modes) [Hz].

    A string's have a closed form. For a beam f² is a smooth function of v² and of F_0, up to the critical speed and
    through it, so it is interpolated at Chebyshev's points; their number is doubled until that changes nothing.
    """

    def exact(at: FloatArray) -> FloatArray:
        given: dict[str, Any] = {what: at}
        return frequencies_Hz(saw, side, n_modes, **given)

    if saw.bending_stiffness_N_m2 == 0.0 or not ends[0] < ends[1]:
        return exact
    power = 2.0 if what == "speed_m_s" else 1.0
    low, high = (end**power for end in ends)

    def squared(turns: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return where shares of a half turn lead on the way from end to end, and what f² is there."""
        share = 0.5 - 0.5 * np.cos(np.pi * turns)
        places = (1.0 - share) * low + share * high
        return places, exact(np.clip(places ** (1.0 / power), *ends)) ** 2

    (places, table), error = squared(np.array([0.0, 0.5, 1.0])), np.inf
    while len(table) <= _MOST_NODES:
        weights = (-1.0) ** np.arange(len(table))
        weights[[0, -1]] *= 0.5
        curve = BarycentricInterpolator(places, table, wi=weights)
        # To double the points squares what is missing.
        if error**2 <= _SQUARED_ERROR:
            return lambda at: np.asarray(np.sqrt(curve(np.asarray(at) ** power)))
        new, between = squared((np.arange(len(table) - 1) + 0.5) / (len(table) - 1))
        error = float(np.abs(curve(new) / between - 1.0).max())
        after = np.arange(1, len(table))
        places, table = np.insert(places, after, new), np.insert(table, after, between, axis=0)
    return exact


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

    A mode's frequency falls with the speed and an excitation's does not, so a pair crosses at most once, and its ends
    show whether it does.
    """
    ends, causes = np.asarray(speeds_m_s, dtype=np.float64)[[0, -1]], _harmonics(excitations)
    curve = modes_over(saw, side, n_modes, "speed_m_s", ends=(float(ends[0]), float(ends[1])))
    above = curve(ends)[:, np.newaxis] > _excited_Hz(excitations, ends)[..., np.newaxis]
    cause, modes = np.nonzero(above[0] & ~above[1])
    if not modes.size:
        return ()
    pairs = np.arange(modes.size)

    def above_Hz(speed_m_s: FloatArray) -> FloatArray:
        return np.asarray(curve(speed_m_s)[pairs, modes] - _excited_Hz(excitations, speed_m_s)[pairs, cause])

    meeting = roots_of_cases(above_Hz, *(np.full(modes.size, end) for end in ends))
    meeting_Hz = _excited_Hz(excitations, meeting)[pairs, cause]
    found = []
    for which, mode, speed, meets_Hz in zip(
        cause.tolist(), (modes + 1).tolist(), meeting.tolist(), meeting_Hz.tolist(), strict=True
    ):
        excitation, harmonic = causes[which]
        apart = speed / saw.speed_m_s - 1.0 if saw.speed_m_s > 0.0 else np.inf
        found.append(Crossing(side, mode, excitation.name, harmonic, speed, meets_Hz, apart))
    return in_order(found)


def in_order(crossings: list[Crossing]) -> tuple[Crossing, ...]:
    """Return crossings by speed. On a string mode n meets n turns at one speed: rounding must not order them."""
    return tuple(sorted(crossings, key=lambda one: (significant(one.speed_m_s), one.mode, one.harmonic)))


def margins(
    saw: Saw, sides: tuple[Side, ...], excitations: tuple[Excitation, ...], n_modes: int = 6
) -> tuple[Margin, ...]:
    """Return how far every mode is from every excitation at the speed at work, the nearest first."""
    excited_Hz, found = _excited_Hz(excitations, saw.speed_m_s).tolist(), []
    for side in sides:
        modes_Hz = frequencies_Hz(saw, side, n_modes)[0].tolist()
        for (mode, own_Hz), ((cause, harmonic), its_Hz) in product(
            enumerate(modes_Hz, start=1), zip(_harmonics(excitations), excited_Hz, strict=True)
        ):
            if its_Hz > 0.0:
                found.append(Margin(side, mode, cause.name, harmonic, own_Hz, its_Hz, own_Hz / its_Hz - 1.0))
    return tuple(sorted(found, key=lambda one: (significant(abs(one.margin)), one.mode, one.harmonic)))


class SawChart(NamedTuple):
    """The data of a Campbell chart."""

    saw: Saw
    speed_m_s: FloatArray
    mode_Hz: dict[Side, FloatArray]
    excitations: tuple[Excitation, ...]
    crossings: tuple[Crossing, ...]


def saw_chart(
    saw: Saw, excitations: tuple[Excitation, ...], speeds_m_s: npt.ArrayLike, n_modes: int = 4
) -> SawChart:
    """Return the data of a Campbell chart of both sides at constant torque."""
    speeds, found, modes_Hz = frozen_array(speeds_m_s), list[Crossing](), {}
    ends = (float(speeds[0]), float(speeds[-1]))
    for side in _SIDES:
        found += find_crossings(saw, side, excitations, speeds, n_modes)
        modes_Hz[side] = modes_over(saw, side, n_modes, "speed_m_s", ends=ends)(speeds)
    return SawChart(saw, speeds, modes_Hz, excitations, in_order(found))


_SEARCHED, _HILLS, _ZOOM, _SETTLED = 257, 4, 33, 1e-10


class StrainStatus(AdvisedStatus):
    """Recommendation for the preload."""

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
    found by inversion; preloads outside all intervals are allowed.
    """
    low_N, high_N = range_N
    excited_Hz = _excited_Hz(excitations, saw.speed_m_s)
    curves = [modes_over(saw, side, n_modes, "preload_N", ends=range_N) for side in _SIDES]
    intervals_N = np.concatenate([_forbidden(curve, excited_Hz, margin, range_N) for curve in curves])
    present_N, (starts_N, stops_N) = min(max(saw.preload_N, low_N), high_N), intervals_N.T
    # Where an interval begins beyond all that end before it, a new one of their union does.
    starts_N, stops_N = np.sort(starts_N), np.maximum.accumulate(stops_N[np.argsort(starts_N, kind="stable")])
    first = np.append(True, starts_N[1:] > stops_N[:-1])[: starts_N.size]
    starts_N, stops_N = starts_N[first], stops_N[np.append(first[1:], True)[: first.size]]
    candidates_N = np.array([present_N, low_N, high_N, *starts_N, *stops_N])
    # The ends of the intervals are roots: a hair inside them still is outside for people.
    hair_N, at_N = 1e-9 * high_N, candidates_N[:, np.newaxis]
    inside = ((starts_N + hair_N < at_N) & (at_N < stops_N - hair_N)).any(axis=1)
    allowed_N = candidates_N[(low_N <= candidates_N) & (candidates_N <= high_N) & ~inside].tolist()

    def nearest(preload_N: FloatArray) -> FloatArray:
        """Return the smallest margin at preloads within the range."""
        of_modes = np.concatenate([curve(preload_N) for curve in curves], axis=1)
        apart = np.abs(of_modes[..., np.newaxis] / excited_Hz[excited_Hz > 0.0] - 1.0)
        return np.asarray(apart.min(axis=(1, 2), initial=np.inf))

    status = StrainStatus.IMPOSSIBLE
    if allowed_N:
        nearest_N = min(allowed_N, key=lambda preload_N: (abs(preload_N - saw.preload_N), preload_N))
        status = StrainStatus.KEEP if nearest_N == saw.preload_N else StrainStatus.CHANGE
    else:
        nearest_N = _best(nearest, range_N)
    cut_N = np.clip(np.stack([starts_N, stops_N], axis=1), low_N, high_N).tolist()
    forbidden_N = tuple((start, stop) for start, stop in cut_N)
    return StrainAdvice(status, nearest_N, float(nearest(np.array([nearest_N]))[0]), forbidden_N)


def _best(nearest: Callable[[FloatArray], FloatArray], range_N: tuple[float, float]) -> float:
    """Return the preload of the greatest margin: every hill of it that may be the highest is looked at more closely."""
    tried = np.linspace(*range_N, _SEARCHED)
    margin, step = nearest(tried), (range_N[1] - range_N[0]) / (_SEARCHED - 1)
    padded = np.pad(margin, 1, constant_values=-np.inf)
    hills = np.flatnonzero((margin >= padded[:-2]) & (margin >= padded[2:]))
    ends = []
    for top in tried[hills[np.argsort(-margin[hills], kind="stable")][:_HILLS]]:
        at, width = float(top), step
        while width > _SETTLED * range_N[1]:
            near = np.linspace(max(at - width, range_N[0]), min(at + width, range_N[1]), _ZOOM)
            at, width = float(near[np.argmax(nearest(near))]), 2.0 * width / (_ZOOM - 1) * 2.0
        ends.append(at)
    return ends[int(np.argmax(nearest(np.array(ends))))]


def _forbidden(
    curve: Callable[[FloatArray], FloatArray],
    excited_Hz: FloatArray,
    margin: float,
    range_N: tuple[float, float],
) -> FloatArray:
    """Return the intervals of preload that the modes of one side, a curve, forbid, cut to the range, shape (n, 2)."""
    least_Hz, most_Hz = (one[:, np.newaxis] for one in curve(np.array(range_N)))
    edges_Hz = np.multiply.outer(excited_Hz, [1.0 - margin, 1.0 + margin])[:, np.newaxis] + 0.0 * least_Hz
    # An interval that goes on beyond the range must not leave its end allowed.
    past_N = 1e-6 * range_N[1]
    found_N = np.where(edges_Hz < least_Hz, range_N[0] - past_N, range_N[1] + past_N)
    inside = (least_Hz <= edges_Hz) & (edges_Hz <= most_Hz)
    wanted_Hz, mode = edges_Hz[inside], np.nonzero(inside)[1]
    if mode.size:
        found_N[inside] = roots_of_cases(
            lambda preload_N: curve(preload_N)[np.arange(mode.size), mode] - wanted_Hz,
            *(np.full(mode.size, end) for end in range_N),
        )
    return found_N[(found_N[..., 0] < range_N[1]) & (found_N[..., 1] > range_N[0])]
