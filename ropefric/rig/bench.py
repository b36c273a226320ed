"""One recording of the virtual rig: mechanics, sensor, converter, and what goes wrong."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ropefric.errors import InputError
from ropefric.rig.faults import FAULTS, Fault, Samples, Setup
from ropefric.rig.protocols import RIG_PROTOCOLS, RigProtocol
from ropefric.rig.sensing import draw_sensor
from ropefric.rig.settings import HELD_BENCH, Bench
from ropefric.rig.story import SimulatedRecording
from ropefric.traces.breakaway import Status

__all__ = ["HELD_BENCH", "Bench", "simulate_recording"]

# The worse hides the lesser: a file that cannot be read shows no saturation.
_SEVERITY = (
    Status.UNREADABLE,
    Status.TOO_SHORT,
    Status.SATURATED,
    Status.NO_BREAKAWAY,
    Status.NO_PEAK,
    Status.OK,
)


def simulate_recording(
    bench: Bench,
    *,
    lift_force_N: float,
    end_tension_N: float,
    rng: np.random.Generator,
    faults: Sequence[str] = (),
    protocol: str = "breakaway",
    cell: str = "",
) -> SimulatedRecording:
    """Return one recording with known truth.

    The mechanics, the noise and the faults draw from generators of their own, so the same seed with and without
    a fault of the samples differs by that fault alone.
    """
    if not 0.0 < end_tension_N < lift_force_N < math.inf:
        raise InputError(
            f"the end tension {end_tension_N:g} N must be positive and below the lift force {lift_force_N:g} N",
            key="end_tension_N",
            fix="give the slack-side force as end_tension_N and the larger, tight-side force as lift_force_N",
        )
    way = RIG_PROTOCOLS[protocol]
    chosen = [_fault_for(name, way) for name in faults]
    story_rng, fault_rng, noise_rng = (np.random.default_rng(seed) for seed in rng.integers(2**63, size=3))
    measured_N = lift_force_N if way.measures_lift else end_tension_N
    used = bench.cell_named(cell) if cell else bench.cell_for(measured_N)
    setup = Setup(
        story=way.draw(bench, lift_force_N, end_tension_N, story_rng),
        sensor=draw_sensor(bench, used, story_rng),
    )
    for fault in chosen:
        if fault.on_setup:
            setup = fault.on_setup(setup, bench, fault_rng)
    time_s = np.arange(math.floor(setup.story.end_s * bench.sampling_rate_Hz) + 1) / bench.sampling_rate_Hz
    force_N = setup.story.force_N(time_s)
    samples = Samples(time_s=time_s, counts=setup.sensor.read(force_N, time_s, noise_rng))
    for fault in chosen:
        if fault.on_samples:
            samples = fault.on_samples(samples, setup, fault_rng)
    truth = setup.story.truth()
    statuses = [truth.status, *(fault.expected_status for fault in chosen if fault.expected_status)]
    return SimulatedRecording(
        time_s=samples.time_s,
        counts=samples.counts,
        true_time_s=time_s,
        true_force_N=force_N,
        truth=replace(
            truth,
            status=min(statuses, key=_SEVERITY.index),
            faults=tuple(fault.name for fault in chosen),
            cell=setup.sensor.cell.name,
        ),
    )


def _fault_for(name: str, way: RigProtocol) -> Fault:
    fault = FAULTS[name]
    if fault.protocols and way.name not in fault.protocols:
        raise InputError(
            f"fault '{name}' does not go with protocol '{way.name}'",
            key="faults",
            fix=f"it goes with: {', '.join(fault.protocols)}",
        )
    return fault
