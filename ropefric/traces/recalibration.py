"""A better calibration for a recording that kept its raw counts."""

from dataclasses import replace

from ropefric.errors import InputError
from ropefric.traces.calibration import Calibration
from ropefric.traces.trace import ForceTrace


def recalibrate(trace: ForceTrace, calibration: Calibration) -> ForceTrace:
    """Return the recording with its forces computed anew from the raw counts it kept."""
    if trace.counts is None:
        raise InputError(
            f"{trace.name} holds forces only, no raw counts, so no other calibration can be applied",
            code="RF213",
            path=trace.source,
            fix="import the column of raw counts as channel `counts`",
        )
    force_N, saturation = calibration.apply(trace.counts)
    return replace(trace, force_N=force_N, calibration=calibration, saturation=saturation)
