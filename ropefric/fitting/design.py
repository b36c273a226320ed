"""The inverse of a prediction: the smallest wrap, wheel or end tension that lifts a load with a given probability."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.fitting.design_result import QUANTITIES, Design, DesignStatus, SolveFor
from ropefric.fitting.design_search import CHUNK, DesignSearch, LiftBound
from ropefric.fitting.predict import outside_range
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import Conditions


def design(
    fit: FitResult,
    *,
    lift_N: npt.ArrayLike,
    rope_radius_m: npt.ArrayLike,
    wheel_radius_m: npt.ArrayLike | None = None,
    wrap_angle_rad: npt.ArrayLike | None = None,
    end_tension_N: npt.ArrayLike | None = None,
    solve_for: SolveFor = "wrap",
    probability: float | None = 0.95,
    limits: tuple[float, float] | None = None,
) -> Design:
    """Return the smallest wrap, wheel radius or end tension that lifts a load, for n designs at once.

    ln F_A rises with each of the three, so the mean law has one crossing, found by Newton's method in brackets. The
    bound may fall again where extrapolation widens it; the first crossing above that of the mean is taken.
    """
    search = DesignSearch.checked(
        fit, solve_for, probability, limits,
        lift_N=lift_N, rope_radius_m=rope_radius_m, wheel_radius_m=wheel_radius_m, wrap_angle_rad=wrap_angle_rad,
        end_tension_N=end_tension_N,
    )  # fmt: skip
    n = search.log_load.size
    parts = [search.solve(slice(first, min(first + CHUNK, n))) for first in range(0, n, CHUNK)]
    x, status, eta, bound, at_limit, bound_at_limit = (
        np.concatenate(part) for part in zip(*parts, strict=True)
    )
    arrays = dict(search.given)
    arrays[QUANTITIES[solve_for][0]] = x
    reached = status <= DesignStatus.LOWER_LIMIT
    extrapolated = np.zeros(n, dtype=np.bool_)
    if reached.any():
        chosen = Conditions(**{name: values[reached] for name, values in arrays.items()})
        extrapolated[reached] = outside_range(fit.validity, chosen).any(axis=1)
    with np.errstate(over="ignore"):
        return Design(
            solve_for=solve_for,
            value=x,
            required_N=np.exp(search.log_load),
            lift_force_N=np.exp(eta),
            lower_bound_N=np.exp(bound),
            probability=probability,
            status=status.astype(np.int8),
            limits=search.limits,
            limit_lift_N=np.exp(at_limit),
            limit_bound_N=np.exp(bound_at_limit),
            extrapolated=extrapolated,
            **arrays,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DesignChart:
    """Lift forces over wheel radius and wrap at one end tension."""

    wheel_radius_m: FloatArray
    wrap_angle_rad: FloatArray
    rope_radius_m: float
    end_tension_N: float
    lift_force_N: FloatArray
    lower_bound_N: FloatArray
    probability: float
    extrapolated: BoolArray


def design_chart(
    fit: FitResult,
    wheel_radius_m: npt.ArrayLike,
    wrap_angle_rad: npt.ArrayLike,
    end_tension_N: float,
    *,
    rope_radius_m: float,
    probability: float = 0.95,
) -> DesignChart:
    """Return lift force and lower bound over a grid of r wheel radii [m] and w wraps [rad]."""
    radii, wraps = (
        np.atleast_1d(np.asarray(wheel_radius_m, float)),
        np.atleast_1d(np.asarray(wrap_angle_rad, float)),
    )
    grid = np.meshgrid(radii, wraps, indexing="ij")
    conditions = Conditions(
        wheel_radius_m=grid[0].ravel(),
        rope_radius_m=np.array(rope_radius_m),
        wrap_angle_rad=grid[1].ravel(),
        end_tension_N=np.array(end_tension_N),
    )
    bound = LiftBound.of(fit, probability)
    found = [
        bound.evaluate(conditions.select(np.arange(first, min(first + CHUNK, len(conditions)))))
        for first in range(0, len(conditions), CHUNK)
    ]
    eta, lower = (np.concatenate(part) for part in zip(*found, strict=True))
    with np.errstate(over="ignore"):
        return DesignChart(
            wheel_radius_m=radii,
            wrap_angle_rad=wraps,
            rope_radius_m=float(rope_radius_m),
            end_tension_N=float(end_tension_N),
            lift_force_N=np.exp(eta).reshape(grid[0].shape),
            lower_bound_N=np.exp(lower).reshape(grid[0].shape),
            probability=probability,
            extrapolated=outside_range(fit.validity, conditions).any(axis=1).reshape(grid[0].shape),
        )
