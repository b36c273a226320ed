"""The inverse of a prediction: the smallest wrap, wheel or end tension that lifts a load with a given probability."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.fitting.design_result import QUANTITIES, Design, DesignStatus, SolveFor
from ropefric.fitting.design_search import CHUNK, DesignSearch, LiftBound
from ropefric.fitting.extrapolation import outside_range
from ropefric.fitting.problem import FloatArray
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import Conditions

__all__ = ["DesignChart", "design", "design_chart"]


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

    Parameters
    ----------
    fit : FitResult
        The fit.
    lift_N : array_like, scalar or shape (n,)
        Load to lift [N], positive.
    rope_radius_m, wheel_radius_m, wrap_angle_rad, end_tension_N : array_like, scalar or shape (n,)
        The other quantities; the one looked for is left out.
    solve_for : {"wrap", "radius", "end_tension"}
        What is looked for.
    probability : float, optional
        Probability, 0.5 or more and below 1, that one pull with one new rope lifts the load: the one-sided lower
        prediction bound η − t √(J C Jᵀ + scatter²) reaches ln F. None: the mean law lifts it.
    limits : tuple of float, optional
        Where to look, SI; `LIMITS` by default.

    Raises
    ------
    InputError
        If quantities are missing or too many, a number is out of range, the law does not depend on what is looked
        for, or the fit knows no scatter and a probability is asked for.

    Notes
    -----
    ln F_A rises with each of the three, so the mean law has one crossing, found by Newton's method in brackets. The
    bound may fall again where extrapolation widens it; the first crossing above that of the mean is taken.

    Examples
    --------
    >>> from ropefric.fitting.fit import fit_law
    >>> from ropefric.fitting.table import TrialTable
    >>> table = TrialTable(
    ...     trial=tuple("abcd"), wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=[3.0, 3.0, 6.0, 6.0],
    ...     end_tension_N=20, peak_N=[36.0, 36.8, 66.0, 66.7],
    ... )
    >>> found = design(
    ...     fit_law(table, "constant"), lift_N=60, rope_radius_m=0.005, wheel_radius_m=0.04, end_tension_N=20,
    ...     probability=None,
    ... )
    >>> found.explain()
    'wrap_angle_rad = 5.49825 rad lifts 60 N'
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
    """Lift forces over wheel radius and wrap at one end tension.

    Attributes
    ----------
    wheel_radius_m : ndarray, shape (r,)
        Rows [m].
    wrap_angle_rad : ndarray, shape (w,)
        Columns [rad].
    rope_radius_m, end_tension_N : float
        The same everywhere.
    lift_force_N : ndarray, shape (r, w)
        F_A of the mean law [N]; NaN where the law has no answer, infinite where the force overflows.
    lower_bound_N : ndarray, shape (r, w)
        What one new rope exceeds with the probability [N].
    probability : float
        That probability.
    extrapolated : ndarray of bool, shape (r, w)
        Where the chart leaves what was tested.
    """

    wheel_radius_m: FloatArray
    wrap_angle_rad: FloatArray
    rope_radius_m: float
    end_tension_N: float
    lift_force_N: FloatArray
    lower_bound_N: FloatArray
    probability: float
    extrapolated: npt.NDArray[np.bool_]


def design_chart(
    fit: FitResult,
    wheel_radius_m: npt.ArrayLike,
    wrap_angle_rad: npt.ArrayLike,
    end_tension_N: float,
    *,
    rope_radius_m: float,
    probability: float = 0.95,
) -> DesignChart:
    """Return lift force and lower bound over a grid of r wheel radii [m] and w wraps [rad].

    Raises
    ------
    InputError
        If a number is out of range, or the fit knows no scatter.
    """
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
