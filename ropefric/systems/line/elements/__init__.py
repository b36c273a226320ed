"""All kinds of elements by their name: a new one is a file here that declares ELEMENT, a frozen dataclass."""

from pkgutil import iter_modules

from ropefric.registry import declared_in
from ropefric.systems.line.element import Element

_FOUND: list[type[Element]] = declared_in(
    __name__, sorted(one.name for one in iter_modules(__path__)), "ELEMENT"
)

ELEMENTS: dict[str, type[Element]] = {one.kind: one for one in _FOUND}
"""Every kind of element by the name that a scene has for it."""
