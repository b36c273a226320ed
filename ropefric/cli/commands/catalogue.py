"""Every command there is: the files of this folder that declare a `COMMAND`."""

import importlib
import pkgutil
from functools import cache

from ropefric.cli import commands
from ropefric.cli.command import Command
from ropefric.registry import Registry


@cache
def find_commands() -> Registry[Command]:
    """Return all commands by name, in the order of work.

    Examples
    --------
    >>> "check" in find_commands()
    True
    """
    names = [module.name for module in pkgutil.iter_modules(commands.__path__)]
    modules = [importlib.import_module(f"{commands.__name__}.{name}") for name in sorted(names)]
    found = [module.COMMAND for module in modules if hasattr(module, "COMMAND")]
    return Registry("command", sorted(found, key=lambda command: (command.order, command.name)))
