"""Radau of scipy: implicit Runge-Kutta of fifth order with the analytic Jacobian; for stiff, damped belts."""

from functools import partial

from ropefric.systems.press.transient.integrators.adaptive import solve_adaptively
from ropefric.systems.press.transient.integrators.integrator import Integrator

__all__ = ["INTEGRATOR"]

INTEGRATOR = Integrator(
    name="radau",
    meaning="implicit Runge-Kutta of fifth order with the analytic Jacobian; for stiff, damped belts",
    control="tolerance",
    solve=partial(solve_adaptively, method="Radau", implicit=True),
)
