"""The belt press as a system for scenes."""

import numpy as np

from ropefric.friction.condition import FloatArray
from ropefric.systems.effect import Method, System
from ropefric.systems.press.answer import PressAnswer, PressModel, solve_press
from ropefric.systems.press.effects import EFFECTS, bare
from ropefric.systems.press.problem import PressProblem
from ropefric.systems.press.steady import drive_power_W

__all__ = ["SYSTEM"]

_DIRECT = Method(
    name="direct solution",
    error=1e-11,
    why="the balances are linear; one small system of equations gives all tensions",
)
_EXACT = Method(
    name="direct solution and matrix exponential",
    error=1e-7,
    why="between two changes of a contact the start-up is linear, and its exponential is exact for any step",
)


def _method(model: PressModel, budget: float) -> Method:  # noqa: ARG001  (the signature of `System.method`)
    if model.start_up is None:
        return _DIRECT
    task = model.start_up
    if task.integrator == "exact":
        return _EXACT
    return Method(
        name=f"direct solution and {task.integrator}",
        settings={"tolerance": task.settings.tolerance}
        | ({} if task.settings.step_s is None else {"step_s": task.settings.step_s}),
        error=np.inf,
        why="asked for by name; its error is not bounded beforehand",
    )


def _solve(model: PressModel, method: Method) -> PressAnswer:  # noqa: ARG001  (the signature of `System.solve`)
    return solve_press(model)


def _distance(answer: PressAnswer, reference: PressAnswer) -> float:
    found = [
        _relative(answer.state.effective_tension_N, reference.state.effective_tension_N),
        _of_largest(answer.slip.utilisation, reference.slip.utilisation),
        _of_largest(*(drive_power_W(one.state)[..., np.newaxis] for one in (answer, reference))),
    ]
    if reference.start_up is not None:
        if answer.start_up is None:
            return np.inf
        found.append(
            _relative(answer.start_up.tension_N.max(axis=0), reference.start_up.tension_N.max(axis=0))
        )
        if answer.start_up.utilisation is not None and reference.start_up.utilisation is not None:
            found.append(
                _of_largest(
                    answer.start_up.utilisation.max(axis=0), reference.start_up.utilisation.max(axis=0)
                )
            )
    return max(found)


def _relative(values: FloatArray, reference: FloatArray) -> float:
    return float(np.max(np.abs(values / reference - 1.0)))


def _of_largest(values: FloatArray, reference: FloatArray) -> float:
    """Return the largest difference, as a share of the largest reference: a roller without torque has none itself."""
    largest = np.max(np.abs(reference), axis=-1, keepdims=True)
    difference = np.abs(values - reference)
    share = np.divide(difference, largest, out=np.zeros_like(difference), where=difference > 0.0)
    return float(np.max(share))


SYSTEM: System[PressProblem, PressModel, PressAnswer] = System(
    name="press", effects=EFFECTS, bare=bare, method=_method, solve=_solve, distance=_distance
)
"""Rollers and belts."""
