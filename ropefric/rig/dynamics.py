"""Ropes on turning wheels with rate-and-state friction or LuGre bristles: many recordings integrated side by side.

A motor drives a wheel through a spring; the wheel drags a rope, whose mass pulls a load cell's spring:

    m u' = T(μ) + (1 - tared) F_B - k x - c u            T(μ) = F_B (e^{μφ} - 1)
    M W' = k_m (X_m(t) - X) + c_m (V_m(t) - W) - T(μ)    v = W - u - (partial slips)

Shared by nothing with `bench`, whose forces are drawn as closed forms: here the peak, the fall and the teeth follow
from stiffness, mass and the friction of the moment.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from math import exp, inf
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import SolverError

_GAMMA = 1.0 - np.sqrt(0.5)  # SDIRK of order 2, L-stable: a stiff contact is damped, not rung
_TOLERANCE = 2e-3
_LOG_STEP = 0.35  # the logarithms of slip speed and state change by at most this in a step
_MOST_STEPS, _SHORTEST_S = 400_000, 1e-12


@dataclass(frozen=True, slots=True, kw_only=True)
class Slider:
    """One recording's rope, wheel, motor and friction; forces in N, lengths in m, times in s.

    Friction coefficient, rate-and-state (`ageing`, `slip`), regularised after Rice and Ben-Zion (1996):
    μ = a asinh(v / 2v_0 exp((μ_0 + b ln(v_0 θ/D_c))/a)). LuGre (Canudas de Wit et al. 1995): μ = σ_0 z + σ_1 z' + σ_2 v,
    z' = v - σ_0 |v| z/g, g = μ_0 + b ln(1 + v_0 θ/D_c) + Δ exp(-(v/v_s)²); θ ages in both.
    `profile` are (time, motor speed), `partial` are (μ that starts it, slip, lasting), `bumps` are (slip distance where,
    relative height, width) of the strength, `rough` are (relative amplitude, wavelength, phase) along the wheel.
    """

    law: str = "ageing"
    stiffness_N_m: float
    mass_kg: float
    damping_N_s_m: float
    wheel_kg: float
    motor_N_m: float
    motor_damping_N_s_m: float
    slack_N: float
    wrap_rad: float
    tared: bool = True
    mu: float
    a: float = 0.0
    b: float = 0.0
    slip_m: float
    speed_m_s: float
    hold_s: float
    excess: float = 0.0
    stribeck_m_s: float = 1.0
    bristle_1_m: float = 1.0
    bristle_damping_s_m: float = 0.0
    viscous_s_m: float = 0.0
    wear: float = 0.0
    wear_m: float = 1.0
    start_mu: float = 0.0
    profile: tuple[tuple[float, float], ...]
    partial: tuple[tuple[float, float, float], ...] = ()
    bumps: tuple[tuple[float, float, float], ...] = ()
    rough: tuple[tuple[float, float, float], ...] = ()
    end_s: float
    longest_step_s: float = 0.01

    @property
    def start_N(self) -> float:
        """Return the force of the cell's spring before anything turns [N]."""
        return self.slack_N * (exp(self.start_mu * self.wrap_rad) - self.tared)

    @property
    def scale_N(self) -> float:
        """Return the force of friction at the reference coefficient [N]."""
        return self.slack_N * (exp(self.mu * self.wrap_rad) - self.tared)


class Motion(NamedTuple):
    """Motion of a slider, at the steps of the integration, shape (n,): spring force, rope, wheel, slip, friction."""

    time_s: FloatArray
    force_N: FloatArray
    rope_m_s: FloatArray
    wheel_m: FloatArray
    wheel_m_s: FloatArray
    slip_m: FloatArray
    slip_m_s: FloatArray
    mu: FloatArray
    stiffness_N_m: float

    def spring_N(self, time_s: FloatArray) -> FloatArray:
        """Return the force of the cell's spring at any times [N], by cubic pieces through force and its rate."""
        rate_N_s = self.stiffness_N_m * self.rope_m_s
        inside = np.clip(time_s, self.time_s[0], self.time_s[-1])
        return np.asarray(CubicHermiteSpline(self.time_s, self.force_N, rate_N_s)(inside))


def stops(slider: Slider, after_s: float) -> float:
    """Return when the motor next begins to slow down."""
    pairs = zip(slider.profile, slider.profile[1:], strict=False)
    return next((a[0] for a, b in pairs if b[1] < a[1] and a[0] > after_s), inf)


def _padded(rows: Sequence[tuple[tuple[float, ...], ...]], filler: tuple[float, ...]) -> FloatArray:
    """Return tables of unequal length as one array (quantity, slider, entry)."""
    most = max((len(row) for row in rows), default=0)
    return np.array([[*row, *[filler] * (most - len(row))] for row in rows], dtype=np.float64).reshape(
        len(rows), most, len(filler)
    ).transpose(2, 0, 1)  # fmt: skip


def _columns(sliders: Sequence[Slider]) -> dict[str, Any]:
    """Return every number of the sliders as an array, the motor's speed as its kinks (time, acceleration gained)."""
    made: dict[str, Any] = {}
    for item in fields(Slider):
        if item.name not in {"law", "profile", "partial", "bumps", "rough"}:
            made[item.name] = np.array([getattr(one, item.name) for one in sliders], dtype=np.float64)
    kinks = []
    for one in sliders:
        times, speeds = np.array(one.profile, dtype=np.float64).T
        slopes = np.diff(speeds) / np.diff(times)
        gained = np.diff(np.concatenate(([0.0], slopes, [0.0])))
        kinks.append(tuple(zip(times.tolist(), gained.tolist(), strict=True)))
    made["kinks"] = _padded(kinks, (inf, 0.0))
    made["partial"] = _padded([one.partial for one in sliders], (inf, 0.0, 1.0))
    made["bumps"] = _padded([one.bumps for one in sliders], (inf, 0.0, 1.0))
    made["rough"] = _padded([one.rough for one in sliders], (0.0, 1.0, 0.0))
    made["slip_law"] = np.array([one.law == "slip" for one in sliders])
    made["scale_N"] = np.array([one.scale_N for one in sliders])
    made["begun_s"] = np.full(made["partial"].shape[1:], inf)
    return made


def _motor(p: dict[str, Any], time_s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return way and speed of the motor."""
    since = np.maximum(time_s[:, None] - p["kinks"][0], 0.0)
    since[~np.isfinite(since)] = 0.0
    return (0.5 * p["kinks"][1] * since**2).sum(axis=1), (p["kinks"][1] * since).sum(axis=1)


def _partial_m_s(p: dict[str, Any], time_s: FloatArray) -> FloatArray | float:
    """Return the speed of partial slips that have begun: half a sine each."""
    if not p["partial"].shape[2]:
        return 0.0
    _, slip_m, lasting_s = p["partial"]
    part = np.clip((time_s[:, None] - p["begun_s"]) / lasting_s, 0.0, 1.0)
    return np.asarray((0.5 * np.pi * slip_m / lasting_s * np.sin(np.pi * part)).sum(axis=1))


def _aged(p: dict[str, Any], state: FloatArray, speed: FloatArray, h: FloatArray) -> FloatArray:
    """Return ln(v_0 θ/D_c) after a time at a constant slip speed: exactly, by the ageing or the slip law."""
    rate = np.abs(speed) / p["slip_m"]
    gone = rate * h
    left = np.exp(-gone)
    whole_s = np.where(gone > 1e-8, -np.expm1(-gone) / np.maximum(rate, 1e-300), h)
    ageing = np.log(np.exp(state) * left + whole_s * p["speed_m_s"] / p["slip_m"])
    steady = np.log(p["speed_m_s"] / np.maximum(np.abs(speed), 1e-30))
    return np.asarray(np.where(p["slip_law"], steady + (state - steady) * left, ageing))


def _strength(p: dict[str, Any], wheel_m: FloatArray, slid_m: FloatArray) -> FloatArray:
    """Return the reference coefficient with wear, bumps and roughness of the moment."""
    factor = 1.0 - p["wear"] * np.expm1(-slid_m / p["wear_m"])
    if p["bumps"].shape[2]:
        where, height, width = p["bumps"]
        factor = factor + (height * np.exp(-(((slid_m[:, None] - where) / width) ** 2))).sum(axis=1)
    if p["rough"].shape[2]:
        amplitude, wave_m, phase = p["rough"]
        factor = factor + (amplitude * np.sin(2 * np.pi * wheel_m[:, None] / wave_m + phase)).sum(axis=1)
    return np.asarray(p["mu"] * factor)


def simulate(sliders: Sequence[Slider]) -> list[Motion]:
    """Return what every slider does until its end, each with steps of its own.

    Raises
    ------
    SolverError
        If a slider's steps become too small, or too many.
    """
    found: dict[int, Motion] = {}
    for kind in (_RateState, _Lugre):
        here = [i for i, one in enumerate(sliders) if (one.law == "lugre") == (kind is _Lugre)]
        if here:
            found |= zip(here, kind([sliders[i] for i in here]).run(), strict=True)
    return [found[i] for i in range(len(sliders))]


class _RateState:
    """Sliders of rate-and-state friction on their way, a column of `y` each.

    Rows: rope and its speed, wheel and its speed, bristle, slip speed, μ, ln(v_0 θ/D_c), slip so far, time.
    """

    def __init__(self, sliders: list[Slider]) -> None:
        self.sliders = sliders
        self.p = p = _columns(sliders)
        self.who = np.arange(len(sliders))
        self.h = 1e-4 * np.minimum(1.0, p["end_s"])
        rope = np.array([one.start_N for one in sliders]) / p["stiffness_N_m"]
        wheel = -p["slack_N"] * np.expm1(p["start_mu"] * p["wrap_rad"]) / p["motor_N_m"]
        aged = np.log(p["hold_s"] * p["speed_m_s"] / p["slip_m"])
        mu, zero = p["start_mu"], np.zeros(len(sliders))
        self.y = np.array([rope, zero, wheel, zero, mu / p["bristle_1_m"], zero, mu, aged, zero, zero])
        self.kept = [(self.who, self.y)]

    def run(self) -> Iterator[Motion]:
        """Integrate all to their ends and return their motions."""
        for _ in range(_MOST_STEPS):
            if not self.who.size:
                return self._motions()
            if (self.h < _SHORTEST_S).any():
                raise SolverError(f"the rig came to a halt: {self.sliders[int(self.who[np.argmin(self.h)])]}")
            self._advance()
        raise SolverError(f"the rig is not done after {_MOST_STEPS} steps")

    def _motions(self) -> Iterator[Motion]:
        who = np.concatenate([one for one, _ in self.kept])
        y = np.concatenate([one for _, one in self.kept], axis=1)[:, np.argsort(who, kind="stable")]
        ends = np.cumsum(np.bincount(who, minlength=len(self.sliders)))[:-1]
        for one, piece in zip(self.sliders, np.split(y, ends, axis=1), strict=True):
            rope, u, wheel, turn, _, v, mu, _, slid, t = piece
            yield Motion(
                time_s=t, force_N=one.stiffness_N_m * rope, rope_m_s=u, wheel_m=wheel - wheel[0], wheel_m_s=turn,
                slip_m=slid, slip_m_s=v, mu=mu, stiffness_N_m=one.stiffness_N_m,
            )  # fmt: skip

    def _aged_strength(self, strength: FloatArray, state: FloatArray) -> FloatArray:
        return np.asarray(strength + self.p["b"] * state)

    def _contact(
        self, given: tuple[FloatArray, ...], guess: tuple[FloatArray, FloatArray]
    ) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
        """Return μ, slip speed v with v(μ) + G T(μ) = v*, the bristle, and whether it was found; v = 2 v_e sinh(μ/a)."""
        p, mu = self.p, guess[0]
        strength, bristle, _, free, give = given
        a, phi, slack = p["a"], p["wrap_rad"], p["slack_N"]
        creep = 2.0 * p["speed_m_s"] * np.exp(-np.minimum(strength / a, 650.0))
        arrived = np.zeros(mu.shape, dtype=bool)
        for _ in range(40):
            grown = np.exp(mu / a)
            v, dv = 0.5 * creep * (grown - 1.0 / grown), 0.5 * creep * (grown + 1.0 / grown) / a
            pull = np.exp(mu * phi)
            step = -(v + give * slack * (pull - 1.0) - free) / (dv + give * slack * phi * pull)
            # Far off, the exponential would need one step per e-fold: go to where it takes the speed of the tangent.
            far = np.abs(step) > 2.0 * a
            if far.any():
                jump = a * np.arcsinh((v + dv * step) / creep) - mu
                step = np.where(far & (jump * step > 0.0) & (np.abs(jump) < np.abs(step)), jump, step)
            # Who has arrived stays, so that nobody's result depends on the company.
            mu = np.where(arrived, mu, np.clip(mu + step, -690.0 * a, 690.0 * a))
            arrived |= np.abs(step) < 1e-9 * (a + np.abs(mu))
            if arrived.all():
                break
        return mu, creep * np.sinh(mu / a), bristle, arrived

    def _advance(self) -> None:
        """Try a step of every slider, take those that are good enough, and choose the next."""
        p, y = self.p, self.y[:5]
        v, mu, aged, slid, t = self.y[5:]
        h = np.minimum(self.h, np.maximum(p["end_s"] - t, 1e-9))
        here = _strength(p, y[2] + 0.5 * h * y[3], slid + 0.5 * h * np.abs(v))
        creep = 1e-2 * p["speed_m_s"]
        log_v, half_v = np.arcsinh(v / creep), v
        hh = _GAMMA * h
        heavy = p["mass_kg"] + hh * p["damping_N_s_m"] + hh**2 * p["stiffness_N_m"]
        turned = p["wheel_kg"] + hh * p["motor_damping_N_s_m"] + hh**2 * p["motor_N_m"]
        give, hung_N = hh / heavy + hh / turned, (1.0 - p["tared"]) * p["slack_N"]
        base, guess, stages = y, (mu, v), []
        good = np.ones(h.size, dtype=bool)
        for part in (_GAMMA, 1.0):
            at_s = t + part * h
            way, speed = _motor(p, at_s)
            u = (p["mass_kg"] * base[1] + hh * (hung_N - p["stiffness_N_m"] * base[0])) / heavy
            drive_N = p["motor_N_m"] * (way - base[2]) + p["motor_damping_N_s_m"] * speed
            turn = (p["wheel_kg"] * base[3] + hh * drive_N) / turned
            # The contact's age at the end of the stage, at the slip speed to be expected halfway there.
            strength = self._aged_strength(here, _aged(p, aged, half_v, part * h))
            mu, slip, bristle, found = self._contact(
                (strength, base[4], hh, turn - u - _partial_m_s(p, at_s), give), guess
            )
            friction_N = p["slack_N"] * np.expm1(mu * p["wrap_rad"])
            u, turn = u + hh * friction_N / heavy, turn - hh * friction_N / turned
            stages.append((np.array([base[0] + hh * u, u, base[2] + hh * turn, turn, bristle]), slip))
            base = y + (1.0 - _GAMMA) / _GAMMA * (stages[-1][0] - y)
            guess, good = (mu, slip), good & found
            gained = np.clip(0.5 / _GAMMA * (np.arcsinh(slip / creep) - log_v), -2.0, 2.0)
            half_v = creep * np.sinh(log_v + gained)
        (early, early_v), (late, late_v) = stages
        slipped = (1.0 - _GAMMA) * early_v + _GAMMA * late_v
        state = _aged(p, aged, slipped, h)
        wrong = np.max([
            p["stiffness_N_m"] * h * np.abs(late[1] - early[1]) / (_TOLERANCE * p["scale_N"]),
            ((np.arcsinh(late_v / creep) - log_v) / _LOG_STEP) ** 2,
            (np.maximum(aged - state, 0.0) / _LOG_STEP) ** 2,
            (p["stiffness_N_m"] * (late[0] - y[0]) / (0.03 * p["scale_N"])) ** 2,
            (p["bristle_1_m"] * (late[4] - y[4]) / (0.05 * p["mu"])) ** 2,
        ], axis=0)  # fmt: skip
        wrong = np.where(good & np.isfinite(wrong), wrong, 100.0)
        taken = wrong <= 1.0
        after = np.array([*late, late_v, guess[0], state, slid + h * np.abs(slipped), t + h])
        self.y = np.where(taken, after, self.y)
        next_h = h * np.clip(0.9 / np.sqrt(np.maximum(wrong, 1e-12)), 0.2, 1.6)
        self.h = np.minimum(next_h, p["longest_step_s"])
        self._start_partial_slips(taken)
        self.kept.append((self.who[taken], self.y[:, taken]))
        on = self.y[9] < p["end_s"] - 1e-9
        if not on.all():
            self.who, self.h, self.y = self.who[on], self.h[on], self.y[:, on]
            self.p = {key: value[..., on, :] if value.ndim > 1 else value[on] for key, value in p.items()}

    def _start_partial_slips(self, taken: BoolArray) -> None:
        starts_mu, _, lasting_s = self.p["partial"]
        if starts_mu.size:
            mu, t, begun_s = self.y[6][:, np.newaxis], self.y[9][:, np.newaxis], self.p["begun_s"]
            begins = (mu >= starts_mu) & np.isinf(begun_s) & taken[:, np.newaxis]
            self.p["begun_s"] = begun_s = np.where(begins, t, begun_s)
            running = (t >= begun_s) & (t < begun_s + lasting_s)
            self.h = np.minimum(self.h, np.where(running, 0.05 * lasting_s, inf).min(axis=1))


class _Lugre(_RateState):
    """Sliders with bristles, whose bend is part of the motion."""

    def _aged_strength(self, strength: FloatArray, state: FloatArray) -> FloatArray:
        return np.asarray(strength + self.p["b"] * np.logaddexp(0.0, state))

    def _contact(
        self, given: tuple[FloatArray, ...], guess: tuple[FloatArray, FloatArray]
    ) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
        p, v = self.p, guess[1]
        strength, bristle, hh, free, give = given
        s0, s1, s2 = p["bristle_1_m"], p["bristle_damping_s_m"], p["viscous_s_m"]
        phi, slack, vs = p["wrap_rad"], p["slack_N"], p["stribeck_m_s"]
        mu, bend, arrived = guess[0], bristle, np.zeros(v.shape, dtype=bool)
        for _ in range(25):
            fading = p["excess"] * np.exp(-((v / vs) ** 2))
            g, dg = strength + fading, -2.0 * v / vs**2 * fading
            size, sign = np.abs(v), np.sign(v)
            below = 1.0 + hh * size * s0 / g
            bend = (bristle + hh * v) / below
            mu = s0 * bend + s1 * (bend - bristle) / hh + s2 * v
            slope = (s0 + s1 / hh) * hh * (1.0 - bend * s0 * (sign / g - size * dg / g**2)) / below + s2
            pull = np.exp(np.clip(mu * phi, -50.0, 50.0))
            slope = 1.0 + give * slack * phi * pull * slope
            step = -(v + give * slack * (pull - 1.0) - free) / np.maximum(slope, 0.1)
            arrived |= np.abs(step) < 1e-8 * (p["speed_m_s"] + np.abs(v))
            v = np.where(arrived, v, v + step)
            if arrived.all():
                break
        return mu, v, bend, arrived
