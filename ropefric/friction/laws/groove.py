"""A V-groove wedges the rope: the coefficient acts as μ/sin(half angle)."""

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction.condition import Conditions
from ropefric.friction.law import Columns, FrictionLaw, Parameter, Sheet, Slopes
from ropefric.friction.laws.constant import Uniform, mu_times_wrap

_HALF_ANGLE_RAD = float(np.radians(20.0))


class Groove(Uniform):
    """The physics of μ/sin(half angle)."""

    def mu(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return the coefficient."""
        mu, half_angle = columns
        return mu / np.sin(half_angle) + 0.0 * conditions.wrap_angle_rad

    def mu_slopes(self, columns: Columns, _conditions: Conditions) -> Slopes:
        """Return its derivatives."""
        mu, half_angle = columns
        sine = np.sin(half_angle)
        return 1.0 / sine, -mu * np.cos(half_angle) / sine**2


def _by_hand(sheet: Sheet) -> float:
    sheet.line("mu/sin(half angle)", "mu/sin(half_angle)", "mu")
    return mu_times_wrap(sheet)


def _candidates(mu: float, _conditions: Conditions, _log_lift: FloatArray) -> list[list[float]]:
    return [[mu * np.sin(_HALF_ANGLE_RAD), _HALF_ANGLE_RAD]]


LAW = FrictionLaw(
    name="groove",
    equation="F_A = F_B exp(mu phi/sin(half_angle))",
    source="V-groove form of Euler's equation",
    parameters=(
        Parameter("mu", "-", 0.07, 0.0, 5.0, "coefficient at the flanks of the groove"),
        Parameter("half_angle", "rad", _HALF_ANGLE_RAD, 0.02, float(np.pi / 2),
                  "half the groove's angle; only mu/sin(half_angle) is seen, so measure it and hold it fixed",
                  fixed=True),
    ),
    coefficient="average",
    effects=frozenset({"groove"}),
    weakens=True,
    physics=Groove(),
    candidates=_candidates,
    arithmetic=_by_hand,
)  # fmt: skip
