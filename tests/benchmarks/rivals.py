"""What `peers.py` times beside ropefric: a fit, a lift force, a blade and a press, as users would write them."""

import math

import lmfit
import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from ropefric.friction.condition import Conditions
from ropefric.friction.laws import LAWS
from ropefric.systems.bandsaw.beam import ScaledBeam, galerkin_modes, widths_for
from ropefric.systems.bandsaw.span import CLAMPED
from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner

LAW, STD = LAWS["coupled"], 0.01
TRUTH = np.array([0.2, -0.2, -0.3, -0.4, 0.05])


def lift_force_N(law, theta, conditions):
    return np.exp(law.log_lift(theta, conditions))


def lmfit_fit(problem, log_lift, start):
    """The same law, vectorised over the conditions, through lmfit with numerical derivatives."""
    parameters = lmfit.Parameters()
    for p, value in zip(problem.law.parameters, start, strict=True):
        parameters.add(p.name, value=value, min=p.lower, max=p.upper)

    def residual(values):
        theta = [values[name].value for name in problem.law.parameter_names]
        return (problem.law.log_lift(theta, problem.conditions) - log_lift) / problem.std

    return np.array(list(lmfit.minimize(residual, parameters).params.valuesdict().values()))


def designs(n):
    rng = np.random.default_rng(11)
    return Conditions(wheel_radius_m=rng.uniform(0.02, 0.1, n), rope_radius_m=0.005,
                      wrap_angle_rad=rng.uniform(1, 12, n), end_tension_N=rng.uniform(1.5, 200, n))  # fmt: skip


def lift_by_quadrature(conditions):
    mu_inf, a, b, c, d = TRUTH
    forces = []
    for r, phi, tension in zip(
        conditions.size_ratio, conditions.wrap_angle_rad, conditions.end_tension_N, strict=True
    ):
        strength = mu_inf * (1 - np.exp(a * r + b))

        def mu(angle, strength=strength):
            return strength * angle**c + d

        def short(angle, mu=mu, tension=tension):
            return quad(mu, 0, angle)[0] - np.log(tension)

        start = brentq(short, 1e-9, 200)
        forces.append(tension * np.exp(quad(mu, start, start + phi)[0]))
    return np.array(forces)


# The blade of the paper, wheels pressed apart with a constant force: e = 0.0099, V = 0.42.
BEAM = ScaledBeam.at_speed(1e-4, 0.42, CLAMPED)
ACCURACY = 1e-8


def spectral(order):
    return galerkin_modes(BEAM, widths_for(BEAM, order), order, 6).frequencies


def hermite(n_elements):
    return galerkin_modes(BEAM, (1.0 / n_elements,) * n_elements, 3, 6).frequencies


def error(found, exact):
    return float(np.abs(found / exact - 1.0).max())


def smallest(solve, exact, orders):
    return next(order for order in orders if error(solve(order), exact) < ACCURACY)


def smallest_hermite(exact):
    """By the law h⁴ from a mesh that is quick to solve: a search would take minutes."""
    law = (error(hermite(100), exact) / ACCURACY) ** 0.25
    return int(np.ceil(100 * law * 1.05))


TIMES_S = np.linspace(0.0, 10.0, 201)


def machine(eta_s):
    """The size of the paper's press: thirteen rollers on one belt."""
    take_up = Tensioner(spring_N_m=2e4, travel_m=0.03, force_N=2000.0, mass_kg=121.0, damping_N_s_m=500.0)
    names = tuple(str(i) for i in range(1, 14))
    rollers = tuple(Roller(name=name, radius_m=0.15, wrap_angle_rad=math.radians(90.0),
                           role="driver" if name == "1" else "tensioner" if name == "3" else "driven",
                           inertia_kg_m2=1.5, squeeze_torque_N_m=0.0 if name == "1" else 15.0,
                           tensioner=take_up if name == "3" else None)
                    for name in names)  # fmt: skip
    belt = Belt(
        name="belt", loop=names, linear_density_kg_m=15.0, thickness_m=0.005, width_m=2.0, axial_stiffness_N=2e6,
        damping_s=eta_s, span_lengths_m=tuple(0.6 + 0.1 * i for i in range(13)),
    )  # fmt: skip
    return Press(rollers=rollers, belts=(belt,), speed_m_s=0.9)


def tensions(problem, states):
    w = np.hstack([states[:, : problem.n_state], problem.inputs.at(TIMES_S)])
    return w @ problem.motion.tension_N.T
