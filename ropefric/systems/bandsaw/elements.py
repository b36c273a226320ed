"""Polynomials on one element of a beam: values and slopes at its ends, and bubbles where both vanish."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError
from ropefric.friction.condition import FloatArray

__all__ = ["Matrices", "assemble", "free_freedoms", "interpolate"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Matrices:
    """What a moving beam of length 1 is made of in some basis φ_1 … φ_k; each (k, k).

    Attributes
    ----------
    mass : ndarray
        ∫ φ_i φ_j.
    travel : ndarray
        ∫ φ_i φ_j' − φ_i' φ_j, skew.
    tension : ndarray
        ∫ φ_i' φ_j'.
    bending : ndarray
        ∫ φ_i'' φ_j''.
    """

    mass: FloatArray
    travel: FloatArray
    tension: FloatArray
    bending: FloatArray


def assemble(widths: tuple[float, ...], order: int, *, turning_ends: bool) -> Matrices:
    """Return the matrices of a span divided into elements, both ends held in place.

    Parameters
    ----------
    widths : tuple of float
        Lengths of the elements, left to right; their sum is 1.
    order : int
        Degree of the polynomials, 3 or more: 3 is Hermite's cubic beam element.
    turning_ends : bool
        Whether the ends may turn; if not, they are clamped.

    Examples
    --------
    >>> pinned = assemble((1.0,), 3, turning_ends=True)
    >>> pinned.bending.tolist()
    [[4.0, 2.0], [2.0, 4.0]]
    """
    value, slope, curvature = _reference(order)
    weights = 2.0 / (2.0 * np.arange(order + 1) + 1.0)
    n_bubbles, n_nodes = order - 3, len(widths) + 1
    size = 2 * n_nodes + n_bubbles * len(widths)
    mass, travel, tension, bending = (np.zeros((size, size)) for _ in range(4))
    blocks = (
        (value * weights) @ value.T,
        (value * weights) @ slope.T - (slope * weights) @ value.T,
        (slope * weights) @ slope.T,
        (curvature * weights) @ curvature.T,
    )
    for element, width in enumerate(widths):
        place = np.ix_(*[_freedoms(element, n_nodes, n_bubbles)] * 2)
        scale = _slope_scale(order, width)
        both = np.outer(scale, scale)
        factors = (0.5 * width, 1.0, 2.0 / width, (2.0 / width) ** 3)
        for whole, block, factor in zip((mass, travel, tension, bending), blocks, factors, strict=True):
            whole[place] += factor * both * block
    kept = np.ix_(*[free_freedoms(len(widths), order, turning_ends=turning_ends)] * 2)
    return Matrices(mass=mass[kept], travel=travel[kept], tension=tension[kept], bending=bending[kept])


def interpolate(
    widths: tuple[float, ...], order: int, values: FloatArray, slopes: FloatArray, curvature: list[FloatArray]
) -> FloatArray:
    """Return the coefficients of a function, whose bending energy and nodal values they keep.

    Parameters
    ----------
    widths, order
        As in `assemble`.
    values, slopes : ndarray, shape (n_elements + 1,)
        At the nodes.
    curvature : list of ndarray, each (order + 1,)
        w'' at the Gauss-Legendre points of each element.

    Returns
    -------
    ndarray
        For all freedoms, the held ones included.

    Examples
    --------
    >>> interpolate((1.0,), 3, np.array([0.0, 1.0]), np.array([1.0, 1.0]), [np.zeros(4)]).tolist()
    [0.0, 1.0, 1.0, 1.0]
    """
    points, weights = np.polynomial.legendre.leggauss(order + 1)
    _, _, basis_curvature = _reference(order)
    at_points = np.polynomial.legendre.legvander(points, order) @ basis_curvature[4:].T
    bubbles = [
        (0.5 * width) ** 2 * (at_points * weights[:, np.newaxis]).T @ values_there
        for width, values_there in zip(widths, curvature, strict=True)
    ]
    nodal = np.stack([values, slopes], axis=1).ravel()
    return np.concatenate([nodal, *bubbles])


def free_freedoms(n_elements: int, order: int, *, turning_ends: bool) -> npt.NDArray[np.bool_]:
    """Return which freedoms are not held at the ends, as a boolean array.

    Examples
    --------
    >>> free_freedoms(1, 4, turning_ends=True).tolist()
    [False, True, False, True, True]
    """
    kept = np.ones(2 * (n_elements + 1) + (order - 3) * n_elements, dtype=np.bool_)
    kept[[0, 2 * n_elements]] = False
    if not turning_ends:
        kept[[1, 2 * n_elements + 1]] = False
    return kept


def _freedoms(element: int, n_nodes: int, n_bubbles: int) -> npt.NDArray[np.intp]:
    first = 2 * n_nodes + n_bubbles * element
    return np.concatenate([np.arange(2 * element, 2 * element + 4), np.arange(first, first + n_bubbles)])


def _slope_scale(order: int, width: float) -> FloatArray:
    scale = np.ones(order + 1)
    scale[[1, 3]] = 0.5 * width
    return scale


@lru_cache(maxsize=128)
def _reference(order: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return value, slope and curvature of the basis on [−1, 1] as Legendre series, each (order + 1, order + 1).

    Bubbles are twice integrated Legendre polynomials, so the bending energy of all of them is a unit matrix:
    nothing is lost to rounding at high order.
    """
    if order < 3:
        raise InputError(f"the order is {order}; a beam element needs 3 or more", key="order")
    value, slope, curvature = (np.zeros((order + 1, order + 1)) for _ in range(3))
    value[0, [0, 1, 3]] = 0.5, -0.6, 0.1
    value[1, :4] = 1 / 6, -0.1, -1 / 6, 0.1
    value[2, [0, 1, 3]] = 0.5, 0.6, -0.1
    value[3, :4] = -1 / 6, -0.1, 1 / 6, 0.1
    slope[0, [0, 2]] = -0.5, 0.5
    slope[1, [1, 2]] = -0.5, 0.5
    slope[2, [0, 2]] = 0.5, -0.5
    slope[3, [1, 2]] = 0.5, 0.5
    curvature[0, 1], curvature[2, 1] = 1.5, -1.5
    curvature[1, :2] = -0.5, 1.5
    curvature[3, :2] = 0.5, 1.5
    for row, k in enumerate(range(2, order - 1), start=4):
        a = np.sqrt(k + 0.5)
        curvature[row, k] = a
        slope[row, [k + 1, k - 1]] = a / (2 * k + 1), -a / (2 * k + 1)
        above, below = (2 * k + 1) * (2 * k + 3), (2 * k + 1) * (2 * k - 1)
        value[row, [k + 2, k, k - 2]] = a / above, -a * (1 / above + 1 / below), a / below
    for table in (value, slope, curvature):
        table.flags.writeable = False
    return value, slope, curvature
