"""In what state every contact and span is: between two changes of it the press is a linear system."""

from dataclasses import dataclass

from ropefric.systems.press.transient.model import ElasticPress

STICK, FORWARD, BACKWARD = 0, 1, -1
"""The belt goes with the roller, runs ahead of it (a driven roller slips), or lags behind it (a driver slips)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mode:
    """State of every roller and span."""

    contact: tuple[int, ...]
    turning: tuple[int, ...]
    pressed: tuple[bool, ...]
    taut: tuple[bool, ...]
    strained: tuple[bool, ...]


def sticking(model: ElasticPress) -> Mode:
    """Return the mode of the linear model: no belt slips, all are taut."""
    n_rollers, n_spans = model.incidence.shape
    every = (True,) * n_spans
    return Mode(
        contact=(STICK,) * n_rollers, turning=(1,) * n_rollers, pressed=every, taut=every, strained=every
    )
