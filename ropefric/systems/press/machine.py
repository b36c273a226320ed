"""A belt press: rollers, belts and a speed, checked as a whole."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

from ropefric.errors import InputError, Problem, raise_problems
from ropefric.registry import did_you_mean
from ropefric.systems.checks import Rule, checked, refuse_out_of_scale

Role = Literal["driver", "driven", "tensioner"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tensioner:
    """The spring, preload and geometry that carry a translating roller.

    Its equation of motion is m ẍ + C1 ẋ + k1 x = T'_in cos(upstream) + T'_out cos(downstream) − F with the tensions
    T' = T − ρAv², eqs. (21), (22).
    """

    spring_N_m: float
    travel_m: float
    force_N: float
    mass_kg: float | None = None
    damping_N_s_m: float = 0.0
    upstream_angle_rad: float = 0.0
    downstream_angle_rad: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Roller:
    """A roller and the torques that hold it back."""

    name: str
    radius_m: float
    wrap_angle_rad: float
    role: Role = "driven"
    inertia_kg_m2: float | None = None
    gravity_torque_N_m: float = 0.0
    squeeze_torque_N_m: float = 0.0
    tensioner: Tensioner | None = None
    overspeed: float | None = None

    @property
    def torque_N_m(self) -> float:
        """Return the whole torque M = M_G + M_F that the belt has to overcome [N m]."""
        return self.gravity_torque_N_m + self.squeeze_torque_N_m


@dataclass(frozen=True, slots=True, kw_only=True)
class Belt:
    """A belt and the way it takes."""

    name: str
    loop: tuple[str, ...]
    linear_density_kg_m: float
    thickness_m: float
    width_m: float
    axial_stiffness_N: float | None = None
    damping_s: float = 0.0
    span_lengths_m: tuple[float, ...] | None = None

    @property
    def steps(self) -> tuple[tuple[str, str], ...]:
        """Return from which roller to which the belt runs, once round."""
        return tuple(zip(self.loop, self.loop[1:] + self.loop[:1], strict=True))


@dataclass(frozen=True, slots=True, kw_only=True)
class Span:
    """A piece of belt from one roller to the next; where belts run together it carries all of them."""

    name: str
    start: str
    end: str
    belts: tuple[str, ...]


def spans_of(belts: Sequence[Belt], names: Sequence[str] | None = None) -> tuple[Span, ...]:
    """Return the spans in the order of the first belt's loop, then what the second adds, and so on."""
    steps: dict[tuple[str, str], list[str]] = {}
    for belt in belts:
        for step in belt.steps:
            steps.setdefault(step, []).append(belt.name)
    chosen = [str(i + 1) for i in range(len(steps))] if names is None else names
    return tuple(
        Span(name=name, start=start, end=end, belts=tuple(carried))
        for name, ((start, end), carried) in zip(chosen, steps.items(), strict=False)
    )


@dataclass(frozen=True, kw_only=True)  # no slots: the spans are kept
class Press:
    """The drive train of a belt filter press, or of any machine of rollers and closed belts."""

    rollers: tuple[Roller, ...]
    belts: tuple[Belt, ...]
    speed_m_s: float
    span_names: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        raise_problems(press_problems(self.rollers, self.belts, self.speed_m_s, self.span_names))

    @cached_property
    def spans(self) -> tuple[Span, ...]:
        """Return the spans, in the order of every array over spans."""
        return spans_of(self.belts, self.span_names)

    @property
    def tensioners(self) -> tuple[Roller, ...]:
        """Return the rollers that translate, in the order of every array over tensioners."""
        return tuple(roller for roller in self.rollers if roller.tensioner is not None)

    @property
    def take_ups(self) -> tuple[Tensioner, ...]:
        """Return what carries the rollers that translate, in the same order."""
        return tuple(roller.tensioner for roller in self.rollers if roller.tensioner is not None)

    def belts_on(self, roller: Roller) -> tuple[Belt, ...]:
        """Return the belts that run over a roller."""
        return tuple(belt for belt in self.belts if roller.name in belt.loop)


def missing_elasticity(press: Press) -> list[str]:
    """Return the fields that are missing for belts that stretch."""
    return [
        f"belts.{belt.name}.{name}"
        for belt in press.belts
        for name in ("axial_stiffness_N", "span_lengths_m")
        if getattr(belt, name) is None
    ]


def missing_masses(press: Press) -> list[str]:
    """Return the fields that are missing for what moves in a start-up; the drivers are moved whatever they weigh."""
    return [
        f"rollers.{roller.name}.inertia_kg_m2"
        for roller in press.rollers
        if roller.inertia_kg_m2 is None and roller.role != "driver"
    ] + [
        f"rollers.{roller.name}.tensioner.mass_kg"
        for roller, take_up in zip(press.tensioners, press.take_ups, strict=True)
        if take_up.mass_kg is None
    ]


def refuse_missing(what: str, keys: Sequence[str], *, fix: str) -> None:
    """Refuse a computation for want of some fields, named one by one."""
    if keys:
        raise InputError(
            f"{what} needs {', '.join(keys)}",
            code="RF521",
            key=keys[0],
            fix=fix,
            problems=[Problem(code="RF521", key=key, message=f"{what} needs {key}") for key in keys],
        )


_NUMBERS: Mapping[type, Mapping[str, Rule]] = {
    Roller: {
        "radius_m": "positive",
        "wrap_angle_rad": "positive",
        "inertia_kg_m2": "positive",
        "gravity_torque_N_m": "any",
        "squeeze_torque_N_m": "any",
        "overspeed": "any",
    },
    Tensioner: {
        "spring_N_m": "zero or more",
        "travel_m": "any",
        "force_N": "zero or more",
        "damping_N_s_m": "zero or more",
        "mass_kg": "positive",
        "upstream_angle_rad": "any",
        "downstream_angle_rad": "any",
    },
    Belt: {
        "linear_density_kg_m": "zero or more",
        "thickness_m": "positive",
        "width_m": "positive",
        "damping_s": "zero or more",
        "axial_stiffness_N": "positive",
        "span_lengths_m": "positive",
    },
}


class _Problems(list[Problem]):
    """What is wrong with a press."""

    def add(self, key: str, message: str, *, fix: str = "") -> None:
        self.append(Problem(code="RF520", message=message, key=key, fix=fix))

    def add_number(self, key: str, value: float | None, rule: Rule) -> None:
        if value is None:
            return
        try:
            checked(key, value, rule)
            refuse_out_of_scale(key, value, may_vanish=rule != "positive")
        except InputError as error:
            self.add(key, error.problem.message, fix=error.problem.fix)

    def add_numbers(self, where: str, part: Roller | Tensioner | Belt) -> None:
        for name, rule in _NUMBERS[type(part)].items():
            value = getattr(part, name)
            for one in value if isinstance(value, tuple) else (value,):
                self.add_number(f"{where}.{name}", one, rule)

    def add_names(self, kind: str, names: Iterable[str]) -> None:
        for name, count in Counter(names).items():
            if not name:
                self.add(kind, f"one of the {kind} has an empty name")
            elif count > 1:
                self.add(kind, f"{count} {kind} are called '{name}'", fix="give each a name of its own")


def press_problems(
    rollers: Sequence[Roller], belts: Sequence[Belt], speed_m_s: float, span_names: Sequence[str] | None
) -> list[Problem]:
    """Return everything that is wrong with a press; empty where it can be computed."""
    found = _Problems()
    found.add_number("speed_m_s", speed_m_s, "zero or more")
    for kind, names in (("rollers", [one.name for one in rollers]), ("belts", [one.name for one in belts])):
        if not names:
            found.add(kind, f"a press without {kind} moves nothing")
        found.add_names(kind, names)
    for roller in rollers:
        _add_roller(found, roller)
    for belt in belts:
        _add_belt(found, belt, [roller.name for roller in rollers])
    if not found:  # what follows is written on the graph, which such parts do not make
        _add_spans(found, belts, span_names)
        for roller in rollers:
            _add_place(found, roller, belts)
        _add_drives(found, rollers, belts)
    return found


def _add_roller(found: _Problems, roller: Roller) -> None:
    where = f"rollers.{roller.name}"
    found.add_numbers(where, roller)
    if roller.wrap_angle_rad > 2.0 * math.pi:
        found.add(
            f"{where}.wrap_angle_rad",
            f"roller '{roller.name}' is wrapped {math.degrees(roller.wrap_angle_rad):.6g} deg; a flat belt meets "
            "itself after 360 deg",
        )
    if roller.role not in get_args(Role):
        fix = did_you_mean(str(roller.role), get_args(Role))
        found.add(f"{where}.role", f"roller '{roller.name}' has the unknown role '{roller.role}'", fix=fix)
    if (roller.tensioner is not None) != (roller.role == "tensioner"):
        says = "has no tensioner" if roller.tensioner is None else "has a tensioner"
        found.add(
            f"{where}.tensioner",
            f"roller '{roller.name}' {says}, but its role is '{roller.role}'",
            fix="give the role 'tensioner' together with spring, travel and preload",
        )
    if roller.tensioner is not None:
        found.add_numbers(f"{where}.tensioner", roller.tensioner)
        angles = (roller.tensioner.upstream_angle_rad, roller.tensioner.downstream_angle_rad)
        if all(map(math.isfinite, angles)) and sum(map(math.cos, angles)) <= 1e-9:
            found.add(
                f"{where}.tensioner",
                "the belt's two sides do not pull along the travel, so the spring cannot tension it",
            )
    if roller.overspeed is not None and roller.role != "driver":
        found.add(f"{where}.overspeed", f"roller '{roller.name}' is no driver; it has no speed of its own")


def _add_belt(found: _Problems, belt: Belt, known: Sequence[str]) -> None:
    where = f"belts.{belt.name}"
    found.add_numbers(where, belt)
    if len(belt.loop) < 2:
        found.add(
            f"{where}.loop",
            f"belt '{belt.name}' is not closed: it runs over {len(belt.loop)} roller(s), 2 are needed",
        )
    for name, count in Counter(belt.loop).items():
        if name not in known:
            fix = did_you_mean(name, known)
            found.add(f"{where}.loop", f"belt '{belt.name}' runs over the unknown roller '{name}'", fix=fix)
        if count > 1:
            found.add(
                f"{where}.loop",
                f"belt '{belt.name}' names roller '{name}' {count} times",
                fix="name each roller once; from the last one the belt returns to the first",
            )
    if belt.span_lengths_m is not None and len(belt.span_lengths_m) != len(belt.loop):
        found.add(
            f"{where}.span_lengths_m",
            f"belt '{belt.name}' has {len(belt.loop)} spans and {len(belt.span_lengths_m)} lengths",
        )


def _add_spans(found: _Problems, belts: Sequence[Belt], names: Sequence[str] | None) -> None:
    spans = spans_of(belts)
    if names is not None and len(names) != len(spans):
        steps = ", ".join(f"{span.start}-{span.end}" for span in spans)
        found.add("span_names", f"{len(names)} names for {len(spans)} spans: {steps}")
    found.add_names("span_names", names or ())
    seen: dict[tuple[str, str], tuple[str, float]] = {}
    for belt in belts:
        for step, length in zip(belt.steps, belt.span_lengths_m or (), strict=False):
            other, its = seen.setdefault(step, (belt.name, length))
            if not math.isclose(its, length, rel_tol=1e-9):
                found.add(
                    f"belts.{belt.name}.span_lengths_m",
                    f"belts '{other}' and '{belt.name}' run together from roller '{step[0]}' to '{step[1]}', "
                    f"but their lengths there are {its:g} m and {length:g} m",
                )


def _add_place(found: _Problems, roller: Roller, belts: Sequence[Belt]) -> None:
    where = f"rollers.{roller.name}"
    touching = [belt.name for belt in belts if roller.name in belt.loop]
    if not touching:
        found.add(where, f"no belt runs over roller '{roller.name}'", fix="name it in the loop of a belt")
    if roller.role == "driver" and len(touching) > 1:
        found.add(
            f"{where}.role",
            f"driver '{roller.name}' is shared by the belts {', '.join(touching)}; a driver has no torque balance, "
            "so nothing would say how they share its pull",
            fix="give each belt a driver of its own, or let this roller be driven",
        )
    if roller.role == "tensioner":
        ends = Counter(name for span in spans_of(belts) for name in {("out", span.start), ("in", span.end)})
        most = max(ends["out", roller.name], ends["in", roller.name])
        if most > 1:
            found.add(where, f"{most} spans meet tensioner '{roller.name}' on one side; it has one angle")


def _add_drives(found: _Problems, rollers: Sequence[Roller], belts: Sequence[Belt]) -> None:
    drivers = {roller.name for roller in rollers if roller.role == "driver"}
    for belt in belts:
        others = {name for other in belts if other is not belt for name in other.loop}
        if not drivers & set(belt.loop) and not others & set(belt.loop):
            found.add(f"belts.{belt.name}.loop", f"nothing drives belt '{belt.name}': its loop has no driver")
