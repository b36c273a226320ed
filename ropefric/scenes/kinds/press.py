"""Scenes of a belt press: tensions, slip, and the start-up."""

from collections.abc import Mapping

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.scenes.kind import Kind, SweepField
from ropefric.scenes.kinds.press_machine import press_problem
from ropefric.scenes.kinds.press_report import press_failures, press_quantities, press_tree
from ropefric.scenes.kinds.press_schema import PressScene
from ropefric.systems.press.answer import PressProblem
from ropefric.systems.press.effects import SYSTEM
from ropefric.systems.press.statics import solve_statics
from ropefric.systems.press.steady import steady_state


def _own_wheel(table: PressScene) -> tuple[float, float]:
    """Return the middle roller's radius and half the first belt's thickness."""
    radii = sorted(roller.radius for roller in table.rollers.values())
    belts = list(table.belts.values())
    return (radii[len(radii) // 2] if radii else 1.0), (0.5 * belts[0].thickness if belts else 0.005)


def _contacts(problem: PressProblem) -> Mapping[str, FloatArray]:
    """Return every roller once, with the tension of its belt at rest."""
    rollers = problem.press.rollers
    halves = [
        0.5 * max(belt.thickness_m for belt in problem.press.belts if roller.name in belt.loop)
        for roller in rollers
    ]
    preloads = [part.tensioner.force_N for part in problem.press.tensioners if part.tensioner is not None]
    level_N = 0.5 * (max(preloads) if preloads else 1.0)
    return {
        "wheel_radius_m": np.array([roller.radius_m for roller in rollers]),
        "rope_radius_m": np.array(halves),
        "wrap_angle_rad": np.array([roller.wrap_angle_rad for roller in rollers]),
        "end_tension_N": np.full(len(rollers), level_N),
    }


def _in_one_call(problem: PressProblem) -> bool:
    """Return whether no start-up is asked for: one is simulated at a time."""
    return problem.start_up is None


def _answerable(problem: PressProblem) -> BoolArray:
    """Return where no span is slack at rest; speed can only slacken further."""
    still = steady_state(
        solve_statics(problem.press, closure=problem.closure),
        preload_N=problem.preload_N,
        speed_m_s=np.zeros(problem.n),
        load_factor=problem.load_factor,
        on_slack="flag",
    )
    return np.asarray(~still.slack)


_SCENE_KEYS = {
    "mu": "friction.mu",
    "speed_m_s": "press.speed",
    "preload_N": "press.preload",
    "load_factor": "press.load_factor",
    "wrap_angle_rad": "wrap",
    "radius_m": "radius",
    "inertia_kg_m2": "inertia",
    "gravity_torque_N_m": "gravity_torque",
    "squeeze_torque_N_m": "squeeze_torque",
    "spring_N_m": "spring",
    "travel_m": "travel",
    "force_N": "force",
    "damping_N_s_m": "damping",
    "mass_kg": "mass",
    "upstream_angle_rad": "upstream_angle",
    "downstream_angle_rad": "downstream_angle",
    "linear_density_kg_m": "linear_density",
    "thickness_m": "thickness",
    "width_m": "width",
    "damping_s": "damping",
    "axial_stiffness_N": "axial_stiffness",
    "span_lengths_m": "span_lengths",
}


def _scene_key(name: str) -> str:
    kind, _, which = name.partition(" ")
    if kind in {"span", "roller"} and which:
        # A span goes slack for want of preload; a roller has a table of its own.
        return "press.preload" if kind == "span" else f"rollers.{which}"
    table, dot, last = name.rpartition(".")
    return table + dot + _SCENE_KEYS.get(last, last)


KIND = Kind(
    name="press",
    schema=PressScene,
    system=SYSTEM,
    own_wheel=_own_wheel,
    problem=press_problem,
    quantities=press_quantities,
    tree=press_tree,
    contacts=_contacts,
    sweep_fields={
        "press.speed": SweepField(field="speed_m_s"),
        "press.preload": SweepField(field="preload_N"),
        "press.load_factor": SweepField(field="load_factor"),
    },
    in_one_call=_in_one_call,
    answerable=_answerable,
    failures=press_failures,
    scene_key=_scene_key,
)
