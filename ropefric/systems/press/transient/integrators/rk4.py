"""The paper's method: classical Runge-Kutta of fourth order with a fixed step."""

import math

import numpy as np

from ropefric.errors import SolverError
from ropefric.systems.press.transient.integrators.integrator import Integrator, Settings, check_steps
from ropefric.systems.press.transient.polynomial import FloatArray
from ropefric.systems.press.transient.problem import LinearStartUp
from ropefric.systems.press.transient.spectrum import rk4_limit_s

__all__ = ["INTEGRATOR"]


def _solve(problem: LinearStartUp, times_s: FloatArray, settings: Settings) -> FloatArray:
    limit_s = rk4_limit_s(problem.eigenvalues)
    step_s = 0.1 * limit_s if settings.step_s is None else settings.step_s
    if not 0.0 < step_s <= limit_s:
        raise SolverError(
            f"the step of {step_s:.6g} s is not within RK4's limit of stability, {limit_s:.6g} s for this press",
            code="RF524",
            key="step_s",
            fix=f"take {limit_s:.4g} s or less, or the integrator 'exact' or 'radau'",
        )
    check_steps(float(times_s[-1]) / step_s)
    n = problem.n_state
    states = np.zeros((len(times_s), n + 6))
    y = np.concatenate([problem.start, np.zeros(6)])
    states[times_s == 0.0] = y
    for piece, start, end, inside in problem.pieces(times_s):
        now = start
        stops = [*times_s[inside], end] if not inside.size or times_s[inside[-1]] < end else times_s[inside]
        for i, stop in enumerate(stops):
            # The step is shortened a little so that every time asked for is met.
            count = max(1, math.ceil((float(stop) - now) / step_s * (1.0 - 1e-9)))
            h = (float(stop) - now) / count
            for k in range(count):
                y = _step(problem, y, piece, now + k * h, h)
            now = float(stop)
            if i < inside.size:
                states[inside[i]] = y
    return states


def _step(problem: LinearStartUp, y: FloatArray, piece: int, t: float, h: float) -> FloatArray:
    first, middle, last = (problem.input_at(piece, t + part * h) for part in (0.0, 0.5, 1.0))
    k1 = problem.rate(y, first)
    k2 = problem.rate(y + 0.5 * h * k1, middle)
    k3 = problem.rate(y + 0.5 * h * k2, middle)
    k4 = problem.rate(y + h * k3, last)
    return np.asarray(y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4))


INTEGRATOR = Integrator(
    name="rk4",
    meaning="classical Runge-Kutta with a fixed step, the paper's method; refuses an unstable step",
    control="step",
    solve=_solve,
)
