"""Where modes of the blade meet excitations: over the speed, at work, and which preload keeps them apart."""

import math
from collections.abc import Callable
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev
from scipy.optimize import brentq, minimize_scalar

from ropefric.arrays import FloatArray, frozen_array
from ropefric.files.plain_text import significant
from ropefric.glossary import AdvisedStatus
from ropefric.systems.bandsaw.answer import SawModel, SawProblem, frequencies_Hz
from ropefric.systems.bandsaw.saw import Excitation, Side
from ropefric.systems.roots import roots_of_cases

_SIDES = (Side.TIGHT, Side.SLACK)


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


def work_speed_m_s(problem: SawProblem) -> float:
    """Return the blade's speed at work; 0 where the wheels are not known."""
    return 0.0 if problem.speed_m_s is None else float(problem.speed_m_s[0])


_interpolate: Callable[[Callable[[FloatArray], FloatArray], int], Any] = chebyshev.chebinterpolate
"""Of many columns at once, which its types do not say."""
_DEGREES = (12, 24, 48, 96)
_SQUARED_ERROR = 1e-11
"""Of an interpolated f²: a tenth of the accuracy of the frequencies that it is made from."""


def modes_over(
    model: SawModel, side: Side, n_modes: int, what: str, *, ends: tuple[float, float]
) -> Callable[[FloatArray], FloatArray]:
    """Return the frequencies as a function of "speed_m_s" or "preload_N" between two ends, shape (m, n_modes) [Hz].

    A string's have a closed form. For a beam f² is a smooth function of v² and of F_0, up to the critical speed and
    through it, so it is interpolated at Chebyshev's points; their number is doubled until the last terms are nothing.
    """

    def exact(at: FloatArray) -> FloatArray:
        changed: dict[str, Any] = {what: at}
        return frequencies_Hz(model, side, n_modes, **changed)

    stiff = model.part("bending", model.problem.bending_stiffness_N_m2).any()
    if not stiff or not ends[0] < ends[1]:
        return exact
    power = 2.0 if what == "speed_m_s" else 1.0
    low, high = (end**power for end in ends)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    for degree in _DEGREES:
        table: FloatArray = _interpolate(lambda x: exact((middle + half * x) ** (1.0 / power)) ** 2, degree)
        if (np.abs(table[-2:]) <= _SQUARED_ERROR * np.abs(table[0])).all():
            return lambda at: np.sqrt(chebyshev.chebval((np.asarray(at) ** power - middle) / half, table)).T
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
    model: SawModel,
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
    work_m_s = work_speed_m_s(model.problem)
    curve = modes_over(model, side, n_modes, "speed_m_s", ends=(float(ends[0]), float(ends[1])))
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
        apart = speed / work_m_s - 1.0 if work_m_s > 0.0 else np.inf
        found.append(Crossing(side, mode, excitation.name, harmonic, speed, meets_Hz, apart))
    return in_order(found)


def in_order(crossings: list[Crossing]) -> tuple[Crossing, ...]:
    """Return crossings by speed. On a string mode n meets n turns at one speed: rounding must not order them."""
    return tuple(sorted(crossings, key=lambda one: (significant(one.speed_m_s), one.mode, one.harmonic)))


def margins(
    model: SawModel, sides: tuple[Side, ...], excitations: tuple[Excitation, ...], n_modes: int = 6
) -> tuple[Margin, ...]:
    """Return how far every mode is from every excitation at the speed at work, the nearest first."""
    excited_Hz, found = _excited_Hz(excitations, work_speed_m_s(model.problem)).tolist(), []
    for side in sides:
        modes_Hz = frequencies_Hz(model, side, n_modes)[0].tolist()
        for (mode, own_Hz), ((cause, harmonic), its_Hz) in product(
            enumerate(modes_Hz, start=1), zip(_harmonics(excitations), excited_Hz, strict=True)
        ):
            if its_Hz > 0.0:
                found.append(Margin(side, mode, cause.name, harmonic, own_Hz, its_Hz, own_Hz / its_Hz - 1.0))
    return tuple(sorted(found, key=lambda one: (significant(abs(one.margin)), one.mode, one.harmonic)))


class SawChart(NamedTuple):
    """The data of a Campbell chart."""

    work_m_s: float
    speed_m_s: FloatArray
    mode_Hz: dict[Side, FloatArray]
    excitations: tuple[Excitation, ...]
    crossings: tuple[Crossing, ...]


def saw_chart(
    model: SawModel, excitations: tuple[Excitation, ...], speeds_m_s: npt.ArrayLike, n_modes: int = 4
) -> SawChart:
    """Return the data of a Campbell chart of both sides at constant torque."""
    speeds, found, modes_Hz = frozen_array(speeds_m_s), list[Crossing](), {}
    ends = (float(speeds[0]), float(speeds[-1]))
    for side in _SIDES:
        found += find_crossings(model, side, excitations, speeds, n_modes)
        modes_Hz[side] = modes_over(model, side, n_modes, "speed_m_s", ends=ends)(speeds)
    return SawChart(work_speed_m_s(model.problem), speeds, modes_Hz, excitations, in_order(found))


_TRIED = 2001
"""Preloads that are tried between the ends of the range."""
_HAIR = 1e-9
"""Of a margin: what is set to a recommended preload keeps it."""


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


def recommend_preload(
    model: SawModel,
    excitations: tuple[Excitation, ...],
    *,
    margin: float,
    range_N: tuple[float, float],
    n_modes: int = 6,
) -> StrainAdvice:
    """Return the preload nearest to the present one at which all modes of both sides keep a margin."""
    excited_Hz = _excited_Hz(excitations, work_speed_m_s(model.problem))
    curves = [modes_over(model, side, n_modes, "preload_N", ends=range_N) for side in _SIDES]

    def nearest(preload_N: npt.ArrayLike) -> FloatArray:
        """Return the smallest margin at preloads within the range."""
        of_modes = np.concatenate([curve(np.atleast_1d(preload_N)) for curve in curves], axis=1)
        apart = np.abs(of_modes[..., np.newaxis] / excited_Hz[excited_Hz > 0.0] - 1.0)
        return np.asarray(apart.min(axis=(1, 2), initial=np.inf))

    def advice(status: StrainStatus, preload_N: float) -> StrainAdvice:
        return StrainAdvice(status, preload_N, float(nearest(preload_N)[0]))

    present_N, wanted = float(model.problem.preload_N[0]), margin - _HAIR
    if range_N[0] <= present_N <= range_N[1] and nearest(present_N)[0] >= wanted:
        return advice(StrainStatus.KEEP, present_N)
    tried_N = np.linspace(*range_N, _TRIED)
    margins_there = nearest(tried_N)
    allowed = np.flatnonzero(margins_there >= wanted)
    if not allowed.size:
        best, step_N = tried_N[np.argmax(margins_there)], (range_N[1] - range_N[0]) / (_TRIED - 1)
        ends_N = max(best - step_N, range_N[0]), min(best + step_N, range_N[1])
        found = minimize_scalar(
            lambda one: -nearest(one)[0], bounds=ends_N, method="bounded", options={"xatol": 1e-6}
        )
        return advice(StrainStatus.IMPOSSIBLE, float(found.x))
    first = int(allowed[np.argmin(np.abs(tried_N[allowed] - present_N))])
    before = first + (1 if present_N > tried_N[first] else -1)
    at_N = float(tried_N[first])
    if (
        0 <= before < _TRIED and margins_there[before] < wanted
    ):  # the ends of the range may be what is nearest
        at_N = float(brentq(lambda one: nearest(one)[0] - margin, at_N, tried_N[before]))
    return advice(StrainStatus.CHANGE, at_N)
