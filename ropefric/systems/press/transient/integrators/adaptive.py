"""What the adaptive methods of scipy share: one run for each piece of the drive, since its kinks spoil the order."""

from typing import Any, Literal

import numpy as np
from scipy.integrate import solve_ivp

from ropefric.errors import InputError, SolverError
from ropefric.systems.press.transient.integrators.integrator import Settings
from ropefric.systems.press.transient.polynomial import FloatArray
from ropefric.systems.press.transient.problem import LinearStartUp

__all__ = ["solve_adaptively"]


def solve_adaptively(
    problem: LinearStartUp,
    times_s: FloatArray,
    settings: Settings,
    *,
    method: Literal["DOP853", "Radau", "LSODA"],
    implicit: bool,
) -> FloatArray:
    """Return states beside works at sorted times, see `Integrator.solve`.

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
    states = np.zeros((len(times_s), problem.n_state + 6))
    y = np.concatenate([problem.start, np.zeros(6)])
    states[times_s == 0.0] = y
    for piece, start, end, inside in problem.pieces(times_s):
        stops = np.unique(np.append(times_s[inside], end))
        options: dict[str, Any] = {}
        if implicit:
            options["jac"] = lambda t, y, piece=piece: problem.jacobian(y, problem.input_at(piece, t))
        found = solve_ivp(
            lambda t, y, piece=piece: problem.rate(y, problem.input_at(piece, t)),
            (start, end),
            y,
            method=method,
            t_eval=stops,
            rtol=settings.tolerance,
            atol=settings.tolerance * problem.scale,
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
