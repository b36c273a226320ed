"""All kinds of scenes, found by the name of their system; a new one is a file and its line here."""

from ropefric.registry import Registry
from ropefric.scenes.kind import Kind
from ropefric.scenes.kinds import bandsaw, hoist, press

__all__ = ["KINDS"]

KINDS: Registry[Kind] = Registry("system", (hoist.KIND, press.KIND, bandsaw.KIND))
"""In the order of the handbook."""
