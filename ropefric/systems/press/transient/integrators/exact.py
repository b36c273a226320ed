"""The exact solution by matrix exponentials: the reference for all others, and the fastest of them."""

import numpy as np

from ropefric.systems.press.transient.exponential import Propagator
from ropefric.systems.press.transient.integrators.integrator import Integrator, Settings
from ropefric.systems.press.transient.polynomial import FloatArray
from ropefric.systems.press.transient.problem import LinearStartUp

__all__ = ["INTEGRATOR"]

_SAME = 1e-12
"""Steps that differ by less, against the time reached, are one step: times on a grid are rounded."""


def _solve(problem: LinearStartUp, times_s: FloatArray, _: Settings) -> FloatArray:
    n = problem.n_state
    derivative = problem.motion.derivative
    states = np.zeros((len(times_s), n + 6))
    y, works = problem.start, np.zeros(6)
    states[times_s == 0.0, :n] = y
    for piece, start, end, inside in problem.pieces(times_s):
        propagator = Propagator(
            state=derivative[:, :n], drive=derivative[:, n:], taylor=problem.inputs.taylor[piece]
        )
        known: list[tuple[float, FloatArray, FloatArray]] = []
        z, now = propagator.lift(y, 0.0), start
        stops = [*times_s[inside], end] if not inside.size or times_s[inside[-1]] < end else times_s[inside]
        for i, stop in enumerate(stops):
            flow, integrals = _step(propagator, problem.forms, float(stop) - now, float(stop), known)
            works = works + (integrals @ z) @ z
            z, now = flow @ z, float(stop)
            if i < inside.size:
                states[inside[i], :n], states[inside[i], n:] = z[:n], works
        y = z[:n]
    return states


def _step(
    propagator: Propagator,
    forms: FloatArray,
    length_s: float,
    now_s: float,
    known: list[tuple[float, FloatArray, FloatArray]],
) -> tuple[FloatArray, FloatArray]:
    for length, flow, integrals in known:
        if abs(length - length_s) <= _SAME * now_s:
            return flow, integrals
    made = (length_s, propagator.step(length_s), propagator.integrals(forms, length_s))
    known.append(made)
    return made[1], made[2]


INTEGRATOR = Integrator(
    name="exact",
    meaning="matrix exponential; no error of discretisation at any stiffness, at the times asked for only",
    control="exact",
    solve=_solve,
)
