"""The press of Ni & Wen, from the numbers they print, and machines with one thing changed."""

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS
from ropefric.systems.bandsaw.effects import SYSTEM as SAW
from ropefric.systems.effect import assemble
from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner

PUBLISHED = Path(__file__).parents[2] / "data" / "published"
UPPER = ("1", "2", "3", "4", "5", "6", "7", "8", "9")
LOWER = ("9", "10", "11", "12", "13", "5", "6", "7", "8")


def rows(name):
    """Return the rows of a published table."""
    with (PUBLISHED / name).open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def whole(saw):
    """Return a saw with all its effects."""
    return assemble(SAW, saw, SAW.effects)


def press_data():
    """Return the printed machine data in SI units, by name."""
    factor = {"mm": 1e-3, "N/mm": 1e3, "deg": math.pi / 180, "1/min": 2 * math.pi / 60}
    return {row["quantity"]: float(row["value"]) * factor.get(row["unit"], 1.0)
            for row in rows("belt_press_machine.csv")}  # fmt: skip


def printed_press():
    """Return the printed machine at 50 rpm, without what the paper does not give."""
    data = press_data()
    carriers = {"3": Tensioner(spring_N_m=data["tensioner_stiffness"], travel_m=data["tensioner_travel_up"],
                               force_N=data["tensioner_force_up"], downstream_angle_rad=data["beta"]),
                "13": Tensioner(spring_N_m=data["tensioner_stiffness"],
                                travel_m=data["tensioner_travel_down"],
                                force_N=data["tensioner_force_down"], upstream_angle_rad=data["gamma"])}  # fmt: skip
    rollers = []
    for row in rows("belt_press_rollers.csv"):
        name = row["roller"]
        rollers.append(
            Roller(
                name=name,
                radius_m=float(row["roller_radius_mm"]) / 1000.0,
                wrap_angle_rad=math.radians(float(row["wrap_angle_deg"])),
                role="driver" if name in {"1", "10"} else "tensioner" if name in carriers else "driven",
                gravity_torque_N_m=float(row["gravity_torque_N_m"] or 0),
                squeeze_torque_N_m=float(row["squeeze_torque_N_m"] or 0),
                tensioner=carriers.get(name),
            )
        )
    area_m2 = data["belt_width"] * data["belt_thickness"]
    belts = tuple(Belt(name=name, loop=loop, linear_density_kg_m=data["belt_density"] * area_m2,
                       thickness_m=data["belt_thickness"], width_m=data["belt_width"])
                  for name, loop in (("upper", UPPER), ("lower", LOWER)))  # fmt: skip
    return Press(rollers=tuple(rollers), belts=belts, speed_m_s=0.175 * data["driver_speed"])


def with_roller(press, which, **changes):
    """Return a press one of whose rollers is another."""
    rollers = tuple(replace(r, **changes) if r.name == which else r for r in press.rollers)
    return replace(press, rollers=rollers)


def law_of(name, theta, at):
    """Return the friction of a law with its parameters, and a reference (R_w, R_r, wrap, end tension)."""
    return WrapFriction(law=ALL_LAWS[name], theta=np.array(theta), reference=one_condition(*at))


def density_on_rollers(press):
    """Return the mass per length of all belts on each roller."""
    return np.array([sum(b.linear_density_kg_m for b in press.belts_on(one.name)) for one in press.rollers])
