"""What a fault of the virtual rig is: something that goes wrong, where, and what an honest reading makes of it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ropefric.errors import InputError
from ropefric.rig.protocols.protocol import Story
from ropefric.rig.sensing import Sensor
from ropefric.rig.settings import Bench
from ropefric.rig.story import BreakawayStory
from ropefric.traces.breakaway import Status
from ropefric.traces.trace import FloatArray

__all__ = ["Fault", "Samples", "Setup", "breakaway_story", "near"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """What happens in a recording and what measures it.

    Attributes
    ----------
    story : Story
        The mechanics.
    sensor : Sensor
        The measuring chain.
    """

    story: Story
    sensor: Sensor


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Samples:
    """What the logger wrote.

    Attributes
    ----------
    time_s, counts : ndarray, shape (n,)
        Time stamps [s] and counts, NaN where missing.
    """

    time_s: FloatArray
    counts: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """Something that goes wrong in a recording; acts on the mechanics, on the samples or on the file.

    Attributes
    ----------
    name : str
        What truth files call it.
    meaning : str
        One line for people.
    expected_status : Status or None
        Status an honest reading must end in; None: the fault must not change it.
    rate : float
        Fraction of recordings it befalls in the default mix.
    protocols : tuple of str
        Protocols it can befall; empty for all.
    on_setup, on_samples, on_bytes : callable, optional
        (setup, bench, rng) -> Setup; (samples, setup, rng) -> Samples; (bytes, rng) -> bytes. New objects come
        back, the old ones stay as they were.
    """

    name: str
    meaning: str
    expected_status: Status | None
    rate: float
    protocols: tuple[str, ...] = ()
    on_setup: Callable[[Setup, Bench, np.random.Generator], Setup] | None = None
    on_samples: Callable[[Samples, Setup, np.random.Generator], Samples] | None = None
    on_bytes: Callable[[bytes, np.random.Generator], bytes] | None = None


def breakaway_story(setup: Setup, fault: str) -> BreakawayStory:
    """Return the break-away story a fault wants to change.

    Raises
    ------
    InputError
        If the recording follows another protocol.
    """
    if not isinstance(setup.story, BreakawayStory):
        raise InputError(
            f"fault '{fault}' changes a break-away, and this recording has none",
            key="faults",
            fix="leave it out, or use protocol 'breakaway'",
        )
    return setup.story


def near(time_s: FloatArray, setup: Setup, within_s: float) -> tuple[int, int]:
    """Return first and one past last sample index within some time of the break-away; (0, 0) if there is none."""
    peak_s = setup.story.truth().breakaway_time_s
    if not np.isfinite(peak_s):
        return 0, 0
    first, last = np.searchsorted(time_s, (peak_s - within_s, peak_s + within_s)).tolist()
    return first, last
