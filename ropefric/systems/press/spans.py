"""From loops of rollers to spans: the graph every equation of a press is written on."""

from collections.abc import Sequence
from dataclasses import dataclass

from ropefric.systems.press.parts import Belt

__all__ = ["Span", "spans_of"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Span:
    """A piece of belt from one roller to the next; where belts run together it carries all of them.

    Attributes
    ----------
    name : str
        Its name; its tension is the force of all its belts together.
    start, end : str
        The rollers it leaves and reaches, in the direction of travel.
    belts : tuple of str
        The belts that run in it.

    Examples
    --------
    >>> Span(name="5", start="5", end="6", belts=("upper", "lower")).end
    '6'
    """

    name: str
    start: str
    end: str
    belts: tuple[str, ...]


def spans_of(belts: Sequence[Belt], names: Sequence[str] | None = None) -> tuple[Span, ...]:
    """Return the spans in the order of the first belt's loop, then what the second adds, and so on.

    Parameters
    ----------
    belts : sequence of Belt
        The belts.
    names : sequence of str, optional
        One name a span; by default they are numbered from 1.

    Returns
    -------
    tuple of Span
        A step from one roller to the next that several belts take in the same direction is one span.

    Examples
    --------
    >>> data = {"linear_density_kg_m": 1.0, "thickness_m": 0.005, "width_m": 1.0}
    >>> upper = Belt(name="upper", loop=("1", "2", "3"), **data)
    >>> lower = Belt(name="lower", loop=("3", "4", "2"), **data)
    >>> [(span.name, span.start, span.end, len(span.belts)) for span in spans_of([upper, lower])]
    [('1', '1', '2', 1), ('2', '2', '3', 2), ('3', '3', '1', 1), ('4', '3', '4', 1), ('5', '4', '2', 1)]
    """
    steps: dict[tuple[str, str], list[str]] = {}
    for belt in belts:
        for step in zip(belt.loop, belt.loop[1:] + belt.loop[:1], strict=True):
            steps.setdefault(step, []).append(belt.name)
    chosen = [str(i + 1) for i in range(len(steps))] if names is None else names
    return tuple(
        Span(name=name, start=start, end=end, belts=tuple(carried))
        for name, ((start, end), carried) in zip(chosen, steps.items(), strict=False)
    )
