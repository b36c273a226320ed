"""A tendon that is stressed and anchored, with what slips at the anchorage.

A tendon has no weight that counts and a coefficient that is the same everywhere, so that ln T falls in proportion to
the length within an element. Where its end is let back by the slip w, friction turns round over a length: behind a
fall of m from the jack the tension was P e^−m and is P e^(m − 2 m_a), and w EA is the integral of the difference.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import exprel

from ropefric.arrays import FloatArray
from ropefric.systems.checks import refuse
from ropefric.systems.roots import roots_of_cases


class Anchored(NamedTuple):
    """A tendon after its end has been let back, shape (n,).

    Attributes
    ----------
    tension_N : ndarray, shape (k + 1, n)
        Between the elements, in the order of the line.
    anchor_N, largest_N : ndarray
        At the anchorage, and where friction turns round.
    affected_m : ndarray
        Length over which the tension falls.
    """

    tension_N: FloatArray
    anchor_N: FloatArray
    largest_N: FloatArray
    affected_m: FloatArray


def anchored(tension_N: FloatArray, lengths_m: FloatArray, slip_N_m: FloatArray) -> Anchored:
    """Return a tendon whose jack at the start, where the tension is largest, has let it back by w; slip_N_m is w EA.

    Where that reaches the other end, the whole tendon slackens.
    """
    falls = np.log(tension_N[0] / tension_N)
    jack_N, whole = tension_N[0], falls[-1]
    reaches = _slip_N_m(falls, lengths_m, whole) * jack_N < slip_N_m
    met = roots_of_cases(
        lambda turn: _slip_N_m(falls, lengths_m, turn) * jack_N - slip_N_m, np.zeros_like(whole), whole
    )
    turns = np.where(reaches, whole, met)
    # Over the whole length: T' = c e^m, whose integral is that of before less w EA.
    steps = np.diff(falls, axis=0)
    rising = (lengths_m[:, None] * np.exp(falls[:-1]) * exprel(steps)).sum(axis=0)
    before = (lengths_m[:, None] * np.exp(-falls[1:]) * exprel(steps)).sum(axis=0) * jack_N
    anchor_N = np.where(reaches, (before - slip_N_m) / rising, jack_N * np.exp(-2.0 * turns))
    refuse(
        anchor_N <= 0.0,
        "the slip of the anchorage takes all the tension out of the tendon",
        code="RF510",
        key="anchorage_slip_m",
        fix="check the slip, the length and the axial stiffness",
    )
    after_N = np.where(reaches | (falls < turns), anchor_N * np.exp(falls), tension_N)
    _, spans_m = _affected(falls, lengths_m, turns)
    largest_N = np.where(reaches, after_N[-1], jack_N * np.exp(-turns))
    return Anchored(after_N, anchor_N, largest_N, spans_m.sum(axis=0))


def _affected(falls: FloatArray, lengths_m: FloatArray, turns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the end of each element's share that lies before where friction turns round, and its length [m]."""
    ends, steps = np.clip(turns, falls[:-1], falls[1:]), np.diff(falls, axis=0)
    shares = np.divide(
        ends - falls[:-1], steps, out=(turns > falls[:-1]).astype(np.float64), where=steps > 0.0
    )
    return ends, shares * lengths_m[:, None]


def _slip_N_m(falls: FloatArray, lengths_m: FloatArray, turns: FloatArray) -> FloatArray:
    """Return ∫(e^−m − e^(m − 2 m_a)) dx up to m_a, shape (n,) [m]."""
    ends, spans_m = _affected(falls, lengths_m, turns)
    left = 2.0 * turns - ends - falls[:-1]
    return np.asarray(
        (spans_m * np.exp(falls[:-1] - 2.0 * turns) * exprel(ends - falls[:-1]) * np.expm1(left)).sum(axis=0)
    )
