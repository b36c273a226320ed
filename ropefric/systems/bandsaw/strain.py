"""Which strain force keeps the blade's modes away from what shakes them, if any does."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from ropefric.errors import InputError
from ropefric.systems.bandsaw.inverse import preload_for_N
from ropefric.systems.bandsaw.resonance import Excitation, margins
from ropefric.systems.bandsaw.saw import Saw, Side, frequencies_Hz

_SIDES = (Side.TIGHT, Side.SLACK)
_SEARCHED = 65


class StrainStatus(StrEnum):
    """What is to be done about the preload."""

    KEEP = "keep"
    CHANGE = "change"
    IMPOSSIBLE = "impossible"

    @property
    def advice(self) -> str:
        """Return what the status means and what to do."""
        return {
            StrainStatus.KEEP: "The present preload keeps every mode far enough from every excitation.",
            StrainStatus.CHANGE: "Set the recommended preload: the nearest that keeps the margin.",
            StrainStatus.IMPOSSIBLE: (
                "No preload in the range keeps the margin: as one mode leaves an excitation another arrives. "
                "Change the wheel speed or the free span, accept the best margin, or consider fewer harmonics."
            ),
        }[self]


@dataclass(frozen=True, slots=True, kw_only=True)
class StrainAdvice:
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
    if not 0.0 < margin < 1.0:
        raise InputError(f"the margin is {margin:g}", key="margin", fix="give 0.1 for 10 %")
    if not (0.0 < low_N < high_N and math.isfinite(high_N)):
        raise InputError(
            f"the range is {low_N:g} N to {high_N:g} N; it must be positive and rising", key="range_N"
        )
    forbidden = _union(
        interval
        for side in _SIDES
        for interval in _forbidden(saw, side, excitations, margin=margin, range_N=range_N, n_modes=n_modes)
    )
    shown = tuple((max(start, low_N), min(stop, high_N)) for start, stop in forbidden)
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
    if not allowed:
        best_N = _best(saw, excitations, range_N, n_modes)
        return StrainAdvice(
            status=StrainStatus.IMPOSSIBLE,
            preload_N=best_N,
            margin=_margin_at(saw, excitations, best_N, n_modes),
            forbidden_N=shown,
        )
    nearest_N = min(allowed, key=lambda preload_N: (abs(preload_N - saw.preload_N), preload_N))
    return StrainAdvice(
        status=StrainStatus.KEEP if nearest_N == saw.preload_N else StrainStatus.CHANGE,
        preload_N=nearest_N,
        margin=_margin_at(saw, excitations, nearest_N, n_modes),
        forbidden_N=shown,
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
    intervals = []
    for excitation in excitations:
        for excited_Hz in excitation.frequencies_Hz(saw.speed_m_s).tolist():
            below_Hz, above_Hz = excited_Hz * (1.0 - margin), excited_Hz * (1.0 + margin)
            for mode in range(1, n_modes + 1):
                least_Hz, most_Hz = float(slowest[mode - 1]), float(fastest[mode - 1])
                if most_Hz <= below_Hz or least_Hz >= above_Hz:
                    continue
                start_N = range_N[0] if least_Hz >= below_Hz else preload_for_N(saw, side, below_Hz, mode)
                stop_N = range_N[1] if most_Hz <= above_Hz else preload_for_N(saw, side, above_Hz, mode)
                # An interval that goes on beyond the range must not leave its end allowed.
                past_N = 1e-6 * range_N[1]
                intervals.append(
                    (
                        start_N - past_N if least_Hz > below_Hz else start_N,
                        stop_N + past_N if most_Hz < above_Hz else stop_N,
                    )
                )
    return intervals


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
    return abs(nearest[0].relative) if nearest else math.inf


def _best(saw: Saw, excitations: tuple[Excitation, ...], range_N: tuple[float, float], n_modes: int) -> float:
    tried = np.linspace(*range_N, _SEARCHED).tolist()
    return float(max(tried, key=lambda preload_N: _margin_at(saw, excitations, preload_N, n_modes)))
