"""The answer to a press scene as a JSON tree: tensions, slip, what slips first and when, the start-up."""

from dataclasses import replace
from typing import Any

import numpy as np

from ropefric.scenes.jsonable import finite
from ropefric.scenes.kind import Failure, Quantity
from ropefric.systems.press.answer import PressAnswer, PressProblem, as_operated
from ropefric.systems.press.critical import CHANGES, critical_values, first_to_slip
from ropefric.systems.press.machine import Press
from ropefric.systems.press.slip import MEASURES
from ropefric.systems.press.statics import solve_statics
from ropefric.systems.press.steady import Parts, drive_power_W

_DIRECTIONS = {
    "preload": ("falls", "rises"),
    "speed": ("rises", "falls"),
    "load": ("rises", "falls"),
    "friction": ("falls", "rises"),
}
"""Which way each leads to the first slip, and out of it where a roller slips already."""


def press_quantities(answer: PressAnswer, problem: PressProblem) -> tuple[Quantity, ...]:
    """Return the numbers of a press that people read, one a case."""
    del problem
    use = answer.slip.utilisation
    return (
        Quantity(name="largest_utilisation", value=use.max(axis=-1)),
        Quantity(name="power_W", value=drive_power_W(answer.state)),
        *(
            Quantity(name=f"slip.{name}.{measure}", value=getattr(answer.slip, measure)[..., place])
            for measure in ("utilisation", "as_plotted", "as_printed")
            for place, name in enumerate(answer.slip.rollers)
        ),
        *(
            Quantity(
                name=f"effective_tension_N.{span.name}", value=answer.state.effective_tension_N[..., place]
            )
            for place, span in enumerate(answer.model.press.spans)
        ),
    )


def press_failures(answer: PressAnswer, problem: PressProblem) -> tuple[Failure, ...]:
    """Return the slip of a press that runs steadily; in a start-up slip is simulated, and part of the answer."""
    if problem.start_up is not None:
        return ()
    largest = answer.slip.utilisation.max(axis=-1)
    words = "a roller slips, so the belts cannot be pulled like this"
    return (Failure(words=words, measure="largest utilisation", value=largest, fails=largest > 1.0),)


def press_tree(answer: PressAnswer, problem: PressProblem) -> dict[str, Any]:
    """Return the JSON shape of a press's answer."""
    del problem
    spans = [span.name for span in answer.model.press.spans]
    slip = answer.slip
    tree: dict[str, Any] = {
        "tension_N": dict(zip(spans, answer.at_rest_N[0].tolist(), strict=True)),
        "effective_tension_N": dict(zip(spans, answer.state.effective_tension_N[0].tolist(), strict=True)),
        "slip": {
            roller: {measure: finite(float(slip.of(roller, measure)[0])) for measure in MEASURES}
            for roller in slip.rollers
        },
        "closure": answer.statics.closure,
        "rank": answer.statics.rank,
        "undetermined": list(answer.statics.undetermined),
        "speed_m_s": float(answer.state.speed_m_s[0]),
    }
    tree["loads"] = _loads(answer)
    tree |= _first(answer)
    if answer.start_up is not None:
        tree["start_up"] = answer.start_up.summary()
    return tree


def _loads(answer: PressAnswer) -> dict[str, Any]:
    """Return what the torques stand for: pulls M_G/R, eq. (6), and Δh K_max times the squeezes, eq. (9)."""
    press = answer.model.press
    factor = float(answer.model.problem.load_factor[0])
    by_roller = {}
    for roller in press.rollers:
        if roller.torque_N_m:
            width_m = max(belt.width_m for belt in press.belts if roller.name in belt.loop)
            by_roller[roller.name] = {
                "gravity_pull_N": factor * roller.gravity_torque_N_m / roller.radius_m,
                "squeeze_N_m": factor * roller.squeeze_torque_N_m / (width_m * roller.radius_m),
            }
    total_N = sum(roller.torque_N_m / roller.radius_m for roller in press.rollers)
    return {"by_roller": by_roller, "total_N": factor * total_N}


def _first(answer: PressAnswer) -> dict[str, Any]:
    """Return which roller is nearest to slip, and what would make the first one slip.

    Where rollers slip already, each value is the one at which the last of them stops, and lies the other way.
    """
    model = answer.model
    use = answer.slip.utilisation[0]
    slips = [name for name, share in zip(answer.slip.rollers, use, strict=True) if share > 1.0]
    critical: dict[str, Any] = {}
    for change in CHANGES:
        # What a higher speed does is the belts' mass, whether or not it matters at this one.
        parts = replace(model.parts, mass=model.parts.mass or change == "speed")
        values = critical_values(
            solve_statics(_answering_to_speed(as_operated(model), parts), closure=model.problem.closure),
            model.problem.friction,
            change,  # type: ignore[arg-type]
            tensioner=parts.tensioner,
            told=model.told,
        )
        slipping = {name: values[name] for name in slips}
        first = first_to_slip(slipping or values, change)  # type: ignore[arg-type]
        if any(value is None for value in slipping.values()):
            first = None  # nothing of this kind holds that roller
        critical[change] = {
            "state": "slips" if slipping else "holds",
            # A slipping roller that slips at rest and without load too has no way out there.
            "direction": None
            if first is None or (slipping and first.value == 0.0)
            else _DIRECTIONS[change][bool(slipping)],
            "roller": None if first is None else first.roller,
            "value": None if first is None else first.value,
            "unit": CHANGES[change].rpartition("[")[2].rstrip("]"),
            "by_roller": values,
        }
    return {
        "first_to_slip": answer.slip.rollers[int(np.argmax(use))] if use.any() else None,
        "slips": slips,
        "critical": critical,
    }


def _answering_to_speed(press: Press, parts: Parts) -> Press:
    """Return a press whose T' answers to the speed as with these parts: not at all where its belts weigh nothing."""
    if not parts.keeps_tension:
        return press
    return replace(press, belts=tuple(replace(belt, linear_density_kg_m=0.0) for belt in press.belts))
