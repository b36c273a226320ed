"""Scenes of a rope, cable, belt or tendon through a series of elements."""

import math
from collections.abc import Iterator, Mapping
from inspect import getdoc
from typing import Annotated, Any, get_args, get_type_hints

import numpy as np
from pydantic import Field, PlainValidator, create_model

from ropefric.arrays import FloatArray
from ropefric.files.toml_model import choice, reject, text
from ropefric.scenes import kind
from ropefric.section import Chart, Line, Section
from ropefric.systems.effect import applicable, assemble
from ropefric.systems.friction import WrapFriction
from ropefric.systems.line.effects import SYSTEM
from ropefric.systems.line.element import Element, Given, LineProblem, given_by
from ropefric.systems.line.elements import ELEMENTS
from ropefric.systems.line.elements.drum import Drum
from ropefric.systems.line.line import LineAnswer, answerable

_DIRECTIONS = ("pull", "pay-out")


class LineTable(kind.Table):
    """`[line]`.

    Keys
    ----
    direction : Whether the rope is pulled from start to end, or paid out, so that friction helps the hand at the end.
    start_tension : Before the first element.
    end_tension : Behind the last element, at the hand.
    pull : Effective pull of all drums that have a share of it.
    both_ends : Whether a tendon is stressed from both ends.
    anchorage_slip : w, by which the anchorage lets a stressed tendon back.
    tension_limit : Largest tension that the rope may have anywhere.
    """

    direction: Annotated[str, PlainValidator(choice(lambda: _DIRECTIONS))] = "pull"
    start_tension: Annotated[float | None, kind.key("N", "90 lbf", "start_tension_N", or_zero=True)] = None
    end_tension: Annotated[float | None, kind.key("N", "200 N", "end_tension_N", or_zero=True)] = None
    pull: Annotated[float | None, kind.key("N", "20 kN", "pull_N")] = None
    both_ends: bool = False
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


def _keys() -> dict[str, tuple[Given, str, Any, list[type[Element]]]]:
    """Return the keys of all kinds of elements: what they are given by, their field and type, and who has them."""
    found: dict[str, tuple[Given, str, Any, list[type[Element]]]] = {}
    for element in ELEMENTS.values():
        hints = get_type_hints(element)
        for field, given in given_by(element).items():
            known = found.setdefault(given.key, (given, field, hints[field], []))
            if (known[0].si_unit, known[1]) != (given.si_unit, field):
                raise ValueError(
                    f"{element.__name__} gives its key {given.key} another unit or field than others do"
                )
            known[3].append(element)
    return found


_KEYS = _keys()


def _annotation(given: Given, field: str, its_type: Any) -> Any:
    types = {*get_args(its_type), its_type}
    if bool in types:
        return Annotated[bool | None, kind.Becomes(field)]
    if given.si_unit:
        return Annotated[float | None, kind.key(given.si_unit, given.like, field, above=given.above)]
    allowed = "zero or more" if given.or_zero else "more than 0"
    allowed += f" and at most {given.at_most:g}" if given.at_most < math.inf else ""
    read = kind.number_where(
        lambda one: (one >= 0.0 if given.or_zero else one > 0.0) and one <= given.at_most, allowed
    )
    return Annotated[float | None, PlainValidator(read), kind.Becomes(field)]


class _ElementTable(kind.Table):
    """`[[element]]`: what the rope passes, in the order from start to end.

    Keys
    ----
    kind : What it is.
    name : What the answer calls it.
    """

    kind: Annotated[str, PlainValidator(choice(lambda: ELEMENTS))]
    name: Annotated[str | None, PlainValidator(text)] = None

    def _check(self) -> None:
        self.element(0)

    def element(self, place: int) -> Element:
        """Return the element that the table gives, the one at a place of the line."""
        known = ELEMENTS[self.kind]
        own, values = given_by(known), kind.given(self)
        for field in values:
            if field not in own:
                key = next(key for key, one in _KEYS.items() if one[1] == field)
                has = ", ".join(one.key for one in own.values())
                reject("RF120", f"a {self.kind} has no {key}", fix=f"it has {has}", key=key)
        needed = [one for field, one in own.items() if not hasattr(known, field) and field not in values]
        for one in needed:
            like = f' = "{one.like}"' if one.like else ""
            reject("RF121", f"a {self.kind} needs its {one.key}", fix=f"add {one.key}{like}")
        found = known(name=self.name or f"{self.kind} {place + 1}", **values)
        if missing := found.missing():
            reject("RF121", f"the {self.kind} lacks something", fix=f"add {missing}")
        return found


_MEANINGS = "\n".join(
    f"{key} : Of a {', '.join(one.kind for one in has)}: {given.meaning}"
    for key, (given, _, _, has) in _KEYS.items()
)
_FIELDS: dict[str, Any] = {
    key: (_annotation(given, field, its_type), None) for key, (given, field, its_type, _) in _KEYS.items()
}
ElementTable: Any = create_model(
    "ElementTable",
    __base__=_ElementTable,
    __doc__=f"{getdoc(_ElementTable)}\n{_MEANINGS}\n",  # indented or not, as the version of Python has it
    **_FIELDS,
)
"""The keys of all kinds of elements, of which each table has those of its own kind."""


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
        self._check_ends([one for one in elements if isinstance(one, Drum)])
        self._check_tendon(elements)
        for place, one in enumerate(elements) if self.friction is None else ():
            if one.slides and getattr(one, "mu", None) is None and (one.kind != "run" or self._rubs(one)):
                reject(
                    "RF121",
                    f"no friction is given for {one.name}",
                    fix="add mu to it, or mu, a law or a fit to [friction]",
                    key=f"element.{place}",
                )

    def _check_ends(self, drums: list[Drum]) -> None:
        line = self.line
        if line.start_tension is not None and line.end_tension is not None and not line.both_ends:
            fix = "keep the one that is known, or add both_ends = true for a tendon"
            reject("RF111", "start_tension and end_tension are both given", fix=fix, key="line.end_tension")
        is_known = line.start_tension is not None or line.end_tension is not None
        if not is_known and not any(one.is_set for one in drums):
            fix = 'add start_tension = "90 N", before the first element, or end_tension, behind the last'
            reject("RF121", "the tension is known at neither end", fix=fix, key="line.start_tension")
        if (line.pull is not None) != any(one.share is not None for one in drums):
            fix = 'give pull = "20 kN" to [line] and a share to its drums, or neither'
            reject("RF121", "a pull needs drums with a share of it", fix=fix, key="line.pull")

    def _rubs(self, run: Any) -> bool:
        return self.rope.linear_density is not None or run.wobble_1_m is not None

    def _check_tendon(self, elements: list[Element]) -> None:
        line, friction = self.line, self.friction
        is_tendon = line.both_ends or line.anchorage_slip is not None
        alike = friction is None or friction.mu is not None
        has_drum = any(isinstance(one, Drum) for one in elements)
        if is_tendon and (not alike or self.rope.linear_density is not None or has_drum):
            reject(
                "RF111",
                "both_ends and anchorage_slip are for a tendon: one coefficient, no weight, no drums",
                fix="give mu, and leave out linear_density and drums",
                key="line.both_ends" if line.both_ends else "line.anchorage_slip",
            )


def _problem(table: LineScene, friction: WrapFriction | None) -> LineProblem:
    return LineProblem(
        friction=friction,
        elements=tuple(one.element(place) for place, one in enumerate(table.element)),
        pulled=table.line.direction == "pull",
        both_ends=table.line.both_ends,
        **kind.arrays(table),
    )


def _own_wheel(table: LineScene) -> tuple[float, float]:
    """Return the first bend's radius and the rope's, for a law without reference; only a size effect uses them."""
    radii = [one.radius for one in table.element if getattr(one, "radius", None)]
    thin_m = 0.5 * table.rope.diameter if table.rope.diameter else None
    return (radii[0] if radii else 10.0 * (thin_m or 0.01)), thin_m or 0.1 * (radii[0] if radii else 0.1)


def _quantities(answer: LineAnswer, problem: LineProblem) -> tuple[kind.Quantity, ...]:
    """Return the tension that is not known first, then the others, then those of the elements."""
    ends = {"hand_tension_N": answer.tension_N[-1], "start_tension_N": answer.tension_N[0]}
    named = list(ends) if problem.start_tension_N is not None else list(ends)[::-1]
    found: dict[str, FloatArray | None] = {name: ends[name] for name in named}
    if answer.load_N is not None:
        hand_N = answer.tension_N[-1]
        per_hand = np.divide(answer.load_N, hand_N, out=np.full_like(hand_N, np.nan), where=hand_N != 0.0)
        found |= {"load_N": answer.load_N, "advantage": per_hand}
    found["elongation_m"] = _elongation_m(answer) if answer.stretches else None
    found["needed_end_tension_N"] = answer.needed_end_N
    cycle = answer.cycle
    if cycle is not None and np.isfinite(cycle.pulled_N).any():
        found["cycle.pull_tension_N"], found["cycle.pay_out_tension_N"] = cycle.pulled_N, cycle.paid_out_N
        found["cycle.dead_band_N"] = cycle.pulled_N - cycle.paid_out_N
        found["cycle.lost_stroke_m"] = cycle.lost_stroke_m if answer.stretches else None
    if answer.other_end is not None:
        found["from_other_end.hand_tension_N"] = answer.other_end[-1]
        found["from_other_end.start_tension_N"] = answer.other_end[0]
    found["least_tension_N"] = None if answer.stressed is None else answer.stressed.least_N
    for place, numbers in enumerate(answer.numbers):
        found[f"elements.{place}.tension_out_N"] = answer.tension_N[place + 1]
        found |= {f"elements.{place}.{name}": value for name, value in numbers.items()}
    return tuple(
        kind.Quantity(name, value, positive=bool((value > 0.0).all()), is_main=name == named[0])
        for name, value in found.items()
        if value is not None
    )


def _elongation_m(answer: LineAnswer) -> FloatArray:
    stiffness_N = answer.model.problem.axial_stiffness_N
    if answer.stressed is not None and stiffness_N is not None:
        return np.asarray(answer.stressed.elongation_N_m.sum(axis=0) / stiffness_N)
    return np.asarray(answer.stretch_m.sum(axis=0))


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
        if answer.stretches and answer.stressed is None:
            row["elongation_m"] = kind.finite(answer.stretch_m[place, 0])
        elements.append(row)
    tree: dict[str, Any] = {
        "direction": _DIRECTIONS[0 if problem.pulled else 1],
        "tension_N": tension_N,
        "elements": elements,
    }
    if answer.other_end is not None:
        tree["from_other_end"] = _from_other_end(answer.other_end, problem.elements)
    if answer.stressed is not None:
        both = answer.stressed
        tree["both_ends"] = {"least_at_m": float(both.least_at_m[0])}
        if answer.stretches and problem.axial_stiffness_N is not None:
            drawn_m = both.elongation_N_m[:, 0] / problem.axial_stiffness_N[0]
            tree["both_ends"] |= {"elongation_at_start_m": drawn_m[0], "elongation_at_end_m": drawn_m[1]}
    if answer.anchored:
        names, pairs = (
            ("anchor_N", "largest_N", "affected_m"),
            zip(answer.jacks, answer.anchored, strict=True),
        )
        tree["anchored"] = [
            {"at": end, "tension_N": one.tension_N[:, 0].tolist()} | kind.first(one, *names)
            for end, one in pairs
        ]
    return tree


def _from_other_end(other: FloatArray, elements: tuple[Element, ...]) -> dict[str, Any]:
    """Return the largest side pressure where the rope is pulled from the other end."""
    radii = [getattr(one, "radius_m", None) for one in reversed(elements)]
    pressures = [max(other[i, 0], other[i + 1, 0]) / radius for i, radius in enumerate(radii) if radius]
    return {"normal_N_m": kind.finite(max(pressures))} if pressures else {}


_COLUMNS: kind.Columns = {
    "T in [N]": ("tension_in_N", ".5g"),
    "T out [N]": ("tension_out_N", ".5g"),
    "T/R [N/m]": ("normal_N_m", ".4g"),
    "used": ("utilisation", ".3g"),
    "pulls at it [N]": ("resultant_N", ".4g"),
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
    hand_N = tree["tension_N"][-1]
    if "from_other_end" in tree:
        ends_N = [tree["from_other_end"][name] for name in ("start_tension_N", "hand_tension_N")]
        if None not in ends_N and not np.allclose(
            ends_N, [tree["tension_N"][0], hand_N], rtol=1e-6, atol=0.0
        ):
            yield (
                f"pulled from the other end: {ends_N[0]:.5g} N before the first element, "
                f"{ends_N[1]:.5g} N behind the last"
            )
    if tree.get("cycle", {}).get("dead_band_N") is not None:
        cycle = tree["cycle"]
        lost = f", lost stroke {1e3 * cycle['lost_stroke_m']:.4g} mm" if "lost_stroke_m" in cycle else ""
        yield (
            f"against {tree['tension_N'][0]:.5g} N at the start the hand pulls with {cycle['pull_tension_N']:.5g} N and "
            f"pays out with {cycle['pay_out_tension_N']:.5g} N: dead band {cycle['dead_band_N']:.5g} N{lost}"
        )
    if "both_ends" in tree:
        both = tree["both_ends"]
        yield f"least tension {tree['least_tension_N']:.5g} N, {both['least_at_m']:.4g} m from the start"
        if "elongation_at_start_m" in both:
            drawn = " and ".join(f"{1e3 * both[f'elongation_at_{end}_m']:.4g} mm" for end in ("start", "end"))
            yield f"the jacks at start and end draw out {drawn}"
    for one in tree.get("anchored", ()):
        yield (
            f"after the slip the anchorage at the {one['at']} has {one['anchor_N']:.5g} N and the tendon "
            f"{one['largest_N']:.5g} N at most, {one['affected_m']:.4g} m away"
        )


def _chart(answer: LineAnswer, problem: LineProblem) -> Chart:
    """Return the tension along the rope, by its length where any element has one."""
    lengths_m = np.array([one.stretching_m for one in problem.elements])
    by_length = bool(lengths_m.any())
    steps = lengths_m if by_length else np.ones(len(lengths_m))
    places, both = np.concatenate([[0.0], np.cumsum(steps)]), answer.stressed
    name = "stressed from both ends" if both is not None else "pulled" if problem.pulled else "paid out"
    least = [] if both is None else [(both.least_at_m[0], both.least_N[0])]
    lines = [_line(name, places, answer.tension_N[:, 0], least)]
    if answer.other_end is not None and np.isfinite(answer.other_end).all():
        lines.append(Line("pulled from the other end", places, answer.other_end[::-1, 0]))
    if answer.anchored:
        turns = [
            (places[-1] - one.affected_m[0] if end == "end" else one.affected_m[0], one.largest_N[0])
            for end, one in zip(answer.jacks, answer.anchored, strict=True)
        ]
        after_N = np.min([one.tension_N[:, 0] for one in answer.anchored], axis=0)
        lines.append(_line("after the slip of the anchorage", places, after_N, least + turns))
    if problem.tension_limit_N is not None:
        ends = np.array([0.0, places[-1]])
        lines.append(Line("limit", ends, np.full(2, problem.tension_limit_N[0]), limit=True))
    axis = ("along_m", "Along the rope [m]") if by_length else ("element", "Behind element [-]")
    return Chart("Tension along the line", *axis, "tension_N", "Tension T [N]", tuple(lines))


def _line(name: str, places: FloatArray, tension_N: FloatArray, more: list[tuple[float, float]]) -> Line:
    """Return a line through the tensions between the elements, and through more points within them."""
    at = np.concatenate([places, [one[0] for one in more]])
    order = np.argsort(at, kind="stable")
    return Line(name, at[order], np.concatenate([tension_N, [one[1] for one in more]])[order])


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
        "needed_end_tension_N": "Least take-up tension that serves all drums [N]",
        "least_tension_N": "Least tension of the tendon [N]",
    },
)
