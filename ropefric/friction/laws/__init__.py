"""Every friction law by name; one file declares one law."""

from ropefric.friction.law import FrictionLaw
from ropefric.friction.laws import (
    bending,
    constant,
    constant_offset,
    coupled,
    groove,
    howell,
    size_exponential,
    size_power,
    thickness,
    wrap_exponential,
    wrap_power,
)
from ropefric.registry import Registry

_IN_ORDER = (
    constant, constant_offset, size_power, size_exponential, wrap_exponential, wrap_power, coupled, thickness, bending,
    howell, groove,
)  # fmt: skip
LAWS: Registry[FrictionLaw] = Registry("friction law", [module.LAW for module in _IN_ORDER])
"""The laws that a comparison fits."""

ALL_LAWS: Registry[FrictionLaw] = Registry(
    "friction law", [*LAWS.values(), *(law.variant for law in LAWS.values() if law.variant is not None)]
)
"""The same with the forms that count the wrap from zero, for everything that looks a law up by name."""
