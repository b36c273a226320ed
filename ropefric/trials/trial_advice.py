"""What is doubtful in a trial list, or cannot be learned from it: said once for the whole list."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import Problem
from ropefric.friction.condition import condition_groups, distinct
from ropefric.glossary import counted
from ropefric.trials.trial_spec import TrialSpec

SMALLEST_RADIUS_M, LARGEST_RADIUS_M = 1e-3, 10.0
LARGEST_WRAP_TURNS = 100
SMALLEST_WRAP_DEG = 90
FEWEST_REPEATS = 6


def radius_doubt(radius_m: float) -> str:
    """Return why a wheel radius is probably in another unit; "" if it is plausible."""
    if SMALLEST_RADIUS_M <= radius_m <= LARGEST_RADIUS_M:
        return ""
    return f"a wheel radius of {radius_m:g} m is outside 1 mm to 10 m, probably in another unit"


def advise(trials: Sequence[TrialSpec], path: str, *, rule: str, one_trial_each: bool) -> tuple[Problem, ...]:
    """Return warnings about a trial list without errors."""
    used = [trial for trial in trials if not trial.exclude]
    problems = _doubts(trials) + _unseen_effects(used)
    if used and rule == "two-sigma" and one_trial_each and all(trial.sample != "*" for trial in used):
        problems += _few_repeats(used)
    problems.sort(key=lambda p: (p.line or 0, p.code, p.key))
    return tuple(replace(problem, path=path) for problem in problems)


def _radius(trial: TrialSpec) -> str:
    return "" if trial.wheel else radius_doubt(trial.wheel_radius_m)


def _wrap(trial: TrialSpec) -> str:
    turns = trial.wrap_angle_rad / (2 * math.pi)
    return f"a wrap of {turns:g} turns is probably in another unit" if turns > LARGEST_WRAP_TURNS else ""


def _short_wrap(trial: TrialSpec) -> str:
    degrees = math.degrees(trial.wrap_angle_rad)
    if degrees > SMALLEST_WRAP_DEG * (1 - 1e-9):
        return ""
    return f"a wrap of {degrees:g} deg is below the 90 deg that ASTM D3108 sets as least, so u(mu) is large"


def _thick_rope(trial: TrialSpec) -> str:
    if trial.rope_radius_m < trial.wheel_radius_m:
        return ""
    return (
        f"the rope radius, {trial.rope_radius_m * 1e3:g} mm, is not below the wheel radius, "
        f"{trial.wheel_radius_m * 1e3:g} mm"
    )


def _reason(trial: TrialSpec) -> str:
    if trial.exclude.lower() not in {"no", "n", "false", "0", "-", "none"}:
        return ""
    return f"'{trial.exclude}' is taken as a reason, so the trial is excluded"


_CHECKS: tuple[tuple[str, Callable[[TrialSpec], str], str], ...] = (
    ("wheel_radius", _radius, "check the unit in the header"),
    ("wrap_angle", _wrap, "check the unit in the header"),
    ("wrap_angle", _short_wrap, "wrap further where the rig allows it"),
    ("exclude", _reason, "leave the cell empty to keep the trial"),
    ("rope_diameter", _thick_rope, "check both, and whether a diameter stands for a radius"),
)
"""Column, what is doubtful about it in a row ("" if nothing), remedy."""


def _doubts(trials: Sequence[TrialSpec]) -> list[Problem]:
    problems = []
    for key, check, fix in _CHECKS:
        hits = [(trial, said) for trial in trials if (said := check(trial))]
        if hits:
            more = f" (and {len(hits) - 1} more rows)" if len(hits) > 1 else ""
            problems.append(_warning("RF140", hits[0][1] + more, fix=fix, key=key, line=hits[0][0].line))
    return problems


def _few_repeats(trials: Sequence[TrialSpec]) -> list[Problem]:
    group = condition_groups(*_settings(trials))
    counts = np.bincount(group)
    few, least = int(np.count_nonzero(counts < FEWEST_REPEATS)), int(counts.min())
    if not few:
        return []
    line = trials[int(np.argmax(counts[group] == least))].line
    message = (
        f"{few} of {counted(counts.size, 'condition')} have fewer than {FEWEST_REPEATS} repeats, the smallest "
        f"{counted(least, 'repeat')}; the ±2s rule cannot reject anything for n <= 5 "
        "(largest possible |z| = (n-1)/sqrt(n))"
    )
    fix = f'plan {FEWEST_REPEATS} repeats or more, or choose [rejection] rule = "none" on purpose'
    return [_warning("RF310", message, fix=fix, line=line)]


def _settings(trials: Sequence[TrialSpec]) -> tuple[FloatArray, ...]:
    """Return what repeats have in common: size ratio, wrap, load and wheel of each trial."""
    size = [trial.wheel_radius_m / trial.rope_radius_m for trial in trials]
    load_N = [t.end_tension_N if t.end_tension_N is not None else t.lift_force_N or 0.0 for t in trials]
    columns = (size, [t.wrap_angle_rad for t in trials], load_N, [t.wheel_radius_m for t in trials])
    return tuple(np.array(column) for column in columns)


def _unseen_effects(trials: Sequence[TrialSpec]) -> list[Problem]:
    if len(trials) < 2:
        return []
    problems = []
    sizes, wraps, loads, _ = _settings(trials)
    for key, name, effect, values in (
        ("wheel_radius", "ratio of wheel and rope radius", "size", sizes),
        ("wrap_angle", "wrap angle", "wrap angle", wraps),
        ("end_tension", "tension", "tension", loads),
    ):
        if distinct(values).size == 1:
            message = f"all trials have one {name}, so the effect of the {effect} cannot be seen"
            fix = f"measure at two or more values, or fit laws without an effect of the {effect}"
            problems.append(_warning("RF311", message, fix=fix, key=key))
    return problems


def _warning(code: str, message: str, *, fix: str, key: str = "", line: int | None = None) -> Problem:
    return Problem(code=code, message=message, line=line, key=key, fix=fix, severity="warning")
