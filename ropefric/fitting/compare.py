"""Which law the data ask for: all laws on one trial table, ranked by AICc over the conditions, and the one to use.

A law stands on the condition means: refit there, judged by likelihood, with each mean left out. Residuals are those of
the force that was measured: the lift force or, where a known weight is lifted, the end tension. Where the load is set
and the slack side is measured, ln F_A has no scatter at all, and a law that answers the same F_A whatever the end
tension would seem perfect. Such a law says nothing of the force that was measured, and dividing by ∂ ln F_A/∂ ln F_B
shows it.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import FitError, RopefricError, UnknownNameError
from ropefric.files.digits import rounded_tree
from ropefric.fitting.fit import fit_law
from ropefric.fitting.levenberg import batched_fit
from ropefric.fitting.predict import Candidate, Prediction, predict
from ropefric.fitting.problem import FitProblem
from ropefric.fitting.result import RIVAL, Doubt, FitResult, FitStatus, Verdict, same_lift, verdict_of
from ropefric.fitting.statistics import (
    ConditionMeans,
    ScatterFit,
    aicc,
    akaike_weights,
    bic,
    condition_means,
    f_test,
    scatter_fit,
)
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.friction.law import Columns, FrictionLaw, Refusal
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
# Criteria are differences of logarithms, weights and p-values their powers.
_DIGITS = 6
# Weights and parameters depend on each other only where conditions have unequal numbers of repeats.
_ROUNDS = 4
# Of ln F_B, for how the slope by it changes with the parameters; the error is a millionth of a small correction.
_STEP = 1e-6


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
        return dict(rounded_tree({name: getattr(self, name) for name in names}, _DIGITS))


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
        names = ("unit", "n", "n_trials", "scatter_within", "conclusive", "notes")
        tree = {name: getattr(self, name) for name in names} | {
            "ranking": [entry.to_dict() for entry in self.ranking],
            "f_tests": [asdict(test) for test in self.tests],
        }
        return dict(rounded_tree(tree, _DIGITS))


@dataclass(frozen=True, slots=True, eq=False)
class Standing:
    """A law fitted to condition means, in the lift force or in the end tension."""

    problem: FitProblem
    theta: FloatArray
    scatter: ScatterFit
    chi2: float
    k: int
    aicc: float
    bic: float


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
    data, slack = fits["constant"].data, table.measures_slack
    means = condition_means(data if unit == "conditions" else replace(data, group=np.arange(data.n_points)))
    standings = {name: standing(fit.data, means, fit.theta, slack=slack) for name, fit in fits.items()}
    for name, stands in standings.items():
        notes[name] = (
            notes[name] or _no_judge(fits[name], stands, means, slack=slack) or _twin(name, standings, notes)
        )
    ranking = _ranking(fits, standings, notes, len(means))
    tests = tuple(
        found
        for stands in standings.values()
        for case in stands.problem.law.special_cases
        if case.name in standings and (found := nested_test(standings[case.name], stands)) is not None
    )
    return Comparison(
        ranking=ranking,
        tests=tests,
        unit=unit,
        n=len(means),
        n_trials=data.n_points,
        scatter_within=means.scatter_within,
        notes=_notes(ranking, tests, means, unit, slack=slack),
    )


def _ranking(
    fits: Mapping[str, FitResult], standings: Mapping[str, Standing], notes: Mapping[str, str], n: int
) -> tuple[ComparisonEntry, ...]:
    """Return all laws, those without a note weighed and first."""
    ranked = [name for name, note in notes.items() if not note]
    criteria = [standings[name].aicc for name in ranked]
    # Weights say nothing of one law, nor of the constant ones where others went unjudged: a law that the data show to
    # be a simpler one was judged, one without an answer, or with too few data, was not.
    judged = len(fits) == len(notes) and all(
        fit.status not in _NO_ANSWER and standings[name].aicc < math.inf for name, fit in fits.items()
    )
    told = len(ranked) > 1 and (judged or not set(ranked) <= set(ALWAYS))
    weight_of = dict(zip(ranked, akaike_weights(criteria).tolist(), strict=True))
    best, entries = min(criteria, default=math.nan), []
    for name, note in notes.items():
        weight = 0.0 if note else weight_of[name] if told else math.nan
        entry = ComparisonEntry(law=name, n=n, note=note, counted=not note, weight=weight)
        if name in fits:
            stands, fit = standings[name], fits[name]
            entry = replace(
                entry,
                **{key: getattr(stands, key) for key in ("k", "chi2", "aicc", "bic")},
                # Two laws that follow the data exactly both stand at −inf, no distance apart.
                delta_aicc=0.0 if stands.aicc == best else stands.aicc - best,
                loco_error=math.nan if note else leave_one_out(stands),
                status=fit.status.value,
                fit=fit,
            )
        entries.append(entry)
    return tuple(sorted(entries, key=lambda e: (not e.counted, math.inf if math.isnan(e.aicc) else e.aicc)))


def _why_not(fit: FitResult) -> str:
    """Return why a fit has no say in the weights; empty if it has."""
    if fit.status in _NO_ANSWER:
        return fit.status.advice
    if fit.identifiability.unseen:
        named = ", ".join(fit.identifiability.unseen)
        return f"the data do not show {named}, so the law is a simpler one here and is not counted twice"
    return ""


def _no_judge(fit: FitResult, stands: Standing, means: ConditionMeans, *, slack: bool) -> str:
    """Return why the conditions cannot judge a law, or its fit missed what was measured; empty otherwise."""
    if stands.aicc == math.inf:
        few = counted(len(means), "observation")
        return f"{few} cannot judge {stands.k} estimated quantities; {stands.k + 2} are needed"
    missed = stands.problem.law.log_lift(fit.theta, stands.problem.conditions) - means.log_lift
    if slack and scatter_fit(missed, means).deviance > stands.scatter.deviance + _STRAYED:
        text = "its fit answers the lift that was set whatever the end tension"
        return f"{text}, and so says nothing of what was measured"
    return ""


def _twin(name: str, standings: Mapping[str, Standing], notes: Mapping[str, str]) -> str:
    """Return which simpler or earlier law gives the same forces; empty if none does."""
    mine, order = standings[name], list(standings)
    for other, theirs in standings.items():
        earlier = order.index(other) < order.index(name)
        if other == name or notes[other] or not (theirs.k < mine.k or (earlier and theirs.k == mine.k)):
            continue
        # The forces themselves, from whichever side they are seen.
        laws = ((ALL_LAWS[other], theirs), (ALL_LAWS[name], mine))
        lifts = [law.log_lift(stands.theta, stands.problem.conditions) for law, stands in laws]
        if float(np.abs(lifts[0] - lifts[1]).max()) <= _SAME:
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
    ranked = {entry.law: entry for entry in ranking if entry.counted}
    if not ranked or math.isnan(ranking[0].weight):
        named = f"only {' and '.join(ranked)} could be" if ranked else "no law could be"
        notes.append(
            f"{named} ranked on {in_all}, so weights would say nothing and no law is chosen: measure more conditions"
        )
        against = [test for test in tests if test.simpler in ranked and test.fuller not in ranked]
        worst = min(against, key=lambda test: test.p_value, default=None)
        if worst is not None and worst.p_value < _CHANCE:
            more = f"{worst.fuller}, which is not ranked, follows the trials better (p = {worst.p_value:.2g})"
            notes.append(f"an F-test speaks against {worst.simpler}: {more}")
    rivals = [law for law, entry in ranked.items() if entry.delta_aicc <= RIVAL]
    if len(rivals) > 1:
        notes.append(f"within 2 of the best AICc, so not told apart: {', '.join(rivals)}")
    wraps = [law for law in rivals if "wrap-dependence" in ALL_LAWS[law].effects]
    if wraps and "constant-offset" in rivals:
        notes.append(
            f"a constant μ with an offset looks like a wrap effect, and these data do not tell constant-offset from "
            f"{', '.join(wraps)}: measure the offset at a wrap near zero"
        )
    return tuple(notes)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _SetLoads(Conditions):
    """Conditions at which the lift force was set, and the end tension measured."""

    log_lift: FloatArray

    def select(self, index: npt.ArrayLike) -> "_SetLoads":
        """Return the conditions at an index array or boolean mask, in that order."""
        chosen = np.asarray(index)
        return _SetLoads(**{item.name: getattr(self, item.name)[chosen] for item in fields(self)})


@dataclass(frozen=True, slots=True)
class _EndTension:
    """The physics of a law seen from the end tension, to first order.

    Its ln F_A is as far off the one that was set as the law's ln F_B is off the measured one, the other way:
    (ln F_A − set)/(∂ ln F_A/∂ ln F_B). A slope of zero leaves the end tension open, however small the rest.
    """

    physics: Any

    def rise_and_slopes(self, columns: Columns, conditions: _SetLoads) -> tuple[FloatArray, Columns]:
        """Return the rise as seen, and its slopes by the parameters."""
        known = conditions.log_lift - conditions.log_end_tension
        rise, slopes = self.physics.rise_and_slopes(columns, conditions)
        slope = np.maximum(self.physics.condition_slopes(columns, conditions)[2], 1e-12)
        more = replace(conditions, end_tension_N=conditions.end_tension_N * (1.0 + _STEP))
        after = self.physics.rise_and_slopes(columns, more)[1]
        off = (rise - known) / slope
        # The slope by ln F_B changes with a parameter as the slope by the parameter changes with ln F_B.
        seen = ((by - off * (later - by) / _STEP) / slope for by, later in zip(slopes, after, strict=True))
        return known + off, tuple(seen)

    def rise(self, columns: Columns, conditions: _SetLoads) -> FloatArray:
        """Return the rise as seen."""
        return self.rise_and_slopes(columns, conditions)[0]

    def refusals(self, columns: Columns, conditions: _SetLoads) -> Iterable[Refusal]:
        """Return where the law itself has no answer."""
        return tuple(self.physics.refusals(columns, conditions))


def standing(
    problem: FitProblem, means: ConditionMeans, theta: npt.ArrayLike, *, slack: bool = False
) -> Standing:
    """Return how the law of a problem stands on condition means, in the force that was measured."""
    starts, K = np.atleast_2d(np.asarray(theta, dtype=np.float64)), len(means)
    law, conditions = problem.law, means.conditions
    if slack and "end-tension" in law.effects:
        seen: Any = _EndTension(law.physics)
        law = replace(law, physics=seen)
        settings = {name: getattr(conditions, name) for name in SETTINGS}
        conditions = _SetLoads(log_lift=means.log_lift, **settings)
        # A fit of ln F_A may have gone to where F_A does not depend on F_B, from which no gradient leads back.
        declared = [parameter.start for parameter in law.parameters]
        starts = np.vstack([starts, np.where(problem.vary, declared, starts)])
    on_means = replace(
        problem, law=law, conditions=conditions, log_lift=means.log_lift, std=means.std, group=np.arange(K)
    )
    for _ in range(_ROUNDS):
        at, _converged = refit(on_means, starts)
        residual = law.log_lift(at, conditions) - means.log_lift
        scatter = scatter_fit(residual, means)
        on_means = replace(on_means, std=np.sqrt(scatter.variance))
        starts = np.vstack([at, starts[1:]])
        if not means.repeated or float(np.ptp(means.std)) <= 1e-9 * float(means.std[0]):
            break
    k = problem.n_varying + 1
    chi2 = float((residual**2 / scatter.variance).sum())
    criteria = (aicc(scatter.deviance, K, k), bic(scatter.deviance, K, k))
    return Standing(on_means, at, scatter, chi2, k, *criteria)


def refit(problem: FitProblem, starts: FloatArray) -> tuple[FloatArray, bool]:
    """Return the parameters of the best of some searches, and whether it converged."""
    found = batched_fit(problem, starts=starts)
    best = int(np.argmin(found.chi2))
    return (found.theta if np.isfinite(found.chi2[best]) else starts)[best], bool(found.converged[best])


def leave_one_out(law: Standing) -> float:
    """Return the leave-one-condition-out error: RMS of the ln F predicted by a fit to all other means, less measured.

    This is the relative error of the force at conditions the law has not seen. NaN where the other means cannot fix
    the parameters (K ≤ number of parameters) or a refit fails.
    """
    problem, K = law.problem, law.problem.n_points
    if problem.n_varying >= K:
        return math.nan
    found = batched_fit(problem, starts=law.theta, multiplicity=1.0 - np.eye(K))
    if not (found.converged & problem.law.admissible(found.theta, problem.conditions)).all():
        return math.nan
    missed = np.diagonal(problem.law.log_lift(found.theta, problem.conditions) - problem.log_lift)
    return float(np.sqrt(np.mean(missed**2)))


def nested_test(simpler: Standing, fuller: Standing) -> FTest | None:
    """Return the test of two laws, both weighted as the fuller; None without degrees of freedom.

    Where the simpler law lies on a bound of the fuller (a = 0), the p-value is too large rather than too small.
    """
    n, p_simpler, p_fuller = fuller.problem.n_points, simpler.problem.n_varying, fuller.problem.n_varying
    if n <= p_fuller or p_fuller <= p_simpler:
        return None
    weighted = replace(simpler.problem, std=fuller.problem.std)
    at, _converged = refit(weighted, simpler.theta[np.newaxis])
    chi2 = float((weighted.residuals(at) ** 2).sum())
    F, dof, p_value = f_test(chi2, fuller.chi2, n=n, p_simpler=p_simpler, p_fuller=p_fuller)
    names = (simpler.problem.law.name, fuller.problem.law.name)
    return FTest(simpler=names[0], fuller=names[1], f=F, dof=dof, p_value=p_value)


# Their forces follow the data as well as those of others, whatever is known of their parameters.
_ANSWERING = frozenset({FitStatus.OK, FitStatus.AT_BOUND, FitStatus.UNIDENTIFIABLE})


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Choice:
    """The law that is used."""

    fit: FitResult
    entry: ComparisonEntry
    forced: bool
    verdict: Verdict
    doubts: tuple[str, ...]
    rivals: tuple[FitResult, ...]

    @property
    def how(self) -> str:
        """Return how the law came to be used, and the verdict."""
        chosen = self.entry.counted and not math.isnan(self.entry.weight)
        place = "the best by AICc" if chosen else "shown, since none could be chosen"
        return f"{'as asked for' if self.forced else place}; {self.verdict.word}"

    def to_dict(self) -> dict[str, Any]:
        """Return a JSON tree of the law and the verdict."""
        return {"law": self.fit.law, "verdict": self.verdict.to_dict()}

    def of(self, prediction: Prediction) -> Prediction:
        """Return a prediction of one condition with this verdict, and beside it what the rivals answer."""
        candidates = _candidates(prediction, (self.fit, *self.rivals))
        return replace(prediction, judged=self.verdict, candidates=candidates if len(candidates) > 1 else ())


def choose_law(comparison: Comparison, law: str = "", wheel: Conditions | None = None) -> Choice:
    """Return the best law of a comparison whose fit may be used as it stands, or the law that is asked for."""
    fits = {entry.law: entry.fit for entry in comparison.ranking if entry.fit is not None}
    fitted = [entry for entry in comparison.ranking if entry.law in fits]
    if law:
        chosen = comparison[law]
        if law not in fits:
            raise FitError(f"{law} has no answer on these data: {chosen.note}", fix="use another law")
    else:
        good = [entry for entry in fitted if entry.counted and fits[entry.law].trustworthy]
        chosen = (good or fitted)[0]
    fit = fits[chosen.law]
    # The laws that the data do not tell from the one used: all that fit, where none could be weighed.
    others = [(entry, fits[entry.law]) for entry in fitted if entry is not chosen]
    if comparison.conclusive:
        near = [(entry, other) for entry, other in others if entry.counted and entry.delta_aicc <= RIVAL]
        rivals = tuple(other for _, other in near if other.status in _ANSWERING)
    else:
        rivals = tuple(other for _, other in others if other.status is FitStatus.OK)
    doubts = [*_of_place(comparison, chosen, fitted[0], forced=bool(law)), *fit.doubts]
    other = [r.law for r in rivals if comparison[r.law].counted and not _agree(fit, r, wheel)]
    if other:
        where = "on the conditions tested" if wheel is None else "for the wheel asked for"
        text = f"are within {RIVAL:g} in AICc and answer differently {where}"
        doubts.append(("undecided", f"{chosen.law} and {' and '.join(other)} {text}"))
    weight = "" if math.isnan(chosen.weight) else f" with a weight of {chosen.weight:.2f}"
    names = " and ".join(rival.law for rival in rivals)
    alike = f"; {names} answer{'s' * (len(rivals) == 1)} alike" if rivals else ""
    place = "has the lowest AICc" if chosen.delta_aicc <= 0.0 else f"is within {RIVAL:g} of the lowest AICc"
    text = f"{chosen.law} {place}{weight}, and its fit follows the data within their scatter{alike}"
    return Choice(
        fit=fit,
        entry=chosen,
        forced=bool(law),
        verdict=verdict_of(doubts, text),
        doubts=tuple(dict.fromkeys(text for _, text in doubts)),
        rivals=rivals,
    )


def _of_place(
    comparison: Comparison, chosen: ComparisonEntry, first: ComparisonEntry, *, forced: bool
) -> list[Doubt]:
    """Return what the place of a law in the comparison says against it."""
    if not comparison.conclusive:
        ranked = [entry.law for entry in comparison.ranking if entry.counted]
        named = f"only {' and '.join(ranked)} could be" if ranked else "no law could be"
        where = counted(comparison.n, comparison.unit[:-1])
        return [("not judged", f"no choice of law: {named} ranked on {where}; measure more conditions")]
    if not chosen.counted:
        return [("not judged", f"{chosen.law} takes no part in the comparison: {chosen.note}")]
    lead = chosen.delta_aicc - (first.delta_aicc if first.counted else 0.0)
    if chosen is first or lead <= 0.0:
        return []
    text = f"{first.law} stands {lead:.1f} in AICc before"
    if forced:
        text = f"{chosen.law} was asked for; {text} it"
    else:
        text = f"{text} {chosen.law}, but is not to be used as it stands: {first.status}"
    return [("undecided" if lead > RIVAL else "supported", text)]


def _agree(fit: FitResult, rival: FitResult, wheel: Conditions | None) -> bool:
    """Return whether two laws give the same lift force for a wheel, or on the conditions tested."""
    if wheel is None:
        if fit.problem is None:
            return True
        wheel = fit.problem.conditions.select(np.unique(fit.problem.group, return_index=True)[1])
    try:
        own, other = (predict(one, wheel, check=False) for one in (fit, rival))
    except RopefricError:
        return False
    laws = ALL_LAWS[fit.law], ALL_LAWS[rival.law]
    nested = laws[0] in laws[1].special_cases or laws[1] in laws[0].special_cases
    # Of a law on a bound, or not shown by the data, no interval is known, and only its force can be looked at.
    known = rival.status is FitStatus.OK
    return same_lift(
        other.log_lift - own.log_lift,
        own.log_half_width,
        np.nan_to_num(other.log_half_width),
        nested=nested or not known,
    )


def _candidates(prediction: Prediction, fits: Sequence[FitResult]) -> tuple[Candidate, ...]:
    """Return the answers of several laws for one condition, the same one once."""
    found: list[Candidate] = []
    for fit in fits:
        try:
            other = predict(
                fit, prediction.conditions, level=prediction.level, method=prediction.method, check=False
            )
        except RopefricError:
            continue
        lift_N = float(other.lift_force_N[0])
        if not any(math.isclose(lift_N, item.lift_force_N, rel_tol=1e-6) for item in found):
            low, high = other.interval_N[0].tolist()
            std_N = float(other.std_N[0])
            found.append(Candidate(law=fit.law, lift_force_N=lift_N, std_N=std_N, interval_N=(low, high)))
    return tuple(found)
