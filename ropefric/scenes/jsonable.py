"""Numbers and methods as JSON trees hold them."""

import math
from typing import Any

from ropefric.systems.effect import Method


def finite(value: float) -> float | None:
    """Return a number as a float, None (null) where it is not finite."""
    return float(value) if math.isfinite(value) else None


def method_tree(method: Method) -> dict[str, Any]:
    """Return how a model was solved as a JSON tree."""
    return {
        "name": method.name,
        "settings": dict(method.settings),
        "error": finite(method.error),
        "why": method.why,
    }
