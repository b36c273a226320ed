"""The errors of the package, each with its cause, its place and its fix.

Every failure that a user can cause or meet is a `RopefricError`; each also derives from the built-in
exception a Python programmer would expect, so `except ValueError` keeps working.
"""

import errno
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from numbers import Integral, Real
from os import PathLike
from pathlib import PurePath
from traceback import walk_tb
from typing import Any, Literal, NamedTuple

_OUT_OF = {errno.ENOSPC, errno.EDQUOT, errno.EMFILE, errno.ENFILE}
_LONGEST = {"message": 2000, "key": 200, "fix": 1000}


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """One thing that is wrong or doubtful, with its place and its remedy."""

    code: str
    message: str
    path: str = ""
    line: int | None = None
    key: str = ""
    fix: str = ""
    severity: Literal["error", "warning"] = "error"

    def __post_init__(self) -> None:
        # A message quotes what stands in the file, and that may be 20 kB of brackets.
        for name, most in _LONGEST.items():
            text = getattr(self, name)
            if len(text) > most:
                object.__setattr__(self, name, f"{text[:most]}…")

    @property
    def where(self) -> str:
        """Return the place as `path:line key`, without the parts that are unknown."""
        place = self.path if self.line is None else f"{self.path}:{self.line}"
        return " ".join(part for part in (place, self.key) if part)

    def to_dict(self) -> dict[str, str]:
        """Return what programs need of it."""
        return {"code": self.code, "message": self.message, "where": self.where, "fix": self.fix}

    def __str__(self) -> str:
        head = " ".join(part for part in (self.severity, self.code, self.where) if part)
        return f"{head}  {self.message}" + (f"\n  fix: {self.fix}" if self.fix else "")


class RopefricError(Exception):
    """Base of every failure this package reports on purpose.

    Parameters
    ----------
    message : str
        The error and its cause.
    code : str
        Stable identifier, see `Problem.code`.
    path, line, key
        Where it is wrong.
    fix : str
        How to mend it.
    problems : iterable of Problem
        All problems found, when one pass found several; the message then describes the first.
    cases : array of bool, optional
        Of many cases solved in one call those that are refused; the message then describes one of them.

    Examples
    --------
    >>> error = DataError("the file is empty", code="RF101", path="run07.csv", fix="record it again")
    >>> error.to_dict()["error"]["where"]
    'run07.csv'
    """

    default_code = "RF100"
    exit_code = 3

    def __init__(
        self,
        message: str,
        *,
        code: str = "",
        path: str | PurePath = "",
        line: int | None = None,
        key: str = "",
        fix: str = "",
        problems: Iterable[Problem] = (),
        cases: Any = None,
    ) -> None:
        super().__init__(message)
        self.cases = cases
        self.problem = Problem(
            code=code or self.default_code, message=message, path=str(path), line=line, key=key, fix=fix
        )
        self.problems: tuple[Problem, ...] = tuple(problems) or (self.problem,)

    @property
    def code(self) -> str:
        """Return the stable identifier."""
        return self.problem.code

    @property
    def where(self) -> str:
        """Return the place, see `Problem.where`."""
        return self.problem.where

    @property
    def fix(self) -> str:
        """Return what to do about it."""
        return self.problem.fix

    def __str__(self) -> str:
        text = f"{self.where}: {self.problem.message}" if self.where else self.problem.message
        text = f"{text} Fix: {self.fix}" if self.fix else text
        return (
            f"{text} (the first of {len(self.problems)}, see .problems)" if len(self.problems) > 1 else text
        )

    def __reduce__(self) -> tuple[Any, ...]:
        # Keyword-only arguments do not survive the default pickling, and errors cross process borders here.
        return partial(type(self), **_place(self.problem), problems=self.problems), (self.problem.message,)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON shape `{"error": {"code", "message", "where", "fix"}}`, plus all problems found."""
        more = {"problems": [one.to_dict() for one in self.problems]} if len(self.problems) > 1 else {}
        return {"error": {**self.problem.to_dict(), **more}}


def _place(problem: Problem) -> dict[str, Any]:
    return {key: getattr(problem, key) for key in ("code", "path", "line", "key", "fix")}


class RopefricWarning(UserWarning):
    """A warning about an allowed but improbable value, such as a wrap of 400 rad; the message has the fix."""


class InputError(RopefricError, ValueError):
    """An argument has a value outside its valid range, or the wrong unit or shape."""

    default_code = "RF110"


class Kind(NamedTuple):
    """The kind of an argument: `NUMBER.check(level=level)` refuses a value of another kind by its name."""

    types: tuple[type, ...]
    words: str

    def check(self, **values: Any) -> None:
        """Refuse the first of some arguments that is of another kind; truth values are no numbers."""
        for name, value in values.items():
            if not isinstance(value, self.types) or isinstance(value, bool):
                raise InputError(f"{name} cannot be {value!r:.60}", key=name, fix=f"give {self.words}")

    def check_given(self, **values: Any) -> None:
        """Refuse likewise, of arguments that may be left out (None)."""
        self.check(**{name: value for name, value in values.items() if value is not None})


NUMBER, WHOLE_NUMBER = Kind((Real,), "a number"), Kind((Integral,), "a whole number")
TEXT, PATH = Kind((str,), "text"), Kind((str, PathLike), "a path, as text or as a Path")
CALL = Kind((Callable,), "a function")  # type: ignore[arg-type]  # abstract, and good for isinstance
BY_NAME, SEVERAL = Kind((Mapping,), "a mapping from names to values"), Kind((Iterable,), "several values")


class UnknownNameError(RopefricError, LookupError):
    """A name (law, rule, effect, key, column, unit) is not known."""

    default_code = "RF120"


class DataError(RopefricError, ValueError):
    """A file's content cannot be used."""

    default_code = "RF101"


class FitError(RopefricError, RuntimeError):
    """A fit could not be made."""

    default_code = "RF400"


class SolverError(RopefricError, RuntimeError):
    """A numerical method found no answer to the accuracy asked for."""

    default_code = "RF500"


class InternalError(RopefricError):
    """A fault of this package, not of the user's data."""

    default_code = "RF000"
    exit_code = 1


def known_error(error: BaseException, *, report_with: str, path: str = "") -> RopefricError:
    """Return any exception as an error of this package.

    A file that the system refuses is an error of the data; what nobody has foreseen is a fault of this package, to be
    reported together with `report_with`.
    """
    if isinstance(error, RopefricError):
        return error
    if isinstance(error, OSError) and (error.filename is not None or error.errno in _OUT_OF):
        reason, fix = error.strerror or str(error), "check the path, its permissions and the space left"
        return DataError(reason.lower(), path=os.fsdecode(error.filename or path), fix=fix)
    if of_plugin := plugin_error(error):
        return of_plugin
    message = f"internal fault, {type(error).__name__}: {error}"
    fix = f"this is a bug in ropefric, not in your data: please report it with {report_with}"
    return InternalError(message, path=path, fix=fix)


PLUGIN_MODULE = "ropefric_plugin_"
"""How the name of a plugin's module begins."""


def plugin_error(error: BaseException) -> DataError | None:
    """Return the failure of a plugin with its file and line; None for an exception that comes out of none."""
    frames = [
        (frame.f_code.co_filename, line)
        for frame, line in walk_tb(error.__traceback__)
        if str(frame.f_globals.get("__name__")).startswith(PLUGIN_MODULE)
    ]
    if isinstance(error, RopefricError) or not frames:
        return None
    message, fix = f"{type(error).__name__}: {error}", "`ropefric check-plugin` tries it by itself"
    path, line = frames[-1]
    return DataError(f"the plugin fails: {message}", code="RF160", path=path, line=line, fix=fix)


def raise_problems(problems: Iterable[Problem]) -> None:
    """Raise one `DataError` that carries every error among `problems`; return quietly if there is none."""
    errors = [problem for problem in problems if problem.severity == "error"]
    if errors:
        raise data_error(errors)


def data_error(problems: Sequence[Problem]) -> DataError:
    """Return one `DataError` with the first problem's message and all of them in `.problems`."""
    return DataError(problems[0].message, **_place(problems[0]), problems=problems)
