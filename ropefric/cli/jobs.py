"""How many processes a piece of work is worth."""

import typer

SERIAL_BELOW = 20
"""Recordings below which starting worker processes costs more than it saves."""


def parse_jobs(text: str, n_items: int) -> int:
    """Return the number of processes for `n_items` recordings: what the user says, or what pays.

    No more than there are recordings and cores.
    """
    if text != "auto" and (not text.isdecimal() or len(text) > 9 or int(text) < 1):
        raise typer.BadParameter(f"{text!r} is neither 'auto' nor a number of processes", param_hint="--jobs")
    if text == "auto" and n_items < SERIAL_BELOW:
        return 1
    from ropefric.trials.workers import usable_cores  # noqa: PLC0415  (quick start-up)

    wanted = n_items if text == "auto" else int(text)
    return max(1, min(wanted, n_items, usable_cores()))
