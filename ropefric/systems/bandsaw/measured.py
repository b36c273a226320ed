"""What measured frequencies say about the models: how far each is off, and which mounting would explain them."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.special import gammaincc

from ropefric.arrays import FloatArray, frozen_array
from ropefric.errors import FitError, InputError
from ropefric.glossary import AdvisedStatus
from ropefric.systems.bandsaw.beam import beam_frequencies_Hz
from ropefric.systems.bandsaw.saw import MODELS, Saw, Side, frequencies_Hz, preloads_for_N
from ropefric.systems.bandsaw.span import Span


class IdentificationStatus(AdvisedStatus):
    """What an identification is worth."""

    OK = "ok: Preload and mounting factor are determined by the data."
    ON_BOUND = (
        "on-bound: The mounting factor lies on its bound, and its uncertainty reaches there: within what the "
        "points can tell, the wheels are mounted like that."
    )
    NO_SPARE = (
        "no-spare: As many points as unknowns: they are met exactly, whatever they are. Measure more modes or "
        "speeds, or give the points' uncertainties."
    )
    MISFIT = (
        "misfit: The points are further off than their uncertainties allow: the model leaves something out, or a "
        "mode is taken for another. Check the modes, or doubt the uncertainties."
    )
    BEYOND_BOUND = (
        "beyond-bound: The mounting factor lies on its bound, and that is not a measurement of it: the points ask "
        "for a value no mounting has (see free_mounting_factor). Look for what the model leaves out before using "
        "the preload."
    )
    UNIDENTIFIABLE = (
        "unidentifiable: The points cannot tell preload and mounting factor apart. Measure at rest and running, or"
        " at different speeds."
    )


class Identification(NamedTuple):
    """Preload and mounting factor with what is known of their errors."""

    preload_N: float
    mounting_factor: float
    covariance: FloatArray | None
    free_mounting_factor: float | None
    status: IdentificationStatus
    residual_Hz: FloatArray
    dof: int

    @property
    def std(self) -> tuple[float, float] | None:
        """Return the standard uncertainties of F_0 [N] and κ, or None where they are not known."""
        if self.covariance is None:
            return None
        return float(np.sqrt(self.covariance[0, 0])), float(np.sqrt(self.covariance[1, 1]))


class Measurement(NamedTuple):
    """One measured frequency."""

    side: Side
    frequency_Hz: float
    mode: int = 1
    speed_m_s: float | None = None
    std_Hz: float | None = None


class MountingStatus(AdvisedStatus):
    """Whether some mounting of the wheels explains a measured frequency."""

    EXPLAINED = "explained: A mounting factor between 0 and 1 explains the frequency."
    TOO_HIGH = (
        "too-high: No mounting explains the frequency: it is too high. Even wheels pressed apart with a constant "
        "force add no more than the whole inertia tension (kappa = 1). Look for what raises it: a larger preload, "
        "a shorter free span, guides, bending stiffness, or another mode than was meant."
    )
    TOO_LOW = (
        "too-low: No mounting explains the frequency: it is too low. Fixed axles already add nothing (kappa = 0). "
        "Look for what lowers it: lost preload, warmth, a longer free span, yielding wheels, or another mode."
    )


class Mounting(NamedTuple):
    """The mounting factor that would explain a frequency."""

    mounting_factor: float
    status: MountingStatus


def deviation(saw: Saw, measurement: Measurement, model: str) -> tuple[float, float]:
    """Return the frequency that a model gives a measured mode [Hz], and how far that is from it, as a share."""
    changes = MODELS[model].changes
    if "bending_stiffness_N_m2" not in changes and not saw.bending_stiffness_N_m2:
        raise InputError(
            "the saw has no bending stiffness, so there is no beam to compare with",
            key="bending_stiffness_N_m2",
            fix="give EI, or compare strings only",
        )
    changed = replace(_at_speed(saw, measurement), **changes)
    frequency_Hz = float(frequencies_Hz(changed, measurement.side, measurement.mode)[0, -1])
    return frequency_Hz, frequency_Hz / measurement.frequency_Hz - 1.0


def explain_mounting(saw: Saw, measurement: Measurement) -> Mounting:
    """Return the mounting factor that gives exactly the measured frequency, and whether there is such a mounting.

    The saw's stiffness counts; for a string κ = (ρA c² − F_0 ∓ ΔF/2)/(ρA v²) with c = a + √(a² + v²), a = f l/n.
    """
    running = replace(_at_speed(saw, measurement), mounting_factor=0.0)
    if measurement.side is Side.REST or running.speed_m_s == 0.0:
        raise InputError(
            "the blade stood still, and without inertia tension no mounting factor has an influence",
            key="speed_m_s",
            fix="give a frequency that was measured on the running blade",
        )
    needed_N = float(preloads_for_N(running, measurement.side, measurement.frequency_Hz, measurement.mode)[0])
    inertia_N = saw.linear_density_kg_m * running.speed_m_s**2
    kappa = (needed_N - saw.preload_N) / inertia_N
    status = MountingStatus.EXPLAINED
    if not 0.0 <= kappa <= 1.0:
        status = MountingStatus.TOO_HIGH if kappa > 1.0 else MountingStatus.TOO_LOW
    return Mounting(kappa, status)


def _at_speed(saw: Saw, measurement: Measurement) -> Saw:
    if measurement.speed_m_s is None:
        return saw
    return replace(saw, wheel_speed_rad_s=measurement.speed_m_s / saw.wheel_radius_m)


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
    """Return the preload and the mounting factor that fit measured frequencies best."""
    n, stds = len(measurements), [point.std_Hz for point in measurements if point.std_Hz is not None]
    if n < 2:
        raise InputError(f"{n} points for two unknowns", fix="measure at rest and running")
    if 0 < len(stds) < n:
        words = "some points have an uncertainty and some have none"
        raise InputError(words, key="std_Hz", fix="give all of them one, or none")
    weights, known = 1.0 / np.array(stds or [1.0] * n), bool(stds)
    wanted_Hz = np.array([point.frequency_Hz for point in measurements])
    modes = np.array([point.mode for point in measurements])
    at_work = [saw.speed_m_s if point.speed_m_s is None else point.speed_m_s for point in measurements]
    signs = np.array([point.side.sign for point in measurements])
    speed_m_s, pull_N = np.abs(signs) * at_work, 0.5 * saw.tension_difference_N * signs
    inertia_N = saw.linear_density_kg_m * speed_m_s**2

    def floor_N(kappa: float) -> float:
        """Return a preload just above the one at which some point would be slack or past its critical speed."""
        return max(float(((1.0 - kappa) * inertia_N - pull_N).max()), 0.0) * (1.0 + 1e-6) + 1e-6

    # What a string on fixed axles would need, see `preloads_for_N`.
    a = wanted_Hz * saw.free_span_m / modes
    string_N = saw.linear_density_kg_m * (a + np.hypot(a, speed_m_s)) ** 2 - pull_N
    start_N = max(float(np.median(string_N)), floor_N(0.0))

    def residual_Hz(x: FloatArray) -> FloatArray:
        """Return what the points lack, for any κ: its tension is added as preload."""
        span = Span(
            free_span_m=np.asarray(saw.free_span_m),
            linear_density_kg_m=np.asarray(saw.linear_density_kg_m),
            preload_N=float(x[0]) * start_N + float(x[1]) * inertia_N,
            pull_N=pull_N,
            travel_speed_m_s=speed_m_s,
            bending_stiffness_N_m2=np.asarray(saw.bending_stiffness_N_m2),
        )
        table = beam_frequencies_Hz(span, saw.ends, int(modes.max()), accuracy=1e-12)
        return np.asarray(wanted_Hz - table[np.arange(n), modes - 1])

    def search(low: float, high: float, held: tuple[float, ...] = ()) -> tuple[FloatArray, FloatArray, float]:
        """Return (F_0, κ), the Jacobian and the variance; κ lies between two bounds, or is held."""
        lowest, free = floor_N(low) / start_N, 2 - len(held)
        fine: dict[str, Any] = dict.fromkeys(("xtol", "ftol", "gtol"), 1e-12)

        def weighted(x: FloatArray) -> FloatArray:
            return np.asarray(residual_Hz(np.array([*x, *held])) * weights)

        found = least_squares(
            weighted,
            [max(1.0, 1.1 * lowest), 0.5][:free],
            bounds=([lowest, low][:free], [np.inf, high][:free]),
            jac="3-point",
            **fine,
        )
        if found.status <= 0:
            raise FitError(
                "the search for preload and mounting factor did not end",
                fix="check the modes and sides of the points",
            )
        variance = 1.0 if known else 2.0 * float(found.cost) / (n - free) if n > free else math.nan
        return np.array([*found.x, *held]), np.asarray(found.jac), variance

    x, jacobian, variance = search(0.0, 1.0)
    identifiable = _tells_apart(jacobian)
    stopped = identifiable and not _AT_BOUND < x[1] < 1.0 - _AT_BOUND
    free_kappa, beyond, n_free = None, False, 1 + (identifiable and not stopped)
    if stopped:
        x, _, variance = search(0.0, 1.0, held=(float(np.round(x[1])),))
        free, free_jacobian, free_variance = search(_FREE_FLOOR, np.inf)
        free_kappa = float(free[1])
        spread = _covariance(free_jacobian, start_N, free_variance)
        beyond = abs(free_kappa - x[1]) > (0.0 if spread is None else _REACH * float(np.sqrt(spread[1, 1])))
    residuals_Hz, dof = residual_Hz(x), n - n_free
    chi2 = float(np.sum((residuals_Hz * weights) ** 2))
    verdicts = (
        (beyond, IdentificationStatus.BEYOND_BOUND),
        (not identifiable, IdentificationStatus.UNIDENTIFIABLE),
        (not known and dof == 0, IdentificationStatus.NO_SPARE),
        (known and dof > 0 and gammaincc(0.5 * dof, 0.5 * chi2) < _MISFIT, IdentificationStatus.MISFIT),
        (stopped, IdentificationStatus.ON_BOUND),
        (True, IdentificationStatus.OK),
    )
    return Identification(
        preload_N=float(x[0]) * start_N,
        mounting_factor=float(x[1]),
        covariance=_covariance(jacobian[:, :n_free], start_N, variance) if identifiable else None,
        free_mounting_factor=free_kappa,
        status=next(status for holds, status in verdicts if holds),
        residual_Hz=frozen_array(residuals_Hz),
        dof=dof,
    )


def _tells_apart(jacobian: FloatArray) -> bool:
    """Return whether the columns by preload and by mounting factor point in different directions."""
    lengths = np.linalg.norm(jacobian, axis=0)
    if not (lengths > _PARALLEL * lengths.max()).all():
        return False
    return bool(np.linalg.svd(jacobian / lengths, compute_uv=False)[-1] > _PARALLEL)


def _covariance(jacobian: FloatArray, start_N: float, variance: float) -> FloatArray | None:
    """Return the covariance of (F_0, κ), zero for a κ that is held, or None where nothing tells the errors."""
    if math.isnan(variance):
        return None
    inverse = np.linalg.inv(np.linalg.qr(jacobian)[1])
    inverse *= np.array([start_N, 1.0])[: len(inverse), np.newaxis]
    covariance = np.zeros((2, 2))
    covariance[: len(inverse), : len(inverse)] = variance * inverse @ inverse.T
    return frozen_array(covariance)
