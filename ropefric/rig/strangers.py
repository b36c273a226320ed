"""Recordings of rigs unlike the first, with known truth: families of mechanics, of sensors and of what goes wrong.

`recordings(seed)` draws rigs over wide ranges (1 N to 5 kN, 50 Hz to 10 kHz, micro-slip from a thousandth of the climb's
way to more than what stays stable), integrates them (`dynamics`) and passes the spring's force through a sensor.
The truth comes from the noise-free force of the spring alone.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf, nan
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray, frozen_array
from ropefric.registry import Registry
from ropefric.rig.disturbances import Take, Truth, sense
from ropefric.rig.dynamics import Motion, Slider, simulate, stops
from ropefric.traces.breakaway import Status
from ropefric.traces.calibration import Calibration
from ropefric.traces.clock import mend_clock
from ropefric.traces.trace import ForceTrace

Rng = np.random.Generator
TIERS = ("clean", "lab", "nasty")
_SLIPPING = 0.1  # of the driving speed: from here on the contact slips
_MACROSCOPIC = 8.0  # micro-slip lengths that a slip must exceed
_FALL = 0.015  # of F_A; a first fall of less, or lost in the noise, is none
_BATCH = 240


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording:
    """One recording as a stranger sends it."""

    name: str
    family: str
    tier: str
    time_s: FloatArray
    force_N: FloatArray
    truth: Truth
    counts: FloatArray | None = None
    calibration: Calibration | None = None

    def trace(self) -> ForceTrace:
        """Return the recording as the picker gets it: clock mended, counts with their saturation."""
        keep, time_s, notes = mend_clock(self.time_s, [self.force_N], name=self.name)
        trace = ForceTrace(time_s=time_s, force_N=self.force_N[keep], name=self.name, notes=notes)
        if self.counts is None or self.calibration is None:
            return trace
        counts = self.counts.astype(np.int64)
        force_N, saturation = self.calibration.apply(counts)
        return replace(
            trace, force_N=force_N, counts=counts, calibration=self.calibration, saturation=saturation
        )


# How the rope is pulled -----------------------------------------------------------------------------------------------

_RANGES: dict[str, Any] = {
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


def _draw(rng: Rng, given: Mapping[str, Any]) -> dict[str, Any]:
    drawn: dict[str, Any] = {}
    for key, span in (_RANGES | dict(given)).items():
        if isinstance(span, tuple) and span and isinstance(span[0], str):
            drawn[key] = str(rng.choice(span))
        elif isinstance(span, tuple):
            low, high = span
            drawn[key] = float(
                np.exp(rng.uniform(np.log(low), np.log(high))) if key in _LOG else rng.uniform(low, high)
            )
        else:
            drawn[key] = span
    return drawn


def _slider(rng: Rng, drawn: dict[str, Any]) -> Slider:
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
        part = rng.uniform(0.2, 0.8)
        bristle = (mu + spread) / (speed_m_s * climb_s * rng.uniform(0.004, 0.06))
        contact = {
            "b": part * b,
            "excess": (1.0 - part) * spread,
            "stribeck_m_s": speed_m_s * rng.uniform(1.5, 8.0),
            "bristle_1_m": bristle,
            "bristle_damping_s_m": rng.uniform(0.1, 1.0) * np.sqrt(bristle * mass / (force_N * gain)),
            "viscous_s_m": rng.uniform(0.0, 0.02) * mu / speed_m_s,
        }
    knots, end_s = _profile(rng, drawn)
    way = speed_m_s * climb_s
    return Slider(
        law=law, stiffness_N_m=stiffness, mass_kg=mass,
        damping_N_s_m=2.0 * drawn["damping"] * np.sqrt(stiffness * mass),
        wheel_kg=drawn["wheel"] * mass, motor_N_m=drawn["motor"] * stiffness,
        motor_damping_N_s_m=2.0 * rng.uniform(0.1, 0.7) * np.sqrt(drawn["wheel"] * drawn["motor"] * stiffness * mass),
        slack_N=slack_N, wrap_rad=wrap, tared=bool(tared), mu=mu, slip_m=slip_m, speed_m_s=speed_m_s,
        hold_s=slip_m / speed_m_s * np.exp(decades), wear=drawn["wear"], wear_m=way * rng.uniform(0.3, 1.0),
        start_mu=0.0 if tared else mu * rng.uniform(-0.6, 0.2), profile=knots,
        partial=_partial_slips(rng, drawn, mu + 0.85 * spread, way, gain), bumps=_bumps(rng, drawn, way),
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
    rng: Rng, drawn: dict[str, Any], start_mu: float, way: float, gain: float
) -> tuple[tuple[float, float, float], ...]:
    if not drawn.get("partials"):
        return ()
    n = 1 if drawn["partials"] == "one" else int(rng.integers(3, 12))
    low, high, size = (0.78, 0.96, (0.02, 0.12)) if n == 1 else (0.3, 0.96, (0.003, 0.03))
    parts = np.sort(rng.uniform(low, high, n))
    return tuple(
        (
            start_mu + np.log(part) / gain,
            way * rng.uniform(*size),
            drawn["climb_s"] * rng.uniform(0.003, 0.02),
        )
        for part in parts.tolist()
    )


def _bumps(rng: Rng, drawn: dict[str, Any], way: float) -> tuple[tuple[float, float, float], ...]:
    """Return where the contact is stronger: right after the first slip, or much later."""
    if not drawn.get("teeth"):
        return ()
    where = (0.25, 0.6) if drawn["teeth"] == "second" else (0.7, 1.8)
    n = 1 if drawn["teeth"] == "second" else int(rng.integers(1, 4))
    return tuple(
        (way * rng.uniform(*where), rng.uniform(0.06, 0.25), way * rng.uniform(0.05, 0.15)) for _ in range(n)
    )


# What is true ---------------------------------------------------------------------------------------------------------


def truth_of(motion: Motion, slider: Slider, *, resolved_N: float) -> Truth | None:
    """Return what is true of a motion; None where the first fall is neither resolved nor absent, so nobody could say."""
    fast = np.abs(motion.slip_m_s) > _SLIPPING * slider.speed_m_s
    micro_m = max(
        slider.slip_m, (slider.mu + slider.excess) / slider.bristle_1_m if slider.law == "lugre" else 0.0
    )
    enough_m = min(_MACROSCOPIC * micro_m, 0.03 * float(motion.wheel_m.max()))
    edges = np.flatnonzero(np.diff(np.concatenate(([False], fast, [False])).astype(np.int8)))
    onset = next(
        (
            first
            for first, last in zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True)
            if motion.slip_m_s[first] > 0.0 and motion.slip_m[last] - motion.slip_m[first] >= enough_m
        ),
        None,
    )
    partial_s = [_begun(motion, mu) for mu, _, _ in slider.partial]
    if onset is None:
        return Truth(status=Status.NO_BREAKAWAY, partial_s=tuple(at_s for at_s in partial_s if at_s < inf))
    stop = int(np.searchsorted(motion.time_s, stops(slider, float(motion.time_s[onset]))))
    force_N = motion.force_N[onset:stop]
    if force_N.size < 3:
        return None
    fall_N = np.maximum.accumulate(force_N) - force_N
    needed_N = max(_FALL * float(force_N.max()), resolved_N)
    fallen = np.flatnonzero(fall_N >= needed_N)
    if not fallen.size:
        slid_m = motion.slip_m[stop - 1] - motion.slip_m[onset]
        is_clear = fall_N.max() < 0.5 * needed_N and slid_m > 0.2 * motion.slip_m[stop - 1] > 0.0
        return Truth(status=Status.NO_PEAK) if is_clear else None
    peak = int(np.argmax(force_N[: fallen[0] + 1]))
    peak_N, time_s = float(force_N[peak]), float(motion.time_s[onset + peak])
    # A lesser fall while it slips already, or a partial slip that begins this one: two answers would be right.
    slipping_s = float(motion.time_s[onset]), float(motion.time_s[onset + fallen[0]])
    if fall_N[:peak].max(initial=0.0) > 0.3 * needed_N or any(
        slipping_s[0] - lasting_s <= at_s <= slipping_s[1]
        for at_s, (_, _, lasting_s) in zip(partial_s, slider.partial, strict=True)
    ):
        return None
    higher = np.flatnonzero(force_N[peak:] > peak_N)
    until = peak + int(higher[0]) if higher.size else force_N.size
    return Truth(
        status=Status.OK, peak_N=peak_N, time_s=time_s, fall_N=peak_N - float(force_N[peak:until].min()),
        partial_s=tuple(at_s for at_s in partial_s if at_s < time_s),
    )  # fmt: skip


def _begun(motion: Motion, mu: float) -> float:
    at = int(np.argmax(motion.mu >= mu))
    return float(motion.time_s[at]) if motion.mu[at] >= mu else inf


@dataclass(frozen=True, slots=True, kw_only=True)
class Family:
    """Recordings of one kind: how they are drawn, and what the sensor does to them."""

    name: str
    tier: str
    ranges: Mapping[str, Any] = field(default_factory=dict)
    faults: tuple[str, ...] = ()
    expects: Status | None = None


_LAB = {"noise": (1e-3, 6e-3), "rough": (0.0, 0.012), "bits": 12, "rate_Hz": (150.0, 1e4)}
_NASTY = {"noise": (3e-3, 1.5e-2), "rough": (0.0, 0.02), "bits": 11, "rate_Hz": (100.0, 1e4)}
_STEADY = {"direct": (1.05, 1.4), "laws": ("ageing", "slip")}
_SLOW = {**_STEADY, "direct": (0.9, 1.3), "drop": (0.12, 0.4)}
_TEETH = {"direct": (0.3, 0.7), "laws": ("ageing", "slip"), "slide_s": (1.5, 4.0)}
_NO_PEAK = {
    **_STEADY,
    "direct": (1.5, 4.0),
    "drop": (0.005, 0.02),
    "rough": (0.0, 0.003),
    "laws": ("ageing",),
}
_OK, _NONE, _PEAKLESS, _CUT = Status.OK, Status.NO_BREAKAWAY, Status.NO_PEAK, Status.SATURATED


def _family(
    name: str,
    tier: str,
    *faults: str,
    expects: Status = Status.OK,
    like: Mapping[str, Any] | None = None,
    **own: Any,
) -> Family:
    basis = {"clean": {}, "lab": _LAB, "nasty": _NASTY}[tier]
    return Family(
        name=name, tier=tier, ranges={**basis, **(like or {}), **own}, faults=faults, expects=expects
    )


FAMILIES: Registry[Family] = Registry("family of recordings", [
    _family("sharp", "clean"),
    _family("sharp-slip-law", "clean", laws="slip", critical=(0.01, 0.2)),
    _family("bristles", "clean", laws="lugre"),
    _family("rounded", "clean", like=_SLOW, fall_s=(0.05, 0.3), climb_s=(0.5, 4.0)),
    _family("fall-20-80-ms", "clean", like=_SLOW, fall_s=(0.02, 0.08), climb_s=(0.4, 2.0)),
    _family("fall-0.1-0.6-s", "clean", like=_SLOW, fall_s=(0.1, 0.6), climb_s=(0.8, 6.0)),
    _family("strong-stick-slip", "clean", like=_TEETH, drop=(0.3, 0.6), critical=(0.02, 0.2)),
    _family("weak-stick-slip", "clean", like=_TEETH, drop=(0.06, 0.15), critical=(0.3, 0.9)),
    _family("hardening", "clean", wear=(0.03, 0.12)),
    _family("second-higher", "clean", teeth="second", critical=(0.03, 0.2)),
    _family("rests", "clean", rests=True),
    _family("held-quiet", "clean", expects=_NONE, held=(0.4, 0.85), laws=("ageing", "slip"), slide_s=(0.5, 2.0)),
    _family("climbing", "clean", expects=_NONE, stopped=(0.3, 0.9)),
    _family("no-peak", "clean", like=_NO_PEAK, expects=_PEAKLESS),
    _family("lab", "lab"),
    _family("lab-bristles", "lab", laws="lugre"),
    _family("lab-rounded", "lab", like=_SLOW, fall_s=(0.03, 0.4)),
    _family("fall-0.3-2-s", "lab", like=_SLOW, fall_s=(0.3, 2.0), climb_s=(1.5, 8.0)),
    _family("lab-stick-slip", "lab", like=_TEETH, critical=(0.03, 0.7)),
    _family("one-precursor", "lab", partials="one"),
    _family("many-precursors", "lab", partials="many"),
    _family("snag", "lab", "snag", idle_s=(0.5, 2.0)),
    _family("jog", "lab", jog=(0.1, 0.8)),
    _family("impact", "lab", "impact", idle_s=(0.4, 2.0)),
    _family("late-higher", "lab", teeth="late", slide_s=(1.5, 4.0)),
    _family("wear", "lab", like=_SLOW, fall_s=(0.02, 0.2), wear=(0.1, 0.5), slide_s=(1.0, 3.0)),
    _family("two-pulls", "lab", pulls=2),
    _family("strokes", "lab", pulls=4, slide_s=(0.3, 1.0), climb_s=(0.2, 1.5)),
    _family("short", "lab", idle_s=(0.05, 0.15), slide_s=(0.1, 0.4), ending="cut", climb_s=(0.2, 0.8), hang=0.0),
    _family("few-samples", "lab", rate_Hz=(50.0, 100.0), climb_s=(0.3, 1.0), per_climb=8.0),
    _family("hum", "lab", "hum", hum=(1e-3, 8e-3), rate_Hz=(400.0, 1e4)),
    _family("pink", "lab", "pink", noise=(1e-3, 3e-3)),
    _family("filter", "lab", "filter", climb_s=(1.0, 6.0)),
    _family("held-creeping", "lab", expects=_NONE, held=(0.7, 0.95), slide_s=(0.8, 3.0)),
    _family("held-let-down", "lab", expects=_NONE, held=(0.5, 0.9), ending="let-down"),
    _family("lab-climbing", "lab", expects=_NONE, stopped=(0.3, 0.93)),
    _family("lab-no-peak", "lab", like=_NO_PEAK, expects=_PEAKLESS),
    _family("nasty", "nasty"),
    _family("ringing", "nasty", "ringing", rate_Hz=(800.0, 1e4), critical=(0.03, 0.15)),
    _family("tare-shift", "nasty", "tare-shift"),
    _family("drift", "nasty", "drift"),
    _family("spikes", "nasty", "spikes"),
    _family("double-spikes", "nasty", "double-spikes"),
    _family("dropouts", "nasty", "dropouts"),
    _family("gaps", "nasty", "gaps"),
    _family("jitter", "nasty", "jitter"),
    _family("duplicated-rows", "nasty", "doubled"),
    _family("coarse", "nasty", "coarse"),
    _family("loud-hum", "nasty", "hum", hum=(8e-3, 3e-2), rate_Hz=(300.0, 5e3)),
    _family("hard-snag", "nasty", "snag", "hum", hum=(1e-3, 1e-2), idle_s=(0.5, 2.0)),
    _family("hard-impact", "nasty", "impact", "ringing", idle_s=(0.4, 2.0), rate_Hz=(500.0, 1e4)),
    _family("hard-precursor", "nasty", "spikes", partials="one"),
    _family("everything", "nasty", "snag", "filter", "hum", "drift", "spikes", hum=(1e-3, 1e-2), climb_s=(1.0, 5.0)),
    _family("clipped", "nasty", "clipped", expects=_CUT),
    _family("clipped-counts", "nasty", "clipped-counts", expects=_CUT),
    _family("late-start", "nasty", "late", like=_SLOW, expects=_PEAKLESS, fall_s=(0.02, 0.2), slide_s=(1.5, 3.0)),
    _family("hard-held", "nasty", "hum", "drift", hum=(1e-3, 1e-2), expects=_NONE, held=(0.5, 0.9)),
])  # fmt: skip
"""Every kind of recording by name."""


def recordings(
    seed: int, *, per_family: int = 8, families: Sequence[str] = (), tiers: Sequence[str] = TIERS
) -> Iterator[Recording]:
    """Yield recordings of unfamiliar rigs with known truth; the same for the same seed, whichever families are asked.

    Parameters
    ----------
    seed : int
        The same seed draws the same recordings.
    per_family : int
        How many of each family.
    families, tiers : sequence of str
        Only these families, only these tiers; all by default.
    """
    chosen = [FAMILIES[name] for name in families or FAMILIES]
    jobs = [(one, number) for one in chosen if one.tier in tiers for number in range(per_family)]
    for start in range(0, len(jobs), _BATCH):
        yield from _made(seed, jobs[start : start + _BATCH])


def _made(seed: int, jobs: list[tuple[Family, int]]) -> Iterator[Recording]:
    """Draw until every recording's truth is one that can be told; a draw that is not is thrown away."""
    order = list(FAMILIES)
    done: dict[int, Take] = {}
    for attempt in range(12):
        open_jobs = [i for i in range(len(jobs)) if i not in done]
        takes = []
        for i in open_jobs:
            family, number = jobs[i]
            rng = np.random.default_rng([seed, order.index(family.name), number, attempt])
            drawn = _draw(rng, family.ranges)
            takes.append(Take(rng=rng, drawn=drawn, slider=_slider(rng, drawn)))
        for i, take, motion in zip(open_jobs, takes, simulate([take.slider for take in takes]), strict=True):
            family = jobs[i][0]
            part = 6.0 * take.drawn["noise"] + 3.0 * take.drawn.get("hum", 0.0) + 1.5 * take.drawn["rough"]
            truth = truth_of(motion, take.slider, resolved_N=part * take.slider.scale_N)
            if truth is None:
                continue
            take.truth = truth
            sense(take, motion, family.faults)
            if take.truth.status == family.expects:
                done[i] = take
        if len(done) == len(jobs):
            break
    for i, (family, number) in enumerate(jobs):
        if i in done:
            take = done[i]
            yield Recording(
                name=f"{family.name}-{number:03d}", family=family.name, tier=family.tier,
                time_s=frozen_array(take.time_s), force_N=frozen_array(take.force_N),
                truth=take.truth if take.truth.status != Status.SATURATED else replace(take.truth, peak_N=nan),
                counts=take.counts, calibration=take.calibration,
            )  # fmt: skip
