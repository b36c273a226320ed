"""What can go wrong in a recording of the virtual rig, one fault a file."""

from ropefric.registry import Registry
from ropefric.rig.faults import (
    clock_jitter,
    drift,
    dropout,
    high_tooth,
    no_breakaway,
    no_peak,
    noisy,
    saturation,
    spike,
    too_short,
    unreadable,
)
from ropefric.rig.faults.fault import Fault

__all__ = ["FAULTS"]

FAULTS: Registry[Fault] = Registry(
    "fault",
    [
        spike.FAULT,
        dropout.FAULT,
        saturation.FAULT,
        no_breakaway.FAULT,
        no_peak.FAULT,
        too_short.FAULT,
        high_tooth.FAULT,
        drift.FAULT,
        noisy.FAULT,
        clock_jitter.FAULT,
        unreadable.FAULT,
    ],
)
"""Every fault by name."""
