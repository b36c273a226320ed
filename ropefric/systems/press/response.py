"""How speed, springs and elastic belts act together on the tensions: which of them a model has decides the form."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ropefric.friction.condition import FloatArray
from ropefric.systems.press.statics import Statics
from ropefric.systems.press.steady import SteadyState, steady_state

__all__ = ["Parts", "respond"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Parts:
    """What resists and what gives way when the belts run.

    Attributes
    ----------
    mass : bool
        The belts have their mass, which a tension has to keep on its path.
    springs : bool
        The tensioners, on their springs.
    stretch : bool
        The belts, by their EA.

    Examples
    --------
    >>> Parts(mass=True, springs=True, stretch=True).tensioner, Parts(springs=True).keeps_tension
    ('elastic', True)
    """

    mass: bool = False
    springs: bool = False
    stretch: bool = False

    @property
    def keeps_tension(self) -> bool:
        """Return whether T' stays whatever the speed: without mass, or without stretch on springs."""
        return not self.mass or (self.springs and not self.stretch)

    @property
    def tensioner(self) -> Literal["locked", "elastic"]:
        """Return what the tensioners do where T' does not stay."""
        return "elastic" if self.springs and self.stretch else "locked"


def respond(
    parts: Parts,
    statics: Statics,
    *,
    preload_N: FloatArray | None,
    speed_m_s: FloatArray,
    load_factor: FloatArray,
) -> SteadyState:
    """Return the steady state of a press of which some parts give way.

    Between locked tensioners T stays and T' = T − ρAv² (eq. (39)), whether or not the belts stretch. Belts that do
    not stretch leave tensioners on springs where they are, and T' stays. Where both give way dT' = −ρAv²/(1 + s).

    Raises
    ------
    InputError, SolverError
        As `steady_state`.
    """
    if parts.keeps_tension:
        still = steady_state(
            statics, preload_N=preload_N, speed_m_s=np.zeros_like(speed_m_s), load_factor=load_factor
        )
        return replace(still, speed_m_s=speed_m_s)
    return steady_state(
        statics,
        preload_N=preload_N,
        speed_m_s=speed_m_s,
        load_factor=load_factor,
        tensioner=parts.tensioner,
    )
