"""The one place where failures become words and exit codes."""

import errno
import os
import sys
import traceback
from typing import Any, Protocol, runtime_checkable

from ropefric.cli.jsontext import json_text
from ropefric.cli.output import Output
from ropefric.errors import DataError, InputError, RopefricError
from ropefric.registry import did_you_mean

INTERNAL, USAGE, INTERRUPTED = 1, 2, 130
_OUT_OF = {errno.ENOSPC, errno.EDQUOT, errno.EMFILE, errno.ENFILE}


@runtime_checkable
class UsageFailure(Protocol):
    """What typer raises for a command line it cannot use, whichever library it has it from."""

    exit_code: int

    def format_message(self) -> str:
        """Return the message for people."""
        ...


def report_failure(error: BaseException, out: Output) -> int:
    r"""Say what went wrong, as text on stderr or as the JSON error object on stdout, and return the exit code."""
    known, exit_code = _in_known_words(_interrupt_behind(error) or error)
    if out.json:
        out.result(json_text(known.to_dict()) + "\n")
    else:
        out.problems(known.problems)
    if exit_code == INTERNAL and os.environ.get("ROPEFRIC_DEBUG", "") not in {"", "0"}:
        traceback.print_exception(error, file=sys.stderr)
    return exit_code


def _interrupt_behind(error: BaseException | None) -> KeyboardInterrupt | None:
    """Return the interrupt that a library has put into its own words, such as an import that was broken off."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error


def _in_known_words(error: BaseException) -> tuple[RopefricError, int]:
    if isinstance(error, RopefricError):
        return error, error.exit_code
    if isinstance(error, KeyboardInterrupt):
        by = error.args[0] if error.args and isinstance(error.args[0], int) else INTERRUPTED - 128
        return RopefricError("interrupted", code="RF001"), 128 + by
    if isinstance(error, UsageFailure):
        return _usage_error(error), USAGE
    if isinstance(error, OSError) and (error.filename is not None or error.errno in _OUT_OF):
        refused = _file_error(error)
        return refused, refused.exit_code
    fault = RopefricError(
        f"internal fault, {type(error).__name__}: {error}",
        code="RF000",
        fix="this is a bug in ropefric, not in your data: please report it with the command you gave; "
        "ROPEFRIC_DEBUG=1 shows where it happened",
    )
    return fault, INTERNAL


def _file_error(error: OSError) -> DataError:
    """Return a file the user named and the system refuses as what it is: bad data, not a bug."""
    path = os.fsdecode(error.filename or "")
    reason = (error.strerror or str(error)).lower()
    return DataError(
        reason, code="RF101", path=path, fix="check the path, its permissions and the space left"
    )


def _usage_error(error: Any) -> InputError:
    """Return typer's complaint with the nearest thing that would have worked."""
    if isinstance(error.__cause__, InputError):  # an option's value, about which the library knows more
        return error.__cause__
    message = str(error.format_message()).strip()
    context = getattr(error, "ctx", None)
    option = getattr(error, "option_name", "")
    fix = f"see {context.command_path} --help" if context is not None else "see ropefric --help"
    if option and hasattr(error, "possibilities") and context is not None:
        known = [name for parameter in context.command.params for name in parameter.opts]
        message = str(error.message)
        fix = f"{did_you_mean(option, [*known, '--help'])} {fix}"
    elif ". Did you mean" in message:
        message, _, meant = message.partition(". D")
        fix = f"d{meant} {fix}"
    code = "RF120" if message.startswith("No such") else "RF110"
    return InputError(message[:1].lower() + message[1:], code=code, fix=fix)
