"""Parts of an accuracy study: cases, methods at several settings, one reference, and measured points."""

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from math import isfinite, nan
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.registry import Registry

ACCURACIES = tuple(10.0**-n for n in range(2, 13))
"""The relative accuracies a page answers for, 1e-2 … 1e-12."""

ROUNDING = 2.0**-53
"""Errors below half a unit in the last place are luck, and all the same."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """How well one setting did; always the same, whatever the machine is busy with."""

    error: float
    evaluations: float
    bias: float = nan
    noise: float = nan
    shares: Mapping[str, float] = field(default_factory=dict, hash=False)
    kinds: Mapping[str, float] = field(default_factory=dict, hash=False)


class Setting(NamedTuple):
    """One method at one setting."""

    method: str
    setting: str
    call: Callable[[], object]
    assess: Callable[[], Outcome]
    quick: bool = True


class Case(NamedTuple):
    """One problem with a known answer."""

    name: str
    title: str
    settings: Callable[[], tuple[Setting, ...]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured(Outcome):
    """Error and time of one setting; without a time where none was taken."""

    case: str
    method: str
    setting: str
    seconds: float = nan
    lower_s: float = nan
    upper_s: float = nan
    repeats: int = 0
    loops: int = 0

    @property
    def spread_s(self) -> float:
        """Return the range between the quartiles [s]."""
        return self.upper_s - self.lower_s

    @property
    def name(self) -> str:
        """Return method and setting in one."""
        return f"{self.method}, {self.setting}" if self.setting else self.method

    @property
    def shown_error(self) -> float:
        """Return the error, not below rounding."""
        return max(self.error, ROUNDING)

    def to_dict(self) -> dict[str, Any]:
        """Return the point as plain data, None where there is no number."""
        tree = asdict(self) | {"spread_s": self.spread_s}
        tree |= tree.pop("shares")
        if not tree["kinds"]:
            del tree["kinds"]
        return {k: None if isinstance(v, float) and not isfinite(v) else v for k, v in tree.items()}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Study:
    """A numerical choice of the tool, and what each way of making it costs.

    Attributes
    ----------
    name : str
        The name of the study: "integral".
    title : str
        The comparison in one line.
    question : str
        The question that it answers.
    reference : str
        Where the true answer comes from, independent of all methods compared.
    counted : str
        What `Outcome.evaluations` counts.
    cases : tuple of Case
        The first is the ordinary one.
    used : str
        What the tool itself does, in a few words.
    findings : callable
        Returns sentences that are particular to this study from what was measured.

    Examples
    --------
    >>> study = Study(name="s", title="", question="", reference="", counted="", cases=())
    >>> study.findings(())
    ()
    """

    name: str
    title: str
    question: str
    reference: str
    counted: str
    cases: tuple[Case, ...]
    used: str = ""
    findings: Callable[[tuple[Measured, ...]], tuple[str, ...]] = lambda _points: ()

    def case(self, name: str = "") -> Case:
        """Return a case by name, the first without one.

        Raises
        ------
        UnknownNameError
            If the study has no such case.
        """
        return Registry(f"case of {self.name}", self.cases)[name or self.cases[0].name]


class Counted:
    """A function that counts its calls, and the points it was called with."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        self.calls = 0
        self.points = 0

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Return what the function returns."""
        self.calls += 1
        self.points += np.size(args[0]) if args else 1
        return self._function(*args, **kwargs)


def largest_error(answer: npt.ArrayLike, reference: npt.ArrayLike) -> float:
    """Return the largest relative error; infinite where one answer is no number."""
    exact = np.asarray(reference, dtype=np.float64)
    with np.errstate(invalid="ignore", over="ignore"):
        errors = np.abs((np.asarray(answer, dtype=np.float64) - exact) / exact)
    return float(errors.max()) if np.isfinite(errors).all() else float("inf")


def against(
    reference: Any,
    method: str,
    label: str,
    solve: Callable[..., Any],
    *functions: Callable[..., Any],
    over: Sequence[float] = (),
    work: float | str | Callable[..., float] = "points",
    quick: Container[float] | bool | None = None,
    error: Callable[[Any, Any], float] = largest_error,
) -> tuple[Setting, ...]:
    """Return a method at the settings `over`, named after a label such as "{} steps"; without a label, its only one.

    `solve(*functions)`, or `solve(setting, *functions)`, answers a problem that is given by functions. Its work is how
    often they are called, or at how many points; or a number; or from the answer and the setting. Calls are counted
    only while the error is assessed, not while it is timed. A quick look takes those settings that are in `quick`, by
    default every third.
    """

    def made(place: int, given: tuple[float, ...]) -> Setting:
        def assess() -> Outcome:
            counted = [Counted(function) for function in functions]
            answer = solve(*given, *counted)
            done = work(answer, *given) if callable(work) else work
            if isinstance(done, str):
                done = sum(getattr(one, done) for one in counted)
            return Outcome(error=float(error(answer, reference)), evaluations=float(done))

        taken = place % 3 == 0 if quick is None else quick if isinstance(quick, bool) else given[0] in quick
        return Setting(method, label.format(*given), partial(solve, *given, *functions), assess, taken)

    return tuple(made(place, (one,)) for place, one in enumerate(over)) if over or label else (made(0, ()),)


def over_seeds(errors: Sequence[float] | FloatArray, evaluations: float) -> Outcome:
    """Return the outcome of repetitions: root mean square, mean and standard deviation of their relative errors."""
    found = np.asarray(errors, dtype=np.float64)
    if not (found.size and np.isfinite(found).all()):
        return Outcome(error=float("inf"), evaluations=evaluations)
    return Outcome(
        error=float(np.sqrt(np.mean(found**2))),
        evaluations=evaluations,
        bias=float(found.mean()),
        noise=float(found.std(ddof=1)) if found.size > 1 else 0.0,
    )


def in_case(points: Iterable[Measured], case: str) -> tuple[Measured, ...]:
    """Return the points of one case."""
    return tuple(point for point in points if point.case == case)


def by_case(points: Sequence[Measured]) -> dict[str, tuple[Measured, ...]]:
    """Return the points of each case that has any."""
    return {case: in_case(points, case) for case in dict.fromkeys(point.case for point in points)}


def pareto_front(points: Iterable[Measured]) -> tuple[Measured, ...]:
    """Return the points that no other point beats in both error and time, fastest first."""
    front: list[Measured] = []
    for point in sorted(points, key=lambda point: (point.seconds, point.shown_error)):
        if isfinite(point.error) and (not front or point.shown_error < front[-1].shown_error):
            front.append(point)
    return tuple(front)


def cheapest(points: Iterable[Measured], accuracy: float) -> Measured | None:
    """Return the fastest point with an error of at most `accuracy`; None if there is none."""
    good = (point for point in points if point.error <= accuracy)
    return min(good, key=lambda point: point.seconds, default=None)


def time_text(seconds: float) -> str:
    """Return a time with the unit that suits it; a dash where there is none."""
    if not isfinite(seconds):
        return "–"
    units = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"))
    size, unit = next((one for one in units if seconds >= 0.9995 * one[0]), (1e-9, "ns"))
    return f"{seconds / size:.{2 if seconds < 99.5 * size else 3}g} {unit}"


_UNSTEADY = 0.5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StudyResult:
    """The measurements of one study."""

    study: Study
    points: tuple[Measured, ...]
    quick: bool

    def front(self, case: str) -> tuple[Measured, ...]:
        """Return the points of a case that no other beats in both error and time, fastest first."""
        return pareto_front(in_case(self.points, case))

    def cheapest(self, case: str) -> tuple[tuple[float, Measured | None], ...]:
        """Return, for each accuracy 1e-2 … 1e-12, the fastest point that reaches it."""
        points = in_case(self.points, case)
        return tuple((accuracy, cheapest(points, accuracy)) for accuracy in ACCURACIES)

    @property
    def findings(self) -> tuple[str, ...]:
        """Return what the measurement says, in sentences."""
        return self.study.findings(self.points)

    @property
    def unsteady(self) -> float:
        """Return the share of points whose times spread by more than half their median: other work was going on."""
        spreads = [point.spread_s > _UNSTEADY * point.seconds for point in self.points]
        return float(np.mean(spreads or [False]))

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain data."""
        return {
            **{key: getattr(self.study, key) for key in ("name", "title", "reference", "counted")},
            "points": [point.to_dict() for point in self.points],
            "cheapest": {
                case.name: [
                    {"accuracy": accuracy}
                    | {key: getattr(point, key, None) for key in ("method", "setting", "seconds")}
                    for accuracy, point in self.cheapest(case.name)
                ]
                for case in self.study.cases
            },
            "findings": list(self.findings),
            "unsteady": self.unsteady,
        }
