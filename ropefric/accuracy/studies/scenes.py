"""Scenes: what leaving effects out saves and costs, against simulating all of them."""

import math
import tomllib
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from ropefric.accuracy.studies.press_transient import RUN_UP_S, SPEED_M_S, machine
from ropefric.accuracy.study import Case, Measured, Setting, Study, against, by_case, time_text
from ropefric.files.toml import TomlDocument
from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS
from ropefric.scenes.plan import Plan, make_plan
from ropefric.scenes.scene import Scene, read_scene
from ropefric.scenes.scene_templates import bundled_scenes
from ropefric.scenes.sweep import Axis, Sweep, parse_axis, sweep_scene
from ropefric.systems.bandsaw.answer import SawProblem
from ropefric.systems.bandsaw.effects import SYSTEM as SAW
from ropefric.systems.bandsaw.saw import STEEL_85_09
from ropefric.systems.beltdrive.effects import SYSTEM as DRIVE
from ropefric.systems.effect import System, assemble
from ropefric.systems.friction import WrapFriction
from ropefric.systems.hoist.contact import HoistProblem
from ropefric.systems.hoist.effects import SYSTEM as HOIST
from ropefric.systems.line.effects import SYSTEM as LINE
from ropefric.systems.press.answer import PressProblem
from ropefric.systems.press.effects import SYSTEM as PRESS
from ropefric.systems.press.transient.drives import DRIVE_LAWS
from ropefric.systems.traction.effects import SYSTEM as TRACTION

N_SWEEP = 8
"""Preloads of the sweep."""


def _each(**numbers: float) -> dict[str, Any]:
    """Return numbers of one machine as arrays."""
    return {name: np.array([value]) for name, value in numbers.items()}


# A rope that climbs, runs, hangs and is a little stiff: all six effects have something to say.
_HOIST = HoistProblem(
    friction=WrapFriction(
        law=ALL_LAWS["coupled"],
        theta=np.array([0.46, -0.22, -0.3, -0.48, 0.055]),
        reference=one_condition(0.035, 0.0049, 5.4, 32.0),
    ),
    **_each(wheel_radius_m=0.04, rope_radius_m=0.0049, wrap_angle_rad=5.0 * np.pi, end_tension_N=80.0),
    **_each(speed_m_s=0.3, linear_density_kg_m=0.062, hanging_length_m=25.0, bending_stiffness_N_m2=1e-4),
)
_SAW = SawProblem(
    n_modes=3,
    section=STEEL_85_09,
    **_each(free_span_m=1.6, preload_N=12_000.0, tension_difference_N=211.0, mounting_factor=0.1),
    **_each(wheel_radius_m=0.35, wheel_speed_rad_s=100.0),
    **_each(
        **{name: getattr(STEEL_85_09, name) for name in ("linear_density_kg_m", "bending_stiffness_N_m2")}
    ),
)
_PRESS = PressProblem(
    press=machine(2e6, 1e-3),
    closure="share",
    friction=WrapFriction.constant(0.9),
    **_each(speed_m_s=SPEED_M_S, load_factor=1.0),
)
_START_UP = replace(
    _PRESS,
    friction=WrapFriction.constant(0.25),
    start_up={
        "speed": DRIVE_LAWS["s-curve"](speed_m_s=SPEED_M_S, duration_s=RUN_UP_S),
        "time_s": np.linspace(0.0, 1.0, 201),
        "loads": "with-speed",
    },
)


def _read(name: str, data: dict[str, Any]) -> Scene:
    return read_scene(TomlDocument(path=f"{name}.toml", data=data, lines={}), Path())


def _bundled(name: str) -> Any:
    """Return the problem of a bundled scene."""
    return _read(name, tomllib.loads(bundled_scenes()[name])).problem


PROBLEMS: dict[str, tuple[System, Any, str]] = {
    "hoist": (
        HOIST,
        _HOIST,
        "a rope of 9.8 mm climbing on a wheel of 40 mm, 2.5 turns, 25 m of it hanging; law: coupled",
    ),
    "traction": (TRACTION, _bundled("traction"), "a lift of 630 kg on its sheave, four load cases"),
    "belt-drive": (DRIVE, _bundled("belt-drive"), "a flat belt between two pulleys at 7.5 kW"),
    "line": (LINE, _bundled("cable-pull"), "a cable through five elements of a conduit"),
    "press-fixed": (
        PRESS,
        _bundled("press-fixed"),
        "a press of 13 rollers, two belts between fixed centres",
    ),
    "press": (PRESS, _PRESS, f"one belt over four rollers, at {SPEED_M_S:g} m/s"),
    "start-up": (PRESS, _START_UP, f"the same press, run up in {RUN_UP_S:g} s; three of its rollers slip"),
    "saw": (SAW, _SAW, "a blade of 85 × 0.9 mm on 1.6 m at 35 m/s, three frequencies of each side"),
    "saw-sweep": (
        SAW,
        replace(_SAW, preload_N=np.linspace(8_000.0, 16_000.0, N_SWEEP)),
        f"the same blade at {N_SWEEP} preloads from 8 to 16 kN, planned once and solved in one call",
    ),
}
"""By the name of their case: the system, a machine to be planned and solved, and what it is."""

SWEEP = "hoist-sweep"
_SWEPT = ("wheel.wrap=180deg:1440deg:200", "load.end_tension=40N:500N:200")


ACCURACIES_WANTED = (0.3, 0.1, 0.03, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8)

_QUICK = {0.1, 1e-2}
"""The accuracies for which a quick look makes a plan."""
_REFERENCE_BUDGET = 1e-14
_A_SAVING = 0.25
"""Share of the time with all effects that a busy machine can resolve."""
_PLAN, _ALL, _NONE = "plan and solve", "all effects", "no effects"


@cache
def planned(case: str, accuracy: float, effects: str = "auto") -> tuple[Plan, Any]:
    """Return the plan of a case and the model assembled to it."""
    system, problem, _ = PROBLEMS[case]
    return make_plan(system, problem, accuracy=accuracy, effects=effects)


@cache
def _reference(case: str) -> Any:
    """Return the answer with all effects by the finest method of the system."""
    system, model = PROBLEMS[case][0], planned(case, 1.0, "all")[1]
    return system.solve(model, system.method(model, _REFERENCE_BUDGET))


def _settings(case: str) -> tuple[Setting, ...]:
    system, problem, _ = PROBLEMS[case]
    judged = partial(
        against, _reference(case), error=lambda found, wanted: system.distance(found, wanted, wanted)
    )

    def plan_and_solve(accuracy: float, effects: str = "auto") -> object:
        plan, model = make_plan(system, problem, accuracy=accuracy, effects=effects)
        return system.solve(model, plan.method)

    def count(_answer: object, accuracy: float, effects: str = "auto") -> float:
        return len(planned(case, accuracy, effects)[0].simulated)

    bare, roughest = assemble(system, problem, ()), _roughest(case)
    label = "accuracy {:g}" if len(roughest) > 1 else ""
    whole, all_of = partial(plan_and_solve, effects="all"), partial(count, effects="all")
    return (
        *judged(_NONE, "", lambda: system.solve(bare, system.method(bare, 1.0)), work=0.0),
        *judged(_PLAN, "accuracy {:g}", plan_and_solve, over=ACCURACIES_WANTED, work=count, quick=_QUICK),
        *judged(_ALL, label, whole, over=roughest, work=all_of, quick=roughest[:3:2]),
    )


def _roughest(case: str) -> tuple[float, ...]:
    """Return the accuracies at which all effects are solved by another method than at any rougher one."""
    found: dict[tuple[object, ...], float] = {}
    for wanted in ACCURACIES_WANTED:
        method = planned(case, wanted, "all")[0].method
        found.setdefault((method.name, *method.settings.items()), wanted)
    return tuple(found.values())


@cache
def swept_scene(accuracy: float, effects: str = "auto") -> tuple[Scene, tuple[Axis, ...]]:
    """Return the scene of the sweep at an accuracy, and its axes: the bundled hoist with a rope a little stiff."""
    data = tomllib.loads(bundled_scenes()["climbing-hoist"])
    del data["load"]["payload"]
    data["rope"] |= {"hanging_length": "5 m", "bending_stiffness": "2e-5 N*m^2"}
    data["friction"] = {"law": "wrap-power", "parameters": {"a": 0.1, "b": -0.4, "c": 0.1}}
    data |= {"accuracy": accuracy, "effects": effects}
    scene = _read("climbing-hoist", data)
    return scene, tuple(parse_axis(scene, axis) for axis in _SWEPT)


def _swept_settings() -> tuple[Setting, ...]:
    def sweep(accuracy: float, effects: str = "auto") -> Sweep:
        return sweep_scene(*swept_scene(accuracy, effects))

    whole, work = partial(sweep, 1.0, "all"), lambda found, *_: _count(found)
    judged = partial(against, whole(), error=_largest_difference, work=work)
    return (
        *judged(_PLAN, "accuracy {:g}", sweep, over=ACCURACIES_WANTED, quick=_QUICK),
        *judged(_ALL, "", whole),
    )


def _count(found: Sweep) -> float:
    """Return how many effects are simulated, of those left out at some of the points their share."""
    return len(found.simulated) - sum(
        count / math.prod(found.shape) for name, count in found.left_out.items() if name in found.simulated
    )


def _largest_difference(found: Sweep, reference: Sweep) -> float:
    pairs = [(values, reference.columns[name]) for name, values in found.columns.items()]
    return max(float(np.max(np.abs(ours - all_) / np.maximum(np.abs(all_), 1e-300))) for ours, all_ in pairs)


def _findings(points: tuple[Measured, ...]) -> tuple[str, ...]:
    return tuple(_worth(case, here) for case, here in by_case(points).items())


def _wanted(point: Measured) -> float:
    return float(point.setting.removeprefix("accuracy "))


def _worth(case: str, points: tuple[Measured, ...]) -> str:
    """Return at which accuracies planning and solving is quicker than solving everything as accurately."""
    found, whole = [], max(point.evaluations for point in points)
    for point in points:
        if point.method == _PLAN and point.evaluations < whole:
            wanted = _wanted(point)
            whole_s = min((p.seconds for p in points if p.method == _ALL and p.error <= wanted), default=0.0)
            if whole_s - point.seconds > _A_SAVING * whole_s:
                found.append((wanted, whole_s / point.seconds, point.seconds, whole_s))
    if not found:
        return f"{case}: leaving effects out saves no measurable time; all effects are simulated."
    wanted, times, planned_s, whole_s = max(found, key=lambda one: one[1])
    where = ", ".join(f"{one[0]:g}" for one in found)
    return (
        f"{case}: planned and solved quicker than everything at an accuracy of {where}, most at {wanted:g}: "
        f"{time_text(planned_s)} instead of {time_text(whole_s)}, {times:.2g} times as fast."
    )


STUDY = Study(
    name="scenes",
    title="Effects that the plan of a scene leaves out, against all effects",
    question="What does it save to simulate only the effects a scene calls for, and how far is the answer then off?",
    reference="all effects, by the system's finest method; the tests hold it against other solutions",
    counted="effects in the model",
    used="plan and solve",
    cases=(
        *(Case(name, title, partial(_settings, name)) for name, (_, _, title) in PROBLEMS.items()),
        Case(
            SWEEP, "40 000 wraps and end tensions of a rope a little stiff; law: wrap-power", _swept_settings
        ),
    ),
    findings=_findings,
)
