"""Wang and Jiang (2010): the band-saw blade as a string of travelling waves."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.papers.paper import Given, Item, Paper, Row, Shown, shown
from ropefric.section import Line
from ropefric.systems.bandsaw.answer import SawProblem, feed_limit_N, torsion_frequencies_Hz
from ropefric.systems.bandsaw.measured import deviation, explain_mounting
from ropefric.systems.bandsaw.saw import MODELS, Saw, Side, span_of
from ropefric.systems.bandsaw.span import Span, Waves, string_frequencies_Hz, travelling_waves

_RUNNING = (Side.TIGHT, Side.SLACK)
_MODES = 6
_PRINTED = {
    ("1", Side.REST, "rest"): "23.6 47.2 70.8 94.5 118.1 141.7",
    ("2", Side.TIGHT, "tensioned"): "24.0 48.0 72.0 96.0 120.0 144.0",
    ("2", Side.SLACK, "tensioned"): "23.3 46.6 69.9 93.2 116.6 139.8",
    ("2", Side.TIGHT, "running"): "19.0 38.0 57.0 76.0 95.0 114.0",
    ("2", Side.SLACK, "running"): "17.9 35.8 53.7 71.6 89.5 107.4",
    ("3", Side.TIGHT, "tensioned"): "26.5 53.0 79.5 106.0 132.5 159.0",
    ("3", Side.SLACK, "tensioned"): "25.8 51.6 77.4 103.2 129.0 154.8",
    ("3", Side.TIGHT, "running"): "21.8 43.6 65.4 87.2 108.0 130.8",
    ("3", Side.SLACK, "running"): "21.0 42.0 63.0 84.0 105.0 126.0",
}
"""Tables 1 to 3 by table, side and state: the first six modes [Hz]."""
_CUT, _MISPRINT = "cut off, not rounded", "misprint: the printed speeds give 18.87"
_MISPRINTS = {
    ("2", Side.SLACK, "tensioned", 5): "misprint for 116.5, which is 5 × 23.3",
    ("2", Side.TIGHT, "running", 1): _MISPRINT,
    ("3", Side.TIGHT, "running", 5): "misprint for 109.0, which is 5 × 21.8",
}


class Machine(NamedTuple):
    """A saw as a string: between fixed axles (κ = 0) and under a constant force (κ = 1)."""

    problem: SawProblem
    by_table: dict[str, Saw]

    def span(self, side: Side, table: str = "2", *, runs: bool = True) -> Span:
        """Return a side with the tensions of work, running or held still."""
        span = span_of(self.by_table[table], side)
        return span if runs else replace(span, travel_speed_m_s=np.zeros(1))

    def modes_Hz(self, side: Side, table: str = "2", *, runs: bool = True, n: int = _MODES) -> FloatArray:
        """Return the frequencies of a side."""
        return np.asarray(string_frequencies_Hz(self.span(side, table, runs=runs), n)[0])

    def waves(
        self, side: Side, mode: int, times: FloatArray, *, runs: bool = True
    ) -> tuple[FloatArray, Waves]:
        """Return places on a side [m], and the two waves there at shares of a period."""
        span = self.span(side, runs=runs)
        place_m = np.linspace(0.0, span.free_span_m[0], 161)
        period_s = 1.0 / self.modes_Hz(side, runs=runs, n=mode)[-1]
        return place_m, travelling_waves(span, mode, place_m, times * period_s)


def _machine(given: Given) -> Machine:
    problem: SawProblem = given.scene.problem
    saw = problem.saw
    if saw is None:
        fix = "give the scene a [wheel] with its speed"
        raise InputError("the paper's saw has wheels", code="RF121", key="--scene", fix=fix)
    string = replace(saw, bending_stiffness_N_m2=0.0)
    fixed, free = (replace(string, mounting_factor=kappa) for kappa in (0.0, 1.0))
    return Machine(problem, {"1": string, "2": fixed, "3": free})


def _both_sides(
    what: str, table: str, printed: tuple[str, str], remarks: tuple[str, str] = ("", "")
) -> Callable[[Machine], Iterator[Row]]:
    """Give the wave speed or the first frequency of both running sides."""

    def rows(it: Machine) -> Iterator[Row]:
        for side, text, remark in zip(_RUNNING, printed, remarks, strict=True):
            value = it.span(side, table).wave_speed_m_s[0] if what == "c" else it.modes_Hz(side, table)[0]
            yield Row(f"{what}, {side} side", value, text, remark)

    return rows


def _table(table: str) -> Callable[[Machine], Iterator[Row]]:
    def rows(it: Machine) -> Iterator[Row]:
        for (own, side, state), text in _PRINTED.items():
            if own == table:
                first, found = text.split()[0], it.modes_Hz(side, table, runs=state == "running")
                for mode, (value, shown) in enumerate(zip(found, text.split(), strict=True), start=1):
                    remark = _CUT if table == "1" else f"{mode} × the rounded {first}"
                    if mode == 1:
                        remark = "with the printed 761 N" if table == "3" else _CUT
                    remark = _MISPRINTS.get((table, side, state, mode), remark)
                    name = "at rest" if side is Side.REST else f"{side}, {state}"
                    yield Row(f"{name}, mode {mode}", value, shown, remark)

    return rows


def _ends(it: Machine) -> Iterator[Row]:
    _, waves = it.waves(Side.REST, 1, np.linspace(0.0, 1.0, 8))
    for end, name in ((0, "x = 0"), (-1, "x = l")):
        yield Row(f"largest |f1 + f2| at {name}", abs(waves.mode[:, end]).max())
    yield Row("largest |f1 + f2| anywhere", abs(waves.mode).max())


def _period(it: Machine) -> Iterator[Row]:
    span = it.span(Side.REST)
    length_m = 2.0 * span.free_span_m[0]
    here, there = (
        travelling_waves(span, 1, np.array([0.1, 0.7]) + far_m, np.array([0.003]))
        for far_m in (0.0, length_m)
    )
    yield Row("2l [m]", length_m)
    yield Row("largest change of f1 over 2l", abs(there.forward - here.forward).max())


def _times(it: Machine) -> Iterator[Row]:
    for side in _RUNNING:
        _, waves = it.waves(side, 1, np.zeros(1))
        yield Row(f"t_1 = l/(c + v), {side} side", waves.forward_s)
        yield Row(f"t_2 = l/(c - v), {side} side", waves.backward_s)
        yield Row(f"T = 1/f_1, {side} side", waves.forward_s + waves.backward_s)


def _feed(it: Machine) -> Iterator[Row]:
    problem, section = it.problem, it.problem.section
    if section is None:
        return
    torsion_Hz = torsion_frequencies_Hz(it.span(Side.REST), section, 1)[0, 0]
    yield Row("first frequency of torsion at rest [Hz]", torsion_Hz)
    length_m = float((problem.free_span_m if problem.guided_m is None else problem.guided_m)[0])
    for side in _RUNNING:
        net_N = it.span(side, "3").net_tension_N
        limit_N = feed_limit_N(net_N, section, problem.ends, length_m)[0]
        yield Row(f"limit under feed force, {side} side [N]", limit_N)


def _measured(it: Machine) -> Iterator[Row]:
    saw = it.by_table["2"]
    for point in it.problem.measurements:
        name = f"{point.side} measured {point.frequency_Hz:g} Hz"
        if point.side is Side.REST:
            ratio = it.modes_Hz(Side.REST)[0] / point.frequency_Hz
            yield Row(f"{name}, string at rest off by [%]", 100.0 * (ratio - 1))
            continue
        for model in ("string-fixed-axles", "string-constant-force"):
            yield Row(f"{name}, {MODELS[model].name} off by [%]", 100.0 * deviation(saw, point, model)[1])
        yield Row(f"{name} would need the mounting factor", explain_mounting(saw, point).mounting_factor)


_PHASES = np.arange(4) / 8.0
_PLACE, _DEFLECTION = ("place_m", "Place along the span x [m]"), ("deflection", "Deflection [-]")
_WAVES = {"forward": "wave with the blade", "backward": "wave against it", "mode": "the two together"}


def _pictures(side: Side, mode: int, *, runs: bool) -> Callable[[Machine], Iterator[Shown]]:
    def charts(it: Machine) -> Iterator[Shown]:
        place_m, waves = it.waves(side, mode, _PHASES, runs=runs)
        speed = f"at {it.by_table['2'].speed_m_s:.1f} m/s" if runs else "at rest"
        for what, name in _WAVES.items():
            moments = zip(_PHASES, getattr(waves, what), strict=True)
            lines = [Line(f"t = {phase:g} T", place_m, line) for phase, line in moments]
            stem = f"{'running' if runs else 'rest'}_{what}"
            yield shown(stem, f"Mode {mode} {speed}: {name}", _PLACE, _DEFLECTION, lines)

    return charts


PAPER = Paper(
    title="Travelling waves of a band-saw blade",
    source="Wang Z., Jiang X.: Travelling-wave mechanism and dynamic characteristics of band-saw blade vibration, "
    "Scientia Silvae Sinicae 46 (11), 2010",
    system="bandsaw",
    scene="band-saw",
    machine=_machine,
    items=(
        Item(number="(1)", says="y_tt = c² y_xx, c = √(F/ρA)", where="1.1", unit="m/s",
            rows=lambda it: [Row("c at rest", it.span(Side.REST).wave_speed_m_s[0])]),
        Item(number="(2)-(4), Figs 1-3", says="y = f1(ct - x) + f2(ct + x), y = 0 at both ends", where="1.1",
            rows=_ends, charts=_pictures(Side.REST, 2, runs=False)),
        Item(number="(5), (6)", says="f1(ct + l) = f1(ct - l): period 2l in space", where="1.1", rows=_period),
        Item(number="(7)", says="f_n = n/(2l) √(F/ρA)", where="1.1", unit="Hz",
            rows=lambda it: [Row("f_1 at rest", it.modes_Hz(Side.REST)[0])]),
        Item(number="Figs 4, 5", says="waves with and against the blade, t_1 = l/(c + v), t_2 = l/(c - v)", where="1.2",
            unit="s", rows=_times, charts=_pictures(Side.TIGHT, 2, runs=True)),
        Item(number="(8)", says="f_n = n (c² - v²)/(2lc)", where="1.2", unit="Hz",
            rows=lambda it: [Row(f"f_{n + 1}, tight side, κ = 0", f) for n, f in enumerate(it.modes_Hz(Side.TIGHT))]),
        Item(number="(9), Table 1", says="f_n at rest under F_0", where="3", unit="Hz", rows=_table("1")),
        Item(number="(16)", says="M = 9549 P/n", where="3", unit="N m",
            rows=lambda it: [Row("M", 2.0 * it.problem.pull_N[0] * it.by_table["2"].wheel_radius_m)]),
        Item(number="(17)", says="ΔF = F_1 - F_2 = 2·9549 P/(D n)", where="3", unit="N",
            rows=lambda it: [Row("ΔF", 2.0 * it.problem.pull_N[0], "211")]),
        Item(number="v", says="v = πDn/60", where="3", unit="m/s",
            rows=lambda it: [Row("v", it.by_table["2"].speed_m_s, "35.5", _CUT)]),
        Item(number="(10), (11)", says="c = √((F_0 ± ΔF/2)/ρA)", where="2, 3", unit="m/s",
            rows=_both_sides("c", "2", ("76.8", "74.4"))),
        Item(number="(12)", says="f_1 = c/(2l) (1 - v²/c²)", where="2, 3", unit="Hz",
            rows=_both_sides("f_1", "2", ("19.0", "17.9"), (_MISPRINT, _CUT))),
        Item(number="Table 2", says="under F_0 ± ΔF/2 (κ = 0)", where="3", unit="Hz", rows=_table("2")),
        Item(number="ρA, F_c", says="F_c = ∫½ρAR²ω² sin α dα = ρA R²ω²", where="2, 3",
            rows=lambda it: [
                Row("ρA [kg/m]", it.problem.linear_density_kg_m[0], "0.60"),
                Row("F_c [N]", it.problem.inertia_N[0], "761", "from 0.6 kg/m and 16.2 1/s, both rounded"),
            ]),
        Item(number="(13), (14)", says="c = √((F_0 ± ΔF/2 + F_c)/ρA)", where="2, 3", unit="m/s",
            rows=_both_sides("c", "3", ("84.7", "82.6"), ("with the printed 761 N",) * 2)),
        Item(number="(15)", says="f_1 = c/(2l) (1 - v²/c²)", where="2, 3", unit="Hz",
            rows=_both_sides("f_1", "3", ("21.8", "21.0"))),
        Item(number="Table 3", says="under F_0 ± ΔF/2 + F_c (κ = 1)", where="3", unit="Hz", rows=_table("3")),
        Item(number="Discussion 1", says="measured and computed frequencies", where="4", rows=_measured,
            remark="the paper calls the agreement good; no moving string, whatever its mounting (0 to 1), explains "
            "the tight side"),
        Item(number="Discussion 4", says="torsion, and the limit under feed force (κ = 1)", where="4", rows=_feed,
            remark="left to later work there; pushed on the teeth at mid-span, between guides as far apart as the "
            "scene says, the free span if it does not"),
    ),
    notes=(
        ("the width and thickness of the blade are not printed; those of the bundled scene are a guess with the printed "
        "cross-section, and only torsion and the limit under feed force depend on them"),
    ),
)  # fmt: skip
