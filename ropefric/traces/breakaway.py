"""The break-away of one recording, and the settings of its search."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, fields, is_dataclass
from enum import StrEnum
from math import isnan, nan
from typing import Any

from ropefric.errors import InputError, UnknownNameError
from ropefric.registry import did_you_mean
from ropefric.shown import Shown

ENDINGS = ("sliding", "separation")
SIDES = ("slack", "tight")
RESTS = ("unknown", "zero", "pretension")
PICKERS = ("trained", "highest")

SURE = 0.8
"""Smallest probability of the status `ok` and of a reason for no break-away."""


class Status(StrEnum):
    """Outcome of a recording."""

    OK = "ok"
    DOUBTFUL = "doubtful"
    NO_BREAKAWAY = "no-breakaway"
    NO_PEAK = "no-peak"
    SATURATED = "saturated"
    TOO_SHORT = "too-short"
    UNREADABLE = "unreadable"


ADVICE: dict[Status, str] = {
    Status.OK: "The static peak was found.",
    Status.DOUBTFUL: (
        "More than one thing in this recording may be the break-away, and what was measured does not decide between "
        "them. Look at the candidates and give the trial a pick_s or a peak_N, or exclude it."
    ),
    Status.NO_BREAKAWAY: (
        "This recording shows no slip: the force rises to its end, stays at a quiet level or is let down. If the rope "
        "did slip, name the place with pick_s or peak_N; if not, load it further or record for longer."
    ),
    Status.NO_PEAK: (
        "The rope slides, but no static peak exceeds the sliding force. There may be none for this "
        "pair; or it lies in a gap, in a stretch in which the converter stuck, or between two samples: sample "
        "faster, or let the rope dwell before the pull."
    ),
    Status.SATURATED: (
        "The converter sat at its limit where the peak should be, so the peak is at least that high and "
        "unknown. Use a larger force cell or a lower end tension."
    ),
    Status.TOO_SHORT: "There are too few usable samples to distinguish loading from sliding. Record for longer.",
    Status.UNREADABLE: "The file could not be read; see the problem listed with it.",
}
"""Meaning of each status and what to do about it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Phase:
    """A stretch of a recording: idle, loading, break-away, sliding, held or unloading."""

    name: str
    start_s: float
    end_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceEvent:
    """A fall of the force: a partial slip, snag or impact before the break-away, a stick-slip event, a candidate.

    Attributes
    ----------
    kind : str
        `partial-slip`, `bump`, `slip`, `break-away` or `let-down`.
    time_s, force_N : float
        When the force was highest [s], and how high [N].
    drop_N, fall_s : float
        How far it fell [N] and how long that took [s]; NaN of a candidate that was not measured.
    evidence : str
        Of a candidate, in words: what it hangs on, as whether a drift is taken off.
    probability : float
        Of a candidate: how likely the picker takes it for the break-away, to two digits; NaN where nobody says.
    """

    kind: str
    time_s: float
    force_N: float
    drop_N: float = nan
    fall_s: float = nan
    evidence: str = ""
    probability: float = nan


@dataclass(frozen=True, slots=True, kw_only=True)
class Breakaway(Shown):
    """The break-away force of one trial and what supports it; NaN where there is no such number.

    Attributes
    ----------
    status : Status
        `ok` means `peak_N` may be used; every other status says why not.
    detail : str
        The finding in this recording, with numbers and units.
    peak_N : float
        Static peak F_A of the smoothed trace [N]; for a `held` recording the mean of the plateau.
    probability : float
        How likely the picker takes that place for the break-away, or the status for true, to two digits.
    peak_raw_N : float
        The same before smoothing [N], isolated spikes left out.
    peak_time_s : float
        When [s].
    peak_std_N : float
        Standard uncertainty [N] of picking: noise left after smoothing, the window's bias, what a gap in the
        samples next to the peak may hide, and a zero that drifts or is not quite known.
    bias_N : float
        First-order bias of `peak_N` by smoothing [N]; negative: `peak_N` reads low.
    kinetic_N, kinetic_std_N : float
        Mean and sample standard deviation of the force while sliding [N].
    window_s : float
        Width of the moving average [s].
    noise_std_N : float
        Noise of one sample [N].
    loading_rate_N_s : float
        Slope of the loading just before the peak [N/s].
    kinetic_s : float
        Length of the stretch of sliding `kinetic_N` is taken over [s].
    drop_N, trough_N : float
        Fall from the peak [N], and the lowest force of that slip [N].
    n_slips : int
        Stick-slip events from the break-away on, itself included; 0 where none was found.
    recurrence_s : float
        Median time between neighbouring stick-slip events [s].
    dwell_s : float
        Time of rest before the loading [s].
    rest_N : float
        Force of the rope at rest before the loading, of a recording that was not tared [N].
    end_tension_N, end_tension_std_N : float
        Measured slack tension at the peak and its standard uncertainty [N], where a second channel gives it.
    events : tuple of ForceEvent
        Partial slips, bumps and impacts before the break-away, and every stick-slip event.
    candidates : tuple of ForceEvent
        Possible break-aways, best first, where the status is `doubtful`.
    phases : tuple of Phase
        The phases in time.
    notes : tuple of str
        Remarks: spikes left out, gaps bridged.
    trace : ForceTrace or None
        The recording, where one call found its break-away; a campaign does not keep recordings.

    Examples
    --------
    >>> Breakaway(status=Status.NO_PEAK).advice[:16]
    'The rope slides,'
    """

    _said = (
        "status",
        "peak_N ± peak_std_N",
        "peak_time_s",
        "kinetic_N ± kinetic_std_N",
        "window_s",
        "noise_std_N",
        "loading_rate_N_s",
        "detail",
    )

    status: Status
    detail: str = ""
    peak_N: float = nan
    probability: float = nan
    peak_raw_N: float = nan
    peak_time_s: float = nan
    peak_std_N: float = nan
    bias_N: float = nan
    kinetic_N: float = nan
    kinetic_std_N: float = nan
    window_s: float = nan
    noise_std_N: float = nan
    loading_rate_N_s: float = nan
    kinetic_s: float = nan
    drop_N: float = nan
    trough_N: float = nan
    n_slips: int = 0
    recurrence_s: float = nan
    dwell_s: float = nan
    rest_N: float = nan
    end_tension_N: float = nan
    end_tension_std_N: float = nan
    events: tuple[ForceEvent, ...] = field(default=())
    candidates: tuple[ForceEvent, ...] = field(default=())
    phases: tuple[Phase, ...] = field(default=())
    notes: tuple[str, ...] = field(default=())
    trace: Any = field(default=None, repr=False, compare=False)

    def to_dict(self) -> dict[str, Any]:
        """Return all fields but the recording as plain numbers, words and lists; `None` for NaN."""
        return {one.name: _plain(getattr(self, one.name)) for one in fields(self) if one.name != "trace"}

    def _more_said(self) -> Iterator[tuple[str, str]]:
        return (("note", note) for note in self.notes)

    @property
    def advice(self) -> str:
        """Return what the status means and what to do."""
        return ADVICE[self.status]


def _plain(value: Any) -> Any:
    """Return a value as JSON represents it."""
    if isinstance(value, tuple):
        return [_plain(one) for one in value]
    if is_dataclass(value) and not isinstance(value, type):
        return {name: _plain(one) for name, one in asdict(value).items()}
    if isinstance(value, float) and isnan(value):
        return None
    return str(value) if isinstance(value, StrEnum) else value


@dataclass(frozen=True, slots=True, kw_only=True)
class PickSettings:
    """Settings of the search for F_A."""

    window_s: float | None = None
    start_s: float | None = None
    stop_s: float | None = None
    min_step_N: float | None = None
    ending: str = "sliding"
    side: str = "slack"
    rest: str = "unknown"
    pick_s: float | None = None
    picker: str = "trained"

    def __post_init__(self) -> None:
        for key, known in (("ending", ENDINGS), ("side", SIDES), ("rest", RESTS), ("picker", PICKERS)):
            word = getattr(self, key)
            if word not in known:
                raise UnknownNameError(f"unknown {key} {word!r}", key=key, fix=did_you_mean(str(word), known))
        for key in ("window_s", "min_step_N"):
            value = getattr(self, key)
            if value is not None and not 0 <= value < float("inf"):
                raise InputError(f"{key} = {value} must not be negative", code="RF220", key=key)
        if self.start_s is not None and self.stop_s is not None and not self.start_s < self.stop_s:
            raise InputError(
                f"the part from {self.start_s} s until {self.stop_s} s is empty",
                code="RF220",
                key="until",
                fix="make the end (`until`, `stop_s`) later than the start (`from`, `start_s`)",
            )
