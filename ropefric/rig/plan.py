"""What a simulated campaign is to hold: the law that is true, the conditions, the repeats, what goes wrong."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, UnknownNameError
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import ALL_LAWS
from ropefric.registry import did_you_mean
from ropefric.rig.faults import FAULTS
from ropefric.rig.protocols import RIG_PROTOCOLS
from ropefric.rig.settings import Bench

DEFAULT_FAULTS: dict[str, float] = {fault.name: fault.rate for fault in FAULTS.values()}
"""Fraction of recordings each fault befalls in an ordinary campaign."""
_MOST_TRIALS = 100_000


@dataclass(frozen=True, slots=True, kw_only=True)
class RigCondition:
    """One condition: a wheel, a wrap, a weight."""

    wheel_radius_m: float
    wrap_angle_rad: float
    end_tension_N: float

    @property
    def wheel(self) -> str:
        """Return the wheel's name: W and its radius in millimetres."""
        return f"W{1e3 * self.wheel_radius_m:.6g}".replace(".", "p")


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignPlan:
    """A campaign to simulate."""

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
