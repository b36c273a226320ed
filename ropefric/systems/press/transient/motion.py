"""A press with elastic belts as arrays, and its equations of motion in one mode as rows over w = (q, dq/dt, u).

The coordinates q are the rims' ways s = Rθ of the driven rollers relative to the first driver, the tensioners' ways ξ
from their place at rest and, where slip is allowed, how far the belt on each roller has run ahead of it, δ. With
e = −Dᵀ (s + δ) − Pᵀ ξ and T = T_0 + k (e + η de/dt) the balances are, where belt and roller stick together,

    (J/R² + ρARα) dv/dt = D T − M/R,        m ξ'' + C1 ξ' + k1 ξ = P (T − T_0 − ρAv²),

eqs. (10)-(22) less the state at rest. Where a belt slips forward, friction and the belt's mass on the arc m share
what the tensions leave, F = T_out − T_in − m b'', and the element dT/dφ = ρAR²θ'' − F integrated over the wrap gives

    F = (1 − κ) T'_out + (κ e^M − 1) T'_in,      κ = m / (m + m ∫(e^(M(α) − M(s)) − 1) ds/α),

for constant μ κ = M/(e^M − 1); where it slips backward, with the sides exchanged and the other sign.
"""

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.machine import Press, missing_elasticity, missing_masses, refuse_missing
from ropefric.systems.press.slip import available_pull_N, contacts_of, grip_on
from ropefric.systems.press.statics import (
    carried_belts,
    has_balance,
    incidence,
    load_torques_N_m,
    pull_matrix,
    radii_m,
    span_density_kg_m,
)
from ropefric.systems.press.transient.drives import (
    ACCELERATION,
    FIRST_DRIVER,
    LOAD,
    ONE,
    SPEED,
    SPEED_SQUARED,
    Inputs,
)

MOVING = frozenset({"belt-inertia", "belt-damping", "tensioner-damping", "arc-inertia"})
"""What a start-up may contain beside elastic belts and turning rollers; what is left out is never computed."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ElasticPress:
    """A press ready to be moved. Rollers are described at their rims: s = Rθ [m], mass J/R² [kg], load M/R [N]."""

    press: Press
    incidence: FloatArray
    pull: FloatArray
    stiffness_N_m: FloatArray
    damping_N_s_m: FloatArray
    density_kg_m: FloatArray
    preload_N: FloatArray
    roller_mass_kg: FloatArray
    arc_mass_kg: FloatArray
    load_N: FloatArray
    driven: npt.NDArray[np.intp]
    drivers: npt.NDArray[np.intp]
    overspeed: FloatArray
    tensioner_mass_kg: FloatArray
    tensioner_damping_N_s_m: FloatArray
    spring_N_m: FloatArray

    @property
    def into(self) -> FloatArray:
        """Return 1 where a span arrives at a roller, shape (n_rollers, n_spans)."""
        return np.maximum(-self.incidence, 0.0)

    @property
    def out_of(self) -> FloatArray:
        """Return 1 where a span leaves a roller, shape (n_rollers, n_spans)."""
        return np.maximum(self.incidence, 0.0)


def standstill_tension_N(press: Press) -> FloatArray:
    """Return the tensions of a press that stands still and unloaded, shape (n_spans,) [N].

    Without torques each belt has one tension all around, and the tensioners' balance k1 x + F = P T says which.
    """
    belts_in = carried_belts(press)
    by_belt = pull_matrix(press) @ belts_in.T
    force_N = np.array([part.spring_N_m * part.travel_m + part.force_N for part in press.take_ups])
    if np.linalg.matrix_rank(by_belt) < len(press.belts) or len(force_N) > len(press.belts):
        raise InputError(
            f"{len(force_N)} tensioners do not settle the standstill tensions of {len(press.belts)} belts",
            code="RF521",
            key="preload_N",
            fix="give each belt one tensioner; in Python, give the tension of every span at rest (preload_N)",
        )
    level_N = np.linalg.solve(by_belt, force_N)
    if not (level_N > 0.0).all():
        slack = press.belts[int(np.argmin(level_N))].name
        raise InputError(
            f"belt '{slack}' is slack at rest: {level_N.min():.6g} N",
            code="RF523",
            fix="raise the tensioner's force or travel",
        )
    return np.asarray(level_N @ belts_in)


def elastic_press(
    press: Press, *, effects: Collection[str] = MOVING, preload_N: npt.ArrayLike | None = None
) -> ElasticPress:
    """Return a press with elastic belts as arrays."""
    refuse_missing("a start-up", [*missing_elasticity(press), *missing_masses(press)], fix="give them")
    preload = standstill_tension_N(press) if preload_N is None else np.array(preload_N, dtype=np.float64)
    if preload.shape != (len(press.spans),) or not (np.isfinite(preload) & (preload > 0.0)).all():
        raise InputError(
            f"the preload needs one positive tension for each of {len(press.spans)} spans", key="preload_N"
        )
    index = {(span.start, span.end): i for i, span in enumerate(press.spans)}
    stiffness, damping = np.zeros(len(index)), np.zeros(len(index))
    for belt in press.belts:
        for step, length_m in zip(belt.steps, belt.span_lengths_m or (), strict=True):
            own = (belt.axial_stiffness_N or 0.0) / length_m
            stiffness[index[step]] += own
            damping[index[step]] += own * belt.damping_s
    arcs = [
        sum(belt.linear_density_kg_m for belt in press.belts_on(roller))
        * roller.radius_m
        * roller.wrap_angle_rad
        for roller in press.rollers
    ]
    balanced, radius = has_balance(press), radii_m(press)
    drivers = np.flatnonzero(~balanced)
    return ElasticPress(
        press=press,
        incidence=incidence(press),
        pull=pull_matrix(press),
        stiffness_N_m=stiffness,
        damping_N_s_m=damping * ("belt-damping" in effects),
        density_kg_m=span_density_kg_m(press) * ("belt-inertia" in effects),
        preload_N=preload,
        roller_mass_kg=np.array([roller.inertia_kg_m2 or 0.0 for roller in press.rollers]) / radius**2,
        arc_mass_kg=np.array(arcs) * ("arc-inertia" in effects),
        load_N=load_torques_N_m(press) / radius,
        driven=np.flatnonzero(balanced),
        drivers=drivers,
        overspeed=np.array([press.rollers[i].overspeed or 0.0 for i in drivers]),
        tensioner_mass_kg=np.array([part.mass_kg or 0.0 for part in press.take_ups]),
        tensioner_damping_N_s_m=np.array([part.damping_N_s_m for part in press.take_ups])
        * ("tensioner-damping" in effects),
        spring_N_m=np.array([part.spring_N_m for part in press.take_ups]),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrictionLimit:
    """What gross slip on each roller is governed by: e^M, and κ, see `motion`; each (n_rollers,)."""

    growth: FloatArray
    share: FloatArray


_LEAST_GRIP = 1e-7
"""A thousand times what `exact.guards_of` takes for zero, as a share of the tension."""


def friction_limit(model: ElasticPress, friction: float | WrapFriction) -> FrictionLimit:
    """Return what gross slip on each roller is governed by."""
    press = model.press
    growth, share = np.empty(len(press.rollers)), np.empty(len(press.rollers))
    spin = 1.0 / radii_m(press)
    for i, contact in enumerate(contacts_of(press, model.preload_N, angular_acceleration_rad_s2=spin)):
        grip = grip_on(contact, friction)
        growth[i] = np.exp(grip.exponent)
        if growth[i] - 1.0 < _LEAST_GRIP:
            raise InputError(
                f"roller {press.rollers[i].name} holds the belt by e^(μφ) − 1 = {growth[i] - 1.0:.3g} of its tension:"
                f" a start-up with slip cannot tell less than {_LEAST_GRIP:g} from no friction at all",
                code="RF523",
                key="friction",
                fix="give a larger coefficient or wrap angle, or write slip = false",
            )
        still = float(contact.slack_N) * np.expm1(float(grip.exponent))
        # What the acceleration of 1 m/s² alone adds to the friction that can be borne.
        added = float(available_pull_N(contact, grip)) - still
        arc_N = float(contact.inertia_towards_tight_N) * contact.wrap_angle_rad
        share[i] = 1.0 / (1.0 + added / arc_N) if arc_N else float(grip.exponent) / (growth[i] - 1.0)
    return FrictionLimit(growth=growth, share=share)


def friction_utilisation(
    limit: FrictionLimit,
    *,
    friction_N: FloatArray,
    upstream_N: FloatArray,
    downstream_N: FloatArray,
    arc_force_N: FloatArray,
) -> FloatArray:
    """Return required over available friction of every roller, shape (..., n_rollers) [-].

    U = |F| / (T'_slack (e^M − 1) ± m b'' (1/κ − 1)): 0 without friction, 1 in gross slip, and without acceleration
    the utilisation of `ropefric.systems.press.slip`. Infinite where friction acts on a belt that has lifted off.
    """
    forward = friction_N >= 0.0
    slack_N = np.where(forward, upstream_N, downstream_N)
    towards_N = np.where(forward, arc_force_N, -arc_force_N)
    available_N = slack_N * (limit.growth - 1.0) + towards_N * (1.0 / limit.share - 1.0)
    required_N = np.abs(friction_N)
    ratio = np.where(required_N > 0.0, np.inf, 0.0)
    np.divide(required_N, available_N, out=ratio, where=available_N > 0.0)
    return ratio


STICK, FORWARD, BACKWARD = 0, 1, -1
"""The belt goes with the roller, runs ahead of it (a driven roller slips), or lags behind it (a driver slips)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mode:
    """State of every roller and span: between two changes of it the press is a linear system."""

    contact: tuple[int, ...]
    turning: tuple[int, ...]
    pressed: tuple[bool, ...]
    taut: tuple[bool, ...]
    strained: tuple[bool, ...]


def sticking(model: ElasticPress) -> Mode:
    """Return the mode of the linear model: no belt slips, all are taut."""
    n_rollers, n_spans = model.incidence.shape
    every = (True,) * n_spans
    return Mode(
        contact=(STICK,) * n_rollers, turning=(1,) * n_rollers, pressed=every, taut=every, strained=every
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """One mode of a press as rows over w = (q, dq/dt, u)."""

    model: ElasticPress
    mode: Mode
    limit: FrictionLimit | None = None

    @cached_property
    def n_rollers(self) -> int:
        """Return the number of rollers."""
        return len(self.model.load_N)

    @cached_property
    def n_coordinates(self) -> int:
        """Return the number of coordinates q."""
        slips = self.n_rollers if self.limit is not None else 0
        return len(self.model.driven) + len(self.model.spring_N_m) + slips

    @cached_property
    def n_inputs(self) -> int:
        """Return the number of inputs u."""
        return FIRST_DRIVER + 3 * len(self.model.drivers)

    @property
    def _n_w(self) -> int:
        return 2 * self.n_coordinates + self.n_inputs

    def input(self, place: int) -> FloatArray:
        """Return the row of one input, shape (n_w,)."""
        return np.eye(1, self._n_w, k=2 * self.n_coordinates + place).reshape(-1)

    def _of_rollers(self, order: int) -> FloatArray:
        """Return ways (order 0), speeds (1) or accelerations (2) of the rims relative to the first driver's.

        Coordinates have no accelerations of their own: those of all but the drivers stay zero.
        """
        rows, n_q, model = np.zeros((self.n_rollers, self._n_w)), self.n_coordinates, self.model
        if order < 2:
            rows[model.driven, order * n_q + np.arange(len(model.driven))] = 1.0
        rows[model.drivers, 2 * n_q + FIRST_DRIVER + 3 * np.arange(len(model.drivers)) + order] = 1.0
        return rows

    def _of_tensioners(self, order: int) -> FloatArray:
        first = order * self.n_coordinates + len(self.model.driven)
        return np.eye(len(self.model.spring_N_m), self._n_w, k=first)

    def _of_slips(self, order: int) -> FloatArray:
        if self.limit is None:
            return np.zeros((self.n_rollers, self._n_w))
        return np.eye(self.n_rollers, self._n_w, k=(order + 1) * self.n_coordinates - self.n_rollers)

    @cached_property
    def travel_m(self) -> FloatArray:
        """Return ξ, shape (n_tensioners, n_w)."""
        return self._of_tensioners(0)

    @cached_property
    def travel_speed_m_s(self) -> FloatArray:
        """Return dξ/dt, shape (n_tensioners, n_w)."""
        return self._of_tensioners(1)

    @cached_property
    def relative_way_m(self) -> FloatArray:
        """Return Rθ of every roller less that of the first driver, shape (n_rollers, n_w)."""
        return self._of_rollers(0)

    @cached_property
    def rim_speed_m_s(self) -> FloatArray:
        """Return Rθ' of every roller, shape (n_rollers, n_w)."""
        return self._of_rollers(1) + self.input(SPEED)

    @cached_property
    def slip_m(self) -> FloatArray:
        """Return δ of every roller, shape (n_rollers, n_w)."""
        return self._of_slips(0)

    @cached_property
    def slip_speed_m_s(self) -> FloatArray:
        """Return dδ/dt of every roller, shape (n_rollers, n_w)."""
        return self._of_slips(1)

    @cached_property
    def stretch_speed_m_s(self) -> FloatArray:
        """Return de/dt of every span, shape (n_spans, n_w)."""
        speeds = self.rim_speed_m_s - self.input(SPEED) + self.slip_speed_m_s
        return -self.model.incidence.T @ speeds - self.model.pull.T @ self.travel_speed_m_s

    @cached_property
    def spring_N(self) -> FloatArray:
        """Return T_0 + k e of every span, as if it could push, shape (n_spans, n_w)."""
        model = self.model
        stretch = -model.incidence.T @ (self.relative_way_m + self.slip_m) - model.pull.T @ self.travel_m
        return model.stiffness_N_m[:, None] * stretch + np.outer(model.preload_N, self.input(ONE))

    @cached_property
    def unclipped_N(self) -> FloatArray:
        """Return T_0 + k (e + η de/dt) of every span, as if it could push, shape (n_spans, n_w)."""
        return self.spring_N + self.model.damping_N_s_m[:, None] * self.stretch_speed_m_s

    @cached_property
    def tension_N(self) -> FloatArray:
        """Return T of every span, shape (n_spans, n_w)."""
        return np.array(self.mode.taut, dtype=np.float64)[:, None] * self.unclipped_N

    @cached_property
    def pressing_N(self) -> FloatArray:
        """Return T − ρAv² of every span, as if it could push, shape (n_spans, n_w)."""
        return self.unclipped_N - np.outer(self.model.density_kg_m, self.input(SPEED_SQUARED))

    @cached_property
    def net_pull_N(self) -> FloatArray:
        """Return D T, the belts' pull on every roller and on what lies on it, shape (n_rollers, n_w)."""
        return self.model.incidence @ self.tension_N

    @cached_property
    def limit_N(self) -> tuple[FloatArray, FloatArray]:
        """Return the friction of gross slip, forward and backward, each of shape (n_rollers, n_w)."""
        if self.limit is None:
            nothing = np.zeros_like(self.net_pull_N)
            return nothing, nothing
        pressing = np.array(self.mode.pressed, dtype=np.float64)[:, None] * self.pressing_N
        upstream, downstream = self.model.into @ pressing, self.model.out_of @ pressing
        tight, slack = (
            (1.0 - self.limit.share)[:, None],
            (self.limit.share * self.limit.growth - 1.0)[:, None],
        )
        return tight * downstream + slack * upstream, tight * upstream + slack * downstream

    @cached_property
    def load_N(self) -> FloatArray:
        """Return M/R of every roller against forward motion, shape (n_rollers, n_w); nil of one that is held."""
        return np.outer(self.model.load_N * np.array(self.mode.turning), self.input(LOAD))

    @cached_property
    def _driver_acceleration(self) -> FloatArray:
        return self._of_rollers(2) + self.input(ACCELERATION)

    @cached_property
    def rim_acceleration_m_s2(self) -> FloatArray:
        """Return Rθ'' of every roller, shape (n_rollers, n_w)."""
        rows = self._driver_acceleration.copy()
        model, mode = self.model, self.mode
        for i in model.driven:
            if mode.turning[i] == 0:
                rows[i] = 0.0
            elif mode.contact[i] == STICK:
                mass = model.roller_mass_kg[i] + model.arc_mass_kg[i]
                rows[i] = (self.net_pull_N[i] - self.load_N[i]) / mass
            else:
                rows[i] = (self.friction_N[i] - self.load_N[i]) / model.roller_mass_kg[i]
        return rows

    @cached_property
    def friction_N(self) -> FloatArray:
        """Return the friction that the belt drives each rim with, shape (n_rollers, n_w); negative on a driver."""
        model, rows = self.model, np.zeros_like(self.net_pull_N)
        for i, contact in enumerate(self.mode.contact):
            if contact != STICK:
                rows[i] = contact * self.limit_N[contact < 0][i]
            elif i in model.drivers:
                rows[i] = self.net_pull_N[i] - model.arc_mass_kg[i] * self._driver_acceleration[i]
            elif self.mode.turning[i] == 0:
                rows[i] = self.net_pull_N[i]
            else:
                share = model.arc_mass_kg[i] / (model.roller_mass_kg[i] + model.arc_mass_kg[i])
                rows[i] = self.net_pull_N[i] - share * (self.net_pull_N[i] - self.load_N[i])
        return rows

    @cached_property
    def belt_acceleration_m_s2(self) -> FloatArray:
        """Return the acceleration of the belt on every roller, shape (n_rollers, n_w)."""
        rows = self.rim_acceleration_m_s2.copy()
        for i, contact in enumerate(self.mode.contact):
            if contact != STICK:
                rows[i] = (self.net_pull_N[i] - self.friction_N[i]) / self.model.arc_mass_kg[i]
        return rows

    @cached_property
    def travel_acceleration_m_s2(self) -> FloatArray:
        """Return ξ'' of every tensioner, shape (n_tensioners, n_w)."""
        model = self.model
        rest = np.outer(model.preload_N, self.input(ONE)) + np.outer(
            model.density_kg_m, self.input(SPEED_SQUARED)
        )
        force = model.pull @ (self.tension_N - rest)
        force -= model.spring_N_m[:, None] * self.travel_m
        force -= model.tensioner_damping_N_s_m[:, None] * self.travel_speed_m_s
        return force / model.tensioner_mass_kg[:, None]

    @cached_property
    def derivative(self) -> FloatArray:
        """Return d(q, dq/dt)/dt, shape (2 n_q, n_w)."""
        n_q = self.n_coordinates
        rows = [
            np.eye(n_q, self._n_w, k=n_q),
            self.rim_acceleration_m_s2[self.model.driven] - self.input(ACCELERATION),
            self.travel_acceleration_m_s2,
        ]
        if self.limit is not None:
            rows.append(self.belt_acceleration_m_s2 - self.rim_acceleration_m_s2)
        return np.vstack(rows)


def resting_coordinates(motion: Motion, inputs: FloatArray) -> FloatArray:
    """Return the coordinates at which nothing accelerates under constant inputs u, shape (n_q,).

    Belts that slip do not take part: their δ stay zero.
    """
    n_q = motion.n_coordinates
    free = len(motion.model.driven) + len(motion.model.spring_N_m)
    rows = motion.derivative[n_q : n_q + free]
    stiffness, load = rows[:, :free], rows[:, 2 * n_q :] @ inputs
    if np.linalg.matrix_rank(stiffness) < free:
        raise InputError(
            "the press has no place of rest: a belt or tensioner is held by nothing", code="RF521"
        )
    return np.concatenate([-np.linalg.solve(stiffness, load), np.zeros(n_q - free)])


def starting_state(motion: Motion, inputs: Inputs) -> FloatArray:
    """Return (q, dq/dt) of a machine at rest in balance with the loads of the first moment, shape (2 n_q,).

    Where the drive begins with a speed, all but the drivers still stand: relative to the drive they move backward.
    """
    first = inputs.at(0.0)
    still = first.copy()
    still[[SPEED, ACCELERATION]] = 0.0
    still[SPEED + 2 :] = 0.0
    speeds = np.zeros(motion.n_coordinates)
    speeds[: len(motion.model.driven)] = -first[SPEED]
    return np.concatenate([resting_coordinates(motion, still), speeds])


def settled_tension_N(model: ElasticPress, *, speed_m_s: float, load_factor: float = 1.0) -> FloatArray:
    """Return the tensions of steady running in closed form, shape (n_spans,) [N].

    It is what a start-up tends to; with the tensioners' damping alone that takes hours, and with no damping at all it
    is only the mean.
    """
    if np.ptp(model.overspeed) > 0.0 and speed_m_s != 0.0:
        raise InputError(
            "drivers of different speed stretch the belts between them until one slips: nothing settles",
            key="overspeed",
            fix="give all drivers one speed, or solve the start-up with friction",
        )
    motion = Motion(model=model, mode=sticking(model))
    inputs = np.zeros(motion.n_inputs)
    inputs[[ONE, LOAD, SPEED, SPEED_SQUARED]] = 1.0, load_factor, speed_m_s, speed_m_s**2
    at_rest = resting_coordinates(motion, inputs)
    return np.asarray(motion.tension_N @ np.concatenate([at_rest, np.zeros_like(at_rest), inputs]))


POWERS = ("drive", "load", "belt", "tensioner", "slip", "centrifugal")
"""Works that are counted: done by the drivers, against the loads, lost in belts, tensioners' dampers and slip, and
done by the running belts' momentum ρAv² on the tensioners."""


def power_forms(motion: Motion) -> FloatArray:
    """Return the powers in the order of `POWERS` as symmetric matrices S, power = wᵀ S w, shape (6, n_w, n_w)."""
    model = motion.model
    drivers = model.drivers
    push = (model.roller_mass_kg[:, None] * motion.rim_acceleration_m_s2 + motion.load_N - motion.friction_N)[
        drivers
    ]
    kept = np.array(motion.mode.strained, dtype=np.float64)[:, None] * motion.spring_N
    momentum = -np.outer(model.pull @ model.density_kg_m, motion.input(SPEED_SQUARED))
    pairs = (
        (push, motion.rim_speed_m_s[drivers]),
        (motion.load_N, motion.rim_speed_m_s),
        (motion.tension_N - kept, motion.stretch_speed_m_s),
        (model.tensioner_damping_N_s_m[:, None] * motion.travel_speed_m_s, motion.travel_speed_m_s),
        (motion.friction_N, motion.slip_speed_m_s),
        (momentum, motion.travel_speed_m_s),
    )
    products = np.array([force.T @ speed for force, speed in pairs])
    return np.asarray(0.5 * (products + products.transpose(0, 2, 1)))


def kinetic_energy_J(motion: Motion, w: FloatArray) -> FloatArray:
    """Return the kinetic energy of rollers, belts on them and tensioners at states w of shape (..., n_w)."""
    model = motion.model
    rim, slip, travel = (
        w @ rows.T for rows in (motion.rim_speed_m_s, motion.slip_speed_m_s, motion.travel_speed_m_s)
    )
    energy = rim**2 @ model.roller_mass_kg + (rim + slip) ** 2 @ model.arc_mass_kg
    return np.asarray(0.5 * (energy + travel**2 @ model.tensioner_mass_kg))


def elastic_energy_J(motion: Motion, w: FloatArray) -> FloatArray:
    """Return the energy of the strained spans, and of the tensioners from their place at rest, at states w."""
    model = motion.model
    spring, travel = w @ motion.spring_N.T, w @ motion.travel_m.T
    if motion.limit is not None:
        spring = np.maximum(spring, 0.0)  # the linear model's belts push, and store energy by it
    held = travel**2 @ (0.5 * model.spring_N_m) + travel @ (model.pull @ model.preload_N)
    return np.asarray(spring**2 @ (0.5 / model.stiffness_N_m) + held)
