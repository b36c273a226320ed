"""Scenes of a rope on a wheel that lifts."""

import math
from collections.abc import Mapping
from typing import Annotated, Any, Self

import numpy as np
from pydantic import model_validator

from ropefric.arrays import FloatArray
from ropefric.files.toml_model import StrictTable, reject
from ropefric.scenes.kind import Failure, Kind, Quantity, SweepField
from ropefric.scenes.schema import FrictionTable, SceneTable, optional
from ropefric.systems.friction import WrapFriction
from ropefric.systems.hoist.contact import Lift
from ropefric.systems.hoist.effects import SYSTEM, answerable
from ropefric.systems.hoist.problem import GRAVITY_M_S2, HoistProblem


class WheelTable(StrictTable):
    """`[wheel]`."""

    radius: Annotated[float, optional("m", "40 mm", above=0)]
    wrap: Annotated[float, optional("rad", "540 deg", above=0)]
    speed: Annotated[float | None, optional("m/s", "0.3 m/s")] = None


class RopeTable(StrictTable):
    """`[rope]`."""

    diameter: Annotated[float, optional("m", "9.8 mm", above=0)]
    linear_density: Annotated[float | None, optional("kg/m", "62 g/m", above=0)] = None
    hanging_length: Annotated[float | None, optional("m", "5 m", above=0)] = None
    bending_stiffness: Annotated[float | None, optional("N*m^2", "2e-3 N*m^2", above=0)] = None


class LoadTable(StrictTable):
    """`[load]`."""

    end_tension: Annotated[float | None, optional("N", "80 N", above=0)] = None
    payload: Annotated[float | None, optional("kg", "120 kg", above=0)] = None

    @model_validator(mode="after")
    def _has_an_end_tension(self) -> Self:
        if self.end_tension is None:
            also = " for the payload" if self.payload is not None else ""
            reject(
                "RF121",
                f"no end tension is given{also}: a rope that nothing pulls on its slack side lifts nothing",
                fix='add end_tension = "80 N"',
                key="end_tension",
            )
        return self


class HoistScene(SceneTable):
    """A scene with `system = "hoist"`."""

    wheel: WheelTable
    rope: RopeTable
    load: LoadTable
    friction: FrictionTable


def _own_wheel(table: HoistScene) -> tuple[float, float]:
    return table.wheel.radius, 0.5 * table.rope.diameter


def _problem(table: HoistScene, friction: WrapFriction | None) -> HoistProblem:
    assert friction is not None  # noqa: S101  (the schema asks for it)
    given = {
        "speed_m_s": table.wheel.speed,
        "linear_density_kg_m": table.rope.linear_density,
        "hanging_length_m": table.rope.hanging_length,
        "bending_stiffness_N_m2": table.rope.bending_stiffness,
        "payload_kg": table.load.payload,
    }
    return HoistProblem(
        friction=friction,
        wheel_radius_m=_array(table.wheel.radius),
        rope_radius_m=_array(0.5 * table.rope.diameter),
        wrap_angle_rad=_array(table.wheel.wrap),
        end_tension_N=_array(table.load.end_tension or math.nan),
        **{name: _array(value) for name, value in given.items() if value is not None},
    )


def _array(value: float) -> FloatArray:
    return np.array([value])


def _quantities(lift: Lift, problem: HoistProblem) -> tuple[Quantity, ...]:
    found = [
        Quantity(name="lift_force_N", value=lift.lift_force_N, positive=True),
        Quantity(name="mu_average", value=lift.average_mu, positive=True),
    ]
    if problem.payload_kg is not None:
        weight_N = problem.payload_kg * GRAVITY_M_S2
        found += [
            Quantity(name="lift_margin", value=lift.lift_force_N / weight_N, positive=True),
            Quantity(name="margin_N", value=lift.lift_force_N - weight_N),
        ]
    return tuple(found)


def _failures(lift: Lift, problem: HoistProblem) -> tuple[Failure, ...]:
    if problem.payload_kg is None:
        return ()
    margin = lift.lift_force_N / (problem.payload_kg * GRAVITY_M_S2)
    words = "the hoist does not lift its payload"
    return (Failure(words=words, measure="lift margin", value=margin, fails=margin < 1.0),)


def _tree(lift: Lift, problem: HoistProblem) -> dict[str, Any]:
    tree: dict[str, Any] = {
        "contact_rad": float(lift.contact_rad[0]),
        "log_lift": float(lift.log_lift[0]),
        "end_tension_N": float(lift.end_tension_N[0]),
    }
    if problem.payload_kg is not None:
        tree["payload_N"] = float(problem.payload_kg[0] * GRAVITY_M_S2)
        tree["lifts_payload"] = bool(lift.lift_force_N[0] >= tree["payload_N"])
    return tree


def _contacts(problem: HoistProblem) -> Mapping[str, FloatArray]:
    return {
        "wheel_radius_m": problem.wheel_radius_m,
        "rope_radius_m": problem.rope_radius_m,
        "wrap_angle_rad": problem.wrap_angle_rad,
        "end_tension_N": problem.end_tension_N,
    }


_SCENE_KEYS = {
    "wheel_radius_m": "wheel.radius",
    "rope_radius_m": "rope.diameter",
    "wrap_angle_rad": "wheel.wrap",
    "end_tension_N": "load.end_tension",
    "speed_m_s": "wheel.speed",
    "linear_density_kg_m": "rope.linear_density",
    "hanging_length_m": "rope.hanging_length",
    "bending_stiffness_N_m2": "rope.bending_stiffness",
    "payload_kg": "load.payload",
}


def _scene_key(name: str) -> str:
    return _SCENE_KEYS.get(name, name)


KIND = Kind(
    name="hoist",
    schema=HoistScene,
    system=SYSTEM,
    own_wheel=_own_wheel,
    problem=_problem,
    quantities=_quantities,
    tree=_tree,
    contacts=_contacts,
    sweep_fields={
        "wheel.radius": SweepField(field="wheel_radius_m"),
        "wheel.wrap": SweepField(field="wrap_angle_rad"),
        "wheel.speed": SweepField(field="speed_m_s"),
        "rope.diameter": SweepField(field="rope_radius_m", factor=0.5),
        "rope.linear_density": SweepField(field="linear_density_kg_m"),
        "rope.hanging_length": SweepField(field="hanging_length_m"),
        "rope.bending_stiffness": SweepField(field="bending_stiffness_N_m2"),
        "load.end_tension": SweepField(field="end_tension_N"),
        "load.payload": SweepField(field="payload_kg"),
    },
    answerable=answerable,
    failures=_failures,
    scene_key=_scene_key,
)
