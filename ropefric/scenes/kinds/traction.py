"""Scenes of a lift's traction sheave: do its ropes hold while loading and braking, and slip when the car is stalled."""

import math
from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from pydantic import Field, PlainValidator

from ropefric.arrays import FloatArray
from ropefric.files.toml_model import choice, reject, whole_number
from ropefric.scenes import kind
from ropefric.section import Chart, Line, Section
from ropefric.systems.traction.effects import SYSTEM
from ropefric.systems.traction.sheave import CASES, GROOVES, TractionAnswer, TractionProblem, answerable

_NO_CERTIFICATE = "a check after EN 81-50, 5.11, and no certificate: lifts are approved by notified bodies"
_LARGEST_UNDERCUT_DEG = 106.0
_UNDERCUT = {"undercut", "v"}


class LiftTable(kind.Table):
    """`[lift]`.

    Keys
    ----
    car : P, mass of the empty car.
    rated_load : Q.
    counterweight : Its mass.
    travel : Between lowest and highest stop.
    speed : Rated; it lowers the coefficient in an emergency stop.
    deceleration : Of the emergency stop.
    """

    car: Annotated[float, kind.key("kg", "700 kg", "car_kg")]
    rated_load: Annotated[float, kind.key("kg", "630 kg", "rated_load_kg")]
    counterweight: Annotated[float, kind.key("kg", "1015 kg", "counterweight_kg")]
    travel: Annotated[float, kind.key("m", "18 m", "travel_m")]
    speed: Annotated[float | None, kind.key("m/s", "1 m/s", "speed_m_s")] = None
    deceleration: Annotated[float | None, kind.key("m/s^2", "0.5 m/s^2", "deceleration_m_s2")] = None


class SheaveTable(kind.Table):
    """`[sheave]`.

    Keys
    ----
    diameter : Of the sheave.
    wrap : α, over which the ropes lie on it.
    groove : Its form.
    groove_angle : γ.
    undercut : β; of undercut and v grooves alone.
    """

    diameter: Annotated[float, kind.key("m", "400 mm", "wheel_radius_m", factor=0.5)]
    wrap: Annotated[float, kind.key("rad", "160 deg", "wrap_angle_rad")]
    groove: Annotated[str, PlainValidator(choice(lambda: GROOVES))]
    groove_angle: Annotated[float, kind.key("rad", "35 deg", "groove_angle_rad")]
    undercut: Annotated[float | None, kind.key("rad", "90 deg", "undercut_rad")] = None

    def _check(self) -> None:
        if (self.groove in _UNDERCUT) != (self.undercut is not None):
            fix = 'add undercut = "90 deg" to the grooves undercut and v, remove it from others'
            reject("RF121", f"undercut does not fit the groove {self.groove}", fix=fix, key="groove")


class RopesTable(kind.Table):
    """`[ropes]`.

    Keys
    ----
    count : Ropes side by side.
    diameter : Of one rope.
    linear_density : Mass per length of one rope.
    above_car : Rope between the car at the highest stop and the sheave.
    above_counterweight : Rope between the counterweight at its highest and the sheave.
    """

    count: Annotated[int, PlainValidator(whole_number(1, 100)), kind.Becomes("rope_count", many=False)]
    diameter: Annotated[float, kind.key("m", "10 mm", "rope_radius_m", factor=0.5)]
    linear_density: Annotated[float | None, kind.key("kg/m", "0.336 kg/m", "linear_density_kg_m")] = None
    above_car: Annotated[float, kind.key("m", "2 m", "above_car_m", or_zero=True)] = 0.0
    above_counterweight: Annotated[float, kind.key("m", "2 m", "above_counterweight_m", or_zero=True)] = 0.0


class PulleysTable(kind.Table):
    """`[pulleys]`: inertia of deflector pulleys over the square of their radius.

    Keys
    ----
    car_side : Of those on the car's side.
    counterweight_side : Of those on the counterweight's side.
    """

    car_side: Annotated[float | None, kind.key("kg", "20 kg", "car_pulley_kg")] = None
    counterweight_side: Annotated[float | None, kind.key("kg", "20 kg", "counterweight_pulley_kg")] = None


class TractionScene(kind.SceneTable):
    """A scene with `system = "traction"`."""

    lift: LiftTable
    sheave: SheaveTable
    ropes: RopesTable
    pulleys: PulleysTable = Field(default_factory=PulleysTable)


def _quantities(answer: TractionAnswer, problem: TractionProblem) -> tuple[kind.Quantity, ...]:
    undercut = (kind.Quantity("needed_undercut_rad", answer.needed_undercut_rad),)
    return (
        kind.Quantity("largest_utilisation", answer.utilisation.max(axis=0), positive=True),
        kind.Quantity("needed_wrap_rad", answer.needed_wrap_rad, positive=True),
        *(undercut if problem.is_round else ()),
        *(
            kind.Quantity(f"cases.{case}.utilisation", use, positive=True)
            for case, use in zip(CASES, answer.utilisation, strict=True)
        ),
    )


def _failures(answer: TractionAnswer, problem: TractionProblem) -> tuple[kind.Failure, ...]:
    # What EN 81-50, 5.11 has its formulae for; a V groove has at least 35 deg.
    limits = (
        ("groove_angle_rad", "groove angle", "at least", 25.0 if problem.is_round else 35.0, "deg"),
        ("undercut_rad", "undercut", "at most", _LARGEST_UNDERCUT_DEG, "deg"),
        ("deceleration_m_s2", "deceleration", "at least", 0.5, "m/s2"),
    )
    outside = []
    for name, what, side, limit, unit in limits:
        if (given := getattr(problem, name)) is not None:
            value = np.degrees(given) if unit == "deg" else given
            beyond = value - limit if side == "at most" else limit - value
            needed = f"outside EN 81-50, which requires {side} {limit:g} {unit}"
            outside.append(kind.Failure(needed, what, value, beyond > 1e-9 * limit, limit))
    held = [f"the ropes slip in the load case {case}" for case in CASES[:-1]]
    words = (*held, "the ropes do not slip when the car is stalled")
    uses = zip(words, answer.utilisation, strict=True)
    return (*(kind.Failure(said, "utilisation", use, use > 1.0) for said, use in uses), *outside)


def _tree(answer: TractionAnswer, problem: TractionProblem) -> dict[str, Any]:
    ratio = np.full_like(answer.tight_N, np.inf)
    columns = answer._asdict() | {
        "tension_ratio": np.divide(answer.tight_N, answer.slack_N, out=ratio, where=answer.slack_N > 0.0),
        "capacity": np.exp(answer.log_capacity),
    }
    del columns["log_capacity"], columns["utilisation"]
    cases = {
        case: {name: kind.finite(values[i, 0]) for name, values in columns.items()}
        | {"passes": bool(answer.utilisation[i, 0] <= 1.0)}
        for i, case in enumerate(CASES)
    }
    own = "the standard's" if problem.friction is None else "the scene's"
    return {"cases": cases, "groove": problem.groove, "friction_is": own, "note": _NO_CERTIFICATE}


def _sections(tree: Mapping[str, Any]) -> tuple[Section, ...]:
    columns: kind.Columns = {
        "T1 [N]": ("tight_N", ".0f"),
        "T2 [N]": ("slack_N", ".0f"),
        "T1/T2": ("tension_ratio", ".4g"),
        "f": ("friction_factor", ".4f"),
        "e^(f alpha)": ("capacity", ".4g"),
        "utilisation": ("utilisation", ".4g"),
        "passes ": ("passes", ""),
    }
    cases = tree["cases"]
    lines = [
        f"friction is {tree['friction_is']}; the ropes must hold while loading and braking, and slip when stalled"
    ]
    if not all(cases[case]["passes"] for case in CASES[:-1]):
        needed = [("a wrap", tree["needed_wrap_rad"]), ("an undercut", tree.get("needed_undercut_rad"))]
        changes = [
            f"{what} of at least {math.degrees(one):.1f} deg" for what, one in needed if one is not None
        ]
        if changes and math.degrees(needed[1][1] or 0.0) > _LARGEST_UNDERCUT_DEG:
            changes[-1] += " (the standard ends at 106 deg)"
        lines.append(f"changes that would make it hold: {', or '.join(changes) or 'none, without friction'}")
    if not cases["stalled"]["passes"]:
        limit = cases["stalled"]["wrap_limit_rad"]
        most = "none, the ropes outweigh the car"
        most = most if limit is None else f"a wrap of at most {math.degrees(limit):.1f} deg"
        lines.append(f"change that would make it slip when stalled: {most}")
    more = {"lines": tuple(lines), "notes": (tree["note"],)}
    return (kind.by_rows("Traction", "load case", cases, columns, **more),)


def _chart(answer: TractionAnswer, problem: TractionProblem) -> Chart:
    # What stalled ropes must slip at is often ten times what the others must hold: it would hide them.
    wraps = np.linspace(0.75, 1.25, 101) * problem.wrap_angle_rad[0]
    here = np.degrees(problem.wrap_angle_rad[:1])
    held: dict[float, list[str]] = {}
    for case, factor in zip(CASES[:-1], answer.friction_factor[:, 0], strict=False):
        held.setdefault(float(factor), []).append(case)
    lines = [
        Line(f"holds ({', '.join(names)})", np.degrees(wraps), np.exp(factor * wraps))
        for factor, names in held.items()
    ]
    lines += [
        Line(f"asked by {case}", here, answer.tight_N[i, :1] / answer.slack_N[i, :1])
        for i, case in enumerate(CASES[:-1])
    ]
    axes = "wrap_angle_deg", "Wrap angle α [deg]", "tension_ratio", "Ratio of tensions T1/T2 [-]"
    return Chart("What the sheave's friction holds, and what the load cases ask", *axes, tuple(lines))


def _contacts(problem: TractionProblem) -> Mapping[str, FloatArray]:
    lighter_kg = np.minimum(problem.car_kg, problem.counterweight_kg)
    return kind.at_contact(problem, 9.81 * lighter_kg / problem.rope_count)


KIND = kind.Kind(
    name="traction",
    schema=TractionScene,
    system=SYSTEM,
    own_wheel=lambda table: (0.5 * table.sheave.diameter, 0.5 * table.ropes.diameter),
    problem=lambda table, friction: TractionProblem(
        friction=friction, groove=table.sheave.groove, **kind.arrays(table)
    ),
    quantities=_quantities,
    tree=_tree,
    contacts=_contacts,
    answerable=answerable,
    failures=_failures,
    sections=_sections,
    figures={"traction": kind.Figure(_chart)},
    words={
        "largest_utilisation": "Largest utilisation of the four load cases",
        "needed_wrap_rad": "Least wrap that holds while loading and braking [rad]",
        "needed_undercut_rad": "Least undercut that holds while loading and braking [rad]",
    },
)
