"""Scenes of a belt drive, flat or with V belts or ropes, and of a single drum: capstan or band brake."""

import math
from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from pydantic import PlainValidator

from ropefric.files.toml_model import choice, reject, whole_number
from ropefric.scenes import kind
from ropefric.section import Section
from ropefric.systems.beltdrive.drive import (
    CLOSURES,
    DriveAnswer,
    DriveProblem,
    answerable,
)
from ropefric.systems.beltdrive.effects import SYSTEM
from ropefric.systems.friction import WrapFriction

_TURN = 2.0 * math.pi
_PER_MINUTE = 60.0 / _TURN
_DEGREES = 360.0 / _TURN


class DrivingTable(kind.Table):
    """`[driving]`.

    Keys
    ----
    diameter : Of the driving pulley, drum or capstan, where the belt lies on it.
    wrap : Over which the belt lies on it; left out where it follows from the centre distance.
    speed : Its rotation.
    """

    diameter: Annotated[float, kind.key("m", "300 mm", "wheel_radius_m", factor=0.5)]
    wrap: Annotated[float | None, kind.key("rad", "180 deg", "wrap_angle_rad")] = None
    speed: Annotated[float | None, kind.key("rad/s", "1500 rpm", "speed_rad_s", or_zero=True)] = None


class DrivenTable(kind.Table):
    """`[driven]`.

    Keys
    ----
    diameter : Of the driven pulley.
    wrap : Over which the belt lies on it; one turn less the driving pulley's, if left out.
    """

    diameter: Annotated[float, kind.key("m", "600 mm", "driven_radius_m", factor=0.5)]
    wrap: Annotated[float | None, kind.key("rad", "200 deg", "driven_wrap_rad")] = None


class BeltTable(kind.Table):
    """`[belt]`.

    Keys
    ----
    count : Belts side by side.
    thickness : Of one belt, or a rope's diameter; half of it counts as the rope radius of the friction law.
    linear_density : Mass per length of one belt, for the centrifugal tension.
    groove_angle : Of a wedge groove, from flank to flank; left out for flat belts and ropes on drums.
    axial_stiffness : EA of one belt, for its creep and the length that fixed centres keep.
    span_length : Of the free belt from one pulley to the other.
    centre_distance : Of the pulleys; span, wraps and belt length follow from it.
    crossed : Whether the belt crosses itself between the pulleys.
    """

    count: Annotated[int, PlainValidator(whole_number(1, 1000)), kind.Becomes("belt_count", many=False)] = 1
    thickness: Annotated[float, kind.key("m", "5 mm", "rope_radius_m", factor=0.5)]
    linear_density: Annotated[float | None, kind.key("kg/m", "0.9 kg/m", "linear_density_kg_m")] = None
    groove_angle: Annotated[float | None, kind.key("rad", "34 deg", "groove_angle_rad")] = None
    axial_stiffness: Annotated[float | None, kind.key("N", "200 kN", "axial_stiffness_N")] = None
    span_length: Annotated[float | None, kind.key("m", "1.2 m", "span_m")] = None
    centre_distance: Annotated[float | None, kind.key("m", "1.2 m", "centre_distance_m")] = None
    crossed: bool = False


class TensionTable(kind.Table):
    """`[tension]`: of one belt, and what it is.

    Keys
    ----
    closure : What the force is: the most of the tight side, the slack side's, or the pretension at rest.
    force : Of one belt.
    """

    closure: Annotated[str, PlainValidator(choice(lambda: CLOSURES))]
    force: Annotated[float, kind.key("N", "1200 N", "tension_N")]


class LoadTable(kind.Table):
    """`[load]`.

    Keys
    ----
    power : To be carried; left out for the largest there is.
    """

    power: Annotated[float | None, kind.key("W", "7.5 kW", "power_W")] = None


class DriveScene(kind.SceneTable):
    """A scene with `system = "beltdrive"`."""

    driving: DrivingTable
    driven: DrivenTable | None = None
    belt: BeltTable
    tension: TensionTable
    load: LoadTable | None = None
    friction: kind.FrictionTable

    rules = (
        kind.one_of("driving.wrap", "belt.centre_distance"),
        kind.excludes("belt.centre_distance", "belt.span_length", "driven.wrap"),
        kind.needs("belt.centre_distance", "driven"),
        kind.needs("belt.span_length", "driven"),
        kind.needs("belt.crossed", "belt.centre_distance"),
        kind.needs("load.power", "driving.speed"),
    )

    def _check(self) -> None:
        if self.driven is not None and self.driven.wrap is None and (self.driving.wrap or 0.0) >= _TURN:
            reject(
                "RF121",
                "the driven pulley's wrap does not follow from a belt that goes round more than once",
                fix='add wrap = "180 deg" to [driven]',
                key="driven",
            )


def _problem(table: DriveScene, friction: WrapFriction) -> DriveProblem:
    # An open belt wraps both pulleys by one turn together.
    laid: dict[str, Any] = {"wrap_angle_rad": np.array([math.pi])}  # what a centre distance sets is set by it
    if table.driven is not None and table.driving.wrap is not None:
        laid["driven_wrap_rad"] = np.array([_TURN - table.driving.wrap])
    given = laid | kind.arrays(table)
    return DriveProblem(friction=friction, closure=table.tension.closure, crossed=table.belt.crossed, **given)


def _quantities(answer: DriveAnswer, problem: DriveProblem) -> tuple[kind.Quantity, ...]:
    found = {name: getattr(answer, name) for name in ("full_pull_N", "full_tight_N", "full_slack_N")}
    if problem.speed_rad_s is not None:
        found["full_power_W"] = answer.full_power_W
    if problem.power_W is not None:
        found["utilisation"] = answer.utilisation
    return tuple(kind.Quantity(name, value, positive=True) for name, value in found.items())


def _failures(answer: DriveAnswer, problem: DriveProblem) -> tuple[kind.Failure, ...]:
    strained = kind.strained("a belt", answer.strain.max(axis=0))
    if problem.power_W is None:
        return (strained,)
    use, slack_N = answer.utilisation, answer.slack_N
    return (
        kind.Failure("the belts slip: they do not carry the power", "utilisation", use, use > 1.0),
        kind.Failure("a belt goes slack at work", "slack side in N", slack_N, slack_N <= 0.0, limit=0.0),
        strained,
    )


def _tree(answer: DriveAnswer, problem: DriveProblem) -> dict[str, Any]:
    speed_m_s = None if problem.speed_rad_s is None else float(problem.belt_speed_m_s[0])
    tree: dict[str, Any] = {"closure": problem.closure, "belt_speed_m_s": speed_m_s}
    tree |= kind.first(answer, "circling_N")
    if problem.belt_length_m is not None and problem.span_m is not None:
        tree["span_m"], tree["belt_length_m"] = float(problem.span_m[0]), float(problem.belt_length_m[0])
    tree["keeps_length"] = problem.closure == "fixed" and problem.span_m is not None
    work_W = float((answer.pull_N * problem.belt_speed_m_s)[0])
    tree["at_work"] = kind.first(answer, "tight_N", "slack_N", "pull_N") | {
        "torque_N_m": float((answer.pull_N * problem.wheel_radius_m)[0]),
        "power_W": work_W,
    }
    wraps = {"driving": problem.wrap_angle_rad, "driven": problem.driven_wrap_rad}
    tree["pulleys"] = {
        name: {
            "wrap_angle_rad": float(wrap[0]),
            "mu": float(answer.coefficients[place, 0]),
            "slip_arc_rad": kind.finite(answer.slip_arc_rad[place, 0]),
        }
        for place, (name, wrap) in enumerate(wraps.items())
        if wrap is not None
    }
    if problem.driven_radius_m is not None:
        ratio = float(answer.speed_ratio[0])
        tree["creep"] = {"speed_ratio": ratio, "power_lost_W": work_W * (1.0 - ratio)}
        if problem.speed_rad_s is not None:
            gear = problem.wheel_radius_m / problem.driven_radius_m
            tree["pulleys"]["driven"]["speed_rad_s"] = float((problem.speed_rad_s * gear)[0]) * ratio
    elif problem.closure == "tensioner":
        # Held at its slack end a band brakes by the more; the other way round it holds at the tight end.
        least = float(np.exp(-answer.exponents[0, 0]))
        tree["at_work"]["reversed_torque_N_m"] = tree["at_work"]["torque_N_m"] * least
    return tree


def _sections(tree: Mapping[str, Any]) -> tuple[Section, ...]:
    work = tree["at_work"]
    lines = [
        (
            f"at work: T1 = {work['tight_N']:.5g} N, T2 = {work['slack_N']:.5g} N a belt, "
            f"{tree['circling_N']:.4g} N of it to keep it on its circle; torque {work['torque_N_m']:.5g} N m"
        )
    ]
    if "belt_length_m" in tree:
        lines.append(f"belt length {tree['belt_length_m']:.6g} m, of it {tree['span_m']:.6g} m in each span")
    if tree["closure"] == "fixed" and not tree["keeps_length"]:
        lines.append("no span length is given: T1 + T2 = 2 T, as of spans much longer than the arcs")
    if "reversed_torque_N_m" in work:
        lines.append(f"turning the other way, against the band: torque {work['reversed_torque_N_m']:.5g} N m")
    if tree.get("creep", {}).get("power_lost_W"):
        creep = tree["creep"]
        lines.append(
            f"creep: the driven rim runs {100 * (1 - creep['speed_ratio']):.3g} % slower, which loses "
            f"{creep['power_lost_W']:.4g} W"
        )
    columns: kind.Columns = {
        "wrap [deg]": ("wrap_angle_rad", ".1f", _DEGREES),
        "slips over [deg]": ("slip_arc_rad", ".1f", _DEGREES),
        "mu with groove": ("mu", ".4g"),
        "driven [rpm]": ("speed_rad_s", ".5g", _PER_MINUTE),
    }
    return (kind.by_rows("Belt and pulleys", "pulley", tree["pulleys"], columns, lines=tuple(lines)),)


KIND = kind.Kind(
    name="beltdrive",
    schema=DriveScene,
    system=SYSTEM,
    own_wheel=lambda table: (0.5 * table.driving.diameter, 0.5 * table.belt.thickness),
    problem=_problem,
    quantities=_quantities,
    tree=_tree,
    contacts=lambda problem: kind.at_contact(problem, problem.tension_N),
    answerable=answerable,
    failures=_failures,
    sections=_sections,
    beyond={
        "circling_N": "what keeps the belt on its circle",
        "creep.power_lost_W": "the power that creep takes",
    },
    words={
        "full_pull_N": "Largest pull of all belts [N]",
        "full_tight_N": "Tight side at the largest pull, a belt [N]",
        "full_slack_N": "Slack side at the largest pull, a belt [N]",
        "full_power_W": "Largest power of all belts at this speed [W]",
        "utilisation": "Share of the largest pull at work",
    },
)
