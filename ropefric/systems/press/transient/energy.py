"""Where the drive's work goes: powers and stored energies of one mode as quadratic forms of w = (q, dq/dt, u)."""

from dataclasses import dataclass

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.systems.press.transient.inputs import SPEED_SQUARED
from ropefric.systems.press.transient.motion import Motion

POWERS = ("drive", "load", "belt", "tensioner", "slip", "centrifugal")
"""Works that are counted: done by the drivers, against the loads, lost in belts, tensioners' dampers and slip, and
done by the running belts' momentum ρAv² on the tensioners."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Energies:
    """Works since the start and energies, each of shape (n_times,) [J]."""

    drive: FloatArray
    load: FloatArray
    belt: FloatArray
    tensioner: FloatArray
    slip: FloatArray
    centrifugal: FloatArray
    kinetic: FloatArray
    elastic: FloatArray

    @property
    def residual(self) -> FloatArray:
        """Return what does not add up since the first time [J]; zero but for rounding and the integrator's error."""
        stored = self.kinetic + self.elastic
        supplied = self.drive + self.centrifugal - self.load - self.belt - self.tensioner - self.slip
        return np.asarray((supplied - supplied[0]) - (stored - stored[0]))

    @property
    def relative_residual(self) -> float:
        """Return the greatest residual over the greatest of all works and changes of energy [-]."""
        parts = [getattr(self, name) for name in POWERS]
        parts += [part - part[0] for part in (self.kinetic, self.elastic)]
        scale = max(float(np.abs(part).max()) for part in parts)
        return float(np.abs(self.residual).max()) / scale if scale > 0.0 else 0.0


def power_forms(motion: Motion) -> FloatArray:
    """Return the powers in the order of `POWERS` as symmetric matrices S, power = wᵀ S w, shape (6, n_w, n_w)."""
    model = motion.model
    drivers = model.drivers
    push = (model.roller_mass_kg[:, None] * motion.rim_acceleration_m_s2 + motion.load_N - motion.friction_N)[
        drivers
    ]
    kept = np.array(motion.mode.strained, dtype=np.float64)[:, None] * motion.spring_N
    momentum = -np.outer(model.pull @ model.density_kg_m, motion.input(SPEED_SQUARED))
    pairs = (
        (push, motion.rim_speed_m_s[drivers]),
        (motion.load_N, motion.rim_speed_m_s),
        (motion.tension_N - kept, motion.stretch_speed_m_s),
        (model.tensioner_damping_N_s_m[:, None] * motion.travel_speed_m_s, motion.travel_speed_m_s),
        (motion.friction_N, motion.slip_speed_m_s),
        (momentum, motion.travel_speed_m_s),
    )
    products = np.array([force.T @ speed for force, speed in pairs])
    return np.asarray(0.5 * (products + products.transpose(0, 2, 1)))


def kinetic_energy_J(motion: Motion, w: FloatArray) -> FloatArray:
    """Return the kinetic energy of rollers, belts on them and tensioners at states w of shape (..., n_w)."""
    model = motion.model
    rim, slip, travel = (
        w @ rows.T for rows in (motion.rim_speed_m_s, motion.slip_speed_m_s, motion.travel_speed_m_s)
    )
    energy = rim**2 @ model.roller_mass_kg + (rim + slip) ** 2 @ model.arc_mass_kg
    return np.asarray(0.5 * (energy + travel**2 @ model.tensioner_mass_kg))


def elastic_energy_J(motion: Motion, w: FloatArray) -> FloatArray:
    """Return the energy of the strained spans, and of the tensioners from their place at rest, at states w."""
    model = motion.model
    spring, travel = w @ motion.spring_N.T, w @ motion.travel_m.T
    if motion.limit is not None:
        spring = np.maximum(spring, 0.0)  # the linear model's belts push, and store energy by it
    held = travel**2 @ (0.5 * model.spring_N_m) + travel @ (model.pull @ model.preload_N)
    return np.asarray(spring**2 @ (0.5 / model.stiffness_N_m) + held)


def energies_of(motion: Motion, w: FloatArray, works: FloatArray) -> Energies:
    """Return the balance of states w, shape (n, n_w), and works in the order of `POWERS`, shape (n, 6)."""
    return Energies(
        **dict(zip(POWERS, works.T, strict=True)),
        kinetic=kinetic_energy_J(motion, w),
        elastic=elastic_energy_J(motion, w),
    )
