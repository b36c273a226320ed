"""How well conditions fix a law's parameters: information from conditions whose means scatter at two levels."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError, UnknownNameError
from ropefric.fitting.result import FitResult
from ropefric.fitting.statistics import RANK_RATIO
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.registry import did_you_mean


@dataclass(frozen=True, slots=True, kw_only=True)
class MeanScatter:
    """How the mean of a condition's repeats scatters."""

    within: float
    between: float = 0.0
    instrument_N: float = 0.0

    def __post_init__(self) -> None:
        numbers = (self.within, self.between, self.instrument_N)
        if not all(math.isfinite(x) and x >= 0.0 for x in numbers) or not any(numbers):
            raise InputError(
                f"scatter within {self.within:g}, between {self.between:g}, instrument {self.instrument_N:g} N",
                key="scatter",
                fix="give standard deviations of ln F from 0, one above it: 0.017 is 1.7 % between repeats",
            )

    def variance(self, log_lift: FloatArray, repeats: npt.ArrayLike) -> FloatArray:
        """Return the variance of mean ln F_A of conditions, s_b² + s_w²/m + (u/F_A)², shape (n,)."""
        m = np.asarray(repeats, dtype=np.float64)
        return np.asarray(self.between**2 + self.within**2 / m + (self.instrument_N * np.exp(-log_lift)) ** 2)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlannedLaw:
    """A law at the parameters a plan is made for, and what is known of them already."""

    law: FrictionLaw
    theta: FloatArray
    free: BoolArray
    scatter: MeanScatter
    known: FloatArray
    tested: Conditions | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.free.any():
            raise InputError(
                f"every parameter of {self.law.name} is held, so tests have nothing to determine", key="fixed"
            )

    @property
    def n_free(self) -> int:
        """Return the number q of parameters to determine."""
        return int(np.count_nonzero(self.free))

    @property
    def free_names(self) -> tuple[str, ...]:
        """Return their names."""
        return tuple(np.array(self.law.parameter_names)[self.free].tolist())

    def gradients(self, conditions: Conditions) -> FloatArray:
        """Return ∂ ln F_A/∂θ by the free parameters, shape (n, q)."""
        return np.asarray(self.law.jacobian(self.theta, conditions)[:, self.free])

    def rows(self, conditions: Conditions, repeats: npt.ArrayLike) -> FloatArray:
        """Return gradients over the standard deviation of a mean, shape (n, q): Σ rows rowsᵀ is the information."""
        log_lift, slopes = self.law.log_lift_and_jacobian(self.theta, conditions)
        return np.asarray(slopes[:, self.free] / np.sqrt(self.scatter.variance(log_lift, repeats))[:, None])


def planned_guess(
    law: FrictionLaw, guess: Mapping[str, float], scatter: MeanScatter, *, fixed: tuple[str, ...] = ()
) -> PlannedLaw:
    """Return a law at guessed parameters, nothing of them known yet."""
    theta = law.theta_from(guess)
    for name in fixed:
        if name not in law.parameter_names:
            raise UnknownNameError(
                f"{law.name} has no parameter {name!r}", fix=did_you_mean(name, law.parameter_names)
            )
    free = np.array([not item.fixed and item.name not in fixed for item in law.parameters])
    return PlannedLaw(
        law=law, theta=theta, free=free, scatter=scatter, known=np.zeros((0, int(np.count_nonzero(free))))
    )


def planned_fit(
    fit: FitResult,
    *,
    within: float | None = None,
    between: float | None = None,
    instrument_N: float | None = None,
) -> PlannedLaw:
    """Return a fitted law with the conditions it was fitted to, which the new tests add to."""
    found, notes = fit.statistics, []
    if within is None:
        within = found.scatter_within
    if between is None:
        between = found.scatter_between
    if not math.isfinite(within):
        raise InputError(
            "the fit has no repeats, so it does not know the scatter of one trial",
            key="scatter_within",
            fix='give it, such as --scatter-within "1.7 %"',
        )
    if not math.isfinite(between):
        between = 0.0
        notes.append("the fit cannot tell the scatter between conditions: none is assumed")
    if not fit.trials.get("n"):
        raise InputError("the fit does not list its conditions", key="fit", fix="fit the trials again")
    if instrument_N is None:
        chain_N = np.array(fit.trials["peak_std_N"], dtype=np.float64)
        instrument_N = float(np.median(chain_N[np.isfinite(chain_N)])) if np.isfinite(chain_N).any() else 0.0
    scatter = MeanScatter(within=within, between=between, instrument_N=instrument_N)
    tested = Conditions(
        **{
            name: np.array(fit.trials[name], dtype=np.float64)
            for name in ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N")
        }
    )
    theta = np.asarray(fit.theta)
    free = np.array([item.vary and not item.at_bound for item in fit.parameters], dtype=bool)
    held = [item.name for item in fit.parameters if item.vary and item.at_bound]
    if held:
        notes.append(f"{', '.join(held)} lies on a bound in the fit and is held there")
    bare = PlannedLaw(
        law=fit.friction_law,
        theta=theta,
        free=free,
        scatter=scatter,
        known=np.zeros((0, int(np.count_nonzero(free)))),
        tested=tested,
        notes=tuple(notes),
    )
    return replace(bare, known=bare.rows(tested, np.array(fit.trials["n"])))


def expected_std(planned: PlannedLaw, rows: FloatArray, wanted: Conditions) -> FloatArray:
    """Return the standard error of ln F_A that rows of information give at conditions, shape (n,).

    Infinite where the rows leave undetermined what the prediction needs.
    """
    targets = planned.gradients(wanted)
    if not len(rows):
        return np.full(len(wanted), np.inf)
    length = np.linalg.norm(rows, axis=0)
    length = np.where(length > 0.0, length, 1.0)
    _, values, turn = np.linalg.svd(rows / length, full_matrices=True)
    values = np.concatenate([values, np.zeros(rows.shape[1] - values.size)])
    along = (targets / length) @ turn.T
    seen = values > values[0] / RANK_RATIO
    needed = np.abs(along[:, ~seen]) > 1e-6 * np.linalg.norm(along, axis=1)[:, None]
    std = np.linalg.norm(along[:, seen] / values[seen], axis=1)
    return np.where(needed.any(axis=1), np.inf, std)
