"""The steady run of a press: tensions over any grid of preloads, speeds and loads, the drives, and elastic creep.

A belt runs with v_b (1 + T/EA), T with its ρAv². It sticks to a roller where it arrives, so that the roller's rim runs
as fast as the belt in the span before it. Belts that run together stick to each other too: with their shares of T,

    v = Σ EA / Σ (EA/v_b) · (1 + T/Σ EA).

The first driver turns as fast as the scene says. The v_b of one belt after the other follows from the rollers where
belts meet, as in the closures of `statics`; so the speed that another driver must have follows from the tensions.
A belt with n spans loses v_b/(2 EA) Σ (T_i − T_i−1)² of the drivers' power.
"""

from dataclasses import dataclass
from itertools import product
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import SolverError
from ropefric.systems.checks import in_scale
from ropefric.systems.press.machine import Press, refuse_missing
from ropefric.systems.press.statics import Statics, belts_alone, tension_row

TakeUp: TypeAlias = Literal["locked", "elastic", "floating"]
"""What tensioners do when the belts run: keep their place, so that T stays and T' = T − ρAv² (eq. (39)), whether or
not the belts stretch; give way on their springs as the belts stretch; or keep T', since the belts have no mass or do
not stretch, which leaves tensioners on springs where they are."""


def speed_shift_kg_m(statics: Statics, tensioner: TakeUp) -> FloatArray:
    """Return dT'/d(v²) of every span, shape (n_spans,) [kg/m]: T' = T'(0) + v² times this.

    A running belt needs ρAv² to keep its path. If the tensioners keep their place its length cannot change, T stays
    and T' falls by all of it: the limit of a stiff spring. In general the level z_b of T' in belt b follows from the
    belt's length and the springs' balance,

        (L/EA)_b (z_b + ρA_b v²) = −Σ_j G_jb dx_j,      k_j dx_j = Σ_b G_jb z_b,

    with G the pull of one newton in each belt along each travel: for one tensioner dT' = −ρAv²/(1 + s),
    s = (cos + cos)² k_b/k1, k_b = EA/L. A spring of no stiffness keeps T'.
    """
    press = statics.press
    if tensioner != "elastic":
        return -press.density_kg_m * (tensioner == "locked")
    fix = "give them, or take tensioner='locked'"
    refuse_missing("the elastic tensioner", press.missing_elasticity, fix=fix)
    arcs_m = {roller.name: roller.radius_m * roller.wrap_angle_rad for roller in press.rollers}
    lengths_m = [
        sum(belt.span_lengths_m or ()) + sum(arcs_m[name] for name in belt.loop) for belt in press.belts
    ]
    give = np.diag(lengths_m / np.array([belt.axial_stiffness_N for belt in press.belts], dtype=np.float64))
    density = np.array([belt.linear_density_kg_m for belt in press.belts])
    pull = press.pull @ press.carried.T
    springs = np.diag([part.spring_N_m for part in press.tensioners.values()])
    # One system in z and dx, so that a spring of no stiffness needs no division by zero.
    system = np.block([[give, pull.T], [pull, -springs]])
    right = np.concatenate([-give @ density, np.zeros(len(springs))])
    level = np.linalg.solve(system, right)[: len(density)]
    return np.asarray(statics.by_preload @ (pull @ (level + density)) - press.density_kg_m)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SteadyState:
    """Tensions T' of a press that runs steadily, at any number of operating points."""

    press: Press
    speed_m_s: FloatArray
    load_factor: FloatArray
    effective_tension_N: FloatArray
    slack: BoolArray

    @property
    def tension_N(self) -> FloatArray:
        """Return T [N], shape (..., n_spans): with the part ρAv² of every belt that keeps it on its path."""
        return self.effective_tension_N + np.multiply.outer(self.speed_m_s**2, self.press.density_kg_m)


def steady_state(
    statics: Statics,
    *,
    preload_N: npt.ArrayLike | None = None,
    speed_m_s: npt.ArrayLike | None = None,
    load_factor: npt.ArrayLike = 1.0,
    tensioner: TakeUp = "locked",
    on_slack: Literal["refuse", "flag"] = "refuse",
) -> SteadyState:
    """Return the tensions of a steady run, eqs. (23)-(36) and (39); a preload given is that of all tensioners."""
    press, own_N = statics.press, np.array([one.force_N for one in statics.press.tensioners.values()])
    asked = {
        "speed_m_s": press.speed_m_s if speed_m_s is None else speed_m_s,
        "load_factor": load_factor,
        "preload_N": 0.0 if preload_N is None else preload_N,
    }
    speed, load, preload = (in_scale(name, values, "zero or more") for name, values in asked.items())
    shape = np.broadcast_shapes(speed.shape, load.shape, preload.shape)
    base_N = statics.given_N + (statics.by_preload @ own_N if preload_N is None else 0.0)
    shares = [
        (statics.by_load_N, load),
        (speed_shift_kg_m(statics, tensioner), speed**2),
        (statics.by_preload.sum(axis=1), preload),
    ]
    # Constant parts are summed beforehand and work space is used again, as sweeps of millions of points ask for.
    base_N = base_N + sum(share * float(acting) for share, acting in shares if not acting.ndim)
    varying = [(share, acting) for share, acting in shares if acting.ndim]
    by_span, lowest_N, term = np.empty((len(base_N), *shape)), np.full(shape, np.inf), np.empty(shape)
    for i, constant in enumerate(base_N):
        tension = by_span[i, ...]
        tension[...] = constant
        for share, acting in varying:
            if share[i]:
                tension += np.multiply(acting, share[i], out=term)
        np.minimum(lowest_N, tension, out=lowest_N)
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


def driver_torque_N_m(state: SteadyState) -> dict[str, FloatArray]:
    """Return the torque each driver's motor supplies [N m], shape (...): R (T_in − T_out) and its own load."""
    press, pulls_N = state.press, state.effective_tension_N @ state.press.incidence.T
    return {
        roller.name: roller.torque_N_m * state.load_factor - roller.radius_m * pulls_N[..., i]
        for i, roller in enumerate(press.rollers)
        if roller.role == "driver"
    }


def drive_power_W(state: SteadyState) -> FloatArray:
    """Return the power of all drivers together [W], shape (...): the loads Σ M/R times the speed.

    It is computed from the loads: creep, bearings and bending are not part of the model.
    """
    return np.asarray(state.press.rim_load_N.sum() * state.load_factor * state.speed_m_s)


def rim_speed_ratios(press: Press, tension_N: FloatArray) -> FloatArray:
    """Return each rim's speed over the first driver's, shape (..., n_rollers), from T, shape (..., n_spans).

    1 where the EA of a belt is not known.
    """
    stiffness_N = np.array([belt.axial_stiffness_N for belt in press.belts], dtype=np.float64)
    if np.isnan(stiffness_N).any():
        return np.ones((*tension_N.shape[:-1], len(press.rollers)))
    together_N = stiffness_N @ press.carried
    stretched = 1.0 + tension_N / together_N
    driver = press.drivers[0].name
    first = press.belts_on(driver)[0].name
    unstrained = {first: 1.0 / (stretched @ tension_row(press, driver, first))}
    for _, (roller, *pair) in product(press.belts, belts_alone(press)):
        for one, other in (pair, pair[::-1]):
            if one in unstrained and other not in unstrained:
                pace, follows = (stretched @ tension_row(press, roller, belt) for belt in (one, other))
                unstrained[other] = unstrained[one] * pace / follows
    # A belt that never meets another alone keeps to the first one's pace.
    paces = np.stack([unstrained.get(belt.name, unstrained[first]) for belt in press.belts], axis=-1)
    by_span = together_N / ((stiffness_N / paces) @ press.carried) * stretched
    return np.asarray(by_span[..., np.argmax(press.into, axis=1)])
