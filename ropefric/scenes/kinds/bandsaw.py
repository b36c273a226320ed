"""Scenes of a band saw: the frequencies of its blade at rest and running, and what may shake it."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field, PlainValidator

from ropefric import section
from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError
from ropefric.files.plain_text import significant
from ropefric.files.toml_model import choice, reject, whole_number
from ropefric.scenes import kind
from ropefric.systems.bandsaw import resonance
from ropefric.systems.bandsaw.answer import SawAnswer, SawModel, SawProblem, answerable, solve_saw
from ropefric.systems.bandsaw.effects import SYSTEM
from ropefric.systems.bandsaw.saw import Excitation, Section, Side, tension_difference_N, torque_N_m
from ropefric.systems.bandsaw.span import ENDS
from ropefric.systems.effect import assemble
from ropefric.systems.friction import WrapFriction

_RUNNING = (Side.TIGHT, Side.SLACK)


class BladeTable(kind.Table):
    """`[blade]`.

    Keys
    ----
    free_span : l, between the points where blade and wheels part.
    linear_density : ρA; or give width, thickness and density.
    width : b of its section.
    thickness : h of its section.
    density : ρ of the steel.
    youngs_modulus : E, for bending and for what feed the blade bears.
    shear_modulus : G, for torsion and for what feed the blade bears.
    bending_stiffness : EI, in place of what the section gives.
    ends : How wheels or guides hold the ends of the span.
    modes : How many modes are computed.
    """

    free_span: Annotated[float, kind.key("m", "1.6 m", "free_span_m")]
    linear_density: Annotated[
        float | None, kind.key("kg/m", "0.6 kg/m", "linear_density_kg_m", many=False)
    ] = None
    width: Annotated[float | None, kind.key("m", "85 mm")] = None
    thickness: Annotated[float | None, kind.key("m", "0.9 mm")] = None
    density: Annotated[float | None, kind.key("kg/m^3", "7800 kg/m^3")] = None
    youngs_modulus: Annotated[float | None, kind.key("Pa", "206 GPa")] = None
    shear_modulus: Annotated[float | None, kind.key("Pa", "79 GPa")] = None
    bending_stiffness: Annotated[float | None, kind.key("N*m^2", "1.06 N*m^2", "bending_stiffness_N_m2")] = (
        None
    )
    ends: Annotated[str, PlainValidator(choice(lambda: ENDS))] = "clamped"
    modes: Annotated[int, PlainValidator(whole_number(1, 40))] = 6

    rules = (kind.one_of("linear_density", "density"), kind.needs("density", "width", "thickness"))


class WheelTable(kind.Table):
    """`[wheel]`.

    Keys
    ----
    radius : R; or give the diameter.
    diameter : 2R; or give the radius.
    speed : Rotation n, which makes the blade's speed v = ωR.
    wrap : Over which the blade lies on a wheel; for the friction it needs.
    """

    radius: Annotated[float | None, kind.key("m", "0.35 m", "wheel_radius_m", many=False)] = None
    diameter: Annotated[float | None, kind.key("m", "0.7 m", "wheel_radius_m", factor=0.5, many=False)] = None
    speed: Annotated[float, kind.key("rad/s", "970 rpm", "wheel_speed_rad_s", many=False, or_zero=True)] = 0.0
    wrap: Annotated[float, kind.key("rad", "180 deg", "wheel_wrap_rad", many=False)] = np.pi

    rules = (kind.one_of("radius", "diameter"),)


_share = kind.number_where(
    lambda one: 0.0 <= one <= 1.0,
    "from 0 to 1",
    "give 0 for fixed wheel axles, 1 for a constant-force mounting",
)


class TensionTable(kind.Table):
    """`[tension]`.

    Keys
    ----
    preload : F_0 of a side at rest.
    mounting_factor : κ: 0 where the axles keep their place, 1 where a constant force presses them apart.
    """

    preload: Annotated[float, kind.key("N", "3412 N", "preload_N")]
    mounting_factor: Annotated[float | None, PlainValidator(_share), kind.Becomes("mounting_factor")] = None


class DriveTable(kind.Table):
    """`[drive]`.

    Keys
    ----
    power : P at the wheel; or give torque or tension_difference.
    torque : M at the wheel; or give power or tension_difference.
    tension_difference : ΔF = F_1 - F_2; or give power or torque.
    printed_factor : Whether M = 9549 P/n is taken as printed, with the rounded factor.
    """

    power: Annotated[float | None, kind.key("W", "7.5 kW", or_zero=True)] = None
    torque: Annotated[float | None, kind.key("N*m", "73.8 N*m", or_zero=True)] = None
    tension_difference: Annotated[
        float | None, kind.key("N", "211 N", "tension_difference_N", or_zero=True)
    ] = None
    printed_factor: bool = False

    rules = (kind.one_of("power", "torque", "tension_difference"),)


_margin = kind.number_where(lambda one: 0.0 < one < 1.0, "between 0 and 1", "write 0.1 for 10 %")


class ExcitationTable(kind.Table):
    """`[excitation]`.

    Keys
    ----
    wheel_harmonics : Multiples of the wheel's rotation that may shake the blade.
    tooth_pitch : Between teeth, whose passing shakes the blade.
    frequencies : Others, such as the mains'.
    margin : How far, as a share, every mode is to stay from what shakes it.
    preload_range : The preloads that may be recommended for that, the lower first.
    """

    wheel_harmonics: Annotated[int, PlainValidator(whole_number(0, 50))] = 3
    tooth_pitch: Annotated[float | None, kind.key("m", "22 mm")] = None
    frequencies: list[Annotated[float, kind.key("Hz", "50 Hz")]] = Field(default_factory=list)
    margin: Annotated[float | None, PlainValidator(_margin)] = None
    preload_range: list[Annotated[float, kind.key("N", "3000 N")]] | None = None

    rules = (kind.needs("margin", "preload_range"), kind.needs("preload_range", "margin"))

    def _check(self) -> None:
        ends = self.preload_range
        if ends is not None and (len(ends) != 2 or not ends[0] < ends[1]):
            reject("RF110", "a range is two preloads, the lower first", key="preload_range")


class FeedTable(kind.Table):
    """`[feed]`: what pushes the wood against the teeth.

    Keys
    ----
    force : That pushes the wood against the teeth.
    guide_distance : Between the guides; the free span, if it is left out.
    """

    force: Annotated[float, kind.key("N", "150 N", "feed_force_N")]
    guide_distance: Annotated[float | None, kind.key("m", "0.4 m", "guided_m", many=False)] = None


class SawScene(kind.SceneTable):
    """A scene with `system = "bandsaw"`."""

    blade: BladeTable
    tension: TensionTable
    wheel: WheelTable | None = None
    drive: DriveTable | None = None
    excitation: ExcitationTable | None = None
    feed: FeedTable | None = None
    gone: ClassVar[Mapping[str, str]] = {
        "measured": "remove it; compare the frequencies of the answer with the measured ones"
    }

    rules = (
        kind.needs("drive", "wheel"),
        kind.needs("feed", "blade.width", "blade.thickness", "blade.youngs_modulus", "blade.shear_modulus"),
    )

    def _check(self) -> None:
        if self.drive is not None and self.drive.power is not None and not (self.wheel and self.wheel.speed):
            fix = 'add speed = "970 rpm" to [wheel]'
            reject("RF121", "drive.power needs wheel.speed", fix=fix, key="wheel.speed")


_UNKNOWN_THICKNESS_M = 1e-3


def _own_wheel(table: SawScene) -> tuple[float, float]:
    radius_m = 1.0 if table.wheel is None else kind.given(table.wheel)["wheel_radius_m"]
    return radius_m, 0.5 * (table.blade.thickness or _UNKNOWN_THICKNESS_M)


def _problem(table: SawScene, friction: WrapFriction | None) -> SawProblem:
    shaken = table.excitation or ExcitationTable()
    computed, section = _section_of(table.blade)
    if (pull_N := _computed_pull_N(table)) is not None:
        computed["tension_difference_N"] = pull_N
    return SawProblem(
        n_modes=table.blade.modes,
        ends=ENDS[table.blade.ends],
        section=section,
        friction=friction,
        excitations=_excitations(table),
        margin_wanted=shaken.margin,
        preload_range_N=shaken.preload_range,
        **{name: np.array([value]) for name, value in computed.items()} | kind.arrays(table),
    )


def _section_of(blade: BladeTable) -> tuple[dict[str, float], Section | None]:
    """Return what a blade's section makes of its mass and stiffness, and the section itself where its steel is known."""
    if blade.width is None or blade.thickness is None:
        return {}, None
    area_m2 = blade.width * blade.thickness
    density = blade.density if blade.linear_density is None else blade.linear_density / area_m2
    computed = {"linear_density_kg_m": area_m2 * (density or 0.0)}
    steel = {"density_kg_m3": density or 0.0}
    if blade.youngs_modulus is not None:
        computed["bending_stiffness_N_m2"] = blade.youngs_modulus * area_m2 * blade.thickness**2 / 12.0
        steel["young_modulus_Pa"] = blade.youngs_modulus
    if blade.shear_modulus is None:
        return computed, None
    sizes = {"width_m": blade.width, "thickness_m": blade.thickness}
    return computed, Section(shear_modulus_Pa=blade.shear_modulus, **sizes, **steel)


def _computed_pull_N(table: SawScene) -> float | None:
    """Return ΔF from the drive's power or torque; None where it is given itself, or nothing is."""
    drive, wheel = table.drive, table.wheel
    if drive is None or wheel is None or drive.tension_difference is not None:
        return None
    torque = drive.torque
    if torque is None:
        torque = float(torque_N_m(drive.power or 0.0, wheel.speed, printed=drive.printed_factor))
    return float(tension_difference_N(torque, kind.given(wheel)["wheel_radius_m"]))


def _excitations(table: SawScene) -> tuple[Excitation, ...]:
    shaken, found = table.excitation, list[Excitation]()
    if shaken is None:
        return ()
    if table.wheel is not None and shaken.wheel_harmonics:
        harmonics = tuple(range(1, shaken.wheel_harmonics + 1))
        found.append(resonance.wheel_rotation(kind.given(table.wheel)["wheel_radius_m"], harmonics))
    if shaken.tooth_pitch is not None:
        found.append(resonance.tooth_passing(shaken.tooth_pitch))
    return (*found, *(resonance.fixed_frequency(f"{one:g} Hz", one) for one in shaken.frequencies))


def _quantities(answer: SawAnswer, _: SawProblem) -> tuple[kind.Quantity, ...]:
    found: dict[str, FloatArray | None] = {
        f"{side.value}.first_frequency_Hz": one.frequencies_Hz[:, 0] for side, one in answer.sides.items()
    }
    found |= {"wheel.utilisation": answer.wheel_utilisation, "feed.limit_N": answer.feed_limit_N}
    return tuple(
        kind.Quantity(name, value, positive=name != "wheel.utilisation")
        for name, value in found.items()
        if value is not None
    )


def _failures(answer: SawAnswer, problem: SawProblem) -> tuple[kind.Failure, ...]:
    found, limit_N = [], answer.feed_limit_N
    if limit_N is not None and problem.feed_force_N is not None:
        used = problem.feed_force_N / limit_N
        found.append(kind.Failure("the blade buckles under the feed", "share of its limit", used, used > 1.0))
    apart = _apart(answer, problem)
    if apart is not None:
        # Where the accuracy of the frequencies leaves it open, they are found to ten digits.
        close = np.abs(apart - 1.0) <= answer.accuracy
        if close.any():
            some = problem.select(close)
            apart[close] = _apart(solve_saw(assemble(SYSTEM, some, answer.model.effects)), some)
        words, measure = "a mode is nearer to what shakes it than the margin wanted", "distance over that"
        found.append(kind.Failure(words, measure, apart, apart < 1.0, counted=True))
    return tuple(found)


def _apart(answer: SawAnswer, problem: SawProblem) -> FloatArray | None:
    """Return the least ratio of a mode and what shakes it over that of the margin wanted, shape (n,); None without."""
    margin, speed_m_s = problem.margin_wanted, problem.speed_m_s
    if margin is None or speed_m_s is None or not problem.excitations:
        return None
    shaken_Hz = np.hstack([one.frequencies_Hz(speed_m_s) for one in problem.excitations])[:, :, np.newaxis]
    modes_Hz = np.hstack([answer.sides[side].frequencies_Hz for side in _RUNNING])[:, np.newaxis]
    with np.errstate(divide="ignore"):
        ratio = modes_Hz / shaken_Hz
    return np.asarray(np.maximum(ratio / (1.0 + margin), (1.0 - margin) / ratio).min(axis=(1, 2)))


def _kept(problem: SawProblem) -> dict[str, str]:
    return {"bending": "what resonates depends on it"} if problem.excitations else {}


def _contacts(problem: SawProblem) -> Mapping[str, FloatArray]:
    thickness_m = _UNKNOWN_THICKNESS_M if problem.section is None else problem.section.thickness_m
    radius_m = np.ones(problem.n) if problem.wheel_radius_m is None else problem.wheel_radius_m
    return {
        "wheel_radius_m": radius_m,
        "rope_radius_m": np.full(problem.n, 0.5 * thickness_m),
        "wrap_angle_rad": problem.wheel_wrap_rad,
        "end_tension_N": problem.preload_N,
    }


_NEAREST = 10
_SPEEDS = 200
_FASTEST = 0.98
"""Of the critical speed: up to where crossings are looked for."""


def _tree(answer: SawAnswer, problem: SawProblem) -> dict[str, Any]:
    # A constant-force mounting has no critical speed.
    tree: dict[str, Any] = {side.value: kind.first(one, *one._fields) for side, one in answer.sides.items()}
    if problem.speed_m_s is not None:
        tree["speed_m_s"] = float(problem.speed_m_s[0])
    if problem.feed_force_N is not None:
        tree["feed"] = {"force_N": float(problem.feed_force_N[0])}
    if problem.speed_m_s is not None and problem.excitations:
        tree["resonance"] = _resonance(answer.model)
    return tree


def _recommended(model: SawModel) -> dict[str, Any] | None:
    """Return the preload that keeps the margin wanted, with advice; why there is none; None where none is asked for."""
    problem = model.problem
    if problem.margin_wanted is None or problem.preload_range_N is None:
        return None
    wanted: dict[str, Any] = {"margin": problem.margin_wanted, "range_N": problem.preload_range_N}
    try:
        found = resonance.recommend_preload(model, problem.excitations, n_modes=problem.n_modes, **wanted)
    except RopefricError as error:
        return {"status": "not possible", "advice": error.problem.message}
    numbers = {"preload_N": found.preload_N, "margin": found.margin}
    return numbers | {"status": found.status.value, "advice": found.status.advice}


def _resonance(model: SawModel) -> dict[str, Any]:
    """Return where modes and excitations meet, of the blade with what is simulated of it."""
    problem = model.problem
    shakes, n_modes, crossings = problem.excitations, problem.n_modes, list[resonance.Crossing]()
    for side in _RUNNING:
        crossings += resonance.find_crossings(model, side, shakes, _speeds_m_s(model, side), n_modes)
    nearest = resonance.margins(model, _RUNNING, shakes, n_modes)[:_NEAREST]
    return {
        "recommended_preload": _recommended(model),
        "nearest": [one._asdict() for one in nearest],
        "crossings": [one._asdict() | {"speed_margin": kind.finite(one.speed_margin)} for one in crossings],
    }


def _speeds_m_s(model: SawModel, side: Side) -> FloatArray:
    """Return speeds from rest to half as fast again as at work, or to nearly the critical speed."""
    problem = model.problem
    static_N = problem.preload_N + side.sign * model.part("tension-difference", problem.pull_N)
    held = float(model.part("wheel-inertia-tension", problem.mounting_factor)[0])
    critical_m_s = np.sqrt(static_N / (max(1.0 - held, 1e-3) * problem.linear_density_kg_m))
    return np.linspace(
        0.0,
        min(1.5 * max(resonance.work_speed_m_s(problem), 1.0), _FASTEST * float(critical_m_s[0])),
        _SPEEDS,
    )


def _sections(tree: Mapping[str, Any]) -> tuple[section.Section, ...]:
    sides = [side for side in ("tight", "slack", "rest") if side in tree]
    modes = range(len(tree["rest"]["frequencies_Hz"]))
    shown = {"": "frequencies_Hz"} | ({"torsion ": "torsion_Hz"} if "torsion_Hz" in tree["rest"] else {})
    frequencies = section.Section(
        "Natural frequencies",
        lines=tuple(_lines(tree, sides)),
        headings=("mode", *(f"{side} [Hz]" for side in sides)),
        rows=tuple(
            (f"{word}{mode + 1}", *(section.in_cell(tree[side][name][mode], ".3f") for side in sides))
            for word, name in shown.items()
            for mode in modes
        ),
    )
    return (frequencies, *([_resonance_part(tree["resonance"])] if "resonance" in tree else []))


def _lines(tree: Mapping[str, Any], sides: list[str]) -> list[str]:
    lines = [f"blade speed {tree['speed_m_s']:.3f} m/s"] if "speed_m_s" in tree else []
    for side in sides:
        one, fastest = tree[side], tree[side]["critical_speed_m_s"]
        limit = "none (constant-force mounting)" if fastest is None else f"{fastest:.2f} m/s"
        lines.append(
            f"{side}: F = {one['tension_N']:.1f} N, c = {one['wave_speed_m_s']:.2f} m/s, critical speed {limit}"
        )
    if "wheel" in tree:
        lines.append(f"driving wheel: {100 * tree['wheel']['utilisation']:.3g} % of its grip is used")
    if "torsion" in tree["effects"]["left_out"]:
        lines.append("torsion is left out; its frequencies are not listed")
    if "feed" in tree:
        bears = ", ".join(f"{tree[side]['feed_limit_N']:.4g} N on the {side} side" for side in sides[:2])
        lines.append(f"feed {tree['feed']['force_N']:.4g} N; the blade buckles sideways at {bears}")
    return lines


def _resonance_part(found: Mapping[str, Any]) -> section.Section:
    advice = found["recommended_preload"]
    lines: tuple[str, ...] = ()
    if advice is not None:
        preload = f"preload {advice['preload_N']:.4g} N: " if "preload_N" in advice else ""
        lines = (preload + advice["advice"],)
    nearest = sorted(found["crossings"], key=lambda one: significant(abs(one["speed_margin"] or 0.0)))[:5]
    return section.Section(
        "What may resonate, the nearest first",
        lines=lines,
        headings=("side", "mode", "excitation ", "mode [Hz]", "excitation [Hz]", "margin"),
        rows=tuple(
            (
                *(one["side"], str(one["mode"])),
                f"{one['harmonic']} × {one['excitation']}",
                *kind.cells(one, (("mode_Hz", ".2f"), ("excitation_Hz", ".2f"))),
                f"{100 * one['margin']:+.1f} %",
            )
            for one in found["nearest"]
        ),
        notes=tuple(
            f"{one['side']} mode {one['mode']} meets {one['harmonic']} × {one['excitation']} at "
            f"{one['speed_m_s']:.2f} m/s, {100 * (one['speed_margin'] or 0.0):+.1f} % off ({one['frequency_Hz']:.2f} Hz)"
            for one in nearest
        ),
    )


def _campbell(answer: SawAnswer, problem: SawProblem) -> resonance.SawChart | None:
    if problem.speed_m_s is None or not problem.excitations:
        return None
    model = answer.model
    speeds = min((_speeds_m_s(model, side) for side in _RUNNING), key=lambda one: float(one[-1]))
    return resonance.saw_chart(model, problem.excitations, speeds, min(problem.n_modes, 4))


KIND = kind.Kind(
    name="bandsaw",
    schema=SawScene,
    system=SYSTEM,
    own_wheel=_own_wheel,
    problem=_problem,
    quantities=_quantities,
    tree=_tree,
    contacts=_contacts,
    answerable=answerable,
    failures=_failures,
    kept=_kept,
    keys={
        "n_modes": "blade.modes",
        "tension_difference_N": "drive",
        "wheel_radius_m": "wheel",
        "travel_speed_m_s": "wheel.speed",
    },
    sections=_sections,
    beyond={"resonance": "margins, crossings and the preload recommended"},
    words={"feed.limit_N": "feed force at which the blade buckles [N]"},
    figures={"campbell": kind.Figure(_campbell, "draw_saw_chart")},
)
