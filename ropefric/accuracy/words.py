"""Times and errors in words."""

from math import isfinite

_UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"))


def time_text(seconds: float) -> str:
    """Return a time with the unit that suits it; a dash where there is none."""
    if not isfinite(seconds):
        return "–"
    for size, unit in _UNITS:
        if seconds >= 0.9995 * size or unit == "ns":
            return f"{seconds / size:.{2 if seconds < 99.5 * size else 3}g} {unit}"
    raise AssertionError  # pragma: no cover
