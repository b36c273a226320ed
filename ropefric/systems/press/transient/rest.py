"""Where a press comes to rest: the state it starts from and the one it settles in, each by one linear solution."""

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.press.transient.inputs import LOAD, ONE, SPEED, SPEED_SQUARED
from ropefric.systems.press.transient.mode import sticking
from ropefric.systems.press.transient.model import ElasticPress
from ropefric.systems.press.transient.motion import Motion


def resting_coordinates(motion: Motion, inputs: FloatArray) -> FloatArray:
    """Return the coordinates at which nothing accelerates under constant inputs u, shape (n_q,).

    Belts that slip do not take part: their δ stay zero.
    """
    n_q = motion.n_coordinates
    free = len(motion.model.driven) + len(motion.model.spring_N_m)
    rows = motion.derivative[n_q : n_q + free]
    stiffness, load = rows[:, :free], rows[:, 2 * n_q :] @ inputs
    if np.linalg.matrix_rank(stiffness) < free:
        raise InputError(
            "the press has no place of rest: a belt or tensioner is held by nothing", code="RF521"
        )
    coordinates = np.zeros(n_q)
    coordinates[:free] = -np.linalg.solve(stiffness, load)
    return coordinates


def settled_tension_N(model: ElasticPress, *, speed_m_s: float, load_factor: float = 1.0) -> FloatArray:
    """Return the tensions of steady running in closed form, shape (n_spans,) [N].

    It is what a start-up tends to; with the tensioners' damping alone that takes hours, and with no damping at all it
    is only the mean.
    """
    if np.ptp(model.overspeed) > 0.0 and speed_m_s != 0.0:
        raise InputError(
            "drivers of different speed stretch the belts between them until one slips: nothing settles",
            key="overspeed",
            fix="give all drivers one speed, or solve the start-up with friction",
        )
    motion = Motion(model=model, mode=sticking(model))
    inputs = np.zeros(motion.n_inputs)
    inputs[[ONE, LOAD, SPEED, SPEED_SQUARED]] = 1.0, load_factor, speed_m_s, speed_m_s**2
    at_rest = resting_coordinates(motion, inputs)
    w = np.concatenate([at_rest, np.zeros_like(at_rest), inputs])
    return np.asarray(motion.tension_N @ w)
