"""A rope on a wheel as a scene assembles it, and its lift force in many digits."""

import hard_truth
import mpmath as mp

from ropefric.systems.effect import assemble
from ropefric.systems.friction import WrapFriction
from ropefric.systems.hoist.contact import HoistProblem
from ropefric.systems.hoist.effects import SYSTEM

__all__ = ["DENSITY", "RADIUS", "SPEED", "lifted", "rope", "true_log_lift"]

# R² and ρv² = 16 N exactly, so that EI/(2R²) and what is left of F_B are the floats that were meant.
WHEEL, ROPE = 0.1875, 0.0625
RADIUS = WHEEL + ROPE
DENSITY, SPEED = 0.0625, 16.0


def rope(*, wrap, tension, mu=0.2, friction=None, stiffness_N=0.0, moving=False):
    """Return a rope of EI = 2R²E, of a constant coefficient if no friction is given."""
    motion = {"linear_density_kg_m": DENSITY, "speed_m_s": SPEED} if moving else {}
    return HoistProblem(
        friction=WrapFriction.constant(mu) if friction is None else friction,
        wheel_radius_m=WHEEL,
        rope_radius_m=ROPE,
        wrap_angle_rad=wrap,
        end_tension_N=tension,
        bending_stiffness_N_m2=2.0 * RADIUS**2 * stiffness_N,
        **motion,
    )


def lifted(problem):
    """Return the answer with every effect that there are data for."""
    known = [name for name, effect in SYSTEM.effects.items() if not effect.needs(problem)]
    model = assemble(SYSTEM, problem, known)
    return SYSTEM.solve(model, SYSTEM.method(model, 1e-9))


def true_log_lift(*, mu, wrap, tension, stiffness_N=0.0, moving=False):
    """Return ln F_A: what does not hold the rope on its circle bends it and rubs."""
    with mp.workdps(60), hard_truth.digits(60):
        circling = mp.mpf(DENSITY) * mp.mpf(SPEED) ** 2 if moving else mp.mpf(0)
        F = mp.mpf(tension) - circling
        if stiffness_N:
            rigidity = 2 * mp.mpf(RADIUS) ** 2 * mp.mpf(stiffness_N)
            rise = hard_truth.rise("bending", (mu, rigidity), (WHEEL, ROPE, wrap, F))
        else:
            rise = mp.mpf(mu) * mp.mpf(wrap)
        return mp.log(circling + F * mp.exp(rise))
