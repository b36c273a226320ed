"""Numbers and methods as JSON trees hold them."""

import math
from typing import Any

from ropefric.systems.effect import Method

__all__ = ["finite", "method_tree"]


def finite(value: float) -> float | None:
    """Return a number as a float, None (null) where it is not finite.

    Examples
    --------
    >>> finite(2), finite(math.inf)
    (2.0, None)
    """
    return float(value) if math.isfinite(value) else None


def method_tree(method: Method) -> dict[str, Any]:
    """Return how a model was solved as a JSON tree.

    Examples
    --------
    >>> method_tree(Method(name="closed form", error=1e-13, why="exact"))["error"]
    1e-13
    """
    return {
        "name": method.name,
        "settings": dict(method.settings),
        "error": finite(method.error),
        "why": method.why,
    }
