"""Whether 95 % intervals hold the truth in 95 of 100 small campaigns, and how often a verdict is wrong.

Campaigns with known truth: of laws, numbers of conditions and repeats, scatter between them; of constant data and of
data with one effect. `docs/accuracy.md` shows what `python tests/regenerate_readme.py uncertainty verdicts` counts.
"""

from dataclasses import replace
from math import log, log1p, nan, pi, sqrt
from typing import NamedTuple

import numpy as np
from scipy.special import betaincinv

from ropefric.fitting.compare import choose_law, compare_laws
from ropefric.fitting.diagnose import diagnose
from ropefric.fitting.fit import fit_law
from ropefric.fitting.predict import predict
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.friction.laws import LAWS
from ropefric.trials.table import TrialTable

WITHIN, GAIN, OUTLIER, ROPES, SET_WRONG = 0.02, 0.03, 0.15, 0.04, pi / 90
LOADS_N = np.array([10.0, 40.0, 120.0, 20.0, 80.0, 15.0, 60.0, 30.0, 100.0])
TRUTH = {"constant": (0.2,), "wrap-power": (0.25, -0.4, 0.1), "coupled": (0.46, -0.22, -0.3, -0.48, 0.055)}
# Inside what is tested, and at none of its conditions.
WHEEL = Conditions(wheel_radius_m=np.array([0.035]), rope_radius_m=np.array([0.0049]),
                   wrap_angle_rad=np.array([7.0]), end_tension_N=np.array([60.0]))  # fmt: skip
# What may be true of the mean coefficient: the effect by its name in laws, the setting that it goes with as a power, and
# by how much of itself it changes over the whole span of that setting.
EFFECTS = {"no effect": ("", "wrap_angle_rad", 8.0, 0.0),
           "wrap effect": ("wrap-dependence", "wrap_angle_rad", 8.0, -0.2),
           "size effect": ("size", "wheel_radius_m", 4.0, 0.25),
           "load dependence": ("end-tension", "end_tension_N", 12.0, -0.2)}  # fmt: skip
# What no law describes: by what the mean coefficient is multiplied at some conditions.
MISFITS = {"bend in wrap": lambda at: 1.0 + 0.5 * np.maximum(1.0 - 2.0 * pi / at.wrap_angle_rad, 0.0),
           "threshold in size": lambda at: np.where(at.wheel_radius_m < 0.025, 1.25, 1.0),
           "saturating size": lambda at: np.minimum(at.wheel_radius_m / 0.03, 1.0)}  # fmt: skip
# Repeats that follow Student's t with so many degrees of freedom.
TAILS = "t3", "t5"
# Campaigns of constant data, and of each effect, that the docs show at so many conditions.
WRONG = {6: 50, 8: 50}
FOUND = {6: 60, 8: 60, 12: 60, 20: 100, 36: 100}
COUNTED = 200
_PERCENT = "\N{NO-BREAK SPACE}%"


class Design(NamedTuple):
    """A campaign with known truth: a law, conditions times repeats, scatter between conditions, and what is special."""

    law: str
    conditions: int
    repeats: int
    between: float = WITHIN
    special: str = ""

    @property
    def name(self):
        """Return a short name: "wrap-power 12 x 5, 2 %"."""
        special = f", {self.special}" if self.special else ""
        return f"{self.law} {self.conditions} x {self.repeats}, {100 * self.between:.0f} %{special}"

    @property
    def theta(self):
        """Return the true parameters; a bound is a third of its standard error below the plateau's truth."""
        truth = np.array(TRUTH[self.law])
        if self.special == "bound":
            truth[-1] = 0.01
        return truth

    def table(self, seed):
        """Return the trials of one campaign, and ln F_A of one pull on `WHEEL` with a new rope."""
        k, judged = self.conditions, self.special in {*EFFECTS, *MISFITS}
        rng = np.random.default_rng([seed, k, self.repeats, round(1e3 * self.between)] if judged else seed)
        size = np.full(k, self.repeats)
        if self.special == "uneven":
            size = np.array([1, 5, 9])[np.arange(k) % 3]
        # Every wrap at every load, so that no condition comes twice; laws with a size effect go round the wheels too.
        wheels = np.arange(k) % 5 if self.law == "coupled" or judged else k * [2]
        at = Conditions(wheel_radius_m=np.array([0.015, 0.02, 0.03, 0.04, 0.06])[wheels],
                        rope_radius_m=np.full(k, 0.0049),
                        wrap_angle_rad=pi * np.array([0.5, 1.0, 2.0, 4.0])[np.arange(k) % 4],
                        end_tension_N=LOADS_N[np.arange(k) // 4])  # fmt: skip
        group = np.repeat(np.arange(k), size)
        law, gain = LAWS[self.law], GAIN if self.special == "gain" else 0.0
        wrap_rad = SET_WRONG if self.special == "wrap by rig" else 0.0
        set_wrong = wrap_rad * rng.standard_normal() if wrap_rad else 0.0
        heavy = int(self.special[1:]) if self.special in TAILS else 0

        def repeats(n):
            """Return the scatter of n repeats of variance one: normal, or Student's t."""
            return rng.standard_t(heavy, n) * sqrt(1 - 2 / heavy) if heavy else rng.standard_normal(n)

        pulled = replace(at, wrap_angle_rad=at.wrap_angle_rad + set_wrong)
        log_lift = law.log_lift(self.theta, pulled)
        if self.special in EFFECTS:
            _, setting, span, change = EFFECTS[self.special]
            level = getattr(at, setting)
            more = (level / level.min()) ** (log1p(change) / log(span)) - 1.0
            log_lift += self.theta[0] * at.wrap_angle_rad * more
        elif self.special in MISFITS:
            log_lift += self.theta[0] * at.wrap_angle_rad * (MISFITS[self.special](at) - 1.0)
        # From 0.3 to 1.8 times as much, with the force.
        before, grown = log_lift, self.special == "growing scatter"
        ends = [before.min(), before.max()]
        size = np.exp(np.interp(before, ends, [log(0.3), log(1.8)])) if grown else np.ones(k)
        rise, ropes = log_lift - at.log_end_tension, self.special == "three ropes"
        rope = np.arange(group.size) % 3
        of_rope = (ROPES * rng.standard_normal(3))[rope] * rise[group] if ropes else 0.0
        log_lift = (log_lift + self.between * size * rng.standard_normal(k))[group] + of_rope
        log_lift = log_lift + WITHIN * size[group] * repeats(group.size) + gain * rng.standard_normal()
        log_lift[0] += OUTLIER if self.special == "outlier" else 0.0
        new = law.log_lift(self.theta, WHEEL)[0]
        there = np.exp(np.interp(new, ends, [log(0.3), log(1.8)])) if grown else 1.0
        more = ROPES * (new - WHEEL.log_end_tension[0]) * rng.standard_normal() if ropes else 0.0
        if heavy:
            new = new + self.between * rng.standard_normal() + WITHIN * float(repeats(1)[0])
        else:
            new = new + more + there * np.hypot(self.between, WITHIN) * rng.standard_normal()
        pulls, force_N = at.select(group), np.exp(log_lift)
        columns = {name: getattr(pulls, name) for name in SETTINGS} | {"peak_N": force_N}
        columns["cell_std_N"] = gain * force_N if gain else np.full(group.size, nan)
        columns["wrap_std_rad"] = wrap_rad
        columns["labels"] = {"rope_id": tuple(f"r{i}" for i in rope)} if ropes else {}
        return TrialTable(trial=tuple(map(str, range(group.size))), **columns), float(new)


DESIGNS = (Design("wrap-power", 12, 5), *(Design("wrap-power", k, 5) for k in (6, 8, 20, 36)),
           *(Design("wrap-power", 12, n) for n in (1, 3, 12)),
           *(Design("wrap-power", k, 5, 0.0) for k in (8, 12)),
           *(Design("constant", k, 5) for k in (6, 12)), *(Design("coupled", k, 5) for k in (12, 36)),
           *(Design("wrap-power", 12, 5, special=one)
             for one in ("gain", "bound", "outlier", "uneven", "three ropes", "wrap by rig",
                         "growing scatter", "t3", "t5")))  # fmt: skip
# Of constant data on several wheels, by conditions, repeats and scatter between conditions.
JUDGED = {(k, n, between): Design("constant", k, n, between, "no effect") for k in (6, 8, 12, 20, 36)
          for n in (1, 3, 5, 12) for between in (0.0, WITHIN)}  # fmt: skip


def coverage(design, n, level=0.95):
    """Return in which share of campaigns the intervals of a level hold the truth: of the mean law, and of one pull.

    Beside them the median half width of the mean's interval and degrees of freedom, and how often it is supported.
    """
    mean, held = LAWS[design.law].log_lift(design.theta, WHEEL)[0], []
    shared = {"cell": "cell"} | ({"wrap": "rig"} if design.special == "wrap by rig" else {})
    for seed in range(n):
        table, new = design.table(seed)
        fit = fit_law(table, design.law, shared=shared)
        found = predict(fit, WHEEL, level=level)
        ends = np.log([found.interval_N[0], found.prediction_interval_N[0]])
        held.append([low - 1e-12 <= truth <= high + 1e-12
                     for (low, high), truth in zip(ends, (mean, new), strict=True)]
                    + [0.5 * float(np.ptp(ends[0])), float(found.dof[0]), found.verdict.supported])  # fmt: skip
    shares = np.mean(np.array(held, float)[:, [0, 1, 4]], axis=0).tolist()
    width, dof = np.nanmedian(np.array(held, float)[:, [2, 3]], axis=0).tolist()
    return dict(zip(("mean", "pull", "supported"), shares, strict=True)) | {"half_width": width, "dof": dof}


def verdicts(design, n):
    """Return in which share of campaigns a law with the effect of a design, and the effect itself, are supported.

    Of a constant coefficient that is any law but the constant one, and any effect.
    """
    effect, named = EFFECTS[design.special][0], {design.special}
    if not effect:
        named = {*EFFECTS, "offset"}
    laws = effects = 0
    for seed in range(n):
        table, _ = design.table(seed)
        ranked = compare_laws(table)
        choice, causes = choose_law(ranked), diagnose(table, ranked).causes
        law = choice.fit.friction_law
        laws += choice.verdict.supported and (effect in law.effects if effect else law.name != "constant")
        effects += any(cause.supported == "yes" and cause.cause in named for cause in causes)
    return {"law": laws / n, "effect": effects / n}


def with_interval(share, n):
    """Return a share of n with Clopper and Pearson's 95 % interval."""
    count = round(share * n)
    low = float(betaincinv(count, n - count + 1, 0.025)) if count else 0.0
    high = float(betaincinv(count + 1, n - count, 0.975)) if count < n else 1.0
    return f"{100 * share:.0f}{_PERCENT} ({100 * low:.0f} to {100 * high:.0f}{_PERCENT})"


def uncertainty_block(designs=DESIGNS):
    """Return how many of the intervals of the mean and of one pull hold the truth, design by design."""
    lines = ["| law and design | mean | one pull | half width of the mean | degrees of freedom | supported |",
             "|---|---|---|---|---|---|"]  # fmt: skip
    for design in designs:
        found = coverage(design, COUNTED)
        mean, pull, supported = (f"{100 * found[key]:.0f}{_PERCENT}" for key in ("mean", "pull", "supported"))
        width = f"{100 * found['half_width']:.1f}{_PERCENT}"
        lines.append(f"| {design.name} | {mean} | {pull} | {width} | {found['dof']:.2g} | {supported} |")
    return "\n".join([*lines, ""])


def verdicts_block():
    """Return how often constant data support another law, design by design, and effects are found, in half an hour."""
    columns = list(dict.fromkeys(key[1:] for key in JUDGED))
    heads = " | ".join(f"× {repeats}, {100 * between:.0f} %" for repeats, between in columns)
    lines = [f"| conditions | campaigns | {heads} |", f"|---|---{len(columns) * '|---'}|"]
    for size, n in WRONG.items():
        shares = (verdicts(JUDGED[size, *column], n)["law"] for column in columns)
        lines.append(f"| {size} | {n} | {' | '.join(f'{100 * share:.0f}{_PERCENT}' for share in shares)} |")
    effects = list(EFFECTS)[1:]
    lines += ["", f"| conditions of 5 | campaigns | {' | '.join(effects)} |",
              f"|---|---{len(effects) * '|---'}|"]  # fmt: skip
    for size, n in FOUND.items():
        true = (JUDGED[size, 5, WITHIN]._replace(special=effect) for effect in effects)
        shares = (with_interval(verdicts(one, n)["effect"], n) for one in true)
        lines.append(f"| {size} | {n} | {' | '.join(shares)} |")
    return "\n".join([*lines, ""])
