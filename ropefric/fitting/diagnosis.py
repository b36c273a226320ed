"""What a diagnosis hands on: each possible cause with its verdict, its evidence and the test that would decide."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from ropefric.fitting.judgement import Verdict

Supported = Literal["yes", "no", "cannot-tell"]

_WORDS = {"yes": "supported", "no": "not supported", "cannot-tell": "cannot be told"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Cause:
    """A reason why a rope may not obey the capstan equation."""

    cause: str
    supported: Supported
    evidence: str
    experiment: str
    numbers: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnosis:
    """Why a rope does not obey the capstan equation, or that it does.

    Attributes
    ----------
    causes : tuple of Cause
        All that were looked at.
    summary : str
        The answer in one sentence.
    verdict : Verdict
        On the best law of the comparison behind it.
    """

    causes: tuple[Cause, ...]
    summary: str
    verdict: Verdict

    def __getitem__(self, cause: str) -> Cause:
        return {item.cause: item for item in self.causes}[cause]

    @property
    def text(self) -> str:
        """Return the diagnosis as lines for people."""
        lines = [self.summary, f"the best law is {self.verdict.word}: {self.verdict.reason}"]
        for item in self.causes:
            lines += [
                f"{item.cause}: {_WORDS[item.supported]}",
                f"  {item.evidence}",
                f"  to decide: {item.experiment}",
            ]
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Return a JSON tree."""
        return {
            "summary": self.summary,
            "verdict": self.verdict.to_dict(),
            "causes": [
                {
                    "cause": item.cause,
                    "supported": item.supported,
                    "evidence": item.evidence,
                    "experiment": item.experiment,
                    "numbers": dict(item.numbers),
                }
                for item in self.causes
            ],
        }
