"""Ni and Wen (2015): the drive train of a belt filter press, its tensions, and which roller slips."""

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError
from ropefric.papers.paper import Item, Paper, Row, Shown, shown
from ropefric.papers.reading import Given
from ropefric.section import Line
from ropefric.systems.effect import applicable, assemble
from ropefric.systems.press.answer import PressAnswer, solve_press
from ropefric.systems.press.effects import SYSTEM
from ropefric.systems.press.machine import Press, Roller
from ropefric.systems.press.slip import PressSweep, critical
from ropefric.systems.press.statics import CLOSURES, solve_statics, steady_state
from ropefric.systems.press.transient.motion import Settled, settled_press
from ropefric.systems.press.transient.start_up import StartUp

_EFFECTS = ("gravity-load", "squeeze-load", "belt-inertia", "wrap-dependence", "size")


def _numbered(text: str) -> dict[str, str]:
    return {str(i): one for i, one in enumerate(text.split(), start=1)}


_RADII = _numbered("175 75 75 75 250 200 175 150 100 175 75 75 75")
_WRAPS = _numbered("177.6 28.1 163.3 28.1 56.7 131.8 157.0 147.2 91.1 81.4 79.6 64.1 126.1")
"""Radius [mm] and wrap [deg] of each roller."""
_GRAVITY = {"2": "26.2", "3": "26.2", "5": "15.0", "13": "4.5"}
_SQUEEZE = {"5": "84.0", "6": "33.6", "7": "29.4", "8": "25.2", "9": "16.8"}
"""Torques [N m]."""
_CONSTANT, _SMALL, _ABOVE = ("4", "11", "12"), ("1", "3", "6", "7", "8", "13"), ("2", "4")
"""Rollers whose factor is said to be constant, rather small, and above 1."""
_WATCHED = ("2", "5")


class Machine(NamedTuple):
    """A press in its steady run, the same at rest, and what it is over speeds and preloads."""

    answer: PressAnswer
    press: Press
    over_speed: PressSweep
    over_preload: PressSweep
    over_both: PressSweep
    settled: Settled | None
    moved: StartUp | None
    published: bool

    @property
    def spans(self) -> list[str]:
        """Return the names of the spans."""
        return [span.name for span in self.press.spans]

    @property
    def rollers(self) -> list[str]:
        """Return the names of the rollers."""
        return [roller.name for roller in self.press.rollers]


def _machine(given: Given) -> Machine:
    problem = given.scene.problem
    answer = solve_press(assemble(SYSTEM, replace(problem, start_up=None), _EFFECTS))
    press = answer.model.as_operated
    statics = solve_statics(press, closure=problem.closure)
    forces_N = [one.force_N for one in press.tensioners.values()]
    preloads_N = np.linspace(0.75, 2.0, 26) * (np.mean(forces_N) if forces_N else 1.0)
    speeds_m_s = np.linspace(0.0, 2.0, 41) * press.speed_m_s
    few_N = preloads_N[[0, 5, 10, 15, 25]]
    ends = None
    with suppress(RopefricError):  # the scene does not give EA, or a belt is slack at rest
        ends = settled_press(press, press.speed_m_s)

    def swept(**axes: FloatArray) -> PressSweep:
        return PressSweep(statics, problem.friction, **axes)

    over = swept(speed_m_s=speeds_m_s), swept(preload_N=preloads_N)
    both = swept(preload_N=few_N, speed_m_s=speeds_m_s)
    moved = None
    if problem.start_up is not None:  # with all effects that can be simulated
        moved = solve_press(assemble(SYSTEM, problem, applicable(SYSTEM.effects, problem))).start_up
    return Machine(answer, press, *over, both, ends, moved, given.published)


def _each(
    names: Iterable[str], values: Iterable[float], form: str, printed: dict[str, str] | None = None
) -> Iterator[Row]:
    for name, value in zip(names, np.asarray(values).ravel().tolist(), strict=True):
        yield Row(form.format(name), value, (printed or {}).get(name, ""))


def _rollers(
    value: Callable[[Roller, Press], float], form: str, printed: dict[str, str] | None = None
) -> Callable[[Machine], Iterator[Row]]:
    """Give a number of every roller that has one."""
    return lambda it: (
        Row(form.format(one.name), found, (printed or {}).get(one.name, ""))
        for one in it.press.rollers
        if (found := value(one, it.press))
    )


def _width_m(one: Roller, press: Press) -> float:
    return max(belt.width_m for belt in press.belts_on(one.name))


def _balances(it: Machine) -> Iterator[Row]:
    """Give what is left of the rollers' balances, R(T_out − T_in) − M, and what the drivers supply."""
    press, state = it.press, it.answer.state
    left_N_m = press.radius_m * (press.incidence @ state.effective_tension_N[0] - press.rim_load_N)
    for roller, left in zip(press.rollers, left_N_m.tolist(), strict=True):
        if roller.role != "driver":
            yield Row(f"R(T_out - T_in) - M of roller {roller.name}", 0.0 if abs(left) < 1e-9 else left)
    for name, torque in state.driver_torque_N_m.items():
        yield Row(f"torque of driver {name}", float(torque[0]))
    yield Row("power of all drivers [W]", float(state.drive_power_W[0]))


def _travels(it: Machine) -> Iterator[Row]:
    running_N = it.answer.state.effective_tension_N[0]
    states = ("at rest", it.answer.at_rest_N[0], "30"), ("free to move, running", running_N, "")
    for words, tension_N, printed in states:
        pulls_N = it.press.pull @ tension_N
        for (name, one), pull_N in zip(it.press.tensioners.items(), pulls_N.tolist(), strict=True):
            if one.spring_N_m:
                travel_m = (pull_N - one.force_N) / one.spring_N_m
                yield Row(f"x of roller {name}, {words}", 1e3 * travel_m, printed)


def _open(it: Machine) -> Iterator[Row]:
    statics = it.answer.statics
    yield Row("tensions", float(len(it.spans)))
    yield Row("independent balances", float(statics.rank))
    for closure in CLOSURES:
        try:
            state = steady_state(solve_statics(it.press, closure=closure), speed_m_s=0.0, on_slack="flag")
        except RopefricError:  # speed-ratio needs what the scene does not give
            continue
        for name in ("9", "10") if it.published else ():
            yield Row(f"T{name} by the closure '{closure}'", float(state.tension_N[it.spans.index(name)]))


def _settled(it: Machine) -> Iterator[Row]:
    if it.settled is None:
        yield Row(
            "relative angles", None, remark="the scene does not give EA and span lengths; nor does the paper"
        )
        return
    angles = it.settled.relative_way_m / it.press.radius_m
    yield from _each(it.rollers, angles, "angle of roller {} relative to the first driver [rad]")
    yield from _each(it.press.tensioners, it.settled.travel_m, "travel of roller {} [m]")


def _factors(it: Machine) -> Iterator[Row]:
    slip = it.answer.slip
    yield from _each(slip.rollers, slip.as_printed[0], "Λ* of roller {} as printed")
    yield from _each(slip.rollers, slip.as_plotted[0], "Λ* of roller {} inverted")
    yield from _each(slip.rollers, slip.utilisation[0], "utilisation of roller {}")


def _in_motion(it: Machine) -> Iterator[Row]:
    if it.moved is not None:
        for name, value in it.moved.summary()["peak_as_printed"].items():
            yield Row(f"largest Λ of roller {name} over the start-up", value)


def _critical(it: Machine) -> Iterator[Row]:
    problem = it.answer.model.problem
    statics = solve_statics(it.press, closure=problem.closure)
    for change, words in (("friction", "coefficient"), ("preload", "preload [N]")):
        found = critical(statics, problem.friction, change, told=it.answer.model.told)
        if found.value is not None:
            yield Row(f"{words} at which roller {found.roller} slips first", found.value)


def _steps(values: FloatArray) -> tuple[FloatArray, float]:
    """Return by how much values change from one to the next, and what is no change."""
    return np.diff(np.ravel(values)), 1e-12 * float(np.abs(values).max())


def _falls(values: FloatArray) -> bool:
    steps, least = _steps(values)
    return bool((steps < -least).all())


def _constant(values: FloatArray) -> bool:
    steps, least = _steps(values)
    return bool((np.abs(steps) <= 1e3 * least).all())


def _figure_4(it: Machine) -> Iterator[Row]:
    tension_N = it.over_speed.effective_tension_N[0]
    fall = float((1.0 - tension_N[-1] / tension_N[0]).max())
    yield Row("largest fall of T' from rest to twice the speed [%]", 100.0 * fall)
    if it.published:
        both = [it.spans.index(name) for name in ("5", "6", "7", "8")]
        others = [i for i in range(len(it.spans)) if i not in both]
        alike = [it.spans.index(name) for name in ("11", "12", "13")]
        yield Row(
            "T'5 to T'8 are the largest", bool(tension_N[:, both].min() > tension_N[:, others].max()), "yes"
        )
        yield Row("T'3 = T'4", bool(np.allclose(tension_N[:, 2], tension_N[:, 3], rtol=1e-12)), "yes")
        yield Row("T'11 = T'12 = T'13", bool(np.ptp(tension_N[:, alike], axis=1).max() < 1e-9), "yes")
        yield Row("every T' falls with the speed", all(map(_falls, tension_N.T)), "yes")


_INVERTED = "the inverted ratio does, which the figures must show"


def _said(it: Machine, of: str, holds: Callable[[str], bool]) -> Iterator[Row]:
    """Give whether a statement on figures holds for the ratio as printed, and for its inverse."""
    if it.published:
        yield Row(f"{of}: as printed", holds("as_printed"), "yes", _INVERTED)
        yield Row(f"{of}: inverted", holds("as_plotted"), "yes")


def _figure_5(it: Machine) -> Iterator[Row]:
    slip = it.over_speed.slip

    def above(measure: str) -> bool:
        return {name for name in it.rollers if (slip.of(name, measure) > 1.0).any()} == set(_ABOVE)

    def constant(measure: str) -> bool:
        return all(_constant(slip.of(name, measure)) for name in _CONSTANT)

    def small(measure: str) -> bool:
        named = max(slip.of(name, measure).max() for name in _SMALL)
        others = min(slip.of(name, measure).min() for name in it.rollers if name not in {*_SMALL, "9", "10"})
        return bool(named < others)

    yield from _said(it, "only rollers 2 and 4 are above 1", above)
    yield from _said(it, "rollers 4, 11 and 12 are constant", constant)
    yield from _said(it, "rollers 1, 3, 6, 7, 8, 13 are below 2, 4, 5, 11, 12", small)


def _figure_6(it: Machine) -> Iterator[Row]:
    slip = it.over_preload.slip

    def falls(measure: str) -> bool:
        return all(_falls(slip.of(name, measure)) for name in _WATCHED)

    yield from _said(it, "rollers 2 and 5 fall as the preload rises", falls)


def _figure_7(it: Machine) -> Iterator[Row]:
    slip = it.over_both.slip

    def rises(measure: str) -> bool:
        return all(_falls(-row) for name in _WATCHED for row in slip.of(name, measure))

    def weaker(measure: str) -> bool:
        spread = [slip.of(name, measure) for name in _WATCHED]
        return all(float(np.ptp(one, axis=1).max()) < float(np.ptp(one, axis=0).min()) for one in spread)

    yield from _said(it, "rollers 2 and 5 rise with the speed", rises)
    yield from _said(it, "the preload matters more than the speed", weaker)


_SPEED = ("driver_rpm", "Speed of the first driver n [1/min]")
_PRELOAD = ("preload_N", "Preload of the tensioners F [N]")
_TENSION, _FACTOR = ("effective_tension_N", "T' [N]"), ("slip_factor", "Slip factor Λ, inverted ratio [-]")


def _lines(names: Iterable[str], x: FloatArray, values: FloatArray, form: str) -> list[Line]:
    return [Line(form.format(name), x, line) for name, line in zip(names, values.T, strict=True)]


def _charts(number: int) -> Callable[[Machine], Iterator[Shown]]:
    def charts(it: Machine) -> Iterator[Shown]:
        rpm = it.over_speed.speed_m_s / it.press.drivers[0].radius_m * 30.0 / math.pi
        over_F, factor = it.over_preload, "Slip factor of every roller"
        if number == 4:
            lines = _lines(it.spans, rpm, it.over_speed.effective_tension_N[0], "T'{}")
            yield shown("figure_4", "Steady tensions over the speed", _SPEED, _TENSION, lines)
        elif number == 5:
            lines = _lines(it.rollers, rpm, it.over_speed.slip.as_plotted[0], "roller {}")
            yield shown("figure_5", f"{factor} over the speed", _SPEED, _FACTOR, lines)
        elif number == 6:
            lines = _lines(it.rollers, over_F.preload_N, over_F.slip.as_plotted[:, 0], "roller {}")
            yield shown("figure_6", f"{factor} over the preload", _PRELOAD, _FACTOR, lines)
        else:
            forces = [f"{F:.4g}" for F in it.over_both.preload_N]
            for name in _WATCHED if it.published else it.rollers:
                lines = _lines(forces, rpm, it.over_both.slip.of(name, "as_plotted").T, "F = {} N")
                yield shown(f"figure_7_{name}", f"Slip factor of roller {name}", _SPEED, _FACTOR, lines)

    return charts


PAPER = Paper(
    title="The drive of a belt filter press, and which roller slips",
    source="Ni B., Wen Z.: Model construction of drive system of belt filter press and filter belt slipping analysis, "
    "Journal of Hunan University of Science and Technology (Natural Science) 30 (2), 2015",
    system="press",
    scene="belt-press",
    machine=_machine,
    items=(
        Item(number="Table 1, R", says="radius R_i", where="4", unit="mm", given=True,
            rows=_rollers(lambda one, _: 1e3 * one.radius_m, "R of roller {}", _RADII)),
        Item(number="Table 1, α", says="wrap α_i", where="4", unit="deg", given=True,
            rows=_rollers(lambda one, _: math.degrees(one.wrap_angle_rad), "α of roller {}", _WRAPS)),
        Item(number="(1)-(5)", says="T_G = μ_f b h ρ_s g l", where="1.1", unit="N",
            rows=_rollers(lambda one, _: one.gravity_torque_N_m / one.radius_m, "T_G of roller {} = M_G/R"),
            remark="h is the sludge's height here and the belt's thickness in section 4; only the pull is known"),
        Item(number="(6)", says="M_G = R T_G", where="1.1", unit="N m", given=True,
            rows=_rollers(lambda one, _: one.gravity_torque_N_m, "M_G of roller {}", _GRAVITY)),
        Item(number="(7), (8)", says="K_max = (1 + μ_c) σ_c²/(3 E_c)", where="1.1", unit="N/m",
            rows=_rollers(lambda one, press: one.squeeze_torque_N_m / (_width_m(one, press) * one.radius_m),
                "Δh K_max of roller {} = M_F/(bR)"),
            remark="Δh and K_max are known as a product only; roller 5 carries two units, wedge and press"),
        Item(number="(9)", says="M_F = b R Δh K_max", where="1.1", unit="N m", given=True,
            rows=_rollers(lambda one, _: one.squeeze_torque_N_m, "M_F of roller {}", _SQUEEZE)),
        Item(number="(10)-(20), (23)-(32)", says="J θ'' = R(T_out - T_in) - M, steady: θ'' = 0", where="1.2, 1.3, 2",
            unit="N m", rows=_balances,
            remark="(19), (20), (24) and (30) print M_F3 and M_F13 where M_G3 and M_G13 are meant"),
        Item(number="(21), (22), (33), (34)", says="k_1 x = T'_2 + T'_3 cos β - F", where="1.4, 2", unit="mm",
            rows=_travels),
        Item(number="(23)-(34) as a whole", says="what the balances leave open", where="2", unit="N", rows=_open,
            remark="they are 13 for 14 tensions: only T9 + T10 follows, and the paper does not say what it took; "
            "rollers 1 and 10 depend on it, the others do not"),
        Item(number="(35), (36)", says="the tensions at v = 0", where="2", unit="N",
            rows=lambda it: _each(it.spans, it.answer.at_rest_N[0], "T{}")),
        Item(number="after (36)", says="steady angles relative to roller 1, and travels", where="2", rows=_settled,
            remark="of belts that stick from standstill on; the paper integrates until nothing changes, which with its "
            "damping alone takes hours"),
        Item(number="(37)", says="Λ_i = (T'_(i-1) + ρAR²θ''/μ)/((T'_i + ρAR²θ''/μ)(e^(μα) - 1))", where="3",
            rows=_in_motion,
            remark="at steady speed it is (38); a scene with [start_up] has it over time, in start_up.csv of `solve`; "
            "the sign of the added term is that of a driven roller"),
        Item(number="(38)", says="Λ_i = T'_(i-1)/(T'_i (e^(μα) - 1))", where="3", rows=_factors,
            remark="as printed it is not 1 at gross slip and not 0 on a roller without torque; its indices are literal "
            "for rollers 2 to 9 only"),
        Item(number="what it comes to", says="the limit of friction", where="4.2", rows=_critical,
            remark="by the utilisation, required over available friction"),
        Item(number="(39)", says="T' = T - ρAv²", where="4.1", unit="N",
            rows=lambda it: _each(it.spans, it.answer.state.effective_tension_N[0], "T'{}"),
            remark="it holds for each belt: where two run together T' = T - 2ρAv²; it is the limit of tensioners that "
            "keep their place"),
        Item(number="Fig. 4", says="steady tensions over the speed", where="4.1", rows=_figure_4, charts=_charts(4)),
        Item(number="Fig. 5", says="slip factors over the speed", where="4.2", rows=_figure_5, charts=_charts(5)),
        Item(number="Fig. 6", says="slip factors over the preload", where="4.2", rows=_figure_6, charts=_charts(6)),
        Item(number="Fig. 7", says="slip factors over preload and speed", where="4.2", rows=_figure_7,
            charts=_charts(7)),
    ),
    notes=(
        "radii, wraps and torques of the published machine are given as printed",
        "the figures are known by what the text says of them; their numbers are not printed",
    ),
)  # fmt: skip
