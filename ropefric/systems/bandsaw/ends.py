"""How the ends of a span are held: what a beam may do there, and at which compression it buckles."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.registry import Registry


@dataclass(frozen=True, slots=True, kw_only=True)
class Ends:
    """A way of holding both ends of a span of length 1."""

    name: str
    meaning: str
    turns: bool
    buckling: float
    buckling_low: float
    buckling_loads: Callable[[int], FloatArray] = field(repr=False)
    buckled: Callable[[FloatArray], tuple[FloatArray, FloatArray, FloatArray]] = field(repr=False)


_PI_SQUARED = (9.869604401089358, 6.265295508739711e-16)


def _pinned_loads(n: int) -> FloatArray:
    return np.square(math.pi * np.arange(1.0, n + 1.0))


def _clamped_loads(n: int) -> FloatArray:
    """Return 4π², 4·4.4934²…, alternating between even buckling, sin(q/2) = 0, and odd, tan(q/2) = q/2."""
    pairs = np.arange(1.0, n // 2 + 2.0)
    middle = (pairs + 0.5) * math.pi
    # tan z = z has its roots just below the odd quarter turns; the iteration gains a digit or more a step.
    z = middle - 1.0 / middle
    for _ in range(30):
        z = middle - np.arctan(1.0 / z)
    both = np.stack([np.square(2.0 * math.pi * pairs), np.square(2.0 * z)], axis=1)
    return np.asarray(both.ravel()[:n])


def _sine(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    pi = math.pi
    return np.sin(pi * x), pi * np.cos(pi * x), -(pi**2) * np.sin(pi * x)


def _raised_cosine(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    q = 2.0 * math.pi
    return 1.0 - np.cos(q * x), q * np.sin(q * x), q**2 * np.cos(q * x)


PINNED = Ends(
    name="pinned",
    meaning="held in place and free to turn",
    turns=True,
    buckling=_PI_SQUARED[0],
    buckling_low=_PI_SQUARED[1],
    buckling_loads=_pinned_loads,
    buckled=_sine,
)
CLAMPED = Ends(
    name="clamped",
    meaning="held in place and in direction, as a blade that runs off a wheel or a guide",
    turns=False,
    buckling=4.0 * _PI_SQUARED[0],
    buckling_low=4.0 * _PI_SQUARED[1],
    buckling_loads=_clamped_loads,
    buckled=_raised_cosine,
)
ENDS: Registry[Ends] = Registry("way of holding the ends", (PINNED, CLAMPED))
"""Every way of holding the ends by name."""
