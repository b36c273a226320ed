"""A tendon that is stressed and anchored: from both ends, and with what slips at the anchorage.

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


class Stressed(NamedTuple):
    """A tendon as it is stressed from both ends, shape (n,).

    Attributes
    ----------
    sides_N : ndarray, shape (2, k + 1, n)
        Between the elements, from the jack at the start alone and from that at the end; the larger one holds.
    least_N, least_at_m : ndarray
        Where the two sides meet, from the start on.
    elongation_N_m : ndarray, shape (2, n)
        ∫T dx that the jacks at start and end draw out.
    """

    sides_N: FloatArray
    least_N: FloatArray
    least_at_m: FloatArray
    elongation_N_m: FloatArray


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


def stressed(from_start_N: FloatArray, from_end_N: FloatArray, lengths_m: FloatArray) -> Stressed:
    """Return the larger of the tensions that the jacks at both ends make, shape (k + 1, n) each."""
    own, other = np.log(from_start_N), np.log(from_end_N)
    ahead = own - other
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.where(ahead[:-1] == ahead[1:], ahead[:-1] > 0.0, ahead[:-1] / (ahead[:-1] - ahead[1:]))
    shares = np.where(ahead[1:] >= 0.0, 1.0, np.where(ahead[:-1] <= 0.0, 0.0, shares))
    meets = own[:-1] + shares * np.diff(own, axis=0)
    drawn = [
        _integral_N_m(own[:-1], own[1:], shares, lengths_m),
        _integral_N_m(other[1:], other[:-1], 1.0 - shares, lengths_m),
    ]
    least = np.minimum(own[0], np.where(shares > 0.0, meets, np.inf).min(axis=0))
    # Where one jack outdoes the other everywhere, the far end has the least.
    least = np.where(shares.any(axis=0), least, other[0])
    at_m = (shares * lengths_m[:, None]).sum(axis=0)
    return Stressed(np.stack([from_start_N, from_end_N]), np.exp(least), at_m, np.stack(drawn))


def _integral_N_m(
    logs: FloatArray, next_logs: FloatArray, shares: FloatArray, lengths_m: FloatArray
) -> FloatArray:
    """Return ∫T dx over the shares of all elements next to where their tension is large, shape (n,)."""
    falls = shares * (logs - next_logs)
    return np.asarray((shares * lengths_m[:, None] * np.exp(logs - falls) * exprel(falls)).sum(axis=0))


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
