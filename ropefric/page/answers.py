"""Laws, wheels and machines as the page shows them, with the same numbers as the commands."""

import itertools
import json
import tempfile
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import lru_cache, partial
from math import degrees
from pathlib import Path
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.files.plain_text import GIVEN_DIGITS, rounded_tree
from ropefric.fitting.compare import choose_law
from ropefric.fitting.design import QUANTITIES, design
from ropefric.fitting.predict import outside_words, predict
from ropefric.fitting.result import FitResult
from ropefric.fitting.statistics import condition_means
from ropefric.fitting.store import save_fit
from ropefric.friction.condition import Conditions, one_condition
from ropefric.page.review import Review
from ropefric.pipeline import CampaignRun, plan_for_design
from ropefric.report import parts
from ropefric.scenes.explain import explain_solution
from ropefric.scenes.keys import scene_keys
from ropefric.scenes.kinds import KINDS
from ropefric.scenes.scene import leaves, load_scene
from ropefric.scenes.scene_templates import bundled_scenes, scene_text, write_scenes
from ropefric.scenes.solve import solve_scene
from ropefric.section import as_text

_plain = partial(rounded_tree, digits=GIVEN_DIGITS)
_POINTS, _WIDER = 60, 1.25
"""Points of a curve over the wrap, and how far it extends beyond the tested range."""
_APART = 0.03
"""Difference in ln F_B: closer settings share one curve in the picture."""


@lru_cache(maxsize=1)
def law_of(review: Review, run: CampaignRun) -> dict[str, Any]:
    """Return the answer as `ropefric run` has it, a verdict on each fitted law, the conditions, and the curves."""
    answer = run.answer
    tree = answer.to_dict() | {
        "asked": review.law,
        "how": answer.winner.how,
        "equation": answer.fit.friction_law.equation,
        "verdicts": {fit.law: choose_law(answer.comparison, fit.law).verdict.word for fit in answer.fits},
        "conditions": review.conditions_of(run),
        "series": [*_series(answer.fit)],
        "rope_radius_m": run.campaign.rope.radius_m,
    }
    return dict(_plain(tree))


def _series(fit: FitResult) -> Iterator[dict[str, Any]]:
    """Yield the series of each wheel and end tension: means over the wrap, law with interval, residuals."""
    means = condition_means(fit.data)
    at, log_N, std = means.conditions, means.log_lift, means.std
    wraps_rad, residuals = at.wrap_angle_rad, log_N - predict(fit, at).log_lift
    points = np.column_stack([np.degrees(wraps_rad), *np.exp([log_N, log_N - std, log_N + std])])
    off = np.expm1(residuals)
    percents = np.column_stack([np.degrees(wraps_rad), 100.0 * off, 100.0 * (off - std), 100.0 * (off + std)])
    names = [
        f"R {1e3 * radius_m:.4g} mm, F_B {level_N:.3g} N"
        for radius_m, level_N in zip(at.wheel_radius_m, _levels(at.end_tension_N), strict=True)
    ]
    for name in dict.fromkeys(names):
        here = np.flatnonzero([one == name for one in names])
        here = here[np.argsort(wraps_rad[here])]
        settings = ("wheel_radius_m", "rope_radius_m", "end_tension_N")
        others = {key: float(np.mean(getattr(at, key)[here])) for key in settings}
        curve = _over_wrap(fit, wraps_rad[here[0]], wraps_rad[here[-1]], others)
        yield {"name": name, **curve, "points": points[here].tolist(), "residuals": percents[here].tolist()}


def _levels(values: FloatArray) -> FloatArray:
    """Return for each value the mean of its level: measured values of one level differ a little."""
    found, order = np.empty_like(values), np.argsort(values)
    starts = [0, *(np.flatnonzero(np.diff(np.log(values[order])) > _APART) + 1), values.size]
    for start, stop in itertools.pairwise(starts):
        found[order[start:stop]] = values[order[start:stop]].mean()
    return found


def _over_wrap(
    fit: FitResult, low_rad: float, high_rad: float, others: Mapping[str, float]
) -> dict[str, Any]:
    """Return the lift force over the wrap, and its interval."""
    wraps: FloatArray = np.linspace(low_rad, high_rad, _POINTS if high_rad > low_rad else 1)
    at = Conditions(wrap_angle_rad=wraps, **{key: np.array(value) for key, value in others.items()})
    found, wraps_deg = predict(fit, at), np.degrees(wraps)
    curves = {"line": found.lift_force_N, "band": found.interval_N}
    return {name: np.column_stack([wraps_deg, values_N]).tolist() for name, values_N in curves.items()}


def plan_of(run: CampaignRun) -> dict[str, Any]:
    """Return the pulls that reduce the uncertainty of the design's lift force most, as `run` writes them."""
    assert run.answer.prediction is not None  # noqa: S101  (the page offers it for a design only)
    plan = plan_for_design(run.answer, run, run.answer.prediction.conditions)
    return {"text": as_text(parts.plan_sections(plan))}


def lift_of(run: CampaignRun, settings: Mapping[str, float]) -> dict[str, Any]:
    """Return the lift force of a wheel with its intervals, as `ropefric predict` does, and its curve over the wrap."""
    answer, fit = run.answer, run.answer.fit
    found = answer.winner.of(predict(fit, one_condition(**settings)))
    low_rad, high_rad = fit.validity["wrap_angle_rad"]
    others = {name: value for name, value in settings.items() if name != "wrap_angle_rad"}
    most_rad = _WIDER * max(high_rad, settings["wrap_angle_rad"])
    curve = _over_wrap(fit, min(low_rad, settings["wrap_angle_rad"]) / _WIDER, most_rad, others)
    # Where radius or end tension were not tested, no wrap was.
    beside = outside_words(fit.validity, one_condition(**others, wrap_angle_rad=low_rad))
    tested_deg = [] if beside else [degrees(low_rad), degrees(high_rad)]
    return {**found.to_dict(), **_plain(curve), "tested_deg": tested_deg}


def inverse_of(run: CampaignRun, asked: Mapping[str, str], settings: Mapping[str, float]) -> dict[str, Any]:
    """Return the smallest wrap, wheel or end tension that lifts a load, as `ropefric design` does."""
    solve_for, probability = asked["solve_for"], float(asked["probability"]) if asked["probability"] else None
    given = {name: value for name, value in settings.items() if name != QUANTITIES[solve_for][0]}
    how: dict[str, Any] = {"solve_for": solve_for, "probability": probability, **given}
    return design(run.answer.fit, lift_N=[float(asked["lift_N"])], **how).to_dict()


def machine_names() -> list[dict[str, str]]:
    """Return the templates of all machines with the kind of machine that they are of."""
    scenes = bundled_scenes().items()
    return [{"name": name, "system": tomllib.loads(text)["system"]} for name, text in scenes]


def machine_form(name: str) -> list[dict[str, Any]]:
    """Return the keys of a template with their values and declarations, then the other keys of this machine."""
    data = tomllib.loads(scene_text(name))
    declared = [*scene_keys(KINDS[data["system"]].schema)]
    rows, given = list[dict[str, Any]](), dict(leaves(data))
    for key, value in given.items():
        one = next((one for one in declared if _fits(one.name, key)), None)
        text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
        rows.append({"key": key, "value": text, **(one._asdict() if one else {})})
    whole = (one for one in declared if not {"…", "["} & {*one.name} and one.name not in given)
    return [*rows, *({"key": one.name, "value": "", **one._asdict()} for one in whole)]


def solve_machine(name: str, values: Mapping[str, str], own: FitResult | None) -> dict[str, Any]:
    """Return the answer of a template with changed keys, and the effects left out with the reasons.

    `values` are as a person writes them, "" for a key that is left out; `own` is a law in place of its friction.
    """
    changes = {key: _value(text) for key, text in values.items()}
    with tempfile.TemporaryDirectory(prefix="ropefric-") as folder:
        write_scenes(folder, [name])
        if own is not None:
            save_fit(own, Path(folder, "fits", "own.json"))
            changes |= {"friction": {"fit": "fits/own.json"}}
        scene = load_scene(Path(folder, f"{name}.toml"), changes)
    solution = solve_scene(scene)
    tree, effects = solution.to_dict(), explain_solution(solution)
    first, *others = parts.solution_sections(solution, tree)
    text = as_text([first._replace(title=name), *others])  # the file is the page's own
    return dict(_plain({"answer": tree, "text": text, "effects": effects.to_dict()["effects"]}))


def _fits(name: str, key: str) -> bool:
    """Return whether a declared name, in which … and [] are names and numbers of the user, matches a key."""
    wanted, given = name.replace("[]", ".[]").split("."), key.split(".")
    return len(wanted) == len(given) and all(
        one in {"…", part} or (one == "[]" and part.isdecimal())
        for one, part in zip(wanted, given, strict=True)
    )


def _value(text: str) -> Any:
    """Return the text of a field as a TOML value; None for an empty field."""
    if not text.strip():
        return None
    with suppress(ValueError):
        return json.loads(text)
    return text.strip()
