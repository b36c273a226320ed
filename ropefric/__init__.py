"""From force traces of a rope on a wheel to a friction law with honest uncertainty, and on to design.

>>> import ropefric as rf
>>> rf.reject([7.18, 7.64, 8.00, 7.40, 9.14, 7.82, 7.67, 7.73, 8.27, 7.30]).rejected
(4,)
"""

from importlib import import_module
from typing import Any

from ropefric.shown import provide as _provide

__version__ = "0.2.0"

_NAMES = {
    "api": "accuracy_table budget compare design diagnose explain extract find_breakaway fit "
    "monte_carlo plan_tests predict read_trace read_trial reject run smooth solve sweep trial_table",
    "errors": "RopefricError RopefricWarning",
    "fitting.predict": "lmfit_model",
    "fitting.store": "load_fit save_fit",
    "plugins": "load_plugin",
    "scenes.scene": "load_scene",
    "scenes.scene_templates": "write_scenes",
    "trials.campaign": "load_campaign",
}
_WHERE = {name: f"ropefric.{module}" for module, names in _NAMES.items() for name in names.split()}
__all__ = ["__version__", *sorted(_WHERE)]  # noqa: PLE0604  (its names are strings)


def __getattr__(name: str) -> Any:
    # NumPy, SciPy and pandas take long to load, and a short command needs none; `__init__.pyi` has the types.
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(_WHERE[name]), name)
    return value


def __dir__() -> list[str]:
    return __all__


# Results lie below the rooms that draw them and predict by them; this package stands above all rooms.
_provide(
    plot=lambda: import_module("ropefric.plotting.results").draw,
    predict=lambda: import_module("ropefric.api").predict,
)
