"""What the adaptive methods of scipy share: one run for each piece of the drive, since its kinks spoil the order."""

from typing import Any, Literal

import numpy as np
from scipy.integrate import solve_ivp

from ropefric.errors import InputError, SolverError
from ropefric.systems.press.transient.integrators.integrator import Settings, check_steps
from ropefric.systems.press.transient.polynomial import FloatArray
from ropefric.systems.press.transient.problem import LinearStartUp

__all__ = ["solve_adaptively"]

_RATES_A_STEP = 12
_IMPLICIT_SHARE = 0.1
_EXPLICIT_SHARE = 0.01
"""What a step may err by, of the tensions: steps add up, and explicit ones on a stiff belt dance on the border of
their stability, where each keeps what the one before erred by."""


def solve_adaptively(
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

    Raises
    ------
    InputError
        If the tolerance is not between 1e-13 and 1.
    SolverError
        If the method gives up.
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
