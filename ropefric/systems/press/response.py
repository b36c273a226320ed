"""How speed, springs and elastic belts act together on the tensions: which of them a model has decides the form."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ropefric.friction.condition import FloatArray
from ropefric.systems.press.statics import Statics
from ropefric.systems.press.steady import SteadyState, steady_state

__all__ = ["RESPONSES", "Parts", "respond"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Parts:
    """What gives way when the belts run.

    Attributes
    ----------
    springs : bool
        The tensioners, on their springs.
    stretch : bool
        The belts, by their EA.

    Examples
    --------
    >>> Parts(springs=True, stretch=False) in RESPONSES
    True
    """

    springs: bool = False
    stretch: bool = False


Respond = Callable[[Statics, FloatArray | None, FloatArray, FloatArray], SteadyState]


def _locked(
    statics: Statics, preload_N: FloatArray | None, speed_m_s: FloatArray, load_factor: FloatArray
) -> SteadyState:
    """Nothing gives way: T stays, T' = T − ρAv² (eq. (39))."""
    return steady_state(statics, preload_N=preload_N, speed_m_s=speed_m_s, load_factor=load_factor)


def _followed(
    statics: Statics, preload_N: FloatArray | None, speed_m_s: FloatArray, load_factor: FloatArray
) -> SteadyState:
    """Belts that do not stretch leave the tensioners where they are: T' stays, whatever the speed."""
    still = steady_state(
        statics, preload_N=preload_N, speed_m_s=np.zeros_like(speed_m_s), load_factor=load_factor
    )
    return replace(still, speed_m_s=speed_m_s)


def _elastic(
    statics: Statics, preload_N: FloatArray | None, speed_m_s: FloatArray, load_factor: FloatArray
) -> SteadyState:
    """Both give way: dT' = −ρAv²/(1 + s)."""
    return steady_state(
        statics, preload_N=preload_N, speed_m_s=speed_m_s, load_factor=load_factor, tensioner="elastic"
    )


RESPONSES: dict[Parts, Respond] = {
    Parts(): _locked,
    Parts(stretch=True): _locked,
    Parts(springs=True): _followed,
    Parts(springs=True, stretch=True): _elastic,
}
"""The steady state for every choice of parts; a belt that stretches between locked rollers keeps its tension."""


def respond(
    parts: Parts,
    statics: Statics,
    *,
    preload_N: FloatArray | None,
    speed_m_s: FloatArray,
    load_factor: FloatArray,
) -> SteadyState:
    """Return the steady state of a press of which some parts give way.

    Raises
    ------
    InputError, SolverError
        As `steady_state`.
    """
    return RESPONSES[parts](statics, preload_N, speed_m_s, load_factor)
