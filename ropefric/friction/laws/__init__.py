"""Every friction law by name, and its declaration: all that the tool says of it.

`uniform` has those whose coefficient is the same all along the wrap, `wrap` those whose local one falls with it,
`bending` a stiff rope, `howell` friction as a power of the contact force. A law of one's own is one more file.
"""

import copyreg
from typing import Any

from ropefric.friction.law import FrictionLaw
from ropefric.friction.laws import bending, howell, uniform, wrap
from ropefric.registry import Registry

LAWS: Registry[FrictionLaw] = Registry(
    "friction law",
    [
        *(uniform.CONSTANT, uniform.CONSTANT_OFFSET, uniform.SIZE_POWER, uniform.SIZE_EXPONENTIAL),
        *(wrap.WRAP_AVERAGE, wrap.WRAP_EXPONENTIAL, wrap.WRAP_POWER, wrap.COUPLED),
        *(uniform.THICKNESS, bending.LAW, howell.LAW, uniform.GROOVE),
    ],
)
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
