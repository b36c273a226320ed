"""The blade as a beam that travels along itself: frequencies to a wanted accuracy, checked after the fact."""

import math
from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import SolverError
from ropefric.systems.bandsaw.ends import CLAMPED, Ends
from ropefric.systems.bandsaw.galerkin import (
    MAX_ORDER,
    ScaledBeam,
    galerkin_frequencies,
    order_for,
    widths_for,
)
from ropefric.systems.bandsaw.span import Span, refuse_overspeed, speed_that_uses_up
from ropefric.systems.bandsaw.string import string_frequencies_Hz

# Two solutions this many orders apart differ by practically all of the coarser one's error.
_CHECK_STEP = 3
# Rounding alone, over many cases of stiffness and speed.
_ROUNDING = 1e-13


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BeamModes:
    """Scaled frequencies with what they cost and what they are worth."""

    frequencies: FloatArray
    order: int
    n_elements: int
    error: float


def solve_beam(beam: ScaledBeam, n_modes: int = 6, *, accuracy: float = 1e-10) -> BeamModes:
    """Return the first frequencies of a scaled beam, with the order raised until a coarser solution agrees."""
    order = order_for(beam, n_modes, accuracy)
    coarse = galerkin_frequencies(beam, widths_for(beam, order), order, n_modes)
    while order + _CHECK_STEP <= MAX_ORDER:
        order += _CHECK_STEP
        widths = widths_for(beam, order)
        fine = galerkin_frequencies(beam, widths, order, n_modes)
        error = float(np.max(np.abs(coarse / fine - 1.0)))
        if error <= max(accuracy, _ROUNDING):
            fine.flags.writeable = False
            return BeamModes(frequencies=fine, order=order, n_elements=len(widths), error=error)
        coarse = fine
    raise SolverError(
        f"{n_modes} modes do not settle to {accuracy:g} up to order {MAX_ORDER}; the last change was {error:g}",
        fix="ask for fewer modes or a larger accuracy",
    )


def scaled_beams(span: Span, ends: Ends) -> list[ScaledBeam]:
    """Return the scaled form of every case of a span that has a stiffness."""
    tension_N, net_N, margin_N = span.tension_N, span.net_tension_N, refuse_overspeed(span, ends)
    stiffness = span.bending_stiffness_N_m2 / (tension_N * span.free_span_m**2)
    speed = np.abs(span.travel_speed_m_s) / span.wave_speed_m_s
    rows = np.stack([stiffness, speed, net_N / tension_N, margin_N / tension_N], axis=1).tolist()
    return [
        ScaledBeam(stiffness=eps2, speed=V, net=net, margin=margin, ends=ends)
        for eps2, V, net, margin in rows
    ]


def beam_frequencies_Hz(
    span: Span, ends: Ends = CLAMPED, n_modes: int = 6, *, accuracy: float = 1e-10
) -> FloatArray:
    """Return the first frequencies of spans as travelling beams; a case without stiffness is a string."""
    stiff = span.bending_stiffness_N_m2 > 0.0
    if not stiff.any():
        return string_frequencies_Hz(span, n_modes)
    refuse_overspeed(span, ends)
    frequencies = np.empty((span.m, n_modes))
    if not stiff.all():
        frequencies[~stiff] = string_frequencies_Hz(span.select(~stiff), n_modes)
    hertz = span.wave_speed_m_s / (2.0 * math.pi * span.free_span_m)
    for case, beam in zip(np.flatnonzero(stiff), scaled_beams(span.select(stiff), ends), strict=True):
        frequencies[case] = hertz[case] * solve_beam(beam, n_modes, accuracy=accuracy).frequencies
    return frequencies


def critical_speeds_m_s(span: Span, ends: Ends, n_modes: int = 1) -> FloatArray:
    """Return the speeds at which a mode's frequency vanishes, v_n² (1 − κ) ρA = F_0 ± ΔF/2 + β_n EI/l².

    Only up to the first of them frequencies are computed; the others say how the string's one critical speed splits.
    """
    load_N = np.multiply.outer(
        ends.buckling_loads(n_modes), span.bending_stiffness_N_m2 / span.free_span_m**2
    )
    return speed_that_uses_up(span.preload_N + span.pull_N + load_N, span).T


def clamped_at_rest_Hz(span: Span, n_modes: int = 6) -> FloatArray:
    """Return the frequencies at rest of a clamped beam that is nearly a string, to second order in e = √(EI/F l²).

    f_n = (n/2l) √(F/ρA) · (1 + 2e + (4 + n²π²/2) e²), shape (m, n_modes); the error goes with e³. A check, and a rule
    for the slide rule: the speed is left out.
    """
    n = np.arange(1.0, n_modes + 1.0)
    e = np.sqrt(span.bending_stiffness_N_m2 / (span.tension_N * span.free_span_m**2))[:, np.newaxis]
    string = n * (span.wave_speed_m_s / (2.0 * span.free_span_m))[:, np.newaxis]
    return np.asarray(string * (1.0 + 2.0 * e + (4.0 + 0.5 * (n * math.pi) ** 2) * e**2))
