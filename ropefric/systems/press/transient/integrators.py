"""Ways from a linear start-up to its states at given times: the exact one, and those it is compared with."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np
from scipy.integrate import solve_ivp

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, SolverError
from ropefric.registry import Registry
from ropefric.systems.press.transient.exponential import Propagator
from ropefric.systems.press.transient.problem import LinearStartUp
from ropefric.systems.press.transient.spectrum import rk4_limit_s

MOST_STEPS = 500_000
"""Of a start-up; each takes some 50 µs."""


def check_steps(needed: float) -> None:
    """Refuse a start-up of more steps than anybody waits for; return quietly otherwise."""
    if not needed <= MOST_STEPS:
        raise SolverError(
            f"the start-up takes more than {MOST_STEPS} steps, the limit: its fastest oscillation, or the step or"
            " tolerance asked for, is too short for the time simulated",
            code="RF524",
            key="start_up.simulate",
            fix="simulate a shorter time, or correct the inertias, masses and stiffnesses",
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """What integrators can be told; each reads what concerns it."""

    tolerance: float = 1e-6
    step_s: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Integrator:
    """A way to integrate."""

    name: str
    meaning: str
    control: Literal["exact", "step", "tolerance"]
    solve: Callable[[LinearStartUp, FloatArray, Settings], FloatArray]


_SAME_STEP = 1e-12
"""Steps that differ by less, against the time reached, are one step: times on a grid are rounded."""


def _by_exponentials(problem: LinearStartUp, times_s: FloatArray, _: Settings) -> FloatArray:
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
            flow, integrals = _flow_over(propagator, problem.forms, float(stop) - now, float(stop), known)
            works = works + (integrals @ z) @ z
            z, now = flow @ z, float(stop)
            if i < inside.size:
                states[inside[i], :n], states[inside[i], n:] = z[:n], works
        y = z[:n]
    return states


def _flow_over(
    propagator: Propagator,
    forms: FloatArray,
    length_s: float,
    now_s: float,
    known: list[tuple[float, FloatArray, FloatArray]],
) -> tuple[FloatArray, FloatArray]:
    for length, flow, integrals in known:
        if abs(length - length_s) <= _SAME_STEP * now_s:
            return flow, integrals
    made = (length_s, propagator.step(length_s), propagator.integrals(forms, length_s))
    known.append(made)
    return made[1], made[2]


_EXACT = Integrator(
    name="exact",
    meaning="matrix exponential; no error of discretisation at any stiffness, at the times asked for only",
    control="exact",
    solve=_by_exponentials,
)


def _by_rk4(problem: LinearStartUp, times_s: FloatArray, settings: Settings) -> FloatArray:
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
                y = _rk4_step(problem, y, piece, now + k * h, h)
            now = float(stop)
            if i < inside.size:
                states[inside[i]] = y
    return states


def _rk4_step(problem: LinearStartUp, y: FloatArray, piece: int, t: float, h: float) -> FloatArray:
    first, middle, last = (problem.input_at(piece, t + part * h) for part in (0.0, 0.5, 1.0))
    k1 = problem.rate(y, first)
    k2 = problem.rate(y + 0.5 * h * k1, middle)
    k3 = problem.rate(y + 0.5 * h * k2, middle)
    k4 = problem.rate(y + h * k3, last)
    return np.asarray(y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4))


_RK4 = Integrator(
    name="rk4",
    meaning="classical Runge-Kutta with a fixed step, the paper's method; refuses an unstable step",
    control="step",
    solve=_by_rk4,
)


_RATES_A_STEP = 12
_IMPLICIT_SHARE = 0.1
_EXPLICIT_SHARE = 0.01
"""What a step may err by, of the tensions: steps add up, and explicit ones on a stiff belt dance on the border of
their stability, where each keeps what the one before erred by."""


def _adaptively(
    problem: LinearStartUp,
    times_s: FloatArray,
    settings: Settings,
    *,
    method: Literal["DOP853", "Radau", "LSODA"],
    implicit: bool,
) -> FloatArray:
    """Return states beside works at sorted times, see `Integrator.solve`.

    Steps are such that the tensions, too, are off by no more than some times the tolerance, however stiff the belt;
    where nothing damps it, errors add up over the periods.
    """
    if not 1e-13 <= settings.tolerance < 1.0:
        raise InputError(
            f"the tolerance is {settings.tolerance:g}; it must lie between 1e-13 and 1", key="tolerance"
        )
    share = _IMPLICIT_SHARE if implicit else _EXPLICIT_SHARE
    absolute = settings.tolerance * np.minimum(problem.scale, share * _tension_scale(problem))
    states = np.zeros((len(times_s), problem.n_state + 6))
    y = np.concatenate([problem.start, np.zeros(6)])
    states[times_s == 0.0] = y
    asked = 0
    for piece, start, end, inside in problem.pieces(times_s):
        stops = np.unique(np.append(times_s[inside], end))
        options: dict[str, Any] = {}

        def rate(t: float, y: FloatArray, piece: int = piece) -> FloatArray:
            nonlocal asked
            asked += 1
            check_steps(asked / _RATES_A_STEP)
            return problem.rate(y, problem.input_at(piece, t))

        if implicit:
            options["jac"] = lambda t, y, piece=piece: problem.jacobian(y, problem.input_at(piece, t))
        found = solve_ivp(
            rate,
            (start, end),
            y,
            method=method,
            t_eval=stops,
            rtol=settings.tolerance,
            atol=absolute,
            **options,
        )
        if not found.success:
            raise SolverError(
                f"{method} gave up at t = {found.t[-1] if found.t.size else start:.6g} s: {found.message}",
                code="RF524",
                fix="take the integrator 'exact'",
            )
        states[inside] = found.y.T[: inside.size]
        y = found.y[:, -1]
    return states


def _tension_scale(problem: LinearStartUp) -> FloatArray:
    """Return what changes a tension by as much as there is at rest, for each state; infinite for works.

    The tension is T_0 + k (e + η de/dt): on a stiff, damped belt a speed that is small beside the drive's is a large
    tension, so that an error of the states alone says little of the tensions.
    """
    rows = np.abs(problem.motion.tension_N[:, : problem.n_state])
    with np.errstate(divide="ignore"):
        ways = (problem.model.preload_N[:, np.newaxis] / rows).min(axis=0)
    return np.concatenate([ways, np.full(6, np.inf)])


_DOP853 = Integrator(
    name="dop853",
    meaning="explicit Runge-Kutta of eighth order; for small errors where nothing is stiff",
    control="tolerance",
    solve=partial(_adaptively, method="DOP853", implicit=False),
)


_RADAU = Integrator(
    name="radau",
    meaning="implicit Runge-Kutta of fifth order with the analytic Jacobian; for stiff, damped belts",
    control="tolerance",
    solve=partial(_adaptively, method="Radau", implicit=True),
)


_LSODA = Integrator(
    name="lsoda",
    meaning="multistep, which changes between stiff and non-stiff by itself, with the analytic Jacobian",
    control="tolerance",
    solve=partial(_adaptively, method="LSODA", implicit=True),
)


INTEGRATORS: Registry[Integrator] = Registry("integrator", [_EXACT, _RK4, _DOP853, _RADAU, _LSODA])
"""The integrators; the first is the default."""
