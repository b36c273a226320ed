"""Scenes of a belt drive, flat or with V belts or ropes, and of a single drum: capstan or band brake."""

import math
from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from pydantic import PlainValidator

from ropefric.files.toml_model import choice, reject, whole_number
from ropefric.scenes import kind
from ropefric.section import Chart, Line, Section
from ropefric.systems.beltdrive.drive import (
    CLOSURES,
    DriveAnswer,
    DriveProblem,
    answerable,
    best_speed_m_s,
    brake_of,
    needed_width_m,
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
    stress : Allowable; with it and a power the width follows.
    density : Of the belt; its mass then grows with the width that is sought.
    """

    count: Annotated[int, PlainValidator(whole_number(1, 1000)), kind.Becomes("belt_count", many=False)] = 1
    thickness: Annotated[float, kind.key("m", "5 mm", "rope_radius_m", factor=0.5)]
    linear_density: Annotated[float | None, kind.key("kg/m", "0.9 kg/m", "linear_density_kg_m")] = None
    groove_angle: Annotated[float | None, kind.key("rad", "34 deg", "groove_angle_rad")] = None
    axial_stiffness: Annotated[float | None, kind.key("N", "200 kN", "axial_stiffness_N")] = None
    span_length: Annotated[float | None, kind.key("m", "1.2 m", "span_m")] = None
    centre_distance: Annotated[float | None, kind.key("m", "1.2 m", "centre_distance_m")] = None
    crossed: bool = False
    stress: Annotated[float | None, kind.key("Pa", "2 MPa", "stress_Pa")] = None
    density: Annotated[float | None, kind.key("kg/m^3", "1000 kg/m^3", "density_kg_m3")] = None

    rules = (kind.needs("density", "stress"), kind.excludes("density", "linear_density"))


class TensionTable(kind.Table):
    """`[tension]`: of one belt, and what it is.

    Keys
    ----
    closure : What the force is: the most of the tight side, the slack side's, the pretension at rest, a lever's effort.
    force : Of one belt.
    """

    closure: Annotated[str, PlainValidator(choice(lambda: CLOSURES))]
    force: Annotated[float, kind.key("N", "1200 N", "tension_N")]


class BrakeTable(kind.Table):
    """`[brake]`: the lever of a band brake, for the closure lever; the force is then the effort at its end.

    Keys
    ----
    lever : Arm of the effort about the fulcrum.
    tight_arm : Arm of the band's tight end; 0 at the fulcrum, negative where its pull helps the effort.
    slack_arm : Arm of the band's slack end, likewise.
    torque : To be held; gives the effort that it takes.
    """

    lever: Annotated[float, kind.key("m", "400 mm", "lever_m")]
    tight_arm: Annotated[float, kind.key("m", "80 mm", "tight_arm_m", above=None)] = 0.0
    slack_arm: Annotated[float, kind.key("m", "150 mm", "slack_arm_m", above=None)] = 0.0
    torque: Annotated[float | None, kind.key("N*m", "350 N*m", "brake_torque_N_m")] = None


class LoadTable(kind.Table):
    """`[load]`.

    Keys
    ----
    power : To be carried; left out for the largest there is.
    """

    power: Annotated[float | None, kind.key("W", "7.5 kW", "power_W", or_zero=True)] = None


class DriveScene(kind.SceneTable):
    """A scene with `system = "beltdrive"`."""

    driving: DrivingTable
    driven: DrivenTable | None = None
    belt: BeltTable
    tension: TensionTable
    brake: BrakeTable | None = None
    load: LoadTable | None = None
    friction: kind.FrictionTable

    rules = (
        kind.one_of("driving.wrap", "belt.centre_distance"),
        kind.excludes("belt.centre_distance", "belt.span_length", "driven.wrap"),
        kind.excludes("brake", "driven", "load"),
        kind.needs("belt.centre_distance", "driven"),
        kind.needs("belt.span_length", "driven"),
        kind.needs("belt.crossed", "belt.centre_distance"),
        kind.needs("load.power", "driving.speed"),
    )

    def _check(self) -> None:
        if (self.brake is not None) != (self.tension.closure == "lever"):
            fix = 'write closure = "lever" and [brake], or neither'
            reject("RF121", "the closure lever is that of a band brake", fix=fix, key="tension.closure")
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
    found["initial_tension_N"] = 0.5 * (answer.full_tight_N + answer.full_slack_N)
    if problem.speed_rad_s is not None:
        found["full_power_W"] = answer.full_power_W
    if problem.power_W is not None:
        found["utilisation"] = answer.utilisation
        found["belts_needed"] = answer.utilisation * problem.belt_count
    if (width_m := needed_width_m(answer)) is not None:
        found["needed_width_m"] = width_m
    quantities = [kind.Quantity(name, value, positive=True) for name, value in found.items()]
    if (brake := brake_of(answer)) is not None:
        named = {name: value for name, value in brake._asdict().items() if value is not None}
        named["torque_N_m"] = answer.pull_N * problem.wheel_radius_m
        # A brake that holds by itself needs a negative effort.
        quantities += [kind.Quantity(f"brake.{name}", value) for name, value in named.items()]
    return tuple(quantities)


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


def _belts(utilisation: float, problem: DriveProblem) -> int | None:
    """Return how many belts the power takes; None where no number of them carries it."""
    if math.isinf(utilisation):
        return None
    return max(1, math.ceil(utilisation * float(problem.belt_count[0]) - 1e-9))


def _undecided(answer: DriveAnswer, problem: DriveProblem, error: float) -> tuple[str, ...]:
    if problem.power_W is None:
        return ()
    use = float(answer.utilisation[0])
    least, most = (_belts(end, problem) for end in (use / (1.0 + error), use * (1.0 + error)))
    return () if least == most else (f"the power takes {least} to {most} belts",)


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
            "adhesion_arc_rad": kind.finite(wrap[0] - answer.slip_arc_rad[place, 0]),
        }
        for place, (name, wrap) in enumerate(wraps.items())
        if wrap is not None
    }
    if problem.driven_radius_m is not None:
        ratio = float(answer.speed_ratio[0])
        creep = {"speed_ratio": ratio, "power_lost_W": work_W * (1.0 - ratio)}
        tree["creep"] = {name: kind.finite(value) for name, value in creep.items()}
        if problem.speed_rad_s is not None:
            gear = problem.wheel_radius_m / problem.driven_radius_m
            tree["pulleys"]["driven"]["speed_rad_s"] = kind.finite((problem.speed_rad_s * gear)[0] * ratio)
    elif problem.closure == "tensioner":
        # Held at its slack end a band brakes by the more; the other way round it holds at the tight end.
        least = float(np.exp(-answer.exponents[0, 0]))
        tree["at_work"]["reversed_torque_N_m"] = tree["at_work"]["torque_N_m"] * least
    best = best_speed_m_s(problem)
    if best is not None:
        share = answer.full_pull_N / (problem.tension_N - answer.circling_N)
        tree["best"] = {
            "speed_m_s": float(best[0]),
            "rotation_rad_s": float((best / problem.wheel_radius_m)[0]),
            "power_W": float((share * problem.tension_N * 2.0 / 3.0 * best)[0]),
        }
    if problem.power_W is not None:
        tree["belts"] = _belts(float(answer.utilisation[0]), problem)
    return tree


def _sections(tree: Mapping[str, Any]) -> tuple[Section, ...]:
    work, best = tree["at_work"], tree.get("best")
    use = tree.get("utilisation", 0.0)
    slips = use is None or use > 1.0
    lines = [
        (
            f"{'for the power asked for' if slips else 'at work'}: T1 = {work['tight_N']:.5g} N, "
            f"T2 = {work['slack_N']:.5g} N a belt, "
            f"{tree['circling_N']:.4g} N of it to keep it on its circle; torque {work['torque_N_m']:.5g} N m"
        )
    ]
    if "belt_length_m" in tree:
        lines.append(f"belt length {tree['belt_length_m']:.6g} m, of it {tree['span_m']:.6g} m in each span")
    if tree["closure"] == "fixed" and not tree["keeps_length"]:
        lines.append("no span length is given: T1 + T2 = 2 T, as of spans much longer than the arcs")
    lines += _brake_lines(tree.get("brake", {}))
    if "reversed_torque_N_m" in work:
        lines.append(f"turning the other way, against the band: torque {work['reversed_torque_N_m']:.5g} N m")
    if tree.get("belts") is not None:
        belts = "belts" if tree["belts"] > 1 else "belt"
        lines.append(f"the power takes {tree['belts']} {belts} with this tension")
    if best is not None:
        lines.append(
            f"best speed: {best['speed_m_s']:.4g} m/s, {best['rotation_rad_s'] * _PER_MINUTE:.5g} rpm of the driving "
            f"pulley, for {best['power_W']:.5g} W at most"
        )
    if tree.get("creep", {}).get("power_lost_W"):
        creep = tree["creep"]
        lines.append(
            f"creep: the driven rim runs {100 * (1 - creep['speed_ratio']):.3g} % slower, which loses "
            f"{creep['power_lost_W']:.4g} W"
        )
    columns: kind.Columns = {
        "wrap [deg]": ("wrap_angle_rad", ".1f", _DEGREES),
        "slips over [deg]": ("slip_arc_rad", ".1f", _DEGREES),
        "adheres over [deg]": ("adhesion_arc_rad", ".1f", _DEGREES),
        "mu with groove": ("mu", ".4g"),
        "driven [rpm]": ("speed_rad_s", ".5g", _PER_MINUTE),
    }
    return (kind.by_rows("Belt and pulleys", "pulley", tree["pulleys"], columns, lines=tuple(lines)),)


def _brake_lines(brake: Mapping[str, Any]) -> list[str]:
    if not brake:
        return []
    back = brake["reversed_torque_N_m"]
    other = "locks by itself" if back is None else f"brakes with {back:.5g} N m"
    lines = [f"the effort brakes with {brake['torque_N_m']:.5g} N m; turning the other way it {other}"]
    for name, way in (
        ("needed_effort_N", "the torque to be held"),
        ("reversed_effort_N", "turning the other way"),
    ):
        if brake.get(name) is not None:
            held = " or less: it locks by itself" if brake[name] <= 0.0 else ""
            lines.append(f"{way} takes an effort of {brake[name]:.5g} N{held}")
    return lines


def _power_chart(answer: DriveAnswer, problem: DriveProblem) -> Chart | None:
    best = best_speed_m_s(problem)
    if best is None or problem.linear_density_kg_m is None:
        return None
    fastest = math.sqrt(3.0) * float(best[0])
    speeds = np.linspace(0.0, fastest, 201)
    share = float((answer.full_pull_N / (problem.tension_N - answer.circling_N))[0])
    power_kW = 1e-3 * share * speeds * (problem.tension_N[0] - problem.linear_density_kg_m[0] * speeds**2)
    at_best = np.full(2, best[0]), np.array([0.0, power_kW.max()])
    lines = [Line("at most", speeds, power_kW), Line(f"best speed {best[0]:.4g} m/s", *at_best, limit=True)]
    if problem.speed_rad_s is not None:
        work_W = answer.pull_N * problem.belt_speed_m_s
        lines.append(Line("at work", problem.belt_speed_m_s[:1], 1e-3 * work_W[:1]))
    axes = "belt_speed_m_s", "Belt speed v [m/s]", "power_kW", "Power P [kW]"
    return Chart("Power of all belts over their speed", *axes, tuple(lines))


def _arcs_chart(answer: DriveAnswer, problem: DriveProblem) -> Chart | None:
    """Return the tension round each pulley: constant where the belt adheres, then changing until it leaves."""
    wraps = [problem.wrap_angle_rad[0]]
    wraps += [] if problem.driven_wrap_rad is None else [problem.driven_wrap_rad[0]]
    slips = answer.slip_arc_rad[: len(wraps), 0]
    if np.isnan(slips).any():
        return None
    circling_N, lines = answer.circling_N[0], []
    enters = (answer.tight_N[0] - circling_N, answer.slack_N[0] - circling_N)
    for place, (name, wrap) in enumerate(zip(("driving pulley", "driven pulley"), wraps, strict=False)):
        angle = np.linspace(0.0, wrap, 201)
        grown = answer.coefficients[place, 0] * np.maximum(angle - (wrap - slips[place]), 0.0)
        tension_N = circling_N + enters[place] * np.exp(-grown if place == 0 else grown)
        lines.append(Line(name, np.degrees(angle), tension_N))
    axes = "angle_deg", "Angle from where the belt arrives [deg]", "tension_N", "Tension T [N]"
    return Chart(
        "Tension of a belt round its pulleys: it adheres first, and slips where it leaves",
        *axes,
        tuple(lines),
    )


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
        "pulleys.driving.adhesion_arc_rad": "the arc of adhesion on the driving pulley",
        "pulleys.driven.adhesion_arc_rad": "the arc of adhesion on the driven pulley",
        "creep.power_lost_W": "the power that creep takes",
    },
    undecided=_undecided,
    figures={"belt_power": kind.Figure(_power_chart), "belt_arcs": kind.Figure(_arcs_chart)},
    words={
        "full_pull_N": "Largest pull of all belts [N]",
        "full_tight_N": "Tight side at the largest pull, a belt [N]",
        "full_slack_N": "Slack side at the largest pull, a belt [N]",
        "initial_tension_N": "Initial tension for the largest pull, (T1 + T2)/2 a belt [N]",
        "full_power_W": "Largest power of all belts at this speed [W]",
        "utilisation": "Share of the largest pull at work",
        "needed_width_m": "Width of each belt that the power takes [m]",
        "belts_needed": "Belts that the power takes, before rounding up",
    },
)
