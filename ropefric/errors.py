"""What can go wrong, said so that the reader can mend it: what, where, why and how to fix.

Every failure that a user can cause or meet is a `RopefricError`; each also derives from the built-in
exception a Python programmer would expect, so `except ValueError` keeps working.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any, Literal

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

    def __str__(self) -> str:
        head = " ".join(part for part in (self.severity, self.code, self.where) if part)
        lines = [f"{head}  {self.message}"]
        if self.fix:
            lines.append(f"  fix: {self.fix}")
        return "\n".join(lines)


class RopefricError(Exception):
    """Base of every failure this package reports on purpose.

    Parameters
    ----------
    message : str
        What is wrong and why.
    code : str
        Stable identifier, see `Problem.code`.
    path, line, key
        Where it is wrong.
    fix : str
        How to mend it.
    problems : iterable of Problem
        All problems found, when one pass found several; the message then describes the first.

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
    ) -> None:
        super().__init__(message)
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
        return f"{text} Fix: {self.fix}" if self.fix else text

    def __reduce__(self) -> tuple[Any, ...]:
        # Keyword-only arguments do not survive the default pickling, and errors cross process borders here.
        problem = self.problem
        place = (problem.code, problem.path, problem.line, problem.key, problem.fix)
        return _rebuild, (type(self), problem.message, place, self.problems)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON shape `{"error": {"code", "message", "where", "fix"}}`, plus all problems found."""
        error: dict[str, Any] = {
            "code": self.code,
            "message": self.problem.message,
            "where": self.where,
            "fix": self.fix,
        }
        if len(self.problems) > 1:
            error["problems"] = [
                {"code": p.code, "message": p.message, "where": p.where, "fix": p.fix} for p in self.problems
            ]
        return {"error": error}


def _rebuild(
    kind: type[RopefricError],
    message: str,
    place: tuple[str, str, int | None, str, str],
    problems: tuple[Problem, ...],
) -> RopefricError:
    code, path, line, key, fix = place
    return kind(message, code=code, path=path, line=line, key=key, fix=fix, problems=problems)


class InputError(RopefricError, ValueError):
    """An argument has a value outside its valid range, or the wrong unit or shape."""

    default_code = "RF110"


class UnknownNameError(RopefricError, LookupError):
    """A name (law, rule, effect, key, column, unit) is not known."""

    default_code = "RF120"


class DataError(RopefricError, ValueError):
    """A file's content cannot be used as it stands."""

    default_code = "RF101"


class FitError(RopefricError, RuntimeError):
    """A fit could not be made; `partial` carries what there is of the result."""

    default_code = "RF400"
    partial: Any = None


class SolverError(RopefricError, RuntimeError):
    """A numerical method found no answer to the accuracy asked for."""

    default_code = "RF500"


def raise_problems(problems: Iterable[Problem]) -> None:
    """Raise one `DataError` that carries every error among `problems`; return quietly if there is none."""
    errors = [problem for problem in problems if problem.severity == "error"]
    if errors:
        raise data_error(errors)


def data_error(problems: Sequence[Problem]) -> DataError:
    """Return one `DataError` with the first problem's message and all of them in `.problems`."""
    first = problems[0]
    return DataError(
        first.message,
        code=first.code,
        path=first.path,
        line=first.line,
        key=first.key,
        fix=first.fix,
        problems=problems,
    )
