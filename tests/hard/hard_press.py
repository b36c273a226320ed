"""A press of one belt, and the exponential of its linear start-up in many digits."""

import mpmath as mp
import numpy as np

from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.transient.drives import press_inputs
from ropefric.systems.press.transient.integrators import LinearStartUp
from ropefric.systems.press.transient.motion import ElasticPress

__all__ = ["WRAP_RAD", "linear_start", "small_press", "true_state"]

WRAP_RAD = 2.0


def small_press(*, EA_N, eta_s, load_N_m=20.0):
    """Return a driver, a loaded roller and a take-up on one belt."""
    take_up = Tensioner(spring_N_m=1e4, travel_m=0.01, force_N=900.0, mass_kg=30.0, damping_N_s_m=200.0)
    rollers = (
        Roller(name="drive", radius_m=0.1, wrap_angle_rad=3.0, role="driver"),
        Roller(
            name="load",
            radius_m=0.1,
            wrap_angle_rad=WRAP_RAD,
            squeeze_torque_N_m=load_N_m,
            inertia_kg_m2=0.3,
        ),
        Roller(
            name="take-up",
            radius_m=0.08,
            wrap_angle_rad=3.0,
            role="tensioner",
            tensioner=take_up,
            inertia_kg_m2=0.2,
        ),
    )
    belt = Belt(
        name="belt",
        loop=("drive", "load", "take-up"),
        linear_density_kg_m=8.0,
        thickness_m=0.005,
        width_m=1.0,
        axial_stiffness_N=EA_N,
        damping_s=eta_s,
        span_lengths_m=(0.8, 1.0, 1.3),
    )
    return Press(rollers=rollers, belts=(belt,), speed_m_s=1.0)


def linear_start(press, speed, loads="with-speed"):
    """Return the linear start-up of a press."""
    model = ElasticPress(press)
    return LinearStartUp(model=model, inputs=press_inputs(model.overspeed, speed, loads))


def true_state(problem, time_s):
    """Return the state at a time in the first piece of the drive: all floats taken as they are, 60 digits."""
    n, rows = problem.n_state, problem.motion.derivative
    taylor = problem.inputs.taylor[0]
    powers = taylor.shape[1]
    with mp.workdps(60):
        whole = mp.zeros(n + powers)
        acting = mp.matrix(rows[:, n:].tolist()) * mp.matrix(taylor.tolist())
        for i in range(n):
            for j in range(n):
                whole[i, j] = mp.mpf(float(rows[i, j])) * mp.mpf(float(time_s))
            for j in range(powers):
                whole[i, n + j] = acting[i, j] * mp.mpf(float(time_s))
        for j in range(1, powers):
            whole[n + j, n + j - 1] = mp.mpf(float(time_s))
        halvings = max(0, int(mp.ceil(mp.log(mp.mnorm(whole, 1), 2)))) + 6
        step = whole / mp.mpf(2) ** halvings
        flow, term = mp.eye(n + powers), mp.eye(n + powers)
        for k in range(1, 22):
            term = term * step / k
            flow += term
        for _ in range(halvings):
            flow = flow * flow
        start = mp.matrix([*problem.start.tolist(), 1, *[0] * (powers - 1)])
        return np.array([float(x) for x in (flow * start)[:n]])
