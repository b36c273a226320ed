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

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple, TypeAlias

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.machine import Press, refuse_missing
from ropefric.systems.press.slip import LEAST_SLACK_N, contacts_of
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
"""Optional parts of a start-up beside elastic belts and turning rollers; a part left out is never computed."""


class ElasticPress:
    """A press ready to be moved, as arrays over spans, rollers, drivers and tensioners.

    Rollers are described at their rims: s = Rθ [m], mass J/R² [kg], load M/R [N].
    """

    def __init__(self, press: Press, effects: Collection[str] = MOVING) -> None:
        refuse_missing("a start-up", [*press.missing_elasticity, *press.missing_masses], fix="give them")
        self.press, rollers, carriers = press, press.rollers, tuple(press.tensioners.values())
        self.preload_N = standstill_tension_N(press)
        self.stiffness_N_m, self.damping_N_s_m = _springs(press, damped="belt-damping" in effects)
        self.density_kg_m = press.density_kg_m * ("belt-inertia" in effects)
        on_arcs = [sum(belt.linear_density_kg_m for belt in press.belts_on(one.name)) for one in rollers]
        arcs_m = press.radius_m * _numbers(rollers, "wrap_angle_rad")
        self.arc_mass_kg = np.array(on_arcs) * arcs_m * ("arc-inertia" in effects)
        self.roller_mass_kg = _numbers(rollers, "inertia_kg_m2") / press.radius_m**2
        self.driven, self.drivers = np.flatnonzero(press.is_driven), np.flatnonzero(~press.is_driven)
        # What holds a driven roller back is a drag: it opposes the motion, and at rest anything up to its size.
        self.drag_N = np.maximum(press.rim_load_N, 0.0) * press.is_driven
        self.overspeed = _numbers(press.drivers, "overspeed")
        self.spring_N_m = _numbers(carriers, "spring_N_m")
        self.tensioner_mass_kg = _numbers(carriers, "mass_kg")
        dampers = _numbers(carriers, "damping_N_s_m")
        self.tensioner_damping_N_s_m = dampers * ("tensioner-damping" in effects)


def _numbers(parts: Sequence[object], name: str) -> FloatArray:
    """Return a number of each part, 0 where it is not given."""
    return np.array([getattr(one, name) or 0.0 for one in parts], dtype=np.float64)


def _springs(press: Press, *, damped: bool) -> tuple[FloatArray, FloatArray]:
    """Return stiffness [N/m] and damping [N s/m] of every span, of all belts that run in it."""
    index = {(span.start, span.end): i for i, span in enumerate(press.spans)}
    stiffness_N_m, damping_N_s_m = np.zeros((2, len(index)))
    for belt in press.belts:
        spans = [index[step] for step in belt.steps]
        own_N_m = (belt.axial_stiffness_N or 0.0) / np.array(belt.span_lengths_m)
        stiffness_N_m[spans] += own_N_m
        damping_N_s_m[spans] += own_N_m * belt.damping_s * damped
    return stiffness_N_m, damping_N_s_m


def standstill_tension_N(press: Press) -> FloatArray:
    """Return the tensions of a press at rest and unloaded, shape (n_spans,) [N].

    Without torques each belt has one tension all around: its pretension between fixed centres, else that of the
    tensioners' balance k1 x + F = P T.
    """
    fixed = [belt.pretension_N is not None for belt in press.belts]
    by_belt = np.vstack([press.pull @ press.carried.T, np.eye(len(fixed))[fixed]])
    springs_N = [one.spring_N_m * one.travel_m for one in press.tensioners.values()]
    force_N = press.preload_N + np.pad(springs_N, (0, sum(fixed)))
    if np.linalg.matrix_rank(by_belt) < len(press.belts) or len(force_N) > len(press.belts):
        raise InputError(
            f"{len(force_N)} tensioners and pretensions do not settle the standstill tensions of {len(fixed)} belts",
            code="RF521",
            key="preload_N",
            fix="give each belt one tensioner or one pretension",
        )
    level_N = np.linalg.solve(by_belt, force_N)
    if not (level_N > 0.0).all():
        slack = press.belts[int(np.argmin(level_N))].name
        raise InputError(
            f"belt '{slack}' is slack at rest: {level_N.min():.6g} N",
            code="RF523",
            fix="raise the tensioner's force or travel",
        )
    return np.asarray(level_N @ press.carried)


class FrictionLimit(NamedTuple):
    """Parameters of gross slip on each roller: e^M, and κ, see above; each (n_rollers,).

    Where friction follows the tensions there are two rows, of slip forward and backward, e^M T' is a tangent,
    growth · T' + offset, and it holds while the slack side is within a factor e^±width of `slack_N`.
    """

    growth: FloatArray
    share: FloatArray
    offset_N: FloatArray | float = 0.0
    slack_N: FloatArray | None = None
    width: FloatArray = np.array(np.inf)


_LEAST_GRIP = 1e-7
"""A thousand times what `exact.guards_of` takes for zero, as a share of the tension."""
_NODES = 48
_TANGENT_ERROR = 1e-4
"""Of M, where friction follows the tensions along tangents."""
_PROBE = 1e-3


@cache
def _gauss() -> tuple[FloatArray, FloatArray]:
    return np.polynomial.legendre.leggauss(_NODES)


def friction_limit(
    model: ElasticPress,
    friction: float | WrapFriction,
    regressors: frozenset[str] = EVERYTHING,
    slack_N: FloatArray | None = None,
) -> FrictionLimit:
    """Return what gross slip on each roller is governed by, with the law at the tensions of the standstill.

    Where slack sides are given, (2, n_rollers) of slip forward and backward, friction follows them.
    """
    contacts = contacts_of(model.press, model.preload_N)
    if slack_N is not None:
        slack_N = np.maximum(slack_N, LEAST_SLACK_N)
        contacts = contacts._replace(upstream_N=slack_N, downstream_N=slack_N)
    exponent = contacts.exponent(friction, regressors)
    grip = np.expm1(exponent)
    if slack_N is None and grip.min() < _LEAST_GRIP:
        weakest = int(np.argmin(grip))
        raise InputError(
            f"roller {contacts.roller[weakest]} holds the belt by e^(μφ) − 1 = {grip[weakest]:.3g} of its tension:"
            f" a start-up with slip cannot resolve less than {_LEAST_GRIP:g} from no friction at all",
            code="RF523",
            key="friction",
            fix="give a larger coefficient or wrap angle",
        )
    # Nodes of ∫ ds/α crowd near the slack side, where a falling μ is steepest.
    nodes, weights = _gauss()
    u = 0.5 * (nodes + 1.0)
    shape = (_NODES, *(1,) * exponent.ndim)
    left = exponent - contacts.exponent(friction, regressors, share=u.reshape(shape) ** 4)
    swell = np.tensordot(2.0 * weights * u**3, np.expm1(left), axes=1)
    growth, share = np.exp(exponent), 1.0 / (1.0 + swell)
    if slack_N is None:
        return FrictionLimit(growth, share)
    tighter = slack_N * np.exp(_PROBE)
    steep = (
        contacts._replace(upstream_N=tighter, downstream_N=tighter).exponent(friction, regressors) - exponent
    )
    slope = steep / _PROBE  # dM/d ln T'
    width = np.sqrt(2.0 * _TANGENT_ERROR / np.maximum(np.abs(slope), _TANGENT_ERROR))
    return FrictionLimit(growth * (1.0 + slope), share, -growth * slope * slack_N, slack_N, width)


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
    n_rollers, n_spans = model.press.incidence.shape
    every = (True,) * n_spans
    return Mode(
        contact=(STICK,) * n_rollers, turning=(1,) * n_rollers, pressed=every, taut=every, strained=every
    )


class Motion:
    """One mode of a press as rows over w = (q, dq/dt, u), each array of shape (how many, n_w).

    Attributes
    ----------
    inputs
        The inputs u themselves.
    relative_way_m, rim_speed_m_s, rim_acceleration_m_s2
        Rθ of every roller less that of the first driver; Rθ'; Rθ''.
    slip_m, slip_speed_m_s, belt_acceleration_m_s2
        δ of every roller, dδ/dt, and the acceleration of the belt on it.
    travel_m, travel_speed_m_s, travel_acceleration_m_s2
        ξ of every tensioner, ξ', ξ''.
    stretch_speed_m_s
        de/dt of every span.
    spring_N, unclipped_N, pressing_N, tension_N
        T_0 + k e of every span; T_0 + k (e + η de/dt); this less ρAv²; all as if it could push. And T, which cannot.
    sides_N
        T' before every roller, and behind it: the slack sides of slip forward and backward.
    limit_N
        The friction of gross slip on every roller, forward and backward.
    load_N, friction_N
        M/R against forward motion, nil on a roller that is held; the friction with which the belt drives the rim,
        negative on a driver.
    derivative
        d(q, dq/dt)/dt, shape (2 n_q, n_w).
    """

    def __init__(self, model: ElasticPress, mode: Mode, limit: FrictionLimit | None = None) -> None:
        self.model, self.mode, self.limit = model, mode, limit
        self._coordinates()
        self._tensions()
        self._balances()

    def _coordinates(self) -> None:
        """Set the rows of ways, speeds and inputs."""
        model, n_rollers = self.model, len(self.model.press.rollers)
        n_driven, n_tensioners = len(model.driven), len(model.spring_N_m)
        self.n_slips = 0 if self.limit is None else n_rollers
        self.n_coordinates = n_q = n_driven + n_tensioners + self.n_slips
        self.n_inputs = FIRST_DRIVER + 3 * len(model.drivers)
        n_w = 2 * n_q + self.n_inputs
        self.inputs = np.eye(self.n_inputs, n_w, k=2 * n_q)
        # Coordinates have no accelerations of their own: those of all but the drivers stay zero here.
        way, speed, self._given_m_s2 = np.zeros((3, n_rollers, n_w))
        for order, rows in enumerate((way, speed, self._given_m_s2)):
            rows[model.drivers, 2 * n_q + FIRST_DRIVER + 3 * np.arange(len(model.drivers)) + order] = 1.0
        for order, rows in enumerate((way, speed)):
            rows[model.driven, order * n_q + np.arange(n_driven)] = 1.0
        self.relative_way_m, self._relative_m_s, self.rim_speed_m_s = way, speed, speed + self.inputs[SPEED]
        self.travel_m, self.travel_speed_m_s = (
            np.eye(n_tensioners, n_w, k=order * n_q + n_driven) for order in (0, 1)
        )
        self.slip_m, self.slip_speed_m_s = np.zeros((2, n_rollers, n_w))
        if self.n_slips:
            self.slip_m, self.slip_speed_m_s = (
                np.eye(n_rollers, n_w, k=order * n_q - n_rollers) for order in (1, 2)
            )

    def _tensions(self) -> None:
        """Set the rows of what the spans pull with, and of what presses the belts on the rollers."""
        model, press, mode = self.model, self.model.press, self.mode
        self.stretch_speed_m_s = (
            -press.incidence.T @ (self._relative_m_s + self.slip_speed_m_s)
            - press.pull.T @ self.travel_speed_m_s
        )
        stretch = -press.incidence.T @ (self.relative_way_m + self.slip_m) - press.pull.T @ self.travel_m
        self._preload_N = np.outer(model.preload_N, self.inputs[ONE])
        self._momentum_N = np.outer(model.density_kg_m, self.inputs[SPEED_SQUARED])
        self.spring_N = model.stiffness_N_m[:, None] * stretch + self._preload_N
        self.unclipped_N = self.spring_N + model.damping_N_s_m[:, None] * self.stretch_speed_m_s
        self.pressing_N = self.unclipped_N - self._momentum_N
        self.tension_N = _where(mode.taut, self.unclipped_N)
        pressed = _where(mode.pressed, self.pressing_N)
        self.sides_N = press.into @ pressed, press.out_of @ pressed
        self.load_N = np.outer(press.rim_load_N * np.array(mode.turning), self.inputs[LOAD])
        self.limit_N = self._limit_N()

    def _balances(self) -> None:
        """Set the rows of the accelerations."""
        model, press, n_q = self.model, self.model.press, self.n_coordinates
        self._move_rollers(press.incidence @ self.tension_N, self._given_m_s2 + self.inputs[ACCELERATION])
        force_N = press.pull @ (self.tension_N - self._preload_N - self._momentum_N)
        force_N -= model.spring_N_m[:, None] * self.travel_m
        force_N -= model.tensioner_damping_N_s_m[:, None] * self.travel_speed_m_s
        self.travel_acceleration_m_s2 = force_N / model.tensioner_mass_kg[:, None]
        slipping = self.belt_acceleration_m_s2 - self.rim_acceleration_m_s2
        self.derivative = np.vstack(
            [
                np.eye(n_q, self.inputs.shape[1], k=n_q),
                self.rim_acceleration_m_s2[model.driven] - self.inputs[ACCELERATION],
                self.travel_acceleration_m_s2,
                slipping[: self.n_slips],
            ]
        )

    def _limit_N(self) -> tuple[FloatArray, FloatArray]:
        if self.limit is None:
            return np.zeros_like(self.load_N), np.zeros_like(self.load_N)
        growth, share, offset_N = (
            np.broadcast_to(one, (2, len(self.load_N)))[..., None] for one in self.limit[:3]
        )
        forward, backward = (
            (1.0 - share[i]) * self.sides_N[1 - i]
            + (share[i] * growth[i] - 1.0) * self.sides_N[i]
            + share[i] * offset_N[i] * self.inputs[ONE]
            for i in (0, 1)
        )
        return forward, backward

    def _move_rollers(self, net_N: FloatArray, driver_m_s2: FloatArray) -> None:
        """Share what the belts pull, D T, between the rollers and what lies on them."""
        model, mode = self.model, self.mode
        self.friction_N, self.rim_acceleration_m_s2 = np.zeros_like(net_N), driver_m_s2
        self.belt_acceleration_m_s2 = np.zeros_like(net_N)
        for i, (contact, turning) in enumerate(zip(mode.contact, mode.turning, strict=True)):
            arc_kg, roller_kg, rim = model.arc_mass_kg[i], model.roller_mass_kg[i], self.rim_acceleration_m_s2
            sticks, drives = contact == STICK, i in model.drivers
            if not sticks:
                self.friction_N[i] = contact * self.limit_N[contact < 0][i]
            if not drives:
                acting_N, mass_kg = (
                    (net_N[i], roller_kg + arc_kg) if sticks else (self.friction_N[i], roller_kg)
                )
                rim[i] = (acting_N - self.load_N[i]) / mass_kg if turning else 0.0
            if sticks:
                self.friction_N[i] = net_N[i] - arc_kg * rim[i]
            self.belt_acceleration_m_s2[i] = rim[i] if sticks else (net_N[i] - self.friction_N[i]) / arc_kg


def _where(holds: tuple[bool, ...], rows: FloatArray) -> FloatArray:
    return np.array(holds, dtype=np.float64)[:, None] * rows


def resting_coordinates(
    motion: Motion, inputs: FloatArray, rims_N: float | FloatArray = 0.0, travels_N: float | FloatArray = 0.0
) -> FloatArray:
    """Return the coordinates at which nothing accelerates under constant inputs u, shape (n_q,).

    Belts that slip do not take part: their δ stay zero. More forces may act on all rims, and along the travels.
    """
    n_q, model = motion.n_coordinates, motion.model
    free = len(model.driven) + len(model.spring_N_m)
    rows = motion.derivative[n_q : n_q + free]
    stiffness, load = rows[:, :free], rows[:, 2 * n_q :] @ inputs
    load[: len(model.driven)] += (rims_N / (model.roller_mass_kg + model.arc_mass_kg))[model.driven]
    load[len(model.driven) :] += travels_N / model.tensioner_mass_kg
    if np.linalg.matrix_rank(stiffness) < free:
        raise InputError(
            "the press has no place of rest: a belt or tensioner is held by nothing", code="RF521"
        )
    return np.concatenate([-np.linalg.solve(stiffness, load), np.zeros(n_q - free)])


def starting_state(motion: Motion, inputs: Inputs, *, held: bool = False) -> FloatArray:
    """Return (q, dq/dt) of a machine at rest in balance with the loads of the first moment, shape (2 n_q,).

    Drags that are `held` at rest ask nothing of the belts yet. Where the drive begins with a speed, all but the
    drivers still stand: relative to the drive they move backward.
    """
    first = inputs.at(0.0)
    still = first.copy()
    still[[SPEED, ACCELERATION]] = 0.0
    still[SPEED + 2 :] = 0.0
    speeds = np.zeros(motion.n_coordinates)
    speeds[: len(motion.model.driven)] = -first[SPEED]
    held_N = motion.model.drag_N * first[LOAD] * held
    return np.concatenate([resting_coordinates(motion, still, held_N), speeds])


class Settled(NamedTuple):
    """Where a start-up leads: tensions of the spans [N], rims' ways relative to the first driver, and travels [m]."""

    tension_N: FloatArray
    relative_way_m: FloatArray
    travel_m: FloatArray


def settled(model: ElasticPress, speed_m_s: float, slip_m: FloatArray | None = None) -> Settled | None:
    """Return in closed form what a start-up tends to whose belts stick from now on.

    With the tensioners' damping alone that takes hours, and with no damping at all it is only the mean. Belts that have
    slipped by `slip_m` keep what they are displaced by. None where drivers of different speed stretch the belts between
    them until one slips.
    """
    if np.ptp(model.overspeed) > 0.0 and speed_m_s != 0.0:
        return None
    motion = Motion(model, sticking(model))
    inputs = np.zeros(motion.n_inputs)
    inputs[[ONE, LOAD, SPEED, SPEED_SQUARED]] = 1.0, 1.0, speed_m_s, speed_m_s**2
    spread_N = np.zeros(len(model.preload_N))
    if slip_m is not None:
        spread_N = -model.stiffness_N_m * (model.press.incidence.T @ slip_m)
    shifted_N = model.press.incidence @ spread_N, model.press.pull @ spread_N
    at_rest = resting_coordinates(motion, inputs, shifted_N[0], shifted_N[1])
    w = np.concatenate([at_rest, np.zeros_like(at_rest), inputs])
    given_m = np.array([one.travel_m for one in model.press.tensioners.values()])
    return Settled(motion.tension_N @ w + spread_N, motion.relative_way_m @ w, given_m + motion.travel_m @ w)


def settled_press(press: Press, speed_m_s: float, effects: Collection[str] = MOVING) -> Settled | None:
    """Return where a press settles whose belts stick from standstill on, without its start-up: no mass matters there."""
    weighed = [
        replace(
            one,
            inertia_kg_m2=one.inertia_kg_m2 or 1.0,
            tensioner=one.tensioner and replace(one.tensioner, mass_kg=one.tensioner.mass_kg or 1.0),
        )
        for one in press.rollers
    ]
    return settled(ElasticPress(replace(press, rollers=tuple(weighed)), effects), speed_m_s)


def power_pairs(motion: Motion) -> list[tuple[FloatArray, FloatArray]]:
    """Return forces and speeds, rows over w, whose products are six powers.

    They are done by the drivers, against the loads, lost in belts, tensioners' dampers and slip, and done by the
    running belts' momentum ρAv² on the tensioners.
    """
    model, drivers = motion.model, motion.model.drivers
    push = model.roller_mass_kg[:, None] * motion.rim_acceleration_m_s2 + motion.load_N - motion.friction_N
    kept = _where(motion.mode.strained, motion.spring_N)
    momentum = -np.outer(model.press.pull @ model.density_kg_m, motion.inputs[SPEED_SQUARED])
    return [
        (push[drivers], motion.rim_speed_m_s[drivers]),
        (motion.load_N, motion.rim_speed_m_s),
        (motion.tension_N - kept, motion.stretch_speed_m_s),
        (model.tensioner_damping_N_s_m[:, None] * motion.travel_speed_m_s, motion.travel_speed_m_s),
        (motion.friction_N, motion.slip_speed_m_s),
        (momentum, motion.travel_speed_m_s),
    ]


PowerRows: TypeAlias = tuple[FloatArray, FloatArray, list[int]]
"""Forces and speeds whose products are the powers, as rows, and where each power's begin."""


def power_rows(motion: Motion) -> PowerRows:
    """Return the rows over w of all forces and speeds that have a power."""
    none = np.zeros((1, motion.inputs.shape[1]))  # without tensioners
    pairs = [(force, speed) if len(force) else (none, none) for force, speed in power_pairs(motion)]
    starts = np.cumsum([0, *(len(force) for force, _ in pairs[:-1])]).tolist()
    forces, speeds = (np.vstack(rows) for rows in zip(*pairs, strict=True))
    return forces, speeds, starts


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
    spring, travel = np.maximum(w @ motion.spring_N.T, 0.0), w @ motion.travel_m.T
    held = travel**2 @ (0.5 * model.spring_N_m) + travel @ (model.press.pull @ model.preload_N)
    return np.asarray(spring**2 @ (0.5 / model.stiffness_N_m) + held)
