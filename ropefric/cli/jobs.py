"""How many processes a piece of work is worth."""

import os

import typer

__all__ = ["SERIAL_BELOW", "parse_jobs"]

SERIAL_BELOW = 20
"""Recordings below which starting worker processes costs more than it saves."""


def parse_jobs(text: str, n_items: int) -> int:
    """Return the number of processes for `n_items` recordings: what the user says, or what pays.

    Parameters
    ----------
    text : str
        "auto" or a positive integer.
    n_items : int
        How many recordings there are.

    Raises
    ------
    typer.BadParameter
        For anything else.

    Examples
    --------
    >>> parse_jobs("auto", 12), parse_jobs("3", 12)
    (1, 3)
    """
    if text == "auto":
        return 1 if n_items < SERIAL_BELOW else max(1, _usable_cores())
    if not text.isdecimal() or len(text) > 9 or int(text) < 1:
        raise typer.BadParameter(f"{text!r} is neither 'auto' nor a number of processes", param_hint="--jobs")
    return int(text)


def _usable_cores() -> int:
    if hasattr(os, "sched_getaffinity"):  # a container may own fewer cores than the machine has
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
