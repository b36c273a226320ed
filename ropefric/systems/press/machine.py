"""A belt press: rollers, belts and a speed, checked as a whole, with the matrices of its balances.

With the incidence matrix D (+1 where a span leaves a roller, −1 where it arrives) and the pull matrix P of the
tensioners the equations (10)-(22) are, for all rollers and tensioners at once,

    J θ̈ = diag(R) D T − M,        m ẍ + C1 ẋ + k1 x = P T' − F,        T' = T − v² w,

with w the mass per length of all belts of a span; the drivers' rows of the first give the torque their motors must
supply. By virtual work the same matrices give what a span is stretched by: e = −Dᵀ (R θ) − Pᵀ x.

Examples
--------
>>> drive = Roller(name="drive", radius_m=0.1, wrap_angle_rad=3.0, role="driver")
>>> load = Roller(name="load", radius_m=0.2, wrap_angle_rad=3.0, role="tensioner", gravity_torque_N_m=5.0,
...     tensioner=Tensioner(spring_N_m=0.0, travel_m=0.0, force_N=1000.0))
>>> belt = Belt(name="belt", loop=("drive", "load"), linear_density_kg_m=15, thickness_m=0.005, width_m=1)
>>> press = Press(rollers=(drive, load), belts=(belt,), speed_m_s=1.0)
>>> press.out_of.tolist(), press.into.tolist()
([[1.0, 0.0], [0.0, 1.0]], [[0.0, 1.0], [1.0, 0.0]])
>>> press.incidence.tolist(), press.pull.tolist(), press.carried.tolist()
([[1.0, -1.0], [-1.0, 1.0]], [[1.0, 1.0]], [[1.0, 1.0]])
>>> press.rim_load_N.tolist(), press.is_driven.tolist(), press.density_kg_m.tolist()
([0.0, 25.0], [False, True], [15.0, 15.0])
"""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import InputError, Problem, raise_problems
from ropefric.registry import did_you_mean
from ropefric.systems.checks import checked, rules_of

Role = Literal["driver", "driven", "tensioner"]
Positive = Annotated[float, "positive"]
NotNegative = Annotated[float, "zero or more"]
Finite = Annotated[float, "any"]
"""Ranges of the numbers of a part; all are finite."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tensioner:
    """The spring, preload and geometry that carry a translating roller.

    Its equation of motion is m ẍ + C1 ẋ + k1 x = T'_in cos(upstream) + T'_out cos(downstream) − F with the tensions
    T' = T − ρAv², eqs. (21), (22).
    """

    spring_N_m: NotNegative
    travel_m: Finite
    force_N: NotNegative
    mass_kg: Positive | None = None
    damping_N_s_m: NotNegative = 0.0
    upstream_angle_rad: Finite = 0.0
    downstream_angle_rad: Finite = 0.0
    is_shared: bool = True
    """Whether a preload that is given for all tensioners replaces its own."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Roller:
    """A roller and the torques that hold it back."""

    name: str
    radius_m: Positive
    wrap_angle_rad: Positive
    role: Role = "driven"
    inertia_kg_m2: Positive | None = None
    gravity_torque_N_m: Finite = 0.0
    squeeze_torque_N_m: Finite = 0.0
    tensioner: Tensioner | None = None
    overspeed: Finite | None = None

    @property
    def torque_N_m(self) -> float:
        """Return the whole torque M = M_G + M_F that the belt has to overcome [N m]."""
        return self.gravity_torque_N_m + self.squeeze_torque_N_m


@dataclass(frozen=True, slots=True, kw_only=True)
class Belt:
    """A belt and the way it takes; one with a pretension lies between fixed centres and keeps its unstretched length."""

    name: str
    loop: tuple[str, ...]
    linear_density_kg_m: NotNegative
    thickness_m: Positive
    width_m: Positive
    axial_stiffness_N: Positive | None = None
    damping_s: NotNegative = 0.0
    span_lengths_m: Annotated[tuple[float, ...], "positive"] | None = None
    pretension_N: Positive | None = None

    @property
    def steps(self) -> tuple[tuple[str, str], ...]:
        """Return from which roller to which the belt runs, once round."""
        return tuple(zip(self.loop, self.loop[1:] + self.loop[:1], strict=True))


class Span(NamedTuple):
    """A piece of belt from one roller to the next; where belts run together it carries all of them."""

    name: str
    start: str
    end: str
    belts: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)  # no slots: spans and matrices are kept
class Press:
    """The drive train of a belt filter press, or of any machine of rollers and closed belts.

    Spans come in the order of the first belt's loop, then what the second adds, and so on; arrays over spans, rollers
    and tensioners in the order of these.
    """

    rollers: tuple[Roller, ...]
    belts: tuple[Belt, ...]
    speed_m_s: NotNegative

    def __post_init__(self) -> None:
        raise_problems(_problems(self))

    @cached_property
    def spans(self) -> tuple[Span, ...]:
        """Return the spans."""
        steps: dict[tuple[str, str], list[str]] = {}
        for belt in self.belts:
            for step in belt.steps:
                steps.setdefault(step, []).append(belt.name)
        return tuple(
            Span(str(i), *step, tuple(carried)) for i, (step, carried) in enumerate(steps.items(), 1)
        )

    @property
    def tensioners(self) -> dict[str, Tensioner]:
        """Return what carries the rollers that translate, by their names."""
        return {one.name: one.tensioner for one in self.rollers if one.tensioner is not None}

    @property
    def fixed_belts(self) -> tuple[Belt, ...]:
        """Return the belts between fixed centres."""
        return tuple(belt for belt in self.belts if belt.pretension_N is not None)

    @cached_property
    def preload_N(self) -> FloatArray:
        """Return what sets the level of the tensions: the tensioners' forces, then the pretensions of fixed belts."""
        forces = [one.force_N for one in self.tensioners.values()]
        return np.array([*forces, *(belt.pretension_N or 0.0 for belt in self.fixed_belts)])

    @cached_property
    def is_shared(self) -> BoolArray:
        """Return which of these a preload of all tensioners replaces."""
        return np.array(
            [one.is_shared for one in self.tensioners.values()] + [False] * len(self.fixed_belts), dtype=bool
        )

    @property
    def drivers(self) -> tuple[Roller, ...]:
        """Return the rollers that motors turn."""
        return tuple(roller for roller in self.rollers if roller.role == "driver")

    def belts_on(self, roller: str) -> list[Belt]:
        """Return the belts that run over a roller."""
        return [belt for belt in self.belts if roller in belt.loop]

    @cached_property
    def into(self) -> FloatArray:
        """Return 1 where a span arrives at a roller, else 0; shape (n_rollers, n_spans)."""
        return np.array([[float(span.end == roller.name) for span in self.spans] for roller in self.rollers])

    @cached_property
    def out_of(self) -> FloatArray:
        """Return 1 where a span leaves a roller, else 0; shape (n_rollers, n_spans)."""
        return np.array(
            [[float(span.start == roller.name) for span in self.spans] for roller in self.rollers]
        )

    @cached_property
    def incidence(self) -> FloatArray:
        """Return D, shape (n_rollers, n_spans): D T is the net pull of the belts on each roller's rim [N]."""
        return self.out_of - self.into

    @cached_property
    def pull(self) -> FloatArray:
        """Return P, shape (n_tensioners, n_spans): P T' is the belts' pull along each travel, eqs. (21), (22) [N]."""
        angles = [(one.upstream_angle_rad, one.downstream_angle_rad) for one in self.tensioners.values()]
        arriving, leaving = np.cos(angles).reshape(-1, 2).T[..., np.newaxis]
        which = [roller.tensioner is not None for roller in self.rollers]
        return np.asarray(arriving * self.into[which] + leaving * self.out_of[which])

    @cached_property
    def carried(self) -> FloatArray:
        """Return 1 where a belt runs in a span, else 0; shape (n_belts, n_spans)."""
        return np.array([[float(belt.name in span.belts) for span in self.spans] for belt in self.belts])

    @cached_property
    def density_kg_m(self) -> FloatArray:
        """Return w, shape (n_spans,): mass per length of all belts in each span; v² w is their ρAv²."""
        return np.array([belt.linear_density_kg_m for belt in self.belts]) @ self.carried

    @cached_property
    def radius_m(self) -> FloatArray:
        """Return R, shape (n_rollers,)."""
        return np.array([roller.radius_m for roller in self.rollers])

    @cached_property
    def wrap_angle_rad(self) -> FloatArray:
        """Return α, shape (n_rollers,)."""
        return np.array([roller.wrap_angle_rad for roller in self.rollers])

    @cached_property
    def half_thickness_m(self) -> FloatArray:
        """Return half the mean thickness of the belts on each roller, shape (n_rollers,)."""
        belts = [self.belts_on(roller.name) for roller in self.rollers]
        return np.array([0.5 * sum(belt.thickness_m for belt in on) / len(on) for on in belts])

    @cached_property
    def rim_load_N(self) -> FloatArray:
        """Return M/R, shape (n_rollers,)."""
        return np.array([roller.torque_N_m for roller in self.rollers]) / self.radius_m

    @cached_property
    def is_driven(self) -> BoolArray:
        """Return which rollers obey a torque balance, shape (n_rollers,): all but the drivers."""
        return np.array([roller.role != "driver" for roller in self.rollers])

    @property
    def missing_elasticity(self) -> list[str]:
        """Return the fields that are missing for belts that stretch."""
        return [
            f"belts.{belt.name}.{name}"
            for belt in self.belts
            for name in ("axial_stiffness_N", "span_lengths_m")
            if getattr(belt, name) is None
        ]

    @property
    def missing_masses(self) -> list[str]:
        """Return the fields that are missing for what moves in a start-up; the drivers do whatever they weigh."""
        driven = [roller for roller in self.rollers if roller.role != "driver"]
        carriers = self.tensioners.items()
        return [f"rollers.{one.name}.inertia_kg_m2" for one in driven if one.inertia_kg_m2 is None] + [
            f"rollers.{name}.tensioner.mass_kg" for name, one in carriers if one.mass_kg is None
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


Said = Iterator[tuple[bool, str, str, str]]
"""A check: whether it fails, its key, its message and its fix."""


def _problems(press: Press) -> list[Problem]:
    """Return all errors of a press; those of its graph only where its parts make one."""

    def found(said: Said) -> list[Problem]:
        return [
            Problem(code="RF520", message=message, key=key, fix=fix)
            for wrong, key, message, fix in said
            if wrong
        ]

    return found(chain(_numbers(press), _parts(press))) or found(_graph(press))


def _numbers(press: Press) -> Said:
    parts: list[tuple[str, Any]] = [("", press)]
    for roller in press.rollers:
        parts += [
            (f"rollers.{roller.name}.", roller),
            (f"rollers.{roller.name}.tensioner.", roller.tensioner),
        ]
    parts += [(f"belts.{belt.name}.", belt) for belt in press.belts]
    for where, part in parts:
        for name, rule in rules_of(type(part)).items() if part is not None else ():  # type: ignore[arg-type]  # hashable
            value = getattr(part, name)
            for one in value if isinstance(value, tuple) else () if value is None else (value,):
                try:
                    checked(where + name, one, rule)
                except InputError as error:
                    yield True, where + name, error.problem.message, error.problem.fix


def _parts(press: Press) -> Said:
    for kind, names in (
        ("rollers", [one.name for one in press.rollers]),
        ("belts", [one.name for one in press.belts]),
    ):
        yield not names, kind, f"a press without {kind} moves nothing", ""
        yield "" in names, kind, f"one of the {kind} has an empty name", ""
        fix = "write it without; in slip.2.utilisation points separate the parts of a name"
        for name in names:
            yield "." in name, kind, f"the name '{name}' of one of the {kind} has a point", fix
    for roller in press.rollers:
        where, what, carrier = f"rollers.{roller.name}", f"roller '{roller.name}'", roller.tensioner
        wrapped = f"{what} is wrapped {math.degrees(roller.wrap_angle_rad):.6g} deg; a flat belt meets itself after "
        yield roller.wrap_angle_rad > 2.0 * math.pi, f"{where}.wrap_angle_rad", f"{wrapped}360 deg", ""
        if carrier is not None:
            with np.errstate(invalid="ignore"):
                pulls = np.cos([carrier.upstream_angle_rad, carrier.downstream_angle_rad]).sum()
            loose = "the belt's two sides do not pull along the travel, so the spring cannot tension it"
            yield bool(pulls <= 1e-9), f"{where}.tensioner", loose, ""
        own = f"{what} is no driver; it has no speed of its own"
        yield roller.overspeed is not None and roller.role != "driver", f"{where}.overspeed", own, ""
    known = [roller.name for roller in press.rollers]
    for belt in press.belts:
        where, what, n = f"belts.{belt.name}", f"belt '{belt.name}'", len(belt.loop)
        yield n < 2, f"{where}.loop", f"{what} is not closed: it runs over {n} roller(s), 2 are needed", ""
        for name, count in Counter(belt.loop).items():
            unknown = f"{what} runs over the unknown roller '{name}'"
            yield name not in known, f"{where}.loop", unknown, did_you_mean(name, known)
            fix = "name each roller once; from the last one the belt returns to the first"
            yield count > 1, f"{where}.loop", f"{what} names roller '{name}' {count} times", fix
        lengths = n if belt.span_lengths_m is None else len(belt.span_lengths_m)
        yield lengths != n, f"{where}.span_lengths_m", f"{what} has {n} spans and {lengths} lengths", ""
    for key in press.missing_elasticity if press.fixed_belts else []:
        message = f"a belt between fixed centres keeps a length that needs {key}"
        yield True, key, message, "give it, or put the belt on a tensioner in place of its pretension"


def _graph(press: Press) -> Said:
    seen: dict[tuple[str, str], tuple[str, float]] = {}
    for belt in press.belts:
        for step, length in zip(belt.steps, belt.span_lengths_m or (), strict=False):
            other, its = seen.setdefault(step, (belt.name, length))
            message = (
                f"belts '{other}' and '{belt.name}' run together from roller '{step[0]}' to '{step[1]}', "
                f"but their lengths there are {its:g} m and {length:g} m"
            )
            wrong = not math.isclose(its, length, rel_tol=1e-9)
            yield wrong, f"belts.{belt.name}.span_lengths_m", message, ""
    for belt in press.belts:
        yield from _held(press, belt)
    for place, roller in enumerate(press.rollers):
        where, name, touching = f"rollers.{roller.name}", roller.name, press.belts_on(roller.name)
        yield not touching, where, f"no belt runs over roller '{name}'", "name it in the loop of a belt"
        message = (
            f"driver '{name}' is shared by the belts {', '.join(belt.name for belt in touching)}; a driver has no "
            "torque balance, so nothing would say how they share its pull"
        )
        fix = "give each belt a driver of its own, or let this roller be driven"
        yield roller.role == "driver" and len(touching) > 1, f"{where}.role", message, fix
        most = int(max(one[place].sum() for one in (press.into, press.out_of)))
        message = f"{most} spans meet tensioner '{name}' on one side; it has one angle"
        yield roller.role == "tensioner" and most > 1, where, message, ""


def _held(press: Press, belt: Belt) -> Said:
    """Yield what a belt lacks that is driven and has one tension."""
    where, drivers = f"belts.{belt.name}", {roller.name for roller in press.drivers}
    others = {name for other in press.belts if other is not belt for name in other.loop}
    message = f"nothing drives belt '{belt.name}': its loop has no driver"
    yield not (drivers | others) & set(belt.loop), f"{where}.loop", message, ""
    if belt.pretension_N is not None:
        carriers = (press.tensioners.keys() & set(belt.loop)) - others
        names = " and ".join(f"'{name}'" for name in sorted(carriers))
        message = f"belt '{belt.name}' has a pretension, but tensioner {names} sets its tension"
        fix = "leave out the pretension, or let the roller be driven"
        yield bool(carriers), f"{where}.pretension_N", message, fix


GRAVITY_M_S2 = 9.81


def gravity_torque_N_m(
    *,
    sludge_friction: npt.ArrayLike,
    belt_width_m: npt.ArrayLike,
    sludge_height_m: npt.ArrayLike,
    sludge_density_kg_m3: npt.ArrayLike,
    zone_length_m: npt.ArrayLike,
    radius_m: npt.ArrayLike,
) -> FloatArray:
    """Return M_G = R μ_f b h ρ_s g l, for the pull that the sludge's weight asks of the belt, eqs. (5), (6)."""
    area_m2 = np.multiply(belt_width_m, zone_length_m)
    weight_N = GRAVITY_M_S2 * area_m2 * np.multiply(sludge_height_m, sludge_density_kg_m3)
    return np.asarray(np.multiply(sludge_friction, radius_m) * weight_N)


def squeeze_torque_N_m(
    *,
    belt_width_m: npt.ArrayLike,
    radius_m: npt.ArrayLike,
    compression_m: npt.ArrayLike,
    strength_Pa: npt.ArrayLike,
    poisson_ratio: npt.ArrayLike,
    youngs_modulus_Pa: npt.ArrayLike,
    units: npt.ArrayLike = 1.0,
) -> FloatArray:
    """Return M_F = b R Δh K_max of squeezing the cake this many times, K_max = (1 + μ_c) σ_c²/(3 E_c), eqs. (7)-(9)."""
    stiffer = 1.0 + checked("poisson_ratio", poisson_ratio, "zero or more")
    limit_J_m3 = np.square(strength_Pa) * stiffer / np.multiply(3.0, youngs_modulus_Pa)
    return np.asarray(np.multiply(belt_width_m, radius_m) * np.multiply(compression_m, units) * limit_J_m3)
