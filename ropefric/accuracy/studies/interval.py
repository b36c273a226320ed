"""The 95 % interval of a fitted coefficient by covariance, profile and draws: its ends, and its coverage.

Both laws have one parameter and an exponent per radian that is estimated linearly, so the exact interval is known.
"""

from collections.abc import Callable
from functools import cache, partial

import numpy as np
import numpy.typing as npt
from scipy.special import ndtri

from ropefric.accuracy.study import Case, Measured, Outcome, Setting, Study, against, over_seeds, time_text
from ropefric.arrays import FloatArray
from ropefric.fitting.intervals import profile_intervals
from ropefric.fitting.problem import FitProblem
from ropefric.fitting.statistics import plain_covariance
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import LAWS
from ropefric.uncertainty.budget import joint_draws

SIZE_SHARE = 0.25
"""A = R_r/(R_w + R_r) of the wheel of both cases."""

WRAPS_RAD = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0)
LEVEL = 0.95
N_SEEDS = 12
N_CAMPAIGNS = 200
_FACTOR = float(ndtri(0.5 + 0.5 * LEVEL))

_COUNTS = (100, 300, 1000, 3000, 10_000, 30_000)
_SCATTER = {"constant": 0.02, "thickness": 0.4}
_TRUTH = {"constant": 0.2, "thickness": 0.5}


def mu_of_exponent(law: str, exponent: npt.ArrayLike) -> FloatArray:
    """Return the coefficient for an exponent per radian λ: μ = λ, or λ/(1 − A − A λ²) for a thick rope.

    The second solves λ = [−1 + √(1 + 4Aμ²(1 − A))]/(2Aμ) for μ.
    """
    found = np.asarray(exponent, dtype=np.float64)
    if law == "constant":
        return found
    return found / (1.0 - SIZE_SHARE - SIZE_SHARE * found**2)


@cache
def interval_problem(law: str) -> FitProblem:
    """Return six pulls of known scatter with residuals that are fixed, so that the estimate is not the truth."""
    chosen, n = LAWS[law], len(WRAPS_RAD)
    pulls = Conditions(
        wheel_radius_m=np.full(n, 0.03),
        rope_radius_m=np.full(n, 0.01),
        wrap_angle_rad=np.array(WRAPS_RAD),
        end_tension_N=np.full(n, 20.0),
    )
    truth, scatter = [_TRUTH[law]], _SCATTER[law]
    residual = scatter * np.sin(1.0 + 2.0 * np.arange(n))
    return FitProblem.plain(chosen, pulls, chosen.log_lift(truth, pulls) + residual, scatter, truth)


def exact_interval(law: str) -> tuple[float, float, float]:
    """Return the estimate of μ and the exact ends of its 95 % interval.

    ln(F_A/F_B) = λφ is linear in λ, whose interval is therefore Σφy/Σφ² ± 1.96 σ/√Σφ²; μ(λ) is increasing, so the
    ends of the interval of μ are those of λ, seen through it.
    """
    problem, phi = interval_problem(law), np.array(WRAPS_RAD)
    rise = problem.log_lift - np.log(problem.conditions.end_tension_N)
    best = phi @ rise / (phi @ phi)
    half_width = _FACTOR * _SCATTER[law] / np.sqrt(phi @ phi)
    middle, low, high = mu_of_exponent(law, [best, best - half_width, best + half_width]).tolist()
    return middle, low, high


def by_covariance(problem: FitProblem, theta: FloatArray, _: int = 0) -> FloatArray:
    """Return the ends of the interval of μ by the covariance of the estimate."""
    half_width = _FACTOR * np.sqrt(plain_covariance(problem.jacobian(theta))[0, 0])
    return np.asarray(theta + half_width * np.array([-1.0, 1.0]))


def by_profile(problem: FitProblem, theta: FloatArray, _: int = 0) -> FloatArray:
    """Return the ends of the interval of μ by the profile of the likelihood."""
    return np.asarray(profile_intervals(problem, theta, level=LEVEL).ci[0])


def by_draws(problem: FitProblem, theta: FloatArray, seed: int = 0, *, n: int) -> FloatArray:
    """Return the ends of the interval of μ by the quantiles of a lift force over n draws of the estimate."""
    root, rng = np.sqrt(plain_covariance(problem.jacobian(theta))), np.random.default_rng(seed)
    draws = joint_draws(theta, root, dof=np.inf, n=n, rng=rng)
    pull = problem.conditions.select(np.array([2]))
    lifts = problem.law.log_lift(np.clip(draws, problem.lower, problem.upper), pull)[:, 0]
    ends = np.percentile(lifts, [50.0 * (1.0 - LEVEL), 50.0 * (1.0 + LEVEL)])
    return mu_of_exponent(problem.law.name, (ends - pull.log_end_tension) / pull.wrap_angle_rad)


def _settings(law: str) -> tuple[Setting, ...]:
    problem = interval_problem(law)
    estimate, low, high = exact_interval(law)
    theta, exact = np.array([estimate]), np.array([estimate - low, high - estimate])

    def arms(find: Callable[[FitProblem, FloatArray], FloatArray]) -> FloatArray:
        below, above = find(problem, theta)
        return np.array([estimate - below, above - estimate])

    def drawn(n: int) -> Setting:
        def assess() -> Outcome:
            errors = [arms(partial(by_draws, n=n, seed=seed)) / exact - 1.0 for seed in range(N_SEEDS)]
            return over_seeds(np.concatenate(errors), float(n))

        call = partial(by_draws, problem, theta, n=n)
        return Setting("monte carlo", f"n = {n}", call, assess, n in _COUNTS[:3:2])

    n_profile = profile_intervals(problem, theta, level=LEVEL).n_fits
    return (
        *against(exact, "covariance", "", partial(arms, by_covariance), work=1.0),
        *against(exact, "profile", "", partial(arms, by_profile), work=n_profile),
        *map(drawn, _COUNTS),
    )


def _coverage_settings(law: str) -> tuple[Setting, ...]:
    """Return each kind of interval with the shares of campaigns in which it includes the truth or lies beside it.

    An interval depends on the pulls by the estimate of λ alone, which is normal about the truth. The campaigns have
    the quantiles of that normal distribution as estimates.
    """
    problem, truth, phi = interval_problem(law), _TRUTH[law], np.array(WRAPS_RAD)
    log_end = problem.conditions.log_end_tension
    rate = ((problem.law.log_lift([truth], problem.conditions) - log_end) / phi)[0]
    quantiles = ndtri((np.arange(N_CAMPAIGNS) + 0.5) / N_CAMPAIGNS)
    rates = rate + _SCATTER[law] / np.sqrt(phi @ phi) * quantiles
    campaigns = [
        (FitProblem.plain(problem.law, problem.conditions, log_end + one * phi, _SCATTER[law], mu), mu, seed)
        for seed, (one, mu) in enumerate(zip(rates, mu_of_exponent(law, rates)[:, np.newaxis], strict=True))
    ]

    def setting(method: str, name: str, find: Callable[..., FloatArray], work: float) -> Setting:
        def assess() -> Outcome:
            low, high = np.array([find(*one) for one in campaigns]).T
            below, above = float(np.mean(high < truth)), float(np.mean(truth < low))
            tail = 0.5 * (1.0 - LEVEL)
            # One campaign more or less is the smallest difference that can be counted.
            error = max(abs(below - tail), abs(above - tail), 1.0 / N_CAMPAIGNS)
            shares = {"coverage": 1.0 - below - above, "too_low": below, "too_high": above}
            return Outcome(error=error, evaluations=work, shares=shares)

        return Setting(method, name, partial(find, *campaigns[N_CAMPAIGNS // 2]), assess)

    n_profile = profile_intervals(*campaigns[N_CAMPAIGNS // 2][:2], level=LEVEL).n_fits
    return (
        setting("covariance", "", by_covariance, 1.0),
        setting("profile", "", by_profile, float(n_profile)),
        *(setting("monte carlo", f"n = {n}", partial(by_draws, n=n), float(n)) for n in _COUNTS[::2]),
    )


def _findings(points: tuple[Measured, ...]) -> tuple[str, ...]:
    words = [
        "{coverage:.1%} ({too_low:.1%} too low, {too_high:.1%} too high)".format(**point.shares)
        + f" by {point.name} in {time_text(point.seconds)}"
        for point in points
        if point.shares
    ]
    return (f"Coverage of the 95 % intervals: {', '.join(words)}.",) if words else ()


STUDY = Study(
    name="interval",
    title="95 % interval of a fitted coefficient: both its arms, and its coverage",
    question="When is the covariance enough, and how many draws does an interval need?",
    reference="exact interval, through an exponent per radian that is estimated linearly",
    counted="fits or draws",
    used="covariance where χ² is a parabola to its ends, else the profile",
    cases=(
        Case("linear", "constant law, six pulls with a scatter of 2 % each", partial(_settings, "constant")),
        Case(
            "curved",
            "law of the thick rope, six pulls with a scatter of 40 %: the upper arm is the longer one",
            partial(_settings, "thickness"),
        ),
        Case(
            "coverage",
            f"the curved case in {N_CAMPAIGNS} campaigns; error: difference of a tail from 2.5 % of them",
            partial(_coverage_settings, "thickness"),
        ),
    ),
    findings=_findings,
)
