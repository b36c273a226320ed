"""Statistics of fitted parameters: scatter, covariance, identifiability, trends, likelihood and criteria.

Everything about a Jacobian comes from one decomposition, `decomposed`.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, nan, sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq
from scipy.special import fdtrc, stdtr

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.files.plain_text import GIVEN_DIGITS, STD_DIGITS, significant
from ropefric.fitting.problem import FitProblem
from ropefric.friction.condition import SETTINGS, Conditions, distinct

SMALLEST_SCATTER = 1e-9
"""Repeats that agree closer than this were not measured, or were copied; closer to a law, rounding."""
# Rounding of the Jacobian alone gives ratios of singular values up to this.
RANK_RATIO = 1e8
# A parameter whose slopes are below this has a variance that no float holds: it changes nothing.
_NOT_SEEN = 1e-150
# Part of a parameter in the weak direction from which it is named.
_TAKES_PART = 0.15
_RATIO_DECIMALS = 6
# Eigenvalues of a correlation matrix that are no more than rounding.
_UNSEEN = 1e-12
# Decimals of a correlation beside those its smallest eigenvalue needs, and the most that rounding leaves any.
_DECIMALS = 3
_MOST_DECIMALS = 17
_SAME = 1e-9
# Where there is no scatter at all, what is left over is rounding and where the search stopped: no trend.
_ROUNDING = 1e-9
# ln F of double precision is known no better than this.
_RESOLVED = 1e-12
# Of a residual, what fitting leaves of its own variance; with less it tells nothing.
_UNJUDGED = 1e-3
# Of the largest square, how far a variance may be off.
_EXACT = 1e-16
# Of a smooth function: its modes, how far it carries in parts of a setting's span, and what it needs to be seen.
_MODES, _SMOOTH_OVER, _SMOOTH_SPARE, _MOST_SMOOTH = 5, 0.5, 4, 400


# ---- scatter of ln F_A about a law ----


def furthest(residual: FloatArray, own: FloatArray, dof: int) -> tuple[int, float, float]:
    """Return which residual lies furthest off the others, by how many of their scatters, and its p-value.

    By deleted residuals: `own` (n,) is the part of its own variance that is left in each, `dof` what the others leave.
    """
    judged = own > _UNJUDGED
    square = np.where(judged, residual**2 / np.maximum(own, _UNJUDGED), 0.0)
    rest = np.maximum(float(residual @ residual) - square, 1e-300) / dof
    t = np.sqrt(square / rest)
    worst = int(np.argmax(t))
    return worst, float(t[worst]), min(1.0, 2.0 * residual.size * float(stdtr(dof, -t[worst])))


def group_means(values: FloatArray, group: IntArray) -> FloatArray:
    """Return the mean of each condition, shape (k,)."""
    return np.bincount(group, weights=values) / np.bincount(group)


# ---- what a Jacobian knows of its parameters ----


class Decomposition(NamedTuple):
    """J = U S V of columns scaled to unit length, so that nothing depends on the parameters' units."""

    length: FloatArray
    left: FloatArray
    values: FloatArray
    rows: FloatArray
    lost: BoolArray
    """Which combinations of the parameters change nothing."""

    @property
    def unseen(self) -> BoolArray:
        """Return which parameters belong to a combination that changes nothing, shape (q,)."""
        return np.asarray(np.abs(self.rows[self.lost]).max(axis=0, initial=0.0) > 1e-6)

    def root(self) -> tuple[FloatArray, FloatArray]:
        """Return H with H Hᵀ = (JᵀJ)⁻¹ and U with J = U H⁻¹, over the combinations that are seen."""
        seen = ~self.lost
        return self.rows.T[:, seen] / self.values[seen] / self.length[:, None], self.left[:, seen]


def decomposed(J: FloatArray) -> Decomposition:
    """Return the decomposition of J, shape (n, q)."""
    n, q = J.shape
    length = np.linalg.norm(J, axis=0)
    seen = length > _NOT_SEEN
    length = np.where(seen, length, 1.0)
    # Fewer points than parameters leave some combinations unseen: zero rows make them show up as zeros.
    padded = np.vstack([np.where(seen, J, 0.0) / length, np.zeros((max(q - n, 0), q))])
    left, values, rows = np.linalg.svd(padded, full_matrices=False)
    lost = values <= values.max(initial=0.0) / RANK_RATIO
    return Decomposition(length=length, left=left[:n], values=values, rows=rows, lost=lost)


def plain_covariance(J: FloatArray) -> FloatArray:
    """Return (JᵀJ)⁻¹, shape (q, q), the pseudo-inverse where combinations of parameters are not seen."""
    half, _ = decomposed(J).root()
    return np.asarray(half @ half.T)


def combined_dof(variance: FloatArray, parts: Iterable[tuple[FloatArray, float]]) -> FloatArray:
    """Return Welch and Satterthwaite's degrees of freedom of variances (t,).

    Of each part (t,) the degrees of freedom are given; the rest is known for sure.
    """
    unsure = sum((part**2 / dof for part, dof in parts), np.zeros_like(variance))
    with np.errstate(divide="ignore", invalid="ignore"):
        found = variance**2 / unsure
    return np.where(found > 0.0, found, inf)


def rounded_covariance(covariance: FloatArray) -> FloatArray:
    """Return a covariance to the digits that mean something, shape (q, q): standard errors to four.

    Correlations keep three decimals beyond the first of the smallest eigenvalue of their matrix, so that it stays
    positive definite and the best known combination of parameters keeps its error to a per cent or better.
    Combinations of which the covariance holds rounding only have no part in it.
    """
    if not np.isfinite(covariance).all():
        return covariance
    # Rounding may turn a variance of zero a hair negative.
    size = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    rounded, shown = np.zeros_like(covariance), np.flatnonzero(size)
    size, some = size[shown], np.ix_(shown, shown)
    correlation = covariance[some] / size[:, None] / size
    correlation = 0.5 * (correlation + correlation.T)
    eigenvalues = np.linalg.eigvalsh(correlation)
    smallest = float(eigenvalues[eigenvalues > _UNSEEN].min(initial=1.0))
    decimals = _DECIMALS - math.floor(math.log10(smallest))
    std = np.array([significant(value, STD_DIGITS) for value in size.tolist()])
    product = correlation.round(decimals) * std[:, None] * std
    product[np.diag_indices_from(product)] = std**2
    digits = min(max(GIVEN_DIGITS, decimals + 2), _MOST_DECIMALS)
    cells = [significant(cell, digits) for cell in product.ravel().tolist()]
    rounded[some] = np.array(cells).reshape(product.shape)
    return rounded


class Identifiability(NamedTuple):
    """How well data determine parameters."""

    ratio: float
    weak: tuple[str, ...]
    weak_direction: str
    unseen: tuple[str, ...]


def identify(jacobian: FloatArray, names: Sequence[str]) -> Identifiability:
    """Return how well a Jacobian determines its parameters (Belsley's condition number without centring)."""
    q = len(names)
    _, _, values, rows, lost = decomposed(jacobian)
    ratio = inf if lost.any() else float(values[0] / values[-1]) if q else 1.0
    weakest = dict(zip(names, rows[-1].tolist() if q else (), strict=True))
    unseen = np.abs(rows[lost]).max(axis=0, initial=0.0) > _TAKES_PART
    # Two parameters take part in equal shares: the last bits may not say which comes first.
    order = sorted(names, key=lambda name: -round(abs(weakest[name]), _RATIO_DECIMALS))
    weak = tuple(name for name in order if abs(weakest[name]) > _TAKES_PART)
    return Identifiability(
        ratio=significant(ratio, _RATIO_DECIMALS),
        weak=weak,
        weak_direction=_direction(weak, weakest),
        unseen=tuple(name for name, gone in zip(names, unseen, strict=True) if gone),
    )


def _direction(weak: tuple[str, ...], weakest: Mapping[str, float]) -> str:
    """Return in words how the parameters of the weakest combination move together."""
    if len(weak) < 2:
        return f"{weak[0]} alone" if weak else ""
    rising = [name for name in weak if weakest[name] * weakest[weak[0]] > 0]
    falling = [name for name in weak if name not in rising]
    text = f"{' and '.join(rising)} up"
    return f"{text} while {' and '.join(falling)} down" if falling else f"{text} together"


@dataclass(frozen=True, slots=True, kw_only=True)
class FitStatistics:
    """How well the law fits."""

    n: int
    n_conditions: int
    dof: int
    chi2: float
    chi2_reduced: float
    aicc: float
    bic: float
    scatter_within: float
    scatter_between: float
    interval_dof: float
    lack_of_fit_p: float = nan


# ---- dependences of the residuals ----


class Trend(NamedTuple):
    """Residuals that follow a regressor."""

    regressor: str
    size: float
    p_value: float


def find_trends(weighted: FitProblem, jacobian: FloatArray, residuals: FloatArray) -> tuple[Trend, ...]:
    """Return how far means follow each regressor beside the law's own parameters, the surest first.

    Linear and quadratic terms of the regressor are tested (F) against the residuals of the means, which their scatter
    weighs, so that a scatter between conditions alone makes no trend. A regressor with fewer than three values gets the
    linear term alone. Size and end tension may change ln F itself, or μ and so ln F in proportion to the wrap: the surer
    of both counts, with its p-value doubled. Last comes any smooth function of all three, `_smooth`.
    """
    basis, at = _basis(jacobian), weighted.conditions
    left = residuals - basis @ (basis.T @ residuals)
    regressors = {
        "wrap angle": at.wrap_angle_rad,
        "size ratio": at.size_ratio,
        "end tension": at.log_end_tension,
    }
    trends, varied = [], dict[str, FloatArray]()
    for name, values in regressors.items():
        span = np.ptp(values) if values.size else 0.0
        if span <= _SAME * np.abs(values).max(initial=1.0):
            continue
        x = varied[name] = (values - values.mean()) / span
        powers = (1,) if distinct(x + 2.0).size < 3 else (1, 2)
        shapes = (1.0,) if name == "wrap angle" else (1.0, at.wrap_angle_rad)
        found = [
            trend
            for shape in shapes
            if (trend := _explained(name, weighted, [shape * x**n for n in powers], basis, left)) is not None
        ]
        if found:
            surest = min(found, key=lambda trend: trend.p_value)
            trends.append(surest._replace(p_value=min(1.0, len(found) * surest.p_value)))
    smooth = _smooth(weighted, [*varied.values()], basis, left)
    return tuple(sorted([*trends, *smooth], key=lambda trend: trend.p_value))


def _explained(
    name: str, weighted: FitProblem, columns: list[FloatArray], basis: FloatArray, left: FloatArray
) -> Trend | None:
    """Return what columns beside a basis explain of the residuals; None where they hold nothing, or all."""
    extra = weighted.whitened(np.stack(columns)).T
    extra = _basis(extra - basis @ (basis.T @ extra), np.linalg.norm(extra, axis=0).max())
    explained = extra.T @ left
    more, dof = extra.shape[1], left.size - basis.shape[1] - extra.shape[1]
    rest = float(left @ left - explained @ explained)
    fitted = weighted.unwhitened(extra @ explained)
    size = sqrt(float(np.mean(fitted**2))) if fitted.size else 0.0
    if not more or dof < 1 or not rest > 0.0 or size < _ROUNDING:
        return None
    return Trend(name, size, float(fdtrc(more, dof, float(explained @ explained) / more / (rest / dof))))


def _smooth(
    weighted: FitProblem, settings: list[FloatArray], basis: FloatArray, left: FloatArray
) -> tuple[Trend, ...]:
    """Return how far means follow any smooth function of the settings: the leading modes of a Gaussian kernel.

    Which modes those are hangs on the settings alone and not on the forces, so that the F-test is exact.
    """
    dof = left.size - basis.shape[1]
    if not settings or dof < _SMOOTH_SPARE or left.size > _MOST_SMOOTH:
        return ()
    apart = sum((np.subtract.outer(x, x) / _SMOOTH_OVER) ** 2 for x in settings)
    kernel = weighted.whitened(weighted.whitened(np.exp(-0.5 * np.asarray(apart))).T)
    beside = kernel - basis @ (basis.T @ kernel)
    beside = beside - (beside @ basis) @ basis.T
    modes = np.linalg.eigh(0.5 * (beside + beside.T))[1][:, ::-1][:, : min(_MODES, dof // 2)]
    columns = map(weighted.unwhitened, modes.T)
    found = _explained("settings together", weighted, [*columns], basis, left)
    return () if found is None else (found,)


def _basis(columns: FloatArray, scale: float = 0.0) -> FloatArray:
    """Return orthonormal columns that span the given ones, without those that are only rounding."""
    length = np.linalg.norm(columns, axis=0)
    length = np.maximum(np.where(length > 0.0, length, 1.0), scale)
    left, values, _ = np.linalg.svd(columns / length, full_matrices=False)
    return np.asarray(left[:, values > _SAME * max(values.max(initial=0.0), 1.0)])


# ---- how good a law is for its number of parameters ----


def aicc(deviance: float, n: int, k: int) -> float:
    """Return Akaike's criterion with the small-sample term, deviance + 2k + 2k(k + 1)/(n − k − 1)."""
    return inf if n <= k + 1 else deviance + 2.0 * k + 2.0 * k * (k + 1) / (n - k - 1)


def bic(deviance: float, n: int, k: int) -> float:
    """Return Schwarz's criterion, deviance + k ln n; arguments as in `aicc`."""
    return deviance + k * math.log(n)


def akaike_weights(criteria: npt.ArrayLike) -> FloatArray:
    """Return the weights e^{−Δ/2}, summing to 1; zero where the criterion is not finite above, all zero if none is."""
    values = np.asarray(criteria, dtype=np.float64)
    values = np.where(np.isnan(values), inf, values)
    best = values.min(initial=inf)
    if best == inf:
        return np.zeros_like(values)
    # Two at −inf are no distance apart.
    with np.errstate(invalid="ignore"):
        weights = np.where(values == best, 1.0, np.exp(-0.5 * (values - best)))
    return np.asarray(weights / weights.sum())


def f_test(
    chi2_simpler: float, chi2_fuller: float, *, n: int, p_simpler: int, p_fuller: int
) -> tuple[float, tuple[int, int], float]:
    """Return F, its degrees of freedom and the p-value of two nested least-squares fits with the same weights."""
    extra, left = p_fuller - p_simpler, n - p_fuller
    F = max(chi2_simpler - chi2_fuller, 0.0) / extra / max(chi2_fuller / left, 1e-300)
    return F, (extra, left), float(fdtrc(extra, left, F))


@dataclass(frozen=True, slots=True, eq=False)
class ConditionMeans:
    """One mean ln F_A for each condition: the independent evidence about a law.

    Repeats of a condition share whatever makes that condition differ from the law, so only their mean bears on
    the law; their spread about the mean is the same for every law, and gives the error of that mean.
    """

    conditions: Conditions
    log_lift: FloatArray
    std: FloatArray
    size: IntArray
    scatter_within: float

    def __len__(self) -> int:
        return self.log_lift.size

    @property
    def repeated(self) -> bool:
        """Return whether any condition has repeats, so that `std` is absolute."""
        return not math.isnan(self.scatter_within)


def condition_means(problem: FitProblem) -> ConditionMeans:
    """Return the mean of every group of a problem, with the standard deviation its repeats give it.

    Conditions of one group are averaged like their forces, since settings repeat only nearly.
    """
    group, weight, at = problem.group, problem.std**-2.0, problem.conditions
    total = np.bincount(group, weight)

    def mean(values: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(group, weight * values) / total)

    # Of the rise, since a test that hangs the load on the tight side scatters in F_B instead.
    rise = problem.log_lift - at.log_end_tension
    about2 = (rise - mean(rise)[group]) ** 2
    spare = problem.n_points - problem.n_conditions
    within, std = nan, np.asarray(total**-0.5, dtype=np.float64)
    if spare > 0:
        within = sqrt(float(about2.sum()) / spare)
        # Repeats that agree exactly would make a mean infinitely well known.
        std = np.maximum(std * sqrt(float((weight * about2).sum()) / spare), _RESOLVED)
    settings = {name: mean(getattr(at, name)) for name in SETTINGS[:3]}
    conditions = Conditions(**settings, end_tension_N=np.exp(mean(at.log_end_tension)))
    return ConditionMeans(conditions, mean(problem.log_lift), std, np.bincount(group), within)


class ScatterFit(NamedTuple):
    """The scatter of condition means about a law that makes them likeliest: −2 ln L of it, and their variances."""

    deviance: float
    variance: FloatArray


def scatter_fit(residual: FloatArray, means: ConditionMeans) -> ScatterFit:
    """Return the likeliest scatter for residuals of the means, shape (K,).

    With repeats the variance of a mean is τ² + s_i², with s_i known from the repeats and τ ≥ 0 estimated: a law
    earns nothing by following the means closer than their repeats allow. Without repeats it is a multiple of
    s_i², estimated too; the deviance is then Σ ln s_i² + K ln(χ²/K).
    """
    squared, known = residual**2, means.std**2
    if not means.repeated:
        variance = np.maximum(float((squared / known).mean()) * known, _RESOLVED**2)
        return ScatterFit(float(np.log(variance).sum()), variance)

    def score(extra: float) -> float:
        variance = known + extra
        return float(((squared - variance) / variance**2).sum())

    most = float(squared.max())
    extra = brentq(score, 0.0, most, xtol=_EXACT * most) if score(0.0) > 0.0 else 0.0
    variance = known + extra
    return ScatterFit(float((np.log(variance) + squared / variance).sum()) - len(means), variance)
