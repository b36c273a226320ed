"""What a study of accuracy is: cases, in each of them several methods at several settings, and one reference."""

from collections.abc import Callable
from dataclasses import dataclass
from math import nan

from ropefric.accuracy.measured import Measured
from ropefric.registry import Registry


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """How well one setting did; always the same, whatever the machine is busy with."""

    error: float
    evaluations: float
    bias: float = nan
    noise: float = nan


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Setting:
    """One method at one setting."""

    method: str
    setting: str
    call: Callable[[], object]
    assess: Callable[[], Outcome]
    quick: bool = True


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Case:
    """One problem with a known answer."""

    name: str
    title: str
    settings: Callable[[], tuple[Setting, ...]]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Study:
    """A numerical choice of the tool, and what each way of making it costs.

    Attributes
    ----------
    name : str
        What it is found by: "integral".
    title : str
        What is compared, in a line.
    question : str
        What a reader wants to know from it.
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
