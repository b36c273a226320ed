"""The rope-wheel friction of a portable rope track hoist (PRTH): the paper's equations, for a hoist and its trials."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from ropefric.arrays import FloatArray
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.papers.paper import Item, Paper, Row, Shown, shown
from ropefric.papers.reading import Given
from ropefric.papers.reduction import ITEMS, STEPS, Reduction, reduce_trials
from ropefric.section import Line
from ropefric.systems.effect import applicable, assemble
from ropefric.systems.hoist.contact import Lift, solve_lift, tension_along_N
from ropefric.systems.hoist.effects import SYSTEM
from ropefric.trials.outliers import RULES, scaled
from ropefric.trials.table import TrialTable

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
