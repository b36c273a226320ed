"""Forces drawn along corners, what swings or strikes on them, recordings of the rig, and what is picked of them."""

import numpy as np

from ropefric.rig.bench import Bench
from ropefric.rig.recording import simulate_recording
from ropefric.traces.breakaway import PickSettings
from ropefric.traces.decision import pick_breakaway
from ropefric.traces.trace import ForceTrace

TIME_S = np.arange(0.0, 6.0, 0.001)
REST = ((0.0, 0.0), (1.0, 0.0))
PULL = (*REST, (3.0, 100.0), (3.004, 70.0), (6.0, 70.0))
"""A rest of a second, a climb to 100 N within two, a slip by 30 N, sliding."""


def line(*corners, time_s=TIME_S):
    """Return the force along a line through corners (time, force)."""
    return np.interp(time_s, *zip(*corners, strict=True))


def drawn(*corners, noise_N=0.1, seed=7, time_s=TIME_S):
    """Return the force along a line through corners (time, force), with noise."""
    return line(*corners, time_s=time_s) + np.random.default_rng(seed).normal(0.0, noise_N, time_s.size)


def since(begin_s, time_s=TIME_S):
    """Return the time since a moment, nothing before."""
    return np.maximum(time_s - begin_s, 0.0)


def ring(at_s, height_N, *, lasts_s=0.03, hz=40.0, time_s=TIME_S):
    """Return what swings from a moment on and dies away."""
    gone_s = since(at_s, time_s)
    return height_N * np.exp(-gone_s / lasts_s) * np.sin(2.0 * np.pi * hz * gone_s)


def knock(at_s, height_N, lasts_s, time_s=TIME_S):
    """Return half a sine."""
    return height_N * np.sin(np.pi * np.clip((time_s - at_s) / lasts_s, 0.0, 1.0))


def settles(at_s, drop_N, tau_s, time_s=TIME_S):
    """Return what has fallen since a moment of what comes to its level little by little."""
    return drop_N * -np.expm1(-since(at_s, time_s) / tau_s)


def hung(levels_N, *, swing_Hz=8.0, damping=0.06, begin_s=0.3, every_s=0.5, time_s=TIME_S):
    """Return the force of weights hung on one by one, each of which swings around its level."""
    force_N, omega = np.zeros(time_s.size), 2.0 * np.pi * swing_Hz
    for n, added_N in enumerate(np.diff(levels_N, prepend=0.0)):
        gone_s = since(begin_s + n * every_s, time_s)
        force_N += added_N * (1.0 - np.exp(-damping * omega * gone_s) * np.cos(omega * gone_s))
    return force_N


def loaded(*teeth, rate_N_s, begins=((0.0, 0.0), (0.3, 0.0)), fall_s=0.004):
    """Return the corners of a force that a machine loads at one rate up to each of some teeth (top, bottom)."""
    corners = [*begins]
    for top_N, bottom_N in teeth:
        now_s, force_N = corners[-1]
        slips_s = now_s + (top_N - force_N) / rate_N_s
        corners += [(slips_s, top_N), (slips_s + fall_s, bottom_N)]
    return corners


def picked(force_N, settings=PickSettings(), time_s=TIME_S):  # noqa: B008  (it is frozen)
    """Return what is picked of a force."""
    return pick_breakaway(ForceTrace(time_s=time_s, force_N=force_N), settings)[0]


def record(seed, *faults, lift_N=320.7, end_N=80.0, bench=Bench(), **ways):  # noqa: B008  (it is frozen)
    """Return a recording of the rig with known truth."""
    rng = np.random.default_rng(seed)
    return simulate_recording(bench, lift_force_N=lift_N, end_tension_N=end_N, rng=rng, faults=faults, **ways)
