"""A straight run: the weight of the rope, its friction on the floor, and the wobble of a duct."""

from dataclasses import dataclass, replace
from typing import Annotated, ClassVar, Self

import numpy as np
from scipy.special import exprel

from ropefric.arrays import FloatArray
from ropefric.friction.integral import exprel_slope
from ropefric.systems.line.element import Element, Given, Mu, Passage, Wobble


@dataclass(frozen=True, kw_only=True)
class Run(Element):
    """A straight run: dT/dx = μ k T + w (sin α + μ |cos α|) where the rope is pulled, −μ where it is paid out."""

    kind: ClassVar[str] = "run"

    length_m: Annotated[float, Given("length", "along the rope.", "m", "30 m")]
    slope_rad: Annotated[
        float, Given("slope", "α, positive uphill from start to end.", "rad", "10 deg", above=None)
    ] = 0.0
    wobble_1_m: Wobble = None
    mu: Mu = None
    carries: Annotated[
        bool, Given("carries", "whether its tension carries the load of a hauling system.")
    ] = False

    @property
    def effects(self) -> frozenset[str]:
        """Return weight, and wobble where it is given."""
        return frozenset({"weight"} if self.wobble_1_m is None else {"weight", "wobble"})

    def turned(self) -> Self:
        """Return the run with the slope that it has from the other end."""
        return replace(self, slope_rad=-self.slope_rad)

    def _rates(self, passage: Passage) -> tuple[FloatArray, FloatArray]:
        """Return μ k L and w L (sin α + μ |cos α|), with the signs they have from the known side on."""
        way, sense = passage.ways
        mu = sense * passage.coefficient(self.mu)
        wobble = self.wobble_1_m if passage.has("wobble") and self.wobble_1_m is not None else 0.0
        slope = np.sin(self.slope_rad) + mu * abs(np.cos(self.slope_rad))
        return way * mu * wobble * self.length_m, way * slope * passage.weight_N_m * self.length_m

    def tension_N(self, passage: Passage, known_N: FloatArray) -> FloatArray:
        """Return T e^z + b (e^z − 1)/z, the solution of dT/dx over the whole run."""
        z, b = self._rates(passage)
        return np.asarray(known_N * np.exp(z) + b * exprel(z))

    def stretch_N_m(self, passage: Passage, known_N: FloatArray) -> FloatArray:
        """Return ∫T dx = L (T (e^z − 1)/z + b (e^z − 1 − z)/z²)."""
        z, b = self._rates(passage)
        return np.asarray(self.length_m * (known_N * exprel(z) + b * (exprel(z) - exprel_slope(z))))


ELEMENT = Run
