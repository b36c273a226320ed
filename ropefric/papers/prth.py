"""The rope-wheel friction of a portable rope track hoist (PRTH): the paper's equations, and its reduction of trials."""

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError
from ropefric.fitting.fit import fit_law
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import SETTINGS, Conditions, condition_groups, levels
from ropefric.friction.law import FrictionLaw
from ropefric.papers.paper import Given, Item, Paper, Row, Shown
from ropefric.scenes.kind import Chart, Line
from ropefric.systems.effect import assemble
from ropefric.systems.hoist.contact import Lift, solve_lift, tension_along_N
from ropefric.systems.hoist.effects import SYSTEM
from ropefric.trials.outliers import RULES, scaled
from ropefric.trials.table import TrialTable

_EXAMPLE_N = (335.7, *(320.7 + sign * 3.9051248 for sign in (-1.0, 1.0) for _ in range(7)))
"""Fifteen forces with the printed mean and standard deviation, one of them beyond two of these."""
_STEPS = 61
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


class Reduction(NamedTuple):
    """What the paper's experiment makes of trials: a series over each setting, and the laws it puts beside them.

    `sizes` are the laws (3) and (4) of the series of wheels, `wraps` the laws (14) and (15) of all trials on the wheel
    whose wrap was varied, `both` is the law (16) of all trials; forces are over F_0.
    """

    series: dict[str, Series]
    sizes: tuple[FitResult, ...]
    wraps: tuple[FitResult, ...]
    both: FitResult | None


def reduce_trials(trials: TrialTable) -> Reduction:
    """Return what the paper's own reduction makes of trials."""
    found = {over: one for over in _OVER if (one := _series(trials, over)) is not None}
    sizes: tuple[FitResult, ...] = ()
    wraps: tuple[FitResult, ...] = ()
    if "wheel_radius_m" in found:
        sizes = _fitted(found["wheel_radius_m"].trials, "size-power", "size-exponential")
    if "wrap_angle_rad" in found:
        own = found["wrap_angle_rad"].at
        wheel = np.isclose(trials.wheel_radius_m, own.wheel_radius_m[0], rtol=1e-6)
        rope = np.isclose(trials.rope_radius_m, own.rope_radius_m[0], rtol=1e-6)
        wraps = _fitted(replace(trials, kept=trials.kept & wheel & rope), "wrap-exponential", "wrap-power")
    return Reduction(found, sizes, wraps, next(iter(_fitted(trials, "coupled")), None))


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
    others = condition_groups(*(getattr(at, name) for name in SETTINGS if name != over))
    along = levels(getattr(at, over))
    counts = [np.unique(along[others == group]).size for group in range(int(others.max()) + 1)]
    if max(counts) < 3:
        return None
    chosen = np.flatnonzero(others == int(np.argmax(counts)))
    places = [chosen[along[chosen] == level] for level in np.unique(along[chosen])]
    kept = np.zeros(len(trials), dtype=np.bool_)
    kept[used[chosen]] = True
    n = np.array([rows.size for rows in places])
    squares = sum(float(((log_lift[rows] - log_lift[rows].mean()) ** 2).sum()) for rows in places)
    within = math.sqrt(squares / (n.sum() - n.size)) if n.sum() > n.size else math.nan
    return Series(
        over=over,
        at=at.select([rows[0] for rows in places]),
        log_lift=np.array([log_lift[rows].mean() for rows in places]),
        std=within / np.sqrt(n),
        trials=replace(trials, kept=kept),
    )


class Segments(NamedTuple):
    """The wrap cut where it was measured, eqs. (5)-(10): ends, ln F there, and the coefficient of each piece."""

    ends_rad: FloatArray
    log_force: FloatArray
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
    return Segments(ends, force, np.diff(force) / np.diff(ends), np.hypot(std[1:], std[:-1]) / np.diff(ends))


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
    model = assemble(
        SYSTEM, problem, [name for name, one in SYSTEM.effects.items() if not one.needs(problem)]
    )
    lift = solve_lift(model)
    assert source is not None  # noqa: S101  (a hoist's schema asks for friction)
    trials = given.trials
    if trials is None and source.fit is not None:
        trials = _means(source.fit)
    if trials is not None and given.reference_N != 1.0:
        forces = (
            "end_tension_N",
            "peak_N",
            "peak_std_N",
            "end_tension_std_N",
            "cell_std_N",
            "end_tension_set_N",
        )
        trials = replace(trials, **{name: getattr(trials, name) / given.reference_N for name in forces})
    return Machine(
        lift=lift,
        law=source.friction.law,
        theta=source.friction.theta,
        at=Conditions(**{name: getattr(problem, name)[:1] for name in SETTINGS}),
        reference_N=given.reference_N,
        reduction=None if trials is None else reduce_trials(trials),
    )


def _means(fit: FitResult) -> TrialTable:
    """Return the conditions that a stored fit rests on as trials, each by its mean."""
    columns: dict[str, Any] = {name: np.asarray(fit.trials[name]) for name in SETTINGS}
    peak_N = np.exp(fit.trials["mean_log_lift"])
    return TrialTable(trial=tuple(f"condition {i + 1}" for i in range(len(peak_N))), peak_N=peak_N, **columns)


def log_lift(law: FrictionLaw, theta: FloatArray, at: Conditions, reference_N: float = 1.0) -> FloatArray:
    """Return ln F_A where ∫μ dφ over φ0 is ln(F_B/F_0), eqs. (11), (17), for any F_0: forces are counted in it."""
    over = replace(at, end_tension_N=at.end_tension_N / reference_N)
    return law.log_lift(theta, over) + math.log(reference_N)


def bracket_of_16(theta: FloatArray) -> tuple[float, float]:
    """Return μ_inf and b of μ_R = μ_inf (1 − e^(a r)) + b, as (16) prints it, from those in the bracket of (4)."""
    mu_inf, _, b = theta[:3]
    return float(mu_inf * np.exp(b)), float(-mu_inf * np.expm1(b))


def _example(_: Machine) -> Iterator[Row]:
    values = np.array(_EXAMPLE_N)
    kept = values[~RULES["two-sigma"].flag(values)]
    yield Row("mean F_A of a series of 15", scaled(values).mean(), "321.7")
    yield Row("s", scaled(values).std(), "5.5")
    yield Row("mean after one pass of ±2s", scaled(kept).mean(), "320.7")


def _euler(it: Machine) -> Iterator[Row]:
    yield Row("F_B [N]", float(it.lift.end_tension_N[0]))
    yield Row("F_A [N], eq. (17) with all effects of the scene", float(it.lift.lift_force_N[0]))
    yield Row("F_A/F_B", float(it.lift.lift_force_N[0] / it.lift.end_tension_N[0]))
    yield Row("average μ = ln(F_A/F_B)/φ over the contact", float(it.lift.average_mu[0]))


def _figure_1(it: Machine) -> Iterator[Row]:
    problem = it.lift.model.problem
    yield Row("centrifugal part ρω²r² [N]", float(problem.circling_N[0]))
    yield Row("wrap φ in contact [deg]", math.degrees(it.lift.contact_rad[0]))
    if it.lift.arcs is None:
        yield Row(
            "slip θ and stick φ - θ [deg]", None, remark="θ = φ at the lift force; a payload asks for less"
        )
        return
    for name, arc in it.lift.arcs._asdict().items():
        yield Row(f"{name[:-4]} arc under the payload [deg]", math.degrees(arc[0]))


def _parameters(
    fits: Callable[[Reduction], Iterable[FitResult | None]],
) -> Callable[[Machine], Iterator[Row]]:
    def rows(it: Machine) -> Iterator[Row]:
        if it.reduction is None:
            return
        for fit in fits(it.reduction):
            if fit is None:
                continue
            for one in fit.parameters:
                yield Row(f"{one.name} of {fit.law}", one.value, remark=f"± {one.std:.2g}")
            if fit.law == "coupled":
                for name, value in zip(("μ_inf", "b"), bracket_of_16(fit.theta), strict=True):
                    yield Row(f"{name} in the bracket of (16) as printed", value)

    return rows


def _equation(*numbers: str) -> Callable[[Reduction], Iterable[FitResult | None]]:
    return lambda found: [
        fit for fit in (*found.sizes, *found.wraps, found.both) if fit is not None and fit.law in numbers
    ]


def _segments(it: Machine) -> Iterator[Row]:
    wraps = it.reduction and it.reduction.series.get("wrap_angle_rad")
    if not wraps:
        yield Row("segments", None, remark="no three wraps on one wheel under one end tension were tested")
        return
    cut = segments(wraps)
    for start, end, mu, std in zip(
        *np.degrees((cut.ends_rad[:-1], cut.ends_rad[1:])), cut.mu, cut.std, strict=True
    ):
        yield Row(
            f"μ from {start:.4g} to {end:.4g} deg", float(mu), remark=f"± {std:.2g}" if std > 0.0 else ""
        )
    widths = np.diff(cut.ends_rad)
    yield Row("(7), (9): Σ μ_m φ_m / φ", float(cut.mu @ widths / widths.sum()))
    yield Row(
        "(8), (10): equal weights",
        float(cut.mu.mean()),
        remark="" if np.ptp(widths) < 1e-9 else "parts not equal",
    )
    yield Row("ln(F_A/F_B)/φ over it all", float(wraps.average_mu[-1]))


def _local(it: Machine) -> Iterator[Row]:
    wraps = it.reduction and it.reduction.series.get("wrap_angle_rad")
    if not wraps or it.reduction is None:
        return
    cut = segments(wraps)
    for fit in it.reduction.wraps:
        local = fit.friction_law.local_mu(
            fit.theta, cut.middle_rad, wraps.at.select(np.zeros(len(cut.mu), np.int64))
        )
        for middle, mu, own in zip(np.degrees(cut.middle_rad), local, cut.mu, strict=True):
            yield Row(f"μ({middle:.4g} deg) by {fit.law}", float(mu), remark=f"measured {own:.4g}")


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


_RATIO, _MU = ("ratio", "F_A/F_B [-]"), ("mu_average", "Average coefficient μ [-]")


def _panels(over: str) -> Callable[[Machine], Iterator[Shown]]:
    def charts(it: Machine) -> Iterator[Shown]:
        found = it.reduction and it.reduction.series.get(over)
        if found:
            yield from panels(found)

    return charts


def panels(found: Series) -> Iterator[Shown]:
    """Yield the two panels of Figs 4 to 6: coefficient and ratio of the forces over what was varied."""
    number, words, unit, _ = _OVER[found.over]
    across = (found.over, f"{words[:1].upper()}{words[1:]} [{unit}]")
    ratio = np.exp(found.log_lift - found.at.log_end_tension)
    for (column, label), values in ((_MU, found.average_mu), (_RATIO, ratio)):
        line = Line("measured", found.x, values, points=True)
        yield Shown(f"figure_{number}_{column}", Chart(f"{label.rpartition(' [')[0]} over the {words}", *across,
            column, label, (line,)))  # fmt: skip


def _along(found: Series, fit: FitResult) -> tuple[FloatArray, FloatArray, Conditions]:
    """Return fine steps over a series, in the unit of its figure, ln F_A by a law, and the conditions."""
    values = getattr(found.at, found.over)
    fine = np.linspace(values[0], values[-1], _STEPS)
    one = {name: np.full(_STEPS, getattr(found.at, name)[0]) for name in SETTINGS}
    at = Conditions(**one | {found.over: fine})
    return fine * _OVER[found.over][3], fit.friction_law.log_lift(fit.theta, at), at


def size_chart(found: Reduction) -> Iterator[Shown]:
    """Yield Fig. 7: average coefficient over R_w/R_r, measured and by both laws, whichever is the better."""
    series = found.series.get("wheel_radius_m")
    if series is None:
        return
    lines = [Line("measured", series.at.size_ratio, series.average_mu, points=True)]
    for fit in found.sizes:
        _, log, at = _along(series, fit)
        lines.append(Line(_NAMES[fit.law], at.size_ratio, (log - at.log_end_tension) / at.wrap_angle_rad))
    yield Shown(
        "figure_7",
        Chart("Size effect: measured, and both laws", "size_ratio", "R_w/R_r [-]", *_MU, tuple(lines)),
    )


def wrap_charts(found: Reduction) -> Iterator[Shown]:
    """Yield Fig. 8: ln F_A over the wrap and its derivative, measured and by both laws."""
    series = found.series.get("wrap_angle_rad")
    if series is None:
        return
    cut = segments(series)
    forces = [Line("measured", series.x, series.log_lift, points=True)]
    local = [Line("measured, piece by piece", np.degrees(cut.middle_rad), cut.mu, points=True)]
    for fit in found.wraps:
        x, log, at = _along(series, fit)
        forces.append(Line(_NAMES[fit.law], x, log))
        local.append(Line(_NAMES[fit.law], x, fit.friction_law.local_mu(fit.theta, at.wrap_angle_rad, at)))
    across = ("wrap_angle_deg", "Wrap φ [deg]")
    yield Shown("figure_8_log_lift", Chart("Wrap: measured ln F_A, and both laws", *across, "log_lift", "ln F_A [-]",
        tuple(forces)))  # fmt: skip
    yield Shown(
        "figure_8_mu",
        Chart("Wrap: local coefficient, eq. (13)", *across, "mu_local", "μ(φ) [-]", tuple(local)),
    )


def _figure_9(it: Machine) -> Iterator[Shown]:
    fit = it.reduction and it.reduction.both
    series = it.reduction and it.reduction.series.get("wheel_radius_m")
    if not fit or not series:
        return
    wrap_rad, lines = np.radians(np.linspace(20.0, 1080.0, _STEPS)), []
    for radius_m in series.at.wheel_radius_m:
        at = Conditions(wheel_radius_m=np.full(_STEPS, radius_m), rope_radius_m=series.at.rope_radius_m[:1],
            wrap_angle_rad=wrap_rad, end_tension_N=np.ones(1))  # fmt: skip
        mu = fit.friction_law.local_mu(fit.theta, wrap_rad, at)
        lines.append(Line(f"R_w = {1e3 * radius_m:.4g} mm", np.degrees(wrap_rad), mu))
    yield Shown("figure_9", Chart("Wheel and wrap together, eq. (16), from F_0 on", "wrap_angle_deg", "φ [deg]", "mu_local",
        "μ(φ) [-]", tuple(lines)))  # fmt: skip


def _chart_1(it: Machine) -> Iterator[Shown]:
    arcs = it.lift.arcs
    if arcs is None or not np.isfinite(arcs.slip_rad).all():
        return
    ends = np.cumsum([0.0, arcs.slip_rad[0], arcs.stick_rad[0]])
    lines = tuple(
        Line(name, np.degrees(angle), tension_along_N(it.lift, angle))
        for name, start, end in (("slips", 0, 1), ("sticks", 1, 2))
        for angle in [np.linspace(ends[start], ends[end], _STEPS)]
    )
    yield Shown("figure_1", Chart("Tension along the rope on the turning wheel, under the payload", "wrap_angle_deg",
        "Angle from the slack side [deg]", "tension_N", "Tension F [N]", lines))  # fmt: skip


_NAMES = {
    "size-power": "(3), size-power",
    "size-exponential": "(4), size-exponential",
    "wrap-exponential": "(14), wrap-exponential",
    "wrap-power": "(15), wrap-power",
}


def _off(fit: FitResult, at: Conditions, log_lift: FloatArray) -> float:
    """Return the root mean square of ln F_A by which a law misses conditions."""
    return float(np.sqrt(np.mean((fit.friction_law.log_lift(fit.theta, at) - log_lift) ** 2)))


def _both_laws(over: str) -> Callable[[Machine], Iterator[Row]]:
    """Give by how much both laws of a figure miss its points."""

    def rows(it: Machine) -> Iterator[Row]:
        found = it.reduction and it.reduction.series.get(over)
        if not found or it.reduction is None:
            return
        for fit in it.reduction.sizes if over == "wheel_radius_m" else it.reduction.wraps:
            yield Row(f"rms miss of ln F_A by {_NAMES[fit.law]}", _off(fit, found.at, found.log_lift))

    return rows


def _points(over: str) -> Callable[[Machine], Iterator[Row]]:
    def rows(it: Machine) -> Iterator[Row]:
        found = it.reduction and it.reduction.series.get(over)
        if not found:
            yield Row(f"over the {_OVER[over][1]}", None, remark="not varied by itself over three values")
            return
        for x, mu, rise in zip(
            found.x, found.average_mu, found.log_lift - found.at.log_end_tension, strict=True
        ):
            ratio = f"F_A/F_B = {math.exp(rise):.4g}"
            yield Row(f"μ at {x:.4g} {_OVER[over][2]}", float(mu), remark=ratio)

    return rows


PAPER = Paper(
    title="The lift force of a rope on a wheel (PRTH)",
    source='"Wheel-rope friction lifting force model for the portable rope track hoist"',
    system="hoist",
    scene="climbing-hoist",
    machine=_machine,
    of="the climbing hoist and the simulated trials that ropefric brings along",
    items=(
        Item(number="(1), Fig. 1", says="the element with its mass, and the slip angle θ of the wrap φ", where="1",
            rows=_figure_1, charts=_chart_1),
        Item(number="(2)", says="F_A/F_B = e^(μφ)", where="1", rows=_euler),
        Item(number="Fig. 3 (b)", says="repeats beyond mean ± 2s are rejected once", where="2.2", unit="N", rows=_example,
            remark="no series is printed: one of 15 forces with the printed mean and s"),
        *(
            Item(number=f"Fig. {number}", says=f"coefficient and ratio of forces over the {words}", where="3",
                rows=_points(over), charts=_panels(over))
            for over, (number, words, _, _) in _OVER.items()
        ),
        Item(number="(3)", says="μ = μ_inf (R_w/(R_r + R_w))^a + b", where="3.1",
            rows=_parameters(_equation("size-power"))),
        Item(number="(4)", says="μ = μ_inf (1 - e^(a R_w/R_r + b))", where="3.1",
            rows=_parameters(_equation("size-exponential"))),
        Item(number="Fig. 7", says="both laws of size beside the trials", where="3.1", rows=_both_laws("wheel_radius_m"),
            charts=lambda it: size_chart(it.reduction) if it.reduction else (),
            remark="the paper finds (4) the better of the two"),
        Item(number="(5)-(10)", says="ln F_j - ln F_i = Σ μ_m φ_m", where="3.2", rows=_segments,
            remark="(8) and (10) weigh the pieces equally, which is right for equal pieces only"),
        Item(number="(11)-(13)", says="∫μ dφ = ln F - ln F_0, μ(φ) = d ln F/dφ", where="3.2", rows=_local,
            remark="the law through the integral beside the differences of the trials, whose noise is amplified"),
        Item(number="(14)", says="μ(φ) = a e^(bφ) + c", where="3.2", rows=_parameters(_equation("wrap-exponential"))),
        Item(number="(15)", says="μ(φ) = a φ^b + c", where="3.2", rows=_parameters(_equation("wrap-power")),
            remark="the paper's choice; a wrap series under one end tension cannot tell its parameters apart, so all "
            "end tensions on that wheel are taken"),
        Item(number="Fig. 8", says="both laws of wrap beside the trials", where="3.2", rows=_both_laws("wrap_angle_rad"),
            charts=lambda it: wrap_charts(it.reduction) if it.reduction else ()),
        Item(number="(16)", says="μ(φ) = μ_R φ^c + d, μ_R = μ_inf (1 - e^(a r)) + b", where="3.3",
            rows=_parameters(_equation("coupled")),
            remark="its bracket is not that of (4), which `coupled` has; both are one family, A - B e^(a r)"),
        Item(number="Fig. 9", says="wheel and wrap together", where="3.3", charts=_figure_9),
        Item(number="(17)", says="F_A = F_B exp ∫μ dφ from φ0 to φ0 + φ", where="3.3", rows=_lift,
            remark="F_0 = 1 N is a physical reference and no free scale: (15), (16) give another force for another F_0"),
    ),
    notes=(
        "no fitted parameter and no force but those of one series are printed, and the figures have no numbers",
        "Fig. 2 shows the test bench, Fig. 3 (a) a recording, which `extract` draws for each condition",
    ),
)  # fmt: skip
