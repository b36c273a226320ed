"""What a simulated campaign is to hold: the law that is true, the conditions, the repeats, what goes wrong."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ropefric.errors import InputError, UnknownNameError
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import ALL_LAWS
from ropefric.registry import did_you_mean
from ropefric.rig.faults import FAULTS
from ropefric.rig.protocols import RIG_PROTOCOLS
from ropefric.rig.settings import Bench
from ropefric.traces.trace import FloatArray

__all__ = ["DEFAULT_FAULTS", "CampaignPlan", "RigCondition"]

DEFAULT_FAULTS: dict[str, float] = {fault.name: fault.rate for fault in FAULTS.values()}
"""Fraction of recordings each fault befalls in an ordinary campaign."""
_MOST_TRIALS = 100_000


@dataclass(frozen=True, slots=True, kw_only=True)
class RigCondition:
    """One condition: a wheel, a wrap, a weight.

    Attributes
    ----------
    wheel_radius_m : float
        Wheel radius R_w [m], positive.
    wrap_angle_rad : float
        Wrap angle φ [rad], positive.
    end_tension_N : float
        End tension F_B of the slack side [N], positive.

    Examples
    --------
    >>> RigCondition(wheel_radius_m=0.04, wrap_angle_rad=math.radians(540), end_tension_N=60.0).wheel
    'W40'
    """

    wheel_radius_m: float
    wrap_angle_rad: float
    end_tension_N: float

    @property
    def wheel(self) -> str:
        """Return the wheel's name: W and its radius in millimetres."""
        return f"W{1e3 * self.wheel_radius_m:.6g}".replace(".", "p")


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignPlan:
    """A campaign to simulate.

    Attributes
    ----------
    name : str
        Name of the campaign; its files say beside it that it is simulated.
    law : str
        Name of the friction law that is true, in `ALL_LAWS`.
    parameters : mapping of str to float
        Its true parameters, all of them.
    rope_diameter_m : float
        Rope diameter [m].
    rope_linear_density_kg_m : float
        Mass per length of the rope [kg/m].
    conditions : tuple of RigCondition
        What is measured.
    design : RigCondition
        The wheel whose lift force the campaign is to predict.
    unseen : tuple of RigCondition
        Further conditions that are not measured, whose true lift force goes into the truth file.
    repeats : int
        Recordings per condition, each with a new rope.
    faults : mapping of str to float
        Fraction of recordings each fault befalls.
    bench : Bench
        The rig.
    protocol : str
        A name in `RIG_PROTOCOLS`.

    Raises
    ------
    InputError
        If there is no condition or repeat, a rate is not between 0 and 1, a parameter is missing, or the law
        has no answer for a condition.
    UnknownNameError
        If law, parameter, fault or protocol is unknown.
    """

    name: str
    law: str
    parameters: Mapping[str, float]
    rope_diameter_m: float
    conditions: tuple[RigCondition, ...]
    design: RigCondition
    unseen: tuple[RigCondition, ...] = ()
    rope_linear_density_kg_m: float = 0.062
    repeats: int = 12
    faults: Mapping[str, float] = field(default_factory=lambda: dict(DEFAULT_FAULTS))
    bench: Bench = field(default_factory=Bench)
    protocol: str = "breakaway"

    def __post_init__(self) -> None:
        if not self.conditions or self.repeats < 1:
            raise InputError(
                f"{len(self.conditions)} conditions with {self.repeats} repeats make no recording",
                key="repeats",
                fix="plan at least one condition and one repeat",
            )
        if self.n_trials > _MOST_TRIALS:
            raise InputError(
                f"{len(self.conditions)} conditions with {self.repeats} repeats are {self.n_trials} recordings;"
                f" the limit is {_MOST_TRIALS}",
                key="repeats",
                fix="ask for fewer repeats",
            )
        for name, rate in self.faults.items():
            if not 0.0 <= rate <= 1.0:
                raise InputError(
                    f"fault '{FAULTS[name].name}': rate {rate:g} is not between 0 and 1", key="faults"
                )
        way = RIG_PROTOCOLS[self.protocol]
        for name, rate in self.faults.items():
            allowed = FAULTS[name].protocols
            if rate > 0.0 and allowed and way.name not in allowed:
                raise InputError(
                    f"fault '{name}' does not go with protocol '{way.name}'",
                    key="faults",
                    fix=f"leave it out; it goes with: {', '.join(allowed)}",
                )
        self.lift_force_N(self.conditions)

    @property
    def n_trials(self) -> int:
        """Return the number of recordings."""
        return len(self.conditions) * self.repeats

    def lift_force_N(self, conditions: tuple[RigCondition, ...]) -> FloatArray:
        """Return the true lift force of conditions [N], shape (n,), without scatter."""
        law = ALL_LAWS[self.law]
        names = law.parameter_names
        for name in self.parameters:
            if name not in names:
                raise UnknownNameError(
                    f"unknown parameter '{name}' of law '{law.name}'", fix=did_you_mean(name, names)
                )
        missing = [name for name in names if name not in self.parameters]
        if missing:
            raise InputError(f"law '{law.name}' needs a value for: {', '.join(missing)}", key="parameters")
        pulls = Conditions(
            wheel_radius_m=np.array([c.wheel_radius_m for c in conditions]),
            rope_radius_m=np.array(0.5 * self.rope_diameter_m),
            wrap_angle_rad=np.array([c.wrap_angle_rad for c in conditions]),
            end_tension_N=np.array([c.end_tension_N for c in conditions]),
        )
        log_lift = law.log_lift(np.array([self.parameters[name] for name in names]), pulls)
        if not float(log_lift.max()) < math.log(1e9):
            raise InputError(f"a lift force of e^{log_lift.max():.4g} N is beyond any rig", key="conditions")
        return np.exp(log_lift)
