"""What measured frequencies say about the models: how far each is off, and which mounting would explain them."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum

from ropefric.errors import InputError
from ropefric.systems.bandsaw.inverse import preload_for_N
from ropefric.systems.bandsaw.models import MODELS
from ropefric.systems.bandsaw.saw import Saw, Side, frequencies_Hz

__all__ = ["Deviation", "Measurement", "Mounting", "MountingStatus", "deviations", "explain_mounting"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """One measured frequency.

    Attributes
    ----------
    side : Side
        Where.
    frequency_Hz : float
        [Hz], positive.
    mode : int
        n = 1, 2, …
    speed_m_s : float, optional
        Speed of the blade [m/s]; by default the saw's at work.
    std_Hz : float, optional
        Standard uncertainty [Hz], positive.

    Raises
    ------
    InputError
        If a number is outside its range.

    Examples
    --------
    >>> Measurement(side=Side.TIGHT, frequency_Hz=24.9).mode
    1
    """

    side: Side
    frequency_Hz: float
    mode: int = 1
    speed_m_s: float | None = None
    std_Hz: float | None = None

    def __post_init__(self) -> None:
        for name in ("frequency_Hz", "std_Hz"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise InputError(
                    f"{name} is {value:g}; it must be finite and positive", key=name, fix="correct this value"
                )
        if self.mode < 1:
            raise InputError(f"the mode is {self.mode}; modes count from 1", key="mode")
        if self.speed_m_s is not None and not (math.isfinite(self.speed_m_s) and self.speed_m_s >= 0.0):
            raise InputError(
                f"the speed is {self.speed_m_s:g} m/s; it must be finite and zero or more", key="speed_m_s"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Deviation:
    """How far a model is from a measurement.

    Attributes
    ----------
    model : str
        Name of the model, see `MODELS`.
    measurement : Measurement
        What was measured.
    frequency_Hz : float
        What the model says [Hz].
    relative : float
        (model)/(measured) − 1 [-].
    """

    model: str
    measurement: Measurement
    frequency_Hz: float
    relative: float


class MountingStatus(StrEnum):
    """Whether some mounting of the wheels explains a measured frequency."""

    EXPLAINED = "explained"
    TOO_HIGH = "too-high"
    TOO_LOW = "too-low"

    @property
    def advice(self) -> str:
        """Return what the status means and what to do.

        Examples
        --------
        >>> MountingStatus.TOO_HIGH.advice[:57]
        'No mounting explains the frequency: it is too high. Even '
        """
        return {
            MountingStatus.EXPLAINED: "A mounting factor between 0 and 1 explains the frequency.",
            MountingStatus.TOO_HIGH: (
                "No mounting explains the frequency: it is too high. Even wheels pressed apart with a constant "
                "force add no more than the whole inertia tension (kappa = 1). Look for what raises it: a larger "
                "preload, a shorter free span, guides, bending stiffness, or another mode than was meant."
            ),
            MountingStatus.TOO_LOW: (
                "No mounting explains the frequency: it is too low. Fixed axles already add nothing (kappa = 0). "
                "Look for what lowers it: lost preload, warmth, a longer free span, yielding wheels, or another mode."
            ),
        }[self]


@dataclass(frozen=True, slots=True, kw_only=True)
class Mounting:
    """The mounting factor that would explain a frequency.

    Attributes
    ----------
    mounting_factor : float
        κ [-], outside [0, 1] where no mounting does it.
    status : MountingStatus
        Which of these.
    """

    mounting_factor: float
    status: MountingStatus


def deviations(
    saw: Saw, measurements: Iterable[Measurement], models: Iterable[str] | None = None
) -> tuple[Deviation, ...]:
    """Return how far each model is from each measurement.

    Parameters
    ----------
    saw : Saw
        The saw; its mounting factor is replaced by the model's.
    measurements : iterable of Measurement
        What was measured.
    models : iterable of str, optional
        Names from `MODELS`; by default all that the saw has the data for.

    Raises
    ------
    InputError
        If a beam is asked for and the saw has no stiffness, or as `frequencies_Hz`.
    UnknownNameError
        For an unknown model.

    Examples
    --------
    >>> saw = Saw(free_span_m=1.6, linear_density_kg_m=0.5967, preload_N=3412.0, wheel_radius_m=0.35,
    ...     wheel_speed_rad_s=970 * math.pi / 30, tension_difference_N=210.95)
    >>> tight = Measurement(side=Side.TIGHT, frequency_Hz=24.9)
    >>> [(found.model, round(found.relative, 3)) for found in deviations(saw, [tight])]
    [('string-at-rest', -0.036), ('string-fixed-axles', -0.243), ('string-constant-force', -0.126)]
    """
    stiff = saw.bending_stiffness_N_m2 > 0.0
    if models is None:
        models = [name for name, model in MODELS.items() if stiff or not model.bends]
    chosen = [MODELS[name] for name in models]
    if not stiff and any(model.bends for model in chosen):
        raise InputError(
            "the saw has no bending stiffness, so there is no beam to compare with",
            key="bending_stiffness_N_m2",
            fix="give EI, or compare strings only",
        )
    found = []
    for measurement in measurements:
        for model in chosen:
            changed = model.applied_to(_at_speed(saw, measurement))
            frequency = float(frequencies_Hz(changed, measurement.side, measurement.mode)[0, -1])
            found.append(
                Deviation(
                    model=model.name,
                    measurement=measurement,
                    frequency_Hz=frequency,
                    relative=frequency / measurement.frequency_Hz - 1.0,
                )
            )
    return tuple(found)


def explain_mounting(saw: Saw, measurement: Measurement) -> Mounting:
    """Return the mounting factor that gives exactly the measured frequency, and whether there is such a mounting.

    The saw's stiffness counts; for a string κ = (ρA c² − F_0 ∓ ΔF/2)/(ρA v²) with c = a + √(a² + v²), a = f l/n.

    Parameters
    ----------
    saw : Saw
        The saw; its mounting factor does not matter.
    measurement : Measurement
        What was measured while it ran.

    Raises
    ------
    InputError
        If the blade stood still: then no mounting factor has an influence.

    Examples
    --------
    >>> saw = Saw(free_span_m=1.6, linear_density_kg_m=0.5967, preload_N=3412.0, wheel_radius_m=0.35,
    ...     wheel_speed_rad_s=970 * math.pi / 30, tension_difference_N=210.95)
    >>> found = explain_mounting(saw, Measurement(side=Side.TIGHT, frequency_Hz=24.9))
    >>> round(found.mounting_factor, 2), str(found.status)
    (2.21, 'too-high')
    """
    running = replace(_at_speed(saw, measurement), mounting_factor=0.0)
    if measurement.side is Side.REST or running.speed_m_s == 0.0:
        raise InputError(
            "the blade stood still, and without inertia tension no mounting factor has an influence",
            key="speed_m_s",
            fix="give a frequency that was measured on the running blade",
        )
    needed_N = preload_for_N(running, measurement.side, measurement.frequency_Hz, measurement.mode)
    inertia_N = saw.linear_density_kg_m * running.speed_m_s**2
    kappa = (needed_N - saw.preload_N) / inertia_N
    if 0.0 <= kappa <= 1.0:
        status = MountingStatus.EXPLAINED
    else:
        status = MountingStatus.TOO_HIGH if kappa > 1.0 else MountingStatus.TOO_LOW
    return Mounting(mounting_factor=kappa, status=status)


def _at_speed(saw: Saw, measurement: Measurement) -> Saw:
    if measurement.speed_m_s is None:
        return saw
    return replace(saw, wheel_speed_rad_s=measurement.speed_m_s / saw.wheel_radius_m)
