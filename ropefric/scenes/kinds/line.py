"""Scenes of a rope, cable, belt or tendon through a series of elements."""

from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields
from typing import Annotated, Any

import numpy as np
from pydantic import Field, PlainValidator

from ropefric.arrays import FloatArray
from ropefric.files.toml_model import choice, reject, text
from ropefric.scenes import kind
from ropefric.scenes.kind import Becomes, key, zero_or_more
from ropefric.section import Chart, Line, Section
from ropefric.systems.effect import applicable, assemble
from ropefric.systems.friction import WrapFriction
from ropefric.systems.line.effects import SYSTEM
from ropefric.systems.line.element import Element, LineProblem
from ropefric.systems.line.elements import ELEMENTS, Drum
from ropefric.systems.line.line import LineAnswer, answerable

_DIRECTIONS = ("pull", "pay-out")
_efficiency = kind.number_where(lambda one: 0.0 < one <= 1.0, "more than 0 and at most 1")


class LineTable(kind.Table):
    """`[line]`.

    Keys
    ----
    direction : Whether the rope is pulled from start to end, or paid out, so that friction helps the hand at the end.
    start_tension : Before the first element.
    end_tension : Behind the last element, at the hand.
    anchorage_slip : w, by which the anchorage lets a stressed tendon back.
    tension_limit : Largest tension that the rope may have anywhere.
    """

    direction: Annotated[str, PlainValidator(choice(lambda: _DIRECTIONS))] = "pull"
    start_tension: Annotated[float | None, kind.key("N", "90 lbf", "start_tension_N", or_zero=True)] = None
    end_tension: Annotated[float | None, kind.key("N", "200 N", "end_tension_N", or_zero=True)] = None
    anchorage_slip: Annotated[float | None, kind.key("m", "6 mm", "anchorage_slip_m")] = None
    tension_limit: Annotated[float | None, kind.key("N", "10 kN", "tension_limit_N")] = None


class RopeTable(kind.Table):
    """`[rope]`.

    Keys
    ----
    linear_density : Mass per length; for the weight of runs.
    axial_stiffness : EA; for elongation, lost stroke and anchorage slip.
    diameter : 2 R_r; for laws with a size effect.
    bending_stiffness : EI, which keeps the rope from lying down on the whole bend.
    """

    linear_density: Annotated[float | None, kind.key("kg/m", "2 kg/m", "linear_density_kg_m")] = None
    axial_stiffness: Annotated[float | None, kind.key("N", "30 MN", "axial_stiffness_N")] = None
    diameter: Annotated[float | None, kind.key("m", "12 mm", "rope_radius_m", factor=0.5)] = None
    bending_stiffness: Annotated[float | None, kind.key("N*m^2", "2e-3 N*m^2", "bending_stiffness_N_m2")] = (
        None
    )


class ElementTable(kind.Table):
    """`[[element]]`: what the rope passes, in the order from start to end; each has the keys of its own kind.

    Keys
    ----
    kind : What it is.
    name : What the answer calls it.
    angle : Of a bend or drum: over which the rope lies on it.
    radius : Of a bend or drum: of what the rope lies on; for the side pressure.
    length : Of a bend or run: along the rope.
    slope : Of a run: α, positive uphill from start to end.
    wobble : Of a bend or run: k, unintended angle per length of a duct or sheath.
    mu : Of a bend, drum or run: coefficient of this element alone.
    normal_limit : Of a bend: largest side pressure T/R.
    carries : Of a run: whether its tension carries the load of a hauling system.
    efficiency : Of a wheel: η, the tension that arrives over that which pulls.
    torque : Of a drum: that drives it, negative where it brakes; all its friction if left out.
    """

    kind: Annotated[str, PlainValidator(choice(lambda: ELEMENTS))]
    name: Annotated[str | None, PlainValidator(text)] = None
    angle: Annotated[float | None, key("rad", "90 deg", "angle_rad")] = None
    radius: Annotated[float | None, key("m", "300 mm", "radius_m")] = None
    length: Annotated[float | None, key("m", "30 m", "length_m")] = None
    slope: Annotated[float | None, key("rad", "10 deg", "slope_rad", above=None)] = None
    wobble: Annotated[float | None, key("1/m", "0.01 rad/m", "wobble_1_m")] = None
    mu: Annotated[float | None, PlainValidator(zero_or_more), Becomes("mu")] = None
    normal_limit: Annotated[float | None, key("N/m", "5 kN/m", "normal_limit_N_m")] = None
    carries: Annotated[bool | None, Becomes("carries")] = None
    efficiency: Annotated[float | None, PlainValidator(_efficiency), Becomes("efficiency")] = None
    torque: Annotated[float | None, key("N*m", "150 N*m", "torque_N_m", above=None)] = None

    def _check(self) -> None:
        self.element(0)

    def element(self, place: int) -> Element:
        """Return the element that the table gives, the one at a place of the line."""
        known, values = ELEMENTS[self.kind], kind.given(self)
        keys = {one.field: key for key, one in kind.becomes(type(self)).items()}
        own = {one.name: keys[one.name] for one in fields(known) if one.name in keys}
        for field in values.keys() - own.keys():
            has = ", ".join(own.values())
            reject("RF120", f"a {self.kind} has no {keys[field]}", fix=f"it has {has}", key=keys[field])
        for one in fields(known):
            if one.name in own and one.default is MISSING and one.name not in values:
                fix = kind.how_to_add(type(self), own[one.name])
                reject("RF121", f"a {self.kind} needs its {own[one.name]}", fix=fix)
        found = known(name=self.name or f"{self.kind} {place + 1}", **values)
        if missing := found.missing():
            reject("RF121", f"the {self.kind} lacks something", fix=f"add {missing}")
        return found


class LineScene(kind.SceneTable):
    """A scene with `system = "line"`."""

    line: LineTable
    rope: RopeTable = Field(default_factory=RopeTable)
    element: list[ElementTable]
    rules = (kind.needs("line.anchorage_slip", "rope.axial_stiffness"),)

    def _check(self) -> None:
        elements = [one.element(place) for place, one in enumerate(self.element)]
        if not elements:
            reject("RF121", "the line has no element", fix="add a table [[element]]", key="element")
        self._check_ends()
        self._check_tendon(elements)
        for place, one in enumerate(elements) if self.friction is None else ():
            if one.slides and getattr(one, "mu", None) is None and (one.kind != "run" or self._rubs(one)):
                reject(
                    "RF121",
                    f"no friction is given for {one.name}",
                    fix="add mu to it, or mu, a law or a fit to [friction]",
                    key=f"element.{place}",
                )

    def _check_ends(self) -> None:
        line = self.line
        if line.start_tension is not None and line.end_tension is not None:
            fix = "keep the one that is known"
            reject("RF111", "start_tension and end_tension are both given", fix=fix, key="line.end_tension")
        if line.start_tension is None and line.end_tension is None:
            fix = 'add start_tension = "90 N", before the first element, or end_tension, behind the last'
            reject("RF121", "the tension is known at neither end", fix=fix, key="line.start_tension")

    def _rubs(self, run: Any) -> bool:
        return self.rope.linear_density is not None or run.wobble_1_m is not None

    def _check_tendon(self, elements: list[Element]) -> None:
        friction, is_tendon = self.friction, self.line.anchorage_slip is not None
        alike = friction is None or friction.mu is not None
        has_drum = any(isinstance(one, Drum) for one in elements)
        if is_tendon and (not alike or self.rope.linear_density is not None or has_drum):
            reject(
                "RF111",
                "anchorage_slip is for a tendon: one coefficient, no weight, no drums",
                fix="give mu, and leave out linear_density and drums",
                key="line.anchorage_slip",
            )


def _problem(table: LineScene, friction: WrapFriction | None) -> LineProblem:
    return LineProblem(
        friction=friction,
        elements=tuple(one.element(place) for place, one in enumerate(table.element)),
        pulled=table.line.direction == "pull",
        **kind.arrays(table),
    )


def _own_wheel(table: LineScene) -> tuple[float, float]:
    """Return the first bend's radius and the rope's, for a law without reference; only a size effect uses them."""
    thin_m = 0.5 * table.rope.diameter if table.rope.diameter else None
    radius_m = next((one.radius for one in table.element if one.radius), 10.0 * (thin_m or 0.01))
    return radius_m, thin_m or 0.1 * radius_m


def _quantities(answer: LineAnswer, problem: LineProblem) -> tuple[kind.Quantity, ...]:
    """Return the tension that is not known first, then the others, then those of the elements."""
    ends = {"hand_tension_N": answer.tension_N[-1], "start_tension_N": answer.tension_N[0]}
    named = list(ends) if problem.start_tension_N is not None else list(ends)[::-1]
    found: dict[str, FloatArray | None] = {name: ends[name] for name in named}
    if answer.load_N is not None:
        hand_N = answer.tension_N[-1]
        per_hand = np.divide(answer.load_N, hand_N, out=np.full_like(hand_N, np.nan), where=hand_N != 0.0)
        found |= {"load_N": answer.load_N, "advantage": per_hand}
    found["elongation_m"] = answer.stretch_m.sum(axis=0) if answer.stretches else None
    cycle = answer.cycle
    if cycle is not None and np.isfinite(cycle.pulled_N).any():
        found["cycle.pull_tension_N"], found["cycle.pay_out_tension_N"] = cycle.pulled_N, cycle.paid_out_N
        found["cycle.dead_band_N"] = cycle.pulled_N - cycle.paid_out_N
        found["cycle.lost_stroke_m"] = cycle.lost_stroke_m if answer.stretches else None
    for place, numbers in enumerate(answer.numbers):
        found[f"elements.{place}.tension_out_N"] = answer.tension_N[place + 1]
        found |= {f"elements.{place}.{name}": value for name, value in numbers.items()}
    return tuple(
        kind.Quantity(name, value, positive=bool((value > 0.0).all()), is_main=name == named[0])
        for name, value in found.items()
        if value is not None
    )


def _failures(answer: LineAnswer, problem: LineProblem) -> tuple[kind.Failure, ...]:
    found = []
    for place, (one, numbers) in enumerate(zip(problem.elements, answer.numbers, strict=True)):
        lowest_N = answer.tension_N[place : place + 2].min(axis=0)
        words = f"{one.name}: the rope would have to push"
        found.append(kind.Failure(words, "lowest tension in N", lowest_N, lowest_N < 0.0, limit=0.0))
        if "utilisation" in numbers:
            # A drum that needs all its friction is at the limit, whatever rounding says.
            over = numbers["utilisation"] > 1.0 + 1e-12
            found.append(kind.Failure(f"{one.name}: {one.over}", "utilisation", numbers["utilisation"], over))
    if problem.axial_stiffness_N is not None and answer.stretches:
        found.append(kind.strained("the rope", answer.tension_N.max(axis=0) / problem.axial_stiffness_N))
    if problem.tension_limit_N is not None:
        use = answer.tension_N.max(axis=0) / problem.tension_limit_N
        found.append(kind.Failure("the tension exceeds its limit", "utilisation", use, use > 1.0))
    return tuple(found)


def _tree(answer: LineAnswer, problem: LineProblem) -> dict[str, Any]:
    tension_N = [kind.finite(one[0]) for one in answer.tension_N]
    elements = []
    for place, (one, numbers) in enumerate(zip(problem.elements, answer.numbers, strict=True)):
        row: dict[str, Any] = {"name": one.name, "kind": one.kind}
        row |= {"tension_in_N": tension_N[place], "tension_out_N": tension_N[place + 1], "normal_N_m": None}
        row |= {name: kind.finite(value[0]) for name, value in numbers.items()}
        if answer.stretches:
            row["elongation_m"] = kind.finite(answer.stretch_m[place, 0])
        elements.append(row)
    tree: dict[str, Any] = {
        "direction": _DIRECTIONS[0 if problem.pulled else 1],
        "tension_N": tension_N,
        "elements": elements,
    }
    if (tendon := answer.anchored) is not None:
        tree["anchored"] = kind.first(tendon, "anchor_N", "largest_N", "affected_m")
        tree["anchored"]["tension_N"] = tendon.tension_N[:, 0].tolist()
    return tree


_COLUMNS: kind.Columns = {
    "T in [N]": ("tension_in_N", ".5g"),
    "T out [N]": ("tension_out_N", ".5g"),
    "T/R [N/m]": ("normal_N_m", ".4g"),
    "used": ("utilisation", ".3g"),
    "torque [N m]": ("torque_N_m", ".4g"),
    "longer by [mm]": ("elongation_m", ".4g", 1e3),
}


def _sections(tree: Mapping[str, Any]) -> tuple[Section, ...]:
    elements = tree["elements"]
    columns = {
        head: one for head, one in _COLUMNS.items() if any(row.get(one[0]) is not None for row in elements)
    }
    names = [row["name"] for row in elements]
    rows = {
        name if names.count(name) == 1 else f"{name} ({place + 1})": row
        for place, (name, row) in enumerate(zip(names, elements, strict=True))
    }
    return (kind.by_rows("Along the line", "element", rows, columns, lines=tuple(_lines(tree))),)


def _lines(tree: Mapping[str, Any]) -> Iterator[str]:
    if tree.get("cycle", {}).get("dead_band_N") is not None:
        cycle = tree["cycle"]
        lost = f", lost stroke {1e3 * cycle['lost_stroke_m']:.4g} mm" if "lost_stroke_m" in cycle else ""
        yield (
            f"against {tree['tension_N'][0]:.5g} N at the start the hand pulls with {cycle['pull_tension_N']:.5g} N and "
            f"pays out with {cycle['pay_out_tension_N']:.5g} N: dead band {cycle['dead_band_N']:.5g} N{lost}"
        )
    if (one := tree.get("anchored")) is not None:
        yield (
            f"after the slip the anchorage has {one['anchor_N']:.5g} N and the tendon {one['largest_N']:.5g} N at most, "
            f"{one['affected_m']:.4g} m away"
        )


def _chart(answer: LineAnswer, problem: LineProblem) -> Chart:
    """Return the tension along the rope, by its length where any element has one."""
    lengths_m = np.array([one.stretching_m for one in problem.elements])
    by_length = bool(lengths_m.any())
    steps = lengths_m if by_length else np.ones(len(lengths_m))
    places = np.concatenate([[0.0], np.cumsum(steps)])
    lines = [Line("pulled" if problem.pulled else "paid out", places, answer.tension_N[:, 0])]
    if (tendon := answer.anchored) is not None:
        turns_m = abs((places[-1] if problem.pulled else 0.0) - tendon.affected_m[0])
        before = int(np.searchsorted(places, turns_m))
        tension_N = np.insert(tendon.tension_N[:, 0], before, tendon.largest_N[0])
        lines.append(Line("after the slip of the anchorage", np.insert(places, before, turns_m), tension_N))
    if problem.tension_limit_N is not None:
        ends = np.array([0.0, places[-1]])
        lines.append(Line("limit", ends, np.full(2, problem.tension_limit_N[0]), limit=True))
    axis = ("along_m", "Along the rope [m]") if by_length else ("element", "Behind element [-]")
    return Chart("Tension along the line", *axis, "tension_N", "Tension T [N]", tuple(lines))


def _contacts(problem: LineProblem) -> Mapping[str, FloatArray]:
    """Return the bends and drums that use the law of the line, with the tension on their slack side."""
    names = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N")
    rows, friction = [], problem.friction
    if friction is not None:
        model = assemble(SYSTEM, problem, applicable(SYSTEM.effects, problem))
        answer, thin_m = SYSTEM.solve(model, SYSTEM.method(model, 1.0)), problem.rope_radius_m
        reference = [float(getattr(friction.reference, name)[0]) for name in names[:2]]
        for place, one in enumerate(problem.elements):
            angle_rad = getattr(one, "angle_rad", None)
            if angle_rad is not None and one.slides and getattr(one, "mu", None) is None:
                radius_m = getattr(one, "radius_m", None) or reference[0]
                slack_N = float(answer.tension_N[place : place + 2, 0].min())
                rows.append((radius_m, reference[1] if thin_m is None else thin_m[0], angle_rad, slack_N))
    columns = np.array(rows, dtype=np.float64).reshape(-1, 4).T
    return dict(zip(names, np.maximum(columns, 1e-30), strict=True))


KIND = kind.Kind(
    name="line",
    schema=LineScene,
    system=SYSTEM,
    own_wheel=_own_wheel,
    problem=_problem,
    quantities=_quantities,
    tree=_tree,
    contacts=_contacts,
    answerable=answerable,
    failures=_failures,
    keys={
        "mu": "friction.mu",
        "element": "element.{}",
        "elements": "element",
        "wrap_angle_rad": "rope.bending_stiffness",
    },
    sections=_sections,
    figures={"line": kind.Figure(_chart)},
    words={
        "hand_tension_N": "Tension at the hand, behind the last element [N]",
        "start_tension_N": "Tension before the first element [N]",
        "load_N": "Load that the carrying runs hold [N]",
        "advantage": "Load over the tension at the hand",
        "elongation_m": "Elongation of the rope [m]",
    },
)
