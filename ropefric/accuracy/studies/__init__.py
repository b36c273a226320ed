"""Every study of accuracy by name; one file declares one study."""

from ropefric.accuracy.study import Study
from ropefric.registry import Registry, declared_in

_IN_ORDER = ("integral", "peak", "picks", "interval", "press_transient", "blade_modes", "scenes")
STUDIES: Registry[Study] = Registry("study", declared_in(__name__, _IN_ORDER, "STUDY"))
"""The studies, in the order of a campaign's way from the traces to a design."""
