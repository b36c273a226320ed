"""Recordings counted the way people ask: how many are fine, how many need a look, how many could not be read."""

from collections import Counter
from collections.abc import Iterable

from ropefric.traces.breakaway import Status

__all__ = ["count_kinds", "kind_of"]


def kind_of(status: str) -> str:
    """Return "ok", "flagged" (read, but without a usable F_A), "failed" (not read) or "" for no status.

    Examples
    --------
    >>> kind_of("no-peak"), kind_of("unreadable"), kind_of("run_148.csv")
    ('flagged', 'failed', '')
    """
    if status not in set(Status):
        return ""
    if status == Status.OK:
        return "ok"
    return "failed" if status == Status.UNREADABLE else "flagged"


def count_kinds(statuses: Iterable[str]) -> dict[str, int]:
    """Return how many recordings are ok, flagged and failed.

    Examples
    --------
    >>> count_kinds(["ok", "ok", "saturated"])
    {'ok': 2, 'flagged': 1, 'failed': 0}
    """
    counts = Counter(kind_of(status) for status in statuses)
    return {kind: counts[kind] for kind in ("ok", "flagged", "failed")}
