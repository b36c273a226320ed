"""Which law the data ask for: all laws on one trial table, ranked by AICc over the conditions."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from ropefric.errors import InputError, RopefricError, UnknownNameError
from ropefric.files.digits import rounded_tree
from ropefric.fitting.fit import fit_law
from ropefric.fitting.problem import FitProblem
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
    k: int
    chi2: float
    aicc: float
    bic: float
    delta_aicc: float
    weight: float
    loco_error: float
    status: str
    counted: bool
    note: str
    fit: FitResult | None

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON object of the entry; None where there is no number."""
        numbers = ("chi2", "aicc", "delta_aicc", "weight", "bic", "loco_error")
        values = {name: getattr(self, name) for name in numbers}
        plain = {name: float(value) if math.isfinite(value) else None for name, value in values.items()}
        return {
            "law": self.law,
            "n": self.n,
            "k": self.k,
            "status": self.status,
            "counted": self.counted,
            "note": self.note,
        } | _rounded(plain)


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
        return _rounded({
            "ranking": [entry.to_dict() for entry in self.ranking],
            "f_tests": [
                {"simpler": t.simpler, "fuller": t.fuller, "f": t.f if math.isfinite(t.f) else None,
                 "dof": list(t.dof), "p_value": t.p_value}
                for t in self.tests
            ],
            "unit": self.unit,
            "n": self.n,
            "n_trials": self.n_trials,
            "scatter_within": self.scatter_within if math.isfinite(self.scatter_within) else None,
            "conclusive": self.conclusive,
            "notes": list(self.notes),
        })  # fmt: skip


def _rounded(tree: dict[str, Any]) -> dict[str, Any]:
    """Return numbers to six digits: criteria are differences of logarithms, weights and p-values their powers."""
    plain: dict[str, Any] = rounded_tree(tree, _DIGITS)
    return plain


def compare_laws(
    table: TrialTable,
    laws: Iterable[str | FrictionLaw] | None = None,
    *,
    unit: Unit = "conditions",
    law_options: Mapping[str, Mapping[str, Any]] | None = None,
    progress: Callable[[str, int, int], None] | None = None,
    **fit_options: Any,
) -> Comparison:
    """Return how friction laws stand against each other on a trial table."""
    chosen = _chosen(laws)
    options = {name: dict(values) for name, values in (law_options or {}).items()}
    for name in options:
        if name not in {law.name for law in chosen}:
            raise InputError(f"options for {name!r}, which is not compared", key=name)
    fits: dict[str, FitResult | RopefricError] = {}
    for number, law in enumerate(chosen, start=1):
        if progress is not None:
            progress(law.name, number, len(chosen))
        try:
            fits[law.name] = fit_law(table, law, **(fit_options | options.get(law.name, {})))
        except RopefricError as error:
            if law.name == "constant":
                raise
            # The law itself knows best why it has no answer on these conditions.
            reasons = law.validity([parameter.start for parameter in law.parameters], table.conditions())
            fits[law.name] = InputError(reasons[0], code="RF420") if reasons else error
    constant = _problem(fits["constant"])
    means = condition_means(
        constant if unit == "conditions" else replace(constant, group=np.arange(constant.n_points))
    )
    slack = table.measures_slack
    standings = {
        name: standing(_problem(fit), means, fit.theta, slack=slack)
        for name, fit in fits.items()
        if isinstance(fit, FitResult)
    }
    ranking, tests = _ranking(fits, standings, means), _tests(standings)
    return Comparison(
        ranking=ranking,
        tests=tests,
        unit=unit,
        n=len(means),
        n_trials=constant.n_points,
        scatter_within=means.scatter_within,
        notes=_notes(ranking, tests, means, unit, slack=slack),
    )


def _chosen(laws: Iterable[str | FrictionLaw] | None) -> list[FrictionLaw]:
    if isinstance(laws, str | FrictionLaw):
        laws = [laws]
    given = (
        LAWS.values() if laws is None else [ALL_LAWS[law] if isinstance(law, str) else law for law in laws]
    )
    # In one order whatever was asked for, so that ties are always settled alike.
    unique = {law.name: law for law in [*(LAWS[name] for name in ALWAYS), *given]}
    return list(unique.values())


def _problem(fit: FitResult | RopefricError) -> FitProblem:
    if isinstance(fit, RopefricError):
        raise fit
    if fit.problem is None:
        raise InputError(f"the fit of {fit.law} carries no data", fix="compare fits that were just made")
    return fit.problem


def _ranking(
    fits: Mapping[str, FitResult | RopefricError], standings: Mapping[str, Standing], means: ConditionMeans
) -> tuple[ComparisonEntry, ...]:
    notes = {name: _why_not(fit) for name, fit in fits.items()}
    for name, note in notes.items():
        notes[name] = (
            note
            or _too_few(standings[name], means)
            or _strayed(fits[name], standings[name], means)
            or _twin(name, standings, notes)
        )
    counted = [name for name in fits if not notes[name]]
    best = min((standings[name].aicc for name in counted), default=math.nan)
    shares = akaike_weights([standings[name].aicc for name in counted])
    if not _weighable(counted, fits, standings):
        shares = np.full_like(shares, math.nan)
    weights = dict(zip(counted, shares.tolist(), strict=True))
    entries = [
        _entry(name, fit, standings.get(name), means, best=best, weight=weights.get(name), note=notes[name])
        for name, fit in fits.items()
    ]
    return tuple(sorted(entries, key=lambda e: (not e.counted, math.inf if math.isnan(e.aicc) else e.aicc)))


def _weighable(
    counted: list[str], fits: Mapping[str, FitResult | RopefricError], standings: Mapping[str, Standing]
) -> bool:
    """Return whether weights say anything: not of one law, nor of the constant ones where others went unjudged."""
    if len(counted) < 2 or not set(counted) <= set(ALWAYS):
        return len(counted) > 1
    # A law that the data show to be a simpler one was judged; one without an answer, or with too few data, was not.
    return all(
        isinstance(fit, FitResult) and fit.status not in _NO_ANSWER and standings[name].aicc < math.inf
        for name, fit in fits.items()
    )


def _entry(
    name: str,
    fit: FitResult | RopefricError,
    stands: Standing | None,
    means: ConditionMeans,
    *,
    best: float,
    weight: float | None,
    note: str,
) -> ComparisonEntry:
    nan = math.nan
    if stands is None or isinstance(fit, RopefricError):
        return ComparisonEntry(
            law=name, n=len(means), k=0, chi2=nan, aicc=nan, bic=nan, delta_aicc=nan, weight=0.0,
            loco_error=nan, status=REFUSED, counted=False, note=note, fit=None,
        )  # fmt: skip
    # Two laws that follow the data exactly both stand at −inf, no distance apart.
    delta = 0.0 if stands.aicc == best else stands.aicc - best
    return ComparisonEntry(
        law=name,
        n=len(means),
        k=stands.k,
        chi2=stands.chi2,
        aicc=stands.aicc,
        bic=stands.bic,
        delta_aicc=delta,
        weight=weight or 0.0,
        loco_error=nan if weight is None else leave_one_out(stands),
        status=fit.status.value,
        counted=weight is not None,
        note=note,
        fit=fit,
    )


def _why_not(fit: FitResult | RopefricError) -> str:
    """Return why a fit has no say in the weights; empty if it has."""
    if isinstance(fit, RopefricError):
        return str(fit)
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


def _strayed(fit: FitResult | RopefricError, stands: Standing, means: ConditionMeans) -> str:
    """Return whether the fit of ln F_A missed the measured end tensions; empty if it did not."""
    if not stands.slack or isinstance(fit, RopefricError):
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


def _tests(standings: Mapping[str, Standing]) -> tuple[FTest, ...]:
    tests = []
    for fuller, stands in standings.items():
        for simpler in (case.name for case in stands.problem.law.special_cases):
            found = nested_test(standings[simpler], stands) if simpler in standings else None
            if found is not None:
                F, dof, p_value = found
                tests.append(FTest(simpler=simpler, fuller=fuller, f=F, dof=dof, p_value=p_value))
    return tuple(tests)


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
