"""Whether 95 % intervals hold the truth in 95 of 100 small campaigns, and how often a verdict is wrong.

Of laws, designs and every kind of interval; and of constant data and of data with one effect, what `compare` and
`diagnose` support.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from math import degrees, isfinite, log, log1p, nan, pi
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import betaincinv

from ropefric.accuracy.study import Case, Measured, Outcome, Setting, Study
from ropefric.arrays import FloatArray
from ropefric.fitting.compare import choose_law, compare_laws
from ropefric.fitting.diagnose import diagnose
from ropefric.fitting.fit import fit_law
from ropefric.fitting.intervals import bootstrap, bootstrap_t, profile_of, with_intervals
from ropefric.fitting.predict import predict
from ropefric.fitting.result import FitResult
from ropefric.fitting.statistics import clustered_covariance
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.friction.laws import LAWS
from ropefric.trials.table import TrialTable
from ropefric.uncertainty.budget import quantile

WITHIN, GAIN, OUTLIER = 0.02, 0.03, 0.15
TRUTH = {
    "constant": (0.2,),
    "wrap-power": (0.25, -0.4, 0.1),
    "coupled": (0.46, -0.22, -0.3, -0.48, 0.055),
}
WHEEL = Conditions(
    wheel_radius_m=np.array([0.035]),
    rope_radius_m=np.array([0.0049]),
    wrap_angle_rad=np.array([7.0]),
    end_tension_N=np.array([60.0]),
)
"""Inside what is tested, and at none of its conditions."""
HOLDS = (0.93, 0.97)
QUICK, USUAL, FULL = 20, 200, 1000
"""Campaigns of a quick look, of the usual one and of that over all designs."""
_RESAMPLES = 400
_SIZES, _REPEATS = (6, 8, 12, 20, 36), (1, 3, 5, 12)
JUDGED = 100
"""Campaigns that are judged at each usual design: a share is known to 10 % at worst."""
EFFECTS = {
    "no effect": ("", "wrap_angle_rad", 8.0, 0.0),
    "wrap effect": ("wrap-dependence", "wrap_angle_rad", 8.0, -0.2),
    "size effect": ("size", "wheel_radius_m", 4.0, 0.25),
    "load dependence": ("end-tension", "end_tension_N", 12.0, -0.2),
}
"""What may be true of the mean coefficient: the effect by its name in laws, the setting that it goes with as a power,
and by how much of itself it changes over the whole span of that setting."""


class Design(NamedTuple):
    """A campaign with known truth: a law, conditions times repeats, scatter between conditions, and what is special."""

    law: str
    conditions: int
    repeats: int
    between: float = WITHIN
    special: str = ""

    @property
    def name(self) -> str:
        """Return a short name: "wrap-power 12 x 5, 2 %"."""
        special = f", {self.special}" if self.special else ""
        return f"{self.law} {self.conditions} x {self.repeats}, {100 * self.between:.0f} %{special}"

    @property
    def title(self) -> str:
        """Return it in words."""
        words = {
            "gain": f"the force cell wrong by {100 * GAIN:.0f} % (1σ) in all of them",
            "bound": "the plateau's truth a third of its standard error above its bound",
            "outlier": f"one pull {100 * OUTLIER:.0f} % too high",
            "uneven": "1 to 9 repeats a condition instead",
            "no effect": "what is supported of a constant μ, and of one that changes by a fifth over all wraps, wheels "
            "(larger ones have more) or end tensions",
        }
        said = f"; {words[self.special]}" if self.special else ""
        scatter = f"{100 * WITHIN:.0f} % between repeats, {100 * self.between:.0f} % between conditions"
        return f"{self.conditions} conditions of {self.repeats}, {scatter}{said}"

    @property
    def theta(self) -> FloatArray:
        """Return the true parameters."""
        truth = np.array(TRUTH[self.law])
        if self.special == "bound":
            truth[-1] = 0.01
        return truth

    def table(self, seed: int) -> tuple[TrialTable, float]:
        """Return the trials of one campaign, and ln F_A of one pull on `WHEEL` with a new rope."""
        k, judged = self.conditions, self.special in EFFECTS
        rng = np.random.default_rng([seed, k, self.repeats, round(1e3 * self.between)] if judged else seed)
        size = np.full(k, self.repeats)
        if self.special == "uneven":
            size = np.array([1, 5, 9])[np.arange(k) % 3]
        # Every wrap at every load; all but the laws without a size effect go round the wheels with them.
        wraps = pi * np.array([0.5, 1.0, 2.0, 4.0])[np.arange(k) % 4]
        loads = np.array([10.0, 40.0, 120.0])[(np.arange(k) // 4) % 3]
        wheels = np.array([0.015, 0.02, 0.03, 0.04, 0.06])[
            np.arange(k) % 5 if self.law == "coupled" or judged else k * [2]
        ]
        at = Conditions(
            wheel_radius_m=wheels, rope_radius_m=np.full(k, 0.0049), wrap_angle_rad=wraps, end_tension_N=loads
        )
        group = np.repeat(np.arange(k), size)
        law, gain = LAWS[self.law], GAIN if self.special == "gain" else 0.0
        log_lift = law.log_lift(self.theta, at)
        if judged:
            _, setting, span, change = EFFECTS[self.special]
            level = getattr(at, setting)
            log_lift += self.theta[0] * wraps * ((level / level.min()) ** (log1p(change) / log(span)) - 1.0)
        log_lift = (log_lift + self.between * rng.standard_normal(k))[group]
        log_lift = log_lift + WITHIN * rng.standard_normal(group.size) + gain * rng.standard_normal()
        log_lift[0] += OUTLIER if self.special == "outlier" else 0.0
        new = (
            float(law.log_lift(self.theta, WHEEL)[0]) + np.hypot(self.between, WITHIN) * rng.standard_normal()
        )
        pulls, force_N = at.select(group), np.exp(log_lift)
        columns = {name: getattr(pulls, name) for name in SETTINGS} | {"peak_N": force_N}
        columns["peak_std_N"] = gain * force_N if gain else np.full(group.size, nan)
        return TrialTable(trial=tuple(map(str, range(group.size))), **columns), new


class Intervals(NamedTuple):
    """95 % intervals of the parameters (p, 2), of ln F_A of the mean law and of one pull with a new rope (2,)."""

    parameters: FloatArray
    mean: FloatArray | None = None
    pull: FloatArray | None = None


def by_covariance(fit: FitResult) -> Intervals:
    """Return what a fit and a prediction print."""
    found = predict(fit, WHEEL, check=False)
    ends = np.array([item.ci95 for item in fit.parameters])
    return Intervals(ends, np.log(found.interval_N[0]), np.log(found.prediction_interval_N[0]))


def by_sandwich(fit: FitResult) -> Intervals:
    """Return the intervals of CR2 with Bell and McCaffrey's degrees of freedom, one by one."""
    problem = fit.data
    residuals, J = problem.residuals_and_jacobian(fit.theta)
    at_mean = fit.friction_law.jacobian(fit.theta, WHEEL)[:, problem.vary]
    wanted = np.vstack([np.eye(fit.theta.size)[problem.vary][:, problem.vary], at_mean])
    covariance, dof = clustered_covariance(J[:, problem.vary], residuals, problem.group, of=wanted)
    half = np.sqrt(np.einsum("ij,jk,ik->i", wanted, covariance, wanted)) * [quantile(0.975, nu) for nu in dof]
    centre = np.append(fit.theta[problem.vary], fit.friction_law.log_lift(fit.theta, WHEEL))
    ends = centre[:, None] + half[:, None] * [-1.0, 1.0]
    return Intervals(np.clip(ends[:-1], problem.lower[:, None], problem.upper[:, None]), ends[-1])


def by_drawn_conditions(fit: FitResult) -> Intervals:
    """Return the percentiles of fits to whole conditions drawn anew."""
    drawn = bootstrap(fit.data, fit.theta, kind="clustered", n=_RESAMPLES)
    return Intervals(
        drawn.interval(), np.quantile(fit.friction_law.log_lift(drawn.theta, WHEEL)[:, 0], [0.025, 0.975])
    )


def by_bootstrap_t(fit: FitResult) -> Intervals:
    """Return the intervals by Student's own way, with quantiles that are drawn."""
    ends = bootstrap_t(fit.data, fit.theta, at=WHEEL, n=_RESAMPLES)
    return Intervals(ends[:-1], ends[-1])


KINDS: dict[str, Callable[[FitResult], Intervals]] = {
    "covariance": by_covariance,
    "auto": lambda fit: by_covariance(with_intervals(fit, "auto")),
    "CR2, Bell-McCaffrey": by_sandwich,
    "profile": lambda fit: Intervals(profile_of(fit).ci),
    "bootstrap of conditions": by_drawn_conditions,
    "bootstrap-t": by_bootstrap_t,
}
"""Kinds of interval; "auto" is the default."""


@cache
def _campaign(design: Design, seed: int) -> tuple[FitResult, float]:
    table, new = design.table(seed)
    return fit_law(table, design.law), new


def _inside(ends: FloatArray | None, truth: npt.ArrayLike) -> list[bool]:
    """Return which intervals hold the truth, of those that there are."""
    if ends is None:
        return []
    low, high = np.atleast_2d(ends).T
    there = ~np.isnan(low + high)
    held = (low - 1e-12 <= truth) & (truth <= high + 1e-12)
    return [bool(one) for one in held[there]]


def coverage(design: Design, kind: Callable[[FitResult], Intervals], n: int) -> Outcome:
    """Return how many intervals hold the truth: of the parameters, the mean law and one pull with a new rope.

    `given`: how often there is an interval of the mean, or of the first parameter where the kind has no other, and
    `half_width` the median of half of it. The error is the largest distance of a share from 95 %.
    """
    mean = float(LAWS[design.law].log_lift(design.theta, WHEEL)[0])
    held: dict[str, list[bool]] = {"parameters": [], "mean": [], "pull": []}
    widths, given = [], 0
    for seed in range(n):
        fit, new = _campaign(design, seed)
        found = kind(fit)
        held["parameters"] += _inside(found.parameters, design.theta)
        held["mean"] += _inside(found.mean, mean)
        held["pull"] += _inside(found.pull, new)
        shown = found.parameters[0] if found.mean is None else found.mean
        given += bool(np.isfinite(shown).all())
        widths.append(float(shown[1] - shown[0]) / 2.0)
    shares = {name: float(np.mean(inside)) if inside else nan for name, inside in held.items()}
    errors = [abs(share - 0.95) for share in shares.values() if isfinite(share)]
    width = float(np.nanmedian(widths)) if np.isfinite(widths).any() else nan
    return Outcome(
        error=max(errors, default=float("inf")),
        evaluations=float(n),
        shares={**shares, "given": given / n, "half_width": width},
    )


def verdicts(design: Design, n: int) -> Outcome:
    """Return in which share of campaigns a law with the effect of a design, and the effect itself, are supported.

    Of a constant coefficient that is any law but the constant one, any effect: the error is the share of such laws,
    else that of campaigns in which the effect is missed. `law_low` and `law_high` hold the share of laws at 95 %,
    `effect_low` and `effect_high` that of effects.
    """
    effect, named = EFFECTS[design.special][0], {design.special}
    if not effect:
        named = {*EFFECTS, "offset", "coil contact"}
    laws = effects = 0
    for seed in range(n):
        table, _ = design.table(seed)
        ranked = compare_laws(table)
        choice, causes = choose_law(ranked), diagnose(table, ranked).causes
        law = choice.fit.friction_law
        laws += choice.verdict.supported and (effect in law.effects if effect else law.name != "constant")
        effects += any(cause.supported == "yes" and cause.cause in named for cause in causes)
    shares: dict[str, float] = {}
    for name, count in (("law", laws), ("effect", effects)):
        low = float(betaincinv(count, n - count + 1, 0.025)) if count else 0.0
        high = float(betaincinv(count + 1, n - count, 0.975)) if count < n else 1.0
        shares |= {name: count / n, f"{name}_low": low, f"{name}_high": high}
    return Outcome(
        error=1.0 - shares["effect"] if effect else shares["law"], evaluations=float(n), shares=shares
    )


def _settings(design: Design, *, full: bool) -> tuple[Setting, ...]:
    rows: list[tuple[str, Callable[[], object], Callable[[int], Outcome], tuple[int, int]]] = []
    for effect in EFFECTS if design.special in EFFECTS else ():
        true = design._replace(special=effect)
        many = (FULL if true == design else USUAL) if full else JUDGED
        rows.append((effect, partial(verdicts, true, 1), partial(verdicts, true), (QUICK // 3, many)))
    for kind, how in () if design.special in EFFECTS else KINDS.items():
        one, all_of = partial(_one, design, how), partial(coverage, design, how)
        rows.append((kind, one, all_of, (QUICK, FULL if full else USUAL)))
    return tuple(
        Setting(name, f"{n} campaigns", one, partial(all_of, n), n == counts[0])
        for name, one, all_of, counts in rows
        for n in counts
    )


def _one(design: Design, how: Callable[[FitResult], Intervals]) -> Intervals:
    return how(_campaign(design, 0)[0])


def _case(design: Design, *, full: bool = False) -> Case:
    return Case(design.name, design.title, partial(_settings, design, full=full))


def with_all_designs(study: Study) -> Study:
    """Return the study over every law, size, number of repeats and scatter, 1000 campaigns each: hours.

    Pieces, in this order, that an executor may share: a kind of interval, or a true effect, at a design.
    """
    more = [
        Design(law, k, n, between)
        for law in TRUTH for k in _SIZES for n in _REPEATS for between in (0.0, WITHIN)
    ]  # fmt: skip
    special = [design for design in _DESIGNS if design.special and design.special not in EFFECTS]
    return replace(study, cases=tuple(_case(one, full=True) for one in (*more, *special, *JUDGED_DESIGNS)))


def _findings(points: tuple[Measured, ...]) -> tuple[str, ...]:
    """Say where the default holds, what it covers where it does not, and the cheapest kind that always does."""
    every = {(point.case, point.method): point for point in sorted(points, key=lambda one: one.evaluations)}
    of_kind = {kind: [point for key, point in every.items() if key[1] == kind] for kind in KINDS}
    lines = []
    if default := of_kind["auto"]:
        off = [f"{point.case}: {_off(point)}." for point in default if _off(point)]
        held = len(default) - len(off)
        lines = [f"auto, the default, holds 93 to 97 % in {held} of {len(default)} designs.", *off]
    always = [point for mine in of_kind.values() if not any(map(_off, mine)) for point in mine]
    if always:
        first = min(always, key=lambda one: one.seconds)
        lines.append(f"Cheapest kind that holds 93 to 97 % everywhere, but for chance: {first.method}.")
    elif any(of_kind.values()):
        lines.append("No kind of interval holds 93 to 97 % in every design; what each covers stands above.")
    for (case, effect), point in every.items():
        if effect in EFFECTS:
            law, found = (share_text(point.shares, name) for name in ("law", "effect"))
            whose, which = (
                ("a richer law", "an effect") if effect == "no effect" else ("a law with it", "the effect")
            )
            lines.append(
                f"{case.split(', no')[0]}, {effect}: {whose} is supported in {law} of {point.evaluations:.0f} "
                f"campaigns, {which} in {found}."
            )
    return tuple(lines)


def share_text(shares: Mapping[str, float], name: str) -> str:
    """Return a share of verdicts with its 95 % interval."""
    share, low, high = (100.0 * shares[f"{name}{end}"] for end in ("", "_low", "_high"))
    return f"{share:.0f} % ({low:.0f} to {high:.0f} %)"


def _off(point: Measured) -> str:
    """Return what lies outside 93 to 97 % by more than chance (two standard errors), in words."""
    room = 2.0 * np.sqrt(0.95 * 0.05 / point.evaluations)
    said = [
        f"{name} {100 * point.shares[name]:.0f} %"
        for name in ("parameters", "mean", "pull")
        if point.shares[name] < HOLDS[0] - room or point.shares[name] > HOLDS[1] + room
    ]
    return ", ".join(said)


JUDGED_DESIGNS = tuple(
    Design("constant", k, n, between, "no effect")
    for k in _SIZES for n in _REPEATS for between in (0.0, WITHIN)
)  # fmt: skip
"""Of constant data on several wheels."""
_DESIGNS = (
    Design("wrap-power", 12, 5),
    *(Design("wrap-power", k, 5) for k in (6, 8, 20, 36)),
    *(Design("wrap-power", 12, n) for n in (1, 3, 12)),
    *(Design("wrap-power", k, 5, 0.0) for k in (8, 12)),
    *(Design("constant", k, 5) for k in (6, 12)),
    *(Design("coupled", k, 5) for k in (12, 36)),
    *(Design("wrap-power", 12, 5, special=one) for one in ("gain", "bound", "outlier", "uneven")),
    Design("constant", 12, 5, special="no effect"),
)
STUDY = Study(
    name="uncertainty",
    title="95 % intervals of small campaigns: how many hold the truth",
    question="Do 95 % intervals hold the truth in 95 of 100 campaigns as small as a laboratory's?",
    reference=f"the truth of simulated campaigns, on {degrees(7.0):.0f} deg of a 35 mm wheel at 60 N",
    counted="campaigns; error: the largest distance of a coverage from 95 %",
    used="covariance of two levels of scatter with Student's t; the profile where χ² is no parabola",
    cases=tuple(_case(design) for design in _DESIGNS),
    findings=_findings,
)
