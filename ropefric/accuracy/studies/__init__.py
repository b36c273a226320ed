"""Every study of accuracy by name; one file declares one study."""

from ropefric.accuracy.studies import (
    blade_modes,
    end_tension,
    fit,
    integral,
    peak,
    picks,
    press_transient,
    scenes,
    uncertainty,
)
from ropefric.accuracy.study import Study
from ropefric.registry import Registry

_IN_ORDER = (integral, end_tension, peak, picks, uncertainty, fit, press_transient, blade_modes, scenes)
STUDIES: Registry[Study] = Registry("study", [module.STUDY for module in _IN_ORDER])
"""The studies, in the order of a campaign's way from the traces to a design."""
