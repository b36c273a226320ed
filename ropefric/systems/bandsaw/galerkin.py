"""The moving beam's frequencies from its weak form, as a Hermitian eigenproblem that cannot but give real ones."""

from functools import lru_cache

import numpy as np
import scipy.linalg

from ropefric.errors import InputError, SolverError
from ropefric.friction.condition import FloatArray
from ropefric.systems.bandsaw.elements import Matrices, assemble, free_freedoms, interpolate
from ropefric.systems.bandsaw.scaled import ScaledBeam

__all__ = ["galerkin_frequencies"]

# Below this share of its parts the margin no longer survives in the stiffness matrix by itself.
_NEAR_CRITICAL = 0.1


def galerkin_frequencies(beam: ScaledBeam, widths: tuple[float, ...], order: int, n_modes: int) -> FloatArray:
    """Return the first scaled frequencies ω = 2π f l/c [-], shape (n_modes,).

    With w = Re Σ q_j φ_j e^{iωτ} the weak form is (K + iωG − ω²M) q = 0, K = S K_2 + ε² K_4 positive below the
    critical speed and G skew. In the energy norms of K and M it is the eigenproblem of a skew matrix; the one of
    its inverse gives the small frequencies to full relative precision and needs neither M⁻¹ nor large numbers. A
    Rayleigh quotient then makes the error of every mode quadratic in its vector's.

    Parameters
    ----------
    beam : ScaledBeam
        The beam.
    widths : tuple of float
        Lengths of the elements, see `widths_for`.
    order : int
        Degree of the polynomials on each element.
    n_modes : int
        Up to the number of freedoms.

    Raises
    ------
    InputError
        If there are fewer freedoms than modes.
    SolverError
        If the stiffness is not positive in floats.

    Examples
    --------
    >>> from ropefric.systems.bandsaw.ends import PINNED
    >>> galerkin_frequencies(ScaledBeam.at_speed(1e-2, 0.5, PINNED), (1.0,), 20, 2).round(9).tolist()
    [2.647332318, 6.567103155]
    """
    turning = beam.ends.turns
    parts = _assembled(widths, order, turning)
    size = parts.mass.shape[0]
    if not 1 <= n_modes <= size:
        raise InputError(
            f"{n_modes} modes of {size} freedoms", key="n_modes", fix="ask for fewer modes or a higher order"
        )
    if beam.margin < _NEAR_CRITICAL * abs(beam.net):
        parts, stiffness = _near_critical(beam, parts, widths, order)
    else:
        stiffness = beam.net * parts.tension + beam.stiffness * parts.bending
    scale = 1.0 / np.sqrt(np.diag(stiffness))
    both = np.outer(scale, scale)
    gyroscopic = beam.speed * parts.travel * both
    try:
        lower = np.asarray(np.linalg.cholesky(stiffness * both), dtype=np.float64)
        root = np.asarray(np.linalg.cholesky(parts.mass * both), dtype=np.float64)
    except np.linalg.LinAlgError:
        raise SolverError(
            f"the beam's stiffness is lost in rounding at order {order} on {len(widths)} elements",
            fix="use a lower order",
        ) from None
    return _positive_frequencies(lower, gyroscopic, root, n_modes)


def _positive_frequencies(
    lower: FloatArray, gyroscopic: FloatArray, root: FloatArray, n_modes: int
) -> FloatArray:
    """Return the smallest ω of L Lᵀ + iωG − ω² R Rᵀ."""
    size = lower.shape[0]
    half = scipy.linalg.solve_triangular(lower, gyroscopic, lower=True)
    turned = scipy.linalg.solve_triangular(lower, half.T, lower=True).T
    turned = 0.5 * (turned - turned.T)
    coupling = scipy.linalg.solve_triangular(lower, root, lower=True)
    hermitian = np.zeros((2 * size, 2 * size), dtype=np.complex128)
    hermitian[:size, :size] = -1j * turned
    hermitian[:size, size:] = -1j * coupling
    hermitian[size:, :size] = 1j * coupling.T
    _, vectors = scipy.linalg.eigh(hermitian, subset_by_index=[2 * size - n_modes, 2 * size - 1])
    energy_part = vectors[:size, ::-1]
    shape = scipy.linalg.solve_triangular(lower, energy_part, lower=True, trans="T")
    mass = np.sum(np.abs(root.T @ shape) ** 2, axis=0)
    stiffness = np.sum(np.abs(energy_part) ** 2, axis=0)
    gyration = -np.sum(shape.conj() * (1j * (gyroscopic @ shape)), axis=0).real
    # −ω²m − gω + k = 0 for g as it stands here; the root without cancellation for either sign of g.
    swing = np.hypot(gyration, 2.0 * np.sqrt(mass * stiffness))
    with np.errstate(divide="ignore", invalid="ignore"):
        frequencies = np.where(
            gyration > 0.0, 2.0 * stiffness / (swing + gyration), (swing - gyration) / (2.0 * mass)
        )
    return np.sort(frequencies)


def _near_critical(
    beam: ScaledBeam, parts: Matrices, widths: tuple[float, ...], order: int
) -> tuple[Matrices, FloatArray]:
    """Return the matrices in a basis that has the buckling mode in it, and the stiffness there.

    S K_2 + ε² K_4 = (−β K_2 + K_4) ε² + margin · K_2. The bracket times the buckling mode is exactly zero and is made
    so, which lets the margin stand by itself on the mode's own diagonal, however small it is.
    """
    buckled = _buckling_mode(beam, widths, order)
    replaced = int(np.argmax(np.abs(buckled) * np.sqrt(np.diag(parts.bending))))
    basis = np.eye(buckled.size)
    basis[:, replaced] = buckled
    mass, travel, tension, bending = (
        basis.T @ matrix @ basis for matrix in (parts.mass, parts.travel, parts.tension, parts.bending)
    )
    travel[replaced, replaced] = 0.0
    critical = beam.stiffness * (bending - beam.ends.buckling * tension)
    critical[replaced, :] = 0.0
    critical[:, replaced] = 0.0
    changed = Matrices(mass=mass, travel=travel, tension=tension, bending=bending)
    return changed, critical + beam.margin * tension


def _buckling_mode(beam: ScaledBeam, widths: tuple[float, ...], order: int) -> FloatArray:
    nodes = np.concatenate([[0.0], np.cumsum(widths)])
    values, slopes, _ = beam.ends.buckled(nodes)
    points, _ = np.polynomial.legendre.leggauss(order + 1)
    inside = [
        beam.ends.buckled(start + 0.5 * width * (1.0 + points))[2]
        for start, width in zip(nodes[:-1], widths, strict=True)
    ]
    whole = interpolate(widths, order, values, slopes, inside)
    return np.asarray(whole[free_freedoms(len(widths), order, turning_ends=beam.ends.turns)])


@lru_cache(maxsize=64)
def _assembled(widths: tuple[float, ...], order: int, turning_ends: bool) -> Matrices:  # noqa: FBT001
    parts = assemble(widths, order, turning_ends=turning_ends)
    for matrix in (parts.mass, parts.travel, parts.tension, parts.bending):
        matrix.flags.writeable = False
    return parts
