"""How fine a beam must be divided: its waves, its boundary layers, and the order that resolves both."""

import math
from dataclasses import dataclass

from scipy.special import ive, jv

from ropefric.errors import InputError, SolverError
from ropefric.systems.bandsaw.scaled import ScaledBeam

__all__ = ["MAX_ORDER", "Waves", "order_for", "waves_of", "widths_for"]

MAX_ORDER = 400
"""Highest order that is tried: some 120 modes."""

# A layer element spans e^{-0.8 p}: less than the polynomials of order p on it resolve anyway.
_LAYER_REACH = 0.8
# The middle part is no shorter than the layers.
_WIDEST_LAYER = 1.0 / 3.0
# A layer thinner than the inverse of this takes nothing that a float could show, and its powers stay floats.
_STEEPEST_RATE = 1e60
# Eigenvalues err with the square of the best approximation; how much more was found by experiment.
_SAFETY = {True: 10.0, False: 40.0}


@dataclass(frozen=True, slots=True, kw_only=True)
class Waves:
    """Of what a mode is made: waves e^{ikx} inside, layers e^{−κx} at the ends.

    Attributes
    ----------
    longest, shortest : float
        The two real wave numbers q − m, q + m in amount [-].
    layer_rate : float
        κ [-], the inverse of the boundary layer's thickness, at most 1e60.
    """

    longest: float
    shortest: float
    layer_rate: float


def waves_of(beam: ScaledBeam, mode: int) -> Waves:
    """Return the waves of a mode, closely enough to choose an order by.

    The four wave numbers solve ε²k⁴ + S k² − 2Vωk − ω² = 0: they are m ± q and −m ± iκ. With q given by
    the half waves between the ends, what remains is one equation for m², which has one root in [0, q²].

    Parameters
    ----------
    beam : ScaledBeam
        The beam.
    mode : int
        n = 1, 2, …

    Examples
    --------
    >>> from ropefric.systems.bandsaw.ends import PINNED
    >>> waves = waves_of(ScaledBeam.at_speed(1e-8, 0.6, PINNED), 1)
    >>> round(waves.shortest / math.pi, 4), round(waves.layer_rate)
    (1.6, 8000)
    """
    waves = _waves_between(beam, mode * math.pi)
    if not beam.ends.turns:
        # A clamp turns the phase by arctan(q/κ) at each end: nothing for a string, a quarter wave for a bare beam.
        turn = 2.0 * math.atan2(0.5 * (waves.shortest + waves.longest), waves.layer_rate)
        waves = _waves_between(beam, mode * math.pi + turn)
    return waves


def _waves_between(beam: ScaledBeam, q: float) -> Waves:
    # S + ε²q², written with the margin where S is negative.
    lifted = beam.margin + beam.stiffness * (q**2 - beam.ends.buckling)

    def surplus(m_squared: float) -> float:
        rigid = lifted + beam.stiffness * (q**2 + 2.0 * m_squared)
        moving = beam.speed**2 * (q**2 - m_squared) * (lifted + 3.0 * beam.stiffness * m_squared)
        return moving - m_squared * rigid**2

    low, high = 0.0, q**2
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if surplus(middle) > 0.0 else (low, middle)
    m = math.sqrt(high)
    rate_squared = lifted / beam.stiffness + 2.0 * m**2
    rate = min(math.sqrt(max(rate_squared, 0.0)), _STEEPEST_RATE)
    return Waves(longest=q - m, shortest=q + m, layer_rate=rate)


def widths_for(beam: ScaledBeam, order: int) -> tuple[float, ...]:
    """Return the lengths of the elements: one where the layers are thick, else three with a thin one at each end.

    Examples
    --------
    >>> from ropefric.systems.bandsaw.ends import PINNED
    >>> widths_for(ScaledBeam.at_speed(1e-2, 0.0, PINNED), 20)
    (1.0,)
    >>> [round(width, 6) for width in widths_for(ScaledBeam.at_speed(1e-8, 0.0, PINNED), 20)]
    [0.0016, 0.9968, 0.0016]
    """
    rate = waves_of(beam, 1).layer_rate
    if _LAYER_REACH * order >= _WIDEST_LAYER * rate:
        return (1.0,)
    thin = _LAYER_REACH * order / rate
    return (thin, 1.0 - 2.0 * thin, thin)


def order_for(beam: ScaledBeam, n_modes: int, accuracy: float) -> int:
    """Return the smallest order expected to give the first modes to a relative accuracy.

    A polynomial of degree p leaves J_p(kh/2) of a wave e^{ikx} on an element of length h, and I_p(κh/2) e^{−κh/2}
    of a layer; the eigenvalue errs with the square.

    Parameters
    ----------
    beam : ScaledBeam
        The beam.
    n_modes : int
        How many modes are wanted, 1 or more.
    accuracy : float
        Relative accuracy of every frequency, from 1e-14 to 0.1.

    Raises
    ------
    InputError
        If an argument is outside its range.
    SolverError
        If more than `MAX_ORDER` is needed.

    Examples
    --------
    >>> from ropefric.systems.bandsaw.ends import PINNED
    >>> [order_for(ScaledBeam.at_speed(1e-4, 0.5, PINNED), 6, accuracy) for accuracy in (1e-2, 1e-6, 1e-10)]
    [14, 17, 20]
    """
    if n_modes < 1:
        raise InputError(f"{n_modes} modes were asked for", key="n_modes", fix="ask for 1 or more")
    if not 1e-14 <= accuracy <= 0.1:
        raise InputError(
            f"the accuracy is {accuracy:g}; it must be from 1e-14 to 0.1", key="accuracy", fix="give 1e-10"
        )
    waves = waves_of(beam, n_modes)
    for order in range(n_modes + 3, MAX_ORDER + 1):
        if _expected_error(beam, waves, order) <= accuracy:
            return order
    raise SolverError(
        f"{n_modes} modes need an order above {MAX_ORDER}", key="n_modes", fix="ask for fewer modes"
    )


def _expected_error(beam: ScaledBeam, waves: Waves, order: int) -> float:
    widths = widths_for(beam, order)
    wave = 0.5 * waves.shortest * max(widths)
    # Below its turning point a Bessel function oscillates and tells nothing.
    if order <= wave:
        return math.inf
    layer = 0.5 * waves.layer_rate * min(widths)
    return _SAFETY[beam.ends.turns] * float(jv(order, wave) ** 2 + ive(order, layer) ** 2)
