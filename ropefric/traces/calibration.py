"""ADC counts -> volts -> newtons."""

from dataclasses import dataclass

__all__ = ["Calibration", "Saturation"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """Placeholder."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Saturation:
    """Placeholder."""
