"""What the functions on trials and fits take: results, pandas frames or paths of files."""

import os
from typing import TYPE_CHECKING

from ropefric.api.campaigns import PathLike
from ropefric.errors import InputError
from ropefric.fitting.result import FitResult
from ropefric.fitting.store import load_fit
from ropefric.trials.result import Extraction
from ropefric.trials.table import TrialTable, read_trial_table, table_from_frame, table_of_extraction

if TYPE_CHECKING:
    import pandas as pd


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


def as_fit(fit: FitResult | PathLike) -> FitResult:
    """Return a fit, loaded where its file is given."""
    return fit if isinstance(fit, FitResult) else load_fit(fit)
