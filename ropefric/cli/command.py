"""What a command is and what it gives back: data for programs, a way to show it to people, an exit code."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ropefric.cli.output import Output

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["Answer", "Command"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """The result of one command.

    Attributes
    ----------
    data : mapping
        What `--json` prints: plain containers, strings and numbers.
    show : callable
        Prints the same for people on the console it is given.
    exit_code : int
        0 done, 3 bad data or configuration, 4 not supported.

    Examples
    --------
    >>> Answer(data={"n": 12}, show=lambda console: console.print("12 trials")).exit_code
    0
    """

    data: Mapping[str, Any]
    show: "Callable[[Console], None]"
    exit_code: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """One verb of the command line, declared by one file in `cli/commands/`.

    Attributes
    ----------
    name : str
        The verb.
    run : callable
        Takes an `Output` first, then what typer is to read from the command line, annotated; its docstring is
        the help. It imports the library inside, so that `--help` stays quick.
    example : str
        A command line that works, shown under the help.
    order : int
        Where it stands in the list of commands: the order of work.

    Examples
    --------
    >>> def run(out):
    ...     "Say nothing."
    ...     return Answer(data={}, show=lambda console: None)
    >>> Command(name="nothing", run=run, example="ropefric nothing", order=99).name
    'nothing'
    """

    name: str
    run: Callable[..., Answer]
    example: str
    order: int

    def answer(self, out: Output, arguments: Mapping[str, Any]) -> Answer:
        """Return what the command answers to `arguments`."""
        return self.run(out, **arguments)
