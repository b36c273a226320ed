"""The first frequencies of a running blade: the string, and the beam by Galerkin's method and by Chebyshev series."""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import partial

import numpy as np
import scipy.linalg

from ropefric.accuracy.study import Case, Measured, Setting, Study, against
from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.bandsaw.beam import ScaledBeam, free_freedoms, galerkin_modes, widths_for
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


def string_frequencies(speed: float, n_modes: int) -> FloatArray:
    """Return the scaled frequencies ω_n = nπ (1 − V²) of a string without stiffness, eq. (8)."""
    return np.asarray(math.pi * (1.0 - speed) * (1.0 + speed) * np.arange(1.0, n_modes + 1.0))


# The beam by Chebyshev series over the whole span: another discretisation, to check the first by. The differential
# equation itself is expanded, in the ultraspherical polynomials that make every derivative a single diagonal (Olver and
# Townsend 2013), so nothing is shared with the weak form: neither the basis nor the integrals nor the eigenproblem.
# Boundary layers need an order of some 3/√ε here, so it is no method for a blade that is nearly a string.
def chebyshev_frequencies(beam: ScaledBeam, order: int, n_modes: int = 6) -> FloatArray:
    """Return the first scaled frequencies ω = 2π f l/c [-], shape (n_modes,).

    (λ² M + λ C + K) a = 0 for the coefficients a of Σ a_j T_j(2x − 1), with λ = iω; the four end conditions give the
    first four coefficients by the others, and the last four equations make room for them. The eigenvalues 1/λ of the
    companion matrix of the reversed problem are taken from the largest on.
    """
    if n_modes < 1 or order < 2 * n_modes + 4:
        raise InputError(
            f"{n_modes} modes need an order of {2 * max(n_modes, 1) + 4} or more, not {order}", key="order"
        )
    size = order + 1
    # Derivatives by x on a span of length 1 are twice those by the series' own variable.
    mass = _raised(np.eye(size), 0)
    travel = _raised(2.0 * beam.speed * 2.0 * _derivative(size, 1), 1)
    tension = _raised(-beam.net * 4.0 * _derivative(size, 2), 2)
    bending = beam.stiffness * 16.0 * _derivative(size, 4)
    inner = _inner_basis(size, turning_ends=beam.ends.turns)
    stiff = (tension + bending)[: size - 4] @ inner
    scale = 1.0 / np.max(np.abs(stiff), axis=0)
    half = size - 4
    right = [travel[:half] @ inner * scale, mass[:half] @ inner * scale]
    companion = np.eye(2 * half, k=-half)
    companion[:half] = -np.linalg.solve(stiff * scale, np.hstack(right))
    inverse = np.asarray(scipy.linalg.eigvals(companion), dtype=np.complex128)
    upper = inverse[inverse.imag < 0.0]
    first = upper[np.argsort(-np.abs(upper))][:n_modes]
    return np.sort((1.0 / first).imag)


def _derivative(size: int, times: int) -> FloatArray:
    """Return the derivative of T series as a series in C^(times): 2^(k−1) (k−1)! j on the k-th diagonal."""
    factor = 2.0 ** (times - 1) * float(np.prod(np.arange(1, times)))
    return np.asarray(np.diag(factor * np.arange(times, size), times))


def _raised(matrix: FloatArray, basis: int) -> FloatArray:
    """Return an operator into C^(basis) as one into C^(4), with C^(0) = T."""
    size = matrix.shape[0]
    for k in range(basis, 4):
        j = np.arange(size)
        if k == 0:
            diagonal = np.where(j == 0, 1.0, 0.5)
            convert = np.diag(diagonal) - np.diag(np.full(size - 2, 0.5), 2)
        else:
            convert = np.diag(k / (k + j)) - np.diag(k / (k + j[2:]), 2)
        matrix = convert @ matrix
    return matrix


def _inner_basis(size: int, *, turning_ends: bool) -> FloatArray:
    """Return the series that meet the end conditions, one a column, shape (size, size − 4)."""
    j = np.arange(size, dtype=np.float64)
    right = j**2 * (j**2 - 1.0) / 3.0 if turning_ends else j**2
    # T_j^(k)(−1) = (−1)^(j+k) T_j^(k)(1): even and odd terms stand apart.
    left_sign = (-1.0) ** j
    rows = np.stack([np.ones(size), left_sign, right, left_sign * right])
    return np.vstack([-np.linalg.solve(rows[:, :4], rows[:, 4:]), np.eye(size - 4)])


def _settings(stiffness: float) -> tuple[Setting, ...]:
    beam, exact = ScaledBeam.at_speed(stiffness, SPEED, CLAMPED), FREQUENCIES[stiffness]
    judged = partial(against, exact)

    def galerkin(
        method: str, layout: Callable[[float], tuple[float, ...]], orders: Sequence[int]
    ) -> Iterable[Setting]:
        def work(_: FloatArray, order: int) -> float:
            return float(free_freedoms(len(layout(order)), order, turning_ends=beam.ends.turns).sum())

        def solve(order: int) -> FloatArray:
            return galerkin_modes(beam, layout(order), order, _N_MODES).frequencies

        return judged(f"Galerkin, {method}", "order {}", solve, over=orders, work=work)

    thin = [order for order in _ORDERS if len(widths_for(beam, order)) > 1]
    chebyshev = partial(chebyshev_frequencies, beam, n_modes=_N_MODES)
    return (
        *judged("string", "", partial(string_frequencies, SPEED, _N_MODES), work=0.0),
        *galerkin("one element", lambda _: (1.0,), _ORDERS),
        *galerkin("thin end elements", partial(widths_for, beam), thin),
        *judged(
            "Chebyshev series", "order {}", chebyshev, over=_CHEBYSHEV_ORDERS, work=lambda _, order: order - 3
        ),
    )


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
    used="Galerkin, the order raised until every mode's own error is small enough",
    cases=(
        Case("moderate", "EI/(F l²) = 1e-2, a short stiff blade", partial(_settings, 1e-2)),
        Case("blade", "EI/(F l²) = 1.2e-4, a band saw of 85 × 0.9 mm on 1.6 m", partial(_settings, 1.2e-4)),
        Case("tiny", "EI/(F l²) = 1e-8: boundary layers of 1e-4 of the span", partial(_settings, 1e-8)),
    ),
    findings=_findings,
)
