"""Options that set bounds by name: `--bound d=0:0.2`."""

import math
from collections.abc import Iterable

import typer


def parse_spans(texts: Iterable[str], *, option: str) -> dict[str, tuple[float, float]]:
    """Return `name=low:high` texts as a mapping."""
    spans: dict[str, tuple[float, float]] = {}
    for text in texts:
        name, equals, ends = (part.strip() for part in text.partition("="))
        try:
            low, high = (float(end) for end in ends.split(":"))
        except ValueError:
            low = high = math.nan
        if not name or not equals or not (math.isfinite(low) and math.isfinite(high) and low < high):
            raise typer.BadParameter(f"{text!r} is not like d=0:0.2", param_hint=option)
        if name in spans:
            raise typer.BadParameter(f"{name!r} is given twice", param_hint=option)
        spans[name] = (low, high)
    return spans
