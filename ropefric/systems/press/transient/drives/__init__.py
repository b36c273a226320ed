"""Every drive law by name; one file declares one law."""

from ropefric.registry import Registry
from ropefric.systems.press.transient.drives import constant, ramp, s_curve, table
from ropefric.systems.press.transient.drives.law import DriveLaw

__all__ = ["DRIVE_LAWS"]

DRIVE_LAWS: Registry[DriveLaw] = Registry(
    "drive law", [constant.DRIVE_LAW, ramp.DRIVE_LAW, s_curve.DRIVE_LAW, table.DRIVE_LAW]
)
"""The drive laws."""
