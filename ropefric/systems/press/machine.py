"""A belt press: rollers, belts and a speed, checked as a whole."""

from dataclasses import dataclass

from ropefric.errors import raise_problems
from ropefric.systems.press.checks import press_problems
from ropefric.systems.press.parts import Belt, Role, Roller, Tensioner
from ropefric.systems.press.spans import Span, spans_of

__all__ = ["Belt", "Press", "Role", "Roller", "Span", "Tensioner"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Press:
    """The drive train of a belt filter press, or of any machine of rollers and closed belts.

    Attributes
    ----------
    rollers : tuple of Roller
        All rollers; arrays over rollers have this order.
    belts : tuple of Belt
        All belts. Arrays over spans have the order of the first belt's loop, then what the second adds, and so on.
    speed_m_s : float
        Belt speed v [m/s], zero or more; functions that take a speed of their own start from it.
    span_names : tuple of str, optional
        Names for the spans, in their order; by default they are numbered from 1.

    Raises
    ------
    DataError
        If the parts do not make a machine: a repeated or unknown name, a number outside its range, a loop that is
        not closed, a roller on no belt, a belt nothing drives, a driver that belts share … `.problems` has them all.

    Examples
    --------
    >>> weight = Tensioner(spring_N_m=0.0, travel_m=0.0, force_N=1000.0)
    >>> press = Press(
    ...     rollers=(
    ...         Roller(name="drive", radius_m=0.1, wrap_angle_rad=3.14, role="driver"),
    ...         Roller(name="load", radius_m=0.1, wrap_angle_rad=3.14, role="tensioner", tensioner=weight),
    ...     ),
    ...     belts=(Belt(name="belt", loop=("drive", "load"), linear_density_kg_m=1, thickness_m=0.005, width_m=1),),
    ...     speed_m_s=1.0,
    ... )
    >>> [(span.name, span.start, span.end) for span in press.spans]
    [('1', 'drive', 'load'), ('2', 'load', 'drive')]
    """

    rollers: tuple[Roller, ...]
    belts: tuple[Belt, ...]
    speed_m_s: float
    span_names: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        raise_problems(press_problems(self.rollers, self.belts, self.speed_m_s, self.span_names))

    @property
    def spans(self) -> tuple[Span, ...]:
        """Return the spans, in the order of every array over spans."""
        return spans_of(self.belts, self.span_names)

    @property
    def tensioners(self) -> tuple[Roller, ...]:
        """Return the rollers that translate, in the order of every array over tensioners."""
        return tuple(roller for roller in self.rollers if roller.tensioner is not None)
