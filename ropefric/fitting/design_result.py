"""What a design hands on: the smallest wrap, wheel or end tension found, or why there is none."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray

SolveFor = Literal["wrap", "radius", "end_tension"]

QUANTITIES = {
    "wrap": ("wrap_angle_rad", "rad"),
    "radius": ("wheel_radius_m", "m"),
    "end_tension": ("end_tension_N", "N"),
}
"""The name and unit of each quantity a design can look for."""


class DesignStatus(IntEnum):
    """What became of a design."""

    OK = 0
    LOWER_LIMIT = 1
    OUT_OF_REACH = 2
    TOO_UNCERTAIN = 3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Design:
    """Designs that lift a load; NaN where there is none.

    Attributes
    ----------
    solve_for : {"wrap", "radius", "end_tension"}
        What was looked for.
    value : ndarray, shape (n,)
        The smallest that does: φ [rad], R_w [m] or F_B [N].
    wheel_radius_m, rope_radius_m, wrap_angle_rad, end_tension_N : ndarray, shape (n,)
        The designs, `value` among them.
    required_N : ndarray, shape (n,)
        The load to lift [N].
    lift_force_N, lower_bound_N : ndarray, shape (n,)
        F_A of the mean law, and what one new rope exceeds with the probability [N].
    probability : float or None
        Probability that a new rope lifts the load; None: the mean law does.
    status : ndarray of int8, shape (n,)
        `DesignStatus`: OK; LOWER_LIMIT, the lower limit already does; OUT_OF_REACH, not even the upper limit does
        on average; TOO_UNCERTAIN, it does on average, but nowhere up to the limit with the probability.
    limits : tuple of float
        Where it was looked for.
    limit_lift_N, limit_bound_N : ndarray, shape (n,)
        F_A and lower bound at the upper limit, for those without a design [N].
    extrapolated : ndarray of bool, shape (n,)
        Whether the design lies outside what was tested.
    """

    solve_for: SolveFor
    value: FloatArray
    wheel_radius_m: FloatArray
    rope_radius_m: FloatArray
    wrap_angle_rad: FloatArray
    end_tension_N: FloatArray
    required_N: FloatArray
    lift_force_N: FloatArray
    lower_bound_N: FloatArray
    probability: float | None
    status: npt.NDArray[np.int8]
    limits: tuple[float, float]
    limit_lift_N: FloatArray
    limit_bound_N: FloatArray
    extrapolated: BoolArray

    def __len__(self) -> int:
        return self.value.size

    @property
    def reached(self) -> BoolArray:
        """Return which designs exist, shape (n,)."""
        return self.status <= DesignStatus.LOWER_LIMIT

    def explain(self, index: int = 0) -> str:
        """Return in words what became of one design."""
        name, unit = QUANTITIES[self.solve_for]
        need, high = f"{self.required_N[index]:.6g} N", f"{name} = {self.limits[1]:.6g} {unit}"
        code = DesignStatus(int(self.status[index]))
        if code is DesignStatus.OUT_OF_REACH:
            return (
                f"out of reach: even {high} lifts {self.limit_lift_N[index]:.6g} N on average, less than {need}; "
                "change another quantity or raise the limit"
            )
        if code is DesignStatus.TOO_UNCERTAIN:
            return (
                f"too uncertain: nothing up to {high} lifts {need} with a probability of {self.probability:g}; there "
                f"the mean is {self.limit_lift_N[index]:.6g} N and the bound {self.limit_bound_N[index]:.6g} N; "
                "measure nearer to the design, or accept a lower probability"
            )
        found = f"{name} = {self.value[index]:.6g} {unit}"
        if code is DesignStatus.LOWER_LIMIT:
            return f"the lower limit {found} already lifts {need}"
        return f"{found} lifts {need}" + (
            "" if self.probability is None else f" with probability {self.probability:g}"
        )

    def to_dict(self) -> dict[str, Any]:
        """Return a JSON tree: one object for one design, `{"designs": [...]}` for several."""
        rows = [self._row(i) for i in range(len(self))]
        return rows[0] if len(rows) == 1 else {"designs": rows}

    def _row(self, i: int) -> dict[str, Any]:
        names = (
            "wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N", "required_N", "lift_force_N",
            "lower_bound_N", "limit_lift_N", "limit_bound_N",
        )  # fmt: skip
        numbers = {name: float(getattr(self, name)[i]) for name in names}
        row: dict[str, Any] = {name: value if np.isfinite(value) else None for name, value in numbers.items()}
        return row | {
            "solve_for": self.solve_for,
            "probability": self.probability,
            "status": DesignStatus(int(self.status[i])).name.lower().replace("_", "-"),
            "explanation": self.explain(i),
            "extrapolated": bool(self.extrapolated[i]),
            "limits": list(self.limits),
        }
