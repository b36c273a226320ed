"""Twisting of the blade as a thin strip: its waves run faster than those of the string."""

import numpy as np

from ropefric.errors import InputError
from ropefric.friction.condition import FloatArray
from ropefric.systems.bandsaw.section import Section
from ropefric.systems.bandsaw.span import Span

__all__ = ["torsion_frequencies_Hz", "torsion_wave_speed_m_s"]


def torsion_wave_speed_m_s(span: Span, section: Section) -> FloatArray:
    """Return c_t = √(F/ρA + 4 (G/ρ)(h/b)²) [m/s], shape (m,).

    The strip's own stiffness G b h³/3 and the tension's, F b²/12 (outer fibres lie askew when it is twisted), over
    the inertia ρ h b³/12.

    Parameters
    ----------
    span : Span
        m cases.
    section : Section
        Width b, thickness h, density ρ and shear modulus G.

    Examples
    --------
    >>> from ropefric.systems.bandsaw.section import STEEL_85_09
    >>> span = Span(free_span_m=1.6, linear_density_kg_m=STEEL_85_09.linear_density_kg_m, preload_N=3412)
    >>> torsion_wave_speed_m_s(span, STEEL_85_09).round(2).tolist()
    [101.41]
    """
    return np.sqrt(span.tension_N / span.linear_density_kg_m + _stiffness_part(section))


def torsion_frequencies_Hz(span: Span, section: Section, n_modes: int = 6) -> FloatArray:
    """Return the first frequencies of torsion f_n = n (c_t² − v²)/(2 l c_t) [Hz], shape (m, n_modes).

    The ends are held against twisting. Parameters as in `torsion_wave_speed_m_s`.

    Raises
    ------
    InputError
        If a blade travels at c_t or above, or `n_modes` is below 1.

    Examples
    --------
    >>> from ropefric.systems.bandsaw.section import STEEL_85_09
    >>> span = Span(free_span_m=1.6, linear_density_kg_m=STEEL_85_09.linear_density_kg_m, preload_N=3412)
    >>> torsion_frequencies_Hz(span, STEEL_85_09, 1).round(2).tolist()
    [[31.69]]
    """
    if n_modes < 1:
        raise InputError(f"{n_modes} modes were asked for", key="n_modes", fix="ask for 1 or more")
    speed = torsion_wave_speed_m_s(span, section)
    squared = span.net_tension_N / span.linear_density_kg_m + _stiffness_part(section)
    beyond = squared <= 0.0
    if beyond.any():
        first = int(np.argmax(beyond))
        raise InputError(
            f"the blade travels at {span.travel_speed_m_s[first]:.9g} m/s{span.place(first)} and the critical speed "
            f"of torsion is {speed[first]:.9g} m/s, where its frequency is zero",
            code="RF530",
            key="travel_speed_m_s",
            fix="run slower, or raise the preload",
        )
    first_Hz = squared / (2.0 * span.free_span_m * speed)
    return np.asarray(first_Hz[:, np.newaxis] * np.arange(1.0, n_modes + 1.0))


def _stiffness_part(section: Section) -> float:
    """Return 4 (G/ρ)(h/b)² [m2/s2]."""
    ratio = section.thickness_m / section.width_m
    return 4.0 * section.shear_modulus_Pa / section.density_kg_m3 * ratio**2
