"""What a study of accuracy is: cases, in each of them several methods at several settings, and one reference."""

from collections.abc import Callable
from dataclasses import dataclass
from math import nan

from ropefric.accuracy.measured import Measured
from ropefric.registry import Registry

__all__ = ["Case", "Outcome", "Setting", "Study"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """How well one setting did; always the same, whatever the machine is busy with.

    Attributes
    ----------
    error : float
        Relative error against the reference of the case [-]; infinite where the method has no answer.
    evaluations : float
        How much work it was, in the unit of the study; a mean where it differs from one repetition to another.
    bias, noise : float
        Mean and standard deviation of the relative error over the repetitions of a statistical study [-]; NaN in
        the others.

    Examples
    --------
    >>> Outcome(error=1e-6, evaluations=12.0).bias
    nan
    """

    error: float
    evaluations: float
    bias: float = nan
    noise: float = nan


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Setting:
    """One method at one setting.

    Attributes
    ----------
    method : str
        The method: "gauss-legendre".
    setting : str
        How it is set: "8 points"; "" for a method with nothing to set.
    call : callable
        Computes the answer once; this is what is timed.
    assess : callable
        Returns the `Outcome`, counting the evaluations on the way; this is never timed.
    quick : bool
        Whether it is also measured when time is short.
    """

    method: str
    setting: str
    call: Callable[[], object]
    assess: Callable[[], Outcome]
    quick: bool = True


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Case:
    """One problem with a known answer.

    Attributes
    ----------
    name : str
        What it is found by: "regular".
    title : str
        What it is, with its numbers and units.
    settings : callable
        Returns the settings compared on it; the work of preparing them is done only then.
    """

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
