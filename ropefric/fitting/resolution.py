"""Settings of a rig, and what a list of conditions can determine before anything is measured.

The expected standard errors of a law's parameters, and the power of the test against each simpler law.
"""

import itertools
import math
import os
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import fdtri, ncfdtr

from ropefric.arrays import FloatArray, IntArray
from ropefric.errors import InputError, Problem, raise_problems
from ropefric.files.plain_text import rounded_tree
from ropefric.fitting.problem import FitProblem, batched_fit
from ropefric.fitting.result import SPARE
from ropefric.fitting.statistics import condition_means, decomposed
from ropefric.friction.condition import SETTINGS, Conditions, condition_groups
from ropefric.friction.law import FrictionLaw
from ropefric.friction.laws import LAWS
from ropefric.glossary import counted
from ropefric.trials.campaign_model import Campaign
from ropefric.trials.cells import QUANTITIES, CellTable, Columns, example_of, read_cells
from ropefric.trials.table import TrialTable, read_trial_table

TYPICAL_WITHIN, TYPICAL_BETWEEN = 0.015, 0.01
"""Scatter of ln F_A between repeats and between conditions where none is known [-]."""

FACTORS = ("wheel_radius_m", "wrap_angle_rad", "end_tension_N")
"""Settings that a plan may vary; the rope is the same throughout."""

MOST = 1000
"""Settings of one factor, conditions, repeats and starts of a plan."""

# Of all combinations, each weighed against the others.
_MOST_CONDITIONS = 50_000
# By the share of campaigns, in whole per cent, in which a test distinguishes two laws.
_VERBS = {
    80: "distinguishable",
    50: "probably distinguishable",
    20: "rarely distinguishable",
    0: "not distinguishable",
}
SCALE = ", ".join(f"{words}: in {share} % of campaigns or more" for share, words in _VERBS.items() if share)
"""Meaning of the words of an outlook."""
# A parameter is determined where its standard error is at most this part of it.
_TOLD = 0.5
_TYPICAL_MU = 0.2
_TEST_LEVEL = 0.05
# From this noncentrality on the power is one.
_BEYOND_DOUBT = 1e3


@dataclass(frozen=True, slots=True, kw_only=True)
class MeanScatter:
    """How the mean of a condition's repeats scatters."""

    within: float
    between: float = 0.0

    def __post_init__(self) -> None:
        within, between = both = (self.within, self.between)
        if not all(math.isfinite(x) and x >= 0.0 for x in both) or not within + between > 0.0:
            text = f"scatter within {within:g}, between {between:g}"
            fix = "give standard deviations of ln F from 0, within or between above it: 0.017 is 1.7 % between repeats"
            raise InputError(text, key="scatter", fix=fix)

    def variance(self, repeats: npt.ArrayLike) -> FloatArray:
        """Return the variance of the means of repeats about what they share, s_b² + s_w²/m."""
        return np.asarray(self.between**2 + self.within**2 / np.asarray(repeats, dtype=np.float64))


@dataclass(frozen=True, slots=True, kw_only=True)
class RigLimits:
    """Every setting a rig offers; each combination is a condition that might be tested."""

    wheel_radius_m: tuple[float, ...]
    wrap_angle_rad: tuple[float, ...]
    end_tension_N: tuple[float, ...]
    rope_radius_m: float
    largest_force_N: float = math.inf

    def __post_init__(self) -> None:
        for name in FACTORS:
            levels = sorted(float(level) for level in getattr(self, name))
            if not levels or not (levels[0] > 0.0 and math.isfinite(levels[-1])):
                text = f"{name}: {levels} are no settings"
                raise InputError(text, key=name, fix="give one or more above zero")
            if len(set(levels)) < len(levels):
                raise InputError(f"{name}: a setting is given twice", key=name, fix="give each once")
            object.__setattr__(self, name, tuple(levels))
        if math.prod(self.shape) > _MOST_CONDITIONS:
            sizes = " × ".join(str(size) for size in self.shape)
            text = f"{sizes} settings are {math.prod(self.shape)} conditions; the limit is {_MOST_CONDITIONS}"
            fix = "give fewer wheels, wraps or end tensions, or fewer levels"
            raise InputError(text, key="settings", fix=fix)
        for name in ("rope_radius_m", "largest_force_N"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"{name} = {getattr(self, name):g} is not positive", key=name)

    @property
    def shape(self) -> tuple[int, ...]:
        """Return the number of settings of each factor."""
        return tuple(len(getattr(self, name)) for name in FACTORS)

    def conditions(self) -> Conditions:
        """Return all combinations, wheel by wheel, wrap by wrap, end tension by end tension."""
        grid = np.meshgrid(*(getattr(self, name) for name in FACTORS), indexing="ij")
        columns = dict(zip(FACTORS, (axis.ravel() for axis in grid), strict=True))
        return Conditions(rope_radius_m=np.array(self.rope_radius_m), **columns)


def levels(low: float, high: float, n: int, *, step: float | None = None) -> tuple[float, ...]:
    """Return about n settings, ends included: whole multiples of a step, or two digits in even ratios without one."""
    if step is None and not low > 0.0:
        raise InputError(f"a range from {low:g} has no even ratios", key="range", fix="begin above zero")
    if not low < high:
        raise InputError(f"a range from {low:g} to {high:g}", key="range", fix="give low before high")
    if step is None:
        inner = [float(f"{x:.2g}") for x in np.geomspace(low, high, n).tolist()]
    else:
        inner = [round(x / step) * step for x in np.linspace(low, high, n).tolist()]
    return tuple(sorted({low, high, *(x for x in inner[1:-1] if low <= x <= high)}))


class LawOutlook(NamedTuple):
    """Information of conditions about a law, if it is true with typical parameters.

    Attributes
    ----------
    law : str
        The law.
    reason : str
        Why it can have no say at all; empty if it can.
    expected_std : dict of str to float
        Standard error to expect of each fitted parameter; infinite for one that no condition shows.
    untold : tuple of str
        Parameters whose standard error exceeds half their typical size.
    power : dict of str to float
        Of each simpler law that it contains: the share of campaigns in which the test distinguishes the two.
    """

    law: str
    expected_std: dict[str, float]
    untold: tuple[str, ...]
    power: dict[str, float]
    reason: str = ""

    @property
    def text(self) -> str:
        """Return the outlook in words."""
        if self.reason:
            return f"{self.law}: cannot be judged: {self.reason}"
        words = []
        for simpler, power in self.power.items():
            share = round(100.0 * power)
            verb = next(verb for least, verb in _VERBS.items() if share >= least)
            words.append(f"{verb} from {simpler} (in {share} % of campaigns)")
        if self.untold:
            words.append(f"{', '.join(self.untold)} cannot be determined")
        return f"{self.law}: {'; '.join(words) or 'all parameters can be determined'}"

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON object; an infinite standard error is None."""
        return dict(rounded_tree(self._asdict() | {"text": self.text}, None))


def outlook_of_campaign(campaign: Campaign) -> tuple[LawOutlook, ...]:
    """Return what the trials listed in a campaign can determine, at the typical scatter of ropes.

    Where the slack side is to be measured, its tension is what a usual coefficient leaves of the load.
    """
    trials = [trial for trial in campaign.trials if not trial.exclude]
    place = np.array([(t.wheel_radius_m, t.rope_radius_m, t.wrap_angle_rad) for t in trials]).reshape(-1, 3)
    left = np.exp(-_TYPICAL_MU * place[:, 2])
    tensions = [
        trial.end_tension_N if trial.end_tension_N is not None else (trial.lift_force_N or 1.0) * part
        for trial, part in zip(trials, left, strict=True)
    ]
    columns = [*place.T, np.array(tensions)]
    return _outlooks(columns, condition_groups(*columns), TYPICAL_WITHIN)


def outlook_of_table(table: TrialTable) -> tuple[LawOutlook, ...]:
    """Return what the conditions of a table can determine, at the scatter of its own repeats where it has any."""
    settings, group = listed(table)
    within = scatter_of_repeats(table)
    return _outlooks([*settings.values()], group, TYPICAL_WITHIN if math.isnan(within) else within)


def listed(table: TrialTable) -> tuple[dict[str, FloatArray], IntArray]:
    """Return settings and conditions of the trials that have a force, or of all in a list that has no forces yet."""
    used = table.used
    settings = {name: getattr(table, name)[used if used.any() else table.kept] for name in SETTINGS}
    return settings, table.group() if used.any() else condition_groups(*settings.values())


def scatter_of_repeats(table: TrialTable) -> float:
    """Return the standard deviation of ln F_A between repeats; NaN where no condition has two forces."""
    pulls = FitProblem.plain(LAWS["constant"], table.conditions(), table.log_lift())
    return condition_means(replace(pulls, group=table.group())).scatter_within


def _outlooks(columns: Sequence[FloatArray], group: IntArray, within: float) -> tuple[LawOutlook, ...]:
    first = np.unique(group, return_index=True)[1]
    at = Conditions(**{name: column[first] for name, column in zip(SETTINGS, columns, strict=True)})
    variance = TYPICAL_BETWEEN**2 + within**2 / np.bincount(group)
    return tuple(law_outlook(law, at, variance) for law in LAWS.values())


def read_list(path: str | os.PathLike[str]) -> TrialTable:
    """Return a trial table, or a list of conditions without forces: a row a pull, or as many as `repeats` says."""
    table, problems = read_cells(path)
    columns, others, wrong = table.bind(QUANTITIES, ("repeats",))
    if wrong or "peak_N" in columns:
        return read_trial_table(path)
    found = [*problems, *(doubt for name in others for doubt in table.near_miss(name, QUANTITIES, ()))]
    found += _missing_columns(table, columns)
    if not table.rows:
        text, fix = "the list has a header, but no conditions", "add a row for each"
        found.append(table.problem(table.header_line, "", "RF101", text, fix))
    raise_problems(found)
    read, refused = table.numbers(columns)
    written = [row[columns["repeats"].index] if "repeats" in columns else "1" for _, row in table.rows]
    often = [int(text) if text.isdecimal() and len(text) < 5 else 0 for text in written]
    found += itertools.chain(*refused.values())
    found += _empty_cells(table, columns, read, refused)
    found += _wrong_repeats(table, written, often)
    raise_problems(sorted(found, key=lambda problem: problem.line or 0))
    settings: dict[str, Any] = {name: np.repeat(read[name], often) for name in SETTINGS}
    names = tuple(f"row-{line}-{i}" for (line, _), n in zip(table.rows, often, strict=True) for i in range(n))
    return TrialTable(
        trial=names, peak_N=np.array(math.nan), source=table.path, warnings=tuple(found), **settings
    )


def _empty_cells(
    table: CellTable, columns: Columns, read: Mapping[str, Sequence[float]], refused: Container[int]
) -> Iterator[Problem]:
    """Yield the settings that a row leaves empty."""
    text = "the cell is empty, and every condition needs it"
    for place, (line, _) in enumerate(table.rows):
        for name in SETTINGS if place not in refused else ():
            if math.isnan(read[name][place]):
                yield table.problem(line, columns[name].header, "RF121", text, "write the number")


def _wrong_repeats(table: CellTable, written: Sequence[str], often: Sequence[int]) -> Iterator[Problem]:
    """Yield the numbers of pulls that are none, or too large."""
    for (line, _), text, n in zip(table.rows, written, often, strict=True):
        if not 1 <= n <= MOST:
            why = f"{text[:40]!r} is no number of pulls"
            yield table.problem(line, "repeats", "RF102", why, f"write 1 to {MOST}")


def _missing_columns(table: CellTable, columns: Columns) -> Iterator[Problem]:
    """Yield which settings have no column."""
    campaign = Path(table.path).with_name("campaign.toml")
    for stem in ("wheel_radius", "rope_diameter", "wrap_angle", "end_tension"):
        if QUANTITIES[stem][0] not in columns:
            text = f"there is no column for the {stem.replace('_', ' ')}; every condition needs one"
            fix = f"add a column {example_of(stem, QUANTITIES)}"
            if campaign.is_file():
                fix += f"; or check the campaign that this list is of, {campaign.as_posix()}"
            yield table.problem(table.header_line, "", "RF121", text, fix)


def law_outlook(
    law: FrictionLaw, at: Conditions, variance: FloatArray, theta: Sequence[float] | FloatArray | None = None
) -> LawOutlook:
    """Return what means of conditions, with a variance of ln F_A, can determine of a law, by default a typical one."""
    truth = np.array([item.start for item in law.parameters] if theta is None else theta, dtype=np.float64)
    free = np.array([not item.fixed for item in law.parameters])
    names = [item.name for item in law.parameters if not item.fixed]
    n, q = len(at), len(names)
    reasons = law.validity(truth, at)
    if not reasons and n < q + SPARE:
        reasons = (f"{counted(n, 'condition')} for {counted(q, 'parameter')}, and {q + SPARE} are needed",)
    if reasons:
        return LawOutlook(law.name, {}, tuple(names), {}, reasons[0])
    svd = decomposed(law.jacobian(truth, at)[:, free] / np.sqrt(variance)[:, None])
    half, _ = svd.root()
    std = np.where(svd.unseen, np.inf, np.linalg.norm(half, axis=1))
    found = dict(zip(names, std.tolist(), strict=True))
    weak = std > _TOLD * np.abs(truth[free])
    # An offset of zero has no size to compare its error with.
    untold = tuple(name for name, bad in zip(names, weak & (truth[free] != 0.0), strict=True) if bad)
    power = {case.name: _power(law, truth, case, at, variance) for case in law.special_cases}
    return LawOutlook(law.name, found, untold, power)


def _power(
    law: FrictionLaw, theta: FloatArray, simpler: FrictionLaw, at: Conditions, variance: FloatArray
) -> float:
    """Return the power of the F-test of a law against a simpler one, from the misfit of that."""
    n, fuller = len(at), sum(not item.fixed for item in law.parameters)
    # An effect that is zero there is taken as a tenth.
    signed = (law.lower < 0.0) & (law.upper > 0.0)
    shown = law.log_lift(np.where((theta == 0.0) & signed, 0.1, theta), at)
    problem = FitProblem.plain(simpler, at, shown, np.sqrt(variance))
    try:
        off = float(batched_fit(problem, tolerance=1e-3, max_iterations=60).chi2[0])
    except InputError:
        return math.nan
    more, left = fuller - problem.n_varying, n - fuller
    if off > _BEYOND_DOUBT:
        return 1.0
    limit = float(fdtri(more, left, 1.0 - _TEST_LEVEL))
    return 1.0 - float(ncfdtr(more, left, max(off, 1e-12), limit))
