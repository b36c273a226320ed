"""Every study of accuracy by name; one file declares one study."""

from ropefric.accuracy.studies import (
    blade_modes,
    end_tension,
    fit,
    integral,
    peak,
    press_transient,
    scenes,
    uncertainty,
)
from ropefric.accuracy.study import Study
from ropefric.registry import Registry

STUDIES: Registry[Study] = Registry(
    "study",
    [
        integral.STUDY,
        end_tension.STUDY,
        peak.STUDY,
        uncertainty.STUDY,
        fit.STUDY,
        press_transient.STUDY,
        blade_modes.STUDY,
        scenes.STUDY,
    ],
)
"""The studies, in the order of a campaign's way from the traces to a design."""
