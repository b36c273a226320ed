"""Scenes of a belt press: tensions, slip, and the start-up."""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from inspect import signature
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field, PlainValidator

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import RopefricError
from ropefric.files.toml_model import choice, got, quantity, reject, whole_number
from ropefric.scenes import kind
from ropefric.section import Section
from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.answer import PressAnswer, PressProblem, settles, slip_margins
from ropefric.systems.press.effects import SYSTEM
from ropefric.systems.press.machine import (
    Belt,
    Press,
    Roller,
    Tensioner,
    gravity_torque_N_m,
    squeeze_torque_N_m,
)
from ropefric.systems.press.slip import MEASURES
from ropefric.systems.press.statics import CLOSURES, solve_statics, steady_state
from ropefric.systems.press.transient.drives import DRIVE_LAWS
from ropefric.systems.press.transient.motion import settled_press

_ROLES = ("driver", "driven", "tensioner")


def _names(value: object) -> tuple[str, ...]:
    if not isinstance(value, list) or not value or not all(isinstance(one, str) for one in value):
        reject("RF110", f"expected a list of roller names, got {got(value)}", fix='write ["1", "2", "3"]')
    return tuple(value)


class TensionerTable(kind.Table):
    """`[rollers.NAME.tensioner]`.

    Keys
    ----
    spring : Stiffness k_1 that presses the roller into the belt.
    travel : x, compression of its spring in the given position.
    force : Its own preload F, in place of that of all.
    mass : Of the roller with what moves with it; for a start-up.
    damping : C_1 of its travel; for a start-up.
    upstream_angle : Between its travel and the span that arrives.
    downstream_angle : Between its travel and the span that leaves.
    """

    spring: Annotated[float, kind.key("N/m", "20 N/mm", "spring_N_m", or_zero=True)] = 0.0
    travel: Annotated[float, kind.key("m", "30 mm", "travel_m", above=None)] = 0.0
    force: Annotated[float | None, kind.key("N", "2000 N", "force_N")] = None
    mass: Annotated[float | None, kind.key("kg", "121 kg", "mass_kg")] = None
    damping: Annotated[float, kind.key("N*s/m", "500 N*s/m", "damping_N_s_m", or_zero=True)] = 0.0
    upstream_angle: Annotated[float, kind.key("rad", "56.7 deg", "upstream_angle_rad", above=None)] = 0.0
    downstream_angle: Annotated[float, kind.key("rad", "19.9 deg", "downstream_angle_rad", above=None)] = 0.0


class RollerTable(kind.Table):
    """`[rollers.NAME]`.

    Keys
    ----
    radius : R_i, to the belt.
    wrap : α_i, over which the belt lies on it.
    role : Whether a motor drives it, the belt does, or it tightens the belt, too.
    inertia : J about its axle; for a start-up.
    gravity_torque : M_G, by the sludge's weight that it drags along.
    squeeze_torque : M_F, by squeezing the sludge.
    overspeed : Of a driver: by which share its rim is faster than the press's speed; for the closure speed-ratio.
    """

    radius: Annotated[float, kind.key("m", "75 mm", "radius_m")]
    wrap: Annotated[float, kind.key("rad", "163.3 deg", "wrap_angle_rad")]
    role: Annotated[str, PlainValidator(choice(lambda: _ROLES)), kind.Becomes("role")] = "driven"
    inertia: Annotated[float | None, kind.key("kg*m^2", "2.5 kg*m^2", "inertia_kg_m2")] = None
    gravity_torque: Annotated[float, kind.key("N*m", "26.2 N*m", "gravity_torque_N_m", above=None)] = 0.0
    squeeze_torque: Annotated[float, kind.key("N*m", "33.6 N*m", "squeeze_torque_N_m", above=None)] = 0.0
    overspeed: Annotated[float | None, PlainValidator(kind.number), kind.Becomes("overspeed")] = None
    tensioner: TensionerTable | None = None

    def _check(self) -> None:
        if (self.role == "tensioner") != (self.tensioner is not None):
            reject(
                "RF121",
                "a tensioner is a roller of that role with a table of its own",
                fix='write role = "tensioner" and [rollers.NAME.tensioner], or neither',
                key="role",
            )


class BeltTable(kind.Table):
    """`[belts.NAME]`.

    Keys
    ----
    loop : The rollers it runs over, by name, in the order of travel.
    width : b.
    thickness : h; half of it counts as the rope radius of the friction law.
    density : Of the belt; or give its mass per length.
    linear_density : Mass per length; or give its density.
    axial_stiffness : EA; for creep and start-up, and between fixed centres.
    damping : Ratio of damping to stiffness of its spans; for a start-up.
    span_lengths : Of its spans, in the order of the loop; for a start-up, and between fixed centres.
    pretension : Set at rest without loads between fixed centres, in place of a tensioner: the belt keeps its length.
    """

    loop: Annotated[tuple[str, ...], PlainValidator(_names), kind.Becomes("loop")]
    width: Annotated[float, kind.key("m", "2 m", "width_m")]
    thickness: Annotated[float, kind.key("m", "5 mm", "thickness_m")]
    density: Annotated[float | None, kind.key("kg/m^3", "1500 kg/m^3")] = None
    linear_density: Annotated[float | None, kind.key("kg/m", "15 kg/m", "linear_density_kg_m")] = None
    axial_stiffness: Annotated[float | None, kind.key("N", "2000 kN", "axial_stiffness_N")] = None
    damping: Annotated[float, kind.key("s", "1 ms", "damping_s", or_zero=True)] = 0.0
    span_lengths: Annotated[
        list[Annotated[float, kind.key("m", "1.2 m")]] | None, kind.Becomes("span_lengths_m")
    ] = None
    pretension: Annotated[float | None, kind.key("N", "1500 N", "pretension_N")] = None

    rules = (kind.one_of("density", "linear_density"),)


class MachineTable(kind.Table):
    """`[press]`.

    Keys
    ----
    speed : Of the belts; or give the rotation.
    rotation : Of the first driver; or give the speed.
    preload : F of all tensioners that have no force of their own.
    load_factor : Times which the torques of the sludge are taken.
    closure : Condition that divides the load between the drivers, where the balances leave it open.
    """

    speed: Annotated[float | None, kind.key("m/s", "0.92 m/s", "speed_m_s", or_zero=True)] = None
    rotation: Annotated[float | None, kind.key("rad/s", "50 rpm", or_zero=True)] = None
    preload: Annotated[float | None, kind.key("N", "2000 N", "preload_N")] = None
    load_factor: Annotated[float, PlainValidator(kind.zero_or_more), kind.Becomes("load_factor")] = 1.0
    closure: Annotated[str, PlainValidator(choice(lambda: CLOSURES))] = "share"

    rules = (kind.one_of("rotation", "speed"),)


class GravityTable(kind.Table):
    """`[sludge.gravity]`, eqs. (5), (6).

    Keys
    ----
    friction : μ_f of the sludge's weight on the bars.
    height : Of the sludge.
    density : Of the sludge.
    width : Of the belt.
    zones : Length of the zone whose sludge each roller drags along.
    """

    friction: Annotated[float, PlainValidator(kind.positive), kind.Becomes("sludge_friction")]
    height: Annotated[float, kind.key("m", "60 mm", "sludge_height_m")]
    density: Annotated[float, kind.key("kg/m^3", "1000 kg/m^3", "sludge_density_kg_m3")]
    width: Annotated[float, kind.key("m", "2 m", "belt_width_m")]
    zones: Annotated[dict[str, float], kind.by_name(quantity("m", "1.2 m", above=0), '"2" = "1.2 m"')]


class SqueezeTable(kind.Table):
    """`[sludge.squeeze]`, eqs. (7)-(9).

    Keys
    ----
    width : Of the belt.
    compression : Δh, by which the sludge is squeezed.
    strength : σ_c of the sludge.
    poisson_ratio : μ_c of the sludge.
    youngs_modulus : E_c of the sludge.
    units : How many units of squeezing each roller carries.
    """

    width: Annotated[float, kind.key("m", "2 m", "belt_width_m")]
    compression: Annotated[float, kind.key("m", "10 mm", "compression_m")]
    strength: Annotated[float, kind.key("Pa", "30 kPa", "strength_Pa")]
    poisson_ratio: Annotated[float, PlainValidator(kind.zero_or_more), kind.Becomes("poisson_ratio")]
    youngs_modulus: Annotated[float, kind.key("Pa", "300 kPa", "youngs_modulus_Pa")]
    units: Annotated[dict[str, float], kind.by_name(kind.positive, '"5" = 2, "6" = 1')]


class SludgeTable(kind.Table):
    """`[sludge]`: loads from the sludge, in place of torques."""

    gravity: GravityTable | None = None
    squeeze: SqueezeTable | None = None


class StartUpTable(kind.Table):
    """`[start_up]`.

    Keys
    ----
    law : How the drive's speed rises.
    duration : Of the rise; of a ramp and an s-curve.
    times : Of a table.
    speeds : Of a table, at its times.
    simulate : How long the start-up is followed.
    points : Times at which the answer is written down.
    loads : Whether the sludge's torques grow with the speed or are whole from the start.
    """

    law: Annotated[str, PlainValidator(choice(lambda: DRIVE_LAWS))] = "s-curve"
    duration: Annotated[float | None, kind.key("s", "5 s")] = None
    times: list[Annotated[float, kind.key("s", "1 s", above=None)]] | None = None
    speeds: list[Annotated[float, kind.key("m/s", "0.5 m/s", above=None)]] | None = None
    simulate: Annotated[float, kind.key("s", "20 s")]
    points: Annotated[int, PlainValidator(whole_number(2, 200_000))] = 2001
    loads: Annotated[str, PlainValidator(choice(lambda: ("with-speed", "constant")))] = "with-speed"
    gone: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("integrator", "step", "tolerance"), "remove it; a start-up is solved by matrix exponentials"
    ) | {"slip": "remove it; a large coefficient lets no belt slip"}

    def _check(self) -> None:
        needed = {"table": ("times", "speeds"), "ramp": ("duration",), "s-curve": ("duration",)}
        for name in needed.get(self.law, ()):
            if getattr(self, name) is None:
                reject("RF121", f"the drive law {self.law} needs {name}", fix=f"add {name}", key="law")


class PressScene(kind.SceneTable):
    """A scene with `system = "press"`."""

    press: MachineTable
    rollers: dict[str, RollerTable]
    belts: dict[str, BeltTable]
    friction: kind.FrictionTable
    sludge: SludgeTable = Field(default_factory=SludgeTable)
    start_up: StartUpTable | None = None

    def _check(self) -> None:
        for name, roller in self.rollers.items():
            if roller.tensioner is not None and roller.tensioner.force is None and self.press.preload is None:
                reject(
                    "RF121",
                    f"tensioner {name} has no force",
                    fix='add force = "2000 N" to it, or preload = "2000 N" to [press] for all',
                    key=f"rollers.{name}.tensioner",
                )
        for part, torque, shares in (
            ("gravity", "gravity_torque", "zones"),
            ("squeeze", "squeeze_torque", "units"),
        ):
            for name in getattr(getattr(self.sludge, part), shares, {}):
                if name not in self.rollers:
                    reject("RF120", f"sludge.{part} names the unknown roller {name!r}", key=f"sludge.{part}")
                if getattr(self.rollers[name], torque):
                    reject(
                        "RF111",
                        f"roller {name} has a {torque} and a share of sludge.{part}",
                        fix="keep one of them",
                        key=f"rollers.{name}.{torque}",
                    )


def _problem(table: PressScene, friction: WrapFriction) -> PressProblem:
    speed_m_s = table.press.speed
    if speed_m_s is None:
        drivers = [roller for roller in table.rollers.values() if roller.role == "driver"]
        speed_m_s = (table.press.rotation or 0.0) * (drivers[0].radius if drivers else 0.0)
    press = Press(
        rollers=tuple(_roller(table, name, one) for name, one in table.rollers.items()),
        belts=tuple(_belt(name, one) for name, one in table.belts.items()),
        speed_m_s=speed_m_s,
    )
    return PressProblem(
        press=press,
        closure=table.press.closure,
        friction=friction,
        start_up=None if table.start_up is None else _task(table.start_up, speed_m_s),
        **{"speed_m_s": np.array([speed_m_s])} | kind.arrays(table.press),
    )


def _roller(table: PressScene, name: str, one: RollerTable) -> Roller:
    """Return a roller, with the torques that the sludge puts on it."""
    parts = kind.given(one)
    if one.tensioner is not None:
        # A force of its own comes before the one preload of all tensioners.
        force = {"force_N": table.press.preload or 0.0, "is_shared": one.tensioner.force is None}
        parts["tensioner"] = Tensioner(**force | kind.given(one.tensioner))
    gravity, squeeze = table.sludge.gravity, table.sludge.squeeze
    if gravity is not None and name in gravity.zones:
        zone = {"zone_length_m": gravity.zones[name], "radius_m": one.radius}
        parts["gravity_torque_N_m"] = float(gravity_torque_N_m(**kind.given(gravity), **zone))
    if squeeze is not None and name in squeeze.units:
        squeezed = {"units": squeeze.units[name], "radius_m": one.radius}
        parts["squeeze_torque_N_m"] = float(squeeze_torque_N_m(**kind.given(squeeze), **squeezed))
    return Roller(name=name, **parts)


def _belt(name: str, one: BeltTable) -> Belt:
    mass = {"linear_density_kg_m": (one.density or 0.0) * one.width * one.thickness}
    lengths = {} if one.span_lengths is None else {"span_lengths_m": tuple(one.span_lengths)}
    return Belt(name=name, **mass | kind.given(one) | lengths)


def _task(table: StartUpTable, speed_m_s: float) -> dict[str, Any]:
    law = DRIVE_LAWS[table.law]
    known = {
        "speed_m_s": table.speeds if table.law == "table" else speed_m_s,
        "duration_s": table.duration,
        "time_s": table.times,
    }
    return {
        "speed": law(**{name: known[name] for name in signature(law).parameters}),
        "time_s": np.linspace(0.0, table.simulate, table.points),
        "loads": table.loads,
    }


def _own_wheel(table: PressScene) -> tuple[float, float]:
    """Return the middle roller's radius and half the first belt's thickness."""
    radii = sorted(roller.radius for roller in table.rollers.values())
    belts = list(table.belts.values())
    return (radii[len(radii) // 2] if radii else 1.0), (0.5 * belts[0].thickness if belts else 0.005)


def _contacts(problem: PressProblem) -> Mapping[str, FloatArray]:
    """Return every roller once, with the tension of its belt at rest."""
    press, forces_N = problem.press, [one.force_N for one in problem.press.tensioners.values()]
    halves = [0.5 * max(belt.thickness_m for belt in press.belts_on(one.name)) for one in press.rollers]
    forces_N += [2.0 * (belt.pretension_N or 0.0) for belt in press.fixed_belts]
    set_N = np.array([max(forces_N, default=2.0)]) if problem.preload_N is None else problem.preload_N
    wraps_rad = np.array([one.wrap_angle_rad for one in press.rollers])
    # Of each case all rollers.
    return {
        "wheel_radius_m": np.tile(press.radius_m, set_N.size),
        "rope_radius_m": np.tile(halves, set_N.size),
        "wrap_angle_rad": np.tile(wraps_rad, set_N.size),
        "end_tension_N": np.repeat(0.5 * set_N, len(press.rollers)),
    }


def _answerable(problem: PressProblem) -> BoolArray:
    """Return where no span is slack at rest; speed can only slacken further."""
    still = steady_state(
        solve_statics(problem.press, closure=problem.closure),
        preload_N=problem.preload_N,
        speed_m_s=np.zeros(problem.n),
        load_factor=problem.load_factor,
        on_slack="flag",
        friction=problem.friction,
    )
    return np.asarray(~still.slack)


def _quantities(answer: PressAnswer, _: PressProblem) -> tuple[kind.Quantity, ...]:
    slip, tensions_N = answer.slip, answer.state.effective_tension_N
    return (
        kind.Quantity("largest_utilisation", slip.utilisation.max(axis=-1)),
        kind.Quantity("power_W", answer.state.drive_power_W),
        *(
            kind.Quantity(f"slip.{name}.{measure}", getattr(slip, measure)[..., place])
            for measure in ("utilisation", "as_plotted", "as_printed")
            for place, name in enumerate(slip.rollers)
        ),
        *(
            kind.Quantity(f"effective_tension_N.{span.name}", tensions_N[..., place])
            for place, span in enumerate(answer.model.press.spans)
        ),
    )


def _outcomes(answer: PressAnswer, _: PressProblem) -> tuple[kind.Quantity, ...]:
    """Return what a start-up amounts to: the extremes, whether and how long anything slipped, and the works."""
    if answer.start_up is None:
        return ()
    summary = answer.start_up.summary()
    found = {
        "peak_tension_N": max(summary["peak_tension_N"].values()),
        "lowest_tension_N": min(summary["lowest_tension_N"].values()),
        "peak_utilisation": max(summary["peak_utilisation"].values()),
        "slips": float(bool(summary["slipping_s"])),
        "slipping_s": sum(summary["slipping_s"].values()),
        "drive_work_J": summary["drive_work_J"],
        "slip_loss_J": summary["slip_loss_J"],
    }
    return tuple(kind.Quantity(f"start_up.{name}", np.array([value])) for name, value in found.items())


def _failures(answer: PressAnswer, problem: PressProblem) -> tuple[kind.Failure, ...]:
    """Return the slip of a press that runs steadily; in a start-up slip is simulated, and part of the answer.

    Either may stretch a belt too far.
    """
    press, tension_N = problem.press, answer.state.tension_N
    if problem.start_up is not None:
        if answer.start_up is None:
            return ()
        found, tension_N = [], answer.start_up.tension_N.max(axis=0)[np.newaxis]
    else:
        largest = answer.slip.utilisation.max(axis=-1)
        words = "a roller slips, so a steady run is not possible"
        found = [kind.Failure(words, "largest utilisation", largest, largest > 1.0)]
    if all(belt.axial_stiffness_N is not None for belt in press.belts):
        stiffness_N = np.array([belt.axial_stiffness_N for belt in press.belts]) @ press.carried
        found.append(kind.strained("a belt", (tension_N / stiffness_N).max(axis=-1)))
    return tuple(found)


def _undecided(answer: PressAnswer, _: PressProblem, error: float) -> tuple[str, ...]:
    """Return which rollers may slip or not, and which may be the first; utilisations err by a share of the largest."""
    use, rollers = answer.slip.utilisation[0], answer.slip.rollers
    lifted = np.isinf(use)  # a belt that has lifted off slips for sure
    off = error * float(use[~lifted].max(initial=0.0)) / (1.0 - error) if error < 1.0 else math.inf
    slip = [name for name, one in zip(rollers, use, strict=True) if abs(one - 1.0) <= off]
    first = [name for name, one in zip(rollers, use, strict=True) if one + 2.0 * off >= use.max()]
    found = [f"whether the belt slips on roller {' or '.join(slip)}"] if slip else []
    if use.any() and len(first) > 1 and not lifted.any():
        found.append(f"which is the first to slip, roller {' or '.join(first)}")
    return tuple(found)


def _by_name(names: Sequence[str], values: FloatArray) -> dict[str, float]:
    return dict(zip(names, values.tolist(), strict=True))


def _tree(answer: PressAnswer, _: PressProblem) -> dict[str, Any]:
    press, given, slip = answer.model.press, answer.model.problem.press, answer.slip
    factor = float(answer.model.problem.load_factor[0])
    arc_m = {one.name: one.radius_m * one.wrap_angle_rad for one in press.rollers}
    spans = [span.name for span in press.spans]
    tree: dict[str, Any] = {
        "tension_N": _by_name(spans, answer.at_rest_N[0]),
        "effective_tension_N": _by_name(spans, answer.state.effective_tension_N[0]),
        "slip": {
            roller: {measure: kind.finite(slip.of(roller, measure)[0]) for measure in MEASURES}
            for roller in slip.rollers
        },
        "fixed_centres": {
            belt.name: {
                "pretension_N": belt.pretension_N,
                "arcs_m": (arcs_m := sum(arc_m[name] for name in belt.loop)),
                "belt_length_m": sum(belt.span_lengths_m or ()) + arcs_m,
            }
            for belt in press.fixed_belts
        },
        "closure": answer.statics.closure,
        "rank": answer.statics.rank,
        "undetermined": list(answer.statics.undetermined),
        "speed_m_s": float(answer.state.speed_m_s[0]),
        # What the torques given stand for: pulls M_G/R, eq. (6), and Δh K_max times the squeezes, eq. (9).
        "loads": {
            "by_roller": {
                one.name: {
                    "gravity_pull_N": factor * one.gravity_torque_N_m / one.radius_m,
                    "squeeze_N_m": factor
                    * one.squeeze_torque_N_m
                    / (max(belt.width_m for belt in press.belts_on(one.name)) * one.radius_m),
                }
                for one in given.rollers
                if one.torque_N_m
            },
            "total_N": factor * sum(one.torque_N_m / one.radius_m for one in given.rollers),
        },
        "creep": {
            "rim_speed_m_s": _by_name(slip.rollers, answer.rim_speed_m_s[0]),
            "power_lost_W": float(answer.creep_loss_W[0]),
        },
        **slip_margins(answer),
    }
    with suppress(RopefricError):  # without EA, or with a belt that is slack at rest
        ends = settled_press(answer.model.as_operated, tree["speed_m_s"], answer.model.effects)
        if ends is not None:
            tree["sticking"] = {
                "tension_N": _by_name(spans, ends.tension_N),
                "relative_angle_rad": _by_name(slip.rollers, ends.relative_way_m / press.radius_m),
                "travel_m": _by_name(list(press.tensioners), ends.travel_m),
            }
    if answer.start_up is None:
        return tree
    return tree | {"start_up": answer.start_up.summary() | {"settles": settles(answer)}}


_CHANGES = {
    "preload": ("the mean preload falls to", "the mean preload rises to", "no preload holds"),
    "speed": ("the belts run no faster than", "the belts run as fast as", "no slower run of the belts holds"),
    "load": ("all loads fall by the factor", "all loads grow by the factor", "no smaller loads hold"),
    "friction": ("the coefficient falls to", "the coefficient rises to", "no scaled friction holds"),
}
"""Changes that lead to the first slip or end the last one, by what changes: it falls, it rises, nothing ends it."""


def _sections(tree: Mapping[str, Any]) -> tuple[Section, ...]:
    slips, creep = tree["slip"], tree["creep"]
    uncertain = {"± std": ("utilisation_std", ".2g")}
    columns = {"utilisation": ("utilisation", ".4g")}
    columns |= uncertain if any("utilisation_std" in one for one in slips.values()) else {}
    # The ratios of the paper, `as_printed` and `as_plotted`, are in the JSON answer and the notebook on the paper.
    columns |= {one.replace("_", " "): (one, ".4g") for one in ("log", "mu_required")}
    tensions = {
        name: {"rest": tension_N, "speed": tree["effective_tension_N"][name]}
        for name, tension_N in tree["tension_N"].items()
    }
    forms: kind.Columns = {"T at rest [N]": ("rest", ".1f"), "T' at speed [N]": ("speed", ".1f")}
    lines = tuple(
        f"belt {name} keeps its length between fixed centres: {one['belt_length_m']:.6g} m, set to "
        f"{one['pretension_N']:.6g} N at rest without loads"
        for name, one in tree["fixed_centres"].items()
    )
    found = [
        kind.by_rows("Tensions", "span", tensions, forms, notes=tuple(tree["undetermined"]), lines=lines),
        kind.by_rows("Slip", "roller", slips, columns, lines=_slip_lines(tree)),
    ]
    if creep["power_lost_W"] and not tree["slips"]:
        rims = creep["rim_speed_m_s"].items()
        rims = {name: {"rim": one, "slower": 1.0 - one / tree["speed_m_s"]} for name, one in rims}
        forms = {"rim [m/s]": ("rim", ".6g"), "slower by [%]": ("slower", ".3g", 100.0)}
        line = f"the belts' stretch takes {creep['power_lost_W']:.4g} W of the drivers' power"
        found.append(kind.by_rows("Creep", "roller", rims, forms, lines=(line,)))
    return (*found, *([_start_up(tree)] if "start_up" in tree else []))


def _slip_lines(tree: Mapping[str, Any]) -> tuple[str, ...]:
    slips, alone = tree["slips"], len(tree["slips"]) == 1
    if slips:
        uses = {name: tree["slip"][name]["utilisation"] for name in slips}
        found = ", ".join(
            f"{name} ({'its belt lifts off, or has no friction' if use is None else f'utilisation {use:.3g}'})"
            for name, use in uses.items()
        )
        lines = [f"rollers that slip already: {found}; a steady run is not possible"]
    elif tree["first_to_slip"] is None:
        lines = ["no roller carries a torque"]
    else:
        lines = [f"no roller slips; nearest to it is roller {tree['first_to_slip']}"]
    for change, (falls, rises, never) in _CHANGES.items():
        one, slipping = tree["critical"][change], tree["critical"][change]["state"] == "slips"
        if one["value"] is None:
            lines += [f"{never} {'it' if alone else 'them all'}"] * slipping
            continue
        unit = "" if one["unit"].startswith(("factor", "-")) else f" {one['unit']}"
        at = f"{falls if one['direction'] == 'falls' else rises} {one['value']:.4g}{unit}"
        last = "it stops" if alone else f"the last of them, roller {one['roller']}, stops"
        lines.append(f"{last} where {at}" if slipping else f"if {at}, roller {one['roller']} slips first")
    return tuple(lines)


def _start_up(tree: Mapping[str, Any]) -> Section:
    found, settles = tree["start_up"], tree["start_up"]["settles"]
    highest_N, lowest_N = found["peak_tension_N"], min(found["lowest_tension_N"].values())
    peak, settling = max(highest_N, key=highest_N.__getitem__), str(settles["why"])
    if not settles["steady"] and settles["differs_N"] is None:
        settling = f"the steady run is not reached: {settling}"
    elif not settles["steady"]:
        at_N, span = found["settled_tension_N"][settles["span"]], settles["span"]
        apart = f"{settles['differs_N']:+.1f} N from the steady run"
        settling = f"it settles at {at_N:.1f} N in span {span}, {apart}: {settling}"
    lines = (
        f"highest tension: {highest_N[peak]:.1f} N in span {peak}; lowest anywhere: {lowest_N:.1f} N",
        f"work of the drives: {found['drive_work_J']:.4g} J, of which slip takes {found['slip_loss_J']:.4g} J",
        f"the energy balance closes to {abs(found['energy_residual']):.1g}",
        settling,
    )
    names = {
        "peak utilisation": "peak_utilisation",
        "first slip [s]": "first_slip_s",
        "slips for [s]": "slipping_s",
    }
    rows = {roller: {name: found[name].get(roller) for name in names.values()} for roller in tree["slip"]}
    columns = {heading: (name, ".4g") for heading, name in names.items()}
    return kind.by_rows("Start-up", "roller", rows, columns, lines=lines)


def _start_up_columns(answer: PressAnswer) -> dict[str, FloatArray] | None:
    """Return the histories of a start-up; columns end in a span's or roller's name: `tension_N.8`, `travel_m.3`."""
    found = answer.start_up
    if found is None:
        return None
    rollers = [roller.name for roller in found.press.rollers]
    members = {
        "tension_N": [span.name for span in found.press.spans],
        "travel_m": list(found.press.tensioners),
        **dict.fromkeys(("roller_speed_rad_s", "relative_angle_rad", "contact"), rollers),
        **dict.fromkeys(("slip_m", "slip_speed_m_s", "friction_N", "utilisation", "as_printed"), rollers),
    }
    columns = {"time_s": found.time_s, "drive_speed_m_s": found.drive_speed_m_s}
    for name, ends in members.items():
        values = getattr(found, name)
        columns |= {f"{name}.{end}": values[:, i].astype(np.float64) for i, end in enumerate(ends)}
    return columns


KIND = kind.Kind(
    name="press",
    schema=PressScene,
    system=SYSTEM,
    own_wheel=_own_wheel,
    problem=_problem,
    quantities=_quantities,
    outcomes=_outcomes,
    tree=_tree,
    contacts=_contacts,
    in_one_call=lambda problem: problem.start_up is None,  # one start-up is simulated at a time
    answerable=_answerable,
    failures=_failures,
    beyond={
        "critical": "what has to change until a roller slips, and which is the first",
        "sticking": "angles and travels of belts that stick from standstill on",
        "creep.power_lost_W": "the power that creep takes",
    },
    undecided=_undecided,
    # A span goes slack for want of preload; a roller has a table of its own.
    keys={"span": "press.preload", "roller": "rollers.{}"},
    sections=_sections,
    histories={"start_up.csv": _start_up_columns},
    figures={
        "start_up_figure": kind.Figure(lambda answer, problem: answer.start_up, "draw_press_start_up")  # noqa: ARG005
    },
)
