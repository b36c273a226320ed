"""How belts share a pull that no balance divides: what settles it, and where belts meet, part and are driven.

Steady creep: in a steady run as much belt passes every place, so its speed is v_b (1 + T/EA) with one v_b for each
belt. It sticks to a roller where it arrives. So at a driver V = v_b (1 + T_in/EA), and where two belts meet on one
roller the same V stands for both. With v_b and the speed of that roller eliminated, to first order in the strain,

    (T_d − T_m)_1 / EA_1 − (T_d − T_m)_2 / EA_2 = (V_1 − V_2)/v

for belts 1 and 2 that meet in the spans m and reach their drivers in the spans d; and for two drivers of one belt
(T_1 − T_2)/EA = (V_1 − V_2)/v.

Examples
--------
Two belts over one roller `m`, each with a driver and a tensioner of its own; the second driver is ahead by 0.1 %:

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
>>> EA = {"a": 2e6, "b": 2e6}
>>> [said] = creep_statements(press, axial_stiffness_N=EA, overspeed={"da": 0.0, "db": 1e-3})
>>> said.coefficients, said.value_N
({'1': 1.0, '3': -1.0, '4': -1.0, '6': 1.0}, -2000.0)
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, Problem
from ropefric.registry import Registry
from ropefric.systems.press.machine import Press, Roller


@dataclass(frozen=True, slots=True, kw_only=True)
class Statement:
    """One linear equation between tensions: Σ coefficient · T = value.

    Attributes
    ----------
    coefficients : dict of str to float
        Factor of each span's tension, by span name.
    value_N : float
        The right-hand side [N].

    Examples
    --------
    >>> Statement(coefficients={"9": 1.0, "10": -1.0}, value_N=0.0).value_N
    0.0
    """

    coefficients: dict[str, float]
    value_N: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Closure:
    """A named assumption about the split."""

    name: str
    rule: str
    basis: str
    statements: Callable[[Press], tuple[Statement, ...]]

    def equations(self, press: Press) -> tuple[FloatArray, FloatArray]:
        """Return the statements as a matrix, shape (k, n_spans), and its right-hand side, shape (k,) [N]."""
        statements = self.statements(press)
        matrix = [[said.coefficients.get(span.name, 0.0) for span in press.spans] for said in statements]
        values = [said.value_N for said in statements]
        return np.array(matrix).reshape(len(values), len(press.spans)), np.array(values, dtype=np.float64)


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


def creep_statements(
    press: Press, *, axial_stiffness_N: Mapping[str, float], overspeed: Mapping[str, float]
) -> tuple[Statement, ...]:
    """Return what steady creep says about the tensions."""
    stated = []
    for roller, first, second in meetings(press):
        drivers = driver_of(press, first), driver_of(press, second)
        if drivers[0] is None or drivers[1] is None:
            continue
        softness = axial_stiffness_N[first] / axial_stiffness_N[second]
        stated.append(
            Statement(
                coefficients={
                    arriving_span(press, drivers[0].name, first): 1.0,
                    arriving_span(press, roller, first): -1.0,
                    arriving_span(press, drivers[1].name, second): -softness,
                    arriving_span(press, roller, second): softness,
                },
                value_N=axial_stiffness_N[first] * (overspeed[drivers[0].name] - overspeed[drivers[1].name]),
            )
        )
    return (*stated, *_drivers_of_one_belt(press, axial_stiffness_N, overspeed))


def _drivers_of_one_belt(
    press: Press, axial_stiffness_N: Mapping[str, float], overspeed: Mapping[str, float]
) -> tuple[Statement, ...]:
    stated = []
    for belt in press.belts:
        first, *others = [name for name in belt.loop if name in overspeed] or [""]
        for other in others:
            spans = arriving_span(press, first, belt.name), arriving_span(press, other, belt.name)
            value_N = axial_stiffness_N[belt.name] * (overspeed[first] - overspeed[other])
            stated.append(Statement(coefficients=dict(zip(spans, (1.0, -1.0), strict=True)), value_N=value_N))
    return tuple(stated)


def _share(press: Press) -> tuple[Statement, ...]:
    return creep_statements(
        press,
        axial_stiffness_N={belt.name: 1.0 for belt in press.belts},
        overspeed={roller.name: 0.0 for roller in press.rollers if roller.role == "driver"},
    )


_SHARE = Closure(
    name="share",
    rule="each belt gains the same tension from where the belts meet to its driver: T9 - T4 = T10 - T14",
    basis="steady creep with equal surface speed of the drivers and equal EA of the belts",
    statements=_share,
)


def _equal(press: Press) -> tuple[Statement, ...]:
    return tuple(
        Statement(
            coefficients={leaving_span(press, roller, first): 1.0, leaving_span(press, roller, second): -1.0}
        )
        for roller, first, second in partings(press)
    )


_EQUAL = Closure(
    name="equal",
    rule="belts leave the roller where they part with the same tension: T9 = T10",
    basis="an even split, whatever the drivers do",
    statements=_equal,
)


def _equal_torque(press: Press) -> tuple[Statement, ...]:
    belt_of = {name: belt.name for belt in press.belts for name in belt.loop}
    drivers = [roller for roller in press.rollers if roller.role == "driver"]
    stated = []
    for first, second in pairwise(drivers):
        terms: dict[str, float] = {}
        for driver, sign in ((first, 1.0), (second, -1.0)):
            lever = sign * driver.radius_m / first.radius_m
            for name, factor in (
                (arriving_span(press, driver.name, belt_of[driver.name]), lever),
                (leaving_span(press, driver.name, belt_of[driver.name]), -lever),
            ):
                terms[name] = terms.get(name, 0.0) + factor
        stated.append(Statement(coefficients=terms))
    return tuple(stated)


_EQUAL_TORQUE = Closure(
    name="equal-torque",
    rule="every driver turns its belt with the same torque: R1 (T9 - T1) = R10 (T10 - T11)",
    basis="drives that hold the torque, such as inverters sharing their load",
    statements=_equal_torque,
)


def _speed_ratio(press: Press) -> tuple[Statement, ...]:
    stiffness = {belt.name: belt.axial_stiffness_N for belt in press.belts}
    overspeed = {roller.name: roller.overspeed for roller in press.rollers if roller.role == "driver"}
    missing = [f"belts.{name}.axial_stiffness_N" for name, value in stiffness.items() if value is None]
    missing += [f"rollers.{name}.overspeed" for name, value in overspeed.items() if value is None]
    if missing:
        raise InputError(
            f"the closure 'speed-ratio' needs {', '.join(missing)}",
            code="RF521",
            key=missing[0],
            fix="give EA of every belt and (V - v)/v of every driver, or choose the closure 'share'",
            problems=[
                Problem(code="RF521", key=key, message=f"the closure 'speed-ratio' needs {key}")
                for key in missing
            ],
        )
    return creep_statements(
        press,
        axial_stiffness_N={name: value for name, value in stiffness.items() if value is not None},
        overspeed={name: value for name, value in overspeed.items() if value is not None},
    )


_SPEED_RATIO = Closure(
    name="speed-ratio",
    rule="(T9 - T4)/EA_upper - (T10 - T14)/EA_lower = (V1 - V10)/v",
    basis="steady creep with known EA of the belts and known surface speeds of the drivers",
    statements=_speed_ratio,
)


CLOSURES: Registry[Closure] = Registry("closure", [_SHARE, _EQUAL, _EQUAL_TORQUE, _SPEED_RATIO])
"""The closures; the first is the default."""
