"""From force traces of a rope on a wheel to a friction law with honest uncertainty, and on to design.

>>> import ropefric as rf
>>> rf.reject([7.18, 7.64, 8.00, 7.40, 9.14, 7.82, 7.67, 7.73, 8.27, 7.30]).rejected
(4,)
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

__all__ = [
    "__version__",
    "compare",
    "design",
    "diagnose",
    "extract",
    "find_breakaway",
    "fit",
    "load_campaign",
    "load_fit",
    "predict",
    "read_trace",
    "read_trial",
    "reject",
    "run",
    "save_fit",
    "smooth",
    "trial_table",
]


def __getattr__(name: str) -> Any:
    # NumPy and SciPy take longer to load than the rest of a short command; `__init__.pyi` tells editors the types.
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module("ropefric.api"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
