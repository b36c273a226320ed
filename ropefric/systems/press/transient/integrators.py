"""The linear start-up, and ways to its states at given times: the exact one, and those it is compared with."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any, Literal

import numpy as np
from scipy.integrate import solve_ivp

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, SolverError
from ropefric.systems.press.transient.drives import SPEED, Inputs
from ropefric.systems.press.transient.exact import HybridSolver, check_steps
from ropefric.systems.press.transient.motion import (
    ElasticPress,
    Motion,
    starting_state,
    sticking,
)


class LinearStartUp:
    """A start-up in which no belt slips or goes slack: dy/dt = A y + B u(t).

    Attributes
    ----------
    n_state, start
        Size of the state y = (q, dq/dt), and y at t = 0.
    scale
        What counts as large for each state, for absolute tolerances, shape (n_state,).
    tension_scale
        What changes a tension by as much as there is at rest, for each state. The tension is T_0 + k (e + η de/dt): on
        a stiff, damped belt a speed that is small beside the drive's is a large tension, so that an error of the states
        alone says little of the tensions.
    """

    def __init__(self, model: ElasticPress, inputs: Inputs) -> None:
        self.model, self.inputs = model, inputs
        self.motion = Motion(model, sticking(model))
        self.start = starting_state(self.motion, inputs)
        self.n_state = len(self.start)
        way = float((model.preload_N / model.stiffness_N_m).max())
        speed = max(float(np.abs(inputs.taylor[:, SPEED, 0]).max()), 1e-3)
        self.scale = np.repeat([way, speed], self.motion.n_coordinates)
        with np.errstate(divide="ignore"):
            ways = model.preload_N[:, np.newaxis] / np.abs(self.motion.tension_N[:, : self.n_state])
        self.tension_scale = ways.min(axis=0)

    @property
    def matrix(self) -> FloatArray:
        """Return A [1/s], shape (n_state, n_state)."""
        return self.motion.derivative[:, : self.n_state]

    @property
    def eigenvalues(self) -> np.ndarray:
        """Return the eigenvalues of A [1/s]."""
        return np.linalg.eigvals(self.matrix)

    def rate(self, y: FloatArray, u: FloatArray) -> FloatArray:
        """Return dy/dt, shape (n_state,)."""
        return np.asarray(self.motion.derivative @ np.concatenate([y, u]))


def _exact(problem: LinearStartUp, times_s: FloatArray) -> FloatArray:
    """Take matrix exponentials: no error of discretisation at any stiffness, at the times asked for only."""
    return HybridSolver(problem.model, problem.inputs, None, drags=False).run(times_s)[1]


Advance = Callable[[int, float, FloatArray, FloatArray], FloatArray]
"""(piece of the drive, its start, stops inside it, state at its start) to the states at the stops."""


def _piece_by_piece(problem: LinearStartUp, times_s: FloatArray, advance: Advance) -> FloatArray:
    """Carry the state through the pieces of the drive, and return it at sorted times."""
    y = problem.start
    states = np.zeros((len(times_s), len(y)))
    states[times_s == 0.0] = y
    starts = problem.inputs.starts_s
    for piece, (start, next_start) in enumerate(zip(starts, [*starts[1:], np.inf], strict=True)):
        if start >= times_s[-1]:
            break
        inside = np.flatnonzero((times_s > start) & (times_s <= next_start))
        stops = np.unique(np.append(times_s[inside], min(next_start, times_s[-1])))
        found = advance(piece, float(start), stops, y)
        states[inside], y = found[: inside.size], found[-1]
    return states


def rk4_limit_s(eigenvalues: np.ndarray) -> float:
    """Return the greatest step at which the classical Runge-Kutta method does not amplify any motion [s].

    |1 + z + z²/2 + z³/6 + z⁴/24| ≤ 1 has to hold for z = hλ of every eigenvalue. Seen from 0 the region's border is
    more than 2 away in every direction of the left half-plane, 2√2 along the imaginary axis.
    """
    limits = [_border(value / abs(value)) / abs(value) for value in eigenvalues if abs(value) > 0.0]
    return float(min(limits, default=np.inf))


def _border(direction: complex) -> float:
    # |R|² − 1 is a polynomial in the distance; its root at 0 is divided out.
    series = direction ** np.arange(5) / np.array([1.0, 1.0, 2.0, 6.0, 24.0])
    roots = np.roots(np.convolve(series, series.conj()).real[:0:-1])
    real = roots[np.abs(roots.imag) <= 1e-6 * np.abs(roots)].real
    return float(real[real > 1.5].min()) if (real > 1.5).any() else 2.0 * np.sqrt(2.0)


def _rk4(problem: LinearStartUp, times_s: FloatArray, *, step_s: float) -> FloatArray:
    """Take the classical Runge-Kutta method with a fixed step, the paper's; an unstable step is refused."""
    limit_s = rk4_limit_s(problem.eigenvalues)
    if not 0.0 < step_s <= limit_s:
        raise SolverError(
            f"the step of {step_s:.6g} s is not within RK4's limit of stability, {limit_s:.6g} s for this press",
            code="RF524",
            key="step_s",
            fix=f"take {limit_s:.4g} s or less",
        )
    check_steps(float(times_s[-1]) / step_s)

    def advance(piece: int, start: float, stops: FloatArray, y: FloatArray) -> FloatArray:
        now, found = start, []
        for stop in stops.tolist():
            # The step is shortened a little so that every time asked for is met.
            count = max(1, math.ceil((stop - now) / step_s * (1.0 - 1e-9)))
            h = (stop - now) / count
            for k in range(count):
                first, middle, last = problem.inputs.at(now + (k + np.array([0.0, 0.5, 1.0])) * h, piece)
                k1 = problem.rate(y, first)
                k2 = problem.rate(y + 0.5 * h * k1, middle)
                k3 = problem.rate(y + 0.5 * h * k2, middle)
                k4 = problem.rate(y + h * k3, last)
                y = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            now = stop
            found.append(y)
        return np.array(found)

    return _piece_by_piece(problem, times_s, advance)


_RATES_A_STEP = 12
_SHARES = {"DOP853": 0.01, "Radau": 0.1, "LSODA": 0.1}
"""Largest error of a step, as a fraction of the tensions: steps add up, and explicit ones on a stiff belt are at the
limit of their stability, where each keeps the error of the one before."""


def _adaptive(
    problem: LinearStartUp,
    times_s: FloatArray,
    *,
    method: Literal["DOP853", "Radau", "LSODA"],
    tolerance: float,
) -> FloatArray:
    """Take a method of scipy; the implicit ones with A as their Jacobian.

    Steps are such that the tensions, too, are off by no more than some times the tolerance, however stiff the belt;
    where nothing damps it, errors add up over the periods.
    """
    if not 1e-13 <= tolerance < 1.0:
        raise InputError(f"the tolerance is {tolerance:g}; it must lie between 1e-13 and 1", key="tolerance")
    absolute = tolerance * np.minimum(problem.scale, _SHARES[method] * problem.tension_scale)
    asked = 0

    def advance(piece: int, start: float, stops: FloatArray, y: FloatArray) -> FloatArray:
        def rate(t: float, y: FloatArray) -> FloatArray:
            nonlocal asked
            asked += 1
            check_steps(asked / _RATES_A_STEP)
            return problem.rate(y, problem.inputs.at(t, piece))

        options: dict[str, Any] = {}
        if method != "DOP853":
            options["jac"] = lambda t, y: problem.matrix  # noqa: ARG005  (it is constant)
        found = solve_ivp(
            rate,
            (start, float(stops[-1])),
            y,
            method=method,
            t_eval=stops,
            rtol=tolerance,
            atol=absolute,
            **options,
        )
        if not found.success:
            raise SolverError(
                f"{method} gave up at t = {found.t[-1] if found.t.size else start:.6g} s: {found.message}",
                code="RF524",
                fix="take another method",
            )
        return np.asarray(found.y.T)

    return _piece_by_piece(problem, times_s, advance)


INTEGRATORS: dict[str, Callable[..., FloatArray]] = {
    "exact": _exact,
    "rk4": _rk4,
    "dop853": partial(
        _adaptive, method="DOP853"
    ),  # explicit, eighth order: small errors where nothing is stiff
    "radau": partial(_adaptive, method="Radau"),  # implicit, fifth order: stiff, damped belts
    "lsoda": partial(_adaptive, method="LSODA"),  # multistep, changes between stiff and non-stiff by itself
}
"""Return states at sorted times, shape (n_times, n_state)."""
