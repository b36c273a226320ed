"""What a command is and what it gives back: data for programs, a way to show it to people, an exit code."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ropefric.cli.output import Output

if TYPE_CHECKING:
    from rich.console import Console


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """The result of one command."""

    data: Mapping[str, Any]
    show: "Callable[[Console], None]"
    exit_code: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """One verb of the command line, declared by one file in `cli/commands/`."""

    name: str
    run: Callable[..., Answer]
    example: str
    order: int

    def answer(self, out: Output, arguments: Mapping[str, Any]) -> Answer:
        """Return what the command answers to `arguments`."""
        return self.run(out, **arguments)
