"""A least-squares problem in ln F_A: what every way of fitting and of judging a fit works on."""

from dataclasses import dataclass

import numpy as np

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import InputError
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitProblem:
    """Measured ln F_A, the law to fit, and what is known about both.

    The scatter of break-away forces is multiplicative, so ln F_A is fitted by weighted least squares through the
    wrap integral (rope_wheel §5); nothing is ever differentiated numerically from data.
    """

    law: FrictionLaw
    conditions: Conditions
    log_lift: FloatArray
    std: FloatArray
    group: IntArray
    start: FloatArray
    lower: FloatArray
    upper: FloatArray
    vary: BoolArray

    def __post_init__(self) -> None:
        n, p = self.log_lift.size, len(self.law.parameters)
        if not (len(self.conditions) == n == self.std.size == self.group.size):
            raise InputError(
                f"{n} forces for {len(self.conditions)} conditions, {self.std.size} standard deviations and "
                f"{self.group.size} group numbers",
                code="RF400",
            )
        if not (self.start.size == self.lower.size == self.upper.size == self.vary.size == p):
            raise InputError(f"law {self.law.name} has {p} parameters", code="RF400")
        if n and not (self.std > 0).all():
            raise InputError(
                f"the standard deviation of point {int(np.argmin(self.std))} (the first is 0) is not positive",
                code="RF400",
            )

    @property
    def n_points(self) -> int:
        """Return the number of points n."""
        return int(self.log_lift.size)

    @property
    def n_varying(self) -> int:
        """Return the number of fitted parameters."""
        return int(np.count_nonzero(self.vary))

    def residuals(self, theta: FloatArray) -> FloatArray:
        """Return (model − measured)/std: shape (n,) for theta of shape (p,), (m, n) for (m, p)."""
        return (self.law.log_lift(theta, self.conditions) - self.log_lift) / self.std

    def jacobian(self, theta: FloatArray) -> FloatArray:
        """Return the derivatives of the residuals by all p parameters, shape (n, p) or (m, n, p)."""
        return self.law.jacobian(theta, self.conditions) / self.std[:, None]

    def residuals_and_jacobian(self, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return `residuals` and `jacobian`, the law evaluated once for both."""
        log_lift, slopes = self.law.log_lift_and_jacobian(theta, self.conditions)
        return (log_lift - self.log_lift) / self.std, slopes / self.std[:, None]
