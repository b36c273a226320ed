"""Which law the data ask for: all laws on one trial table, ranked by AICc over the conditions, and the one to use.

A law stands on the condition means (`standing`): refit there, judged by likelihood, with each mean left out. That a
fuller law is preferred to a simpler one takes AICc, the error at conditions left out and a bootstrap test together.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from ropefric.errors import FitError, RopefricError, UnknownNameError
from ropefric.files.plain_text import rounded_tree
from ropefric.fitting.fit import fit_law
from ropefric.fitting.predict import Candidate, Prediction, averaged, predict
from ropefric.fitting.problem import law_named
from ropefric.fitting.result import RIVAL, Doubt, FitResult, FitStatus, Verdict, verdict_of
from ropefric.fitting.standing import (
    CHANCE,
    STRONG,
    Contest,
    FTest,
    Standing,
    contact_trend,
    lead_by_chance,
    leave_one_out,
    nested_test,
    standing,
    wild_trial,
)
from ropefric.fitting.statistics import ConditionMeans, akaike_weights, condition_means, scatter_fit
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.friction.laws import ALL_LAWS, LAWS
from ropefric.glossary import counted
from ropefric.registry import did_you_mean
from ropefric.shown import Shown
from ropefric.trials.table import TrialTable

ALWAYS = ("constant", "constant-offset")
"""Laws that stand in every comparison: a constant μ with an offset can look exactly like a wrap effect."""

REFUSED = "refused"
"""Status of a law that has no answer on the data."""

_NO_ANSWER = frozenset({FitStatus.NOT_CONVERGED, FitStatus.TOO_FEW_POINTS})
# Laws whose ln F_A agree to this at every condition are one law on these data.
_SAME = 1e-6
# Twice a log-likelihood this far below the best that the law can do is another solution.
_STRAYED = 10.0
_CLEAR = 1e-5
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
    contests : tuple of Contest
        The best law against the simpler ones it contains, and against a fuller one that an F-test speaks for.
    wild : tuple of str
        Trials that lie so far off all the others that they decide the ranking.
    contact : dict of str to float
        Of a constant μ that is larger beyond the first turn, where coils touch: by how much (`slope`), its `aicc`, and
        by how much that is lower than the best law's (`lead`). Empty where no turn touches or it is not larger.
    """

    _said = ("best.law", "n", "unit", "n_trials", "scatter_within", "notes")
    _framed = "ranking"
    unit = "conditions"

    ranking: tuple[ComparisonEntry, ...]
    tests: tuple[FTest, ...]
    n: int
    n_trials: int
    scatter_within: float
    notes: tuple[str, ...]
    contests: tuple[Contest, ...] = ()
    wild: tuple[str, ...] = ()
    contact: Mapping[str, float] = field(default_factory=dict)

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
        names = ("unit", "n", "n_trials", "scatter_within", "conclusive", "notes", "wild", "contact")
        tree = {name: getattr(self, name) for name in names} | {
            "ranking": [entry.to_dict() for entry in self.ranking],
            "f_tests": [test._asdict() for test in self.tests],
            "contests": [item._asdict() | {"preferred": item.preferred} for item in self.contests],
        }
        return dict(rounded_tree(tree, _DIGITS))


def compare_laws(
    table: TrialTable,
    laws: Iterable[str | FrictionLaw] | None = None,
    *,
    touching_turns: float | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> Comparison:
    """Return how friction laws stand against each other on a trial table; all turns beyond the first may touch."""
    if isinstance(laws, str | FrictionLaw):
        laws = [laws]
    laws = LAWS.values() if laws is None else laws
    given = map(law_named, laws)
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
    means = condition_means(data)
    wild = wild_trial(data, slack=slack)
    standings = {name: standing(fit.data, means, fit.theta, slack=slack) for name, fit in fits.items()}
    for name, stands in standings.items():
        notes[name] = notes[name] or _no_judge(fits[name], stands, means, slack=slack)
        notes[name] = notes[name] or _twin(name, standings, notes)
    ranking = _ranking(fits, standings, notes, len(means))
    tests = tuple(
        found
        for stands in standings.values()
        for case in stands.problem.law.special_cases
        if case.name in standings and (found := nested_test(standings[case.name], stands)) is not None
    )
    best = min((entry.aicc for entry in ranking if entry.counted), default=math.inf)
    contact = contact_trend(means, touching_turns, best)
    return Comparison(
        ranking=ranking,
        tests=tests,
        contests=_contests(ranking, tests, standings, means),
        n=len(means),
        n_trials=data.n_points,
        scatter_within=means.scatter_within,
        notes=(*_notes(ranking, tests, means, slack=slack), *_contact_notes(ranking[0], contact)),
        contact=contact,
        wild=() if wild is None else (np.array(table.trial)[table.used][wild].item(),),
    )


def _contests(
    ranking: Sequence[ComparisonEntry],
    tests: Sequence[FTest],
    standings: Mapping[str, Standing],
    means: ConditionMeans,
) -> tuple[Contest, ...]:
    """Return the best law against others, and a simpler law that chance leaves beside it against simpler ones still."""
    entries = {entry.law: entry for entry in ranking if entry.counted and not math.isnan(entry.weight)}
    trusted = [name for name, entry in entries.items() if entry.fit is not None and not entry.fit.doubts]
    p_values = {(test.simpler, test.fuller): test.p_value for test in tests}
    contained = {law: [case.name for case in ALL_LAWS[law].special_cases] for law in entries}
    held: dict[tuple[str, str], Contest] = {}
    waiting = (trusted or list(entries))[:1]
    for name in waiting:
        simpler = [law for law in contained[name] if law in entries]
        # Every law is tried against the constant one, whether it contains it or not.
        simpler = simpler or [law for law in entries if law == "constant" != name]
        against = {high: p for (low, high), p in p_values.items() if low == name and high in entries}
        likely = min(against, key=against.__getitem__, default=name)
        pairs = [(law, name) for law in simpler]
        pairs += [(name, likely)] if against.get(likely, 1.0) <= CHANCE else []
        for low, high in pairs:
            if (low, high) in held:
                continue
            p_value = p_values.get((low, high), math.nan)
            # Some are so clear that no simulated campaign would lead as far.
            if not p_value < _CLEAR:
                fuller = [law for law in entries if law != low and low in {"constant", *contained[law]}]
                family = [standings[law] for law in fuller]
                p_value = lead_by_chance(standings[low], standings[high], family, means)
            below, above = entries[low].loco_error, entries[high].loco_error
            lead = standings[low].aicc - standings[high].aicc
            contest = Contest(low, high, lead, p_value, above / below if below > 0.0 else math.nan)
            held[low, high] = contest
            if contest.preferred == "simpler" and low not in waiting:
                waiting.append(low)
    return tuple(held.values())


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
    weights = akaike_weights(criteria).tolist() if told else [math.nan] * len(ranked)
    weight_of, best = dict(zip(ranked, weights, strict=True)), min(criteria, default=math.nan)
    entries = []
    for name, note in notes.items():
        known: dict[str, Any] = {}
        if name in fits:
            stands, fit = standings[name], fits[name]
            known = {key: getattr(stands, key) for key in ("k", "chi2", "aicc", "bic")}
            # Two laws that follow the data exactly both stand at −inf, no distance apart.
            known["delta_aicc"] = 0.0 if stands.aicc == best else stands.aicc - best
            known |= {
                "loco_error": math.nan if note else leave_one_out(stands),
                "status": fit.status.value,
                "fit": fit,
            }
        weight = weight_of.get(name, 0.0)
        entries.append(ComparisonEntry(law=name, n=n, note=note, counted=not note, weight=weight, **known))
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
    ranking: Sequence[ComparisonEntry], tests: Sequence[FTest], means: ConditionMeans, *, slack: bool
) -> tuple[str, ...]:
    """Return what to know before reading a ranking; first what an observation is."""
    in_all = counted(len(means), "condition")
    notes = [f"AICc counts {in_all}, not repeats"]
    if not means.repeated:
        notes.append("no condition was repeated, so every trial is a condition of its own")
    if slack:
        notes.append("the load was set and the end tension measured, so the residuals are those of ln F_B")
    ranked = {entry.law: entry for entry in ranking if entry.counted}
    if not ranked or math.isnan(ranking[0].weight):
        text = "so weights would say nothing and no law is chosen: measure more conditions"
        notes.append(f"{_ranked_on(ranked, in_all)}, {text}")
        against = [test for test in tests if test.simpler in ranked and test.fuller not in ranked]
        worst = min(against, key=lambda test: test.p_value, default=None)
        if worst is not None and worst.p_value < CHANCE:
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


def _contact_notes(best: ComparisonEntry, contact: Mapping[str, float]) -> list[str]:
    """Return that contact between coils may be what a law stands for."""
    lead = contact.get("lead", -math.inf)
    if lead > RIVAL:
        text = f"{_contact_words(lead, best.law)}: such a law may only stand for it"
        return [f"{text}; `ropefric diagnose` weighs the causes against each other"]
    if lead >= -RIVAL and best.law != "constant":
        text = (
            f"contact between coils, beyond the first turn, describes the trials about as well as {best.law}"
        )
        return [f"{text}: hold the coils apart to tell"]
    return []


def _contact_words(lead: float, law: str) -> str:
    text = "a constant μ that is larger beyond the first turn, as by contact between coils, describes the trials better"
    return f"{text} (its AICc is {lead:.1f} below that of {law})"


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
    undecided: Mapping[str, float]

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
        """Return a prediction of one condition with this verdict, averaged over the laws that are undecided.

        Beside it stands what each rival answers, the same answer once.
        """
        answers: list[Prediction] = []
        settings: dict[str, Any] = {"level": prediction.level, "method": prediction.method, "check": False}
        for fit in (self.fit, *self.rivals):
            try:
                new = predict(fit, prediction.conditions, **settings)
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
        judged = replace(prediction, judged=self.verdict, candidates=candidates)
        open_ = [answer for answer in answers if answer.law in self.undecided]
        return judged if len(open_) < 2 else averaged(judged, open_, [self.undecided[x.law] for x in open_])


def choose_law(comparison: Comparison, law: str = "", wheel: Conditions | None = None) -> Choice:
    """Return the law of a comparison that is to be used, or the law that is asked for.

    That is the best one whose fit may be used as it stands, or a simpler one that chance alone leaves behind it.
    """
    fitted = [(entry, entry.fit) for entry in comparison.ranking if entry.fit is not None]
    good = [(entry, fit) for entry, fit in fitted if entry.counted and not fit.doubts]
    contests = comparison.contests if comparison.conclusive else ()
    chosen, fit = (good or fitted)[0]
    if law:
        chosen = comparison[law]
        if chosen.fit is None:
            raise FitError(f"{law} has no answer on these data: {chosen.note}", fix="use another law")
        fit = chosen.fit
    while not law:
        lost = {c.simpler for c in contests if c.fuller == chosen.law and c.preferred == "simpler"}
        simpler = [(entry, other) for entry, other in good if entry.law in lost]
        if not simpler:
            break
        chosen, fit = simpler[0]
    # What the three criteria say of the law used: laws that it beats, and laws of which they do not agree.
    beaten = {c.simpler for c in contests if c.fuller == chosen.law and c.preferred == "fuller"}
    open_ = {
        c.fuller if c.simpler == chosen.law else c.simpler: c
        for c in contests
        if chosen.law in {c.simpler, c.fuller} and c.preferred == "undecided"
    }
    # The laws that the data do not tell from the one used: all that fit, where none could be weighed.
    others = [(entry, other) for entry, other in fitted if entry is not chosen]

    def is_rival(entry: ComparisonEntry, other: FitResult) -> bool:
        if not comparison.conclusive:
            return other.status is FitStatus.OK
        near = entry.counted and entry.delta_aicc <= RIVAL and entry.law not in beaten
        return other.status in _ANSWERING and (entry.law in open_ or near)

    rivals = tuple(other for entry, other in others if is_rival(entry, other))
    doubts = [*_of_place(comparison, chosen, fitted[0][0], forced=bool(law))]
    doubts += fit.doubts or fit.untested(wheel)
    doubts += [("undecided", contest.text) for contest in open_.values()]
    text = "lies far off what all the others agree on: look at it, and set it aside if it is bad"
    doubts += [("undecided", f"trial {name} {text}") for name in comparison.wild]
    if (lead := comparison.contact.get("lead", 0.0)) >= STRONG:
        doubts.append(("undecided", _contact_words(lead, comparison.best.law)))
    apart = [r.law for r in rivals if comparison[r.law].counted and not _agree(fit, r, wheel)]
    if other := [name for name in apart if name not in open_]:
        where = "on the conditions tested" if wheel is None else "for the wheel asked for"
        near_it = f"are within {RIVAL:g} in AICc and " if chosen.delta_aicc <= RIVAL else ""
        text = f"{near_it}answer differently {where}"
        doubts.append(("undecided", f"{chosen.law} and {' and '.join(other)} {text}"))
    undecided = [chosen.law, *dict.fromkeys([*apart, *open_])] if comparison.conclusive else []
    weight = "" if math.isnan(chosen.weight) else f" with a weight of {chosen.weight:.2f}"
    names = " and ".join(rival.law for rival in rivals)
    alike = f"; {names} answer{'s' * (len(rivals) == 1)} alike" if rivals else ""
    place = "has the lowest AICc" if chosen.delta_aicc <= 0.0 else f"is within {RIVAL:g} of the lowest AICc"
    plainer = any(comparison[rival.law].k < chosen.k for rival in rivals)
    alike += ": an effect is there, its form is not known" if rivals and not plainer else ""
    alike += "".join(f"; {text}" for _, text in fit.untested())
    text = f"{chosen.law} {place}{weight}, and its fit follows the data within their scatter{alike}"
    return Choice(
        fit=fit,
        entry=chosen,
        forced=bool(law),
        verdict=verdict_of(doubts, text),
        doubts=tuple(dict.fromkeys(text for _, text in doubts)),
        rivals=rivals,
        # Where criteria disagree none of them may outvote the others by more than laws that are not told apart.
        undecided={x: math.exp(-0.5 * min(max(comparison[x].delta_aicc, 0.0), RIVAL)) for x in undecided},
    )


def _of_place(
    comparison: Comparison, chosen: ComparisonEntry, first: ComparisonEntry, *, forced: bool
) -> list[Doubt]:
    """Return what the place of a law in the comparison says against it."""
    if not comparison.conclusive:
        ranked = [entry.law for entry in comparison.ranking if entry.counted]
        where = f"{_ranked_on(ranked, counted(comparison.n, 'condition'))}; measure more conditions"
        return [("not judged", f"no choice of law: {where}")]
    if not chosen.counted:
        return [("not judged", f"{chosen.law} takes no part in the comparison: {chosen.note}")]
    lead = chosen.delta_aicc - (first.delta_aicc if first.counted else 0.0)
    if chosen is first or lead <= 0.0:
        return []
    text = f"{first.law} stands {lead:.1f} in AICc before"
    if forced:
        text = f"{chosen.law} was asked for; {text} it"
    elif any(c.simpler == chosen.law and c.preferred == "simpler" for c in comparison.contests):
        return []
    else:
        text = f"{text} {chosen.law}, but is not to be used as it stands: {first.status}"
    return [("undecided" if lead > RIVAL else "supported", text)]


def _ranked_on(ranked: Iterable[str], what: str) -> str:
    """Return in words which laws could be ranked."""
    names = " and ".join(ranked)
    return f"{f'only {names}' if names else 'no law'} could be ranked on {what}"


def _agree(fit: FitResult, rival: FitResult, wheel: Conditions | None) -> bool:
    """Return whether two laws give the same lift force for a wheel, or on the conditions tested.

    By root mean squares of ln F_A over them; the rules stand in `ropefric.fitting.result`.
    """
    if wheel is None:
        wheel = fit.data.conditions.select(np.unique(fit.data.group, return_index=True)[1])
    try:
        own, other = (predict(one, wheel, check=False) for one in (fit, rival))
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
