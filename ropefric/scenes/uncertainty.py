"""How uncertain a scene's answer is because its friction was fitted: the fit's covariance, carried through."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError
from ropefric.fitting.propagation import quantile
from ropefric.scenes.kind import Quantity
from ropefric.scenes.scene import FrictionSource
from ropefric.systems.friction import WrapFriction

_STEP = 1e-3
"""Of a standard error, for the derivative along a direction: its square is the error of a central difference."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Uncertain:
    """A number of an answer with its uncertainty."""

    name: str
    value: FloatArray
    std: FloatArray
    interval: FloatArray


def known(quantity: Quantity) -> Uncertain:
    """Return a number that no fit makes uncertain."""
    return Uncertain(
        name=quantity.name,
        value=quantity.value,
        std=np.zeros_like(quantity.value),
        interval=np.stack([quantity.value, quantity.value], axis=-1),
    )


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
    squares = [np.zeros_like(quantity.value) for quantity in nominal]
    for direction in _directions(source.covariance):
        slopes = _slopes(source, solve, nominal, direction)
        squares = [square + slope**2 for square, slope in zip(squares, slopes, strict=True)]
    reach = quantile(0.5 + 0.5 * level, source.dof)
    return tuple(
        _with_std(quantity, np.sqrt(square), reach) for quantity, square in zip(nominal, squares, strict=True)
    )


def _directions(covariance: FloatArray) -> list[FloatArray]:
    """Return vectors d with C = Σ d dᵀ; one of NaN where the covariance is not known."""
    if not np.isfinite(covariance).all():
        return [np.full(covariance.shape[0], np.nan)]
    scale = np.sqrt(np.where(np.diag(covariance) > 0.0, np.diag(covariance), 1.0))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return [
        scale * vector * np.sqrt(value)
        for value, vector in zip(values, vectors.T, strict=True)
        if value > 0.0
    ]


def _slopes(
    source: FrictionSource,
    solve: Callable[[WrapFriction], tuple[Quantity, ...]],
    nominal: tuple[Quantity, ...],
    direction: FloatArray,
) -> list[FloatArray]:
    if np.isnan(direction).any():
        return [np.full_like(quantity.value, np.nan) for quantity in nominal]
    theta = source.friction.theta
    try:
        up, down = (solve(source.with_theta(theta + sign * _STEP * direction)) for sign in (1.0, -1.0))
    except RopefricError:
        # A law at the edge of where it has an answer has no slope there.
        return [np.full_like(quantity.value, np.nan) for quantity in nominal]
    return [(_read(one) - _read(other)) / (2.0 * _STEP) for one, other in zip(up, down, strict=True)]


def _read(quantity: Quantity) -> FloatArray:
    return np.log(quantity.value) if quantity.positive else quantity.value


def _with_std(quantity: Quantity, std: FloatArray, reach: float) -> Uncertain:
    middle, half = _read(quantity), reach * std
    ends = np.stack([middle - half, middle + half], axis=-1)
    if quantity.positive:
        return Uncertain(
            name=quantity.name, value=quantity.value, std=quantity.value * std, interval=np.exp(ends)
        )
    return Uncertain(name=quantity.name, value=quantity.value, std=std, interval=ends)
