"""Functions of `import ropefric`: from recordings to forces, laws, lift forces, designs; from scenes to answers."""

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar, Union

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import (
    BY_NAME,
    CALL,
    NUMBER,
    PATH,
    SEVERAL,
    TEXT,
    WHOLE_NUMBER,
    DataError,
    InputError,
    Kind,
)
from ropefric.files.folder import Folder
from ropefric.fitting import budgets, next_tests, resolution
from ropefric.fitting.compare import Comparison, compare_laws
from ropefric.fitting.design import Design, SolveFor
from ropefric.fitting.design import design as find_design
from ropefric.fitting.diagnose import Diagnosis
from ropefric.fitting.diagnose import diagnose as find_causes
from ropefric.fitting.fit import fit_law
from ropefric.fitting.intervals import with_intervals
from ropefric.fitting.predict import Method, Prediction
from ropefric.fitting.predict import predict as predict_lift
from ropefric.fitting.result import FitResult
from ropefric.fitting.store import load_fit
from ropefric.friction.condition import SETTINGS, Conditions, one_condition
from ropefric.given import (
    Columns,
    as_table,
    as_trace,
    in_declared_units,
    number,
    numbers_given,
    refuse_given,
    settings,
    tared,
    wheels_of,
)
from ropefric.pipeline import CampaignRun, campaign_folder, run_campaign
from ropefric.quantities import split_unit_suffix
from ropefric.scenes.draws import Draws, draw_scene
from ropefric.scenes.explain import Explanation, explain_scene
from ropefric.scenes.scene import Scene, load_scene
from ropefric.scenes.solve import Solution, solve_scene
from ropefric.scenes.sweep import Axis, Sweep, check_table, parse_axis, sweep_scene, write_table
from ropefric.traces.assemble import assemble_trace
from ropefric.traces.breakaway import Breakaway, PickSettings
from ropefric.traces.calibration import Calibration
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.protocols import pick_at
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.profile import ImportProfile
from ropefric.traces.segments import upright
from ropefric.traces.smoothing import SmoothedForce
from ropefric.traces.smoothing import smooth as average
from ropefric.traces.trace import ForceTrace
from ropefric.trials.campaign import load_campaign
from ropefric.trials.campaign_model import Campaign
from ropefric.trials.extract import blocks_of, extract_campaign, tared_trace
from ropefric.trials.outliers import Repeatability, summarise
from ropefric.trials.result import Extraction
from ropefric.trials.table import TrialTable, table_of_extraction
from ropefric.uncertainty.budget import Statement

if TYPE_CHECKING:
    import pandas as pd


T = TypeVar("T")
PathLike = str | os.PathLike[str]
"""A file or folder."""

Trials = Union[TrialTable, Extraction, "pd.DataFrame", Mapping[str, Any], npt.NDArray[Any], PathLike]
"""Trials in any form that `trial_table` takes."""

Given = Any
"""A number, an array, or a quantity with its unit: 0.035, [0.02, 0.04], "35 mm", or one of pint's."""


def as_campaign(campaign: Campaign | PathLike) -> Campaign:
    """Return a campaign, loaded where its file is given."""
    return _loaded(load_campaign, Campaign, campaign=campaign)


def _loaded(load: Callable[[PathLike], T], kind: type[T], **given: Any) -> T:
    """Return the one that is given, or load it where its file is."""
    ((name, value),) = given.items()
    if isinstance(value, kind):
        return value
    Kind(PATH.types, f"a {kind.__name__}, or the path of its file").check(**{name: value})
    return load(value)


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
    PATH.check(path=path)
    Kind((ImportProfile,), "an import profile").check_given(profile=profile)
    Kind((Calibration,), "a calibration").check_given(calibration=calibration)
    used = profile or ImportProfile()
    raws = read_recordings(Path(path), used)
    named = [raw for raw in raws if raw.sample == sample] if sample else list(raws)
    if len(named) != 1:
        fix = f"name one of: {', '.join(raw.sample for raw in raws)}"
        text = f"the file holds {len(raws)} recordings, and sample = {sample!r} names {len(named)} of them"
        raise DataError(text, code="RF123", path=str(path), fix=fix)
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

    Examples
    --------
    >>> import tempfile
    >>> from ropefric.rig.campaign import prth_bench_plan, simulate_campaign
    >>> bench = prth_bench_plan()
    >>> small = replace(bench, conditions=bench.conditions[:1], repeats=2, faults={})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = simulate_campaign(folder, small, seed=1)
    ...     trace = read_trial(Path(folder, "campaign.toml"), "c01-r02")
    >>> str(find_breakaway(trace).status)
    'ok'
    """
    loaded = as_campaign(campaign)
    for spec in loaded.trials:
        if spec.trial == trial:
            raws = read_recordings(spec.path, loaded.profile, shown_as=spec.file)
            return tared_trace(loaded, spec, blocks_of(spec, raws)[0])[0]
    raise InputError(f"the campaign has no trial {trial!r}", key="trial", fix="see campaign.trials")


def smooth(
    trace: "ForceTrace | PathLike | pd.DataFrame | pd.Series | Mapping[str, Any]",
    window_s: Given = None,
    *,
    columns: Columns = None,
) -> SmoothedForce:
    """Return a trace's force under a centred moving average.

    Parameters
    ----------
    trace : ForceTrace, path-like, DataFrame, Series or mapping
        The recording, see `find_breakaway`.
    window_s : number or quantity, optional
        Full width [s], or "10 ms"; by default the width with the smallest uncertainty of the break-away force.
    columns : mapping of str to str, optional
        New names of a table's columns.

    Raises
    ------
    InputError
        If no width is given and there is no break-away to choose it for.

    Examples
    --------
    >>> smooth(ForceTrace(time_s=[0, 1, 2, 3, 4], force_N=[0, 0, 9, 0, 0]), 3.0).force_N.tolist()
    [0.0, 3.0, 3.0, 3.0, 0.0]
    """
    recorded = _recording(trace, columns=columns)
    if window_s is None:
        found = find_breakaway(recorded)
        window_s = found.window_s
        if np.isnan(window_s):
            text = f"no window can be chosen: {found.status}, {found.detail}"
            raise InputError(text, key="window_s", fix="give window_s")
    return average(recorded, number(window_s, "s", "window_s"))


def find_breakaway(
    trace: "ForceTrace | PathLike | pd.DataFrame | pd.Series | Mapping[str, Any] | npt.ArrayLike",
    force_N: npt.ArrayLike | None = None,
    *,
    sampling_rate: Given = None,
    tare: Given | tuple[float, float] = None,
    rest: Literal["unknown", "zero", "pretension"] = "unknown",
    columns: Columns = None,
    window_s: Given = None,
    start_s: Given = None,
    stop_s: Given = None,
    min_step_N: Given = None,
    ending: Literal["sliding", "separation"] = "sliding",
    pick_s: Given = None,
) -> Breakaway:
    """Return the break-away force of a recording in which the load is raised once until the rope slides.

    Parameters
    ----------
    trace : ForceTrace, path-like, DataFrame, Series, mapping or array_like
        The recording; its file; a table with columns of times and forces, such as `time_s` and `force_kN`; a series of
        forces [N] over an index of seconds, durations or time stamps; or the times [s]; or, with `sampling_rate`, the
        forces [N].
    force_N : array_like, optional
        The forces [N] where the times stand alone; a pint quantity in any unit of force.
    sampling_rate : number or quantity, optional
        Samples per second [Hz] where the forces stand alone: 1000, "1 kHz".
    tare : pair of float, number or quantity, optional
        From when until when the sensor carried nothing [s], or what it showed then [N]: taken off.
    rest : str
        What a level at rest is, where `tare` does not say it: `"zero"` (an error of it), `"pretension"`, `"unknown"`.
    columns : mapping of str to str, optional
        New names of a table's columns: `{"F [daN]": "force [daN]"}`.
    window_s, start_s, stop_s, min_step_N, ending
        As `ropefric.traces.breakaway.PickSettings`.
    pick_s : number or quantity, optional
        Take the static peak at this time [s], whatever else would be found.

    Returns
    -------
    Breakaway
        `peak_N` may be used where `status` is "ok"; otherwise `status` and `advice` say why there is none. It keeps its
        recording: `plot()` draws both.

    Raises
    ------
    InputError
        If an argument is no recording, or not what it is to be; the message names the argument.

    Examples
    --------
    >>> time_s = np.arange(2500) / 1000
    >>> force_N = np.interp(time_s, [0.3, 1.3, 1.32], [0, 100, 80])
    >>> found = find_breakaway(time_s, force_N)
    >>> str(found.status), round(found.peak_N)
    ('ok', 100)
    """
    numbers = numbers_given(
        window_s=window_s, start_s=start_s, stop_s=stop_s, min_step_N=min_step_N, pick_s=pick_s
    )
    if tare is not None and rest != "unknown":
        text = "tare already states what the force at rest is"
        raise InputError(text, key="rest", fix="leave one of them out")
    chosen = PickSettings(ending=ending, rest="pretension" if tare is not None else rest, **numbers)
    recorded, said = upright(tared(_recording(trace, force_N, columns, sampling_rate), tare))
    found = pick_breakaway(recorded, chosen)[0] if pick_s is None else pick_at(recorded, chosen)
    return replace(found, notes=(*recorded.notes, *filter(None, [said]), *found.notes), trace=recorded)


def _recording(
    trace: Any, force_N: Any = None, columns: Columns = None, sampling_rate: Any = None
) -> ForceTrace:
    """Return a trace of what `as_trace` takes, or of a file."""
    if not isinstance(trace, str | os.PathLike):
        return as_trace(trace, force_N, columns, sampling_rate)
    refuse_given(force_N=force_N, columns=columns, sampling_rate=sampling_rate)
    return read_trace(trace)


def extract(
    campaign: Campaign | PathLike,
    *,
    jobs: int = 1,
    progress: Callable[[int, int, str], None] | None = None,
    executor: Any = None,
) -> Extraction:
    """Return the break-away forces of all recordings of a campaign, outliers marked by its rule.

    Parameters
    ----------
    campaign : Campaign or path-like
        The campaign or its file.
    jobs : int
        Number of processes.
    progress : callable, optional
        Called with recordings done, recordings in all, and "name status" of the last one.
    executor : concurrent.futures.Executor or dask.distributed.Client, optional
        Reads the recordings in the stead of `jobs` processes of this machine; the result is the same to the last bit.
        Its workers need the recordings under the same path. What a worker that died had in hand is read here.

    Returns
    -------
    Extraction
        `trials` with their forces, `conditions` with mean and scatter, `problems`.

    Examples
    --------
    >>> import tempfile
    >>> from ropefric.rig.campaign import prth_bench_plan, simulate_campaign
    >>> bench = prth_bench_plan()
    >>> small = replace(bench, conditions=bench.conditions[:1], repeats=2, faults={})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = simulate_campaign(folder, small, seed=1)
    ...     found = extract(Path(folder, "campaign.toml"))
    >>> [(trial.trial, str(trial.breakaway.status)) for trial in found.trials]
    [('c01-r01', 'ok'), ('c01-r02', 'ok')]
    """
    WHOLE_NUMBER.check(jobs=jobs)
    CALL.check_given(progress=progress)
    return extract_campaign(as_campaign(campaign), jobs=jobs, progress=progress, executor=executor)


def reject(values: npt.ArrayLike, rule: str = "two-sigma") -> Repeatability:
    """Return mean and scatter of a series, with and without the values a rule sets aside in one pass.

    Parameters
    ----------
    values : array_like, shape (n,)
        Forces of one condition.
    rule : str
        two-sigma, grubbs or none.

    Examples
    --------
    >>> reject([7.18, 7.64, 8.00, 7.40, 9.14, 7.82, 7.67, 7.73, 8.27, 7.30]).rejected
    (4,)
    """
    TEXT.check(rule=rule)
    return summarise(values, rule)


def trial_table(trials: Trials, *, columns: Columns = None) -> TrialTable:
    """Return trials as a trial table; its `to_frame()` gives a pandas DataFrame.

    Parameters
    ----------
    trials : TrialTable, Extraction, DataFrame, mapping, ndarray or path-like
        A table, the result of `extract`, a frame, columns by name or a CSV file with headers such as `wrap_angle_deg`.
        Columns may hold quantities with their units: "35 mm", or pint's.
    columns : mapping of str to str, or sequence of str, optional
        New names of columns, `{"F [N]": "peak_N"}`; or the names of the columns of an array.

    Raises
    ------
    DataError
        With everything that is wrong in it.

    Warns
    -----
    RopefricWarning
        Where a wrap was probably meant in degrees, or a size in millimetres.

    Examples
    --------
    >>> found = trial_table({"wheel_radius": "40 mm", "rope_diameter_mm": 10, "wrap_turns": 1, "F_B": 20,
    ...     "F [N]": [70, 71]}, columns={"F [N]": "peak_N", "F_B": "end_tension_N"})
    >>> found.to_frame()["peak_N"].tolist(), found.wheel_radius_m.tolist()
    ([70.0, 71.0], [0.04, 0.04])
    """
    if isinstance(trials, TrialTable | Extraction):
        if columns is not None:
            text = f"the columns of a {type(trials).__name__} have their names"
            raise InputError(text, key="columns", fix="leave columns out")
        return trials if isinstance(trials, TrialTable) else table_of_extraction(trials)
    is_named = isinstance(trials, str | os.PathLike | Mapping)
    if is_named or hasattr(trials, "columns") or hasattr(trials, "dtype"):
        return as_table(trials, columns)
    fix = "give a DataFrame, a mapping of columns, the path of a CSV file, or the whole result of extract"
    raise InputError(f"{type(trials).__name__} is no trial table", key="trials", fix=fix)


def fit(
    trials: Trials,
    law: str,
    *,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    start: Mapping[str, float] | None = None,
    groups: Sequence[str] | str | None = None,
    shared: Mapping[str, str] | None = None,
    n_starts: int = 4,
    seed: int = 0,
    intervals: Literal["auto", "covariance", "profile"] = "auto",
    of: Literal["peak", "kinetic"] = "peak",
    columns: Columns = None,
) -> FitResult:
    """Return a friction law fitted to trials; `status` says whether to trust it.

    Parameters
    ----------
    trials : TrialTable, Extraction, DataFrame, mapping, ndarray or path-like
        See `trial_table`, which takes `columns`, too.
    law : str
        "constant", "wrap-power", "coupled", …
    fixed, start : mapping of parameter name to value, optional
        Parameters that are held, and start values of others.
    bounds : mapping of parameter name to (lower, upper), optional
        Where the search may go; the law's own bounds by default.
    groups : str or sequence of str, optional
        Columns whose levels may differ in μ, so that three ropes count as three; `rope_id`, `wheel`, `mounting`,
        `operator` and `day` where the trials have them, by default.
    shared : mapping of str to str, optional
        Which trials share a stated error: {"wrap": "rig", "wheel_radius": "wheel", "cell": "cell"}. Other errors are
        part of the scatter; `cell_std_N` is shared by the trials of a cell by default.
    n_starts, seed : int
        Starts of the search, and the seed of what spreads them.
    intervals : {"auto", "covariance", "profile"}
        Where the 95 % intervals of the parameters come from; "auto" is the covariance where χ² grows to the ends of its
        intervals as a parabola does, else the profile.
    of : {"peak", "kinetic"}
        The force that is fitted: the break-away force, or the mean force while sliding (column `kinetic_N`).

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
    BY_NAME.check_given(fixed=fixed, bounds=bounds, start=start, shared=shared)
    SEVERAL.check_given(groups=groups)
    named = (groups,) if isinstance(groups, str) else groups
    made = fit_law(
        trial_table(trials, columns=columns), law, fixed=fixed, bounds=bounds, start=start,
        groups=None if named is None else tuple(named), shared=shared, n_starts=n_starts, seed=seed, of=of,
    )  # fmt: skip
    return with_intervals(made, intervals)


def compare(
    trials: Trials,
    laws: Iterable[str] | None = None,
    *,
    progress: Callable[[str, int, int], None] | None = None,
    of: Literal["peak", "kinetic"] = "peak",
    columns: Columns = None,
) -> Comparison:
    """Return friction laws ranked on trials by AICc; its text is the ranking.

    Parameters
    ----------
    trials : TrialTable, Extraction, DataFrame, mapping, ndarray or path-like
        See `trial_table`, which takes `columns`, too.
    laws : str or iterable of str, optional
        Names of laws, all by default; the two constant laws are always among them.
    progress : callable, optional
        Called with the name of a law, its number, and how many there are.
    of : {"peak", "kinetic"}
        The force that is fitted: the break-away force, or the mean force while sliding.

    Returns
    -------
    Comparison
        `best` is the first of `ranking`; `comparison["coupled"].fit` the fit of a law.

    Raises
    ------
    UnknownNameError
        If there is no such law.

    Examples
    --------
    >>> wrap_rad = np.repeat([3.0, 6.0, 9.0, 12.0, 15.0], 2)
    >>> trials = {"wheel_radius_mm": 40, "rope_diameter_mm": 10, "wrap_angle_rad": wrap_rad, "end_tension_N": 20,
    ...     "peak_N": 20 * np.exp(0.2 * wrap_rad + 0.01 * np.array([1, -1, -1, 1, 1, -1, -1, 1, 1, -1]))}
    >>> [entry.law for entry in compare(trials, ["wrap-power"]).ranking][0]
    'constant'
    """
    SEVERAL.check_given(laws=laws)
    CALL.check_given(progress=progress)
    table = trial_table(trials, columns=columns).of(of)
    return compare_laws(table, laws, progress=progress)


def diagnose(
    trials: Trials,
    comparison: Comparison | None = None,
    *,
    columns: Columns = None,
) -> Diagnosis:
    """Return why trials do not obey the capstan equation, with the evidence, or that they do.

    Parameters
    ----------
    trials : TrialTable, Extraction, DataFrame, mapping, ndarray or path-like
        See `trial_table`, which takes `columns`, too.
    comparison : Comparison, optional
        The result of `compare` on the same trials; made where it is not given.

    Returns
    -------
    Diagnosis
        `causes`, each with `supported` ("yes", "no", "undecided") and its evidence; `found["wrap effect"]` is one.

    Examples
    --------
    >>> wrap_rad = np.repeat([3.0, 6.0, 9.0, 12.0, 15.0], 2)
    >>> trials = {"wheel_radius_mm": 40, "rope_diameter_mm": 10, "wrap_angle_rad": wrap_rad, "end_tension_N": 20,
    ...     "peak_N": 20 * np.exp(0.2 * wrap_rad + 0.01 * np.array([1, -1, -1, 1, 1, -1, -1, 1, 1, -1]))}
    >>> diagnose(trials)["wrap effect"].supported
    'no'
    """
    Kind((Comparison,), "a comparison").check_given(comparison=comparison)
    return find_causes(trial_table(trials, columns=columns), comparison)


def predict(
    fit: FitResult | PathLike,
    wheels: "pd.DataFrame | Mapping[str, Any] | None" = None,
    *,
    wheel_radius_m: Given = None,
    wrap_angle_rad: Given = None,
    end_tension_N: Given = None,
    rope_radius_m: Given = None,
    level: float = 0.95,
    method: Method = "auto",
    linear_density_kg_m: Given = None,
    speed_m_s: Given = None,
    rope: str | None = None,
    columns: Columns = None,
    **named: Given,
) -> Prediction:
    """Return the lift force of a fitted law for n wheels, with confidence and prediction intervals.

    Parameters
    ----------
    fit : FitResult or path-like
        The fit or its file.
    wheels : DataFrame or mapping, optional
        Settings of n wheels, with headers as in a trial table: `wheel_radius_mm`, `wrap_turns`, `end_tension_N`.
    wheel_radius_m, wrap_angle_rad, end_tension_N : array_like, scalar or shape (n,), optional
        R_w [m], φ [rad], F_B [N], those that the table does not have; or with units: "35 mm", "400 deg".
    rope_radius_m : array_like, optional
        R_r [m]; that of the trials where they had one rope only.
    level, method, linear_density_kg_m, speed_m_s
        As `ropefric.fitting.predict.predict`.
    rope : str, optional
        A rope of the trials by its `rope_id`: `this_rope` of the result is the force with that rope.
    columns : mapping of str to str, optional
        New names of the table's columns.
    **named : number, array_like or quantity
        The same settings under another name or unit, as in the header of a trial table: `wheel_diameter_mm=70`,
        `wrap_turns=1.5`, `wheel_radius="35 mm"`.

    Raises
    ------
    InputError
        If a setting is missing or has no unit, the law has no answer for a wheel, or the fit has no
        component for ropes.
    UnknownNameError
        If there is no such argument.

    Warns
    -----
    RopefricWarning
        Where a wrap was probably meant in degrees, or a size in millimetres.

    Examples
    --------
    >>> trials = {"wheel_radius_mm": 40, "rope_diameter_mm": 10, "wrap_angle_rad": [3.0, 6.0, 9.0], "end_tension_N": 20,
    ...     "peak_N": [36.6, 66.1, 121.7]}
    >>> mine = fit(trials, "constant")
    >>> round(predict(mine, wheel_radius="35 mm", wrap="400 deg", end_tension_N=20).lift_force_N[0])
    81
    >>> round(mine.predict(wheel_radius_m=0.035, wrap_deg=400, end_tension_N=20).lift_force_N[0])
    81
    """
    NUMBER.check(level=level)
    stored = as_fit(fit)
    given = {} if wheels is None else wheels_of(wheels, columns)
    asked = in_declared_units(
        named, wheel_radius_m=wheel_radius_m, wrap_angle_rad=wrap_angle_rad, end_tension_N=end_tension_N,
        rope_radius_m=rope_radius_m, linear_density_kg_m=linear_density_kg_m, speed_m_s=speed_m_s,
    )  # fmt: skip
    moving = {name: asked.pop(name) for name in ("linear_density_kg_m", "speed_m_s")}
    given |= settings(**asked)
    _refuse_missing(given, [name for name in SETTINGS if name != "rope_radius_m"], "by name or as a column")
    if "rope_radius_m" not in given:
        given["rope_radius_m"] = _rope(stored)
    for name, unit in (("linear_density_kg_m", "kg/m"), ("speed_m_s", "m/s")):
        if moving[name] is not None:
            moving[name] = number(moving[name], unit, name)
    TEXT.check_given(rope=rope)
    return predict_lift(stored, Conditions(**given), level=level, method=method, rope=rope, **moving)


def design(
    fit: FitResult | PathLike,
    *,
    lift_N: Given = None,
    solve_for: SolveFor = "wrap",
    wheel_radius_m: Given = None,
    wrap_angle_rad: Given = None,
    end_tension_N: Given = None,
    rope_radius_m: Given = None,
    probability: float | None = 0.95,
    **named: Given,
) -> Design:
    """Return the smallest wrap, wheel radius or end tension that lifts a load with a probability.

    Parameters
    ----------
    fit : FitResult or path-like
        The fit or its file.
    lift_N, solve_for, wheel_radius_m, wrap_angle_rad, end_tension_N, probability
        As `ropefric.fitting.design.design`.
    rope_radius_m : array_like, optional
        R_r [m]; that of the trials where they had one rope only.
    **named : number, array_like or quantity
        The same settings under another name or unit, as in the header of a trial table: `wheel_diameter_mm=70`,
        `wrap_turns=1.5`, `wheel_radius="35 mm"`.

    Raises
    ------
    InputError
        If a setting is missing or has no unit, or no such wheel lifts the load.
    UnknownNameError
        If there is no such argument.

    Examples
    --------
    >>> trials = {"wheel_radius_mm": 40, "rope_diameter_mm": 10, "wrap_angle_rad": [3.0, 6.0, 9.0], "end_tension_N": 20,
    ...     "peak_N": [36.6, 66.1, 121.7]}
    >>> found = design(fit(trials, "constant"), lift="100 N", wheel_radius="40 mm", end_tension_N=20, probability=None)
    >>> round(float(found.value[0]), 1)
    8.0
    """
    NUMBER.check_given(probability=probability)
    stored = as_fit(fit)
    asked = in_declared_units(
        named, lift_N=lift_N, wheel_radius_m=wheel_radius_m, wrap_angle_rad=wrap_angle_rad,
        end_tension_N=end_tension_N, rope_radius_m=rope_radius_m,
    )  # fmt: skip
    given: dict[str, Any] = settings(**asked)
    _refuse_missing(given, ["lift_N"])
    given.setdefault("rope_radius_m", _rope(stored))
    return find_design(stored, solve_for=solve_for, probability=probability, **given)


def run(
    campaign: Campaign | PathLike,
    folder: PathLike,
    *,
    law: str = "",
    jobs: int = 1,
    overwrite: bool = False,
    executor: Any = None,
) -> CampaignRun:
    """Return a campaign's result, from recordings to the lift force of its wheel, and write its files into a folder.

    Parameters
    ----------
    campaign : Campaign or path-like
        The campaign or its file.
    folder : path-like
        Where trials.csv, fits/, comparison.csv, … go; what an earlier run wrote there and no longer fits is removed.
    law : str
        The law to use; "" for the best law with a usable fit.
    jobs, executor
        As `extract`.
    overwrite : bool
        Replace files in the folder that ropefric did not write; the campaign's own are never replaced.

    Returns
    -------
    CampaignRun
        `extraction`, `comparison`, `fit` and `prediction`.

    Examples
    --------
    >>> import tempfile
    >>> from ropefric.rig.campaign import prth_bench_plan, simulate_campaign
    >>> bench = prth_bench_plan()
    >>> small = replace(bench, conditions=bench.conditions[:4], repeats=1, faults={})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = simulate_campaign(folder, small, seed=1)
    ...     found = run(Path(folder, "campaign.toml"), Path(folder, "out"))
    ...     names = {path.name for path in Path(folder, "out").iterdir()}
    >>> "trials.csv" in names, len(found.extraction.trials)
    (True, 4)
    """
    PATH.check(folder=folder)
    WHOLE_NUMBER.check(jobs=jobs)
    loaded = as_campaign(campaign)
    with campaign_folder(loaded, folder, force=overwrite) as target:
        result = run_campaign(loaded, target, law=law, jobs=jobs, executor=executor)
        target.publish("answer")
    return result


def _refuse_missing(given: Mapping[str, Any], needed: Iterable[str], how: str = "by name") -> None:
    missing = [name for name in needed if name not in given]
    if missing:
        text = f"no value for {', '.join(missing)}"
        raise InputError(text, key=missing[0], fix=f"give it {how}")


def _rope(fit: FitResult) -> FloatArray:
    return settings(rope_radius_m=fit.only_rope_radius_m())["rope_radius_m"]


def _wheel(asked: Mapping[str, Any]) -> Conditions:
    given = settings(**{name: asked[name] for name in SETTINGS})
    _refuse_missing(given, SETTINGS)
    return one_condition(**{name: number(value, "", name) for name, value in given.items()})


def budget(
    fit: FitResult | PathLike,
    *,
    wheel_radius_m: Given = None,
    wrap_angle_rad: Given = None,
    end_tension_N: Given = None,
    rope_radius_m: Given = None,
    u_wheel_radius_m: Given = None,
    u_rope_radius_m: Given = None,
    u_wrap_angle_rad: Given = None,
    u_end_tension_N: Given = None,
    one_pull: bool = False,
    level: float = 0.95,
    draws: int = 200_000,
    seed: int = 0,
    **named: Given,
) -> Statement:
    """Return the uncertainty budget of a lift force that a fit predicts for a wheel known only so well.

    Parameters
    ----------
    fit : FitResult or path-like
        The fit or its file.
    wheel_radius_m, wrap_angle_rad, end_tension_N : float
        R_w [m], φ [rad], F_B [N].
    rope_radius_m : float, optional
        R_r [m]; that of the trials where they had one rope only.
    u_wheel_radius_m, u_rope_radius_m, u_wrap_angle_rad, u_end_tension_N : float
        Their standard uncertainties; what has none is exact.
    one_pull : bool
        Of one pull with a new rope, not of the mean law.
    level, draws, seed
        As `ropefric.uncertainty.budget.state_uncertainty`.
    **named : number, array_like or quantity
        The same settings under another name or unit, as in the header of a trial table: `wheel_diameter_mm=70`,
        `wrap_turns=1.5`, `u_wrap="2 deg"`.

    Returns
    -------
    Statement
        `budget.lines`, its check by draws, what would make it smaller, and a `status`.

    Raises
    ------
    InputError
        If the law has no answer for this wheel, or the rope is not given and not known.

    Examples
    --------
    >>> import numpy as np
    >>> import pandas as pd
    >>> wrap_rad = np.repeat([3.0, 6.0, 9.0], 2)
    >>> frame = pd.DataFrame({"wheel_radius_mm": 40, "rope_diameter_mm": 10, "wrap_angle_rad": wrap_rad,
    ...     "end_tension_N": 20, "peak_N": 20 * np.exp(0.2 * wrap_rad + 0.01 * np.array([1, -1, -1, 1, 1, -1]))})
    >>> stated = budget(fit(frame, "constant"), wheel_radius_m=0.04, wrap_angle_rad=7.0, end_tension_N=20.0,
    ...                 u_wrap_angle_rad=0.03, draws=20_000)
    >>> round(stated.budget.estimate, 1), max(stated.budget.lines, key=lambda line: line.share).name
    (81.1, 'wrap angle')
    """
    NUMBER.check(level=level)
    WHOLE_NUMBER.check(draws=draws, seed=seed)
    stored = as_fit(fit)
    asked = in_declared_units(
        named, wheel_radius_m=wheel_radius_m, wrap_angle_rad=wrap_angle_rad, end_tension_N=end_tension_N,
        rope_radius_m=rope_radius_m, u_wheel_radius_m=u_wheel_radius_m, u_rope_radius_m=u_rope_radius_m,
        u_wrap_angle_rad=u_wrap_angle_rad, u_end_tension_N=u_end_tension_N,
    )  # fmt: skip
    if asked["rope_radius_m"] is None:
        asked["rope_radius_m"] = _rope(stored)
    at = _wheel(asked)
    stds = {name: 0.0 if asked[f"u_{name}"] is None else asked[f"u_{name}"] for name in SETTINGS}
    wheel_std = {name: number(std, split_unit_suffix(name)[1], f"u_{name}") for name, std in stds.items()}
    return budgets.state_lift(stored, at, wheel_std, one_pull=one_pull, level=level, draws=draws, seed=seed)


def plan_tests(
    known: FitResult | next_tests.PlannedLaw | PathLike,
    *,
    wheels_m: Sequence[Given] | None = None,
    wraps_rad: Sequence[Given] | None = None,
    end_tensions_N: Sequence[Given] | None = None,
    wheel_radius_m: Given = None,
    wrap_angle_rad: Given = None,
    end_tension_N: Given = None,
    rope_radius_m: Given = None,
    largest_force_N: Given = None,
    n_conditions: int = 12,
    repeats: int = 12,
    level: float = 0.95,
    **named: Given,
) -> next_tests.LabPlan:
    """Return the conditions to test next so that one wanted lift force becomes as certain as it can.

    Parameters
    ----------
    known : FitResult, PlannedLaw or path-like
        A fit or its file; or a law with guessed parameters, from `ropefric.fitting.next_tests.planned_guess`.
    wheels_m, wraps_rad, end_tensions_N : sequence of float
        Settings the rig has: R_w [m], φ [rad], F_B [N].
    wheel_radius_m, wrap_angle_rad, end_tension_N : float
        The wheel whose lift force is wanted.
    rope_radius_m : float, optional
        R_r [m]; that of the trials where they had one rope only, and needed with a guessed law.
    largest_force_N : float
        The largest F_A the cell takes [N]; no limit by default.
    n_conditions, repeats, level
        As `ropefric.fitting.next_tests.plan_tests`.
    **named : number, array_like or quantity
        The same settings under another name or unit, as in the header of a trial table: `wheel_diameter_mm=70`,
        `wrap_turns=1.5`, `wheels_mm=[30, 40]`.

    Raises
    ------
    InputError
        If the rope is not given and not known, or no plan within these settings determines the law.

    Examples
    --------
    >>> from ropefric.fitting.next_tests import planned_guess
    >>> from ropefric.fitting.resolution import MeanScatter
    >>> from ropefric.friction.laws import LAWS
    >>> law = planned_guess(LAWS["constant"], {"mu": 0.2}, MeanScatter(within=0.02))
    >>> plan = plan_tests(law, wheels_mm=[30, 40], wraps_rad=[3.0, 6.0, 9.0, 12.0], end_tensions_N=[20.0, 40.0],
    ...     wheel_radius_m=0.05, wrap_angle_rad=14.0, end_tension_N=20.0, rope_radius_m=0.005, largest_force_N=300.0,
    ...     n_conditions=3, repeats=4)
    >>> plan.conditions.wrap_angle_rad.tolist()
    [9.0, 12.0, 12.0]
    """
    WHOLE_NUMBER.check(n_conditions=n_conditions, repeats=repeats)
    NUMBER.check(level=level)
    asked = in_declared_units(
        named, wheels_m=wheels_m, wraps_rad=wraps_rad, end_tensions_N=end_tensions_N, wheel_radius_m=wheel_radius_m,
        wrap_angle_rad=wrap_angle_rad, end_tension_N=end_tension_N, rope_radius_m=rope_radius_m,
        largest_force_N=largest_force_N,
    )  # fmt: skip
    if isinstance(known, next_tests.PlannedLaw):
        planned = known
        if asked["rope_radius_m"] is None:
            text = "a guessed law does not know its rope"
            raise InputError(text, key="rope_radius_m", fix="give the rope's radius [m]")
    else:
        stored = _loaded(load_fit, FitResult, known=known)
        planned = next_tests.planned_fit(stored)
        if asked["rope_radius_m"] is None:
            asked["rope_radius_m"] = _rope(stored)
    wanted = _wheel(asked)
    of_rig = {"wheels_m": "wheel_radius_m", "wraps_rad": "wrap_angle_rad", "end_tensions_N": "end_tension_N"}
    _refuse_missing({name: value for name, value in asked.items() if value is not None}, of_rig)
    rig = settings(**{name: asked[one] for one, name in of_rig.items()})
    largest_N = math.inf if asked["largest_force_N"] is None else asked["largest_force_N"]
    limits = resolution.RigLimits(
        **{name: tuple(values.tolist()) for name, values in rig.items()},
        rope_radius_m=float(wanted.rope_radius_m[0]),
        largest_force_N=number(largest_N, "N", "largest_force_N"),
    )
    return next_tests.plan_tests(
        planned, limits, wanted, n_conditions=n_conditions, repeats=repeats, level=level
    )


def accuracy_table(
    study: str = "", case: str = "", *, method: str = "", timed: bool = False
) -> "pd.DataFrame":
    """Return what accuracy costs: the error and the work of every way to solve one of the problems behind the numbers.

    Parameters
    ----------
    study : str
        Such as "integral" or "peak"; "" for the list of studies with their cases.
    case, method : str
        One case of the study, by default all; and one method.
    timed : bool
        Measure the times, too; otherwise the table is the same on every machine.

    Returns
    -------
    DataFrame
        A row a setting: `error` (relative), `evaluations`, `bias`, `noise`; `seconds` where timed.

    Raises
    ------
    UnknownNameError
        If there is no such study or case.

    Examples
    --------
    >>> rows = accuracy_table("integral", "regular", method="gauss-legendre")
    >>> bool((rows["error"] < 1e-12).any())
    True
    """
    import pandas as pd  # noqa: PLC0415  (quick start-up)

    from ropefric.accuracy.measure import error_table, measure_studies  # noqa: PLC0415  (likewise)
    from ropefric.accuracy.studies import STUDIES  # noqa: PLC0415

    if not study:
        rows = [(one.name, one.title, ", ".join(each.name for each in one.cases)) for one in STUDIES.values()]
        return pd.DataFrame(rows, columns=["study", "comparison", "cases"])
    cases = (STUDIES[study].case(case),) if case else STUDIES[study].cases
    if timed:
        (measured,) = measure_studies([replace(STUDIES[study], cases=cases)], quick=True)
        points = [one for one in measured.points if method in {"", one.method}]
    else:
        points = [one for each in cases for one in error_table(study, each.name, method=method)]
    columns = ["case", "method", "setting", "error", "evaluations", "bias", "noise"]
    columns += ["seconds"] if timed else []
    return pd.DataFrame([[getattr(one, name) for name in columns] for one in points], columns=columns)


def solve(scene: Scene | PathLike, *, level: float = 0.95) -> Solution:
    """Return the answer to a scene, simulated with the effects that its accuracy calls for.

    Parameters
    ----------
    scene : Scene or path-like
        The scene or its file.
    level : float
        Of the intervals.

    Returns
    -------
    Solution
        `to_dict()` holds the numbers, `warnings` what speaks against using them.

    Raises
    ------
    DataError
        With everything that is wrong with the file, or where the scene has no answer.

    Examples
    --------
    >>> import tempfile
    >>> from ropefric.scenes.scene_templates import write_scenes
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     hoist = solve(write_scenes(folder, ["hoist"])[0]).to_dict()
    >>> round(hoist["lift_force_N"]), hoist["effects"]["simulated"]
    (319, ['wrap-dependence', 'size', 'end-tension'])
    """
    NUMBER.check(level=level)
    return solve_scene(_as_scene(scene), level=level)


def explain(scene: Scene | PathLike, *, measure: bool = False) -> Explanation:
    """Return how a scene is solved: each effect, whether it is simulated, and its influence.

    Parameters
    ----------
    scene : Scene or path-like
        The scene or its file.
    measure : bool
        Read the clock, too: what time each effect takes.

    Examples
    --------
    >>> import tempfile
    >>> from ropefric.scenes.scene_templates import write_scenes
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = explain(write_scenes(folder, ["band-saw"])[0])
    >>> found.plan.left_out
    ('bending', 'torsion')
    """
    return explain_scene(_as_scene(scene), measure=measure)


def sweep(
    scene: Scene | PathLike,
    *axes: str | Axis,
    progress: Callable[[int, int, str], None] | None = None,
    table: PathLike | None = None,
    executor: Any = None,
) -> Sweep:
    """Return the numbers of a scene's answer over a grid of any of its own numbers.

    Parameters
    ----------
    scene : Scene or path-like
        The scene or its file.
    *axes : str or Axis
        "wheel.wrap=90deg:1440deg:50", "wheel.radius=20mm,40mm"; several make a grid, of which the last runs fastest.
    progress : callable, optional
        Called with points done, points in all, and what they are.
    table : path-like, optional
        A file ending in .csv or .parquet for the table.
    executor : concurrent.futures.Executor or dask.distributed.Client, optional
        Solves the points, with the same result to the last bit.

    Returns
    -------
    Sweep
        `columns` by name, one value a point; `axes` and `shape` of the grid.

    Raises
    ------
    UnknownNameError
        For a key that the scene does not give, or that holds no number.
    InputError
        For values that the scene cannot take, or where no point has an answer.

    Examples
    --------
    >>> import tempfile
    >>> from ropefric.scenes.scene_templates import write_scenes
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = sweep(write_scenes(folder, ["hoist"])[0], "wheel.wrap=1turn,2turn,3turn")
    >>> found.columns["lift_force_N"].round(-2).tolist()
    [200.0, 500.0, 1100.0]
    """
    loaded = _as_scene(scene)
    for axis in axes:
        Kind((str, Axis), "text such as wheel.wrap=1turn,2turn").check(axes=axis)
    PATH.check_given(table=table)
    CALL.check_given(progress=progress)
    grid = tuple(parse_axis(loaded, axis) if isinstance(axis, str) else axis for axis in axes)
    return _tabled(table, lambda: sweep_scene(loaded, grid, progress=progress, executor=executor))


_Many = TypeVar("_Many", Sweep, Draws)


def _tabled(table: PathLike | None, solve_all: Callable[[], _Many]) -> _Many:
    """Return the answers to many cases, written as a table where that is asked for."""
    if table is None:
        return solve_all()
    path = Path(table)
    check_table(path.name)
    found = solve_all()
    write_table(Folder(path.parent), path.name, found.table)
    return found


def monte_carlo(
    scene: Scene | PathLike,
    *,
    draws: int = 10_000,
    seed: int = 0,
    level: float = 0.95,
    progress: Callable[[int, int, str], None] | None = None,
    table: PathLike | None = None,
    executor: Any = None,
) -> Draws:
    """Return what a scene answers to draws of what it is not sure of, planned once for all of them.

    The parameters of a fit are drawn together, from its covariance with its degrees of freedom (multivariate t); what
    the scene's `[tolerances]` state is a limit of error, so each value within it is as likely.

    Parameters
    ----------
    scene : Scene or path-like
        The scene or its file.
    draws, seed : int
        How many, 10 to a million, and what they begin with: the same draws whatever solves them.
    level : float
        Of the outer quantiles: at 0.95 those of 2.5 % and 97.5 %.
    progress : callable, optional
        Called with draws done, draws in all, and what they are.
    table : path-like, optional
        A file ending in .csv or .parquet: what was drawn and the answer to it, a row a draw.
    executor : concurrent.futures.Executor or dask.distributed.Client, optional
        Solves the draws, with the same result to the last bit.

    Returns
    -------
    Draws
        `numbers` with mean, standard deviation and quantiles; `shares` in which the machine fails; `to_dict()`.

    Raises
    ------
    InputError
        Where nothing in the scene is uncertain, or no draw has an answer.

    Examples
    --------
    >>> import tempfile
    >>> from ropefric.scenes.scene_templates import write_scenes
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = write_scenes(folder, ["hoist"])[0]
    ...     off = {"tolerances": {"wheel": {"wrap": "5 deg"}, "load": {"end_tension": "2 %"}}}
    ...     found = monte_carlo(load_scene(path, off), draws=1000)
    >>> lift = found.numbers["lift_force_N"]
    >>> round(lift.value), round(lift.mean), round(lift.std, 1)
    (319, 319, 3.9)
    """
    WHOLE_NUMBER.check(draws=draws, seed=seed)
    NUMBER.check(level=level)
    PATH.check_given(table=table)
    CALL.check_given(progress=progress)
    loaded, how = _as_scene(scene), {"seed": seed, "level": level, "progress": progress, "executor": executor}
    return _tabled(table, lambda: draw_scene(loaded, draws, **how))


def _as_scene(scene: Scene | PathLike) -> Scene:
    return _loaded(load_scene, Scene, scene=scene)


def as_fit(fit: FitResult | PathLike) -> FitResult:
    """Return a fit, loaded where its file is given."""
    return _loaded(load_fit, FitResult, fit=fit)
