"""The saw of Wang and Jiang (2010) and their printed numbers."""

import math

import pytest
from paper import rows

from ropefric.systems.bandsaw.answer import SawProblem
from ropefric.systems.bandsaw.saw import STEEL_85_09, Side, tension_difference_N, torque_N_m


@pytest.fixture(scope="session")
def machine():
    """Every printed quantity of the machine by name."""
    return {row["quantity"]: float(row["value"]) for row in rows("band_saw_machine.csv")}


@pytest.fixture(scope="session")
def saw(machine):
    """The saw as a string between fixed axles, with the printed torque factor 9549."""
    omega = machine["wheel_speed"] * math.pi / 30.0
    radius = 0.5 * machine["wheel_diameter"]
    torque = torque_N_m(1e3 * machine["power"], omega, printed=True)
    return SawProblem(free_span_m=machine["free_span"], n_modes=6,
               linear_density_kg_m=machine["density"] * machine["cross_section"],
               preload_N=machine["preload"], wheel_radius_m=radius, wheel_speed_rad_s=omega,
               tension_difference_N=float(tension_difference_N(torque, radius)))  # fmt: skip


@pytest.fixture(scope="session")
def stiffness():
    return STEEL_85_09.bending_stiffness_N_m2


@pytest.fixture(scope="session")
def columns():
    """The printed tables: (table, side, runs) -> frequencies of modes 1 to 6."""
    found = {}
    for row in rows("band_saw_frequencies.csv"):
        side = Side.REST if row["side"] == "both" else Side(row["side"])
        column = found.setdefault((int(row["table"]), side, row["state"] == "running"), {})
        column[int(row["mode"])] = float(row["frequency_Hz"])
    return {key: [column[mode] for mode in sorted(column)] for key, column in found.items()}
