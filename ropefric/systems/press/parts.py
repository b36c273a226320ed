"""The parts of a belt press as plain data: rollers, tensioners, belts. `Press` checks them together."""

from dataclasses import dataclass
from typing import Literal

__all__ = ["Belt", "Role", "Roller", "Tensioner"]

Role = Literal["driver", "driven", "tensioner"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tensioner:
    """The spring, preload and geometry that carry a translating roller.

    Its equation of motion is m ẍ + C1 ẋ + k1 x = T'_in cos(upstream) + T'_out cos(downstream) − F with the tensions
    T' = T − ρAv², eqs. (21), (22).

    Attributes
    ----------
    spring_N_m : float
        Stiffness k1 [N/m], zero or more; zero is a cylinder of constant force.
    travel_m : float
        Travel x at rest [m], positive the way the belt pulls.
    force_N : float
        Preload F [N], zero or more.
    mass_kg : float, optional
        Mass m of what translates [kg].
    damping_N_s_m : float
        Damping C1 [N s/m].
    upstream_angle_rad, downstream_angle_rad : float
        Angles [rad] of the belt that arrives and of the belt that leaves, against the travel.

    Examples
    --------
    >>> Tensioner(spring_N_m=2e4, travel_m=0.03, force_N=2000.0, downstream_angle_rad=0.35).upstream_angle_rad
    0.0
    """

    spring_N_m: float
    travel_m: float
    force_N: float
    mass_kg: float | None = None
    damping_N_s_m: float = 0.0
    upstream_angle_rad: float = 0.0
    downstream_angle_rad: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Roller:
    """A roller and the torques that hold it back.

    Attributes
    ----------
    name : str
        Its name; the paper numbers them.
    radius_m : float
        Radius R [m].
    wrap_angle_rad : float
        Wrap α of the belt [rad], up to a full turn.
    role : {"driver", "driven", "tensioner"}
        A driver turns at the speed it is given; the others obey a torque balance, and a tensioner translates too.
    inertia_kg_m2 : float, optional
        Moment of inertia J [kg m²]; only a transient needs it.
    gravity_torque_N_m, squeeze_torque_N_m : float
        M_G of the sludge's weight, eq. (6), and M_F of squeezing it, eq. (9) [N m], positive against the rotation.
    tensioner : Tensioner, optional
        What carries a roller of the role "tensioner".
    overspeed : float, optional
        (V − v)/v [-] of a driver's surface against the speed of the press; only the closure `speed-ratio` needs it.

    Examples
    --------
    >>> Roller(name="5", radius_m=0.25, wrap_angle_rad=0.99, gravity_torque_N_m=15, squeeze_torque_N_m=84).torque_N_m
    99
    """

    name: str
    radius_m: float
    wrap_angle_rad: float
    role: Role = "driven"
    inertia_kg_m2: float | None = None
    gravity_torque_N_m: float = 0.0
    squeeze_torque_N_m: float = 0.0
    tensioner: Tensioner | None = None
    overspeed: float | None = None

    @property
    def torque_N_m(self) -> float:
        """Return the whole torque M = M_G + M_F that the belt has to overcome [N m]."""
        return self.gravity_torque_N_m + self.squeeze_torque_N_m


@dataclass(frozen=True, slots=True, kw_only=True)
class Belt:
    """A belt and the way it takes.

    Attributes
    ----------
    name : str
        Its name.
    loop : tuple of str
        Names of the rollers in the order of travel, each once; from the last one the belt returns to the first.
    linear_density_kg_m : float
        Mass per length ρA [kg/m].
    thickness_m, width_m : float
        Of its cross-section [m]. Half the thickness takes the place of a rope's radius in the size effect.
    axial_stiffness_N : float, optional
        EA [N].
    damping_s : float
        Time constant η [s] of the belt's material damping: T = EA (ε + η dε/dt).
    span_lengths_m : tuple of float, optional
        Free length [m] from each roller of `loop` to the next one, in the order of `loop`.

    Examples
    --------
    >>> Belt(name="cloth", loop=("1", "2"), linear_density_kg_m=15, thickness_m=0.005, width_m=2).damping_s
    0.0
    """

    name: str
    loop: tuple[str, ...]
    linear_density_kg_m: float
    thickness_m: float
    width_m: float
    axial_stiffness_N: float | None = None
    damping_s: float = 0.0
    span_lengths_m: tuple[float, ...] | None = None
