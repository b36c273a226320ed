"""A bend, guide, saddle or karabiner that a rope slides over: T_out = T_in e^M."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.systems.line.element import Contact, Element, Given, Length, Mu, Passage, Radius, Wobble


@dataclass(frozen=True, kw_only=True)
class Bend(Element):
    """A bend with the wrap θ, to which the wobble of a duct adds k times its length: M = ∫μ over θ + k L."""

    kind: ClassVar[str] = "bend"
    over: ClassVar[str] = "the rope presses on the bend by more than its limit"

    angle_rad: Annotated[float, Given("angle", "over which the rope lies on it.", "rad", "90 deg")]
    radius_m: Radius = None
    length_m: Length = None
    wobble_1_m: Wobble = None
    mu: Mu = None
    normal_limit_N_m: Annotated[
        float | None, Given("normal_limit", "largest side pressure T/R.", "N/m", "5 kN/m")
    ] = None

    @property
    def effects(self) -> frozenset[str]:
        """Return wobble and bending stiffness, where their data are given."""
        given = {"wobble": self.wobble_1_m, "bending-stiffness": self.radius_m}
        return frozenset(name for name, value in given.items() if value is not None)

    def missing(self) -> str:
        """Return what a limit or a wobble needs beside itself."""
        if self.normal_limit_N_m is not None and self.radius_m is None:
            return 'radius = "300 mm", for the limit of the side pressure'
        return "" if self.wobble_1_m is None or self.stretching_m else 'length = "2 m", for the wobble'

    @property
    def stretching_m(self) -> float:
        """Return its length, or that of its arc [m]."""
        return self.length_m or self.angle_rad * (self.radius_m or 0.0)

    def _contact(self, passage: Passage) -> Contact:
        wobble = self.wobble_1_m if passage.has("wobble") and self.wobble_1_m is not None else 0.0
        return Contact(self.angle_rad + wobble * self.stretching_m, self.radius_m, self.mu)

    def tension_N(self, passage: Passage, known_N: FloatArray) -> FloatArray:
        """Return T e^M on its tight side, T e^−M on its slack side."""
        return passage.round_bend(known_N, self._contact(passage))

    def stretch_N_m(self, passage: Passage, known_N: FloatArray) -> FloatArray:
        """Return ∫T dx = L (E + P mean of e^M); of a rope that pushes L T."""
        slack_N, bend = known_N if passage.rises else self.tension_N(passage, known_N), self._contact(passage)
        pulls = slack_N > 0.0
        if not self.stretching_m or not pulls.any():
            return self.stretching_m * slack_N
        stiff_N, pressing_N, contact = passage.pressing(np.where(pulls, slack_N, 1.0), bend)
        mean_N = stiff_N + pressing_N * passage.mean_growth(bend, contact, pressing_N)
        return np.asarray(self.stretching_m * np.where(pulls, mean_N, slack_N))

    def numbers(self, passage: Passage, in_N: FloatArray, out_N: FloatArray) -> dict[str, FloatArray]:  # noqa: ARG002
        """Return the side pressure at its tight end, its share of the limit, and what the rope pulls the bend with."""
        found = {"resultant_N": resultant_N(self.angle_rad, in_N, out_N)}
        if self.radius_m is not None:
            found["normal_N_m"] = np.maximum(np.maximum(in_N, out_N), 0.0) / self.radius_m
            if self.normal_limit_N_m is not None:
                found["utilisation"] = found["normal_N_m"] / self.normal_limit_N_m
        return found


def resultant_N(angle_rad: float, in_N: FloatArray, out_N: FloatArray) -> FloatArray:
    """Return what the tensions of both sides of a wrap pull with together [N]; of 180° it is their sum."""
    half = np.square(np.sin(0.5 * angle_rad))
    return np.asarray(np.sqrt((in_N - out_N) ** 2 + 4.0 * in_N * out_N * half))


ELEMENT = Bend
