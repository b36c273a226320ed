"""All kinds of scenes by the name of their system: a new one is a file here that declares KIND."""

import copyreg
from collections.abc import Iterator, Mapping
from importlib import import_module
from pkgutil import iter_modules

from ropefric.errors import UnknownNameError
from ropefric.registry import did_you_mean
from ropefric.scenes.kind import Kind

_NAMES = tuple(sorted(module.name for module in iter_modules(__path__)))


class Kinds(Mapping[str, Kind]):
    """The kinds of scenes by name, each loaded when it is first asked for: a hoist need not wait for a saw's solver."""

    def __getitem__(self, name: str) -> Kind:
        if name not in self:
            raise UnknownNameError(f"unknown system {name!r}", fix=did_you_mean(str(name), _NAMES))
        kind: Kind = import_module(f"ropefric.scenes.kinds.{name}").KIND
        return kind

    def __contains__(self, name: object) -> bool:
        return name in _NAMES

    def __iter__(self) -> Iterator[str]:
        return iter(_NAMES)

    def __len__(self) -> int:
        return len(_NAMES)


KINDS = Kinds()
# Other processes have the functions of a kind already, and find it by its name.
copyreg.pickle(Kind, lambda kind: (KINDS.__getitem__, (kind.name,)))
