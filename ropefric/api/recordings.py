"""From recordings to break-away forces and trial tables."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from ropefric.errors import DataError, InputError
from ropefric.traces.assemble import assemble_trace
from ropefric.traces.breakaway import Breakaway, PickSettings
from ropefric.traces.calibration import Calibration
from ropefric.traces.decided import pick_at
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.smoothing import SmoothedForce
from ropefric.traces.smoothing import smooth as average
from ropefric.traces.trace import ForceTrace
from ropefric.trials.campaign import load_campaign
from ropefric.trials.campaign_model import Campaign
from ropefric.trials.conditions import Repeatability, summarise
from ropefric.trials.extract import extract_campaign
from ropefric.trials.recording import blocks_of, tared_trace
from ropefric.trials.result import Extraction
from ropefric.trials.table import TrialTable, read_trial_table, table_from_frame, table_of_extraction

if TYPE_CHECKING:
    import pandas as pd

PathLike = str | os.PathLike[str]
"""A file or folder."""


def as_campaign(campaign: Campaign | PathLike) -> Campaign:
    """Return a campaign, loaded where its file is given."""
    return campaign if isinstance(campaign, Campaign) else load_campaign(campaign)


def read_trace(
    path: PathLike,
    profile: ImportProfile | None = None,
    *,
    sample: str = "",
    calibration: Calibration | None = None,
) -> ForceTrace:
    r"""Return the force trace of a recording file: force [N] over time [s].

    Parameters
    ----------
    path : path-like
        Text, LabVIEW, Vernier, MATLAB, TDMS, HDF5 or Excel.
    profile : ImportProfile, optional
        How to understand it; what it leaves open is found out or refused.
    sample : str
        Which recording of a wide file.
    calibration : Calibration, optional
        Turns ADC counts into force.

    Raises
    ------
    DataError
        If the file cannot be understood, or holds several recordings and none is named.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "pull.csv").write_text("time_s,force_kN\n0,0.5\n0.01,0.75\n")
    ...     read_trace(Path(folder, "pull.csv")).force_N
    array([500., 750.])
    """
    used = profile or ImportProfile()
    raws = read_recordings(Path(path), used)
    named = [raw for raw in raws if raw.sample == sample] if sample else list(raws)
    if len(named) != 1:
        names = ", ".join(raw.sample for raw in raws)
        raise DataError(
            f"the file holds {len(raws)} recordings, and sample = {sample!r} names {len(named)} of them",
            code="RF123",
            path=str(path),
            fix=f"name one of: {names}",
        )
    return assemble_trace(named[0], used, calibration=calibration)


def read_trial(campaign: Campaign | PathLike, trial: str) -> ForceTrace:
    """Return the force trace of one trial of a campaign: read, calibrated and tared as the campaign says.

    Parameters
    ----------
    campaign : Campaign or path-like
        The campaign or its file.
    trial : str
        Name of the trial.

    Raises
    ------
    InputError
        If there is no such trial.
    DataError
        If its recording cannot be understood.
    """
    loaded = as_campaign(campaign)
    for spec in loaded.trials:
        if spec.trial == trial:
            raws = read_recordings(spec.path, loaded.profile, shown_as=spec.file)
            return tared_trace(loaded, spec, blocks_of(spec, raws)[0])[0]
    raise InputError(f"the campaign has no trial {trial!r}", key="trial", fix="see campaign.trials")


def smooth(trace: ForceTrace, window_s: float | None = None) -> SmoothedForce:
    """Return a trace's force under a centred moving average.

    Parameters
    ----------
    trace : ForceTrace
        The recording.
    window_s : float, optional
        Full width [s]; by default the width with the smallest uncertainty of the break-away force.

    Raises
    ------
    InputError
        If no width is given and there is no break-away to choose it for.

    Examples
    --------
    >>> smooth(ForceTrace(time_s=[0, 1, 2, 3, 4], force_N=[0, 0, 9, 0, 0]), 3.0).force_N.tolist()
    [0.0, 3.0, 3.0, 3.0, 0.0]
    """
    if window_s is None:
        found = find_breakaway(trace)
        window_s = found.window_s
        if np.isnan(window_s):
            raise InputError(
                f"no window can be chosen: {found.status}, {found.detail}",
                key="window_s",
                fix="give window_s",
            )
    return average(trace, window_s)


def find_breakaway(
    trace: ForceTrace,
    *,
    window_s: float | None = None,
    peak: Literal["smoothed", "two-line"] = "smoothed",
    start_s: float | None = None,
    stop_s: float | None = None,
    min_step_N: float | None = None,
    ending: Literal["sliding", "separation"] = "sliding",
    pick_s: float | None = None,
) -> Breakaway:
    """Return the break-away force of a recording in which the load is raised once until the rope slides.

    Parameters
    ----------
    trace : ForceTrace
        The recording.
    window_s, peak, start_s, stop_s, min_step_N, ending
        As `ropefric.traces.breakaway.PickSettings`.
    pick_s : float, optional
        Take the static peak at this time [s], whatever else would be found.

    Returns
    -------
    Breakaway
        `peak_N` may be used where `status` is "ok"; otherwise `status` and `advice` say why there is none.

    Examples
    --------
    >>> time_s = np.arange(2500) / 1000
    >>> force_N = np.interp(time_s, [0.3, 1.3, 1.32], [0, 100, 80])
    >>> found = find_breakaway(ForceTrace(time_s=time_s, force_N=force_N))
    >>> str(found.status), round(found.peak_N)
    ('ok', 100)
    """
    settings = PickSettings(
        window_s=window_s,
        peak=peak,
        start_s=start_s,
        stop_s=stop_s,
        min_step_N=min_step_N,
        ending=ending,
        pick_s=pick_s,
    )
    return pick_breakaway(trace, settings)[0] if pick_s is None else pick_at(trace, settings)


def extract(
    campaign: Campaign | PathLike,
    *,
    jobs: int = 1,
    cache_dir: PathLike | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> Extraction:
    """Return the break-away forces of all recordings of a campaign, outliers marked by its rule.

    Parameters
    ----------
    campaign : Campaign or path-like
        The campaign or its file.
    jobs : int
        Number of processes.
    cache_dir : path-like, optional
        Where results are kept, so that unchanged recordings are not extracted again.
    progress : callable, optional
        Called with recordings done, recordings in all, and "name status" of the last one.
    """
    kept = None if cache_dir is None else Path(cache_dir)
    return extract_campaign(as_campaign(campaign), jobs=jobs, cache_dir=kept, progress=progress)


def reject(values: npt.ArrayLike, rule: str = "two-sigma") -> Repeatability:
    """Return mean and scatter of a series, with and without the values a rule sets aside in one pass.

    Parameters
    ----------
    values : array_like, shape (n,)
        Forces of one condition.
    rule : str
        two-sigma, grubbs, chauvenet, mad or none.

    Examples
    --------
    >>> reject([7.18, 7.64, 8.00, 7.40, 9.14, 7.82, 7.67, 7.73, 8.27, 7.30]).rejected
    (4,)
    """
    return summarise(values, rule)


def trial_table(trials: "TrialTable | Extraction | pd.DataFrame | PathLike") -> TrialTable:
    """Return trials as a trial table; its `to_frame()` gives a pandas DataFrame.

    Parameters
    ----------
    trials : TrialTable, Extraction, DataFrame or path-like
        A table, the result of `extract`, a frame or CSV file with headers such as `wrap_angle_deg`.

    Raises
    ------
    DataError
        With everything that is wrong in it.

    Examples
    --------
    >>> import pandas as pd
    >>> frame = pd.DataFrame({"wheel_radius_mm": [40, 40], "rope_diameter_mm": 10, "wrap_turns": 1,
    ...                       "end_tension_N": 20, "peak_N": [70, 71]})
    >>> trial_table(frame).to_frame()["peak_N"].tolist()
    [70.0, 71.0]
    """
    if isinstance(trials, TrialTable):
        return trials
    if isinstance(trials, Extraction):
        return table_of_extraction(trials)
    if isinstance(trials, str | os.PathLike):
        return read_trial_table(trials)
    if hasattr(trials, "columns"):
        return table_from_frame(trials)
    raise InputError(
        f"{type(trials).__name__} is no trial table",
        key="trials",
        fix="give a DataFrame or the path of a CSV file",
    )
