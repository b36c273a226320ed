"""What a user may decide about picking."""

from dataclasses import dataclass

from ropefric.errors import InputError, UnknownNameError
from ropefric.registry import did_you_mean

__all__ = ["ENDINGS", "PEAKS", "SIDES", "PickSettings"]

PEAKS = ("smoothed", "two-line")
ENDINGS = ("sliding", "separation")
SIDES = ("slack", "tight")


@dataclass(frozen=True, slots=True, kw_only=True)
class PickSettings:
    """How F_A is to be picked from a recording.

    Attributes
    ----------
    window_s : float, optional
        Smoothing window [s]; None chooses it from the trace, 0 does not smooth.
    peak : {"smoothed", "two-line"}
        Which estimate becomes `peak_N`: the maximum of the smoothed trace as in the paper, or the corner of two
        fitted lines, which has no smoothing bias.
    start_s, stop_s : float, optional
        Look only at this part of the recording [s].
    min_step_N : float, optional
        Smallest static peak above the sliding force that counts [N]; None lets the noise decide.
    ending : {"sliding", "separation"}
        What follows the peak: the rope slides, or the force falls away for good (pull-off, rope end). After a
        separation there is no kinetic force, and the static peak is the highest one.
    side : {"slack", "tight"}
        Which rope end the cell of a `held` recording sits at.

    Raises
    ------
    InputError, UnknownNameError
        For a value out of range or an unknown word.

    Examples
    --------
    >>> PickSettings(window_s=0.01).peak
    'smoothed'
    """

    window_s: float | None = None
    peak: str = "smoothed"
    start_s: float | None = None
    stop_s: float | None = None
    min_step_N: float | None = None
    ending: str = "sliding"
    side: str = "slack"

    def __post_init__(self) -> None:
        for key, known in (("peak", PEAKS), ("ending", ENDINGS), ("side", SIDES)):
            word = getattr(self, key)
            if word not in known:
                raise UnknownNameError(f"unknown {key} {word!r}", key=key, fix=did_you_mean(str(word), known))
        for key in ("window_s", "min_step_N"):
            value = getattr(self, key)
            if value is not None and not 0 <= value < float("inf"):
                raise InputError(f"{key} = {value} must not be negative", code="RF220", key=key)
        if self.start_s is not None and self.stop_s is not None and not self.start_s < self.stop_s:
            raise InputError(
                f"the part from {self.start_s} s until {self.stop_s} s is empty", code="RF220", key="until"
            )
