"""A wheel that turns on its bearing: it takes a share of the tension, or a fixed force."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from ropefric.arrays import FloatArray
from ropefric.systems.line.element import Element, Given, Passage
from ropefric.systems.line.elements.bend import resultant_N


@dataclass(frozen=True, kw_only=True)
class Wheel(Element):
    """A pulley: T_out = T_in/η + D where the rope is pulled, (T_in − D) η where it is paid out."""

    kind: ClassVar[str] = "wheel"

    efficiency: Annotated[
        float | None, Given("efficiency", "η, the tension that arrives over that which pulls.", at_most=1.0)
    ] = None
    drag_N: Annotated[
        float | None, Given("drag", "D, the force that turns it without load.", "N", "20 N")
    ] = None
    angle_rad: Annotated[
        float | None,
        Given("angle", "over which the rope lies on it; for the force on its axle.", "rad", "180 deg"),
    ] = None

    @property
    def effects(self) -> frozenset[str]:
        """Return its bearing, where that is given."""
        return frozenset({"bearing"} if self.efficiency is not None or self.drag_N is not None else ())

    def tension_N(self, passage: Passage, known_N: FloatArray) -> FloatArray:
        """Return the tension on its other side."""
        efficiency, drag_N = (
            (self.efficiency or 1.0, self.drag_N or 0.0) if passage.has("bearing") else (1.0, 0.0)
        )
        return known_N / efficiency + drag_N if passage.rises else (known_N - drag_N) * efficiency

    def numbers(self, passage: Passage, in_N: FloatArray, out_N: FloatArray) -> dict[str, FloatArray]:  # noqa: ARG002
        """Return the force on its axle."""
        return {} if self.angle_rad is None else {"resultant_N": resultant_N(self.angle_rad, in_N, out_N)}


ELEMENT = Wheel
