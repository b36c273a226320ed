"""A drum that drives or brakes the rope: by a torque, by its share of the pull, or by all the friction it has."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.systems.line.element import Contact, Element, Given, Mu, Passage, Radius
from ropefric.systems.line.elements.bend import resultant_N


@dataclass(frozen=True, kw_only=True)
class Drum(Element):
    """A drum: T_out = T_in − pull, while T_large/T_small stays below e^M."""

    kind: ClassVar[str] = "drum"
    over: ClassVar[str] = "the rope slips on the drum"

    angle_rad: Annotated[float, Given("angle", "over which the rope lies on it.", "rad", "2.5 turn")]
    radius_m: Radius = None
    torque_N_m: Annotated[
        float | None,
        Given("torque", "that drives it, negative where it brakes; all its friction if left out.", "N*m", "150 N*m",
              above=None),
    ] = None  # fmt: skip
    share: Annotated[
        float | None, Given("share", "of the pull of all drums; in place of a torque.", or_zero=True)
    ] = None
    braked: Annotated[
        bool, Given("braked", "whether a drum without torque holds the rope back with all its friction.")
    ] = False
    mu: Mu = None

    def missing(self) -> str:
        """Return what a torque needs, and what to take out where two things are given."""
        if self.torque_N_m is not None and self.share is not None:
            return "either torque or share, not both"
        return (
            'radius = "200 mm", for the torque'
            if self.torque_N_m is not None and self.radius_m is None
            else ""
        )

    @property
    def is_set(self) -> bool:
        """Return whether its pull is given, so that all its friction need not be used."""
        return self.torque_N_m is not None or self.share is not None

    def pull_N(self, passage: Passage) -> FloatArray:
        """Return the pull that is given: its torque over its radius, or its share of all."""
        problem = passage.model.problem
        if self.torque_N_m is not None and self.radius_m is not None:
            return np.full(problem.n, self.torque_N_m / self.radius_m)
        return np.asarray((self.share or 0.0) * problem.product("pull_N"))

    @property
    def _contact(self) -> Contact:
        return Contact(self.angle_rad, self.radius_m, self.mu)

    def exponent(self, passage: Passage, slack_N: FloatArray) -> FloatArray:
        """Return M over the drum."""
        pressing_N = np.where(slack_N > 0.0, slack_N, 1.0)
        found = passage.exponent(self._contact, np.full_like(slack_N, self.angle_rad), pressing_N)
        return np.broadcast_to(found, slack_N.shape)

    def needed_out_N(self, passage: Passage) -> FloatArray:
        """Return the least tension behind it that lets it pull what it is given; inf where it has no friction."""
        pull_N, least_N = self.pull_N(passage), np.ones(passage.model.problem.n)
        for _ in range(100):
            exponent, before_N = self.exponent(passage, least_N), least_N
            # A drum that brakes has the smaller tension before it.
            ratio = np.where(pull_N > 0.0, np.expm1(exponent), -np.expm1(-exponent))
            least_N = np.divide(np.abs(pull_N), ratio, out=np.full_like(ratio, np.inf), where=ratio > 0.0)
            least_N = np.where(pull_N == 0.0, 0.0, least_N)
            if (np.isinf(least_N) | (np.abs(least_N - before_N) <= 1e-14 * least_N)).all():
                break
        return least_N

    def tension_N(self, passage: Passage, known_N: FloatArray) -> FloatArray:
        """Return the tension on its other side: by the pull that is given, else by e^M."""
        if self.is_set:
            return known_N - passage.ways[0] * self.pull_N(passage)
        # The tension is large before a drum that drives, whichever way the rope moves, and behind one that brakes.
        turning = passage.limp()._replace(is_pulled=self.braked)
        return turning.round_bend(known_N, self._contact)

    def numbers(self, passage: Passage, in_N: FloatArray, out_N: FloatArray) -> dict[str, FloatArray]:
        """Return the share of its friction that is used, its pull and torque, the side pressure and the resultant."""
        low_N, high_N = np.minimum(in_N, out_N), np.maximum(in_N, out_N)
        # What friction holds, from the exponent: a difference of two tensions would lose a small one's digits.
        free_N = low_N * np.expm1(self.exponent(passage, low_N))
        pull_N = self.pull_N(passage) if self.is_set else free_N * (-1.0 if self.braked else 1.0)
        asked_N = np.abs(pull_N)
        use = np.divide(asked_N, free_N, out=np.full_like(free_N, np.inf), where=free_N > 0.0)
        found = {"pull_N": pull_N, "utilisation": np.where(asked_N == 0.0, 0.0, use)}
        found["resultant_N"] = resultant_N(self.angle_rad, in_N, out_N)
        if self.radius_m is not None:
            found["normal_N_m"] = np.maximum(high_N, 0.0) / self.radius_m
            found["torque_N_m"] = pull_N * self.radius_m
        return found


ELEMENT = Drum
