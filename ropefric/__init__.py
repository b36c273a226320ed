"""From force traces of a rope on a wheel to a friction law with honest uncertainty, and on to design.

>>> import ropefric as rf
>>> rf.reject([7.18, 7.64, 8.00, 7.40, 9.14, 7.82, 7.67, 7.73, 8.27, 7.30]).rejected
(4,)
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_WHERE = {
    "budget": "ropefric.api.models",
    "compare": "ropefric.api.models",
    "design": "ropefric.api.models",
    "diagnose": "ropefric.api.models",
    "explain": "ropefric.api.models",
    "extract": "ropefric.api.recordings",
    "find_breakaway": "ropefric.api.recordings",
    "fit": "ropefric.api.models",
    "lmfit_model": "ropefric.fitting.lmfit_model",
    "load_campaign": "ropefric.trials.campaign",
    "load_fit": "ropefric.fitting.store",
    "load_scene": "ropefric.scenes.scene",
    "measured_budgets": "ropefric.api.models",
    "plan_tests": "ropefric.api.models",
    "predict": "ropefric.api.models",
    "read_trace": "ropefric.api.recordings",
    "read_trial": "ropefric.api.recordings",
    "reject": "ropefric.api.recordings",
    "run": "ropefric.api.models",
    "save_fit": "ropefric.fitting.store",
    "smooth": "ropefric.api.recordings",
    "solve": "ropefric.api.models",
    "sweep": "ropefric.api.models",
    "trial_table": "ropefric.api.recordings",
    "write_scenes": "ropefric.scenes.scene_templates",
}
__all__ = ["__version__", *_WHERE]  # noqa: PLE0604  (its names are strings)


def __getattr__(name: str) -> Any:
    # NumPy, SciPy and pandas take long to load, and a short command needs none; `__init__.pyi` has the types.
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_WHERE[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
