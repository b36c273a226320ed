"""From the tables of a press scene to the machine and its task."""

from dataclasses import replace
from typing import cast

import numpy as np

from ropefric.scenes.kinds.press_schema import BeltTable, PressScene, RollerTable, StartUpTable
from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.answer import PressProblem, StartUpTask
from ropefric.systems.press.loads import (
    distortion_energy_J_m3,
    gravity_pull_N,
    gravity_torque_N_m,
    squeeze_torque_N_m,
)
from ropefric.systems.press.machine import Belt, Press, Role, Roller, Tensioner
from ropefric.systems.press.transient.drives import DRIVE_LAWS
from ropefric.systems.press.transient.integrators import Settings


def press_problem(table: PressScene, friction: WrapFriction | None) -> PressProblem:
    """Return the problem that a press scene states."""
    assert friction is not None  # noqa: S101  (the schema asks for it)
    speed_m_s = _speed_m_s(table)
    press = Press(
        rollers=tuple(_loaded(table, _roller(table, name, one)) for name, one in table.rollers.items()),
        belts=tuple(_belt(name, one) for name, one in table.belts.items()),
        speed_m_s=speed_m_s,
    )
    return PressProblem(
        press=press,
        closure=table.press.closure,
        friction=friction,
        speed_m_s=np.array([speed_m_s]),
        preload_N=None if table.press.preload is None else np.array([table.press.preload]),
        load_factor=np.array([table.press.load_factor]),
        start_up=None if table.start_up is None else _task(table.start_up, speed_m_s),
    )


def _speed_m_s(table: PressScene) -> float:
    if table.press.speed is not None:
        return table.press.speed
    drivers = [roller for roller in table.rollers.values() if roller.role == "driver"]
    return (table.press.rotation or 0.0) * (drivers[0].radius if drivers else 0.0)


def _roller(table: PressScene, name: str, one: RollerTable) -> Roller:
    tensioner = None
    if one.tensioner is not None:
        tensioner = Tensioner(
            spring_N_m=one.tensioner.spring,
            travel_m=one.tensioner.travel,
            force_N=one.tensioner.force or table.press.preload or 0.0,
            mass_kg=one.tensioner.mass,
            damping_N_s_m=one.tensioner.damping,
            upstream_angle_rad=one.tensioner.upstream_angle,
            downstream_angle_rad=one.tensioner.downstream_angle,
        )
    return Roller(
        name=name,
        radius_m=one.radius,
        wrap_angle_rad=one.wrap,
        role=cast("Role", one.role),
        inertia_kg_m2=one.inertia,
        gravity_torque_N_m=one.gravity_torque,
        squeeze_torque_N_m=one.squeeze_torque,
        tensioner=tensioner,
        overspeed=one.overspeed,
    )


def _loaded(table: PressScene, roller: Roller) -> Roller:
    """Return a roller with the torques that the sludge puts on it."""
    gravity, squeeze = table.sludge.gravity, table.sludge.squeeze
    if gravity is not None and roller.name in gravity.zones:
        pull_N = gravity_pull_N(
            sludge_friction=gravity.friction,
            belt_width_m=gravity.width,
            sludge_height_m=gravity.height,
            sludge_density_kg_m3=gravity.density,
            zone_length_m=gravity.zones[roller.name],
        )
        torque = float(gravity_torque_N_m(pull_N, radius_m=roller.radius_m))
        roller = replace(roller, gravity_torque_N_m=torque)
    if squeeze is not None and roller.name in squeeze.units:
        energy = distortion_energy_J_m3(
            strength_Pa=squeeze.strength,
            poisson_ratio=squeeze.poisson_ratio,
            youngs_modulus_Pa=squeeze.youngs_modulus,
        )
        torque = float(
            squeeze_torque_N_m(
                belt_width_m=squeeze.width,
                radius_m=roller.radius_m,
                compression_m=squeeze.compression,
                distortion_energy_J_m3=energy,
                units=squeeze.units[roller.name],
            )
        )
        roller = replace(roller, squeeze_torque_N_m=torque)
    return roller


def _belt(name: str, one: BeltTable) -> Belt:
    return Belt(
        name=name,
        loop=one.loop,
        linear_density_kg_m=one.mass(),
        thickness_m=one.thickness,
        width_m=one.width,
        axial_stiffness_N=one.axial_stiffness,
        damping_s=one.damping,
        span_lengths_m=None if one.span_lengths is None else tuple(one.span_lengths),
    )


def _task(table: StartUpTable, speed_m_s: float) -> StartUpTask:
    given = {
        "speed_m_s": table.speeds if table.law == "table" else speed_m_s,
        "duration_s": table.duration,
        "time_s": table.times,
    }
    law = DRIVE_LAWS[table.law]
    return StartUpTask(
        speed=law.speed(**{name: given[name] for name in law.parameters}),
        time_s=np.linspace(0.0, table.simulate, table.points),
        slip=table.slip,
        loads=table.loads,
        integrator=table.integrator,
        settings=Settings(tolerance=table.tolerance, step_s=table.step),
    )
