"""Where belts meet, part and are driven: the places that closures speak about.

Examples
--------
Two belts over one roller `m`, each with a driver and a tensioner of its own:

>>> from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
>>> def roller(name, role="driven", tensioner=None):
...     return Roller(name=name, radius_m=0.1, wrap_angle_rad=3.0, role=role, tensioner=tensioner)
>>> pull = Tensioner(spring_N_m=0.0, travel_m=0.0, force_N=1000.0)
>>> cross_section = {"linear_density_kg_m": 1.0, "thickness_m": 0.005, "width_m": 1.0}
>>> press = Press(
...     rollers=(
...         roller("m"),
...         *(roller(f"d{k}", "driver") for k in "ab"),
...         *(roller(f"t{k}", "tensioner", pull) for k in "ab"),
...     ),
...     belts=tuple(Belt(name=k, loop=("m", f"d{k}", f"t{k}"), **cross_section) for k in "ab"),
...     speed_m_s=1.0,
... )
>>> meetings(press), partings(press), driver_of(press, "b").name
((('m', 'a', 'b'),), (('m', 'a', 'b'),), 'db')
>>> arriving_span(press, "m", "a"), leaving_span(press, "m", "a")
('3', '1')
"""

from itertools import pairwise

from ropefric.systems.press.machine import Press, Roller

__all__ = ["arriving_span", "driver_of", "leaving_span", "meetings", "partings"]


def arriving_span(press: Press, roller: str, belt: str) -> str:
    """Return the name of the span in which a belt reaches a roller."""
    return next(span.name for span in press.spans if span.end == roller and belt in span.belts)


def leaving_span(press: Press, roller: str, belt: str) -> str:
    """Return the name of the span in which a belt leaves a roller."""
    return next(span.name for span in press.spans if span.start == roller and belt in span.belts)


def driver_of(press: Press, belt: str) -> Roller | None:
    """Return the first driver in a belt's loop, or None where another belt drags it along."""
    rollers = {roller.name: roller for roller in press.rollers}
    loop = next(each.loop for each in press.belts if each.name == belt)
    return next((rollers[name] for name in loop if rollers[name].role == "driver"), None)


def meetings(press: Press) -> tuple[tuple[str, str, str], ...]:
    """Return (roller, belt, next belt) wherever belts of one roller reach it in spans of their own."""
    return _pairs(press, {(span.end, belt): span.belts for span in press.spans for belt in span.belts})


def partings(press: Press) -> tuple[tuple[str, str, str], ...]:
    """Return (roller, belt, next belt) wherever belts of one roller leave it in spans of their own."""
    return _pairs(press, {(span.start, belt): span.belts for span in press.spans for belt in span.belts})


def _pairs(press: Press, company: dict[tuple[str, str], tuple[str, ...]]) -> tuple[tuple[str, str, str], ...]:
    """Pair the belts that are alone in their span beside a roller, in the order of the press."""
    found = []
    for roller in press.rollers:
        alone = [belt.name for belt in press.belts if company.get((roller.name, belt.name)) == (belt.name,)]
        found += [(roller.name, first, second) for first, second in pairwise(alone)]
    return tuple(found)
