"""Posterior sampling of a fit with an ensemble of walkers; needs the extra `mcmc`."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from importlib import import_module
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from ropefric.errors import FitError, InputError
from ropefric.fitting.levenberg import batched_fit
from ropefric.fitting.problem import FitProblem
from ropefric.fitting.reduced import Reduced, reduced
from ropefric.friction.condition import FloatArray

__all__ = ["ChainStatus", "McmcResult", "mcmc"]

# What the authors of emcee ask for before the autocorrelation time itself can be trusted.
_CHAIN_IN_TIMES = 50
_FEWEST_WALKERS = 32
_START_SPREAD = 0.3
_FEW_ACCEPTED = 0.1
_NO_WIDTH = 1e-13


class ChainStatus(StrEnum):
    """Whether a chain may be believed."""

    OK = "ok"
    TOO_SHORT = "too-short"
    STUCK = "stuck"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class McmcResult:
    """Draws from the posterior of the parameters under flat priors inside the bounds.

    Attributes
    ----------
    theta : ndarray, shape (s, p)
        Draws after the burn-in, walker by walker within each kept step; fixed parameters stand at their value.
    std : ndarray, shape (p,)
        Standard deviation.
    ci95 : ndarray, shape (p, 2)
        2.5 and 97.5 percentiles.
    autocorrelation_steps : ndarray, shape (p,)
        Integrated autocorrelation time [steps]; zero for a fixed parameter.
    effective_draws : float
        Independent draws that theta is worth, for the slowest parameter.
    acceptance : float
        Share of the proposed steps that were taken.
    status : ChainStatus
        OK, TOO_SHORT or STUCK.
    advice : tuple of str
        What to do where it is not OK.
    """

    theta: FloatArray
    std: FloatArray
    ci95: FloatArray
    autocorrelation_steps: FloatArray
    effective_draws: float
    acceptance: float
    status: ChainStatus
    advice: tuple[str, ...]


def mcmc(
    problem: FitProblem,
    theta: npt.ArrayLike,
    *,
    n_steps: int = 2000,
    n_burn: int = 500,
    n_walkers: int | None = None,
    scale: float = 1.0,
    absolute_std: bool = False,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> McmcResult:
    """Return draws from the posterior of the fitted parameters, flat priors inside the bounds.

    Parameters
    ----------
    problem : FitProblem
        The problem that was fitted: n points, q fitted parameters.
    theta : array_like, shape (p,)
        Its solution, where the walkers start.
    n_steps, n_burn : int
        Steps of every walker that are kept, at least 1, and dropped before, zero or more.
    n_walkers : int, optional
        At least 2 q + 2 and even; 32 or 4 q unless given.
    scale : float
        What the log-likelihood is divided by, positive: the ratio of clustered to plain variance where repeats
        share their condition's scatter, so that they are not taken for independent.
    absolute_std : bool
        Whether problem.std are the standard deviations, ln L = −χ²/2. Otherwise their common factor is unknown and
        integrated out under Jeffreys' prior, ln L = −(n/2) ln χ².
    seed : int
        The same seed gives the same draws.
    progress : callable, optional
        Called with (steps done, steps in all).

    Returns
    -------
    McmcResult
        With a status; a chain that is too short is returned with one and never silently called good.

    Raises
    ------
    FitError
        If emcee is not installed, or the posterior has no width to walk in.
    InputError
        If an argument is out of range, nothing is fitted or the law has no answer at theta.

    Notes
    -----
    All walkers of half an ensemble are evaluated in one call of the law (Goodman & Weare 2010; Foreman-Mackey et
    al. 2013, PASP 125:306).
    """
    emcee = _emcee()
    best = np.asarray(theta, dtype=np.float64)
    free = np.flatnonzero(problem.vary)
    walkers = n_walkers or max(_FEWEST_WALKERS, 4 * free.size)
    _check_problem(problem, best, scale)
    _check_chain(problem.n_varying, walkers, n_steps, n_burn)
    data = reduced(problem)
    rng = np.random.default_rng(seed)
    start = _around(problem, data, best, walkers, rng)
    sampler = emcee.EnsembleSampler(
        walkers,
        free.size,
        _Posterior(problem=problem, data=data, best=best, free=free, scale=scale, absolute_std=absolute_std),
        vectorize=True,
    )
    # emcee draws from a generator of its own; the state it starts from carries the seed.
    state = np.random.RandomState(rng.integers(2**32)).get_state()
    total = n_burn + n_steps
    steps = sampler.sample(
        emcee.State(start, random_state=state),
        iterations=total,
        # It judges walkers by their condition number, units and all; `_around` has judged them without.
        skip_initial_state_check=True,
    )
    for done, _ in enumerate(steps, start=1):
        if progress is not None:
            progress(done, total)
    return _result(sampler, best, free, n_burn)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Posterior:
    """The log-posterior of many walkers at once."""

    problem: FitProblem
    data: Reduced
    best: FloatArray
    free: npt.NDArray[np.intp]
    scale: float
    absolute_std: bool

    def __call__(self, walkers: FloatArray) -> FloatArray:
        """Return one number for every row of free parameters; minus infinity outside the prior."""
        sets = np.tile(self.best, (len(walkers), 1))
        sets[:, self.free] = walkers
        inside = ((sets >= self.problem.lower) & (sets <= self.problem.upper))[:, self.free].all(axis=1)
        value = np.full(len(sets), -np.inf)
        chi2 = self.data.chi2(sets[inside])
        with np.errstate(divide="ignore"):
            log_likelihood = -0.5 * chi2 if self.absolute_std else -0.5 * self.problem.n_points * np.log(chi2)
        value[inside] = np.where(np.isfinite(chi2), log_likelihood / self.scale, -np.inf)
        return value


def _emcee() -> ModuleType:
    try:
        # An extra, and slow to import.
        return import_module("emcee")
    except ImportError:
        raise FitError(
            "posterior sampling needs the package emcee, which is not installed",
            code="RF430",
            fix='pip install "ropefric[mcmc]"',
        ) from None


def _check_problem(problem: FitProblem, best: FloatArray, scale: float) -> None:
    if best.shape != problem.start.shape:
        raise InputError(f"theta has shape {best.shape}; law {problem.law.name} needs {problem.start.shape}")
    if not problem.n_varying:
        raise InputError(
            f"no parameter of {problem.law.name} is fitted, so there is no posterior", key="vary"
        )
    if not (np.isfinite(scale) and scale > 0.0):
        raise InputError(f"scale is {scale:g}; it must be finite and positive", key="scale")


def _check_chain(q: int, walkers: int, n_steps: int, n_burn: int) -> None:
    if n_steps < 1 or n_burn < 0:
        raise InputError(f"{n_steps} steps after {n_burn} of burn-in are no chain", fix="take 2000 after 500")
    if walkers < 2 * q + 2 or walkers % 2:
        raise InputError(
            f"{walkers} walkers cannot move in {q} dimensions",
            key="n_walkers",
            fix=f"an even number from {2 * q + 2}",
        )


def _around(
    problem: FitProblem, data: Reduced, best: FloatArray, walkers: int, rng: np.random.Generator
) -> FloatArray:
    """Return starts spread about the solution by part of its uncertainty, each with an answer, shape (w, q)."""
    levels = np.sqrt(float(data.chi2(best[np.newaxis])[0]) / max(problem.n_points - problem.n_varying, 1))
    if not np.isfinite(levels):
        raise InputError(
            f"{problem.law.name} has no answer at theta = {best.tolist()}", code="RF420", key="theta"
        )
    lift = problem.law.log_lift(best, problem.conditions)
    noise = rng.standard_normal((8 * walkers, lift.size)) * problem.std * levels
    fits = batched_fit(problem, lift + noise, best, tolerance=1e-4)
    cloud = fits.theta[fits.converged][:, problem.vary]
    centre = best[problem.vary]
    width = cloud.std(axis=0) if len(cloud) else np.zeros(centre.size)
    wide = bool((width > _NO_WIDTH * np.maximum(np.abs(centre), 1.0)).all())
    if len(cloud) < walkers or not wide or np.linalg.matrix_rank((cloud - centre) / width) < centre.size:
        raise FitError(
            f"the posterior of {problem.law.name} has no width in some direction: the data are exact, or a parameter "
            "stands at its bound in every resample",
            code="RF430",
            fix="fix that parameter, or leave exact data to the fit",
        )
    starts = centre + (cloud[:walkers] - centre) * _START_SPREAD
    return np.clip(starts, problem.lower[problem.vary], problem.upper[problem.vary])


def _result(sampler: Any, best: FloatArray, free: npt.NDArray[np.intp], n_burn: int) -> McmcResult:
    chain = np.asarray(sampler.get_chain(discard=n_burn), dtype=np.float64)
    steps, walkers, _ = chain.shape
    draws = np.tile(best, (steps * walkers, 1))
    draws[:, free] = chain.reshape(steps * walkers, free.size)
    times = np.zeros(best.size)
    # A walker that never moved has no autocorrelation; with tol=0 emcee answers however short the chain is.
    with np.errstate(invalid="ignore", divide="ignore"):
        times[free] = sampler.get_autocorr_time(discard=n_burn, tol=0)
    slowest = float(np.nan_to_num(times, nan=steps).max())
    times = np.nan_to_num(times, nan=float(steps))
    acceptance = float(np.mean(sampler.acceptance_fraction))
    status, advice = _verdict(steps, slowest, acceptance)
    std = np.zeros(best.size)
    std[free] = draws[:, free].std(axis=0, ddof=1)
    low, high = np.quantile(draws, [0.025, 0.975], axis=0)
    return McmcResult(
        theta=draws,
        std=std,
        ci95=np.stack([low, high], axis=-1),
        autocorrelation_steps=times,
        effective_draws=steps * walkers / slowest,
        acceptance=acceptance,
        status=status,
        advice=advice,
    )


def _verdict(steps: int, slowest: float, acceptance: float) -> tuple[ChainStatus, tuple[str, ...]]:
    if acceptance < _FEW_ACCEPTED:
        taken = f"only {100 * acceptance:.0f} % of the steps were taken"
        return ChainStatus.STUCK, (f"{taken}; use more walkers, or fix a parameter the data do not see",)
    if steps < _CHAIN_IN_TIMES * slowest:
        length = f"{steps} steps are {steps / slowest:.0f} autocorrelation times"
        return ChainStatus.TOO_SHORT, (
            f"{length}; take at least {np.ceil(_CHAIN_IN_TIMES * slowest):.0f} steps",
        )
    return ChainStatus.OK, ()
