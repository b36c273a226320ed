"""The start-up of a press: from the machine and its drive to tensions, speeds, slips and energies."""

import math
from collections import defaultdict
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PPoly

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, SolverError
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.machine import Press
from ropefric.systems.press.slip import contacts_of, factor_in_motion
from ropefric.systems.press.transient.drives import SPEED, Loads, press_inputs
from ropefric.systems.press.transient.exact import Guard, HybridSolver
from ropefric.systems.press.transient.motion import (
    MOVING,
    STICK,
    ElasticPress,
    FrictionLimit,
    Motion,
    Settled,
    elastic_energy_J,
    friction_limit,
    friction_utilisation,
    kinetic_energy_J,
    settled,
)


class SlipInterval(NamedTuple):
    """One time during which a belt slipped on a roller, forward (1) or backward (-1)."""

    roller: str
    start_s: float
    end_s: float
    direction: int


class Energies:
    """Works since the start and energies, each of shape (n_times,) [J], from states w and works (n_times, 6).

    `residual` is what does not add up since the first time, zero but for rounding and the solver's error;
    `relative_residual` its greatest over the greatest of all works and changes of energy [-].
    """

    def __init__(self, motion: Motion, w: FloatArray, works: FloatArray) -> None:
        self.drive, self.load, self.belt = works.T[:3]
        self.tensioner, self.slip, self.centrifugal = works.T[3:]
        self.kinetic, self.elastic = kinetic_energy_J(motion, w), elastic_energy_J(motion, w)
        supplied = self.drive + self.centrifugal - self.load - self.belt - self.tensioner - self.slip
        stored = self.kinetic + self.elastic
        self.residual = (supplied - supplied[0]) - (stored - stored[0])
        changes = (self.kinetic - self.kinetic[0], self.elastic - self.elastic[0])
        scale = max(float(np.abs(part).max()) for part in (*works.T, *changes))
        self.scale_J = scale or 1.0
        # What rounding leaves of the energies themselves, and of forces that are stiffnesses times ways and slips.
        way_m = max(float(np.abs(w @ rows.T).max()) for rows in (motion.relative_way_m, motion.slip_m))
        most_J = float(np.abs(self.elastic).max() + self.kinetic.max())
        self.rounding_J = _ROUNDING * (most_J + float(motion.model.stiffness_N_m.max()) * way_m**2)
        self.relative_residual = float(np.abs(self.residual).max()) / self.scale_J

    def check(self, times_s: FloatArray, *, loads_take: bool) -> None:
        """Refuse an account that does not close, or where what only takes energy gives some."""
        accounts = {
            "the loads drive": self.load if loads_take else 0.0 * self.load,
            "the belts' damping drives": self.belt,
            "the tensioners' dampers drive": self.tensioner,
            "slip drives": self.slip,
        }
        wrong = {
            f"{what} the press": np.maximum.accumulate(taken) - taken for what, taken in accounts.items()
        } | {"the energies of the start-up do not add up": np.abs(self.residual)}
        worst = max(wrong, key=lambda what: float(wrong[what].max()))
        broken = np.flatnonzero(wrong[worst] > _CLOSES * self.scale_J + self.rounding_J)
        if broken.size:
            raise SolverError(
                f"{worst}: from t = {times_s[broken[0]]:.6g} s on, by {wrong[worst].max():.3g} J"
                f" of {self.scale_J:.3g} J",
                code="RF524",
                key="start_up",
                fix="check the loads, the drive and the masses, or simulate a shorter time",
            )


_ROUNDING = 64.0 * float(np.finfo(np.float64).eps)
_CLOSES = 1e-3
"""How much of the energy may be missing, by the quadrature of the powers."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StartUp:
    """A start-up of a press: histories at the times asked for, and what they amount to."""

    press: Press
    time_s: FloatArray
    drive_speed_m_s: FloatArray
    tension_N: FloatArray
    roller_speed_rad_s: FloatArray
    relative_angle_rad: FloatArray
    travel_m: FloatArray
    contact: npt.NDArray[np.int8]
    slip_m: FloatArray
    slip_speed_m_s: FloatArray
    friction_N: FloatArray
    utilisation: FloatArray
    as_printed: FloatArray
    energy: Energies
    slips: tuple[SlipInterval, ...]
    settled: Settled | None
    at_end: npt.NDArray[np.str_]

    def summary(self) -> dict[str, Any]:
        """Return what the histories amount to, as plain data; rollers that slip in the order of their first slip."""
        spans = [span.name for span in self.press.spans]
        rollers = [roller.name for roller in self.press.rollers]
        first: dict[str, float] = {}
        total: dict[str, float] = defaultdict(float)
        for slip in self.slips:
            first.setdefault(slip.roller, slip.start_s)
            total[slip.roller] += slip.end_s - slip.start_s

        def named(names: Sequence[str], values: FloatArray) -> dict[str, float]:
            return dict(zip(names, values.tolist(), strict=True))

        ends = self.settled
        return {
            "peak_tension_N": named(spans, self.tension_N.max(axis=0)),
            "lowest_tension_N": named(spans, self.tension_N.min(axis=0)),
            "peak_utilisation": named(rollers, self.utilisation.max(axis=0)),
            "peak_as_printed": named(rollers, self.as_printed.max(axis=0)),
            "first_slip_s": first,
            "slipping_s": dict(total),
            "drive_work_J": float(self.energy.drive[-1]),
            "slip_loss_J": float(self.energy.slip[-1]),
            "energy_residual": self.energy.relative_residual,
            "settled_tension_N": None if ends is None else named(spans, ends.tension_N),
            "settled_relative_angle_rad": None
            if ends is None
            else named(rollers, ends.relative_way_m / self.press.radius_m),
            "settled_travel_m": None if ends is None else named(list(self.press.tensioners), ends.travel_m),
            "at_end": {name: what for name, what in zip(rollers, self.at_end.tolist(), strict=True) if what},
        }


def start_up(
    press: Press,
    *,
    speed: PPoly,
    time_s: npt.ArrayLike,
    friction: float | WrapFriction,
    loads: Loads = "with-speed",
    effects: Collection[str] = MOVING,
    regressors: frozenset[str] = EVERYTHING,
    follows: bool = False,
) -> StartUp:
    """Return the start-up of a press from rest, eqs. (10)-(22) closed by elastic belts, at evenly spaced times.

    The drivers follow `speed` exactly; span tensions are T_0 + Σ EA/L (e + η de/dt). A belt does not push, a roller
    takes no more than T'_tight = T'_slack e^M with what accelerating the belt adds, and drag opposes the motion and
    holds at rest; between two changes of these the solution is exact. A start-up in which something that only takes
    energy drives the press is refused.
    """
    times = _checked(time_s)
    model = ElasticPress(press, effects=effects)
    if not (model.arc_mass_kg > 0.0).all():
        raise InputError(
            "a belt that slips moves by its own mass, but it has none on the rollers",
            key="arc_inertia",
            fix="give every belt a density and keep the effect arc-inertia",
        )
    inputs = press_inputs(model.overspeed, speed, loads)
    limit = friction_limit(model, friction, regressors)
    exponents, follow = (_following(model, friction, regressors) if follows else None) or (None, None)
    found = _histories(limit, times, HybridSolver(model, inputs, limit, follow=follow), exponents=exponents)
    found.energy.check(times, loads_take=bool((press.rim_load_N[model.driven] >= 0.0).all()))
    return found


def _following(
    model: ElasticPress, friction: float | WrapFriction, regressors: frozenset[str]
) -> tuple[Callable[[FloatArray], FloatArray], Callable[[FloatArray], FrictionLimit]] | None:
    """Return M and the limit of slip at slack sides, where friction follows the tensions; None where it cannot."""
    if not (isinstance(friction, WrapFriction) and friction.follows_tension):
        return None
    contacts = contacts_of(model.press, model.preload_N)

    def exponents(slack_N: FloatArray) -> FloatArray:
        return contacts._replace(upstream_N=slack_N, downstream_N=slack_N).exponent(friction, regressors)

    return exponents, partial(friction_limit, model, friction, regressors)


def _solved(solver: HybridSolver, times_s: FloatArray) -> tuple[list[Motion], FloatArray, FloatArray]:
    try:
        with np.errstate(over="raise", invalid="raise"):
            return solver.run(times_s)
    except FloatingPointError:
        raise SolverError(
            "the motion grows beyond all numbers",
            code="RF524",
            key="friction",
            fix="give a coefficient that falls less steeply with the tension",
        ) from None


def largest_difference(found: StartUp, other: StartUp) -> float:
    """Return the largest difference between two summaries; infinite where other rollers slip or stop.

    Tensions are compared by the greatest of their span or where it settles, use of friction by 1 where it is less,
    times by the time simulated, works by the greatest of all.
    """
    summary, wanted = found.summary(), other.summary()
    for one in (summary, wanted):
        one["settled_tension_N"] = one["settled_tension_N"] or {}
    if summary["at_end"] != wanted["at_end"] or any(
        summary[what].keys() != wanted[what].keys() for what in ("first_slip_s", "settled_tension_N")
    ):
        return math.inf
    time_s, peak_N = float(other.time_s[-1]), wanted["peak_tension_N"]
    sizes = {
        "peak_tension_N": peak_N,
        "lowest_tension_N": peak_N,
        # A span that was slack all along may be tight where it settles.
        "settled_tension_N": {n: max(peak_N[n], abs(one)) for n, one in wanted["settled_tension_N"].items()},
        "peak_utilisation": {name: max(1.0, use) for name, use in wanted["peak_utilisation"].items()},
        "first_slip_s": defaultdict(lambda: time_s),
        "slipping_s": defaultdict(lambda: time_s),
    }
    apart = [
        abs(one - wanted[what][name]) / max(size[name], 1e-300) if one != wanted[what][name] else 0.0
        for what, size in sizes.items()
        for name, one in summary[what].items()
    ]
    works = [
        abs(summary[what] - wanted[what]) / other.energy.scale_J for what in ("drive_work_J", "slip_loss_J")
    ]
    return max(float(one) if math.isfinite(one) else math.inf for one in (*apart, *works))


def _histories(
    limit: FrictionLimit,
    times: FloatArray,
    solver: HybridSolver,
    *,
    exponents: Callable[[FloatArray], FloatArray] | None,
) -> StartUp:
    """Return what states and modes at the times asked for mean for the press; `exponents` where friction follows."""
    (motions, states, works), model, inputs = _solved(solver, times), solver.model, solver.inputs
    press = model.press
    w = np.hstack([states, inputs.at(times)])
    chosen: dict[Motion, list[int]] = defaultdict(list)
    for i, motion in enumerate(motions):
        chosen[motion].append(i)

    def read(rows: Callable[[Motion], FloatArray]) -> FloatArray:
        whole = np.zeros((len(w), len(rows(motions[0]))))
        for motion, indices in chosen.items():
            whole[indices] = w[indices] @ rows(motion).T
        return whole

    first, tension = motions[0], read(lambda motion: motion.tension_N)
    friction_N, pressing_N = (read(lambda motion: motion.friction_N), read(lambda motion: motion.pressing_N))
    contact = np.array([motion.mode.contact for motion in motions], dtype=np.int8)
    sides_N, forward = (pressing_N @ press.into.T, pressing_N @ press.out_of.T), friction_N >= 0.0
    if exponents is not None:
        kept = np.array(
            [np.broadcast_to((one.limit or limit).share, (2, contact.shape[1])) for one in motions]
        )
        limit = FrictionLimit(
            np.exp(exponents(np.where(forward, *sides_N))), np.where(forward, kept[:, 0], kept[:, 1])
        )
    arc_force_N = model.arc_mass_kg * read(lambda motion: motion.belt_acceleration_m_s2)
    utilisation = friction_utilisation(
        limit,
        friction_N=friction_N,
        upstream_N=sides_N[0],
        downstream_N=sides_N[1],
        arc_force_N=arc_force_N,
    )
    as_printed = factor_in_motion(*sides_N, np.log(limit.growth), arc_force_N)
    tension = np.maximum(tension, 0.0)  # the moment a belt goes slack is met to rounding only
    # Beside a span that has lifted off the formula has no slack side, but the friction still has a limit.
    lifted = (pressing_N <= 0.0).astype(np.float64) @ np.abs(press.incidence).T > 0.0
    ahead, behind = (read(lambda motion: motion.limit_N[0]), read(lambda motion: motion.limit_N[1]))
    most = np.where(forward, ahead, behind)
    share = np.divide(np.abs(friction_N), most, out=np.zeros_like(most), where=most > 0.0)
    utilisation = np.where(contact != STICK, 1.0, np.where(lifted, share, utilisation))
    slip_m, final_m_s = w @ first.slip_m.T, float(inputs.taylor[-1, SPEED, 0])
    stands = (np.array(motions[-1].mode.turning) == 0) & (contact[-1] == STICK)
    at_end = np.select([contact[-1] != STICK, stands], ["slips", "stands"], "")
    return StartUp(
        press=press,
        time_s=times,
        drive_speed_m_s=w[:, states.shape[1] + SPEED],
        tension_N=tension,
        roller_speed_rad_s=w @ first.rim_speed_m_s.T / press.radius_m,
        relative_angle_rad=w @ first.relative_way_m.T / press.radius_m,
        travel_m=np.array([one.travel_m for one in press.tensioners.values()]) + w @ first.travel_m.T,
        contact=contact,
        slip_m=slip_m,
        slip_speed_m_s=w @ first.slip_speed_m_s.T,
        friction_N=friction_N,
        utilisation=utilisation,
        as_printed=as_printed,
        energy=Energies(first, w, works),
        slips=_slip_intervals([roller.name for roller in press.rollers], solver.changes, float(times[-1])),
        settled=None if at_end.any() else settled(model, final_m_s, slip_m[-1]),
        at_end=at_end,
    )


def _checked(time_s: npt.ArrayLike) -> FloatArray:
    times = np.array(time_s, dtype=np.float64)
    if times.ndim != 1 or times.size < 2 or not np.isfinite(times).all():
        raise InputError("a start-up needs a list of finite times", key="time_s")
    gaps_s = np.diff(times)
    if times[0] != 0.0 or gaps_s[0] <= 0.0 or np.ptp(gaps_s) > 1e-9 * gaps_s[0]:
        raise InputError("the times of a start-up must rise from 0 on, evenly", key="time_s")
    return times


def _slip_intervals(
    names: Sequence[str], changes: Sequence[tuple[float, Guard]], end_s: float
) -> tuple[SlipInterval, ...]:
    """Return all slips from the changes of mode; instants without duration are left out."""
    begun: dict[int, tuple[float, int]] = {}
    found: list[SlipInterval] = []

    def close(place: int, time_s: float) -> None:
        start_s, direction = begun.pop(place)
        if time_s > start_s:
            found.append(SlipInterval(names[place], start_s, time_s, direction))

    for time_s, guard in changes:
        if guard.what == "slip":
            begun[guard.place] = time_s, guard.direction
        elif guard.what == "stick" and guard.place in begun:
            close(guard.place, time_s)
    for place in list(begun):
        close(place, end_s)
    return tuple(sorted(found, key=lambda slip: (slip.start_s, slip.roller)))
