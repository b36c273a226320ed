"""What a start-up model is made of: each can be left out, and is then never computed."""

from dataclasses import dataclass

__all__ = ["Ingredients"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Ingredients:
    """Which effects a start-up contains beside the elastic belts and the turning rollers.

    Attributes
    ----------
    arc_inertia : bool
        The mass of the belts on the rollers, ρA R³ α for each; slip needs it, as a slipping belt moves by itself.
    belt_damping : bool
        The belts' time constant η.
    tensioner_damping : bool
        The tensioners' C1.
    centrifugal : bool
        ρAv² in the tensioners' balance, with v the prescribed speed of the drive at each moment.

    Examples
    --------
    >>> Ingredients(belt_damping=False).arc_inertia
    True
    """

    arc_inertia: bool = True
    belt_damping: bool = True
    tensioner_damping: bool = True
    centrifugal: bool = True
