"""Where a belt lies on a roller: the two tensions beside it, and which of them is the slack one."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError
from ropefric.systems.press.equations import spans_into, spans_out_of
from ropefric.systems.press.machine import Press
from ropefric.systems.press.steady import SteadyState

__all__ = ["Contact", "contacts_of", "steady_contacts"]

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Contact:
    """A roller with what its belts do to it, at any number of operating points.

    Attributes
    ----------
    roller : str
        Its name.
    radius_m, wrap_angle_rad : float
        R [m] and α [rad].
    half_thickness_m : float
        Half the thickness of a belt [m], the mean where several lie on each other.
    upstream_N, downstream_N : ndarray, shape (...)
        T − ρAR²θ̇² before and behind the roller, all its belts together [N].
    inertia_N : ndarray, shape (...), or 0.0
        ρAR²θ̈ of all its belts [N]: what a radian of them needs to be accelerated.

    Examples
    --------
    >>> contact = Contact(roller="2", radius_m=0.075, wrap_angle_rad=0.5, half_thickness_m=0.0025,
    ...     upstream_N=np.array([800.0, 800.0]), downstream_N=np.array([900.0, 700.0]))
    >>> contact.friction_pull_N.tolist(), contact.slack_N.tolist()
    ([100.0, -100.0], [800.0, 700.0])
    """

    roller: str
    radius_m: float
    wrap_angle_rad: float
    half_thickness_m: float
    upstream_N: FloatArray
    downstream_N: FloatArray
    inertia_N: FloatArray | float = 0.0

    def flat_part(self, shape: tuple[int, ...], block: slice) -> "Contact":
        """Return a block of the operating points, spread to a shape and counted through its axes in C order."""
        inertia: FloatArray | float = 0.0
        if self.is_accelerated:
            inertia = np.broadcast_to(self.inertia_N, shape).reshape(-1)[block]
        return replace(
            self,
            upstream_N=np.broadcast_to(self.upstream_N, shape).reshape(-1)[block],
            downstream_N=np.broadcast_to(self.downstream_N, shape).reshape(-1)[block],
            inertia_N=inertia,
        )

    @property
    def is_accelerated(self) -> bool:
        """Return whether the belt on the roller gains or loses speed anywhere."""
        return bool(np.any(self.inertia_N))

    @property
    def friction_pull_N(self) -> FloatArray:
        """Return what the roller holds the belt back with, shape (...) [N]; negative where it drives the belt.

        It is the belt's T_out − T_in less what its own mass on the arc takes, from dT/dφ = ρAR²θ̈ − F.
        """
        pull_N = self.downstream_N - self.upstream_N
        return pull_N - self.inertia_N * self.wrap_angle_rad if self.is_accelerated else pull_N

    @property
    def slack_N(self) -> FloatArray:
        """Return T − ρAR²θ̇² on the side that friction pulls less, shape (...) [N]."""
        if self.is_accelerated:
            return np.where(self.friction_pull_N >= 0.0, self.upstream_N, self.downstream_N)
        return np.minimum(self.upstream_N, self.downstream_N)

    @property
    def tight_N(self) -> FloatArray:
        """Return T − ρAR²θ̇² on the other side, shape (...) [N]."""
        if self.is_accelerated:
            return np.where(self.friction_pull_N >= 0.0, self.downstream_N, self.upstream_N)
        return np.maximum(self.upstream_N, self.downstream_N)

    @property
    def inertia_towards_tight_N(self) -> FloatArray | float:
        """Return ρAR²θ̈, counted positive where it adds to the tension from the slack side on [N]."""
        if not self.is_accelerated:
            return 0.0
        return np.where(self.friction_pull_N >= 0.0, self.inertia_N, -np.asarray(self.inertia_N))


def contacts_of(
    press: Press,
    tension_N: npt.ArrayLike,
    *,
    rim_speed_m_s: npt.ArrayLike = 0.0,
    angular_acceleration_rad_s2: npt.ArrayLike = 0.0,
) -> tuple[Contact, ...]:
    """Return the contact of every roller, from tensions that need not be steady.

    Parameters
    ----------
    press : Press
        The machine.
    tension_N : array_like, shape (..., n_spans)
        T of every span [N], the sum over its belts.
    rim_speed_m_s : array_like, broadcastable to shape (..., n_rollers)
        R θ̇ [m/s]; zero where the tensions are T' already.
    angular_acceleration_rad_s2 : array_like, broadcastable to shape (..., n_rollers)
        θ̈ [rad/s²], positive in the direction of travel.

    Raises
    ------
    InputError
        If the last axis of the tensions is not that of the spans, or a number is not finite.

    Examples
    --------
    >>> from ropefric.systems.press.machine import Belt, Roller, Tensioner
    >>> drive = Roller(name="drive", radius_m=0.1, wrap_angle_rad=3.0, role="driver")
    >>> load = Roller(name="load", radius_m=0.1, wrap_angle_rad=3.0, role="tensioner",
    ...     tensioner=Tensioner(spring_N_m=0.0, travel_m=0.0, force_N=1000.0))
    >>> belt = Belt(name="belt", loop=("drive", "load"), linear_density_kg_m=1, thickness_m=0.005, width_m=1)
    >>> press = Press(rollers=(drive, load), belts=(belt,), speed_m_s=2.0)
    >>> [float(contact.upstream_N) for contact in contacts_of(press, [475.0, 525.0], rim_speed_m_s=2.0)]
    [521.0, 471.0]
    """
    tension = np.asarray(tension_N, dtype=np.float64)
    if tension.ndim == 0 or tension.shape[-1] != len(press.spans):
        raise InputError(
            f"tensions of shape {tension.shape} for {len(press.spans)} spans",
            key="tension_N",
            fix="let the last axis be that of the spans",
        )
    speed, acceleration = (
        np.asarray(value, dtype=np.float64) for value in (rim_speed_m_s, angular_acceleration_rad_s2)
    )
    for name, array in (("tension_N", tension), ("rim_speed_m_s", speed), ("θ̈", acceleration)):
        if not _all_finite(array):
            raise InputError(f"{name} must be finite", key=name)
    by_roller = np.broadcast_to(speed, np.broadcast_shapes(speed.shape, (len(press.rollers),)))
    spin = np.broadcast_to(acceleration, np.broadcast_shapes(acceleration.shape, (len(press.rollers),)))
    into, out_of = spans_into(press), spans_out_of(press)
    contacts = []
    for i, roller in enumerate(press.rollers):
        belts = [belt for belt in press.belts if roller.name in belt.loop]
        density_kg_m = sum(belt.linear_density_kg_m for belt in belts)
        circling_N = density_kg_m * by_roller[..., i] ** 2 if speed.any() else 0.0
        contacts.append(
            Contact(
                roller=roller.name,
                radius_m=roller.radius_m,
                wrap_angle_rad=roller.wrap_angle_rad,
                half_thickness_m=0.5 * sum(belt.thickness_m for belt in belts) / len(belts),
                upstream_N=_sum_of(tension, into[i]) - circling_N,
                downstream_N=_sum_of(tension, out_of[i]) - circling_N,
                inertia_N=density_kg_m * roller.radius_m**2 * spin[..., i] if spin.any() else 0.0,
            )
        )
    return tuple(contacts)


def steady_contacts(
    state: SteadyState, *, angular_acceleration_rad_s2: npt.ArrayLike = 0.0
) -> tuple[Contact, ...]:
    """Return the contact of every roller in a steady run.

    Parameters
    ----------
    state : SteadyState
        The run.
    angular_acceleration_rad_s2 : array_like, broadcastable to shape (..., n_rollers)
        θ̈ to be borne at these tensions [rad/s²].

    Examples
    --------
    See `ropefric.systems.press.slip.slip_table`.
    """
    return contacts_of(
        state.press, state.effective_tension_N, angular_acceleration_rad_s2=angular_acceleration_rad_s2
    )


def _all_finite(array: FloatArray) -> bool:
    # A sum needs no array of its own, which sweeps feel; only where it is not finite the numbers are looked at.
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(array.sum()) or np.isfinite(array).all())


def _sum_of(tension: FloatArray, chosen: FloatArray) -> FloatArray:
    """Return the sum of the chosen spans; of one span a view, which sweeps of a million points feel."""
    first, *others = np.flatnonzero(chosen)
    total = tension[..., first]
    for other in others:
        total = total + tension[..., other]
    return total
