"""LSODA of scipy: multistep, which changes between stiff and non-stiff by itself, with the analytic Jacobian."""

from functools import partial

from ropefric.systems.press.transient.integrators.adaptive import solve_adaptively
from ropefric.systems.press.transient.integrators.integrator import Integrator

__all__ = ["INTEGRATOR"]

INTEGRATOR = Integrator(
    name="lsoda",
    meaning="multistep, which changes between stiff and non-stiff by itself, with the analytic Jacobian",
    control="tolerance",
    solve=partial(solve_adaptively, method="LSODA", implicit=True),
)
