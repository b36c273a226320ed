"""Scenes of a band saw: the frequencies of its blade at rest and running, and what may shake it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.scenes.kind import Kind, Quantity, SweepField
from ropefric.scenes.kinds.saw_report import saw_tree
from ropefric.scenes.kinds.saw_schema import SawScene
from ropefric.systems.bandsaw.answer import SawAnswer
from ropefric.systems.bandsaw.effects import SYSTEM, SawProblem, answerable
from ropefric.systems.bandsaw.ends import ENDS
from ropefric.systems.bandsaw.measured import Measurement
from ropefric.systems.bandsaw.saw import Side
from ropefric.systems.friction import WrapFriction

_UNKNOWN_THICKNESS_M = 1e-3


def _own_wheel(table: SawScene) -> tuple[float, float]:
    radius_m = 1.0 if table.wheel is None else table.wheel.radius_m()
    return radius_m, 0.5 * (table.blade.thickness or _UNKNOWN_THICKNESS_M)


def _problem(table: SawScene, friction: WrapFriction | None) -> SawProblem:
    optional_parts = {
        "wheel_radius_m": None if table.wheel is None else table.wheel.radius_m(),
        "wheel_speed_rad_s": None if table.wheel is None else table.wheel.speed,
        "tension_difference_N": table.pull_N(),
        "mounting_factor": table.tension.mounting_factor,
        "bending_stiffness_N_m2": table.blade.stiffness(),
    }
    arrays: dict[str, Any] = {
        name: np.array([value]) for name, value in optional_parts.items() if value is not None
    }
    return SawProblem(
        free_span_m=np.array([table.blade.free_span]),
        linear_density_kg_m=np.array([table.blade.mass()]),
        preload_N=np.array([table.tension.preload]),
        n_modes=table.blade.modes,
        ends=ENDS[table.blade.ends],
        section=table.blade.section(),
        friction=friction,
        wheel_wrap_rad=np.pi if table.wheel is None else table.wheel.wrap,
        excitations=table.excitations(),
        measurements=tuple(
            Measurement(
                side=Side(one.side), frequency_Hz=one.frequency, mode=one.mode, std_Hz=one.uncertainty
            )
            for one in table.measured
        ),
        margin_wanted=None if table.excitation is None else table.excitation.margin,
        preload_range_N=_range_N(table),
        **arrays,
    )


def _range_N(table: SawScene) -> tuple[float, float] | None:
    if table.excitation is None or table.excitation.preload_range is None:
        return None
    low, high = table.excitation.preload_range
    return low, high


def _quantities(answer: SawAnswer, problem: SawProblem) -> tuple[Quantity, ...]:
    del problem
    found = [
        Quantity(name=f"{side.value}.first_frequency_Hz", value=one.frequencies_Hz[:, 0], positive=True)
        for side, one in answer.sides.items()
    ]
    if answer.wheel_utilisation is not None:
        found.append(Quantity(name="wheel.utilisation", value=answer.wheel_utilisation))
    return tuple(found)


def _contacts(problem: SawProblem) -> Mapping[str, FloatArray]:
    half_m = 0.5 * _UNKNOWN_THICKNESS_M
    if problem.section is not None:
        half_m = 0.5 * problem.section.thickness_m
    radius_m = np.ones(problem.m) if problem.wheel_radius_m is None else problem.wheel_radius_m
    return {
        "wheel_radius_m": radius_m,
        "rope_radius_m": np.full(problem.m, half_m),
        "wrap_angle_rad": np.full(problem.m, problem.wheel_wrap_rad),
        "end_tension_N": problem.preload_N,
    }


_SCENE_KEYS = {
    "free_span_m": "blade.free_span",
    "linear_density_kg_m": "blade.linear_density",
    "bending_stiffness_N_m2": "blade.bending_stiffness",
    "n_modes": "blade.modes",
    "preload_N": "tension.preload",
    "mounting_factor": "tension.mounting_factor",
    "tension_difference_N": "drive",
    "wheel_radius_m": "wheel",
    "wheel_speed_rad_s": "wheel.speed",
    "travel_speed_m_s": "wheel.speed",
}


def _scene_key(name: str) -> str:
    return _SCENE_KEYS.get(name, name)


KIND = Kind(
    name="bandsaw",
    schema=SawScene,
    system=SYSTEM,
    own_wheel=_own_wheel,
    problem=_problem,
    quantities=_quantities,
    tree=saw_tree,
    contacts=_contacts,
    sweep_fields={
        "blade.free_span": SweepField(field="free_span_m"),
        "tension.preload": SweepField(field="preload_N"),
        "tension.mounting_factor": SweepField(field="mounting_factor"),
        "drive.tension_difference": SweepField(field="tension_difference_N"),
        "blade.bending_stiffness": SweepField(field="bending_stiffness_N_m2"),
    },
    answerable=answerable,
    scene_key=_scene_key,
)
