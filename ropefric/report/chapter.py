"""The parts a report is made of, beside sections: pictures, key facts, alerts, and what is folded away."""

from dataclasses import dataclass
from typing import Literal

from ropefric.report.section import Section

__all__ = ["Alert", "Block", "Chapter", "Fact", "Fold", "Picture", "Report"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Alert:
    """Something to know before a result is used.

    Attributes
    ----------
    grade : {"stop", "doubt", "note"}
        Whether the result must not be used, may be wrong, or is merely to be read with this in mind.
    title : str
        What, in a few words.
    text : str
        What exactly, and what to do.
    """

    grade: Literal["stop", "doubt", "note"]
    title: str
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Fact:
    """A key number: what it is, its value, and what belongs to it."""

    name: str
    value: str
    remark: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A figure on the page.

    Attributes
    ----------
    stem : str
        Its name, unique on the page.
    svg : str
        The `<svg>` element.
    caption : str
        What is to be seen.
    files : tuple of str
        The CSV files of its numbers, relative to the page.
    """

    stem: str
    svg: str
    caption: str
    files: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Fold:
    """Parts that are shown on demand, and not printed."""

    title: str
    sections: tuple[Section, ...]


Block = Section | Picture | Fold | tuple[Fact, ...] | tuple[Alert, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Chapter:
    """A heading with blocks under it; `key` is its anchor."""

    key: str
    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """A whole report.

    Attributes
    ----------
    title, lead : str
        Its heading, and one sentence that says what it is about.
    made_by : str
        Program and version.
    chapters : tuple of Chapter
        In the order they are read.
    """

    title: str
    lead: str
    made_by: str
    chapters: tuple[Chapter, ...]
