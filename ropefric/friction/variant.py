"""The second face of a wrap-dependent law: without the equivalence of end tension and wrap."""

from dataclasses import replace

from ropefric.friction.exponential_wrap import ExponentialWrap
from ropefric.friction.law import FrictionLaw
from ropefric.friction.power_wrap import PowerWrap

SUFFIX = "-from-zero"
"""What the name of a law ends in when its wrap is counted from zero, whatever the end tension."""


def with_variant(law: FrictionLaw) -> FrictionLaw:
    """Return a wrap-dependent law that knows its own form without the end tension."""
    physics = law.physics
    if not isinstance(physics, PowerWrap | ExponentialWrap):
        raise TypeError(f"{law.name} does not depend on the wrap through PowerWrap or ExponentialWrap")
    variant = replace(
        law,
        name=law.name + SUFFIX,
        equation=law.equation.replace("from phi0 to phi0 + phi", "from 0 to phi"),
        effects=law.effects - {"end-tension"},
        physics=replace(physics, equivalence=False),
    )
    return replace(law, variant=variant)
