"""Named collections of declared objects: one file declares one object, and everyone else finds it by name."""

from collections.abc import Iterable, Iterator, Mapping
from difflib import get_close_matches
from importlib import import_module
from typing import Any, Protocol, TypeVar

from ropefric.errors import InputError, UnknownNameError


class Named(Protocol):
    """Anything with a name of its own."""

    @property
    def name(self) -> str:
        """The name it is found by."""
        ...


T = TypeVar("T", bound=Named)
_ADDED: list[tuple[dict[str, Any], str]] = []


def count_added() -> int:
    """Return how many members plugins have added to registries."""
    return len(_ADDED)


def forget_added(after: int = 0) -> None:
    """Take the members that plugins added out of their registries again, but for the first few."""
    while len(_ADDED) > after:
        members, name = _ADDED.pop()
        del members[name]


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return `did you mean 'x'?` for the known word closest to `word`, or the list of known words."""
    names = sorted(known)
    folded = {name.lower(): name for name in names}
    close = get_close_matches(str(word).lower(), folded, n=1, cutoff=0.6)
    if close:
        return f"did you mean '{folded[close[0]]}'?"
    return f"known: {', '.join(names)}" if names else "none is known"


def declared_in(package: str, modules: Iterable[str], name: str) -> list[Any]:
    """Return what each module of a package declares under one name: `LAW`, `READER`."""
    return [getattr(import_module(f"{package}.{module}"), name) for module in modules]


class Registry(Mapping[str, T]):
    """An ordered mapping from name to declared object, whose misses say what was meant; plugins may add to it.

    Parameters
    ----------
    kind : str
        What the objects are, in words, for messages: "outlier rule".
    members : iterable
        The objects; each has a `name`.

    Raises
    ------
    ValueError
        If two members have the same name.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> rules = Registry("outlier rule", [SimpleNamespace(name="two-sigma"), SimpleNamespace(name="none")])
    >>> list(rules)
    ['two-sigma', 'none']
    >>> rules["two-sgima"]
    Traceback (most recent call last):
    ...
    ropefric.errors.UnknownNameError: unknown outlier rule 'two-sgima' Fix: did you mean 'two-sigma'?
    """

    def __init__(self, kind: str, members: Iterable[T]) -> None:
        self.kind = kind
        self._members: dict[str, T] = {}
        for member in members:
            if member.name in self._members:
                raise ValueError(f"two members of the {kind} registry are called {member.name!r}")
            self._members[member.name] = member

    def __getitem__(self, name: str) -> T:
        try:
            return self._members[name]
        except KeyError:
            fix = did_you_mean(str(name), self._members)
            raise UnknownNameError(f"unknown {self.kind} {name!r}", fix=fix) from None

    def get(self, name: str, default: Any = None) -> Any:
        """Return a member, or `default`: a mapping that is asked gently does not raise."""
        return self[name] if name in self else default  # noqa: SIM401  (that would be itself)

    def add(self, member: T) -> None:
        """Take a plugin's member in until `forget_added`; refuse a name that is taken."""
        if member.name in self:
            text = f"there is a {self.kind} {member.name!r} already"
            raise InputError(text, code="RF162", key="name", fix="give it a name of its own")
        self._members[member.name] = member
        _ADDED.append((self._members, member.name))

    def __contains__(self, name: object) -> bool:
        return name in self._members

    def __iter__(self) -> Iterator[str]:
        return iter(self._members)

    def __len__(self) -> int:
        return len(self._members)
