"""The first frequencies of a running blade: the string, and the beam by Galerkin's method and by Chebyshev series."""

import math
from functools import partial

import numpy as np

from ropefric.accuracy.chebyshev import chebyshev_frequencies
from ropefric.accuracy.study import Case, Measured, Setting, Study, against
from ropefric.arrays import FloatArray
from ropefric.systems.bandsaw.beam import ScaledBeam, free_freedoms, galerkin_frequencies, widths_for
from ropefric.systems.bandsaw.span import CLAMPED

SPEED = 0.5
"""V = v/c."""

# 50-digit scaled frequencies of the clamped beam, from the determinant of its end conditions, by ε².
FREQUENCIES = {
    1e-2: (3.4455610832230161724, 8.3378199193847339322, 14.873677077597928472),
    1.2e-4: (2.4222669705200785702, 4.8737338807005549786, 7.3821213474757303083),
    1e-8: (2.3567391530882318598, 4.7134806905377819502, 7.070226996700068828),
}
_N_MODES = 3
_ORDERS = (6, 8, 10, 12, 14, 16, 20, 24, 32, 48)
_CHEBYSHEV_ORDERS = (10, 12, 14, 16, 20, 24, 32, 48, 64, 96)
_QUICK_ORDERS = {8, 12, 16, 24, 32}


def string_frequencies(speed: float, n_modes: int) -> FloatArray:
    """Return the scaled frequencies ω_n = nπ (1 − V²) of a string without stiffness, eq. (8)."""
    return np.asarray(math.pi * (1.0 - speed) * (1.0 + speed) * np.arange(1.0, n_modes + 1.0))


def _settings(stiffness: float) -> tuple[Setting, ...]:
    beam, exact = ScaledBeam.at_speed(stiffness, SPEED, CLAMPED), FREQUENCIES[stiffness]

    def setting(method: str, order: int, call: "partial[FloatArray]", unknowns: int) -> Setting:
        quick = order in {0, *_QUICK_ORDERS}
        return against(exact, method, f"order {order}" if order else "", call, work=unknowns, quick=quick)

    made = [setting("string", 0, partial(string_frequencies, SPEED, _N_MODES), 0)]
    for order in _ORDERS:
        layouts: dict[str, tuple[float, ...]] = {"Galerkin, one element": (1.0,)}
        if len(widths_for(beam, order)) > 1:
            layouts["Galerkin, thin end elements"] = widths_for(beam, order)
        for method, widths in layouts.items():
            size = int(free_freedoms(len(widths), order, turning_ends=beam.ends.turns).sum())
            made.append(
                setting(method, order, partial(galerkin_frequencies, beam, widths, order, _N_MODES), size)
            )
    for order in _CHEBYSHEV_ORDERS:
        call = partial(chebyshev_frequencies, beam, order, _N_MODES)
        made.append(setting("Chebyshev series", order, call, order - 3))
    return tuple(made)


def _findings(points: tuple[Measured, ...]) -> tuple[str, ...]:
    strings = [f"{100 * point.error:.2g} % ({point.case})" for point in points if point.method == "string"]
    if not strings:
        return ()
    return (
        f"The string is off by {', '.join(strings)}.",
        "Galerkin's matrices are kept between calls, as in a sweep over speeds; the first call, untimed, makes them.",
    )


STUDY = Study(
    name="blade-modes",
    title="First three frequencies of a clamped blade running at half its wave speed",
    question="When is the string enough, and which order does the beam need where its ends have boundary layers?",
    reference="root of the determinant of the end conditions in 50-digit arithmetic (mpmath)",
    counted="unknowns",
    used="Galerkin, the order raised until a coarser solution agrees",
    cases=(
        Case("moderate", "EI/(F l²) = 1e-2, a short stiff blade", partial(_settings, 1e-2)),
        Case(
            "blade",
            "EI/(F l²) = 1.2e-4, a band saw of 85 × 0.9 mm on 1.6 m",
            partial(_settings, 1.2e-4),
        ),
        Case("tiny", "EI/(F l²) = 1e-8: boundary layers of 1e-4 of the span", partial(_settings, 1e-8)),
    ),
    findings=_findings,
)
