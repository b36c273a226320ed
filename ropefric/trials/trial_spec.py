"""One row of the trial list, in SI."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialSpec:
    """One recording and the conditions it was made under."""

    trial: str
    file: str
    path: Path
    line: int
    wheel_radius_m: float
    rope_radius_m: float
    wrap_angle_rad: float
    end_tension_N: float | None = None
    lift_force_N: float | None = None
    sample: str = ""
    wheel: str = ""
    cell: str = ""
    rope_id: str = ""
    dwell_s: float | None = None
    start_s: float | None = None
    stop_s: float | None = None
    exclude: str = ""
    note: str = ""
    own: tuple[tuple[str, str], ...] = ()
