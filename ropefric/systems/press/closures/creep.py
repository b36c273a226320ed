"""Steady creep: a belt takes a roller's speed where it reaches it, and its speed there tells its strain.

In a steady run as much belt passes every place, so its speed is v_b (1 + T/EA) with one v_b for each belt. It sticks
to a roller where it arrives. So at a driver V = v_b (1 + T_in/EA), and where two belts meet on one roller the same V
stands for both. With v_b and the speed of that roller eliminated, to first order in the strain,

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
>>> EA = {"a": 2e6, "b": 2e6}
>>> [said] = creep_statements(press, axial_stiffness_N=EA, overspeed={"da": 0.0, "db": 1e-3})
>>> said.coefficients, said.value_N
({'1': 1.0, '3': -1.0, '4': -1.0, '6': 1.0}, -2000.0)
"""

from collections.abc import Mapping

from ropefric.systems.press.closures.closure import Statement
from ropefric.systems.press.closures.meeting import arriving_span, driver_of, meetings
from ropefric.systems.press.machine import Press

__all__ = ["creep_statements"]


def creep_statements(
    press: Press, *, axial_stiffness_N: Mapping[str, float], overspeed: Mapping[str, float]
) -> tuple[Statement, ...]:
    """Return what steady creep says about the tensions.

    Parameters
    ----------
    press : Press
        The machine.
    axial_stiffness_N : mapping of str to float
        EA of each belt [N].
    overspeed : mapping of str to float
        (V − v)/v of each driver [-].
    """
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
