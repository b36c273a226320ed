"""DOP853 of scipy: explicit Runge-Kutta of eighth order; for small errors where nothing is stiff."""

from functools import partial

from ropefric.systems.press.transient.integrators.adaptive import solve_adaptively
from ropefric.systems.press.transient.integrators.integrator import Integrator

__all__ = ["INTEGRATOR"]

INTEGRATOR = Integrator(
    name="dop853",
    meaning="explicit Runge-Kutta of eighth order; for small errors where nothing is stiff",
    control="tolerance",
    solve=partial(solve_adaptively, method="DOP853", implicit=False),
)
