"""The parts a report is made of, beside sections: pictures, key facts, alerts, and what is folded away."""

from dataclasses import dataclass
from typing import Literal

from ropefric.report.section import Section


@dataclass(frozen=True, slots=True, kw_only=True)
class Alert:
    """Something to know before a result is used."""

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
    """A figure on the page."""

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
    """A whole report."""

    title: str
    lead: str
    made_by: str
    chapters: tuple[Chapter, ...]
