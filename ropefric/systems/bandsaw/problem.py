"""What is known of a band saw, for one case or many at once."""

from dataclasses import dataclass

import numpy as np

from ropefric.errors import InputError
from ropefric.friction.condition import FloatArray
from ropefric.systems.bandsaw.ends import CLAMPED, Ends
from ropefric.systems.bandsaw.excitation import Excitation
from ropefric.systems.bandsaw.measured import Measurement
from ropefric.systems.bandsaw.section import Section
from ropefric.systems.friction import WrapFriction
from ropefric.systems.spread import Rule, spread

__all__ = ["SawProblem"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SawProblem:
    """A blade on two wheels, m cases side by side; scalars are spread.

    Attributes
    ----------
    free_span_m : ndarray, shape (m,)
        Length l of each free span [m], positive.
    linear_density_kg_m : ndarray, shape (m,)
        Mass per length ρA [kg/m], positive.
    preload_N : ndarray, shape (m,)
        Tension F_0 of each side at rest [N], positive.
    n_modes : int
        How many frequencies of each side are wanted.
    wheel_radius_m, wheel_speed_rad_s : ndarray, shape (m,), optional
        R [m] and ω [rad/s] of the wheels.
    tension_difference_N : ndarray, shape (m,), optional
        ΔF of the sides at work [N].
    mounting_factor : ndarray, shape (m,), optional
        κ from 0 (fixed wheel axles) to 1 (constant-force mounting).
    bending_stiffness_N_m2 : ndarray, shape (m,), optional
        EI [N m2].
    ends : Ends
        How the ends of a stiff blade are held.
    section : Section, optional
        The blade's cross-section; only torsion and the wheel's friction need it.
    friction : WrapFriction, optional
        Between blade and wheel.
    wheel_wrap_rad : float
        Wrap of the blade on the wheel [rad].
    excitations : tuple of Excitation
        What may shake the blade.
    measurements : tuple of Measurement
        What was measured on the saw.
    margin_wanted : float, optional
        |mode/excitation − 1| that a recommended preload is to keep [-].
    preload_range_N : tuple of float, optional
        Lowest and highest preload to recommend [N].

    Raises
    ------
    InputError
        If the lengths disagree or a number is not finite.

    Examples
    --------
    >>> saw = SawProblem(free_span_m=1.6, linear_density_kg_m=0.5967, preload_N=[3000.0, 3412.0], n_modes=3)
    >>> saw.m, saw.speed_m_s
    (2, None)
    """

    free_span_m: FloatArray
    linear_density_kg_m: FloatArray
    preload_N: FloatArray
    n_modes: int
    wheel_radius_m: FloatArray | None = None
    wheel_speed_rad_s: FloatArray | None = None
    tension_difference_N: FloatArray | None = None
    mounting_factor: FloatArray | None = None
    bending_stiffness_N_m2: FloatArray | None = None
    ends: Ends = CLAMPED
    section: Section | None = None
    friction: WrapFriction | None = None
    wheel_wrap_rad: float = np.pi
    excitations: tuple[Excitation, ...] = ()
    measurements: tuple[Measurement, ...] = ()
    margin_wanted: float | None = None
    preload_range_N: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        for name, array in spread({name: getattr(self, name) for name in _RULES}, _RULES).items():
            object.__setattr__(self, name, array)
        if self.n_modes < 1:
            raise InputError(f"{self.n_modes} modes were asked for", key="n_modes", fix="ask for 1 or more")

    @property
    def m(self) -> int:
        """Return how many cases there are."""
        return self.preload_N.size

    @property
    def speed_m_s(self) -> FloatArray | None:
        """Return the blade's speed v = ω R [m/s], shape (m,), where the wheels are known."""
        if self.wheel_radius_m is None or self.wheel_speed_rad_s is None:
            return None
        return self.wheel_speed_rad_s * self.wheel_radius_m


_RULES: dict[str, Rule] = {
    "free_span_m": "positive",
    "linear_density_kg_m": "positive",
    "preload_N": "positive",
    "wheel_radius_m": "positive",
    "wheel_speed_rad_s": "zero or more",
    "tension_difference_N": "zero or more",
    "mounting_factor": "zero or more",
    "bending_stiffness_N_m2": "zero or more",
}
