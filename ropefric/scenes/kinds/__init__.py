"""All kinds of scenes by the name of their system: a new one is a file here that declares KIND."""

import copyreg
from importlib import import_module
from pkgutil import iter_modules

from ropefric.registry import Registry
from ropefric.scenes.kind import Kind


class Kinds(Registry[Kind]):
    """The kinds of scenes by name, each loaded when it is first asked for: a hoist need not wait for a saw's solver."""

    def __init__(self) -> None:
        super().__init__("system", ())
        self._members = dict.fromkeys(sorted(module.name for module in iter_modules(__path__)))  # type: ignore[assignment]

    def __getitem__(self, name: str) -> Kind:
        if name in self and self._members[name] is None:
            self._members[name] = import_module(f"{__name__}.{name}").KIND
        return super().__getitem__(name)


KINDS = Kinds()


def kind_named(name: str) -> Kind:
    """Return a kind by its name: how another process, which has its functions already, comes by it."""
    return KINDS[name]


copyreg.pickle(Kind, lambda kind: (kind_named, (kind.name,)))
