"""The answer to a saw scene as a JSON tree: the sides, what may resonate, what measurements say about the models."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError
from ropefric.scenes.jsonable import finite
from ropefric.systems.bandsaw.answer import SawAnswer, SideAnswer
from ropefric.systems.bandsaw.effects import SawProblem
from ropefric.systems.bandsaw.measured import deviations, explain_mounting, identify
from ropefric.systems.bandsaw.models import MODELS
from ropefric.systems.bandsaw.resonance import find_crossings, margins
from ropefric.systems.bandsaw.saw import Saw, Side
from ropefric.systems.bandsaw.strain import recommend_preload

_NEAREST = 10
_SPEEDS = 200
_FASTEST = 0.98
"""Of the critical speed: up to where crossings are looked for."""


def saw_tree(answer: SawAnswer, problem: SawProblem) -> dict[str, Any]:
    """Return the JSON shape of a saw's answer."""
    tree: dict[str, Any] = {side.value: _side(one) for side, one in answer.sides.items()}
    if problem.speed_m_s is not None:
        tree["speed_m_s"] = float(problem.speed_m_s[0])
    saw, planned = saw_of(problem), planned_saw(answer, problem)
    if saw is None or planned is None:
        return tree
    if problem.excitations:
        tree["resonance"] = _resonance(planned, problem)
    if problem.measurements:
        tree["comparison"] = {
            "deviations": _deviations(saw, problem),
            "mounting": _mountings(planned, problem),
            "identified": _identified(planned, problem),
        }
    return tree


def saw_of(problem: SawProblem) -> Saw | None:
    """Return the whole saw of a single case, with all its parts; None where its wheels are not known."""
    if problem.wheel_radius_m is None or problem.wheel_speed_rad_s is None:
        return None
    optional = {
        "tension_difference_N": problem.tension_difference_N,
        "mounting_factor": problem.mounting_factor,
        "bending_stiffness_N_m2": problem.bending_stiffness_N_m2,
    }
    return Saw(
        free_span_m=float(problem.free_span_m[0]),
        linear_density_kg_m=float(problem.linear_density_kg_m[0]),
        preload_N=float(problem.preload_N[0]),
        wheel_radius_m=float(problem.wheel_radius_m[0]),
        wheel_speed_rad_s=float(problem.wheel_speed_rad_s[0]),
        ends=problem.ends,
        **{name: float(value[0]) for name, value in optional.items() if value is not None},
    )


def planned_saw(answer: SawAnswer, problem: SawProblem) -> Saw | None:
    """Return the saw with a stiff blade only if the plan has one; None where its wheels are not known.

    Which mounting explains a measurement, and where a mode meets an excitation, depends on it.
    """
    saw = saw_of(problem)
    if saw is None or answer.model.spans[Side.TIGHT].bending_stiffness_N_m2.any():
        return saw
    return replace(saw, bending_stiffness_N_m2=0.0)


def _side(one: SideAnswer) -> dict[str, Any]:
    tree = {
        "frequencies_Hz": one.frequencies_Hz[0].tolist(),
        "tension_N": float(one.tension_N[0]),
        "wave_speed_m_s": float(one.wave_speed_m_s[0]),
        # A constant-force mounting has no critical speed.
        "critical_speed_m_s": finite(float(one.critical_speed_m_s[0])),
    }
    if one.torsion_Hz is not None:
        tree["torsion_Hz"] = one.torsion_Hz[0].tolist()
    return tree


def _resonance(saw: Saw, problem: SawProblem) -> dict[str, Any]:
    near = margins(saw, (Side.TIGHT, Side.SLACK), problem.excitations, problem.n_modes)
    return {
        "recommended_preload": _recommended(saw, problem),
        "nearest": [
            {
                "side": one.side.value,
                "mode": one.mode,
                "excitation": one.excitation,
                "harmonic": one.harmonic,
                "mode_Hz": one.mode_Hz,
                "excitation_Hz": one.excitation_Hz,
                "margin": one.relative,
            }
            for one in near[:_NEAREST]
        ],
        "crossings": [
            {
                "side": one.side.value,
                "mode": one.mode,
                "excitation": one.excitation,
                "harmonic": one.harmonic,
                "speed_m_s": one.speed_m_s,
                "frequency_Hz": one.frequency_Hz,
                "speed_margin": finite(one.speed_margin),
            }
            for side in (Side.TIGHT, Side.SLACK)
            for one in find_crossings(saw, side, problem.excitations, speeds_m_s(saw, side), problem.n_modes)
        ],
    }


def _recommended(saw: Saw, problem: SawProblem) -> dict[str, Any] | None:
    """Return the preload that keeps the margin wanted, where one was."""
    if problem.margin_wanted is None or problem.preload_range_N is None:
        return None
    try:
        found = recommend_preload(
            saw,
            problem.excitations,
            margin=problem.margin_wanted,
            range_N=problem.preload_range_N,
            n_modes=problem.n_modes,
        )
    except RopefricError as error:
        return {"status": "not possible", "advice": error.problem.message}
    return {
        "preload_N": found.preload_N,
        "margin": found.margin,
        "forbidden_N": [list(interval) for interval in found.forbidden_N],
        "status": found.status.value,
        "advice": found.status.advice,
    }


def speeds_m_s(saw: Saw, side: Side) -> FloatArray:
    """Return speeds from rest to half as fast again as at work, or to nearly the critical speed."""
    static_N = saw.preload_N + 0.5 * side.sign * saw.tension_difference_N
    held = saw.linear_density_kg_m * max(1.0 - saw.mounting_factor, 1e-3)
    fastest = min(1.5 * max(saw.speed_m_s, 1.0), _FASTEST * math.sqrt(static_N / held))
    return np.linspace(0.0, fastest, _SPEEDS)


def _deviations(saw: Saw, problem: SawProblem) -> list[dict[str, Any]]:
    """Return how far each model is from each measurement; a model that has no answer for this saw says why."""
    found: list[dict[str, Any]] = []
    for model in MODELS:
        for point in problem.measurements:
            row = {
                "model": model,
                "side": point.side.value,
                "mode": point.mode,
                "measured_Hz": point.frequency_Hz,
            }
            try:
                (one,) = deviations(saw, (point,), (model,))
            except RopefricError as error:
                found.append(row | {"model_Hz": None, "relative": None, "why": error.problem.message})
            else:
                found.append(row | {"model_Hz": one.frequency_Hz, "relative": one.relative, "why": ""})
    return sorted(found, key=lambda row: (row["side"] != Side.REST.value, row["side"] != Side.TIGHT.value))


def _mountings(saw: Saw, problem: SawProblem) -> list[dict[str, Any]]:
    found = []
    for point in problem.measurements:
        if point.side is Side.REST:
            continue
        row = {"side": point.side.value, "mode": point.mode, "measured_Hz": point.frequency_Hz}
        try:
            one = explain_mounting(saw, point)
        except RopefricError as error:
            found.append(
                row | {"mounting_factor": None, "status": "not possible", "advice": error.problem.message}
            )
        else:
            found.append(
                row
                | {
                    "mounting_factor": one.mounting_factor,
                    "status": one.status.value,
                    "advice": one.status.advice,
                }
            )
    return found


def _identified(saw: Saw, problem: SawProblem) -> dict[str, Any] | None:
    try:
        found = identify(saw, problem.measurements)
    except RopefricError as error:
        return {"status": "not possible", "advice": error.problem.message}
    std = found.std
    return {
        "preload_N": found.preload_N,
        "mounting_factor": found.mounting_factor,
        "preload_std_N": None if std is None else finite(std[0]),
        "mounting_factor_std": None if std is None else finite(std[1]),
        "free_mounting_factor": found.free_mounting_factor,
        "status": found.status.value,
        "advice": found.status.advice,
    }
