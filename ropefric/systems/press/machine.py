"""A belt press: rollers, belts and a speed, checked as a whole."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from ropefric.errors import Problem, raise_problems
from ropefric.registry import did_you_mean
from ropefric.systems.reach import beyond_reach

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
        for step in zip(belt.loop, belt.loop[1:] + belt.loop[:1], strict=True):
            steps.setdefault(step, []).append(belt.name)
    chosen = [str(i + 1) for i in range(len(steps))] if names is None else names
    return tuple(
        Span(name=name, start=start, end=end, belts=tuple(carried))
        for name, ((start, end), carried) in zip(chosen, steps.items(), strict=False)
    )


_ROLES = ("driver", "driven", "tensioner")


def press_problems(
    rollers: Sequence[Roller], belts: Sequence[Belt], speed_m_s: float, span_names: Sequence[str] | None
) -> list[Problem]:
    """Return everything that is wrong with a press; empty where it can be computed."""
    problems: list[Problem] = []
    if not (math.isfinite(speed_m_s) and speed_m_s >= 0.0):
        problems.append(
            _problem("speed_m_s", f"the speed is {speed_m_s} m/s; it must be finite and zero or more")
        )
    elif beyond_reach(speed_m_s, may_vanish=True):
        problems.append(_beyond("speed_m_s", speed_m_s))
    for kind, parts in (("rollers", rollers), ("belts", belts)):
        if not parts:
            problems.append(_problem(kind, f"a press without {kind} moves nothing"))
        problems += _name_problems(kind, [part.name for part in parts])
    for roller in rollers:
        problems += _roller_problems(roller)
    known = [roller.name for roller in rollers]
    for belt in belts:
        problems += _belt_problems(belt, known)
    if problems:
        return problems  # what follows is written on the graph, which such parts do not make
    spans = spans_of(belts)
    problems += _span_problems(spans, span_names)
    problems += _length_problems(belts)
    for roller in rollers:
        problems += _place_problems(roller, spans, belts)
    problems += _drive_problems(rollers, belts)
    return problems


def _name_problems(kind: str, names: Iterable[str]) -> Iterator[Problem]:
    for name, count in Counter(names).items():
        if not name:
            yield _problem(kind, f"one of the {kind} has an empty name")
        elif count > 1:
            yield _problem(kind, f"{count} {kind} are called '{name}'", fix="give each a name of its own")


def _roller_problems(roller: Roller) -> Iterator[Problem]:
    where = f"rollers.{roller.name}"
    yield from _number(f"{where}.radius_m", roller.radius_m, "positive")
    yield from _number(f"{where}.wrap_angle_rad", roller.wrap_angle_rad, "positive")
    if roller.wrap_angle_rad > 2.0 * math.pi:
        yield _problem(
            f"{where}.wrap_angle_rad",
            f"roller '{roller.name}' is wrapped {math.degrees(roller.wrap_angle_rad):.6g} deg; a flat belt meets "
            "itself after 360 deg",
        )
    if roller.inertia_kg_m2 is not None:
        yield from _number(f"{where}.inertia_kg_m2", roller.inertia_kg_m2, "positive")
    yield from _number(f"{where}.gravity_torque_N_m", roller.gravity_torque_N_m, "finite")
    yield from _number(f"{where}.squeeze_torque_N_m", roller.squeeze_torque_N_m, "finite")
    if roller.role not in _ROLES:
        fix = did_you_mean(str(roller.role), _ROLES)
        yield _problem(
            f"{where}.role", f"roller '{roller.name}' has the unknown role '{roller.role}'", fix=fix
        )
    if (roller.tensioner is not None) != (roller.role == "tensioner"):
        says = "has no tensioner" if roller.tensioner is None else "has a tensioner"
        yield _problem(
            f"{where}.tensioner",
            f"roller '{roller.name}' {says}, but its role is '{roller.role}'",
            fix="give the role 'tensioner' together with spring, travel and preload",
        )
    if roller.tensioner is not None:
        yield from _tensioner_problems(f"{where}.tensioner", roller.tensioner)
    if roller.overspeed is not None:
        yield from _number(f"{where}.overspeed", roller.overspeed, "finite")
        if roller.role != "driver":
            yield _problem(
                f"{where}.overspeed", f"roller '{roller.name}' is no driver; it has no speed of its own"
            )


def _tensioner_problems(where: str, tensioner: Tensioner) -> Iterator[Problem]:
    yield from _number(f"{where}.spring_N_m", tensioner.spring_N_m, "zero or more")
    yield from _number(f"{where}.travel_m", tensioner.travel_m, "finite")
    yield from _number(f"{where}.force_N", tensioner.force_N, "zero or more")
    yield from _number(f"{where}.damping_N_s_m", tensioner.damping_N_s_m, "zero or more")
    if tensioner.mass_kg is not None:
        yield from _number(f"{where}.mass_kg", tensioner.mass_kg, "positive")
    angles = (tensioner.upstream_angle_rad, tensioner.downstream_angle_rad)
    for side, angle in zip(("upstream", "downstream"), angles, strict=True):
        yield from _number(f"{where}.{side}_angle_rad", angle, "finite")
    if all(map(math.isfinite, angles)) and sum(map(math.cos, angles)) <= 1e-9:
        yield _problem(
            where, "the belt's two sides do not pull along the travel, so the spring cannot tension it"
        )


def _belt_problems(belt: Belt, known: Sequence[str]) -> Iterator[Problem]:
    where = f"belts.{belt.name}"
    yield from _number(f"{where}.linear_density_kg_m", belt.linear_density_kg_m, "zero or more")
    yield from _number(f"{where}.thickness_m", belt.thickness_m, "positive")
    yield from _number(f"{where}.width_m", belt.width_m, "positive")
    yield from _number(f"{where}.damping_s", belt.damping_s, "zero or more")
    if belt.axial_stiffness_N is not None:
        yield from _number(f"{where}.axial_stiffness_N", belt.axial_stiffness_N, "positive")
    if len(belt.loop) < 2:
        yield _problem(
            f"{where}.loop",
            f"belt '{belt.name}' is not closed: it runs over {len(belt.loop)} roller(s), 2 are needed",
        )
    for name, count in Counter(belt.loop).items():
        if name not in known:
            fix = did_you_mean(name, known)
            yield _problem(
                f"{where}.loop", f"belt '{belt.name}' runs over the unknown roller '{name}'", fix=fix
            )
        if count > 1:
            yield _problem(
                f"{where}.loop",
                f"belt '{belt.name}' names roller '{name}' {count} times",
                fix="name each roller once; from the last one the belt returns to the first",
            )
    if belt.span_lengths_m is not None:
        if len(belt.span_lengths_m) != len(belt.loop):
            yield _problem(
                f"{where}.span_lengths_m",
                f"belt '{belt.name}' has {len(belt.loop)} spans and {len(belt.span_lengths_m)} lengths",
            )
        for length in belt.span_lengths_m:
            yield from _number(f"{where}.span_lengths_m", length, "positive")


def _span_problems(spans: Sequence[Span], names: Sequence[str] | None) -> Iterator[Problem]:
    if names is None:
        return
    if len(names) != len(spans):
        steps = ", ".join(f"{span.start}-{span.end}" for span in spans)
        yield _problem("span_names", f"{len(names)} names for {len(spans)} spans: {steps}")
    yield from _name_problems("span_names", names)


def _length_problems(belts: Sequence[Belt]) -> Iterator[Problem]:
    seen: dict[tuple[str, str], tuple[str, float]] = {}
    for belt in belts:
        steps = zip(belt.loop, belt.loop[1:] + belt.loop[:1], strict=True)
        for step, length in zip(steps, belt.span_lengths_m or (), strict=False):
            other, its = seen.setdefault(step, (belt.name, length))
            if not math.isclose(its, length, rel_tol=1e-9):
                yield _problem(
                    f"belts.{belt.name}.span_lengths_m",
                    f"belts '{other}' and '{belt.name}' run together from roller '{step[0]}' to '{step[1]}', "
                    f"but their lengths there are {its:g} m and {length:g} m",
                )


def _place_problems(roller: Roller, spans: Sequence[Span], belts: Sequence[Belt]) -> Iterator[Problem]:
    where = f"rollers.{roller.name}"
    touching = [belt.name for belt in belts if roller.name in belt.loop]
    if not touching:
        yield _problem(
            where, f"no belt runs over roller '{roller.name}'", fix="name it in the loop of a belt"
        )
    if roller.role == "driver" and len(touching) > 1:
        yield _problem(
            f"{where}.role",
            f"driver '{roller.name}' is shared by the belts {', '.join(touching)}; a driver has no torque balance, "
            "so nothing would say how they share its pull",
            fix="give each belt a driver of its own, or let this roller be driven",
        )
    if roller.role == "tensioner":
        arriving = sum(span.end == roller.name for span in spans)
        leaving = sum(span.start == roller.name for span in spans)
        if max(arriving, leaving) > 1:
            yield _problem(
                where,
                f"{max(arriving, leaving)} spans meet tensioner '{roller.name}' on one side; it has one angle",
            )


def _drive_problems(rollers: Sequence[Roller], belts: Sequence[Belt]) -> Iterator[Problem]:
    drivers = {roller.name for roller in rollers if roller.role == "driver"}
    for belt in belts:
        others = {name for other in belts if other is not belt for name in other.loop}
        if not drivers & set(belt.loop) and not others & set(belt.loop):
            yield _problem(
                f"belts.{belt.name}.loop", f"nothing drives belt '{belt.name}': its loop has no driver"
            )


def _number(key: str, value: float, rule: str) -> Iterator[Problem]:
    bad = {"positive": not value > 0.0, "zero or more": not value >= 0.0, "finite": False}[rule]
    if bad or not math.isfinite(value):
        yield _problem(
            key, f"{key} is {value:g}; it must be finite" + ("" if rule == "finite" else f" and {rule}")
        )
    elif beyond_reach(value, may_vanish=rule != "positive"):
        yield _beyond(key, value)


def _beyond(key: str, value: float) -> Problem:
    said = f"{key} is {value:g}, beyond anything from 1e-30 to 1e30 in SI units"
    return _problem(key, said, fix="check the unit it was given in")


def _problem(key: str, message: str, *, fix: str = "") -> Problem:
    return Problem(code="RF520", message=message, key=key, fix=fix)


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
