"""The band saw as a system for scenes."""

import numpy as np

from ropefric.friction.condition import FloatArray
from ropefric.systems.bandsaw.answer import SawAnswer, SawModel, solve_saw
from ropefric.systems.bandsaw.effects import EFFECTS, bare
from ropefric.systems.bandsaw.problem import SawProblem
from ropefric.systems.effect import Method, System

__all__ = ["SYSTEM"]

_CLOSED_FORM = Method(name="closed form", error=1e-13, why="a string's travelling waves have one")
_FINEST = 1e-12
"""What rounding leaves is a few units of 1e-14."""
_COARSEST = 1e-3
"""A beam to a thousandth takes at most two orders more than to a hundredth: both need their boundary layers."""

_MARGIN = 0.25
"""What two orders may differ by, of the error allowed: the finer one can err by nearly twice what they differ by."""


def _method(model: SawModel, budget: float) -> Method:
    if not any(span.bending_stiffness_N_m2.any() for span in model.spans.values()):
        return _CLOSED_FORM
    accuracy = min(max(budget, _FINEST), _COARSEST)
    return Method(
        name="spectral elements",
        settings={"accuracy": _MARGIN * accuracy},
        error=accuracy,
        why="the order is raised until a coarser solution agrees to a quarter of this",
    )


def _solve(model: SawModel, method: Method) -> SawAnswer:
    return solve_saw(model, accuracy=method.settings.get("accuracy", _FINEST))


def _distance(answer: SawAnswer, reference: SawAnswer) -> float:
    found = [
        float(np.max(np.abs(answer.sides[side].frequencies_Hz / other.frequencies_Hz - 1.0)))
        for side, other in reference.sides.items()
    ]
    if answer.wheel_utilisation is not None and reference.wheel_utilisation is not None:
        found.append(_relative(answer.wheel_utilisation, reference.wheel_utilisation))
    return max(found)


def _relative(values: FloatArray, reference: FloatArray) -> float:
    """Return the largest relative difference where there is one: a wheel that pulls nothing needs no grip."""
    differs = values != reference
    share = np.divide(values, reference, out=np.full_like(values, np.inf), where=differs & (reference != 0.0))
    return float(np.max(np.where(differs, np.abs(share - 1.0), 0.0)))


SYSTEM: System[SawProblem, SawModel, SawAnswer] = System(
    name="bandsaw", effects=EFFECTS, bare=bare, method=_method, solve=_solve, distance=_distance
)
"""A blade on two wheels."""
