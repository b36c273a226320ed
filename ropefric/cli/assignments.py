"""Options that set numbers by name: `--parameter mu=0.2`."""

import math
from collections.abc import Iterable

import typer


def parse_assignments(texts: Iterable[str], *, option: str) -> dict[str, float]:
    """Return `name=value` texts as a mapping."""
    values: dict[str, float] = {}
    for text in texts:
        name, equals, number = (part.strip() for part in text.partition("="))
        try:
            value = float(number)
        except ValueError:
            value = math.nan
        if not name or not equals or not math.isfinite(value):
            raise typer.BadParameter(f"{text!r} is not like mu=0.2", param_hint=option)
        if name in values:
            raise typer.BadParameter(f"{name!r} is given twice", param_hint=option)
        values[name] = value
    return values
