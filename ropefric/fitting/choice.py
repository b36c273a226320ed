"""Which law of a comparison is used, the verdict on it, and what the laws beside it would answer."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ropefric.errors import FitError, RopefricError
from ropefric.fitting.compare import Comparison, ComparisonEntry
from ropefric.fitting.predict import Candidate, Prediction, predict
from ropefric.fitting.result import FitResult
from ropefric.fitting.verdict import RIVAL, Doubt, FitStatus, Verdict, same_lift, verdict_of
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import ALL_LAWS
from ropefric.glossary import counted

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
    rivals = [
        fits[entry.law]
        for entry in fitted
        if entry is not chosen
        and (
            entry.counted and entry.delta_aicc <= RIVAL and fits[entry.law].status in _ANSWERING
            if comparison.conclusive
            else fits[entry.law].status is FitStatus.OK
        )
    ]
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
        rivals=tuple(rivals),
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
    # Of a law on a bound no interval is known, and only its force can be looked at.
    known = rival.status is FitStatus.OK
    return same_lift(
        other.log_lift - own.log_lift, own.log_half_width, other.log_half_width, nested=nested or not known
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
