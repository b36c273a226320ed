"""How belts share a pull that no balance divides: what settles it, and where belts meet, part and are driven.

Steady creep: in a steady run as much belt passes every place, so its speed is v_b (1 + T/EA) with one v_b for each
belt. It sticks to a roller where it arrives. So at a driver V = v_b (1 + T_in/EA), and where two belts meet on one
roller the same V stands for both. With v_b and the speed of that roller eliminated, to first order in the strain,

    (T_d − T_m)_1 / EA_1 − (T_d − T_m)_2 / EA_2 = (V_1 − V_2)/v

for belts 1 and 2 that meet in the spans m and reach their drivers in the spans d; and for two drivers of one belt
(T_1 − T_2)/EA = (V_1 − V_2)/v.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.registry import Registry
from ropefric.systems.press.machine import Press, Span, refuse_missing

Statement = tuple[dict[str, float], float]
"""One linear equation between tensions: the factor of each span's tension by the span's name, and their sum [N]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Closure:
    """A named assumption about the split.

    Attributes
    ----------
    name : str
        Its name in scenes.
    rule : str
        What it says of the tensions, as a formula.
    basis : str
        What the machine must be like for it to hold.
    statements : callable
        `statements(press)` returns its equations.
    """

    name: str
    rule: str
    basis: str
    statements: Callable[[Press], list[Statement]]

    def equations(self, press: Press) -> tuple[FloatArray, FloatArray]:
        """Return the statements as a matrix, shape (k, n_spans), and its right-hand side, shape (k,) [N]."""
        statements = self.statements(press)
        matrix = [[factors.get(span.name, 0.0) for span in press.spans] for factors, _ in statements]
        values = np.array([value_N for _, value_N in statements], dtype=np.float64)
        return np.array(matrix).reshape(len(values), len(press.spans)), values


def _arriving(press: Press, roller: str, belt: str) -> str:
    """Return the name of the span in which a belt reaches a roller."""
    return next(span.name for span in press.spans if span.end == roller and belt in span.belts)


def _leaving(press: Press, roller: str, belt: str) -> str:
    """Return the name of the span in which a belt leaves a roller."""
    return next(span.name for span in press.spans if span.start == roller and belt in span.belts)


def _drivers(press: Press) -> dict[str, list[str]]:
    """Return the drivers in each belt's loop; a belt without one is dragged along by another."""
    drivers = {roller.name for roller in press.rollers if roller.role == "driver"}
    return {belt.name: [name for name in belt.loop if name in drivers] for belt in press.belts}


def _alone(press: Press, end: Callable[[Span], str]) -> list[tuple[str, str, str]]:
    """Return (roller, belt, next belt) wherever belts of one roller are alone in their spans at one end of these."""
    alone = {(end(span), span.belts) for span in press.spans}
    return [
        (roller.name, first, second)
        for roller in press.rollers
        for first, second in pairwise(
            belt.name for belt in press.belts if (roller.name, (belt.name,)) in alone
        )
    ]


def creep_statements(
    press: Press, *, axial_stiffness_N: Mapping[str, float], overspeed: Mapping[str, float]
) -> list[Statement]:
    """Return what steady creep says about the tensions."""
    drivers, stated = _drivers(press), []
    for roller, first, second in _alone(press, lambda span: span.end):
        if drivers[first] and drivers[second]:
            one, other = drivers[first][0], drivers[second][0]
            softness = axial_stiffness_N[first] / axial_stiffness_N[second]
            factors = {
                _arriving(press, one, first): 1.0,
                _arriving(press, roller, first): -1.0,
                _arriving(press, other, second): -softness,
                _arriving(press, roller, second): softness,
            }
            stated.append((factors, axial_stiffness_N[first] * (overspeed[one] - overspeed[other])))
    for belt, names in drivers.items():
        for other in names[1:]:
            factors = {_arriving(press, names[0], belt): 1.0, _arriving(press, other, belt): -1.0}
            stated.append((factors, axial_stiffness_N[belt] * (overspeed[names[0]] - overspeed[other])))
    return stated


def _share(press: Press) -> list[Statement]:
    return creep_statements(
        press,
        axial_stiffness_N={belt.name: 1.0 for belt in press.belts},
        overspeed={roller.name: 0.0 for roller in press.rollers if roller.role == "driver"},
    )


def _equal(press: Press) -> list[Statement]:
    return [
        ({_leaving(press, roller, first): 1.0, _leaving(press, roller, second): -1.0}, 0.0)
        for roller, first, second in _alone(press, lambda span: span.start)
    ]


def _equal_torque(press: Press) -> list[Statement]:
    belt_of = {name: belt.name for belt in press.belts for name in belt.loop}
    stated = []
    for first, second in pairwise(roller for roller in press.rollers if roller.role == "driver"):
        factors: dict[str, float] = {}
        for driver, lever in ((first, 1.0), (second, -second.radius_m / first.radius_m)):
            into = _arriving(press, driver.name, belt_of[driver.name])
            out_of = _leaving(press, driver.name, belt_of[driver.name])
            factors[into] = factors.get(into, 0.0) + lever
            factors[out_of] = factors.get(out_of, 0.0) - lever
        stated.append((factors, 0.0))
    return stated


def _speed_ratio(press: Press) -> list[Statement]:
    stiffness = {belt.name: belt.axial_stiffness_N for belt in press.belts}
    overspeed = {roller.name: roller.overspeed for roller in press.rollers if roller.role == "driver"}
    missing = [f"belts.{name}.axial_stiffness_N" for name, value in stiffness.items() if value is None]
    missing += [f"rollers.{name}.overspeed" for name, value in overspeed.items() if value is None]
    refuse_missing(
        "the closure 'speed-ratio'",
        missing,
        fix="give EA of every belt and (V - v)/v of every driver, or choose the closure 'share'",
    )
    return creep_statements(
        press,
        axial_stiffness_N={name: value for name, value in stiffness.items() if value is not None},
        overspeed={name: value for name, value in overspeed.items() if value is not None},
    )


CLOSURES: Registry[Closure] = Registry(
    "closure",
    [
        Closure(
            name="share",
            rule="each belt gains the same tension from where the belts meet to its driver: T9 - T4 = T10 - T14",
            basis="steady creep with equal surface speed of the drivers and equal EA of the belts",
            statements=_share,
        ),
        Closure(
            name="equal",
            rule="belts leave the roller where they part with the same tension: T9 = T10",
            basis="an even split, whatever the drivers do",
            statements=_equal,
        ),
        Closure(
            name="equal-torque",
            rule="every driver turns its belt with the same torque: R1 (T9 - T1) = R10 (T10 - T11)",
            basis="drives that hold the torque, such as inverters sharing their load",
            statements=_equal_torque,
        ),
        Closure(
            name="speed-ratio",
            rule="(T9 - T4)/EA_upper - (T10 - T14)/EA_lower = (V1 - V10)/v",
            basis="steady creep with known EA of the belts and known surface speeds of the drivers",
            statements=_speed_ratio,
        ),
    ],
)
"""The closures; the first is the default."""
