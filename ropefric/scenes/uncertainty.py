"""How uncertain a scene's answer is because its friction was fitted: the fit's covariance, carried through."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError
from ropefric.scenes.kind import Quantity
from ropefric.scenes.scene import FrictionSource
from ropefric.systems.friction import WrapFriction
from ropefric.uncertainty.quantity import directions, quantile

_STEP = 1e-3
"""Of a standard error, for the derivative along a direction: its square is the error of a central difference."""


class Uncertain(NamedTuple):
    """A number of an answer with its uncertainty."""

    name: str
    value: FloatArray
    std: FloatArray
    interval: FloatArray


def known(quantity: Quantity) -> Uncertain:
    """Return a number that no fit makes uncertain."""
    ends = np.stack([quantity.value, quantity.value], axis=-1)
    return Uncertain(quantity.name, quantity.value, np.zeros_like(quantity.value), ends)


def carry_through(
    source: FrictionSource,
    solve: Callable[[WrapFriction], tuple[Quantity, ...]],
    nominal: tuple[Quantity, ...],
    *,
    level: float = 0.95,
) -> tuple[Uncertain, ...]:
    """Return the answer's numbers with their uncertainty, to first order: g C gᵀ.

    The gradient is taken along the principal directions of the covariance, by central differences: two solutions
    a parameter. Forces and coefficients are taken in their logarithm.
    """
    if source.covariance is None:
        return tuple(known(quantity) for quantity in nominal)
    theta, squares = source.friction.theta, [np.zeros_like(quantity.value) for quantity in nominal]
    # A covariance that is not known leaves every number without an error.
    finite = bool(np.isfinite(source.covariance).all())
    columns = directions(source.covariance) if finite else np.zeros((theta.size, 0))
    try:
        for step in _STEP * columns.T[columns.any(axis=0)]:
            ends = zip(
                solve(source.with_theta(theta + step)), solve(source.with_theta(theta - step)), strict=True
            )
            slopes = [(_read(up) - _read(down)) / (2.0 * _STEP) for up, down in ends]
            squares = [square + slope**2 for square, slope in zip(squares, slopes, strict=True)]
    except RopefricError:
        # A law at the edge of where it has an answer has no slope there.
        finite = False
    reach = quantile(0.5 + 0.5 * level, source.dof)
    return tuple(
        _with_std(quantity, np.sqrt(square) if finite else np.full_like(square, np.nan), reach)
        for quantity, square in zip(nominal, squares, strict=True)
    )


def _read(quantity: Quantity) -> FloatArray:
    return np.log(quantity.value) if quantity.positive else quantity.value


def _with_std(quantity: Quantity, std: FloatArray, reach: float) -> Uncertain:
    middle, half = _read(quantity), reach * std
    ends = np.stack([middle - half, middle + half], axis=-1)
    if quantity.positive:
        std, ends = quantity.value * std, np.exp(ends)
    return Uncertain(quantity.name, quantity.value, std, ends)
