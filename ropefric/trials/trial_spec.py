"""One row of the trial list, in SI."""

from dataclasses import dataclass
from pathlib import Path

__all__ = ["TrialSpec"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialSpec:
    """One recording and the conditions it was made under.

    Attributes
    ----------
    trial : str
        Its name, unique within the campaign.
    file : str
        The recording as the list names it.
    path : Path
        Where that is.
    line : int
        1-based line in the list.
    sample : str
        Block of a wide file; "" for ordinary files, "*" for all blocks.
    wheel : str
        Name of the wheel, "" where the row gives a radius.
    wheel_radius_m, rope_radius_m : float
        Radii [m].
    wrap_angle_rad : float
        Wrap angle [rad].
    end_tension_N : float, optional
        Slack-side tension F_B [N]; None where that is what the sensor measures.
    lift_force_N : float, optional
        Known tight-side tension [N]; None unless the slack side is measured.
    cell : str
        Name of the force cell; "" where recordings are in newtons.
    rope_id : str
        Rope specimen.
    dwell_s : float, optional
        Time under load before the pull [s].
    start_s, stop_s : float, optional
        The part of the recording to look at [s]; the campaign's where the row has none.
    exclude : str
        Why the trial is set aside; "" if it is not.
    note : str
        Anything.
    own : tuple of (str, str)
        Headers and cells of columns that the user added.

    Examples
    --------
    >>> trial = TrialSpec(
    ...     trial="t1", file="a.csv", path=Path("a.csv"), line=2, wheel_radius_m=0.04, rope_radius_m=0.0049,
    ...     wrap_angle_rad=3.14, end_tension_N=80.0,
    ... )
    >>> trial.exclude
    ''
    """

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
