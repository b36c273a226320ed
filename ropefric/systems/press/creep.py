"""Elastic creep: how fast the rims of a press run, and how belts that run together share their tension.

A belt runs with v_b (1 + T/EA), T with its ρAv². It sticks to a roller where it arrives, so that the roller's rim runs
as fast as the belt in the span before it. Belts that run together stick to each other too: with their shares of T,

    v = Σ EA / Σ (EA/v_b) · (1 + T/Σ EA).

The first driver turns as fast as the scene says. The v_b of one belt after the other follows from the rollers where
belts meet, as in the closures of `statics`; so the speed that another driver must have follows from the tensions.
A belt with n spans loses v_b/(2 EA) Σ (T_i − T_i−1)² of the drivers' power.
"""

from itertools import pairwise, product
from typing import Literal, TypeAlias

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.systems.press.machine import Press

_Side: TypeAlias = Literal["start", "end"]


def tension_row(press: Press, roller: str, belt: str, side: _Side = "end") -> FloatArray:
    """Return 1 for the span in which a belt reaches a roller ("end"), or leaves it ("start"), else 0."""
    return np.array([float(getattr(span, side) == roller and belt in span.belts) for span in press.spans])


def belts_alone(press: Press, side: _Side = "end") -> list[tuple[str, str, str]]:
    """Return (roller, belt, next belt) wherever belts of one roller are alone in their spans on one side of it."""
    alone = {(getattr(span, side), span.belts) for span in press.spans}
    on = {
        one.name: [belt.name for belt in press.belts if (one.name, (belt.name,)) in alone]
        for one in press.rollers
    }
    return [(roller, *pair) for roller, belts in on.items() for pair in pairwise(belts)]


def _speeds(press: Press, tension_N: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return v of every span and v_b of every belt over the first driver's, shapes (..., n_spans) and (..., n_belts)."""
    stiffness_N = _stiffness_N(press)
    together_N = stiffness_N @ press.carried
    stretched = 1.0 + tension_N / together_N
    driver = press.drivers[0].name
    first = press.belts_on(driver)[0].name
    unstrained = {first: 1.0 / (stretched @ tension_row(press, driver, first))}
    for _, (roller, *pair) in product(press.belts, belts_alone(press)):
        for one, other in (pair, pair[::-1]):
            if one in unstrained and other not in unstrained:
                pace, follows = (stretched @ tension_row(press, roller, belt) for belt in (one, other))
                unstrained[other] = unstrained[one] * pace / follows
    # A belt that never meets another alone keeps to the first one's pace.
    paces = np.stack([unstrained.get(belt.name, unstrained[first]) for belt in press.belts], axis=-1)
    by_span = together_N / ((stiffness_N / paces) @ press.carried) * stretched
    return by_span, paces


def _stiffness_N(press: Press) -> FloatArray:
    return np.array([belt.axial_stiffness_N for belt in press.belts], dtype=np.float64)


def rim_speed_ratios(press: Press, tension_N: FloatArray) -> FloatArray:
    """Return each rim's speed over the first driver's, shape (..., n_rollers), from T, shape (..., n_spans).

    1 where the EA of a belt is not known.
    """
    if np.isnan(_stiffness_N(press)).any():
        return np.ones((*tension_N.shape[:-1], len(press.rollers)))
    return np.asarray(_speeds(press, tension_N)[0][..., np.argmax(press.into, axis=1)])


def own_tensions_N(press: Press, tension_N: FloatArray) -> FloatArray:
    """Return the tension of each belt in the spans it runs in, shape (..., n_belts, n_spans); T where it is alone."""
    by_span, paces = _speeds(press, tension_N)
    strain = by_span[..., np.newaxis, :] / paces[..., np.newaxis] - 1.0
    alone = press.carried.sum(axis=0) == 1.0
    return np.where(alone, tension_N[..., np.newaxis, :], _stiffness_N(press)[:, np.newaxis] * strain)
