"""The rope-wheel friction of a portable rope track hoist (PRTH): what its paper makes of trials, and of a hoist.

Trials are reduced to series over one setting, with laws put beside them.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError
from ropefric.fitting.fit import fit_law
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import SETTINGS, Conditions, along_one
from ropefric.friction.law import FrictionLaw
from ropefric.papers.paper import Given, Item, Paper, Row, Shown, part_of, shown
from ropefric.section import Line, Section
from ropefric.systems.effect import applicable, assemble
from ropefric.systems.hoist.contact import Lift, solve_lift, tension_along_N
from ropefric.systems.hoist.effects import SYSTEM
from ropefric.trials.outliers import RULES, scaled
from ropefric.trials.table import TrialTable

STEPS = 61
_OVER = {
    "end_tension_N": ("4", "end tension F_B", "N", 1.0),
    "wrap_angle_rad": ("5", "wrap φ", "deg", 180.0 / math.pi),
    "wheel_radius_m": ("6", "wheel radius R_w", "mm", 1e3),
}
"""What is varied, by figure: its words, unit and factor."""


class Series(NamedTuple):
    """Conditions that differ in one setting alone, in its order: settings, mean ln F_A and its standard error."""

    over: str
    at: Conditions
    log_lift: FloatArray
    std: FloatArray
    trials: TrialTable

    @property
    def x(self) -> FloatArray:
        """Return the setting that is varied, in the unit of its figure."""
        return np.asarray(getattr(self.at, self.over) * _OVER[self.over][3])

    @property
    def average_mu(self) -> FloatArray:
        """Return ln(F_A/F_B)/φ, eq. (2)."""
        return np.asarray((self.log_lift - self.at.log_end_tension) / self.at.wrap_angle_rad)

    @property
    def ratio(self) -> FloatArray:
        """Return F_A/F_B."""
        return np.exp(self.log_lift - self.at.log_end_tension)


class Reduction(NamedTuple):
    """What the paper's experiment makes of trials: a series over each setting, and the laws it puts beside them.

    `sizes` are the laws (3) and (4) of the series of wheels, `wraps` the laws (14) and (15) of all trials on the wheel
    whose wrap was varied, `both` is the law (16) of all trials; forces are over F_0.
    """

    series: dict[str, Series]
    sizes: tuple[FitResult, ...]
    wraps: tuple[FitResult, ...]
    both: tuple[FitResult, ...]


def reduce_trials(trials: TrialTable, fits: Sequence[FitResult] = ()) -> Reduction:
    """Return what the paper's own reduction makes of trials, of all of which some laws may have their fits."""
    found = {over: one for over in _OVER if (one := _series(trials, over)) is not None}
    sizes, wraps = (found.get(over) for over in ("wheel_radius_m", "wrap_angle_rad"))
    by_size = () if sizes is None else _fitted(sizes.trials, "size-power", "size-exponential")
    by_wrap: tuple[FitResult, ...] = ()
    if wraps is not None:
        wheel = np.isclose(trials.wheel_radius_m, wraps.at.wheel_radius_m[0], rtol=1e-6)
        rope = np.isclose(trials.rope_radius_m, wraps.at.rope_radius_m[0], rtol=1e-6)
        by_wrap = _fitted(replace(trials, kept=trials.kept & wheel & rope), "wrap-exponential", "wrap-power")
    both = tuple(fit for fit in fits if fit.law == "coupled") or _fitted(trials, "coupled")
    return Reduction(found, by_size, by_wrap, both)


def _fitted(trials: TrialTable, *names: str) -> tuple[FitResult, ...]:
    """Return the laws that can be fitted."""
    fits = []
    for name in names:
        with suppress(RopefricError):
            fits.append(fit_law(trials, name))
    return tuple(fits)


def _series(trials: TrialTable, over: str) -> Series | None:
    """Return the conditions that differ in one setting alone and take the most values of it; None below three."""
    at, log_lift, used = trials.conditions(), trials.log_lift(), np.flatnonzero(trials.used)
    if not len(at):
        return None
    chosen, along = along_one(at, over)
    places = [chosen[along[chosen] == level] for level in np.unique(along[chosen])]
    if len(places) < 3:
        return None
    kept = np.zeros(len(trials), dtype=np.bool_)
    kept[used[chosen]] = True
    n = np.array([rows.size for rows in places])
    squares = sum(float(((log_lift[rows] - log_lift[rows].mean()) ** 2).sum()) for rows in places)
    within = math.sqrt(squares / (n.sum() - n.size)) if n.sum() > n.size else math.nan
    means = np.array([log_lift[rows].mean() for rows in places])
    mine, own = at.select([rows[0] for rows in places]), replace(trials, kept=kept)
    return Series(over, mine, means, within / np.sqrt(n), own)


class Segments(NamedTuple):
    """The wrap cut where it was measured, eqs. (5)-(10): ends, and the coefficient of each piece."""

    ends_rad: FloatArray
    mu: FloatArray
    std: FloatArray

    @property
    def middle_rad(self) -> FloatArray:
        """Return where the local coefficient is taken to be that of the piece, eq. (13)."""
        return np.asarray(0.5 * (self.ends_rad[1:] + self.ends_rad[:-1]))


def segments(wraps: Series) -> Segments:
    """Return μ_(i,j) = (ln F_j − ln F_i)/φ_(i,j) of a series of wraps, the first piece from F_B at φ = 0 on."""
    ends = np.concatenate([[0.0], wraps.at.wrap_angle_rad])
    force = np.concatenate([wraps.at.log_end_tension[:1], wraps.log_lift])
    std = np.concatenate([[0.0], wraps.std])
    return Segments(ends, np.diff(force) / np.diff(ends), np.hypot(std[1:], std[:-1]) / np.diff(ends))


class Trials(NamedTuple):
    """What is made of trials, without a hoist."""

    reduction: Reduction


def bracket_of_16(theta: FloatArray) -> tuple[float, float]:
    """Return μ_inf and b of μ_R = μ_inf (1 − e^(a r)) + b, as (16) prints it, from those in the bracket of (4)."""
    mu_inf, _, b = theta[:3]
    return float(mu_inf * np.exp(b)), float(-mu_inf * np.expm1(b))


def _within(std: float) -> str:
    return f"± {std:.2g}" if 0.0 < std < math.inf else ""


def _of_laws(*names: str) -> Callable[[Any], Iterator[Row]]:
    """Give the parameters of fitted laws."""

    def rows(it: Any) -> Iterator[Row]:
        found = it.reduction
        for fit in () if found is None else (*found.sizes, *found.wraps, *found.both):
            if fit.law in names:
                for one in fit.parameters:
                    yield Row(f"{one.name} of {fit.law}", one.value, remark=_within(one.std))
            if fit.law == "coupled" and fit.law in names:
                for name, value in zip(("μ_inf", "b"), bracket_of_16(fit.theta), strict=True):
                    yield Row(f"{name} in the bracket of (16) as printed", value)

    return rows


def _over(setting: str, rows: Callable[[Series, Reduction], Iterator[Any]]) -> Callable[[Any], Iterator[Any]]:
    """Return what to give of a series, nothing where there is none."""

    def of(it: Any) -> Iterator[Any]:
        if it.reduction is not None and setting in it.reduction.series:
            yield from rows(it.reduction.series[setting], it.reduction)

    return of


_wraps, _wheels = partial(_over, "wrap_angle_rad"), partial(_over, "wheel_radius_m")


def _segments(wraps: Series, _: Reduction) -> Iterator[Row]:
    cut = segments(wraps)
    widths, ends_deg = np.diff(cut.ends_rad), np.degrees(cut.ends_rad)
    for start, end, mu, std in zip(ends_deg[:-1], ends_deg[1:], cut.mu, cut.std, strict=True):
        yield Row(f"μ from {start:.4g} to {end:.4g} deg", float(mu), remark=_within(float(std)))
    yield Row("(7), (9): Σ μ_m φ_m / φ", float(cut.mu @ widths / widths.sum()))
    equal = np.ptp(widths) < 1e-9
    remark = "" if equal else "the pieces are not equal"
    yield Row("(8), (10): equal weights", float(cut.mu.mean()), remark=remark)
    yield Row("ln(F_A/F_B)/φ over it all", float(wraps.average_mu[-1]))


def _local(wraps: Series, found: Reduction) -> Iterator[Row]:
    cut = segments(wraps)
    at = wraps.at.select(np.zeros(len(cut.mu), np.int64))
    for fit in found.wraps:
        local = fit.friction_law.local_mu(fit.theta, cut.middle_rad, at)
        for middle, mu, own in zip(np.degrees(cut.middle_rad), local, cut.mu, strict=True):
            yield Row(f"μ({middle:.4g} deg) by {fit.law}", float(mu), remark=f"measured {own:.4g}")


def _points(series: Series, _: Reduction) -> Iterator[Row]:
    for x, mu, ratio in zip(series.x, series.average_mu, series.ratio, strict=True):
        yield Row(f"μ at {x:.4g} {_OVER[series.over][2]}", float(mu), remark=f"F_A/F_B = {ratio:.4g}")


def _misses(series: Series, found: Reduction) -> Iterator[Row]:
    """Give the root mean square of ln F_A by which both laws of a figure miss its points."""
    for fit in found.sizes if series.over == "wheel_radius_m" else found.wraps:
        off = fit.friction_law.log_lift(fit.theta, series.at) - series.log_lift
        yield Row(f"rms miss of ln F_A by {_NAMES[fit.law]}", float(np.sqrt(np.mean(off**2))))


_NUMBERS = {"size-power": 3, "size-exponential": 4, "wrap-exponential": 14, "wrap-power": 15}
_NAMES = {law: f"({number}), {law}" for law, number in _NUMBERS.items()}
_MU, _LOCAL = ("mu_average", "Average coefficient μ [-]"), ("mu_local", "Local coefficient μ(φ) [-]")
_WRAP, _SIZE = ("wrap_angle_deg", "Wrap φ [deg]"), ("size_ratio", "R_w/R_r [-]")


def panels(series: Series, _: Reduction) -> Iterator[Shown]:
    """Yield the two panels of Figs 4 to 6: coefficient and ratio of the forces over what was varied."""
    number, words, unit, _factor = _OVER[series.over]
    across = (series.over, f"{words[:1].upper()}{words[1:]} [{unit}]")
    for up, values in ((_MU, series.average_mu), (("ratio", "F_A/F_B [-]"), series.ratio)):
        line = Line("measured", series.x, values, points=True)
        yield shown(f"figure_{number}_{up[0]}", f"{up[1][:-4]} over the {words}", across, up, [line])


def _fine(series: Series) -> Conditions:
    """Return fine steps over a series."""
    values = getattr(series.at, series.over)
    one = {name: getattr(series.at, name)[:1] for name in SETTINGS}
    return Conditions(**one | {series.over: np.linspace(values[0], values[-1], STEPS)})


def size_chart(series: Series, found: Reduction) -> Iterator[Shown]:
    """Yield Fig. 7: average coefficient over R_w/R_r, measured and by both laws, whichever is the better."""
    at, lines = _fine(series), [Line("measured", series.at.size_ratio, series.average_mu, points=True)]
    lines += [
        Line(_NAMES[fit.law], at.size_ratio, fit.friction_law.average_mu(fit.theta, at))
        for fit in found.sizes
    ]
    yield shown("figure_7", "Size effect: measured, and both laws", _SIZE, _MU, lines)


def wrap_charts(series: Series, found: Reduction) -> Iterator[Shown]:
    """Yield Fig. 8: ln F_A over the wrap and its derivative, measured and by both laws."""
    at, cut = _fine(series), segments(series)
    x = np.degrees(at.wrap_angle_rad)
    forces = [Line("measured", series.x, series.log_lift, points=True)]
    local = [Line("measured, piece by piece", np.degrees(cut.middle_rad), cut.mu, points=True)]
    for fit in found.wraps:
        law, name = fit.friction_law, _NAMES[fit.law]
        forces.append(Line(name, x, law.log_lift(fit.theta, at)))
        local.append(Line(name, x, law.local_mu(fit.theta, at.wrap_angle_rad, at)))
    up = ("log_lift", "ln F_A [-]")
    yield shown("figure_8_log_lift", "Wrap: measured ln F_A, and both laws", _WRAP, up, forces)
    yield shown("figure_8_mu", "Wrap: local coefficient, eq. (13)", _WRAP, _LOCAL, local)


def coupled_chart(series: Series, found: Reduction) -> Iterator[Shown]:
    """Yield Fig. 9: the coefficient of (16) over the wrap from F_0 on, a line for each wheel."""
    wrap_rad = np.radians(np.linspace(20.0, 1080.0, STEPS))
    for fit in found.both:
        lines = []
        for i, radius_m in enumerate(series.at.wheel_radius_m):
            at = replace(series.at.select(np.full(STEPS, i)), end_tension_N=np.ones(STEPS))
            mu = fit.friction_law.local_mu(fit.theta, wrap_rad, at)
            lines.append(Line(f"R_w = {1e3 * radius_m:.4g} mm", np.degrees(wrap_rad), mu))
        yield shown("figure_9", "Wheel and wrap together, eq. (16), from F_0 on", _WRAP, _LOCAL, lines)


ITEMS = (
    *(
        Item(number=f"Fig. {number}", says=f"coefficient and ratio of forces over the {words}", where="3",
            rows=_over(over, _points), charts=_over(over, panels))
        for over, (number, words, _, _) in _OVER.items()
    ),
    Item(number="(3)", says="μ = μ_inf (R_w/(R_r + R_w))^a + b", where="3.1",
        rows=_of_laws("size-power")),
    Item(number="(4)", says="μ = μ_inf (1 - e^(a R_w/R_r + b))", where="3.1",
        rows=_of_laws("size-exponential")),
    Item(number="Fig. 7", says="both laws of size beside the trials", where="3.1", rows=_wheels(_misses),
        charts=_wheels(size_chart),
        remark="the paper finds (4) the better of the two"),
    Item(number="(5)-(10)", says="ln F_j - ln F_i = Σ μ_m φ_m", where="3.2", rows=_wraps(_segments),
        remark="(8) and (10) weigh the pieces equally, which is right for equal pieces only"),
    Item(number="(11)-(13)", says="∫μ dφ = ln F - ln F_0, μ(φ) = d ln F/dφ", where="3.2",
        rows=_wraps(_local),
        remark="the law through the integral beside the differences of the trials, whose noise is amplified"),
    Item(number="(14)", says="μ(φ) = a e^(bφ) + c", where="3.2", rows=_of_laws("wrap-exponential")),
    Item(number="(15)", says="μ(φ) = a φ^b + c", where="3.2", rows=_of_laws("wrap-power"),
        remark="the paper's choice; a wrap series under one end tension cannot tell its parameters apart, so all "
        "end tensions on that wheel are taken"),
    Item(number="Fig. 8", says="both laws of wrap beside the trials", where="3.2", rows=_wraps(_misses),
        charts=_wraps(wrap_charts)),
    Item(number="(16)", says="μ(φ) = μ_R φ^c + d, μ_R = μ_inf (1 - e^(a r)) + b", where="3.3",
        rows=_of_laws("coupled"),
        remark="its bracket is not that of (4), which `coupled` has; both are one family, A - B e^(a r)"),
    Item(number="Fig. 9", says="wheel and wrap together", where="3.3", charts=_wheels(coupled_chart)),
)  # fmt: skip
"""What of the paper follows from trials alone."""


def reduction_of(trials: TrialTable, fits: Sequence[FitResult] = ()) -> tuple[list[Section], list[Shown]]:
    """Return the paper's reduction of trials by itself, for a report: in words and tables, and as figures.

    Nothing where no setting was varied by itself. `fits` are of laws that were fitted to all of them already.
    """
    found = Trials(reduce_trials(trials, fits))
    if not found.reduction.series:
        return [], []
    rows = {item: tuple(item.rows(found)) for item in ITEMS}
    # A report shows the coefficients over each setting, of all conditions, anyway.
    charts = [one for item in rows for one in item.charts(found) if not one.stem.endswith(_MU[0])]
    return [part_of(item, some) for item, some in rows.items() if some], charts


# ---- the paper's equations, for a hoist and its trials ----

_EXAMPLE_N = (335.7, *(320.7 + sign * 3.9051248 for sign in (-1.0, 1.0) for _ in range(7)))
"""Fifteen forces with the printed mean and standard deviation, one of them beyond two of these."""


class Machine(NamedTuple):
    """A hoist with its law, and what is made of trials."""

    lift: Lift
    law: FrictionLaw
    theta: FloatArray
    at: Conditions
    reference_N: float
    reduction: Reduction | None


def _machine(given: Given) -> Machine:
    scene = given.scene
    problem, source = scene.problem, scene.source
    model = assemble(SYSTEM, problem, applicable(SYSTEM.effects, problem))
    lift = solve_lift(model)
    assert source is not None  # noqa: S101  (a hoist's schema asks for friction)
    trials = given.trials
    if trials is None and source.fit is not None:
        trials = _means(source.fit)
    if trials is not None and given.reference_N != 1.0:
        names = ("end_tension", "end_tension_std", "end_tension_set", "peak", "peak_std", "cell_std")
        forces = {f"{name}_N": getattr(trials, f"{name}_N") / given.reference_N for name in names}
        trials = replace(trials, **forces)
    law, theta = source.friction.law, source.friction.theta
    at = Conditions(**{name: getattr(problem, name)[:1] for name in SETTINGS})
    reduction = None if trials is None else reduce_trials(trials)
    return Machine(lift, law, theta, at, given.reference_N, reduction)


def _means(fit: FitResult) -> TrialTable:
    """Return the conditions that a stored fit rests on as trials, each by its mean."""
    columns: dict[str, Any] = {name: np.asarray(fit.trials[name]) for name in SETTINGS}
    peak_N = np.exp(fit.trials["mean_log_lift"])
    return TrialTable(trial=tuple(f"condition {i + 1}" for i in range(len(peak_N))), peak_N=peak_N, **columns)


def log_lift(law: FrictionLaw, theta: FloatArray, at: Conditions, reference_N: float = 1.0) -> FloatArray:
    """Return ln F_A where ∫μ dφ over φ0 is ln(F_B/F_0), eqs. (11), (17), for any F_0: forces are counted in it."""
    over = replace(at, end_tension_N=at.end_tension_N / reference_N)
    return law.log_lift(theta, over) + math.log(reference_N)


def _example(_: Machine) -> Iterator[Row]:
    values = np.array(_EXAMPLE_N)
    kept = values[~RULES["two-sigma"].flag(values)]
    yield Row("mean F_A of a series of 15", scaled(values).mean(), "321.7")
    yield Row("s", scaled(values).std(), "5.5")
    yield Row("mean after one pass of ±2s", scaled(kept).mean(), "320.7")


def _euler(it: Machine) -> Iterator[Row]:
    end_N, force_N = float(it.lift.end_tension_N[0]), float(it.lift.lift_force_N[0])
    yield Row("F_B [N]", end_N)
    yield Row("F_A [N], eq. (17) with all effects of the scene", force_N)
    yield Row("F_A/F_B", force_N / end_N)
    yield Row("average μ = ln(F_A/F_B)/φ over the contact", float(it.lift.average_mu[0]))


def _figure_1(it: Machine) -> Iterator[Row]:
    yield Row("centrifugal part ρω²r² [N]", float(it.lift.model.problem.circling_N[0]))
    yield Row("wrap φ in contact [deg]", math.degrees(it.lift.contact_rad[0]))
    if it.lift.arcs is None:
        yield Row("slip θ and stick φ - θ", None, remark="θ = φ at the lift force; a payload asks for less")
    else:
        yield Row("slip θ under the payload [deg]", math.degrees(it.lift.arcs.slip_rad[0]))
        yield Row("stick φ - θ under the payload [deg]", math.degrees(it.lift.arcs.stick_rad[0]))


def _chart_1(it: Machine) -> Iterator[Shown]:
    arcs = it.lift.arcs
    if arcs is None or not np.isfinite(arcs.slip_rad).all():
        return
    ends = np.cumsum([0.0, arcs.slip_rad[0], arcs.stick_rad[0]])
    pieces = {"slips": ends[:2], "sticks": ends[1:]}
    angles = {name: np.linspace(one[0], one[1], STEPS) for name, one in pieces.items()}
    lines = [Line(name, np.degrees(one), tension_along_N(it.lift, one)) for name, one in angles.items()]
    title = "Tension along the rope on the turning wheel, under the payload"
    across, up = ("wrap_angle_deg", "Angle from the slack side [deg]"), ("tension_N", "Tension F [N]")
    yield shown("figure_1", title, across, up, lines)


def _lift(it: Machine) -> Iterator[Row]:
    for reference_N in dict.fromkeys((1.0, it.reference_N)):
        value = log_lift(it.law, it.theta, it.at, reference_N)[0]
        yield Row(f"ln F_A by {it.law.name} for F_0 = {reference_N:g} N, the rope at rest", float(value))
        if "end-tension" in it.law.effects:
            yield Row(f"φ0 for F_0 = {reference_N:g} N [deg]", math.degrees(_start_rad(it, reference_N)))


def _start_rad(it: Machine, reference_N: float) -> float:
    """Return φ0, over which F_0 becomes F_B."""
    log_end = math.log(it.at.end_tension_N[0] / reference_N)

    def surplus(log_wrap: float) -> float:
        there = replace(it.at, wrap_angle_rad=np.exp([log_wrap]), end_tension_N=np.ones(1))
        return float(it.law.log_lift(it.theta, there)[0]) - log_end

    return math.exp(brentq(surplus, -600.0, 10.0, xtol=1e-12)) if log_end > 0.0 else 0.0


PAPER = Paper(
    title="The lift force of a rope on a wheel (PRTH)",
    source='"Wheel-rope friction lifting force model for the portable rope track hoist"',
    system="hoist",
    scene="climbing-hoist",
    machine=_machine,
    of="the climbing hoist that ropefric brings along",
    beside="the conditions its fit rests on, simulated",
    items=(
        Item(number="(1), Fig. 1", says="the element with its mass, and the slip angle θ of the wrap φ", where="1",
            rows=_figure_1, charts=_chart_1),
        Item(number="(2)", says="F_A/F_B = e^(μφ)", where="1", rows=_euler),
        Item(number="Fig. 3 (b)", says="repeats beyond mean ± 2s are rejected once", where="2.2", unit="N",
            rows=_example, remark="no series is printed: one of 15 forces with the printed mean and s"),
        *ITEMS,
        Item(number="(17)", says="F_A = F_B exp ∫μ dφ from φ0 to φ0 + φ", where="3.3", rows=_lift,
            remark="F_0 = 1 N is a physical reference and no free scale: (15), (16) give another force for another F_0"),
    ),
    notes=(
        "no fitted parameter and no force but those of one series are printed, and the figures have no numbers",
        "Fig. 2 shows the test bench, Fig. 3 (a) a recording, which `extract` draws for each condition",
    ),
)  # fmt: skip
