"""A better calibration for a recording that kept its raw counts."""

from dataclasses import replace

from ropefric.errors import InputError
from ropefric.traces.calibration import Calibration
from ropefric.traces.trace import ForceTrace

__all__ = ["recalibrate"]


def recalibrate(trace: ForceTrace, calibration: Calibration) -> ForceTrace:
    """Return the recording with its forces computed anew from the raw counts it kept.

    Parameters
    ----------
    trace : ForceTrace
        A recording with `counts`; it is not changed.
    calibration : Calibration
        The calibration to apply, tare included.

    Raises
    ------
    InputError
        RF213 if the recording has no raw counts.
    DataError
        RF211 if a count is above the converter's range.

    Examples
    --------
    >>> import numpy as np
    >>> from ropefric.traces.calibration import ForceCell
    >>> trace = ForceTrace(time_s=[0.0, 0.1], force_N=[0.0, 1.0], counts=np.array([0, 1]))
    >>> recalibrate(trace, Calibration(cell=ForceCell(name="small", full_scale_N=2046.0))).force_N.tolist()
    [0.0, 2.0]
    """
    if trace.counts is None:
        raise InputError(
            f"{trace.name} holds forces only, no raw counts, so no other calibration can be applied",
            code="RF213",
            path=trace.source,
            fix="import the column of raw counts as channel `counts`",
        )
    force_N, saturation = calibration.apply(trace.counts)
    return replace(trace, force_N=force_N, calibration=calibration, saturation=saturation)
