"""What is true of a simulated recording, and the recording itself."""

from dataclasses import dataclass
from math import nan

from ropefric.traces.breakaway import Phase, Status
from ropefric.traces.trace import FloatArray, frozen_array

__all__ = ["RecordingTruth", "SimulatedRecording"]


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingTruth:
    """What is true of one simulated recording, before noise, conversion and damage; NaN where nothing is.

    Attributes
    ----------
    status : Status
        What an honest reading of the recording must end in.
    lift_force_N : float
        Static friction F_A [N]. Also given where the recording cannot show it: `no-breakaway` (never reached),
        `saturated` (above the ceiling), `no-peak` (the level it slides at).
    breakaway_time_s : float
        When the rope breaks away [s].
    kinetic_N : float
        Mean force while sliding [N], from 30 ms after break-away until the motor is off.
    faults : tuple of str
        Names of the faults put in.
    cell : str
        The force cell used.
    dwell_s : float
        Time under load before the pull [s].
    tooth_tops_N, tooth_times_s : tuple of float
        Top [N] and time [s] of every stick-slip tooth; the first is the break-away.
    plateaus_N : tuple of float
        Protocol `held`: the force each plateau settles to [N].
    phases : tuple of Phase
        What happens when.

    Examples
    --------
    >>> RecordingTruth(status=Status.OK, lift_force_N=320.7).faults
    ()
    """

    status: Status
    lift_force_N: float
    breakaway_time_s: float = nan
    kinetic_N: float = nan
    faults: tuple[str, ...] = ()
    cell: str = ""
    dwell_s: float = nan
    tooth_tops_N: tuple[float, ...] = ()
    tooth_times_s: tuple[float, ...] = ()
    plateaus_N: tuple[float, ...] = ()
    phases: tuple[Phase, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SimulatedRecording:
    """One recording of the virtual rig.

    Attributes
    ----------
    time_s : ndarray, shape (n,)
        Time stamps [s] as the logger wrote them; a fault may make them repeat.
    counts : ndarray, shape (n,)
        ADC counts, whole numbers as float64; NaN where a sample is missing.
    true_time_s, true_force_N : ndarray, shape (m,)
        The force on the rope before sensor and damage [N], on the undamaged clock [s].
    truth : RecordingTruth
        What is true of it.
    """

    time_s: FloatArray
    counts: FloatArray
    true_time_s: FloatArray
    true_force_N: FloatArray
    truth: RecordingTruth

    def __post_init__(self) -> None:
        for key in ("time_s", "counts", "true_time_s", "true_force_N"):
            object.__setattr__(self, key, frozen_array(getattr(self, key)))
