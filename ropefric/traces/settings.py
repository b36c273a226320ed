"""What a user may decide about picking."""

from dataclasses import dataclass

from ropefric.errors import InputError, UnknownNameError
from ropefric.registry import did_you_mean

PEAKS = ("smoothed", "two-line")
ENDINGS = ("sliding", "separation")
SIDES = ("slack", "tight")


@dataclass(frozen=True, slots=True, kw_only=True)
class PickSettings:
    """How F_A is to be picked from a recording."""

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
