"""What a start-up model is made of: each can be left out, and is then never computed."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Ingredients:
    """Which effects a start-up contains beside the elastic belts and the turning rollers."""

    arc_inertia: bool = True
    belt_damping: bool = True
    tensioner_damping: bool = True
    centrifugal: bool = True
