"""Bootstrap of a fit: thousands of resamples, refitted in one batch; and fits with intervals found in another way."""

from dataclasses import dataclass, replace
from math import isfinite
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

from ropefric.arrays import FloatArray
from ropefric.errors import FitError, InputError, UnknownNameError
from ropefric.files.digits import to_share
from ropefric.fitting.levenberg import batched_fit
from ropefric.fitting.problem import MANY, FitProblem, pooled
from ropefric.fitting.profile import profile_intervals
from ropefric.fitting.result import FitResult
from ropefric.fitting.statistics import TwoLevelScatter, plain_covariance, two_level_scatter
from ropefric.registry import did_you_mean

BootstrapKind = Literal["parametric", "clustered"]

INTERVALS = ("covariance", "profile", "bootstrap")
"""Ways to the 95 % intervals of the parameters."""

_WORTH_A_NOTE = 0.025
_MOST_RESAMPLES = 1_000_000
# With fewer conditions than this, drawing whole conditions gives intervals that are too narrow.
_ENOUGH_TO_DRAW = 20
_NORMAL = 1.959963984540054


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BootstrapResult:
    """Parameters of the refitted resamples, and what they say of the fit."""

    best: FloatArray
    theta: FloatArray
    std: FloatArray
    n_failed: int
    scatter: TwoLevelScatter
    notes: tuple[str, ...]

    def interval(self, level: float = 0.95) -> FloatArray:
        """Return the percentile interval of every parameter at a level between 0 and 1, shape (p, 2)."""
        if not 0.0 < level < 1.0:
            raise InputError(f"the level is {level:g}; it must lie between 0 and 1", key="level", fix="0.95")
        return np.quantile(self.theta, [(1.0 - level) / 2.0, (1.0 + level) / 2.0], axis=0).T


def bootstrap(
    problem: FitProblem,
    theta: npt.ArrayLike,
    *,
    kind: BootstrapKind = "parametric",
    n: int = 2000,
    seed: int | np.random.Generator = 0,
    scatter: tuple[float, float] | None = None,
) -> BootstrapResult:
    """Return the spread of a fit over resampled data sets, all refitted in one batch.

    "parametric" draws scatter about the law, at two levels; "clustered" draws whole conditions.
    """
    best = np.asarray(theta, dtype=np.float64)
    law, (p,) = problem.law, problem.start.shape
    if best.shape != (p,):
        raise InputError(f"theta has shape {best.shape}; law {law.name} needs {(p,)}")
    if not 2 <= n <= _MOST_RESAMPLES:
        what = "has no spread" if n < 2 else f"is too large: {_MOST_RESAMPLES} is the limit"
        raise InputError(f"a bootstrap of {n} resamples {what}", key="n", fix="take 2000")
    rng = np.random.default_rng(seed)
    levels = two_level_scatter(problem, best) if scatter is None else TwoLevelScatter(*scatter)
    if not all(np.isfinite(value) and value >= 0.0 for value in levels):
        raise InputError(
            f"the scatter within and between conditions is ({levels.within:g}, {levels.between:g})",
            key="scatter",
            fix="give standard deviations of ln F_A, zero or more",
        )
    share: float | FloatArray = 1.0
    if problem.n_points >= MANY:
        problem, share = pooled(problem)
    group = np.unique(problem.group, return_inverse=True)[1]
    k, q = int(group.max()) + 1, problem.n_varying
    if kind == "parametric":
        lift = law.log_lift(best, problem.conditions)
        shared = rng.standard_normal((n, k))[:, group]
        own = rng.standard_normal((n, lift.size))
        fits = batched_fit(problem, lift + levels.between * shared + levels.within * share * own, best)
        good = fits.converged
    elif kind == "clustered":
        if k <= q:
            raise InputError(
                f"{k} conditions cannot be resampled for the {q} fitted parameters of {law.name}",
                key="kind",
                fix="take kind='parametric', or measure more conditions",
            )
        counts = rng.multinomial(k, np.full(k, 1.0 / k), size=n)
        fits = batched_fit(problem, None, best, multiplicity=counts[:, group])
        good = fits.converged & ((counts > 0).sum(axis=1) >= q)
    else:
        raise UnknownNameError(
            f"unknown kind of bootstrap {kind!r}", fix=did_you_mean(str(kind), get_args(BootstrapKind))
        )
    refits = fits.theta[good]
    failed = n - len(refits)
    if len(refits) < 2:
        raise FitError(
            f"{law.name}: only {len(refits)} of {n} resamples could be refitted",
            fix="take a law with fewer parameters, or measure more conditions",
        )
    notes = []
    if failed > _WORTH_A_NOTE * n:
        notes.append(
            f"{failed} of {n} resamples could not be refitted; the intervals speak for the others only"
        )
    at_bound = ((refits <= problem.lower) | (refits >= problem.upper)).mean(axis=0) * problem.vary
    notes += [
        f"{name} is at a bound in {100 * part:.0f} % of the refits, so its interval is one-sided there"
        for name, part in zip(law.parameter_names, at_bound, strict=True)
        if part > _WORTH_A_NOTE
    ]
    return BootstrapResult(
        best=best,
        theta=refits,
        std=refits.std(axis=0, ddof=1) * problem.vary,
        n_failed=failed,
        scatter=levels,
        notes=tuple(notes),
    )


def with_intervals(fit: FitResult, method: str, *, n: int = 2000, seed: int = 0) -> FitResult:
    """Return a fit with `ci95` of its parameters found in another way; all else stays, standard errors too."""
    if method not in INTERVALS:
        raise UnknownNameError(
            f"unknown way to intervals {method!r}", key="intervals", fix=did_you_mean(method, INTERVALS)
        )
    if method == "covariance":
        return fit
    problem = fit.data
    if fit.provenance.get("settings", {}).get("loss", "linear") != "linear":
        raise InputError(
            f"{method} intervals are those of least squares, not of a robust loss",
            key="intervals",
            fix="use loss = 'linear', or intervals = 'covariance'",
        )
    how: dict[str, str | int] = {"method": method}
    if method == "profile":
        ends, notes = _profile(fit, problem)
    else:
        found = fit.statistics
        many = found.n_conditions >= max(_ENOUGH_TO_DRAW, problem.n_varying + 1)
        repeated = found.n_conditions < found.n
        drawn = bootstrap(
            problem, fit.theta, kind="clustered" if many and repeated else "parametric", n=n, seed=seed
        )
        ends, notes = drawn.interval(), drawn.notes
        how |= {"n": n, "seed": seed}
    parameters = tuple(
        replace(item, ci95=(to_share(float(low), item.std), to_share(float(high), item.std)))
        if item.vary
        else item
        for item, (low, high) in zip(fit.parameters, ends, strict=True)
    )
    return replace(
        fit,
        parameters=parameters,
        notes=(*fit.notes, f"95 % intervals by {method}", *notes),
        provenance=dict(fit.provenance) | {"intervals": how},
    )


def _profile(fit: FitResult, problem: FitProblem) -> tuple[FloatArray, tuple[str, ...]]:
    if fit.covariance_kind == "scaled":
        found = profile_intervals(problem, fit.theta)
        return found.ci, found.notes
    # χ² believes in independent trials and a normal quantile; the fit's own covariance and Student's t know better.
    variance = np.diag(fit.covariance)
    shown = variance > 0.0
    plain = np.zeros_like(variance)
    plain[shown] = np.diag(plain_covariance(problem.jacobian(fit.theta)[:, shown]))
    ratio = np.divide(variance, plain, out=np.ones_like(variance), where=plain > 0.0)
    ratio = np.where(np.isfinite(ratio) & (ratio > 0.0), ratio, 1.0)
    dof = fit.statistics.interval_dof
    quantile = float(stdtrit(dof, 0.975)) if isfinite(dof) and dof > 0 else _NORMAL
    found = profile_intervals(problem, fit.theta, scale=ratio * (quantile / _NORMAL) ** 2, absolute_std=True)
    return found.ci, found.notes
