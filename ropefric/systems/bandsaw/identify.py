"""Preload and mounting factor from measured frequencies, by least squares within their bounds."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares
from scipy.special import gammaincc

from ropefric.errors import FitError, InputError
from ropefric.friction.condition import FloatArray
from ropefric.systems.bandsaw.beam import beam_frequencies_Hz
from ropefric.systems.bandsaw.identification import Identification, IdentificationStatus
from ropefric.systems.bandsaw.inverse import preload_for_N
from ropefric.systems.bandsaw.measured import Measurement
from ropefric.systems.bandsaw.saw import Saw, Side
from ropefric.systems.bandsaw.span import Span

__all__ = ["identify"]

# Columns of the Jacobian this nearly parallel let the data speak about one number only.
_PARALLEL = 1e-6
# So near to a bound the search has been stopped by it.
_AT_BOUND = 1e-6
# How far below zero the mounting factor may go once it is set free; above, there is no limit.
_FREE_FLOOR = -1.0
# Standard errors that a free κ may lie outside its bounds, and the chance of a worse fit below which it is none.
_REACH = 2.0
_MISFIT = 1e-3


def identify(saw: Saw, measurements: Sequence[Measurement]) -> Identification:
    """Return the preload and the mounting factor that fit measured frequencies best.

    Parameters
    ----------
    saw : Saw
        The saw; its preload and mounting factor do not matter, its stiffness and torque do.
    measurements : sequence of Measurement
        Two or more, of any sides, modes and speeds.

    Returns
    -------
    Identification
        With standard uncertainties that are those of a linear model at the solution.

    Raises
    ------
    InputError
        With fewer than two points, or if only some of them have an uncertainty.
    FitError
        If the search does not end.

    Examples
    --------
    >>> saw = Saw(free_span_m=1.6, linear_density_kg_m=0.5967, preload_N=1.0, wheel_radius_m=0.35,
    ...     wheel_speed_rad_s=101.58, tension_difference_N=210.95)
    >>> found = identify(saw, [Measurement(side=Side.REST, frequency_Hz=23.6307),
    ...     Measurement(side=Side.TIGHT, frequency_Hz=20.0), Measurement(side=Side.SLACK, frequency_Hz=19.15)])
    >>> str(found.status), round(found.preload_N), round(found.mounting_factor, 2)
    ('ok', 3412, 0.38)
    """
    n = len(measurements)
    if n < 2:
        raise InputError(f"{n} points for two unknowns", fix="measure at rest and running")
    weights = _weights(measurements)
    wanted = np.array([point.frequency_Hz for point in measurements])
    still = replace(saw, mounting_factor=0.0)
    lowest_N = _floor_N(still, measurements, 0.0)
    start_N = max(float(np.median([_start_N(still, point) for point in measurements])), lowest_N)

    def residual_Hz(x: FloatArray) -> FloatArray:
        return wanted - _model_Hz(still, measurements, float(x[0]) * start_N, float(x[1]))

    def weighted(x: FloatArray) -> FloatArray:
        return np.asarray(residual_Hz(x) * weights)

    floor = lowest_N / start_N
    x, jacobian = _search(weighted, (floor, 0.0), (np.inf, 1.0))
    identifiable = _tells_apart(jacobian)
    stopped = identifiable and not _AT_BOUND < x[1] < 1.0 - _AT_BOUND
    if stopped:
        bound = float(np.round(x[1]))
        x = np.array([_search(lambda y: weighted(np.array([y[0], bound])), (floor,), (np.inf,))[0][0], bound])
    n_free = 2 if identifiable and not stopped else 1
    dof = n - n_free
    known = measurements[0].std_Hz is not None

    def variance(x: FloatArray, spare: int) -> float | None:
        if known:
            return 1.0
        return float(np.sum(weighted(x) ** 2)) / spare if spare > 0 else None

    free_kappa, beyond = None, False
    if stopped:
        low = _floor_N(still, measurements, _FREE_FLOOR) / start_N
        free, free_jacobian = _search(weighted, (low, _FREE_FLOOR), (np.inf, np.inf))
        free_kappa = float(free[1])
        spread = _covariance(free_jacobian, 2, start_N, variance(free, n - 2))
        reach = 0.0 if spread is None else _REACH * float(np.sqrt(spread[1, 1]))
        beyond = abs(free_kappa - x[1]) > reach
    if not identifiable:
        status = IdentificationStatus.UNIDENTIFIABLE
    elif beyond:
        status = IdentificationStatus.BEYOND_BOUND
    else:
        chi2 = float(np.sum(weighted(x) ** 2)) if known else None
        status = _judge(chi2, dof, IdentificationStatus.ON_BOUND if stopped else IdentificationStatus.OK)
    residual = residual_Hz(x)
    residual.flags.writeable = False
    return Identification(
        preload_N=float(x[0]) * start_N,
        mounting_factor=float(x[1]),
        covariance=_covariance(jacobian, n_free, start_N, variance(x, dof)) if identifiable else None,
        free_mounting_factor=free_kappa,
        status=status,
        residual_Hz=residual,
        n=n,
        dof=dof,
    )


def _judge(chi2: float | None, dof: int, good: IdentificationStatus) -> IdentificationStatus:
    """Return the status of a fit that nothing else is wrong with; `chi2` is None where no errors are known."""
    if chi2 is None:
        return good if dof > 0 else IdentificationStatus.NO_SPARE
    if dof > 0 and float(gammaincc(0.5 * dof, 0.5 * chi2)) < _MISFIT:
        return IdentificationStatus.MISFIT
    return good


def _search(
    weighted: Callable[[FloatArray], FloatArray], low: tuple[float, ...], high: tuple[float, ...]
) -> tuple[FloatArray, FloatArray]:
    """Return the solution and the Jacobian there, starting from the middle of the physical range."""
    start = [max(1.0, 1.1 * low[0]), 0.5][: len(low)]
    found = least_squares(
        weighted, start, bounds=(low, high), jac="3-point", xtol=1e-12, ftol=1e-12, gtol=1e-12
    )
    if found.status <= 0:
        error = FitError(
            "the search for preload and mounting factor did not end",
            fix="check the modes and sides of the points",
        )
        error.partial = found.x
        raise error
    return np.asarray(found.x, dtype=np.float64), np.asarray(found.jac, dtype=np.float64)


def _tells_apart(jacobian: FloatArray) -> bool:
    """Return whether the columns by preload and by mounting factor point in different directions."""
    lengths = np.linalg.norm(jacobian, axis=0)
    if not (lengths > _PARALLEL * lengths.max()).all():
        return False
    return bool(np.linalg.svd(jacobian / lengths, compute_uv=False)[-1] > _PARALLEL)


def _covariance(
    jacobian: FloatArray, n_free: int, start_N: float, variance: float | None
) -> FloatArray | None:
    """Return the covariance of (F_0, κ), zero for a κ that is held, or None where nothing tells the errors."""
    if variance is None:
        return None
    _, r = np.linalg.qr(jacobian[:, :n_free])
    inverse = np.linalg.inv(r)
    covariance = np.zeros((2, 2))
    covariance[:n_free, :n_free] = variance * inverse @ inverse.T
    units = np.array([start_N, 1.0])
    covariance *= np.outer(units, units)
    covariance.flags.writeable = False
    return covariance


def _weights(measurements: Sequence[Measurement]) -> FloatArray:
    stds = [point.std_Hz for point in measurements]
    if all(std is None for std in stds):
        return np.ones(len(stds))
    if any(std is None for std in stds):
        raise InputError(
            "some points have an uncertainty and some have none",
            key="std_Hz",
            fix="give all of them one, or none",
        )
    return np.array([1.0 / std for std in stds if std is not None])


def _start_N(saw: Saw, point: Measurement) -> float:
    string = replace(
        saw, bending_stiffness_N_m2=0.0, wheel_speed_rad_s=_speed(saw, point) / saw.wheel_radius_m
    )
    return preload_for_N(string, point.side, point.frequency_Hz, point.mode)


def _speed(saw: Saw, point: Measurement) -> float:
    if point.side is Side.REST:
        return 0.0
    return saw.speed_m_s if point.speed_m_s is None else point.speed_m_s


def _floor_N(saw: Saw, measurements: Sequence[Measurement], kappa: float) -> float:
    """Return a preload just above the one at which some point would be slack or past its critical speed."""
    least = [
        saw.linear_density_kg_m * (1.0 - kappa) * _speed(saw, point) ** 2
        - 0.5 * point.side.sign * saw.tension_difference_N
        for point in measurements
    ]
    return max(*least, 0.0) * (1.0 + 1e-6) + 1e-6


def _model_Hz(saw: Saw, measurements: Sequence[Measurement], preload_N: float, kappa: float) -> FloatArray:
    """Return what each point should read, for any κ: its tension is added as preload."""
    speed = np.array([_speed(saw, point) for point in measurements])
    sign = np.array([point.side.sign for point in measurements])
    span = Span(
        free_span_m=np.asarray(saw.free_span_m),
        linear_density_kg_m=np.asarray(saw.linear_density_kg_m),
        preload_N=preload_N + kappa * saw.linear_density_kg_m * speed**2,
        pull_N=0.5 * sign * saw.tension_difference_N,
        travel_speed_m_s=speed,
        bending_stiffness_N_m2=np.asarray(saw.bending_stiffness_N_m2),
    )
    modes = np.array([point.mode for point in measurements])
    table = beam_frequencies_Hz(span, saw.ends, int(modes.max()), accuracy=1e-12)
    return np.asarray(table[np.arange(modes.size), modes - 1])
