"""Every integrator by name; one file declares one integrator."""

from ropefric.registry import Registry
from ropefric.systems.press.transient.integrators import dop853, exact, lsoda, radau, rk4
from ropefric.systems.press.transient.integrators.integrator import Integrator, Settings

__all__ = ["INTEGRATORS", "Settings"]

INTEGRATORS: Registry[Integrator] = Registry(
    "integrator",
    [exact.INTEGRATOR, rk4.INTEGRATOR, dop853.INTEGRATOR, radau.INTEGRATOR, lsoda.INTEGRATOR],
)
"""The integrators; the first is the default."""
