"""Why does my rope not obey the capstan equation? Each possible cause, with the evidence for and against it."""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

import numpy as np
from scipy.special import fdtrc, stdtr

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.fitting.compare import Comparison, ComparisonEntry, choose_law, compare_laws
from ropefric.fitting.result import Verdict
from ropefric.fitting.statistics import ConditionMeans, condition_means
from ropefric.friction.condition import distinct
from ropefric.friction.laws import ALL_LAWS
from ropefric.trials.table import TrialTable

Supported = Literal["yes", "no", "cannot-tell"]

WORDS = {"yes": "supported", "no": "not supported", "cannot-tell": "cannot be told"}
# Differences of AICc: an effect is supported when it makes the data e^3 = 20 times likelier after its price.
_STRONG = 6.0
_WEAK = 2.0
_SIGNIFICANT = 0.01
_MANY = 0.2

_EFFECTS = {
    "load dependence": (
        "end-tension",
        "end tension",
        "the same wheel and wrap at end tensions a factor 10 or more apart, with repeats",
    ),
    "size effect": (
        "size",
        "size ratio R_w/R_r",
        "the same wrap and end tension on wheels from 3 to 15 rope radii",
    ),
    "wrap effect": (
        "wrap-dependence",
        "wrap",
        "wraps from a quarter turn to two turns at several end tensions: a wrap series at one load cannot fix a law",
    ),
}
_OFFSET_TEST = (
    "pull at a wrap near zero, or over the same wrap on a free wheel: ln(F_A/F_B) there is the offset itself"
)


@dataclass(frozen=True, slots=True)
class Cause:
    """A reason why a rope may not obey the capstan equation."""

    cause: str
    supported: Supported
    evidence: str
    experiment: str
    numbers: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnosis:
    """Why a rope does not obey the capstan equation, or that it does.

    Attributes
    ----------
    causes : tuple of Cause
        All that were looked at.
    summary : str
        The answer in one sentence.
    verdict : Verdict
        On the best law of the comparison behind it.
    """

    causes: tuple[Cause, ...]
    summary: str
    verdict: Verdict

    def __getitem__(self, cause: str) -> Cause:
        return {item.cause: item for item in self.causes}[cause]

    @property
    def text(self) -> str:
        """Return the diagnosis as lines for people."""
        lines = [self.summary, f"the best law is {self.verdict.word}: {self.verdict.reason}"]
        for item in self.causes:
            lines += [f"{item.cause}: {WORDS[item.supported]}", f"  {item.evidence}"]
            lines.append(f"  to decide: {item.experiment}")
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Return a JSON tree."""
        causes = [asdict(item) for item in self.causes]
        return {"summary": self.summary, "verdict": self.verdict.to_dict(), "causes": causes}


def diagnose(table: TrialTable, comparison: Comparison | None = None) -> Diagnosis:
    """Return why the trials of a table do not obey F_A = F_B e^{μφ}, or that they do."""
    ranked = compare_laws(table, ALL_LAWS.values()) if comparison is None else comparison
    constant = ranked["constant"].fit
    if constant is None or constant.problem is None:
        text = "the comparison carries no data"
        raise InputError(text, fix="compare the laws again, or leave the comparison out")
    means = condition_means(constant.problem)
    levels = {
        "end-tension": means.log_lift if table.measures_slack else means.conditions.log_end_tension,
        "size": np.log(means.conditions.size_ratio),
        "wrap-dependence": np.log(np.maximum(means.conditions.wrap_angle_rad, 1e-9)),
    }
    causes = [_offset(ranked, means)]
    causes += [_effect(title, ranked, means, levels[effect]) for title, (effect, *_) in _EFFECTS.items()]
    causes += [_no_slip(table), _scatter(ranked, means)]
    verdict = choose_law(ranked).verdict
    return Diagnosis(causes=tuple(causes), summary=_summary(ranked, causes), verdict=verdict)


def _best(ranked: Comparison, effect: str, *, with_it: bool) -> ComparisonEntry | None:
    found = (e for e in ranked.ranking if e.counted and (effect in ALL_LAWS[e.law].effects) == with_it)
    return next(found, None)


def _judged(
    ranked: Comparison, effect: str, found: Mapping[str, float]
) -> tuple[Supported, str, dict[str, float]]:
    """Return the verdict on an effect with what is known of its trend, why, and the numbers behind it."""
    plain, numbers = ranked["constant"], dict(found)
    best, other = _best(ranked, effect, with_it=True), _best(ranked, effect, with_it=False)
    if best is None or not math.isfinite(plain.aicc):
        return "cannot-tell", f"{ranked.n} {ranked.unit} are too few for any law with it", numbers
    rival = plain if other is None else other
    gain, lead = plain.aicc - best.aicc, rival.aicc - best.aicc
    numbers = {"gain_on_constant": gain, "lead_on_others": lead} | numbers
    text = f"AICc of the best law with it, {best.law}, is {_against(gain)} the constant law's"
    if rival.law != "constant":
        text += f" and {_against(lead)} that of {rival.law}, which does without"
    # A "no" that rests on few conditions alone, where a trend is there to be seen, is none.
    explained_by_another = lead < gain and lead <= -_STRONG
    no_trend = explained_by_another or found.get("p_value", 1.0) >= _SIGNIFICANT
    needless = (gain < _WEAK or lead <= -_STRONG) and no_trend
    return "yes" if lead >= _STRONG else "no" if needless else "cannot-tell", text, numbers


def _against(difference: float) -> str:
    return f"{abs(difference):.1f} {'below' if difference > 0 else 'above'}"


def _effect(title: str, ranked: Comparison, means: ConditionMeans, level: FloatArray) -> Cause:
    effect, quantity, experiment = _EFFECTS[title]
    if distinct(np.exp(level)).size < 2:
        return Cause(title, "cannot-tell", f"all conditions have one {quantity}", experiment)
    trend, found = _trend(means, level, quantity)
    supported, why, numbers = _judged(ranked, effect, found)
    parts = [trend, why] if trend else [why]
    offset, wrap = ranked["constant-offset"], _best(ranked, "wrap-dependence", with_it=True)
    if title == "wrap effect" and wrap is not None and offset.counted:
        # Both explain what the constant cannot, and none does better than the other.
        gain = ranked["constant"].aicc - max(offset.aicc, wrap.aicc)
        if gain >= _WEAK and abs(offset.aicc - wrap.aicc) < _STRONG:
            parts.append(
                "a constant μ with a constant offset in ln F looks exactly like a wrap effect, and here both fit"
            )
    return Cause(title, supported, "; ".join(parts), experiment, numbers)


def _trend(means: ConditionMeans, level: FloatArray, quantity: str) -> tuple[str, dict[str, float]]:
    """Return the slope of the average μ over a doubling, from a weighted straight line."""
    wrap = means.conditions.wrap_angle_rad
    usable = wrap > 0.0
    mu = (means.log_lift - means.conditions.log_end_tension)[usable] / wrap[usable]
    x, weight = level[usable] / math.log(2.0), (wrap[usable] / means.std[usable]) ** 2
    x = x - np.average(x, weights=weight) if mu.size > 2 else 0.0 * x
    spread = float((weight * x**2).sum())
    if spread <= 0.0:
        return "", {}
    slope = float((weight * x * mu).sum()) / spread
    rest = mu - np.average(mu, weights=weight) - slope * x
    std = math.sqrt(float((weight * rest**2).sum()) / (mu.size - 2) / spread)
    p_value = 2.0 * float(stdtr(mu.size - 2, -abs(slope) / std)) if std > 0.0 else 0.0
    text = f"average μ changes by {slope:+.2g} ± {std:.1g} per doubling of the {quantity} (p = {p_value:.2g})"
    return text, {"slope_per_doubling": slope, "slope_std": std, "p_value": p_value}


def _offset(ranked: Comparison, means: ConditionMeans) -> Cause:
    fit = ranked["constant-offset"].fit
    if distinct(means.conditions.wrap_angle_rad).size < 2 or fit is None:
        text = "all conditions have one wrap, where an offset cannot be told from μ"
        return Cause("offset", "cannot-tell", text, _OFFSET_TEST)
    k = fit["k"]
    evidence = f"offset of ln F_A k = {k.value:+.3g} ± {k.std:.2g}"
    found = {"k": k.value, "k_std": k.std}
    for test in ranked.tests:
        if (test.simpler, test.fuller) == ("constant", "constant-offset"):
            evidence += f" (F-test p = {test.p_value:.2g})"
            found["p_value"] = test.p_value
    supported, why, numbers = _judged(ranked, "offset", found)
    return Cause("offset", supported, f"{evidence}; {why}", _OFFSET_TEST, numbers)


def _no_slip(table: TrialTable) -> Cause:
    title = "no gross slip"
    experiment = "raise the motor torque until the rope slides all round, and record the slide after the peak"
    bad, n = Counter(word for word in table.status if word != "ok"), len(table)
    numbers = {"not_ok": float(bad.total()), "trials": float(n)}
    if not bad:
        text = f"all {n} trials have status ok; the recordings, which decide this, are not in the table"
        return Cause(title, "no", text, experiment, numbers)
    words = ", ".join(f"{count} {word}" for word, count in sorted(bad.items()))
    text = f"{bad.total()} of {n} trials ({bad.total() / n:.0%}) gave no break-away force: {words}"
    supported: Supported = "yes" if bad["no-breakaway"] > _MANY * n else "cannot-tell"
    return Cause(title, supported, text, experiment, numbers)


def _scatter(ranked: Comparison, means: ConditionMeans) -> Cause:
    """Return whether conditions lie further off the best law than their repeats allow."""
    title = "condition scatter"
    experiment = "repeat each condition with a new rope in random order, and again with the same rope"
    repeats = int(means.size.sum()) - len(means)
    if repeats < 1 or len(means) < 3:
        return Cause(
            title, "cannot-tell", "no condition was repeated, or there are fewer than three", experiment
        )
    best, left = ranked.best.fit, len(means) - ranked.best.k + 1
    if best is None or left < 2:
        text = f"{len(means)} conditions are too few to tell scatter between them from an effect"
        return Cause(title, "cannot-tell", text, experiment)
    excess = (best.friction_law.log_lift(best.theta, means.conditions) - means.log_lift) / means.std
    F = float((excess**2).sum()) / left
    p_value = float(fdtrc(left, repeats, F))
    text = (
        f"condition means lie {math.sqrt(F):.2g} times as far off {ranked.best.law} as their repeats allow "
        f"(p = {p_value:.2g}), by new ropes, settings, or an effect it misses; repeats scatter by "
        f"{100 * means.scatter_within:.2g} %"
    )
    numbers = {"ratio": math.sqrt(F), "p_value": p_value, "scatter_within": means.scatter_within}
    return Cause(title, "yes" if p_value < _SIGNIFICANT else "no", text, experiment, numbers)


def _summary(ranked: Comparison, causes: list[Cause]) -> str:
    found = [item.cause for item in causes if item.supported == "yes"]
    open_ = [item.cause for item in causes if item.supported == "cannot-tell"]
    plain = ranked["constant"]
    mu = plain.fit["mu"] if plain.fit is not None else None
    law = "the capstan equation" + ("" if mu is None else f" with μ = {mu.value:.3g} ± {mu.std:.2g}")
    if found:
        text = f"{law} does not describe the trials; the data support: {', '.join(found)}"
    elif ranked.best.law == "constant" or plain.delta_aicc <= _WEAK:
        text = f"{law} describes the trials; no cause to leave it is supported"
    else:
        text = f"{law} is not the best description ({ranked.best.law} is), but the data do not show why"
    return text + (f"; cannot be told: {', '.join(open_)}" if open_ else "")
