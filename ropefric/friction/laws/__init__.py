"""Every friction law by name; one file declares one law."""

import copyreg
from typing import Any

from ropefric.friction.law import FrictionLaw
from ropefric.registry import Registry, declared_in

_IN_ORDER = (
    "constant", "constant_offset", "size_power", "size_exponential", "wrap_exponential", "wrap_power", "coupled",
    "thickness", "bending", "howell", "groove",
)  # fmt: skip
LAWS: Registry[FrictionLaw] = Registry("friction law", declared_in(__name__, _IN_ORDER, "LAW"))
"""The laws that a comparison fits."""


class _AllLaws(Registry[FrictionLaw]):
    def add(self, member: FrictionLaw) -> None:
        """Take a plugin's law in, among those that a comparison fits, too; and its variant."""
        LAWS.add(member)
        super().add(member)
        if member.variant is not None:
            super().add(member.variant)


ALL_LAWS: Registry[FrictionLaw] = _AllLaws(
    "friction law", [*LAWS.values(), *(law.variant for law in LAWS.values() if law.variant is not None)]
)
"""The same with the forms that count the wrap from zero, for everything that looks a law up by name."""


def law_named(name: str) -> FrictionLaw:
    """Return the law of a name."""
    return ALL_LAWS[name]


def _by_name(law: FrictionLaw) -> str | tuple[Any, ...]:
    """Return how a law goes to another process: by its name, for a plugin's may hold what cannot go."""
    return (law_named, (law.name,)) if ALL_LAWS.get(law.name) is law else object.__reduce_ex__(law, 4)


copyreg.pickle(FrictionLaw, _by_name)
