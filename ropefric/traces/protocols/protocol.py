"""What a protocol is."""

from collections.abc import Callable
from dataclasses import dataclass

from ropefric.traces.breakaway import Breakaway
from ropefric.traces.settings import PickSettings
from ropefric.traces.trace import ForceTrace


@dataclass(frozen=True, slots=True, kw_only=True)
class Protocol:
    """A way of measuring, and how its recordings are read.

    Attributes
    ----------
    name : str
        As in `[protocol] name`.
    description : str
        One line for people.
    pick : callable
        `(trace, settings) -> tuple of Breakaway`, one per trial, at least one.
    measures : {"peak_N", "plateau"}
        Which side of the rope the result belongs to: a break-away force is the lift force F_A itself, a held
        plateau may be either side.
    """

    name: str
    description: str
    pick: Callable[[ForceTrace, PickSettings], tuple[Breakaway, ...]]
    measures: str = "peak_N"
