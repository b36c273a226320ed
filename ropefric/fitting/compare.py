"""Which law the data ask for: all laws on one trial table, ranked by AICc over the conditions."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Any, Literal

import numpy as np

from ropefric.errors import RopefricError, UnknownNameError
from ropefric.files.digits import rounded_tree
from ropefric.fitting.fit import fit_law
from ropefric.fitting.result import FitResult
from ropefric.fitting.standing import (
    Standing,
    leave_one_out,
    measured_residual,
    nested_test,
    standing,
)
from ropefric.fitting.statistics import ConditionMeans, akaike_weights, condition_means, scatter_fit
from ropefric.fitting.verdict import RIVAL, FitStatus
from ropefric.friction.law import FrictionLaw
from ropefric.friction.laws import ALL_LAWS, LAWS
from ropefric.glossary import counted
from ropefric.registry import did_you_mean
from ropefric.trials.table import TrialTable

Unit = Literal["conditions", "trials"]

ALWAYS = ("constant", "constant-offset")
"""Laws that stand in every comparison: a constant μ with an offset can look exactly like a wrap effect."""

REFUSED = "refused"
"""Status of a law that has no answer on the data."""

_NO_ANSWER = frozenset({FitStatus.NOT_CONVERGED, FitStatus.TOO_FEW_POINTS})
# Laws whose ln F_A agree to this at every condition are one law on these data.
_SAME = 1e-6
# Twice a log-likelihood this far below the best that the law can do is another solution.
_STRAYED = 10.0
_CHANCE = 0.05
_DIGITS = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class FTest:
    """Whether a law's extra parameters explain more than chance."""

    simpler: str
    fuller: str
    f: float
    dof: tuple[int, int]
    p_value: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ComparisonEntry:
    """One law in a comparison; NaN where there is no such number."""

    law: str
    n: int
    k: int = 0
    chi2: float = math.nan
    aicc: float = math.nan
    bic: float = math.nan
    delta_aicc: float = math.nan
    weight: float = 0.0
    loco_error: float = math.nan
    status: str = REFUSED
    counted: bool = False
    note: str
    fit: FitResult | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON object of the entry; None where there is no number."""
        names = (item.name for item in fields(self) if item.name != "fit")
        return _rounded({name: getattr(self, name) for name in names})


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Comparison:
    """Laws on one trial table, best first.

    Attributes
    ----------
    ranking : tuple of ComparisonEntry
        Counted laws by AICc, then the others.
    tests : tuple of FTest
        Nested pairs, on the same observations.
    unit : {"conditions", "trials"}
        What an observation is.
    n, n_trials : int
        Observations and trials.
    scatter_within : float
        Standard deviation of ln F_A between repeats [-]; NaN without repeats.
    notes : tuple of str
        What to know before reading the ranking.
    """

    ranking: tuple[ComparisonEntry, ...]
    tests: tuple[FTest, ...]
    unit: Unit
    n: int
    n_trials: int
    scatter_within: float
    notes: tuple[str, ...]

    @property
    def best(self) -> ComparisonEntry:
        """Return the entry that won."""
        return self.ranking[0]

    @property
    def conclusive(self) -> bool:
        """Return whether laws could be weighed against each other, so that the first of the ranking was chosen."""
        return self.best.counted and not math.isnan(self.best.weight)

    def __getitem__(self, law: str) -> ComparisonEntry:
        for entry in self.ranking:
            if entry.law == law:
                return entry
        known = [entry.law for entry in self.ranking]
        raise UnknownNameError(f"{law!r} is not in this comparison", fix=did_you_mean(law, known))

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON shape: `ranking` best first, F-tests and notes; weights are null if not `conclusive`."""
        tests = [_rounded(asdict(test)) for test in self.tests]
        return _rounded({
            "ranking": [entry.to_dict() for entry in self.ranking], "f_tests": tests, "unit": self.unit, "n": self.n,
            "n_trials": self.n_trials, "scatter_within": self.scatter_within, "conclusive": self.conclusive,
            "notes": list(self.notes),
        })  # fmt: skip


def _rounded(tree: dict[str, Any]) -> dict[str, Any]:
    """Return numbers to six digits: criteria are differences of logarithms, weights and p-values their powers."""
    return dict(rounded_tree(tree, _DIGITS))


def compare_laws(
    table: TrialTable,
    laws: Iterable[str | FrictionLaw] | None = None,
    *,
    unit: Unit = "conditions",
    progress: Callable[[str, int, int], None] | None = None,
) -> Comparison:
    """Return how friction laws stand against each other on a trial table."""
    if isinstance(laws, str | FrictionLaw):
        laws = [laws]
    given = LAWS.values() if laws is None else [ALL_LAWS[x] if isinstance(x, str) else x for x in laws]
    # In one order whatever was asked for, so that ties are always settled alike.
    chosen = {law.name: law for law in [*(LAWS[name] for name in ALWAYS), *given]}
    fits: dict[str, FitResult] = {}
    notes: dict[str, str] = {}
    for number, (name, law) in enumerate(chosen.items(), start=1):
        if progress is not None:
            progress(name, number, len(chosen))
        try:
            fits[name] = fit_law(table, law)
            notes[name] = _why_not(fits[name])
        except RopefricError as error:
            if name == "constant":
                raise
            # The law itself knows best why it has no answer on these conditions.
            reasons = law.validity([parameter.start for parameter in law.parameters], table.conditions())
            notes[name] = reasons[0] if reasons else str(error)
    constant = fits["constant"].data
    means = condition_means(
        constant if unit == "conditions" else replace(constant, group=np.arange(constant.n_points))
    )
    slack = table.measures_slack
    standings = {name: standing(fit.data, means, fit.theta, slack=slack) for name, fit in fits.items()}
    for name, stands in standings.items():
        notes[name] = (
            notes[name]
            or _too_few(stands, means)
            or _strayed(fits[name], stands, means)
            or _twin(name, standings, notes)
        )
    ranking = _ranking(fits, standings, notes, len(means))
    tests = tuple(
        FTest(simpler=simpler, fuller=fuller, f=found[0], dof=found[1], p_value=found[2])
        for fuller, stands in standings.items()
        for simpler in (case.name for case in stands.problem.law.special_cases)
        if simpler in standings and (found := nested_test(standings[simpler], stands)) is not None
    )
    return Comparison(
        ranking=ranking,
        tests=tests,
        unit=unit,
        n=len(means),
        n_trials=constant.n_points,
        scatter_within=means.scatter_within,
        notes=_notes(ranking, tests, means, unit, slack=slack),
    )


def _ranking(
    fits: Mapping[str, FitResult], standings: Mapping[str, Standing], notes: Mapping[str, str], n: int
) -> tuple[ComparisonEntry, ...]:
    """Return all laws, those without a note weighed and first."""
    ranked = [name for name, note in notes.items() if not note]
    best = min((standings[name].aicc for name in ranked), default=math.nan)
    weights = dict(
        zip(ranked, akaike_weights([standings[name].aicc for name in ranked]).tolist(), strict=True)
    )
    # Weights say nothing of one law, nor of the constant ones where others went unjudged: a law that the data show to
    # be a simpler one was judged, one without an answer, or with too few data, was not.
    judged = len(fits) == len(notes) and all(
        fit.status not in _NO_ANSWER and standings[name].aicc < math.inf for name, fit in fits.items()
    )
    if len(ranked) < 2 or (set(ranked) <= set(ALWAYS) and not judged):
        weights = dict.fromkeys(ranked, math.nan)
    entries = []
    for name, note in notes.items():
        if name not in fits:
            entries.append(ComparisonEntry(law=name, n=n, note=note))
            continue
        stands = standings[name]
        entries.append(
            ComparisonEntry(
                law=name,
                n=n,
                k=stands.k,
                chi2=stands.chi2,
                aicc=stands.aicc,
                bic=stands.bic,
                # Two laws that follow the data exactly both stand at −inf, no distance apart.
                delta_aicc=0.0 if stands.aicc == best else stands.aicc - best,
                weight=weights.get(name, 0.0),
                loco_error=math.nan if note else leave_one_out(stands),
                status=fits[name].status.value,
                counted=not note,
                note=note,
                fit=fits[name],
            )
        )
    return tuple(sorted(entries, key=lambda e: (not e.counted, math.inf if math.isnan(e.aicc) else e.aicc)))


def _why_not(fit: FitResult) -> str:
    """Return why a fit has no say in the weights; empty if it has."""
    if fit.status in _NO_ANSWER:
        return fit.status.advice
    if fit.identifiability.unseen:
        named = ", ".join(fit.identifiability.unseen)
        return f"the data do not show {named}, so the law is a simpler one here and is not counted twice"
    return ""


def _too_few(stands: Standing, means: ConditionMeans) -> str:
    if stands.aicc == math.inf:
        few = counted(len(means), "observation")
        return f"{few} cannot judge {stands.k} estimated quantities; {stands.k + 2} are needed"
    return ""


def _strayed(fit: FitResult, stands: Standing, means: ConditionMeans) -> str:
    """Return whether the fit of ln F_A missed the measured end tensions; empty if it did not."""
    if not stands.slack:
        return ""
    residual = measured_residual(stands.problem, fit.theta, slack=True)
    if scatter_fit(residual, means).deviance <= stands.scatter.deviance + _STRAYED:
        return ""
    return "its fit answers the lift that was set whatever the end tension, and so says nothing of what was measured"


def _twin(name: str, standings: Mapping[str, Standing], notes: Mapping[str, str]) -> str:
    """Return which simpler or earlier law gives the same forces; empty if none does."""
    mine, earlier = standings[name], True
    for other, theirs in standings.items():
        if other == name:
            earlier = False
            continue
        simpler = theirs.k < mine.k or (earlier and theirs.k == mine.k)
        if simpler and not notes[other] and float(np.abs(theirs.log_lift() - mine.log_lift()).max()) <= _SAME:
            return f"gives the same forces as {other} on these data, and is counted once"
    return ""


def _notes(
    ranking: Sequence[ComparisonEntry],
    tests: Sequence[FTest],
    means: ConditionMeans,
    unit: Unit,
    *,
    slack: bool,
) -> tuple[str, ...]:
    """Return what to know before reading a ranking; first what an observation is."""
    in_all = counted(len(means), unit[:-1])
    notes = [f"AICc counts {in_all}, not repeats" if unit == "conditions" else "AICc counts every trial"]
    if not means.repeated and unit == "conditions":
        notes.append("no condition was repeated, so every trial is a condition of its own")
    if slack:
        notes.append("the load was set and the end tension measured, so the residuals are those of ln F_B")
    ranked = [entry for entry in ranking if entry.counted]
    if any(math.isnan(entry.weight) for entry in ranked) or not ranked:
        notes += _unjudged(ranking, tests, in_all)
    rivals = [e.law for e in ranked if e.delta_aicc <= RIVAL]
    if len(rivals) > 1:
        notes.append(f"within 2 of the best AICc, so not told apart: {', '.join(rivals)}")
    wraps = [law for law in rivals if "wrap-dependence" in ALL_LAWS[law].effects]
    if wraps and "constant-offset" in rivals:
        notes.append(
            f"a constant μ with an offset looks like a wrap effect, and these data do not tell constant-offset from "
            f"{', '.join(wraps)}: measure the offset at a wrap near zero"
        )
    return tuple(notes)


def _unjudged(ranking: Sequence[ComparisonEntry], tests: Sequence[FTest], in_all: str) -> list[str]:
    """Return that the ranking decides nothing, and which tests speak against what it holds."""
    ranked = [entry.law for entry in ranking if entry.counted]
    named = f"only {' and '.join(ranked)} could be" if ranked else "no law could be"
    notes = [
        f"{named} ranked on {in_all}, so weights would say nothing and no law is chosen: measure more conditions"
    ]
    against = [test for test in tests if test.simpler in ranked and test.fuller not in ranked]
    against = sorted((test for test in against if test.p_value < _CHANCE), key=lambda test: test.p_value)
    notes += [
        f"an F-test speaks against {test.simpler}: {test.fuller}, which is not ranked, follows the trials better "
        f"(p = {test.p_value:.2g})"
        for test in against[:1]
    ]
    return notes
