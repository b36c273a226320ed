"""A measurement equation: what goes in, how the answer follows from it, and how it answers to each input."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ropefric.errors import InputError
from ropefric.fitting.gum.quantity import Block, Quantity
from ropefric.friction.condition import FloatArray

__all__ = ["MeasurementModel"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeasurementModel:
    """A measurement equation y = f(x), x the k single quantities and then the q of a block.

    Attributes
    ----------
    name, symbol, unit : str
        Of the answer y.
    quantities : tuple of Quantity
        Independent inputs, k of them.
    block : Block, optional
        Inputs known together, q of them; independent of the others.
    evaluate : callable
        f: (m, k + q) -> (m,); NaN where there is no answer.
    sensitivities : ndarray, shape (k + q,)
        ∂f/∂x at the estimates, analytic.

    Raises
    ------
    InputError
        If the number of sensitivities is wrong, or there is no answer at the estimates.

    Examples
    --------
    >>> from ropefric.fitting.gum.quantity import normal
    >>> area = MeasurementModel(
    ...     name="area", symbol="A", unit="m2", evaluate=lambda x: x[:, 0] * x[:, 1],
    ...     sensitivities=np.array([3.0, 2.0]),
    ...     quantities=(normal("width", "w", "m", 0.1, estimate=2.0), normal("height", "h", "m", 0.1, estimate=3.0)),
    ... )
    >>> area.estimate
    6.0
    """

    name: str
    symbol: str
    unit: str
    quantities: tuple[Quantity, ...]
    evaluate: Callable[[FloatArray], FloatArray]
    sensitivities: FloatArray
    block: Block | None = None

    def __post_init__(self) -> None:
        if self.sensitivities.shape != self.inputs.shape:
            raise InputError(
                f"{self.name}: {self.sensitivities.size} sensitivities for {self.inputs.size} inputs",
                key=self.name,
            )
        if not (np.isfinite(self.estimate) and np.isfinite(self.sensitivities).all()):
            raise InputError(f"{self.name}: there is no answer at the estimates of the inputs", key=self.name)

    @property
    def inputs(self) -> FloatArray:
        """Return the estimates of all inputs, shape (k + q,)."""
        singles = np.array([item.estimate for item in self.quantities])
        return singles if self.block is None else np.concatenate([singles, self.block.estimates])

    @property
    def estimate(self) -> float:
        """Return y at the estimates of the inputs."""
        return float(self.evaluate(self.inputs[np.newaxis, :])[0])

    def draw(self, rng: np.random.Generator, n: int) -> FloatArray:
        """Return the answer to n draws of the inputs, shape (n,); NaN where there is none."""
        columns = [item.draw(rng, n)[:, np.newaxis] for item in self.quantities]
        if self.block is not None:
            columns.append(self.block.draw(rng, n))
        return self.evaluate(np.hstack(columns))
