"""How good a law is for its number of parameters: likelihood of the condition means, AICc, BIC, weights, F-test."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import fdtrc

from ropefric.arrays import FloatArray, IntArray
from ropefric.errors import InputError
from ropefric.fitting.problem import FitProblem
from ropefric.friction.condition import Conditions

_HALVINGS = 200
# ln F of double precision is known no better than this.
_RESOLVED = 1e-12


def least_squares_deviance(rss: float, n: int) -> float:
    """Return n ln(RSS/n): −2 ln L of n equal, unknown scatters, without the n (1 + ln 2π) all laws share."""
    return n * math.log(rss / n) if rss > 0.0 else -math.inf


def aicc(deviance: float, n: int, k: int) -> float:
    """Return Akaike's criterion with the small-sample term, deviance + 2k + 2k(k + 1)/(n − k − 1)."""
    if n <= k + 1:
        return math.inf
    return deviance + 2.0 * k + 2.0 * k * (k + 1) / (n - k - 1)


def bic(deviance: float, n: int, k: int) -> float:
    """Return Schwarz's criterion, deviance + k ln n; arguments as in `aicc`."""
    return deviance + k * math.log(n)


def akaike_weights(criteria: npt.ArrayLike) -> FloatArray:
    """Return the weights e^{−Δ/2}, summing to 1; zero where the criterion is not finite above, all zero if none is."""
    values = np.asarray(criteria, dtype=np.float64)
    usable = ~np.isnan(values) & (values < np.inf)
    if not usable.any():
        return np.zeros_like(values)
    best = values[usable].min()
    if best == -np.inf:
        weights = np.where(values == -np.inf, 1.0, 0.0)
    else:
        weights = np.where(usable, np.exp(-0.5 * (np.where(usable, values, best) - best)), 0.0)
    total: FloatArray = weights / weights.sum()
    return total


@dataclass(frozen=True, slots=True, kw_only=True)
class FTest:
    """Whether a law's extra parameters explain more than chance."""

    simpler: str
    fuller: str
    f: float
    dof: tuple[int, int]
    p_value: float


def f_test(
    chi2_simpler: float, chi2_fuller: float, *, n: int, p_simpler: int, p_fuller: int
) -> tuple[float, tuple[int, int], float]:
    """Return F, its degrees of freedom and the p-value of two nested least-squares fits with the same weights."""
    extra, left = p_fuller - p_simpler, n - p_fuller
    if extra < 1 or left < 1:
        raise InputError(
            f"no F-test of {p_simpler} against {p_fuller} parameters on {n} observations",
            fix="the fuller law needs more parameters than the simpler one, and fewer than there are observations",
        )
    gained = max(chi2_simpler - chi2_fuller, 0.0) / extra
    spread = chi2_fuller / left
    F = gained / max(spread, 1e-300)
    return F, (extra, left), float(fdtrc(extra, left, F))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ConditionMeans:
    """One mean ln F_A for each condition: the independent evidence about a law.

    Repeats of a condition share whatever makes that condition differ from the law, so only their mean bears on
    the law; their spread about the mean is the same for every law and tells how well the mean is known.
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
    _labels, group = np.unique(problem.group, return_inverse=True)
    K, weight = int(group.max()) + 1, problem.std**-2.0
    total = np.bincount(group, weight, K)

    def mean(values: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(group, weight * values, K) / total)

    at = problem.conditions
    log_lift = mean(problem.log_lift)
    # Of the rise, since a test that hangs the load on the tight side scatters in F_B instead.
    rise = problem.log_lift - at.log_end_tension
    spread = rise - mean(rise)[group]
    size, spare = np.bincount(group, minlength=K), problem.n_points - K
    within, std = math.nan, np.asarray(total**-0.5, dtype=np.float64)
    if spare > 0:
        scale = float((weight * spread**2).sum()) / spare
        within = math.sqrt(float((spread**2).sum()) / spare)
        # Repeats that agree exactly would make a mean infinitely well known.
        std = np.maximum(std * math.sqrt(scale), _RESOLVED)
    return ConditionMeans(
        conditions=Conditions(
            wheel_radius_m=mean(at.wheel_radius_m),
            rope_radius_m=mean(at.rope_radius_m),
            wrap_angle_rad=mean(at.wrap_angle_rad),
            end_tension_N=np.exp(mean(at.log_end_tension)),
        ),
        log_lift=log_lift,
        std=std,
        size=size.astype(np.int64),
        scatter_within=within,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ScatterFit:
    """The scatter of condition means about a law that makes them likeliest."""

    deviance: float
    variance: FloatArray
    between: float


def scatter_fit(residual: FloatArray, means: ConditionMeans) -> ScatterFit:
    """Return the likeliest scatter for residuals of the means, shape (K,).

    With repeats the variance of a mean is τ² + s_i², with s_i known from the repeats and τ ≥ 0 estimated: a law
    earns nothing by following the means closer than their repeats allow. Without repeats it is a multiple of
    s_i², estimated too; the deviance is then Σ ln s_i² + K ln(χ²/K).
    """
    K, known = len(means), means.std**2
    if not means.repeated:
        variance = np.maximum(float((residual**2 / known).sum()) / K * known, _RESOLVED**2)
        return ScatterFit(
            deviance=float(np.log(variance).sum()), variance=variance, between=math.sqrt(variance.mean())
        )
    extra = _between_variance(residual**2, known)
    variance = known + extra
    deviance = float((np.log(variance) + residual**2 / variance).sum()) - K
    return ScatterFit(deviance=deviance, variance=variance, between=math.sqrt(extra))


def _between_variance(squared: FloatArray, known: FloatArray) -> float:
    """Return the τ² ≥ 0 of greatest likelihood, by bisection of its score from the largest sensible value down."""

    def score(extra: float) -> float:
        variance = known + extra
        return float(((squared - variance) / variance**2).sum())

    low, high = 0.0, float(squared.max())
    if high <= 0.0 or score(0.0) <= 0.0:
        return 0.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if score(middle) > 0.0 else (low, middle)
        if high - low <= 1e-12 * high:
            break
    return 0.5 * (low + high)
