"""What an integrator is: a named way from a linear start-up to its states at given times."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from ropefric.errors import SolverError
from ropefric.systems.press.transient.polynomial import FloatArray
from ropefric.systems.press.transient.problem import LinearStartUp

__all__ = ["MOST_STEPS", "Integrator", "Settings", "check_steps"]

MOST_STEPS = 500_000
"""Of a start-up; each takes some 50 µs."""


def check_steps(needed: float) -> None:
    """Refuse a start-up of more steps than anybody waits for; return quietly otherwise.

    Raises
    ------
    SolverError
        RF524, with the limit.
    """
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
    """What integrators can be told; each reads what concerns it.

    Attributes
    ----------
    tolerance : float
        Relative error that a step of an adaptive method may make.
    step_s : float, optional
        Step of a method of fixed step [s]; by default a tenth of its limit of stability.
    """

    tolerance: float = 1e-6
    step_s: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Integrator:
    """A way to integrate.

    Attributes
    ----------
    name : str
        Its name.
    meaning : str
        What it is good for.
    control : {"exact", "step", "tolerance"}
        What sets its error.
    solve : callable
        `solve(problem, times_s, settings)` returns states beside works, shape (n_times, n_state + 6), at sorted
        times from 0 on.
    """

    name: str
    meaning: str
    control: Literal["exact", "step", "tolerance"]
    solve: Callable[[LinearStartUp, FloatArray, Settings], FloatArray]
