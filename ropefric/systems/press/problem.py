"""What is known of a belt press and its operation, for one operating point or many at once."""

from dataclasses import dataclass, field

from ropefric.errors import InputError
from ropefric.friction.condition import FloatArray
from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.machine import Press
from ropefric.systems.press.transient.integrators.integrator import Settings
from ropefric.systems.press.transient.polynomial import PiecewisePolynomial
from ropefric.systems.spread import Rule, spread

__all__ = ["PressProblem", "StartUpTask"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StartUpTask:
    """A start-up to be simulated.

    Attributes
    ----------
    speed : PiecewisePolynomial
        Surface speed of the drive over time [m/s].
    time_s : ndarray, shape (k,)
        Times at which the histories are wanted [s].
    slip : bool
        Whether rollers may slip and belts go slack.
    loads : {"with-speed", "constant"}
        Whether the load torques grow with the speed or act from the start.
    integrator : str
        A member of `INTEGRATORS`; slip needs "exact".
    settings : Settings
        Its step or tolerance.
    """

    speed: PiecewisePolynomial
    time_s: FloatArray
    slip: bool
    loads: str
    integrator: str = "exact"
    settings: Settings = field(default_factory=Settings)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PressProblem:
    """A press at n operating points; scalars are spread.

    Attributes
    ----------
    press : Press
        The machine.
    closure : str
        A member of `CLOSURES`.
    friction : WrapFriction
        Between belts and rollers.
    speed_m_s : ndarray, shape (n,)
        Belt speed v [m/s], zero or more.
    preload_N : ndarray, shape (n,), optional
        Preload of all tensioners [N]; by default each has its own.
    load_factor : ndarray, shape (n,)
        Factor on all load torques [-].
    start_up : StartUpTask, optional
        A start-up to be simulated; only for a single point.

    Raises
    ------
    InputError
        If the lengths disagree, or a number is negative or not finite.
    """

    press: Press
    closure: str
    friction: WrapFriction
    speed_m_s: FloatArray
    preload_N: FloatArray | None = None
    load_factor: FloatArray
    start_up: StartUpTask | None = None

    def __post_init__(self) -> None:
        for name, array in spread({name: getattr(self, name) for name in _RULES}, _RULES).items():
            object.__setattr__(self, name, array)
        if self.start_up is not None and self.n > 1:
            raise InputError(
                "a start-up is simulated for one operating point", fix="give one speed and preload"
            )

    @property
    def n(self) -> int:
        """Return how many operating points there are."""
        return self.speed_m_s.size


_RULES: dict[str, Rule] = {
    "speed_m_s": "zero or more",
    "preload_N": "zero or more",
    "load_factor": "zero or more",
}
