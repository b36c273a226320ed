"""Why does my rope not obey the capstan equation? Each possible cause, with the evidence for and against it.

Effects of the settings are judged by the laws of a comparison and, since a law knows one shape and one sign of an
effect, by straight trends of μ as well; both have an AICc on the same condition means. Groups of trials (rope, wheel,
operator, order, dwell) are judged by what they explain beside all settings.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.special import stdtr, stdtrit

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.files.plain_text import significant
from ropefric.fitting import statistics as stats
from ropefric.fitting.compare import Comparison, choose_law, compare_laws
from ropefric.fitting.predict import has_interval
from ropefric.fitting.problem import FitProblem, typical_mu
from ropefric.fitting.result import FitResult, Verdict
from ropefric.fitting.standing import STRONG, straight_fit
from ropefric.friction.condition import distinct
from ropefric.friction.laws import ALL_LAWS
from ropefric.glossary import counted
from ropefric.shown import Shown
from ropefric.trials.table import TrialTable

Supported = Literal["yes", "no", "cannot-tell"]

WORDS = {"yes": "supported", "no": "not supported", "cannot-tell": "undetermined"}
# A difference of AICc.
_WEAK = 2.0
_SAME_AICC = 1e-6
_SIGNIFICANT, _DOUBTED = 0.01, 0.05
_LEVEL = 0.95
# Of a column, what others leave of it; below, it says nothing that they do not.
_ALIASED = 1e-6


class _Effect(NamedTuple):
    effect: str
    quantity: str
    experiment: str
    alias: str = ""


_EFFECTS = {
    "offset": _Effect(
        "offset", "", "pull at a wrap near zero, or over the same wrap on a free wheel: "
        "ln(F_A/F_B) there is the offset itself", "at one wrap an offset looks like a larger μ"
    ),
    "load dependence": _Effect(
        "end-tension", "end tension", "the same wheel and wrap at end tensions a factor 10 or more apart, with repeats"
    ),
    "size effect": _Effect(
        "size", "size ratio R_w/R_r", "the same wrap and end tension on wheels from 3 to 15 rope radii"
    ),
    "wrap effect": _Effect(
        "wrap-dependence", "wrap",
        "wraps from a quarter turn to two turns at several end tensions: a wrap series at one load cannot fix a law",
    ),
}  # fmt: skip
_GROUPS = {
    "rope": ("rope_id", "repeat conditions with several ropes each"),
    "wheel": ("wheel", "two wheels of one size, at the same conditions"),
    "mounting": ("mounting", "mount the rope anew within each condition"),
    "day": ("day", "measure some conditions on several days"),
    "operator": ("operator", "let each operator pull at all conditions"),
    "dwell": ("dwell", "vary the dwell by a factor 10 or more within each condition"),
    "order of trials": ("order", "measure in random order, and come back to the first condition at the end"),
}
_NUMERIC = {"dwell", "order"}


class Cause(NamedTuple):
    """A reason why a rope may not obey the capstan equation."""

    cause: str
    supported: Supported
    evidence: str
    experiment: str
    numbers: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnosis(Shown):
    """Why a rope does not obey the capstan equation, or that it does.

    Attributes
    ----------
    causes : tuple of Cause
        All that were looked at. Of an effect that is not supported the evidence ends with the largest one the data
        leave room for, `bound_low` and `bound_high` of its numbers: one-sided limits at 95 % each.
    summary : str
        The answer in one sentence.
    verdict : Verdict
        On the best law of the comparison behind it.
    """

    _said = ("summary", "verdict=verdict.word")
    _framed = "causes"

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
        causes = [item._asdict() | {"numbers": dict(item.numbers)} for item in self.causes]
        return {"summary": self.summary, "verdict": self.verdict.to_dict(), "causes": causes}


def diagnose(table: TrialTable, comparison: Comparison | None = None) -> Diagnosis:
    """Return why the trials of a table do not obey F_A = F_B e^{μφ}, or that they do."""
    ranked = compare_laws(table, ALL_LAWS.values()) if comparison is None else comparison
    if (fit := ranked["constant"].fit) is None or fit.problem is None:
        text = "the comparison carries no data"
        raise InputError(text, fix="compare the laws again, or leave the comparison out")
    verdict, wild = choose_law(ranked).verdict, ranked.wild
    if wild:
        # One trial must not hide what all the others show.
        table = replace(table, kept=table.kept & ~np.isin(np.array(table.trial), wild))
        ranked = compare_laws(table, [entry.law for entry in ranked.ranking])
        fit = ranked["constant"].fit or fit
    problem = fit.data
    means = stats.condition_means(problem)
    trends = _Trends(means, ranked, slack=table.measures_slack)
    causes = [_judged(title, ranked, trends) for title in _EFFECTS]
    pairs = _not_separated(causes, ranked, trends)
    causes = [_with_pairs(cause, pairs) for cause in causes]
    causes += [_grouped(title, table, problem, trends) for title in _GROUPS]
    causes.append(_wild(wild))
    return Diagnosis(causes=tuple(causes), summary=_summary(ranked, causes, pairs), verdict=verdict)


# ---- effects of the settings ----


class _Line(NamedTuple):
    """A straight line in ln F_A beside other columns: its slope by one column, and how well that is known."""

    slope: float
    std: float
    dof: int
    mu: float

    @property
    def p_value(self) -> float:
        if self.std > 0.0:
            return 2.0 * float(stdtr(self.dof, -abs(self.slope) / self.std))
        return 1.0 if self.slope == 0.0 else 0.0

    def ends(self) -> tuple[float, float]:
        """Return the one-sided limits of the slope at 95 % each."""
        reach = float(stdtrit(self.dof, _LEVEL)) * self.std
        return self.slope - reach, self.slope + reach


class _Trends:
    """Trends of μ with the settings on condition means: ln(F_A/F_B) = φ (μ + Σ slope · ln level) + offset."""

    def __init__(self, means: stats.ConditionMeans, ranked: Comparison, *, slack: bool) -> None:
        at, self.means = means.conditions, means
        wrap = at.wrap_angle_rad
        self.rise = means.log_lift - at.log_end_tension
        load = ("lift force", np.exp(means.log_lift)) if slack else ("end tension", at.end_tension_N)
        # Of each setting its name before the levels and unit after them, a factor to that unit, and the levels.
        self.settings = {
            "load dependence": (load[0], "N", 1.0, load[1]),
            "size effect": ("R_w/R_r =", "", 1.0, at.size_ratio),
            "wrap effect": ("", "deg", math.degrees(1.0), np.maximum(wrap, 1e-9)),
        }
        every = {"offset": np.ones_like(wrap)}
        every |= {title: wrap * np.log(x / x.min()) for title, (*_, x) in self.settings.items()}
        self.columns = {title: column for title, column in every.items() if _adds(wrap[:, None], column)}
        self.aicc = {
            chosen: self._aicc(chosen)
            for size in range(len(self.columns) + 1)
            for chosen in combinations(self.columns, size)
        }
        # The trends that AICc chooses.
        self.best = min(self.aicc, key=lambda chosen: (self.aicc[chosen], chosen))
        first = ranked.best
        leads = first.counted and first.aicc < self.aicc[self.best] - _SAME_AICC
        self.law = first.fit if leads and not slack else None

    def matrix(self, chosen: Iterable[str]) -> FloatArray:
        """Return the columns of μ and of some trends, shape (K, 1 + number of trends)."""
        return np.stack([self.means.conditions.wrap_angle_rad, *(self.columns[t] for t in chosen)], axis=-1)

    def _aicc(self, chosen: tuple[str, ...]) -> float:
        X, K = self.matrix(chosen), len(self.means)
        if X.shape[1] + 2 >= K or any(not _adds(np.delete(X, i, 1), X[:, i]) for i in range(1, X.shape[1])):
            return math.inf
        _, scatter = straight_fit(X, self.rise, self.means)
        return stats.aicc(scatter.deviance, K, X.shape[1] + 1)

    def least(self, having: str = "", without: Sequence[str] = ()) -> float:
        """Return the lowest AICc of trends that have one, and have not others."""
        found = (
            x for some, x in self.aicc.items() if (not having or having in some) and not {*without} & {*some}
        )
        return min(found, default=math.inf)

    def replaces(self, title: str, other: float) -> bool:
        """Return whether a description without one of the best trends, but with this one, would do as well."""
        spared = (self.least(title, without=[one]) for one in self.best)
        return title not in self.best and any(aicc < other + STRONG for aicc in spared)

    def line(self, title: str) -> _Line | None:
        """Return the slope of a trend beside the best description; None where nothing is left to judge it by."""
        fit, at, rise = self.law, self.means.conditions, self.rise
        if fit is not None and _EFFECTS[title].effect not in ALL_LAWS[fit.law].effects:
            # Beside the law itself, in its tangent.
            log_lift, slopes = fit.friction_law.log_lift_and_jacobian(fit.theta, at)
            others, rise = slopes[:, fit.shown], self.means.log_lift - log_lift
            mu = typical_mu(at, log_lift)
        else:
            others, mu = self.matrix(other for other in self.best if other != title), math.nan
        X = np.column_stack([others, self.columns[title]])
        dof = len(self.means) - X.shape[1]
        if dof < 1 or not _adds(others, X[:, -1]):
            return None
        theta, scatter = straight_fit(X, rise, self.means)
        known = self.means.std.max() if self.means.repeated else 0.0
        if max(known, float(np.abs(X @ theta - rise).max())) < stats.SMALLEST_SCATTER:
            return None  # they agree to rounding, which is no scatter to judge by
        root = np.sqrt(scatter.variance)
        left = float((((X @ theta - rise) / root) ** 2).sum()) / dof
        inverse = np.linalg.pinv((X / root[:, None]).T @ (X / root[:, None]), hermitian=True)
        # With repeats a mean is known no better than they say.
        scale = max(left, 1.0) if self.means.repeated else left
        std = math.sqrt(scale * inverse[-1, -1])
        return _Line(float(theta[-1]), std, dof, float(theta[0]) if math.isnan(mu) else mu)


def _adds(columns: FloatArray, column: FloatArray) -> bool:
    """Return whether a column holds something that others do not."""
    size = float(np.linalg.norm(column))
    return size > 0.0 and float(np.linalg.norm(_beside(columns, column))) > _ALIASED * size


def _beside(columns: FloatArray, values: FloatArray) -> FloatArray:
    """Return what columns leave over of values."""
    return np.asarray(values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0])


def _best_law(ranked: Comparison, chosen: Callable[[str], bool]) -> tuple[str, float]:
    """Return the best of some laws and its AICc; infinite if none of them is counted."""
    laws = {entry.law: entry.aicc for entry in ranked.ranking if entry.counted and chosen(entry.law)}
    first = min(laws, key=laws.__getitem__, default="")
    return first, laws.get(first, math.inf)


def _judged(title: str, ranked: Comparison, trends: _Trends) -> Cause:
    """Return the verdict on an effect of the settings."""
    _, quantity, experiment, alias = _EFFECTS[title]
    if title not in trends.columns:
        return Cause(title, "cannot-tell", alias or f"all conditions have one {quantity}", experiment)
    line = trends.line(title)
    numbers, parts = _of_line(title, line, ranked)
    supported, gains, words = _by_aicc(title, ranked, trends, line)
    numbers, parts = numbers | gains, parts + words
    if supported != "yes" and line is not None:  # what the data leave room for
        limits, room = _limits(title, line, trends)
        numbers, parts = numbers | limits, [*parts, room]
    return Cause(title, supported, "; ".join(parts), experiment, numbers)


def _by_aicc(
    title: str, ranked: Comparison, trends: _Trends, line: _Line | None
) -> tuple[Supported, dict[str, float], list[str]]:
    """Return the verdict on an effect by the first rule that applies, and its gains in AICc, also in words.

    The best descriptions with it and without it are laws or straight trends.
    """
    effect, plain = _EFFECTS[title].effect, ranked["constant"].aicc
    having, by_having = _best_law(ranked, lambda law: effect in ALL_LAWS[law].effects)
    lacking, by_lacking = _best_law(ranked, lambda law: effect not in ALL_LAWS[law].effects)
    best = min(trends.least(title), by_having)
    other = min(trends.least(without=[title]), by_lacking)
    if not (math.isfinite(plain) and math.isfinite(best)):
        return "cannot-tell", {}, [f"{ranked.n} conditions are too few for any law with it"]
    gain, lead = plain - best, other - best
    name = having if by_having == best else "straight trends of μ"
    text = f"AICc of the best description with it, {name}, is {_against(gain)} the constant law's"
    if abs(gain - lead) > 1e-9:
        text += f" and {_against(lead)} that of the best without it ({lacking or 'constant'} among the laws)"
    words, is_clear = [text], line is not None and line.p_value < _SIGNIFICANT
    if title == "wrap effect" and _looks_like_offset(ranked, by_having):
        words.append(
            "a constant μ with a constant offset in ln F looks exactly like a wrap effect, and here both fit"
        )
        is_clear = True
    rules: tuple[tuple[bool, Supported], ...] = (
        (lead >= STRONG, "yes"),
        (is_clear, "cannot-tell"),
        (gain < _WEAK or (lead < 0.0 and not trends.replaces(title, other)), "no"),
        (True, "cannot-tell"),
    )
    verdict = next(verdict for applies, verdict in rules if applies)
    return verdict, {"gain_on_constant": gain, "lead_on_others": lead}, words


def _looks_like_offset(ranked: Comparison, by_wrap: float) -> bool:
    """Return whether an offset and a wrap law explain what the constant law cannot, as well as each other."""
    offset = ranked["constant-offset"]
    explained = offset.counted and ranked["constant"].aicc - max(offset.aicc, by_wrap) >= _WEAK
    return explained and abs(offset.aicc - by_wrap) < STRONG


def _not_separated(
    causes: Sequence[Cause], ranked: Comparison, trends: _Trends
) -> tuple[tuple[Cause, Cause], ...]:
    """Return pairs of effects of which one must be there, where the design does not separate them."""
    open_ = [cause for cause in causes if cause.supported == "cannot-tell" and cause.cause in trends.columns]

    def without(*titles: str) -> float:
        gone = {_EFFECTS[title].effect for title in titles}
        return min(
            trends.least(without=titles), _best_law(ranked, lambda law: not gone & ALL_LAWS[law].effects)[1]
        )

    best = without()
    return tuple(
        (one, other)
        for one, other in combinations(open_, 2)
        if math.isfinite(best)
        and without(one.cause, other.cause) - best >= STRONG
        and max(without(one.cause), without(other.cause)) - best < STRONG
    )


def _with_pairs(cause: Cause, pairs: Sequence[tuple[Cause, Cause]]) -> Cause:
    """Return a cause with the effects that look like it, and the pull that separates them."""
    own = [pair for pair in pairs if cause.cause in {one.cause for one in pair}]
    others = [one for pair in own for one in pair if one.cause != cause.cause]
    text = "".join(f"; {cause.cause} or {x.cause} is present; to decide: {x.experiment}" for x in others)
    return cause._replace(evidence=cause.evidence + text)


def _against(difference: float) -> str:
    return f"{abs(difference):.1f} {'below' if difference > 0 else 'above'}"


def _of_line(title: str, line: _Line | None, ranked: Comparison) -> tuple[dict[str, float], list[str]]:
    """Return what the trend of an effect is, as numbers and in words."""
    if title == "offset" and (fit := ranked["constant-offset"].fit) is not None:
        k = fit["k"]
        numbers = {"k": k.value, "k_std": k.std}
        text = f"offset of ln F_A k = {_with_error(fit, 'k', '+.3g')}"
        for test in ranked.tests:
            if (test.simpler, test.fuller) == ("constant", "constant-offset"):
                text += f" (F-test p = {test.p_value:.2g})"
                numbers["p_value"] = test.p_value
        return numbers, [text]
    if line is None:
        return {}, []
    slope, std = line.slope * math.log(2.0), line.std * math.log(2.0)
    numbers = {"slope_per_doubling": slope, "slope_std": std, "p_value": line.p_value}
    words = f"average μ changes by {slope:+.2g} ± {std:.1g} per doubling of the {_EFFECTS[title].quantity}"
    return numbers, [f"{words} (p = {line.p_value:.2g})"]


def _limits(title: str, line: _Line, trends: _Trends) -> tuple[dict[str, float], str]:
    """Return the largest effect that data leave room for, by one-sided 95 % limits, as numbers and in words.

    Of F_A by an offset, of μ from the lowest level to the highest.
    """
    (low, high), levels = line.ends(), np.ones(1)
    if title in trends.settings:
        name, unit, factor, every = trends.settings[title]
        levels = distinct(every)[[0, -1]]
        low, high = (end * (math.log(float(levels[-1] / levels[0])) / line.mu) for end in (low, high))
    low, high = sorted((low, high))
    numbers, fit = {"bound_low": low, "bound_high": high}, trends.law
    beside = f" beside {fit.law}" if fit is not None and fit.law != "constant" else ""
    what = f"an offset that changes F_A by {_percent(low)} to {_percent(high)}"
    if title != "offset":
        ends = " to ".join(f"{significant(float(end) * factor, 4):g}" for end in levels)
        span = " ".join(filter(None, (name, ends, unit)))
        what = f"a change of μ by {_percent(low)} to {_percent(high)} from {span}"
    return numbers, f"{what}{beside} would not have been detected (95 % each)"


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"


# ---- groups of trials ----


def _numbers_of(name: str, words: Sequence[str]) -> FloatArray | None:
    """Return a column of numbers over its span, for a dwell of their logarithms; None for anything else."""
    try:
        number = np.array([float(word.replace(",", ".")) for word in words])
    except ValueError:
        return None
    if name == "dwell":
        number = np.log(np.where(number > 0.0, number, np.nan))
    return number / np.ptp(number) if np.isfinite(number).all() and np.ptp(number) > 0.0 else None


def _columns_of(name: str, words: Sequence[str]) -> tuple[FloatArray, str]:
    """Return how trials differ by a column of the table, shape (n, q); or why that column shows no difference."""
    levels, none = sorted(set(words)), np.zeros((len(words), 0))
    if not any(words):
        return none, f"the table has no column {name}"
    if len(levels) < 2:
        return none, f"all trials have one {name}"
    if name not in _NUMERIC:
        return (np.array(words)[:, None] == np.array(levels[1:])).astype(np.float64), ""
    if (number := _numbers_of(name, words)) is None:
        return none, f"the column {name} has a value that is no number"
    return number[:, None], ""


def _grouped(title: str, table: TrialTable, problem: FitProblem, trends: _Trends) -> Cause:
    """Return whether μ differs between groups of trials, within conditions or between them."""
    name, experiment = _GROUPS[title]
    words = np.array(table.labels.get(name) or ("",) * len(table))[table.used].tolist()
    (x, why), is_number = _columns_of(name, words), name in _NUMERIC
    x = x * problem.conditions.wrap_angle_rad[:, None]
    tests = {} if why else _group_tests(x, problem, trends, signed=is_number)
    n_levels = len(set(words))
    if not tests:
        why = why or (
            f"its {counted(n_levels, 'value')} go with the settings or with single trials, or too few trials are left "
            "to judge by"
        )
        return Cause(title, "cannot-tell", why, experiment)
    clear = min(test[0] for test in tests.values()) * len(tests) < _SIGNIFICANT
    # The test that finds the difference, or else the one with the narrowest limits.
    where, (p_value, *ends) = min(tests.items(), key=lambda x: x[1][0] if clear else x[1][2] - x[1][1])
    p_value = min(1.0, p_value * len(tests))
    low, high = sorted(end / typical_mu(problem.conditions, problem.log_lift) for end in ends)
    what = "from its lowest value to its highest" if is_number else f"between {n_levels} groups"
    change = f"{_percent(low)} to {_percent(high)} {what}"
    if n_levels > 2 and low < 0.0 and not is_number:
        change = f"up to {_percent(high)} {what}"
    supported: Supported = "no" if p_value >= _DOUBTED and low <= 0.0 <= high else "cannot-tell"
    seen = f"a change of μ by {change} would not have been detected"
    if p_value < _SIGNIFICANT:
        supported, seen = "yes", f"μ changes by {change}"
    text = f"{where} conditions {seen} (95 % each; p = {p_value:.2g})"
    numbers = {"p_value": p_value, "bound_low": low, "bound_high": high}
    return Cause(title, supported, text, experiment, numbers)


def _group_tests(
    x: FloatArray, problem: FitProblem, trends: _Trends, *, signed: bool
) -> dict[str, tuple[float, ...]]:
    """Return what columns of trials, which change ln F_A, explain within conditions and between them."""
    rise, group = problem.log_lift - problem.conditions.log_end_tension, problem.group
    mean = np.stack([stats.group_means(column, group) for column in x.T], axis=-1)
    about = rise - stats.group_means(rise, group)[group]
    weight = (trends.means.std.mean() / trends.means.std)[:, None]
    full = trends.matrix(trends.columns) * weight
    own, none = _beyond_rounding(x - mean[group], x), np.zeros((rise.size, 0))
    # Each level against each other; the first has no column.
    levels = np.vstack([np.zeros(x.shape[1]), np.eye(x.shape[1])])
    pairs = np.array([one - other for other, one in combinations(levels, 2)])
    tests = {
        "within": _explained(none, own, about, rise.size - len(mean), pairs, signed=signed),
        "between": _explained(
            full, mean * weight, trends.rise * weight[:, 0], len(mean), pairs, signed=signed
        ),
    }
    return {where: test for where, test in tests.items() if test is not None}


def _beyond_rounding(columns: FloatArray, whole: FloatArray) -> FloatArray:
    """Return columns, zero where they are what rounding leaves of the whole."""
    is_rounding = np.linalg.norm(columns, axis=0) <= 1e-9 * np.linalg.norm(whole, axis=0)
    return np.where(is_rounding, 0.0, columns)


def _explained(
    base: FloatArray, extra: FloatArray, rise: FloatArray, n: int, contrasts: FloatArray, *, signed: bool
) -> tuple[float, ...] | None:
    """Return the p-value of columns beside others, and the limits of the largest of some contrasts (m, q) of theirs.

    `n` counts the independent observations. None where the columns hold nothing of their own, or leave nothing over.
    Without a sign, which would hang on the names of the levels, unless they are numbers.
    """
    left, rest = _beside(base, extra), _beside(base, rise)
    own = np.linalg.norm(left, axis=0) > 1e-3 * np.maximum(np.linalg.norm(extra, axis=0), 1e-300)
    q, dof = left.shape[1], n - base.shape[1] - left.shape[1]
    if not own.all() or np.linalg.matrix_rank(left, tol=1e-6 * np.linalg.norm(left)) < q or dof < 2:
        return None
    slope = np.linalg.lstsq(left, rest, rcond=None)[0]
    chi2 = float(((rest - left @ slope) ** 2).sum())
    p_value = stats.f_test(float(rest @ rest), chi2, n=n - base.shape[1], p_simpler=0, p_fuller=q)[2]
    covariance = np.linalg.inv(left.T @ left) * chi2 / dof
    reach = float(stdtrit(dof, _LEVEL)) * np.sqrt(((contrasts @ covariance) * contrasts).sum(axis=1))
    change = contrasts @ slope if signed else np.abs(contrasts @ slope)
    return p_value, float((change - reach).max()), float((change + reach).max())


# ---- what else ----


def _wild(names: Sequence[str]) -> Cause:
    title, experiment = "wild trials", "look at their recordings; set them aside with kept = false, and why"
    if not names:
        return Cause(title, "no", "no single trial lies far off all the others", experiment)
    text = f"trial {', '.join(names)} lies far off all the others, and was left out of this diagnosis"
    return Cause(title, "yes", text, experiment, {"trials": float(len(names))})


def _summary(ranked: Comparison, causes: Sequence[Cause], pairs: Sequence[tuple[Cause, Cause]]) -> str:
    """Return the diagnosis in one sentence."""
    found, open_ = (
        [item.cause for item in causes if item.supported == word] for word in ("yes", "cannot-tell")
    )
    text = _main_finding(ranked, causes, bool(pairs or {*found} & {*_EFFECTS, *_GROUPS}))
    text += "".join(
        f"; {one.cause} or {other.cause}, which these conditions do not separate" for one, other in pairs
    )
    lists = {"the data support": found, "undetermined": [cause for cause in open_ if cause in _EFFECTS]}
    return "; ".join([text, *(f"{words}: {', '.join(names)}" for words, names in lists.items() if names)])


def _main_finding(ranked: Comparison, causes: Sequence[Cause], has_effect: bool) -> str:  # noqa: FBT001
    """Return whether the capstan equation describes the trials."""
    plain, law = ranked["constant"], "the capstan equation"
    if plain.fit is not None:
        law += f" with μ = {_with_error(plain.fit, 'mu', '.3g')}"
    if has_effect:
        return f"{law} does not describe the trials"
    if not ranked.conclusive:
        return f"{counted(ranked.n, ranked.unit[:-1])} cannot test {law}"
    if ranked.best.law == "constant" or plain.delta_aicc <= _WEAK:
        return f"{law} describes the trials; no cause to leave it is supported" + _hidden(causes)
    return f"{law} is not the best description ({ranked.best.law} is), but the data do not show why"


def _hidden(causes: Sequence[Cause]) -> str:
    """Return which wrap effect the data still leave room for."""
    hidden = [item for item in causes if item.cause == "wrap effect" and "bound_low" in item.numbers]
    return "".join(f", but {item.evidence.rsplit('; ', 1)[-1]}" for item in hidden)


def _with_error(fit: FitResult, name: str, form: str) -> str:
    """Return a fitted parameter with its standard error, where the data leave anything to estimate one from."""
    item = fit[name]
    return f"{item.value:{form}}" + (f" ± {item.std:.2g}" if has_interval(fit) else "")
