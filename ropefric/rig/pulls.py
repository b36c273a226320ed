"""Pulls of the second rig: machines and contacts drawn from wide ranges, and their truth."""

from collections.abc import Callable, Mapping
from math import inf, nan
from typing import Any, NamedTuple

import numpy as np

from ropefric.rig.dynamics import Motion, Slider, stops
from ropefric.traces.breakaway import Status

Rng = np.random.Generator
_SLIPPING = 0.1  # of the driving speed: from here on the contact slips
_MACROSCOPIC = 8.0  # micro-slip lengths that a slip must exceed
_FALL = 0.015  # of F_A; a first fall of less, or lost in the noise, is none


class Truth(NamedTuple):
    """Truth of a recording: its status, and F_A and its time where there is one.

    F_A is the largest noise-free force of the spring between the onset of macroscopic slip (which lasts many
    micro-slip lengths) and its first fall.
    """

    status: Status
    peak_N: float = nan
    time_s: float = nan


RANGES: dict[str, Any] = {
    "laws": ("ageing", "slip", "lugre"),
    "force_N": (1.0, 5e3),
    "wraps": (0.0, 3.0),
    "mu": (0.12, 0.6),
    "climb_s": (0.4, 6.0),
    "speed_m_s": (3e-5, 2e-2),
    "critical": (0.03, 0.35),  # stiffness over the critical one: below 1 the contact is unstable
    "fall_s": None,  # how long the fall lasts; takes the place of `critical`
    "drop": (0.08, 0.45),
    "direct": (0.3, 1.2),  # a/b; above 1 sliding is steady
    "natural_Hz": (15.0, 220.0),
    "damping": (0.04, 0.4),
    "wheel": (2.0, 40.0),
    "motor": (2.0, 40.0),
    "idle_s": (0.3, 1.5),
    "hang": 0.4,  # how often the weights are hung while it records
    "soft_start": (0.02, 0.4),
    "slide_s": (0.5, 3.0),
    "ending": ("stop", "let-down", "cut"),
    "rate_Hz": (300.0, 5e3),
    "noise": (1e-4, 1e-3),  # of F_A
    "rough": (0.0, 0.004),
    "wear": (0.0, 0.0),
    "pulls": 1,
}
_LOG = {"force_N", "climb_s", "speed_m_s", "critical", "fall_s", "natural_Hz", "damping", "wheel", "motor",
        "rate_Hz", "noise", "slide_s", "idle_s"}  # fmt: skip


def draw_numbers(rng: Rng, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return one number (or word) for every range, the given ones in place of the ordinary."""
    drawn: dict[str, Any] = {}
    for key, span in (RANGES | dict(given)).items():
        if not isinstance(span, tuple):
            drawn[key] = span
        elif isinstance(span[0], str):
            drawn[key] = str(rng.choice(span))
        elif key in _LOG:
            drawn[key] = float(np.exp(rng.uniform(*np.log(span))))
        else:
            drawn[key] = float(rng.uniform(*span))
    return drawn


def draw_slider(rng: Rng, drawn: dict[str, Any]) -> Slider:
    """Return the rope, wheel, motor and contact that what was drawn amounts to."""
    force_N, climb_s, speed_m_s, law = (drawn[key] for key in ("force_N", "climb_s", "speed_m_s", "laws"))
    # A pin on a disk is a rope of hardly any wrap.
    wrap = 2.0 * np.pi * drawn["wraps"] if drawn["wraps"] > 0.1 else 0.01
    mu = min(drawn["mu"], 2.5 / wrap)
    tared = wrap < 0.1 or rng.random() > drawn["hang"]
    slack_N = force_N / (np.exp(mu * wrap) - tared)
    gain = wrap * slack_N * np.exp(mu * wrap) / force_N  # d ln F / dμ
    spread = -np.log1p(-drawn["drop"]) / gain  # static less kinetic coefficient
    decades = rng.uniform(4.0, 12.0)  # ln(v θ_0/D_c)
    together = force_N / (speed_m_s * climb_s)
    stiffness = together * (1.0 + 1.0 / drawn["motor"])
    mass = stiffness / (2.0 * np.pi * drawn["natural_Hz"]) ** 2
    b = spread / decades
    a = max(drawn["direct"] * b, 0.0015)
    if drawn["fall_s"]:
        slip_m = speed_m_s * drawn["fall_s"] / (decades if law == "ageing" else 2.5)
    else:
        slip_m = drawn["critical"] * b * max(1.0 - drawn["direct"], 0.1) * gain * speed_m_s * climb_s
    contact: dict[str, Any] = {"a": a, "b": b}
    if law == "lugre":
        part = 1.0 if drawn["fall_s"] else rng.uniform(0.2, 0.8)  # of the weakening, that by slip
        bristle = (mu + spread) / (speed_m_s * climb_s * rng.uniform(0.004, 0.06))
        contact = {"b": part * b, "excess": (1.0 - part) * spread, "bristle_1_m": bristle}
        contact["stribeck_m_s"] = speed_m_s * rng.uniform(0.3, 4.0)
        contact["bristle_damping_s_m"] = rng.uniform(0.1, 1.0) * np.sqrt(bristle * mass / (force_N * gain))
        contact["viscous_s_m"] = rng.uniform(0.0, 0.02) * mu / speed_m_s
    knots, end_s = _profile(rng, drawn)
    way = speed_m_s * climb_s

    def reached_mu(part: float) -> float:
        """Return the coefficient at a part of the force of static friction, or nearly so."""
        return float(np.log(part * (np.exp((mu + 0.8 * spread) * wrap) - tared) + tared)) / wrap

    return Slider(
        law=law, stiffness_N_m=stiffness, mass_kg=mass,
        damping_N_s_m=2.0 * drawn["damping"] * np.sqrt(stiffness * mass),
        wheel_kg=drawn["wheel"] * mass, motor_N_m=drawn["motor"] * stiffness,
        motor_damping_N_s_m=2.0 * rng.uniform(0.1, 0.7) * np.sqrt(drawn["wheel"] * drawn["motor"] * stiffness * mass),
        slack_N=slack_N, wrap_rad=wrap, tared=bool(tared), mu=mu, slip_m=slip_m, speed_m_s=speed_m_s,
        hold_s=slip_m / speed_m_s * np.exp(decades), wear=drawn["wear"], wear_m=way * rng.uniform(0.3, 1.0),
        start_mu=0.0 if tared else mu * rng.uniform(-0.6, 0.2), profile=knots,
        partial=_partial_slips(rng, drawn, way, reached_mu), bumps=_bumps(rng, drawn, way),
        rough=tuple((drawn["rough"] / 3.0, way * rng.uniform(0.02, 0.5), rng.uniform(0, 6.3)) for _ in range(4)),
        end_s=end_s, longest_step_s=min(0.02, 0.02 * climb_s), **contact,
    )  # fmt: skip


def _profile(rng: Rng, drawn: dict[str, Any]) -> tuple[tuple[tuple[float, float], ...], float]:
    """Return the motor's speed at times, and when the recording ends."""
    speed, climb_s = drawn["speed_m_s"], drawn["climb_s"]
    rise_s = climb_s * drawn["soft_start"]
    now = drawn["idle_s"] * (1.0 if drawn["hang"] == 0.0 else 1.5)
    knots = [(0.0, 0.0)]

    def go(lasting_s: float, to: float, change_s: float) -> None:
        nonlocal now
        knots.extend([(now, knots[-1][1])] * (now > knots[-1][0]) + [(now + change_s, to)])
        now += change_s + lasting_s

    if drawn.get("jog"):  # a push forth and back before the pull
        part = drawn["jog"] * climb_s / rng.uniform(1.0, 6.0)
        quick = speed * drawn["jog"] * climb_s / part
        go(0.8 * part, quick, 0.1 * part)
        go(0.0, 0.0, 0.1 * part)
        go(0.8 * part, -quick, 0.1 * part)
        go(rng.uniform(0.2, 1.0) * drawn["idle_s"], 0.0, 0.1 * part)
    for number in range(int(drawn["pulls"])):
        if drawn.get("rests"):  # the motor stops on its way up and goes on
            go(climb_s * rng.uniform(0.2, 0.6), speed, rise_s)
            go(climb_s * rng.uniform(0.1, 0.6), 0.0, 0.05 * climb_s)
        if "held" in drawn:
            go(climb_s * drawn["held"], speed, rise_s)
            go(drawn["slide_s"] * max(climb_s, 0.5), 0.0, 0.05 * climb_s)
            break
        if "stopped" in drawn:
            go(0.0, speed, rise_s)
            return (*knots, (now + 1e3, speed)), now + climb_s * drawn["stopped"]
        sliding_s = drawn["slide_s"] * (climb_s if number == 0 else rng.uniform(0.5, 1.0) * climb_s)
        go(climb_s * 1.25 + sliding_s, speed, rise_s)
        if number + 1 < drawn["pulls"]:
            back = rng.uniform(0.5, 0.95)
            go(climb_s * back / 3.0, -3.0 * speed, 0.1 * climb_s)
            go(rng.uniform(0.2, 1.0) * climb_s, 0.0, 0.1 * climb_s)
    if drawn["ending"] == "cut":
        return (*knots, (now + 1e3, knots[-1][1])), now
    go(rng.uniform(0.1, 0.3) * climb_s, 0.0, 0.05 * climb_s)
    if drawn["ending"] == "let-down":
        quick = rng.uniform(1.0, 6.0)
        go(climb_s * rng.uniform(0.4, 0.9) / quick, -quick * speed, 0.05 * climb_s)
        go(rng.uniform(0.1, 0.4), 0.0, 0.05 * climb_s)
    return (*knots, (now + 1e3, 0.0)), now


def _partial_slips(
    rng: Rng, drawn: dict[str, Any], way: float, reached_mu: Callable[[float], float]
) -> tuple[tuple[float, float, float], ...]:
    if not drawn.get("partials"):
        return ()
    n = 1 if drawn["partials"] == "one" else int(rng.integers(3, 12))
    low, high, size = (0.78, 0.96, (0.02, 0.12)) if n == 1 else (0.3, 0.96, (0.003, 0.03))
    parts = np.sort(rng.uniform(low, high, n)).tolist()
    lasting_s = drawn["climb_s"] * rng.uniform(0.003, 0.02)
    return tuple((reached_mu(part), way * rng.uniform(*size), lasting_s) for part in parts)


def _bumps(rng: Rng, drawn: dict[str, Any], way: float) -> tuple[tuple[float, float, float], ...]:
    """Return where the contact is stronger: right after the first slip, or much later."""
    if not drawn.get("teeth"):
        return ()
    where = (0.25, 0.6) if drawn["teeth"] == "second" else (0.7, 1.8)
    n = 1 if drawn["teeth"] == "second" else int(rng.integers(1, 4))
    return tuple(
        (way * rng.uniform(*where), rng.uniform(0.06, 0.25), way * rng.uniform(0.05, 0.15)) for _ in range(n)
    )


_RSF = ("ageing", "slip")
SLOW = {"laws": _RSF, "direct": (0.9, 1.3), "drop": (0.12, 0.4)}
"""A contact that weakens slowly, so that its fall follows `fall_s`."""

NO_PEAK = {"laws": "ageing", "direct": (1.5, 4.0), "drop": (0.005, 0.02), "rough": (0.0, 0.003)}
"""A contact that gets stronger with speed by more than it got in rest."""


def _onset(motion: Motion, slider: Slider) -> int | None:
    """Return where the rope begins to slip for many micro-slip lengths."""
    fast = np.abs(motion.slip_m_s) > _SLIPPING * slider.speed_m_s
    bent_m = (slider.mu + slider.excess) / slider.bristle_1_m if slider.law == "lugre" else 0.0
    enough_m = min(_MACROSCOPIC * max(slider.slip_m, bent_m), 0.03 * float(motion.wheel_m.max()))
    edges = np.flatnonzero(np.diff(np.concatenate(([False], fast, [False])).astype(np.int8)))
    firsts, lasts = edges[::2], edges[1::2] - 1
    far = (motion.slip_m_s[firsts] > 0.0) & (motion.slip_m[lasts] - motion.slip_m[firsts] >= enough_m)
    return int(firsts[np.argmax(far)]) if far.any() else None


def _roughness(slider: Slider) -> float:
    """Return the part of F_A by which what differs along the wheel falls while the rope slides."""
    gain = slider.wrap_rad * slider.mu * (1.0 + (slider.slack_N / slider.scale_N if slider.tared else 0.0))
    return gain * sum(height for height, _, _ in slider.rough)


def truth_of(motion: Motion, slider: Slider, *, noise: float = 0.0) -> Truth | None:
    """Return the truth of a motion; None where the first fall is neither resolved nor absent."""
    onset = _onset(motion, slider)
    partial_s = [_begun(motion, mu, slider.profile[1][0]) for mu, _, _ in slider.partial]
    if onset is None:
        return Truth(status=Status.NO_BREAKAWAY)
    stop = int(np.searchsorted(motion.time_s, stops(slider, float(motion.time_s[onset]))))
    force_N = motion.force_N[onset:stop]
    if force_N.size < 3:
        return None
    fall_N = np.maximum.accumulate(force_N) - force_N
    needed_N = max(_FALL, noise, 2.0 * _roughness(slider)) * float(force_N.max())
    fallen = np.flatnonzero(fall_N >= needed_N)
    if not fallen.size:
        slid_m = motion.slip_m[stop - 1] - motion.slip_m[onset]
        is_clear = fall_N.max() < 0.5 * needed_N and slid_m > 0.2 * motion.slip_m[stop - 1] > 0.0
        return Truth(status=Status.NO_PEAK) if is_clear else None
    peak = int(np.argmax(force_N[: fallen[0] + 1]))
    peak_N, time_s = float(force_N[peak]), float(motion.time_s[onset + peak])
    # A lesser fall while it slips already, or a partial slip that begins this one: two answers would be right.
    begins_s, ends_s = float(motion.time_s[onset]), float(motion.time_s[onset + fallen[0]])
    partial_N = np.interp(partial_s, motion.time_s, motion.force_N)
    if fall_N[:peak].max(initial=0.0) > 0.3 * needed_N or min(partial_s, default=0.0) > time_s:
        return None
    if any(
        begins_s - lasting_s <= at_s <= ends_s or (at_s < time_s and at_N > 0.97 * peak_N)
        for at_s, at_N, (_, _, lasting_s) in zip(partial_s, partial_N, slider.partial, strict=True)
    ):
        return None
    return Truth(status=Status.OK, peak_N=peak_N, time_s=time_s)


def _begun(motion: Motion, mu: float, start_s: float) -> float:
    """Return when a coefficient was first reached; never, where it was before the motor started."""
    at = int(np.argmax(motion.mu >= mu))
    return float(motion.time_s[at]) if motion.mu[at] >= mu and motion.time_s[at] > start_s else inf
