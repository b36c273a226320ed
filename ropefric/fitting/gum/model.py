"""A measurement equation: what goes in, how the answer follows from it, and how it answers to each input."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.fitting.gum.quantity import Block, Quantity


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeasurementModel:
    """A measurement equation y = f(x), x the k single quantities and then the q of a block."""

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
