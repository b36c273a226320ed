"""From trials to friction laws."""

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Literal

from ropefric.api.inputs import trial_table
from ropefric.fitting.bootstrap import with_intervals
from ropefric.fitting.compare import Comparison, compare_laws
from ropefric.fitting.diagnose import Diagnosis
from ropefric.fitting.diagnose import diagnose as find_causes
from ropefric.fitting.fit import fit_law
from ropefric.fitting.problem import Loss
from ropefric.fitting.result import FitResult

if TYPE_CHECKING:
    import pandas as pd

    from ropefric.api.campaigns import PathLike
    from ropefric.trials.result import Extraction
    from ropefric.trials.table import TrialTable


def fit(
    trials: "TrialTable | Extraction | pd.DataFrame | PathLike",
    law: str,
    *,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    start: Mapping[str, float] | None = None,
    scale_covar: Literal["auto"] | bool = "auto",
    loss: Loss = "linear",
    clustered: bool = True,
    n_starts: int = 4,
    seed: int = 0,
    intervals: Literal["covariance", "profile", "bootstrap"] = "covariance",
) -> FitResult:
    """Return a friction law fitted to trials; `status` says whether to trust it.

    Parameters
    ----------
    trials : TrialTable, Extraction, DataFrame or path-like
        See `trial_table`.
    law : str
        "constant", "wrap-power", "coupled", …
    fixed, bounds, start, scale_covar, loss, clustered, n_starts, seed
        As `ropefric.fitting.fit.fit_law`.
    intervals : {"covariance", "profile", "bootstrap"}
        Where the 95 % intervals come from.

    Examples
    --------
    >>> import numpy as np
    >>> import pandas as pd
    >>> wrap_rad = np.repeat([3.0, 6.0, 9.0], 2)
    >>> frame = pd.DataFrame({"wheel_radius_mm": 40, "rope_diameter_mm": 10, "wrap_angle_rad": wrap_rad,
    ...     "end_tension_N": 20, "peak_N": 20 * np.exp(0.2 * wrap_rad + 0.01 * np.array([1, -1, -1, 1, 1, -1]))})
    >>> round(fit(frame, "constant")["mu"].value, 3)
    0.2
    """
    made = fit_law(
        trial_table(trials), law, fixed=fixed, bounds=bounds, start=start, scale_covar=scale_covar, loss=loss,
        clustered=clustered, n_starts=n_starts, seed=seed,
    )  # fmt: skip
    return with_intervals(made, intervals, seed=seed)


def compare(
    trials: "TrialTable | Extraction | pd.DataFrame | PathLike",
    laws: Iterable[str] | None = None,
    *,
    progress: Callable[[str, int, int], None] | None = None,
) -> Comparison:
    """Return friction laws ranked on trials by AICc, all laws by default; the constant laws always stand in it."""
    return compare_laws(trial_table(trials), laws, progress=progress)


def diagnose(
    trials: "TrialTable | Extraction | pd.DataFrame | PathLike", comparison: Comparison | None = None
) -> Diagnosis:
    """Return why trials do not obey the capstan equation, with the evidence, or that they do."""
    return find_causes(trial_table(trials), comparison)
