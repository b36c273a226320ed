"""A force along the rope: a weight that hangs on it, a pusher, a resistance."""

from dataclasses import dataclass, replace
from typing import Annotated, ClassVar, Self

from ropefric.arrays import FloatArray
from ropefric.systems.line.element import Element, Given, Passage


@dataclass(frozen=True, kw_only=True)
class Force(Element):
    """A force by which the tension is larger behind it, whichever way the rope moves."""

    kind: ClassVar[str] = "force"

    force_N: Annotated[
        float, Given("force", "by which the tension is larger behind it.", "N", "200 N", above=None)
    ]

    def turned(self) -> Self:
        """Return the force as it is from the other end."""
        return replace(self, force_N=-self.force_N)

    def tension_N(self, passage: Passage, known_N: FloatArray) -> FloatArray:
        """Return the tension on its other side."""
        return known_N + passage.ways[0] * self.force_N


ELEMENT = Force
