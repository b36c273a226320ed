"""The moving beam in scaled form: length 1, time in units of l/c, three numbers instead of five."""

from dataclasses import dataclass

import numpy as np

from ropefric.errors import InputError
from ropefric.systems.bandsaw.ends import Ends

__all__ = ["ScaledBeam"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaledBeam:
    """w_ττ + 2V w_xτ − S w_xx + ε² w_xxxx = 0 on 0 ≤ x ≤ 1, with S = 1 − V².

    Near the critical speed, V = √(1 + β ε²), all frequencies go with the margin S + β ε², which therefore is a number
    of its own: computed from V it would have no digits left.

    Attributes
    ----------
    stiffness : float
        ε² = EI/(F l²) [-], positive.
    speed : float
        V = v/c [-], zero or more.
    net : float
        S = 1 − V² [-]; negative above the string's critical speed.
    margin : float
        S + β ε² [-], positive.
    ends : Ends
        How the ends are held.

    Raises
    ------
    InputError
        If a number is outside its range.

    Examples
    --------
    >>> from ropefric.systems.bandsaw.ends import PINNED
    >>> beam = ScaledBeam.at_speed(1e-2, 0.5, PINNED)
    >>> beam.net, round(beam.margin, 6), round(beam.critical_speed, 6)
    (0.75, 0.848696, 1.048187)
    """

    stiffness: float
    speed: float
    net: float
    margin: float
    ends: Ends

    def __post_init__(self) -> None:
        if not (np.isfinite(self.stiffness) and self.stiffness > 0.0):
            raise InputError(
                f"the stiffness ratio is {self.stiffness:g}; it must be finite and positive",
                key="stiffness",
                fix="a blade without stiffness is a string",
            )
        if not (np.isfinite(self.speed) and self.speed >= 0.0):
            raise InputError(
                f"the speed ratio is {self.speed:g}; it must be finite and zero or more", key="speed"
            )
        if not self.margin > 0.0:
            raise InputError(
                f"the speed ratio is {self.speed:.9g}, not below the critical {self.critical_speed:.9g}, where "
                "the first frequency is zero",
                code="RF530",
                key="speed",
                fix="run slower, or raise the tension",
            )

    @classmethod
    def at_speed(cls, stiffness: float, speed: float, ends: Ends) -> "ScaledBeam":
        """Return the beam at a speed ratio V.

        Parameters
        ----------
        stiffness, speed, ends
            ε², V and the ends.
        """
        net = (1.0 - speed) * (1.0 + speed)
        return cls(
            stiffness=stiffness, speed=speed, net=net, margin=net + ends.buckling * stiffness, ends=ends
        )

    @classmethod
    def at_shortfall(cls, stiffness: float, shortfall: float, ends: Ends) -> "ScaledBeam":
        """Return the beam at V = (1 − δ) V_c, as exact as δ is.

        Parameters
        ----------
        stiffness : float
            ε².
        shortfall : float
            δ from above 0 to 1, which is rest.
        ends : Ends
            How the ends are held.

        Examples
        --------
        >>> from ropefric.systems.bandsaw.ends import PINNED
        >>> round(ScaledBeam.at_shortfall(1e-2, 1e-15, PINNED).margin * 1e15, 9)
        2.197392088
        """
        if not 0.0 < shortfall <= 1.0:
            raise InputError(f"the shortfall is {shortfall:g}; it must be above 0 and at most 1")
        limit_squared = 1.0 + ends.buckling * stiffness
        margin = limit_squared * shortfall * (2.0 - shortfall)
        speed = float(np.sqrt(limit_squared)) * (1.0 - shortfall)
        return cls(
            stiffness=stiffness, speed=speed, net=margin - ends.buckling * stiffness, margin=margin, ends=ends
        )

    @property
    def critical_speed(self) -> float:
        """Return V_c = √(1 + β ε²) [-]."""
        return float(np.sqrt(1.0 + self.ends.buckling * self.stiffness))
