"""The steady run of a press: tensions over any grid of preloads, speeds and loads in one product of matrices."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import SolverError, UnknownNameError
from ropefric.registry import did_you_mean
from ropefric.systems.checks import checked, refuse_out_of_scale
from ropefric.systems.press.machine import Press, missing_elasticity, refuse_missing
from ropefric.systems.press.statics import (
    Statics,
    carried_belts,
    incidence,
    load_torques_N_m,
    pull_matrix,
    radii_m,
    span_density_kg_m,
)


def loop_lengths_m(press: Press) -> FloatArray:
    """Return the length of every belt, free spans and arcs, shape (n_belts,) [m]."""
    refuse_missing(
        "the elastic tensioner",
        missing_elasticity(press),
        fix="give them, or take tensioner='locked'",
    )
    arcs_m = {roller.name: roller.radius_m * roller.wrap_angle_rad for roller in press.rollers}
    return np.array(
        [sum(belt.span_lengths_m or ()) + sum(arcs_m[name] for name in belt.loop) for belt in press.belts]
    )


def speed_shift_kg_m(statics: Statics, tensioner: Literal["locked", "elastic"]) -> FloatArray:
    """Return dT'/d(v²) of every span, shape (n_spans,) [kg/m]: T' = T'(0) + v² times this.

    A running belt needs ρAv² to keep its path. If the tensioners keep their place its length cannot change, T stays
    and T' falls by all of it: the limit of a stiff spring. In general the level z_b of T' in belt b follows from the
    belt's length and the springs' balance,

        (L/EA)_b (z_b + ρA_b v²) = −Σ_j G_jb dx_j,      k_j dx_j = Σ_b G_jb z_b,

    with G the pull of one newton in each belt along each travel: for one tensioner dT' = −ρAv²/(1 + s),
    s = (cos + cos)² k_b/k1, k_b = EA/L. A spring of no stiffness keeps T'.
    """
    press = statics.press
    locked = -span_density_kg_m(press)
    if tensioner == "locked":
        return locked
    if tensioner != "elastic":
        raise UnknownNameError(
            f"tensioner = '{tensioner}' is unknown", key="tensioner", fix="locked or elastic"
        )
    stiffness = np.array([belt.axial_stiffness_N for belt in press.belts], dtype=np.float64)
    give = np.diag(loop_lengths_m(press) / stiffness)
    density = np.array([belt.linear_density_kg_m for belt in press.belts])
    pull = pull_matrix(press) @ carried_belts(press).T
    springs = np.diag([part.spring_N_m for part in press.take_ups])
    # One system in z and dx, so that a spring of no stiffness needs no division by zero.
    system = np.block([[give, pull.T], [pull, -springs]])
    right = np.concatenate([-give @ density, np.zeros(len(springs))])
    level = np.linalg.solve(system, right)[: len(density)]
    return np.asarray(locked + statics.by_preload @ (pull @ (level + density)))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SteadyState:
    """Tensions of a press that runs steadily, at any number of operating points."""

    press: Press
    speed_m_s: FloatArray
    load_factor: FloatArray
    effective_tension_N: FloatArray
    slack: BoolArray

    @property
    def tension_N(self) -> FloatArray:
        """Return T [N], shape (..., n_spans): with the part ρAv² of every belt that keeps it on its path."""
        return self.effective_tension_N + np.multiply.outer(self.speed_m_s**2, span_density_kg_m(self.press))

    def effective(self, span: str) -> FloatArray:
        """Return T' of one span by name [N], shape (...)."""
        names = [each.name for each in self.press.spans]
        if span not in names:
            raise UnknownNameError(f"unknown span '{span}'", fix=did_you_mean(span, names))
        return self.effective_tension_N[..., names.index(span)]


def steady_state(
    statics: Statics,
    *,
    preload_N: npt.ArrayLike | Mapping[str, npt.ArrayLike] | None = None,
    speed_m_s: npt.ArrayLike | None = None,
    load_factor: npt.ArrayLike = 1.0,
    tensioner: Literal["locked", "elastic"] = "locked",
    on_slack: Literal["refuse", "flag"] = "refuse",
) -> SteadyState:
    """Return the tensions of a steady run, eqs. (23)-(36) and (39)."""
    press = statics.press
    speed = _numbers("speed_m_s", press.speed_m_s if speed_m_s is None else speed_m_s)
    load = _numbers("load_factor", load_factor)
    preloads = _preloads(press, preload_N)
    shape = np.broadcast_shapes(speed.shape, load.shape, *(force.shape for force in preloads))
    parts = [statics.given_N, statics.by_load_N, speed_shift_kg_m(statics, tensioner), *statics.by_preload.T]
    acting = [np.ones(()), load, speed**2, *preloads]
    by_span, lowest_N = _superpose(parts, acting, shape)
    slack = lowest_N <= 0.0
    if on_slack == "refuse" and slack.any():
        _refuse_slack(press, by_span)
    return SteadyState(
        press=press,
        speed_m_s=np.broadcast_to(speed, shape),
        load_factor=np.broadcast_to(load, shape),
        effective_tension_N=np.moveaxis(by_span, 0, -1),
        slack=slack,
    )


def driver_torque_N_m(state: SteadyState) -> dict[str, FloatArray]:
    """Return the torque each driver's motor supplies [N m], shape (...): R (T_in − T_out) and its own load."""
    press = state.press
    pulls_N = -np.moveaxis(state.effective_tension_N @ incidence(press).T, -1, 0)
    radii, loads = radii_m(press), load_torques_N_m(press)
    return {
        roller.name: radii[i] * pulls_N[i] + state.load_factor * loads[i]
        for i, roller in enumerate(press.rollers)
        if roller.role == "driver"
    }


def drive_power_W(state: SteadyState) -> FloatArray:
    """Return the power of all drivers together [W], shape (...): the loads Σ M/R times the speed.

    It is computed from the loads: creep, bearings and bending are not part of the model.
    """
    press = state.press
    loads_N = float((load_torques_N_m(press) / radii_m(press)).sum())
    return np.asarray(loads_N * state.load_factor * state.speed_m_s)


def _superpose(
    parts: list[FloatArray], acting: list[FloatArray], shape: tuple[int, ...]
) -> tuple[FloatArray, FloatArray]:
    """Return Σ part · acting with the spans in front, and the lowest of them at each point.

    Constant parts are summed beforehand and work space is used again, as sweeps of millions of points ask for.
    """
    varying = [(part, force) for part, force in zip(parts, acting, strict=True) if force.ndim]
    fixed = np.sum(
        [part * force for part, force in zip(parts, acting, strict=True) if not force.ndim], axis=0
    )
    by_span, lowest_N, term = np.empty((len(fixed), *shape)), np.full(shape, np.inf), np.empty(shape)
    for i, constant in enumerate(fixed):
        tension = by_span[i : i + 1].reshape(shape)  # a view even where there is one point
        tension[...] = constant
        for part, force in varying:
            if part[i]:
                np.multiply(force, part[i], out=term)
                tension += term
        np.minimum(lowest_N, tension, out=lowest_N)
    return by_span, lowest_N


def _numbers(name: str, values: npt.ArrayLike) -> FloatArray:
    array = checked(name, values, "zero or more")
    refuse_out_of_scale(name, array, may_vanish=True)
    return array


def _preloads(
    press: Press, preload_N: npt.ArrayLike | Mapping[str, npt.ArrayLike] | None
) -> list[FloatArray]:
    own = {roller.name: part.force_N for roller, part in zip(press.tensioners, press.take_ups, strict=True)}
    chosen: Mapping[str, npt.ArrayLike] = own
    if isinstance(preload_N, Mapping):
        unknown = preload_N.keys() - own.keys()
        if unknown:
            raise UnknownNameError(
                f"preload_N names {', '.join(sorted(unknown))}, which carries no tensioner",
                key="preload_N",
                fix=f"tensioners: {', '.join(own) or 'none'}",
            )
        chosen = own | dict(preload_N)
    elif preload_N is not None:
        chosen = dict.fromkeys(own, preload_N)
    return [_numbers(f"preload_N of tensioner {name}", force) for name, force in chosen.items()]


def _refuse_slack(press: Press, by_span: FloatArray) -> None:
    flat = by_span.reshape(len(press.spans), -1)
    span, point = np.unravel_index(int(np.argmin(flat)), flat.shape)
    place = f" at point {point} of {flat.shape[1]}" if flat.shape[1] > 1 else ""
    worst = press.spans[int(span)]
    raise SolverError(
        f"span {worst.name} (roller {worst.start} to {worst.end}) goes slack{place}: T' = {flat[span, point]:.6g} N, "
        "and a belt cannot push",
        code="RF523",
        key=f"span {worst.name}",
        fix="raise the preload of the tensioners or lower the loads (in Python, on_slack='flag' marks such points)",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Parts:
    """What resists and what gives way when the belts run."""

    mass: bool = False
    springs: bool = False
    stretch: bool = False

    @property
    def keeps_tension(self) -> bool:
        """Return whether T' stays whatever the speed: without mass, or without stretch on springs."""
        return not self.mass or (self.springs and not self.stretch)

    @property
    def tensioner(self) -> Literal["locked", "elastic"]:
        """Return what the tensioners do where T' does not stay."""
        return "elastic" if self.springs and self.stretch else "locked"


def respond(
    parts: Parts,
    statics: Statics,
    *,
    preload_N: FloatArray | None,
    speed_m_s: FloatArray,
    load_factor: FloatArray,
) -> SteadyState:
    """Return the steady state of a press of which some parts give way.

    Between locked tensioners T stays and T' = T − ρAv² (eq. (39)), whether or not the belts stretch. Belts that do
    not stretch leave tensioners on springs where they are, and T' stays. Where both give way dT' = −ρAv²/(1 + s).
    """
    state = steady_state(
        statics,
        preload_N=preload_N,
        speed_m_s=np.zeros_like(speed_m_s) if parts.keeps_tension else speed_m_s,
        load_factor=load_factor,
        tensioner="locked" if parts.keeps_tension else parts.tensioner,
    )
    return replace(state, speed_m_s=speed_m_s)
