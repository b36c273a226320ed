"""Why does my rope not obey the capstan equation? Each possible cause, with the evidence for and against it.

Effects of the settings are judged by the laws of a comparison and, since a law knows one shape and one sign of an
effect, by straight trends of μ as well; both have an AICc on the same condition means. Groups of trials (rope, wheel,
operator, order, dwell) are judged by what they explain beside all settings.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from itertools import combinations
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.special import fdtrc, stdtr, stdtrit

from ropefric.arrays import FloatArray, IntArray
from ropefric.errors import InputError
from ropefric.files.digits import significant
from ropefric.fitting.compare import Comparison, choose_law, compare_laws
from ropefric.fitting.predict import has_interval
from ropefric.fitting.result import FitResult, Verdict
from ropefric.fitting.statistics import SMALLEST_SCATTER, ConditionMeans, aicc, condition_means, scatter_fit
from ropefric.friction.condition import distinct
from ropefric.friction.laws import ALL_LAWS
from ropefric.glossary import counted
from ropefric.shown import Shown
from ropefric.trials.table import TrialTable

Supported = Literal["yes", "no", "cannot-tell"]

WORDS = {"yes": "supported", "no": "not supported", "cannot-tell": "cannot be told"}
# Differences of AICc: an effect is supported when it makes the data e^3 = 20 times likelier after its price.
_STRONG = 6.0
_WEAK = 2.0
_SIGNIFICANT = 0.01
_MANY = 0.2
_LEVEL = 0.95
_TURN_RAD = 2.0 * math.pi
# Of a column, what others leave of it; below, it says nothing that they do not.
_ALIASED = 1e-6


class _Effect(NamedTuple):
    effect: str
    quantity: str
    experiment: str


_EFFECTS = {
    "offset": _Effect(
        "offset", "", "pull at a wrap near zero, or over the same wrap on a free wheel: "
        "ln(F_A/F_B) there is the offset itself"
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
    "coil contact": _Effect(
        "coil-contact", "", "the same wraps with the coils held apart, by a groove or a spacer"
    ),
}  # fmt: skip
_GROUPS = {
    "rope": ("rope_id", "repeat conditions with several ropes each"),
    "wheel": ("wheel", "two wheels of one size, at the same conditions"),
    "operator": ("operator", "let each operator pull at all conditions"),
    "dwell": ("dwell", "vary the dwell by a factor 10 or more within each condition"),
    "order of trials": ("order", "measure in random order, and come back to the first condition at the end"),
}


@dataclass(frozen=True, slots=True)
class Cause:
    """A reason why a rope may not obey the capstan equation."""

    cause: str
    supported: Supported
    evidence: str
    experiment: str
    numbers: dict[str, float] = field(default_factory=dict)


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
        causes = [asdict(item) for item in self.causes]
        return {"summary": self.summary, "verdict": self.verdict.to_dict(), "causes": causes}


def diagnose(
    table: TrialTable, comparison: Comparison | None = None, *, touching_turns: float | None = None
) -> Diagnosis:
    """Return why the trials of a table do not obey F_A = F_B e^{μφ}, or that they do.

    `touching_turns` says how many turns at most touch the one beside them; where it is not said, all beyond the first
    may, and that is tested as an effect.
    """
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
    means = condition_means(problem)
    trends = _Trends(means, ranked, slack=table.measures_slack, touching_turns=touching_turns)
    causes = [_judged(title, ranked, trends) for title in _EFFECTS]
    labels = _labels(table)
    rise = problem.log_lift - problem.conditions.log_end_tension
    causes += [_grouped(title, labels, rise, problem.group, trends) for title in _GROUPS]
    causes += [_no_slip(table), _scatter(ranked, means), _wild(wild)]
    return Diagnosis(causes=tuple(causes), summary=_summary(ranked, causes), verdict=verdict)


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

    def __init__(
        self, means: ConditionMeans, ranked: Comparison, *, slack: bool, touching_turns: float | None
    ) -> None:
        at, self.means = means.conditions, means
        wrap = at.wrap_angle_rad
        self.rise = means.log_lift - at.log_end_tension
        levels = {
            "load dependence": np.exp(means.log_lift) if slack else at.end_tension_N,
            "size effect": at.size_ratio,
            "wrap effect": np.maximum(wrap, 1e-9),
        }
        beyond = np.clip(
            wrap - _TURN_RAD, 0.0, _TURN_RAD * (math.inf if touching_turns is None else touching_turns)
        )
        self.levels = {title: distinct(level) for title, level in levels.items()}
        self.titles = {
            "load dependence": ("lift force", "N", 1.0) if slack else ("end tension", "N", 1.0),
            "size effect": ("R_w/R_r =", "", 1.0),
            "wrap effect": ("", "deg", math.degrees(1.0)),
        }
        every = {"offset": np.ones_like(wrap)}
        every |= {title: wrap * np.log(level / level.min()) for title, level in levels.items()}
        every["coil contact"], self.touching = beyond, bool(beyond.any())
        self.columns = {title: column for title, column in every.items() if _adds(wrap[:, None], column)}
        self.aicc = {
            chosen: self._aicc(chosen)
            for size in range(len(self.columns) + 1)
            for chosen in combinations(self.columns, size)
        }
        first, trends = ranked.best, min(self.aicc.values())
        self.law = first.fit if first.counted and first.aicc < trends and not slack else None

    def matrix(self, chosen: Sequence[str]) -> FloatArray:
        """Return the columns of μ and of some trends, shape (K, 1 + number of trends)."""
        return np.stack([self.means.conditions.wrap_angle_rad, *(self.columns[t] for t in chosen)], axis=-1)

    def _solved(self, X: FloatArray, rise: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the coefficients of columns, and the variance of each mean that makes them likeliest."""
        theta: FloatArray = np.zeros(X.shape[1])
        variance = self.means.std**2
        for _ in range(4):
            root = np.sqrt(variance)
            theta = np.asarray(np.linalg.lstsq(X / root[:, None], rise / root, rcond=None)[0])
            variance = scatter_fit(X @ theta - rise, self.means).variance
        return theta, np.asarray(variance)

    def _aicc(self, chosen: tuple[str, ...]) -> float:
        X, K = self.matrix(chosen), len(self.means)
        if X.shape[1] + 2 >= K or any(not _adds(np.delete(X, i, 1), X[:, i]) for i in range(1, X.shape[1])):
            return math.inf
        theta, _ = self._solved(X, self.rise)
        if "coil contact" in chosen and theta[1 + chosen.index("coil contact")] < 0.0:
            return math.inf  # contact between coils cannot help the rope along
        return aicc(float(scatter_fit(X @ theta - self.rise, self.means).deviance), K, X.shape[1] + 1)

    @property
    def best(self) -> tuple[str, ...]:
        """Return the trends that AICc chooses."""
        return min(self.aicc, key=lambda chosen: (self.aicc[chosen], chosen))

    def least(self, title: str, *, there: bool, without: str = "") -> float:
        """Return the lowest AICc of trends that have one or not, and have not another."""
        found = (
            value
            for chosen, value in self.aicc.items()
            if (title in chosen) == there and without not in chosen
        )
        return min(found, default=math.inf)

    def line(self, title: str) -> _Line | None:
        """Return the slope of a trend beside the best description; None where nothing is left to judge it by."""
        fit, at, rise = self.law, self.means.conditions, self.rise
        if fit is not None and _EFFECTS[title].effect not in ALL_LAWS[fit.law].effects:
            # Beside the law itself, in its tangent.
            log_lift, slopes = fit.friction_law.log_lift_and_jacobian(fit.theta, at)
            others, rise = slopes[:, fit.shown], self.means.log_lift - log_lift
            mu = float(np.median((log_lift - at.log_end_tension) / np.maximum(at.wrap_angle_rad, 1e-9)))
        else:
            others, mu = self.matrix([other for other in self.best if other != title]), math.nan
        X = np.column_stack([others, self.columns[title]])
        dof = len(self.means) - X.shape[1]
        if dof < 1 or not _adds(others, X[:, -1]):
            return None
        theta, variance = self._solved(X, rise)
        known = self.means.std.max() if self.means.repeated else 0.0
        if max(known, float(np.abs(X @ theta - rise).max())) < SMALLEST_SCATTER:
            return None  # they agree to rounding, which is no scatter to judge by
        root = np.sqrt(variance)
        left = float((((X @ theta - rise) / root) ** 2).sum()) / dof
        inverse = np.linalg.pinv((X / root[:, None]).T @ (X / root[:, None]), hermitian=True)
        # With repeats a mean is known no better than they say.
        scale = max(left, 1.0) if self.means.repeated else left
        std = math.sqrt(scale * inverse[-1, -1])
        return _Line(float(theta[-1]), std, dof, float(theta[0]) if math.isnan(mu) else mu)


def _adds(columns: FloatArray, column: FloatArray) -> bool:
    """Return whether a column holds something that others do not."""
    size = float(np.linalg.norm(column))
    if size == 0.0:
        return False
    left = column - columns @ np.linalg.lstsq(columns, column, rcond=None)[0]
    return float(np.linalg.norm(left)) > _ALIASED * size


def _judged(title: str, ranked: Comparison, trends: _Trends) -> Cause:
    """Return the verdict on an effect of the settings."""
    effect, _quantity, experiment = _EFFECTS[title]
    if title == "coil contact" and not trends.touching:
        return Cause(
            title, "no", "no turn lies beside another, by the wraps or by what is said of them", experiment
        )
    if title not in trends.columns:
        return Cause(title, "cannot-tell", _untold(title), experiment)
    line = trends.line(title)
    numbers, parts = _of_line(title, line, ranked)
    laws = {entry.law: entry.aicc for entry in ranked.ranking if entry.counted}
    having = {law: value for law, value in laws.items() if effect in ALL_LAWS[law].effects}
    lacking = {law: value for law, value in laws.items() if law not in having}
    plain = ranked["constant"].aicc
    best = min([trends.least(title, there=True), *having.values()])
    other = min([trends.least(title, there=False), *lacking.values()])
    if not (math.isfinite(plain) and math.isfinite(best)):
        text = f"{ranked.n} {ranked.unit} are too few for any law with it"
        return Cause(title, "cannot-tell", "; ".join([*parts, text]), experiment, numbers)
    gain, lead = plain - best, other - best
    by_law = min(lacking.values(), default=math.inf) - min(having.values(), default=math.inf)
    numbers |= {"gain_on_constant": gain, "lead_on_others": lead}
    parts.append(_criteria_words(having, lacking, plain, gain, lead))
    yes = lead >= _STRONG or (by_law >= _STRONG and lead > 0.0) or _named_by(effect, ranked, trends, title)
    # Another effect that could stand in its place: as good without what the best description has.
    alike = [
        o for o in trends.best if o != title and trends.least(title, there=True, without=o) < other + _STRONG
    ]
    alike = alike if title not in trends.best else []
    clear = line is not None and line.p_value < _SIGNIFICANT
    looks_like_offset = title == "wrap effect" and _looks_like_offset(ranked)
    if looks_like_offset:
        parts.append(
            "a constant μ with a constant offset in ln F looks exactly like a wrap effect, and here both fit"
        )
    if yes:
        return Cause(title, "yes", "; ".join(parts), experiment, numbers)
    needless = gain < _WEAK or (lead < 0.0 and not alike)
    no = needless and not clear and not looks_like_offset
    if line is not None:
        numbers |= (limits := _limits(title, line, trends))
        parts.append(_limits_words(title, limits, trends))
    return Cause(title, "no" if no else "cannot-tell", "; ".join(parts), experiment, numbers)


def _untold(title: str) -> str:
    if title == "offset":
        return "all conditions have one wrap, where an offset cannot be told from μ"
    if title == "coil contact":
        return "the turns that touch go with the wrap in all conditions"
    return f"all conditions have one {_EFFECTS[title].quantity}"


def _of_line(title: str, line: _Line | None, ranked: Comparison) -> tuple[dict[str, float], list[str]]:
    """Return what the trend of an effect is, as numbers and in words."""
    numbers: dict[str, float] = {}
    if title == "offset" and (fit := ranked["constant-offset"].fit) is not None:
        k = fit["k"]
        numbers, text = (
            {"k": k.value, "k_std": k.std},
            f"offset of ln F_A k = {_with_error(fit, 'k', '+.3g')}",
        )
        for test in ranked.tests:
            if (test.simpler, test.fuller) == ("constant", "constant-offset"):
                text += f" (F-test p = {test.p_value:.2g})"
                numbers["p_value"] = test.p_value
        return numbers, [text]
    if line is None:
        return {}, []
    numbers = {"slope_per_doubling": line.slope * math.log(2.0), "slope_std": line.std * math.log(2.0)}
    what = f"changes by {numbers['slope_per_doubling']:+.2g} ± {numbers['slope_std']:.1g} per doubling of the"
    words = f"average μ {what} {_EFFECTS[title].quantity}"
    if title == "coil contact":
        numbers = {"slope": line.slope, "slope_std": line.std}
        words = f"beyond the first turn μ is larger by {line.slope:+.2g} ± {line.std:.1g}"
    return numbers | {"p_value": line.p_value}, [f"{words} (p = {line.p_value:.2g})"]


def _criteria_words(
    having: Mapping[str, float], lacking: Mapping[str, float], plain: float, gain: float, lead: float
) -> str:
    first = min(having, key=having.__getitem__, default="")
    by = first if first and plain - having[first] >= gain - 1e-9 else "straight trends of μ"
    text = f"AICc of the best description with it, {by}, is {_against(gain)} the constant law's"
    rival = min(lacking, key=lacking.__getitem__, default="constant")
    if abs(gain - lead) > 1e-9:
        text += f" and {_against(lead)} that of the best without it ({rival} among the laws)"
    return text


def _against(difference: float) -> str:
    return f"{abs(difference):.1f} {'below' if difference > 0 else 'above'}"


def _named_by(effect: str, ranked: Comparison, trends: _Trends, title: str) -> bool:
    """Return whether the law that won names an effect: no law without it that is as simple comes near.

    A fuller law may contain the winner as a limit and then cannot be far behind; that it does not win is enough.
    """
    best = ranked.best
    if not best.counted or effect not in ALL_LAWS[best.law].effects or best.law == "constant":
        return False
    lacking = [
        e for e in ranked.ranking if e.counted and effect not in ALL_LAWS[e.law].effects and e.k <= best.k
    ]
    simple = (
        value for chosen, value in trends.aicc.items() if title not in chosen and len(chosen) + 2 <= best.k
    )
    return min([*(e.aicc for e in lacking), *simple], default=math.inf) - best.aicc >= _STRONG


def _looks_like_offset(ranked: Comparison) -> bool:
    """Return whether an offset and a wrap effect both explain what the constant law cannot, as well as each other."""
    offset = ranked["constant-offset"]
    wraps = [e.aicc for e in ranked.ranking if e.counted and "wrap-dependence" in ALL_LAWS[e.law].effects]
    if not (offset.counted and wraps):
        return False
    gain = ranked["constant"].aicc - max(offset.aicc, min(wraps))
    return gain >= _WEAK and abs(offset.aicc - min(wraps)) < _STRONG


def _limits(title: str, line: _Line, trends: _Trends) -> dict[str, float]:
    """Return the one-sided 95 % limits of an effect: of F_A by an offset, of μ from the lowest level to the highest."""
    low, high = line.ends()
    if title == "offset":
        scale = 1.0
    elif title == "coil contact":
        low, scale = max(low, 0.0), 1.0 / line.mu
    else:
        ends = trends.levels[title]
        scale = math.log(float(ends[-1] / ends[0])) / line.mu
    low, high = sorted((low * scale, high * scale))
    return {"bound_low": low, "bound_high": high}


def _limits_words(title: str, limits: Mapping[str, float], trends: _Trends) -> str:
    """Return the largest effect that data leave room for, in the user's units."""
    low, high = limits["bound_low"], limits["bound_high"]
    fit = trends.law
    beside = f" beside {fit.law}" if fit is not None and fit.law != "constant" else ""
    if title == "offset":
        return f"an offset may still change F_A by {_percent(low)} to {_percent(high)}{beside} (at 95 % each)"
    if title == "coil contact":
        return (
            f"contact may still raise μ beyond the first turn by up to {_percent(max(high, 0.0))} (at 95 %)"
        )
    name, unit, factor = trends.titles[title]
    ends = [significant(float(end) * factor, 4) for end in trends.levels[title][[0, -1]]]
    room = [
        f"{word} by up to {_percent(size)}" for word, size in (("fall", -low), ("rise", high)) if size > 0.0
    ]
    span = " ".join(filter(None, (name, f"{ends[0]:g} to {ends[1]:g}", unit)))
    return f"μ may still {' or '.join(room)} from {span}{beside} (at 95 % each)"


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"


# ---- groups of trials ----


def _labels(table: TrialTable) -> dict[str, tuple[str, ...]]:
    """Return what is written beside the used trials; their order is that of the rows where none is written."""
    used = np.flatnonzero(table.used).tolist()
    labels = {name: tuple(values[i] for i in used) for name, values in table.labels.items()}
    return {"order": tuple(str(i + 1) for i in used)} | labels


def _grouped(
    title: str, labels: Mapping[str, tuple[str, ...]], rise: FloatArray, group: IntArray, trends: _Trends
) -> Cause:
    """Return whether what is written beside the trials explains their scatter, within conditions or between them."""
    name, experiment = _GROUPS[title]
    values = labels.get(name, ())
    if not any(values):
        return Cause(title, "cannot-tell", f"the table has no column {name}", experiment)
    found = sorted(set(values))
    if len(found) < 2:
        return Cause(title, "cannot-tell", f"all trials have one {name}", experiment)
    numeric = _numbers(values) if name in {"dwell", "order"} else None
    if name == "dwell" and numeric is not None:
        numeric = np.log(numeric) if (numeric > 0.0).all() else None
    if name in {"dwell", "order"} and numeric is None:
        return Cause(title, "cannot-tell", f"the column {name} holds what is no number", experiment)
    x = (
        np.stack([np.array([v == word for v in values], float) for word in found[1:]], axis=-1)
        if numeric is None
        else (numeric / np.ptp(numeric))[:, None]
    )
    group = np.unique(group, return_inverse=True)[1]
    size = np.bincount(group)
    mean = np.stack([np.bincount(group, column) / size for column in x.T], axis=-1)
    about = rise - (np.bincount(group, rise) / size)[group]
    tests = [_explained(np.zeros((rise.size, 0)), x - mean[group], about, rise.size - size.size)]
    full = trends.matrix(list(trends.columns))
    weight = trends.means.std.mean() / trends.means.std
    tests.append(_explained(full * weight[:, None], mean * weight[:, None], trends.rise * weight, size.size))
    told = {where: test for where, test in zip(("within", "between"), tests, strict=True) if test is not None}
    if not told:
        text = (
            f"its {counted(len(found), 'value')} go with the settings or with single trials, or too few trials are "
            "left to judge by"
        )
        return Cause(title, "cannot-tell", text, experiment)
    clear = min(test[0] for test in told.values()) * len(told) < _SIGNIFICANT
    # The one that sees it, or else the one that leaves least room.
    where, (p_value, low, high) = min(
        told.items(), key=lambda item: item[1][0] if clear else item[1][2] - item[1][1]
    )
    p_value = min(1.0, p_value * len(told))
    supported: Supported = "yes" if p_value < _SIGNIFICANT else "no"
    what = "from its lowest value to its highest" if numeric is not None else f"between {len(found)} groups"
    may = "changes" if supported == "yes" else "may still change"
    span = f"{_percent(low)} to {_percent(high)} {what}"
    text = f"{where} conditions F_A {may} by {span} (at 95 % each; p = {p_value:.2g})"
    return Cause(
        title, supported, text, experiment, {"p_value": p_value, "bound_low": low, "bound_high": high}
    )


def _explained(
    base: FloatArray, extra: FloatArray, rise: FloatArray, n: int
) -> tuple[float, float, float] | None:
    """Return the p-value of columns beside others, and the limits of the largest of their effects on ln F_A.

    `n` counts the independent observations. None where the columns hold nothing of their own, or leave nothing over.
    """
    left = extra - base @ np.linalg.lstsq(base, extra, rcond=None)[0]
    own = np.linalg.norm(left, axis=0) > 1e-3 * np.maximum(np.linalg.norm(extra, axis=0), 1e-300)
    if not own.all() or np.linalg.matrix_rank(left, tol=1e-6 * np.linalg.norm(left)) < left.shape[1]:
        return None
    dof = n - base.shape[1] - left.shape[1]
    if dof < 2:
        return None
    rest = rise - base @ np.linalg.lstsq(base, rise, rcond=None)[0]
    slope = np.linalg.lstsq(left, rest, rcond=None)[0]
    chi2 = float(((rest - left @ slope) ** 2).sum())
    F = (float(rest @ rest) - chi2) / left.shape[1] / max(chi2 / dof, 1e-300)
    reach = float(stdtrit(dof, _LEVEL)) * np.sqrt(np.diag(np.linalg.inv(left.T @ left)) * chi2 / dof)
    return float(fdtrc(left.shape[1], dof, F)), float((slope - reach).min()), float((slope + reach).max())


def _numbers(values: Sequence[str]) -> FloatArray | None:
    try:
        found = np.array([float(value.replace(",", ".")) for value in values])
    except ValueError:
        return None
    return found if np.isfinite(found).all() and np.ptp(found) > 0.0 else None


# ---- what else ----


def _wild(names: Sequence[str]) -> Cause:
    title, experiment = "wild trials", "look at their recordings; set them aside with kept = false, and why"
    if not names:
        return Cause(title, "no", "no single trial lies far off what all the others agree on", experiment)
    text = f"trial {', '.join(names)} lies far off what all the others agree on, and was left out of this diagnosis"
    return Cause(title, "yes", text, experiment, {"trials": float(len(names))})


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


def _summary(ranked: Comparison, causes: Sequence[Cause]) -> str:
    found = [item.cause for item in causes if item.supported == "yes"]
    effects = [cause for cause in found if cause in _EFFECTS or cause in _GROUPS]
    open_ = [item.cause for item in causes if item.supported == "cannot-tell" and item.cause in _EFFECTS]
    plain = ranked["constant"]
    law = "the capstan equation"
    if plain.fit is not None:
        law += f" with μ = {_with_error(plain.fit, 'mu', '.3g')}"
    named = f"the data support: {', '.join(found)}"
    if effects:
        text = f"{law} does not describe the trials; {named}"
    elif not ranked.conclusive:
        text = f"{counted(ranked.n, ranked.unit[:-1])} cannot test {law}" + (f"; {named}" if found else "")
    elif ranked.best.law == "constant" or plain.delta_aicc <= _WEAK:
        text = f"{law} describes the trials; no cause to leave it is supported"
        hidden = [item for item in causes if item.cause == "wrap effect" and "bound_low" in item.numbers]
        text += "".join(f", but {item.evidence.rsplit('; ', 1)[-1]}" for item in hidden)
        text += f"; {named}" if found else ""
    else:
        text = f"{law} is not the best description ({ranked.best.law} is), but the data do not show why"
        text += f"; {named}" if found else ""
    return text + (f"; cannot be told: {', '.join(open_)}" if open_ else "")


def _with_error(fit: FitResult, name: str, form: str) -> str:
    """Return a fitted parameter with its standard error, where the data leave anything to estimate one from."""
    item = fit[name]
    return f"{item.value:{form}}" + (f" ± {item.std:.2g}" if has_interval(fit) else "")
