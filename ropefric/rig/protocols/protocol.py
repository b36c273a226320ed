"""What a test protocol of the virtual rig is."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol as TypingProtocol

import numpy as np

from ropefric.rig.settings import Bench
from ropefric.rig.truth import RecordingTruth
from ropefric.traces.trace import FloatArray

__all__ = ["RigProtocol", "Story"]


class Story(TypingProtocol):
    """What happens in one recording."""

    @property
    def end_s(self) -> float:
        """The end of the recording [s]."""
        ...

    def force_N(self, time_s: FloatArray) -> FloatArray:
        """Return the true force [N]."""
        ...

    def truth(self) -> RecordingTruth:
        """Return what is true of it."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class RigProtocol:
    """A way of running the rig.

    Attributes
    ----------
    name : str
        The name campaigns use.
    meaning : str
        One line for people.
    scatters_inside : bool
        Whether one recording holds several trials, each with its own scatter.
    measures_lift : bool
        Whether the cell is on the tight side, so that the largest force is F_A.
    draw : callable
        (bench, lift_force_N, end_tension_N, rng) -> Story.
    """

    name: str
    meaning: str
    scatters_inside: bool
    measures_lift: bool
    draw: Callable[[Bench, float, float, np.random.Generator], Story]
