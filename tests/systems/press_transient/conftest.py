"""The paper's machine completed by what a start-up needs, and a machine of one belt small enough to write down."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from paper import press_data, printed_press

from ropefric.accuracy.studies.press_transient import INTEGRATORS, LinearStartUp
from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.transient.drives import DRIVE_LAWS, press_inputs
from ropefric.systems.press.transient.motion import ElasticPress

DATA = press_data()
# Between 0.5 and 2 m, the shorter ones between the press rollers.
LENGTHS_M = {1: 1.5, 2: 2.0, 3: 1.0, 4: 1.0, 5: 0.6, 6: 0.6, 7: 0.5, 8: 0.5, 9: 1.0, 10: 0.8, 11: 1.5, 12: 2.0,
             13: 1.0, 14: 1.2}  # fmt: skip
SPEED_M_S = 0.175 * DATA["driver_speed"]


def tube_inertia(radius_m, wall_m=0.009, length_m=2.2):
    return 0.5 * math.pi * 7850.0 * length_m * (radius_m**4 - (radius_m - wall_m) ** 4)


def paper_machine(*, EA_N=2e6, eta_s=1e-3, C1=500.0, k1=2e4, force_N=2000.0, load=1.0, density=15.0,
                  overspeed=None, travel_m=0.03):  # fmt: skip
    bare, rollers = printed_press(), []
    for one in bare.rollers:
        tensioner = one.tensioner and replace(one.tensioner, spring_N_m=k1, travel_m=travel_m, force_N=force_N,
                                              mass_kg=121.0, damping_N_s_m=C1)  # fmt: skip
        rollers.append(replace(one, tensioner=tensioner, inertia_kg_m2=tube_inertia(one.radius_m),
                               gravity_torque_N_m=load * one.gravity_torque_N_m,
                               squeeze_torque_N_m=load * one.squeeze_torque_N_m,
                               overspeed=overspeed if one.name == "10" else None))  # fmt: skip
    ways = range(1, 10), (10, 11, 12, 13, 14, 5, 6, 7, 8)
    belts = [replace(belt, linear_density_kg_m=density, axial_stiffness_N=EA_N, damping_s=eta_s,
                     span_lengths_m=tuple(LENGTHS_M[i] for i in spans))
             for belt, spans in zip(bare.belts, ways, strict=True)]  # fmt: skip
    return replace(bare, rollers=tuple(rollers), belts=tuple(belts))


def small_machine(*, EA_N=2e5, eta_s=2e-3, load_N_m=20.0, k1=1e4, C1=200.0, wrap_rad=2.0, force_N=900.0):
    """A driver, a loaded roller and a take-up on one belt."""
    take_up = Tensioner(spring_N_m=k1, travel_m=0.01, force_N=force_N, mass_kg=30.0, damping_N_s_m=C1)
    rollers = (Roller(name="drive", radius_m=0.1, wrap_angle_rad=3.0, role="driver", inertia_kg_m2=0.4),
               Roller(name="load", radius_m=0.1, wrap_angle_rad=wrap_rad, squeeze_torque_N_m=load_N_m,
                      inertia_kg_m2=0.3),
               Roller(name="take-up", radius_m=0.08, wrap_angle_rad=3.0, role="tensioner",
                      tensioner=take_up, inertia_kg_m2=0.2))  # fmt: skip
    belt = Belt(name="belt", loop=("drive", "load", "take-up"), linear_density_kg_m=8.0, thickness_m=0.005,
                width_m=1.0, axial_stiffness_N=EA_N, damping_s=eta_s, span_lengths_m=(0.8, 1.0, 1.3))  # fmt: skip
    return Press(rollers=rollers, belts=(belt,), speed_m_s=1.0)


def run_up(law="s-curve", speed_m_s=SPEED_M_S, duration_s=2.0):
    if law == "constant":
        return DRIVE_LAWS[law](speed_m_s=speed_m_s)
    return DRIVE_LAWS[law](speed_m_s=speed_m_s, duration_s=duration_s)


def random_start(seed, laws=("s-curve", "s-curve", "ramp", "table", "constant")):
    """A machine like the paper's, and a start of it: drive, loads, friction from slippery to more than enough."""
    rng = np.random.default_rng([77, seed])
    press = paper_machine(
        EA_N=10 ** rng.uniform(6, 7), eta_s=10 ** rng.uniform(-3.5, -2), C1=10 ** rng.uniform(1.5, 3.5),
        k1=10 ** rng.uniform(3.7, 4.7), force_N=rng.uniform(800, 3500), load=rng.uniform(0.3, 1.2),
    )  # fmt: skip
    speed_m_s, law, duration_s = (SPEED_M_S * rng.uniform(0.3, 2), str(rng.choice(laws)),
                                  10 ** rng.uniform(-0.3, 0.7))  # fmt: skip
    if law == "table":
        times_s, speeds = [0.0, duration_s / 3, duration_s], [0.0, speed_m_s / 2, speed_m_s]
        drive = DRIVE_LAWS[law](time_s=times_s, speed_m_s=speeds)
    else:
        drive = run_up(law, speed_m_s, duration_s)
    return press, {"speed": drive, "time_s": np.linspace(0.0, duration_s + rng.uniform(0.5, 4), 1001),
                   "friction": rng.uniform(0.15, 1.2), "loads": str(rng.choice(["with-speed", "constant"]))}  # fmt: skip


def linear_problem(press, speed=None, loads="with-speed", **model):
    made = ElasticPress(press, **model)
    return LinearStartUp(
        model=made, inputs=press_inputs(made.overspeed, run_up() if speed is None else speed, loads)
    )


def solve(problem, times_s, integrator="exact", **settings):
    return INTEGRATORS[integrator](problem, np.asarray(times_s, dtype=float), **settings)


@pytest.fixture(scope="session")
def kit():
    """Machines, drives and shortcuts."""
    return SimpleNamespace(
        paper=paper_machine, small=small_machine, run_up=run_up, problem=linear_problem, solve=solve,
        random=random_start, lengths_m=LENGTHS_M, beta=DATA["beta"], gamma=DATA["gamma"], speed_m_s=SPEED_M_S,
    )  # fmt: skip


@pytest.fixture
def random_state():
    return np.random.default_rng(20150207)
