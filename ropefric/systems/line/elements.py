"""The elements of a line: bends, drums, straight runs and wheels."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import exprel

from ropefric.arrays import FloatArray
from ropefric.friction.integral import exprel_slope
from ropefric.systems.line.element import Contact, Element, Passage


@dataclass(frozen=True, kw_only=True)
class Bend(Element):
    """A bend with the wrap θ, to which the wobble of a duct adds k times its length: M = ∫μ over θ + k L."""

    kind: ClassVar[str] = "bend"
    over: ClassVar[str] = "the rope presses on the bend by more than its limit"

    angle_rad: float
    radius_m: float | None = None
    length_m: float | None = None
    wobble_1_m: float | None = None
    mu: float | None = None
    normal_limit_N_m: float | None = None

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
        """Return the side pressure at its tight end, and its share of the limit."""
        if self.radius_m is None:
            return {}
        pressure_N_m = np.maximum(in_N, out_N) / self.radius_m
        limit_N_m = self.normal_limit_N_m
        used = {} if limit_N_m is None else {"utilisation": pressure_N_m / limit_N_m}
        return {"normal_N_m": pressure_N_m} | used


@dataclass(frozen=True, kw_only=True)
class Drum(Element):
    """A drum: T_out = T_in − pull, while T_large/T_small stays below e^M."""

    kind: ClassVar[str] = "drum"
    over: ClassVar[str] = "the rope slips on the drum"

    angle_rad: float
    radius_m: float | None = None
    torque_N_m: float | None = None
    mu: float | None = None

    def missing(self) -> str:
        """Return what a torque needs."""
        lacks = self.torque_N_m is not None and self.radius_m is None
        return 'radius = "200 mm", for the torque' if lacks else ""

    @property
    def pull_N(self) -> float | None:
        """Return the pull that is given by its torque; None where it pulls with all its friction."""
        if self.torque_N_m is None or self.radius_m is None:
            return None
        return self.torque_N_m / self.radius_m

    @property
    def _contact(self) -> Contact:
        return Contact(self.angle_rad, self.radius_m, self.mu)

    def exponent(self, passage: Passage, slack_N: FloatArray) -> FloatArray:
        """Return M over the drum."""
        pressing_N = np.where(slack_N > 0.0, slack_N, 1.0)
        found = passage.exponent(self._contact, np.full_like(slack_N, self.angle_rad), pressing_N)
        return np.broadcast_to(found, slack_N.shape)

    def tension_N(self, passage: Passage, known_N: FloatArray) -> FloatArray:
        """Return the tension on its other side: by the pull that is given, else by e^M."""
        if self.pull_N is not None:
            return known_N - passage.ways[0] * self.pull_N
        # The tension is large before a drum, whichever way the rope moves.
        turning = passage.limp()._replace(is_pulled=False)
        return turning.round_bend(known_N, self._contact)

    def numbers(self, passage: Passage, in_N: FloatArray, out_N: FloatArray) -> dict[str, FloatArray]:
        """Return the share of its friction that is used, its pull and torque, and the side pressure."""
        low_N, high_N = np.minimum(in_N, out_N), np.maximum(in_N, out_N)
        # What friction holds, from the exponent: a difference of two tensions would lose a small one's digits.
        free_N = low_N * np.expm1(self.exponent(passage, low_N))
        pull_N = free_N if self.pull_N is None else np.full_like(free_N, self.pull_N)
        asked_N = np.abs(pull_N)
        use = np.divide(asked_N, free_N, out=np.full_like(free_N, np.inf), where=free_N > 0.0)
        found = {"pull_N": pull_N, "utilisation": np.where(asked_N == 0.0, 0.0, use)}
        if self.radius_m is not None:
            found |= {"normal_N_m": high_N / self.radius_m, "torque_N_m": pull_N * self.radius_m}
        return found


@dataclass(frozen=True, kw_only=True)
class Run(Element):
    """A straight run: dT/dx = μ k T + w (sin α + μ cos α) where the rope is pulled, −μ where it is paid out."""

    kind: ClassVar[str] = "run"

    length_m: float
    slope_rad: float = 0.0
    wobble_1_m: float | None = None
    mu: float | None = None
    carries: bool = False

    @property
    def effects(self) -> frozenset[str]:
        """Return weight, and wobble where it is given."""
        return frozenset({"weight"} if self.wobble_1_m is None else {"weight", "wobble"})

    def _rates(self, passage: Passage) -> tuple[FloatArray, FloatArray]:
        """Return μ k L and w L (sin α + μ cos α), with the signs they have from the known side on."""
        way, sense = passage.ways
        mu = sense * passage.coefficient(self.mu)
        wobble = self.wobble_1_m if passage.has("wobble") and self.wobble_1_m is not None else 0.0
        slope = np.sin(self.slope_rad) + mu * np.cos(self.slope_rad)
        return way * mu * wobble * self.length_m, way * slope * passage.weight_N_m * self.length_m

    def tension_N(self, passage: Passage, known_N: FloatArray) -> FloatArray:
        """Return T e^z + b (e^z − 1)/z, the solution of dT/dx over the whole run."""
        z, b = self._rates(passage)
        return np.asarray(known_N * np.exp(z) + b * exprel(z))

    def stretch_N_m(self, passage: Passage, known_N: FloatArray) -> FloatArray:
        """Return ∫T dx = L (T (e^z − 1)/z + b (e^z − 1 − z)/z²)."""
        z, b = self._rates(passage)
        return np.asarray(self.length_m * (known_N * exprel(z) + b * (exprel(z) - exprel_slope(z))))


@dataclass(frozen=True, kw_only=True)
class Wheel(Element):
    """A pulley: T_out = T_in/η where the rope is pulled, T_in η where it is paid out."""

    kind: ClassVar[str] = "wheel"

    efficiency: float | None = None

    @property
    def effects(self) -> frozenset[str]:
        """Return its bearing, where that is given."""
        return frozenset(() if self.efficiency is None else {"bearing"})

    def tension_N(self, passage: Passage, known_N: FloatArray) -> FloatArray:
        """Return the tension on its other side."""
        efficiency = self.efficiency if passage.has("bearing") and self.efficiency is not None else 1.0
        return known_N / efficiency if passage.rises else known_N * efficiency


ELEMENTS: dict[str, type[Element]] = {one.kind: one for one in (Bend, Drum, Run, Wheel)}
"""Every kind of element by the name that a scene has for it."""
