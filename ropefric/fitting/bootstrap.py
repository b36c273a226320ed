"""Bootstrap of a fit: thousands of resamples, refitted in one batch."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import FitError, InputError, UnknownNameError
from ropefric.fitting.levenberg import BatchFit, batched_fit
from ropefric.fitting.problem import FitProblem
from ropefric.fitting.reduced import MANY, pooled
from ropefric.fitting.scatter import TwoLevelScatter, two_level_scatter
from ropefric.registry import did_you_mean

BootstrapKind = Literal["parametric", "clustered"]
IntervalMethod = Literal["percentile", "basic"]

# In standard errors: what separates two refits says nothing at a millionth of their spread.
_TOLERANCE = 1e-9
_WORTH_A_NOTE = 0.025
_MOST_RESAMPLES = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BootstrapResult:
    """Parameters of the refitted resamples, and what they say of the fit."""

    kind: BootstrapKind
    best: FloatArray
    theta: FloatArray
    std: FloatArray
    ci95: FloatArray
    ci95_basic: FloatArray
    n_failed: int
    scatter: TwoLevelScatter
    notes: tuple[str, ...]
    lower: FloatArray
    upper: FloatArray

    def interval(self, level: float = 0.95, method: IntervalMethod = "percentile") -> FloatArray:
        """Return the interval of every parameter at a level between 0 and 1, shape (p, 2)."""
        if method not in get_args(IntervalMethod):
            raise UnknownNameError(
                f"unknown interval method {method!r}", fix=did_you_mean(str(method), get_args(IntervalMethod))
            )
        return _interval(self.theta, self.best, level, method, (self.lower, self.upper))


def bootstrap(
    problem: FitProblem,
    theta: npt.ArrayLike,
    *,
    kind: BootstrapKind = "parametric",
    n: int = 2000,
    seed: int | np.random.Generator = 0,
    scatter: TwoLevelScatter | tuple[float, float] | None = None,
) -> BootstrapResult:
    """Return the spread of a fit over resampled data sets, all refitted in one batch."""
    best = np.asarray(theta, dtype=np.float64)
    if best.shape != problem.start.shape:
        raise InputError(f"theta has shape {best.shape}; law {problem.law.name} needs {problem.start.shape}")
    if not 2 <= n <= _MOST_RESAMPLES:
        what = "has no spread" if n < 2 else f"is too large: {_MOST_RESAMPLES} is the limit"
        raise InputError(f"a bootstrap of {n} resamples {what}", key="n", fix="take 2000")
    rng = np.random.default_rng(seed)
    levels = two_level_scatter(problem, best) if scatter is None else _checked(scatter)
    enough = np.ones(n, dtype=np.bool_)
    share: float | FloatArray = 1.0
    if problem.n_points >= MANY:
        problem, share = pooled(problem)
    if kind == "parametric":
        fits = _refit_drawn_scatter(problem, best, levels, share, (n, rng))
    elif kind == "clustered":
        fits, enough = _refit_drawn_conditions(problem, best, n, rng)
    else:
        raise UnknownNameError(
            f"unknown kind of bootstrap {kind!r}", fix=did_you_mean(str(kind), get_args(BootstrapKind))
        )
    good = fits.converged & enough
    refits = fits.theta[good]
    if len(refits) < 2:
        raise FitError(
            f"{problem.law.name}: only {len(refits)} of {n} resamples could be refitted",
            fix="take a law with fewer parameters, or measure more conditions",
        )
    bounds = (problem.lower, problem.upper)
    return BootstrapResult(
        kind=kind,
        best=best,
        theta=refits,
        std=refits.std(axis=0, ddof=1) * problem.vary,
        ci95=_interval(refits, best, 0.95, "percentile", bounds),
        ci95_basic=_interval(refits, best, 0.95, "basic", bounds),
        n_failed=n - len(refits),
        scatter=levels,
        notes=_notes(problem, refits, n),
        lower=problem.lower,
        upper=problem.upper,
    )


def _refit_drawn_scatter(
    problem: FitProblem,
    best: FloatArray,
    levels: TwoLevelScatter,
    share: float | FloatArray,
    draw: tuple[int, np.random.Generator],
) -> BatchFit:
    n, rng = draw
    _, group = np.unique(problem.group, return_inverse=True)
    lift = problem.law.log_lift(best, problem.conditions)
    shared = rng.standard_normal((n, int(group.max()) + 1))[:, group]
    own = rng.standard_normal((n, lift.size))
    return batched_fit(
        problem, lift + levels.between * shared + levels.within * share * own, best, tolerance=_TOLERANCE
    )


def _refit_drawn_conditions(
    problem: FitProblem, best: FloatArray, n: int, rng: np.random.Generator
) -> tuple[BatchFit, BoolArray]:
    _, group = np.unique(problem.group, return_inverse=True)
    k, p = int(group.max()) + 1, problem.n_varying
    if k <= p:
        raise InputError(
            f"{k} conditions cannot be resampled for the {p} fitted parameters of {problem.law.name}",
            key="kind",
            fix="take kind='parametric', or measure more conditions",
        )
    counts = rng.multinomial(k, np.full(k, 1.0 / k), size=n)
    fits = batched_fit(problem, None, best, multiplicity=counts[:, group], tolerance=_TOLERANCE)
    return fits, (counts > 0).sum(axis=1) >= p


def _checked(scatter: TwoLevelScatter | tuple[float, float]) -> TwoLevelScatter:
    levels = scatter
    if not isinstance(levels, TwoLevelScatter):
        levels = TwoLevelScatter(within=levels[0], between=levels[1])
    if not all(np.isfinite(value) and value >= 0.0 for value in (levels.within, levels.between)):
        raise InputError(
            f"the scatter within and between conditions is ({levels.within:g}, {levels.between:g})",
            key="scatter",
            fix="give standard deviations of ln F_A, zero or more",
        )
    return levels


def _interval(
    refits: FloatArray,
    best: FloatArray,
    level: float,
    method: IntervalMethod,
    bounds: tuple[FloatArray, FloatArray],
) -> FloatArray:
    if not 0.0 < level < 1.0:
        raise InputError(f"the level is {level:g}; it must lie between 0 and 1", key="level", fix="0.95")
    low, high = np.quantile(refits, [(1.0 - level) / 2.0, (1.0 + level) / 2.0], axis=0)
    if method == "basic":
        low, high = np.clip(2.0 * best - high, *bounds), np.clip(2.0 * best - low, *bounds)
    return np.stack([low, high], axis=-1)


def _notes(problem: FitProblem, refits: FloatArray, n: int) -> tuple[str, ...]:
    notes = []
    failed = n - len(refits)
    if failed > _WORTH_A_NOTE * n:
        notes.append(
            f"{failed} of {n} resamples could not be refitted; the intervals speak for the others only"
        )
    at_bound = ((refits <= problem.lower) | (refits >= problem.upper)).mean(axis=0) * problem.vary
    notes += [
        f"{name} is at a bound in {100 * share:.0f} % of the refits, so its interval is one-sided there"
        for name, share in zip(problem.law.parameter_names, at_bound, strict=True)
        if share > _WORTH_A_NOTE
    ]
    return tuple(notes)
