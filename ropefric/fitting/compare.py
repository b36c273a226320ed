"""Which law the data support: all laws on one trial table, ranked by AICc over the conditions, and the one to use.

Each law is refitted to the condition means (`standing`) and judged there by likelihood, and with each mean left out. A
fuller law is preferred to a simpler one only where AICc, the error at conditions left out and an F-test agree; the
verdict is made by rules (`_RULES`), each from one fact to the word that it calls for.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from ropefric.errors import FitError, RopefricError, UnknownNameError
from ropefric.files.plain_text import rounded_tree
from ropefric.fitting.fit import fit_law
from ropefric.fitting.predict import Candidate, Prediction, predict
from ropefric.fitting.problem import law_named
from ropefric.fitting.result import RIVAL, Doubt, FitResult, FitStatus, Verdict, verdict_of
from ropefric.fitting.standing import (
    STRONG,
    FTest,
    Standing,
    leave_one_out,
    nested_test,
    standing,
    wild_trial,
)
from ropefric.fitting.statistics import ConditionMeans, akaike_weights, condition_means
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.friction.laws import ALL_LAWS, LAWS
from ropefric.glossary import counted
from ropefric.registry import did_you_mean
from ropefric.shown import Shown
from ropefric.trials.table import TrialTable

ALWAYS = ("constant", "constant-offset", "wrap-average")
"""Laws of every comparison: a constant μ with an offset and a wrap effect can look alike, with as many parameters."""

CHANCE = 0.01
"""p-value of an F-test above which a fuller law's lead is put down to chance: low, for the best of many laws leads."""

REFUSED = "refused"
"""Status of a law that has no answer on the data."""

_NO_ANSWER = frozenset({FitStatus.NOT_CONVERGED, FitStatus.TOO_FEW_POINTS})
# Laws whose ln F_A agree to this at every condition are one law on these data.
_SAME = 1e-6
_HIDDEN = (
    "the load was set and the end tension measured, which does not show how the friction depends on the end tension; "
    "compare a form ending in -from-zero"
)
# Half widths of two intervals that differ by no more than this factor are alike.
_WIDTHS = 2.0
# Criteria are differences of logarithms, weights and p-values their powers.
_DIGITS = 6


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
        tree = {item.name: getattr(self, item.name) for item in fields(self) if item.name != "fit"}
        return dict(rounded_tree(tree, _DIGITS))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Comparison(Shown):
    """Laws on one trial table, best first.

    Attributes
    ----------
    ranking : tuple of ComparisonEntry
        Counted laws by AICc, then the others.
    tests : tuple of FTest
        Nested pairs, on the same observations.
    n, n_trials : int
        Conditions, which are the observations, and trials.
    scatter_within : float
        Standard deviation of ln F_A between repeats [-]; NaN without repeats.
    notes : tuple of str
        What to know before reading the ranking.
    wild : tuple of str
        Trials that lie so far off all the others that they decide the ranking.
    """

    _said = ("best.law", "n", "unit", "n_trials", "scatter_within", "notes")
    _framed = "ranking"
    unit = "conditions"

    def _more_said(self) -> Iterator[tuple[str, str]]:
        yield "ranking", "delta AICc, weight, status"
        for entry in self.ranking:
            numbers = (
                f"{entry.delta_aicc:8.2f}  {entry.weight:5.3f}" if entry.counted else f"{'–':>8}  {'–':>5}"
            )
            yield f"  {entry.law}", f"{numbers}  {entry.status}"

    ranking: tuple[ComparisonEntry, ...]
    tests: tuple[FTest, ...]
    n: int
    n_trials: int
    scatter_within: float
    notes: tuple[str, ...]
    wild: tuple[str, ...] = ()

    @property
    def best(self) -> ComparisonEntry:
        """Return the entry that won."""
        return self.ranking[0]

    @property
    def conclusive(self) -> bool:
        """Return whether laws could be weighed against each other, so that the first of the ranking was chosen."""
        return self.best.counted and not math.isnan(self.best.weight)

    def __getitem__(self, law: str) -> ComparisonEntry:
        known = {entry.law: entry for entry in self.ranking}
        if law not in known:
            raise UnknownNameError(f"{law!r} is not in this comparison", fix=did_you_mean(law, known))
        return known[law]

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON shape: `ranking` best first, F-tests and notes; weights are null if not `conclusive`."""
        names = ("unit", "n", "n_trials", "scatter_within", "conclusive", "notes", "wild")
        tree = {name: getattr(self, name) for name in names} | {
            "ranking": [entry.to_dict() for entry in self.ranking],
            "f_tests": [test._asdict() for test in self.tests],
        }
        return dict(rounded_tree(tree, _DIGITS))


def compare_laws(
    table: TrialTable,
    laws: Iterable[str | FrictionLaw] | None = None,
    *,
    shared: Mapping[str, str] | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> Comparison:
    """Return friction laws ranked on a trial table; `shared` says which stated errors their trials share."""
    chosen = _chosen_laws(laws)
    fits: dict[str, FitResult] = {}
    notes: dict[str, str] = {}
    for number, (name, law) in enumerate(chosen.items(), start=1):
        if progress is not None:
            progress(name, number, len(chosen))
        fit, notes[name] = _fitted(table, law, shared)
        fits |= {} if fit is None else {name: fit}
    data, slack = fits["constant"].data, table.measures_slack
    means = condition_means(data)
    wild = wild_trial(data, slack=slack)
    hidden = [name for name, fit in fits.items() if slack and "end-tension" in fit.friction_law.effects]
    notes |= dict.fromkeys(hidden, _HIDDEN)
    standings = {
        name: standing(fit.data, means, fit.theta) for name, fit in fits.items() if name not in hidden
    }
    for name, stands in standings.items():
        notes[name] = notes[name] or _no_judge(stands, means)
        notes[name] = notes[name] or _twin(name, standings, notes)
    ranking, tests = _ranking(fits, standings, notes, len(means)), _nested_tests(standings)
    return Comparison(
        ranking=ranking,
        tests=tests,
        n=len(means),
        n_trials=data.n_points,
        scatter_within=means.scatter_within,
        notes=_notes(ranking, means),
        wild=() if wild is None else (np.array(table.trial)[table.used][wild].item(),),
    )


def _chosen_laws(laws: Iterable[str | FrictionLaw] | None) -> dict[str, FrictionLaw]:
    """Return the laws to compare by name, always in the same order so that ties are settled alike."""
    if isinstance(laws, str | FrictionLaw):
        laws = [laws]
    given = map(law_named, LAWS.values() if laws is None else laws)
    return {law.name: law for law in [*(LAWS[name] for name in ALWAYS), *given]}


def _nested_tests(standings: Mapping[str, Standing]) -> tuple[FTest, ...]:
    """Return the F-tests of all pairs of which one law is a special case of the other."""
    pairs = (
        (standings[case.name], fuller)
        for fuller in standings.values()
        for case in fuller.problem.law.special_cases
        if case.name in standings
    )
    found = (nested_test(simpler, fuller) for simpler, fuller in pairs)
    return tuple(test for test in found if test is not None)


def _fitted(
    table: TrialTable, law: FrictionLaw, shared: Mapping[str, str] | None
) -> tuple[FitResult | None, str]:
    """Return the fit of a law, and why it is not ranked; None where the law has no answer."""
    try:
        fit = fit_law(table, law, shared=shared)
    except RopefricError as error:
        if law.name == "constant":
            raise
        # The law itself knows best why it has no answer on these conditions.
        reasons = law.validity([parameter.start for parameter in law.parameters], table.conditions())
        return None, reasons[0] if reasons else str(error)
    return fit, _why_not(fit)


def _ranking(
    fits: Mapping[str, FitResult], standings: Mapping[str, Standing], notes: Mapping[str, str], n: int
) -> tuple[ComparisonEntry, ...]:
    """Return all laws, those without a note weighed and first."""
    ranked = [name for name, note in notes.items() if not note]
    criteria = [standings[name].aicc for name in ranked]
    judged = len(fits) == len(notes) and all(
        _is_judged(fits[name], stands) for name, stands in standings.items()
    )
    # Weights say nothing of one law, nor of the constant ones where others went unjudged.
    weighed = len(ranked) > 1 and (judged or not set(ranked) <= set(ALWAYS))
    weights = akaike_weights(criteria).tolist() if weighed else [math.nan] * len(ranked)
    weight_of, best = dict(zip(ranked, weights, strict=True)), min(criteria, default=math.nan)

    def entry(name: str, note: str) -> ComparisonEntry:
        plain = ComparisonEntry(law=name, n=n, note=note, counted=not note, weight=weight_of.get(name, 0.0))
        if name not in fits:
            return plain
        fit = fits[name]
        plain = replace(plain, status=fit.status.value, fit=fit)
        if name not in standings:
            return plain
        stands = standings[name]
        return replace(
            plain, k=stands.k, chi2=stands.chi2, aicc=stands.aicc, bic=stands.bic,
            # Two laws that follow the data exactly both stand at −inf, no distance apart.
            delta_aicc=0.0 if stands.aicc == best else stands.aicc - best,
            loco_error=math.nan if note else leave_one_out(stands),
        )  # fmt: skip

    entries = (entry(name, note) for name, note in notes.items())
    return tuple(sorted(entries, key=lambda e: (not e.counted, math.inf if math.isnan(e.aicc) else e.aicc)))


def _is_judged(fit: FitResult, stands: Standing) -> bool:
    """Return whether the data judged a law: also one that they show to be a simpler one."""
    return fit.status not in _NO_ANSWER and stands.aicc < math.inf


def _why_not(fit: FitResult) -> str:
    """Return why a fit has no say in the weights; empty if it has."""
    if fit.status in _NO_ANSWER:
        return fit.status.advice
    if fit.identifiability.unseen:
        named = ", ".join(fit.identifiability.unseen)
        return f"the data cannot determine {named}: the law reduces to a simpler one here"
    return ""


def _no_judge(stands: Standing, means: ConditionMeans) -> str:
    """Return why the conditions cannot judge a law; empty otherwise."""
    if stands.aicc < math.inf:
        return ""
    few = counted(len(means), "observation")
    return f"{few} cannot judge {stands.k} estimated quantities; {stands.k + 2} are needed"


def _twin(name: str, standings: Mapping[str, Standing], notes: Mapping[str, str]) -> str:
    """Return which simpler or earlier law gives the same forces; empty if none does."""
    mine, order = standings[name], list(standings)
    for other, theirs in standings.items():
        earlier = order.index(other) < order.index(name)
        if other == name or notes[other] or not (theirs.k < mine.k or (earlier and theirs.k == mine.k)):
            continue
        lifts = [one.problem.law.log_lift(one.theta, one.problem.conditions) for one in (theirs, mine)]
        if float(np.abs(lifts[0] - lifts[1]).max()) <= _SAME:
            return f"gives the same forces as {other} on these data"
    return ""


def _notes(ranking: Sequence[ComparisonEntry], means: ConditionMeans) -> tuple[str, ...]:
    """Return what to know before reading a ranking; first what an observation is."""
    in_all = counted(len(means), "condition")
    ranked = {entry.law: entry for entry in ranking if entry.counted}
    unweighed = not ranked or math.isnan(ranking[0].weight)
    rivals = _close(ranked, RIVAL)
    alike = [law for law in _close(ranked, STRONG) if _look_alike(law, ranking[0].law)]
    said = {
        f"AICc counts {in_all}, not repeats": True,
        "no condition was repeated, so every trial is a condition of its own": not means.repeated,
        _no_choice(ranked, in_all): unweighed,
        f"AICc within 2 of the best, so not distinguishable: {', '.join(rivals)}": len(rivals) > 1,
        f"{ranking[0].law} and {' and '.join(alike)} look alike: {_OFFSET_OR_WRAP}": alike,
    }
    return tuple(text for text, applies in said.items() if applies)


def _close(ranked: Mapping[str, ComparisonEntry], limit: float) -> list[str]:
    """Return the ranked laws whose AICc is above the best by no more than a limit."""
    return [law for law, entry in ranked.items() if entry.delta_aicc <= limit]


# Strong evidence is needed to distinguish laws with an offset from laws with a wrap effect.
_OFFSET_OR_WRAP = (
    "these conditions do not separate a constant offset from a wrap effect; a pull at a wrap near zero would"
)


def _look_alike(law: str, other: str) -> bool:
    """Return whether one of two laws has an offset where the other has a wrap effect."""
    effects = ALL_LAWS[law].effects, ALL_LAWS[other].effects
    return any(
        "offset" in one and "wrap-dependence" in two and "offset" not in two
        for one, two in (effects, effects[::-1])
    )


# Their forces follow the data as well as those of others, whatever is known of their parameters.
_ANSWERING = frozenset({FitStatus.OK, FitStatus.AT_BOUND, FitStatus.UNIDENTIFIABLE})


Preferred = Literal["simpler", "fuller", "undecided"]


class Rivalry(NamedTuple):
    """A fuller law against a simpler one, by three facts that need not agree.

    By how much the AICc of the fuller law is lower, the p-value of the F-test (NaN for laws that are not nested), and
    its error at conditions left out over that of the simpler one (NaN where one is not known).
    """

    simpler: str
    fuller: str
    lead: float
    p_value: float
    loco_ratio: float

    @property
    def preferred(self) -> Preferred:
        """Return the law to use: the fuller where all facts say so, the simpler where none does."""
        nested = not math.isnan(self.p_value)
        beyond_chance = self.p_value <= CHANCE if nested else self.lead > RIVAL
        if self.lead > 0.0 and beyond_chance and not self.loco_ratio > 1.0:
            return "fuller"
        return "simpler" if not beyond_chance and self.lead <= (RIVAL if nested else 0.0) else "undecided"

    @property
    def text(self) -> str:
        """Return the facts in words."""
        side = "below" if self.lead > 0.0 else "above"
        text = f"the AICc of {self.fuller} is {abs(self.lead):.1f} {side} that of {self.simpler}"
        text += "" if math.isnan(self.p_value) else f", the F-test gives p = {self.p_value:.2g}"
        if math.isnan(self.loco_ratio):
            return text
        return f"{text}, and its error at unseen conditions is {self.loco_ratio:.2f} times that of {self.simpler}"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Choice:
    """The law that is used."""

    fit: FitResult
    entry: ComparisonEntry
    forced: bool
    verdict: Verdict
    doubts: tuple[str, ...]

    @property
    def how(self) -> str:
        """Return how the law came to be used, and the verdict."""
        chosen = self.entry.counted and not math.isnan(self.entry.weight)
        place = "lowest AICc" if self.entry.delta_aicc <= 0.0 else "simplest law that no test rejects"
        place = place if chosen else "no law could be chosen"
        return f"{'as asked for' if self.forced else place}; {self.verdict.word}"

    def to_dict(self) -> dict[str, Any]:
        """Return a JSON tree of the law and the verdict."""
        return {"law": self.fit.law, "verdict": self.verdict.to_dict()}

    def of(self, prediction: Prediction) -> Prediction:
        """Return a prediction of one condition with this verdict; beside it what each rival answers, the same once."""
        answers = [prediction]
        for fit in self.fit.rivals:
            try:
                new = predict(fit, prediction.conditions, level=prediction.level)
            except RopefricError:
                continue
            known = (item.lift_force_N for item in answers)
            if not any(np.allclose(new.lift_force_N, lift_N, rtol=1e-6, atol=0.0) for lift_N in known):
                answers.append(new)
        candidates = tuple(
            Candidate(
                one.law, float(one.lift_force_N[0]), float(one.std_N[0]), tuple(one.interval_N[0].tolist())
            )
            for one in (answers if len(answers) > 1 else ())
        )
        return replace(prediction, verdict=self.verdict, candidates=candidates)


def choose_law(comparison: Comparison, law: str = "", wheel: Conditions | None = None) -> Choice:
    """Return the law of a comparison that is to be used, or the law named by `law`.

    That is the best one whose fit has no doubt, or a simpler one that no fact speaks against.
    """
    facts = _gathered(comparison, law, wheel)
    doubts = [doubt for rule in _RULES for doubt in rule(facts)]
    return Choice(
        fit=replace(facts.fit, rivals=facts.rivals),
        entry=facts.entry,
        forced=bool(law),
        verdict=verdict_of(doubts, _why_supported(facts)),
        doubts=tuple(dict.fromkeys(text for _, text in doubts)),
    )


class _Facts(NamedTuple):
    """Everything known about the law used: its place, its fit, and its rivals."""

    comparison: Comparison
    entry: ComparisonEntry
    fit: FitResult
    forced: bool
    wheel: Conditions | None
    first: ComparisonEntry
    open: tuple[Rivalry, ...]
    won: tuple[Rivalry, ...]
    rivals: tuple[FitResult, ...]


def _gathered(comparison: Comparison, law: str, wheel: Conditions | None) -> _Facts:
    fitted = [(entry, entry.fit) for entry in comparison.ranking if entry.fit is not None]
    good = [(entry, fit) for entry, fit in fitted if entry.counted and not fit.doubts_on(wheel)]
    chosen, fit = (good or fitted)[0]
    if law:
        chosen = comparison[law]
        if chosen.fit is None:
            raise FitError(f"{law} has no answer on these data: {chosen.note}", fix="use another law")
        fit = chosen.fit
    elif comparison.conclusive:
        simpler = _simplest(comparison, chosen, [entry for entry, _ in good])
        chosen, fit = simpler, simpler.fit or fit
    others = [entry for entry, _ in fitted if entry is not chosen]
    open_, won, rivals = _rivals_of(comparison, chosen, others)
    return _Facts(comparison, chosen, fit, bool(law), wheel, fitted[0][0], open_, won, rivals)


def _rivals_of(
    comparison: Comparison, chosen: ComparisonEntry, others: Sequence[ComparisonEntry]
) -> tuple[tuple[Rivalry, ...], tuple[Rivalry, ...], tuple[FitResult, ...]]:
    """Return open rivalries of the law used, those that it won, and the laws that the data do not exclude."""
    against = [rivalry for entry in others if (rivalry := rivalry_of(comparison, chosen, entry)) is not None]
    open_ = [one for one in against if one.preferred == "undecided"]
    won = [one for one in against if one.preferred == "fuller" and one.fuller == chosen.law]
    lost = {one.simpler for one in won}
    undecided = {name for one in open_ for name in (one.simpler, one.fuller)}

    def is_rival(entry: ComparisonEntry, other: FitResult) -> bool:
        if not comparison.conclusive:
            return other.status is FitStatus.OK
        limit = STRONG if _look_alike(entry.law, chosen.law) else RIVAL
        near = entry.counted and entry.delta_aicc <= limit and entry.law not in lost
        return other.status in _ANSWERING and (entry.law in undecided or near)

    rivals = tuple(e.fit for e in others if e.fit is not None and is_rival(e, e.fit))
    return tuple(open_), tuple(won), rivals


def _simplest(
    comparison: Comparison, chosen: ComparisonEntry, good: Sequence[ComparisonEntry]
) -> ComparisonEntry:
    """Return the law that no fact speaks against and that is the simplest so."""
    for _ in good:
        lost = [
            entry
            for entry in good
            if (one := rivalry_of(comparison, entry, chosen)) is not None
            and one.simpler == entry.law
            and one.preferred == "simpler"
        ]
        if not lost:
            break
        chosen = lost[0]
    return chosen


def rivalry_of(comparison: Comparison, one: ComparisonEntry, other: ComparisonEntry) -> Rivalry | None:
    """Return two counted laws against each other if one contains the other, or is the constant one; else None."""
    if not (one.counted and other.counted and comparison.conclusive):
        return None
    for simpler, fuller in ((one, other), (other, one)):
        contained = {case.name for case in ALL_LAWS[fuller.law].special_cases}
        if simpler.law not in contained and not simpler.law == "constant" != fuller.law:
            continue
        tests = {(test.simpler, test.fuller): test.p_value for test in comparison.tests}
        p_value = tests.get((simpler.law, fuller.law), math.nan)
        ratio = fuller.loco_error / simpler.loco_error if simpler.loco_error > 0.0 else math.nan
        return Rivalry(simpler.law, fuller.law, simpler.aicc - fuller.aicc, p_value, ratio)
    return None


# ---- facts, and the word that each calls for ----


def _of_no_choice(facts: _Facts) -> Iterator[Doubt]:
    comparison, chosen = facts.comparison, facts.entry
    if not comparison.conclusive:
        ranked = [entry.law for entry in comparison.ranking if entry.counted]
        yield "not judged", _no_choice(ranked, counted(comparison.n, "condition"))
    elif not chosen.counted:
        yield "not judged", f"{chosen.law} takes no part in the comparison: {chosen.note}"


def _of_place(facts: _Facts) -> Iterator[Doubt]:
    """Yield that another law is ranked before the one used, and why it is not used."""
    chosen, first = facts.entry, facts.first
    lead = chosen.delta_aicc - (first.delta_aicc if first.counted else 0.0)
    if not (facts.comparison.conclusive and chosen.counted) or chosen is first or not lead > 0.0:
        return
    rivalry = rivalry_of(facts.comparison, chosen, first)
    text = f"{first.law} fits better (AICc lower by {lead:.1f})"
    if facts.forced:
        text = f"{chosen.law} was asked for; {text}"
    elif first.fit is not None and not first.fit.doubts_on(facts.wheel) and rivalry is not None:
        return  # no fact but AICc speaks for it, and that not by much
    else:
        text = f"{text} than {chosen.law}, but its own fit is doubtful ({first.status})"
    yield ("undecided" if lead > RIVAL else "supported"), text


def _of_own_fit(facts: _Facts) -> Iterator[Doubt]:
    yield from facts.fit.doubts_on(facts.wheel) or facts.fit.untested(facts.wheel)


def _of_open_rivalries(facts: _Facts) -> Iterator[Doubt]:
    for rivalry in facts.open:
        yield "undecided", rivalry.text


def _of_wild_trials(facts: _Facts) -> Iterator[Doubt]:
    for name in facts.comparison.wild:
        text = "lies far off all the others: look at its recording, and set it aside if it is bad"
        yield "undecided", f"trial {name} {text}"


def _of_other_answers(facts: _Facts) -> Iterator[Doubt]:
    """Yield that laws which the data do not distinguish answer differently."""
    known = {name for one in facts.open for name in (one.simpler, one.fuller)}
    apart = [
        rival.law
        for rival in facts.rivals
        if facts.comparison[rival.law].counted
        and rival.law not in known
        and not _agree(facts.fit, rival, facts.wheel)
    ]
    if apart:
        where = "on the conditions tested" if facts.wheel is None else "for this wheel"
        text = f"the data do not distinguish {facts.entry.law} from {' and '.join(apart)}, which answer"
        yield "undecided", f"{text}{'s' * (len(apart) == 1)} differently {where}"


_RULES = (_of_no_choice, _of_place, _of_own_fit, _of_open_rivalries, _of_wild_trials, _of_other_answers)


def _why_supported(facts: _Facts) -> str:
    """Return what speaks for the law used."""
    chosen, names = facts.entry, " and ".join(rival.law for rival in facts.rivals)
    weight = "" if math.isnan(chosen.weight) else f" with a weight of {chosen.weight:.2f}"
    place = "has the lowest AICc" if chosen.delta_aicc <= 0.0 else "needs fewest parameters"
    alike = f"; {names} answer{'s' * (len(facts.rivals) == 1)} alike" if facts.rivals else ""
    if facts.rivals and any(one.simpler == "constant" for one in facts.won):
        alike += ": there is an effect, but its form cannot be determined"
    if any(_look_alike(chosen.law, rival.law) for rival in facts.rivals):
        alike += f"; {_OFFSET_OR_WRAP}"
    alike += "".join(f"; {text}" for _, text in facts.fit.untested())
    return f"{chosen.law} {place}{weight}, and its fit follows the data within their scatter{alike}"


def _no_choice(ranked: Iterable[str], conditions: str) -> str:
    """Return in words that too few laws could be ranked."""
    names = " and ".join(ranked)
    ranked_on = f"{f'only {names}' if names else 'no law'} could be ranked on {conditions}"
    return f"no choice of law: {ranked_on}; measure more conditions"


def _agree(fit: FitResult, rival: FitResult, wheel: Conditions | None) -> bool:
    """Return whether two laws give the same lift force for a wheel, or on the conditions tested.

    By root mean squares of ln F_A over them, with the rules of `ropefric.fitting.result`.
    """
    if wheel is None:
        wheel = fit.data.conditions.select(np.unique(fit.data.group, return_index=True)[1])
    try:
        own, other = (predict(one, wheel, method="linear") for one in (fit, rival))
    except RopefricError:
        return False
    values = (other.log_lift - own.log_lift, own.log_half_width, np.nan_to_num(other.log_half_width))
    apart, half, others = (math.sqrt(float(np.mean(x**2))) for x in values)
    laws = ALL_LAWS[fit.law], ALL_LAWS[rival.law]
    nested = laws[0] in laws[1].special_cases or laws[1] in laws[0].special_cases
    if apart <= _SAME:
        return True
    # Of a law on a bound, or not shown by the data, no interval is known, and only its force can be looked at.
    if nested or rival.status is not FitStatus.OK:
        return apart <= math.hypot(half, others)
    return apart <= half and half / _WIDTHS <= others <= half * _WIDTHS
