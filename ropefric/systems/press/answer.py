"""A press as assembled from its effects, and its tensions, slip and start-up."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.checks import Cases, ZeroOrMore
from ropefric.systems.effect import Model
from ropefric.systems.friction import WrapFriction, regressors_of
from ropefric.systems.press.creep import rim_speed_ratios
from ropefric.systems.press.critical import CHANGES, critical
from ropefric.systems.press.machine import Press
from ropefric.systems.press.slip import SlipTable
from ropefric.systems.press.statics import Statics, SteadyState, TakeUp, solve_statics, steady_state
from ropefric.systems.press.transient.start_up import StartUp, start_up


@dataclass(frozen=True, kw_only=True, eq=False)
class PressProblem(Cases):
    """A press at n operating points; scalars are spread. `start_up` has the settings of a start-up."""

    press: Press
    closure: str
    friction: WrapFriction
    speed_m_s: ZeroOrMore
    preload_N: ZeroOrMore | None = None
    load_factor: ZeroOrMore
    start_up: Mapping[str, Any] | None = None


class PressModel(Model[PressProblem]):
    """A press with the effects that are in it; without any: no loads or mass, locked tensioners, one coefficient."""

    def _machine(self, load_factor: float = 1.0, preload_N: float | None = None) -> Press:
        """Return the machine with the loads that are in, scaled, and another preload where tensioners share one."""
        gravity, squeeze = (load_factor * (name in self.effects) for name in ("gravity-load", "squeeze-load"))
        rollers = []
        for one in self.problem.press.rollers:
            own: dict[str, Any] = {"gravity_torque_N_m": gravity * one.gravity_torque_N_m}
            own["squeeze_torque_N_m"] = squeeze * one.squeeze_torque_N_m
            if one.tensioner is not None and one.tensioner.is_shared and preload_N is not None:
                own["tensioner"] = replace(one.tensioner, force_N=preload_N)
            rollers.append(replace(one, **own))
        return replace(self.problem.press, rollers=tuple(rollers))

    @cached_property
    def press(self) -> Press:
        """Return the machine with the loads that are in."""
        return self._machine()

    @cached_property
    def as_operated(self) -> Press:
        """Return the machine with the preload and the loads of its operating point."""
        preload_N = self.problem.preload_N
        return self._machine(
            float(self.problem.load_factor[0]), None if preload_N is None else float(preload_N[0])
        )

    @property
    def regressors(self) -> frozenset[str]:
        """Return the regressors that the law gets from a contact."""
        return regressors_of(self.effects)

    @property
    def start_up(self) -> Mapping[str, Any] | None:
        """Return the start-up to be simulated, where it is."""
        return self.problem.start_up if "transient" in self.effects else None


class PressAnswer(NamedTuple):
    """The steady run of a press, and its start-up where one was asked for."""

    model: PressModel
    statics: Statics
    state: SteadyState
    at_rest_N: FloatArray
    slip: SlipTable
    start_up: StartUp | None = None

    @property
    def rim_speed_m_s(self) -> FloatArray:
        """Return how fast the rims run, shape (n, n_rollers) [m/s]: alike where creep is left out."""
        state = self.state
        ratios = np.ones((state.speed_m_s.size, len(state.press.rollers)))
        if "elastic-creep" in self.model.effects:
            has_mass = "belt-inertia" in self.model.effects
            ratios = rim_speed_ratios(state.press, state.tension_N if has_mass else state.effective_tension_N)
        return np.asarray(state.speed_m_s[:, np.newaxis] * ratios)

    @property
    def creep_loss_W(self) -> FloatArray:
        """Return the power that creep takes, shape (n,) [W]: what the drivers supply less what the loads take."""
        pulls_N = -self.state.effective_tension_N @ self.state.press.incidence.T
        slower_m_s = self.rim_speed_m_s - self.state.speed_m_s[:, np.newaxis]  # Σ pulls = 0
        return np.asarray((pulls_N * slower_m_s).sum(axis=-1))


def take_up(effects: Collection[str]) -> TakeUp:
    """Return what the tensioners do with these effects in, where the belts run."""
    springs, stretch = "tensioner-spring" in effects, "belt-elasticity" in effects
    if "belt-inertia" not in effects or (springs and not stretch):
        return "floating"
    return "elastic" if springs else "locked"


def solve_press(model: PressModel) -> PressAnswer:
    """Return tensions and slip of a model, and its start-up where it has one."""
    problem, task = model.problem, model.start_up
    if task is not None and "belt-elasticity" not in model.effects:
        raise InputError(
            "a start-up is carried by belts that stretch, but belt-elasticity is left out",
            code="RF502",
            key="effects",
            fix="name belt-elasticity beside transient, or leave transient out",
        )
    statics = solve_statics(model.press, closure=problem.closure)
    at: dict[str, Any] = {"preload_N": problem.preload_N, "load_factor": problem.load_factor}
    # Where the steady run has a slack span the start-up still has an answer, with belts that lift off.
    at |= {"tensioner": take_up(model.effects), "on_slack": "refuse" if task is None else "flag"}
    law: dict[str, Any] = {"friction": problem.friction, "regressors": model.regressors}
    at |= law
    state, still = (steady_state(statics, speed_m_s=way * problem.speed_m_s, **at) for way in (1.0, 0.0))
    moved = None
    if task is not None:
        moved = start_up(
            model.as_operated,
            effects=model.effects,
            follows="transient-friction" in model.effects,
            **law,
            **task,
        )
    slip = SlipTable(model.press, state.effective_tension_N, **law)
    return PressAnswer(model, statics, state, still.effective_tension_N, slip, moved)


def slip_margins(answer: PressAnswer) -> dict[str, Any]:
    """Return which roller is nearest to slip, and what would make the first one slip or the last one stop, as data."""
    model, rollers, use = answer.model, answer.slip.rollers, answer.slip.utilisation[0]
    statics = solve_statics(model.as_operated, closure=model.problem.closure)
    changes: dict[str, Any] = {}
    for change, words in CHANGES.items():
        # What a higher speed does is the belts' mass, whether or not it matters at this one.
        tensioner = take_up(model.effects | ({"belt-inertia"} if change == "speed" else set()))
        found = critical(
            statics, model.problem.friction, change, tensioner=tensioner, regressors=model.regressors
        )
        changes[change] = found._asdict() | {"unit": words.rpartition("[")[2].rstrip("]")}
    return {
        "first_to_slip": rollers[int(np.argmax(use))] if use.any() else None,
        "slips": [name for name, share in zip(rollers, use, strict=True) if share > 1.0],
        "critical": changes,
    }


_SAME_STATE = 1e-3
"""Of the greatest tension: what a start-up settles at and the steady run are one."""


def settles(answer: PressAnswer) -> dict[str, Any]:
    """Return where a start-up leads, how far that is from the steady run, and why."""
    found, steady_N, closure = answer.start_up, answer.state.tension_N[0], answer.statics.closure
    assert found is not None  # noqa: S101  (asked for by the caller)
    outcome: dict[str, Any] = {"steady": False, "differs_N": None, "span": None}
    if found.settled is None:
        ends = zip(found.press.rollers, found.at_end.tolist(), strict=True)
        names = [f"{roller.name} {what}" for roller, what in ends if what]
        why = f"at the end of the time simulated roller {', '.join(names)}" if names else ""
        return outcome | {"why": why or "drivers of different speed stretch the belts until one slips"}
    press, apart_N, largest_N = found.press, found.settled.tension_N - steady_N, np.abs(steady_N).max()
    worst = int(np.argmax(np.abs(apart_N)))
    outcome |= {"differs_N": float(apart_N[worst]), "span": press.spans[worst].name}
    if abs(apart_N[worst]) <= _SAME_STATE * largest_N:
        return outcome | {"steady": True, "why": "it settles where the steady run is"}
    slipped = ", ".join(dict.fromkeys(slip.roller for slip in found.slips))
    why = "belts that stick to their rollers from the start share the pull as their spans stretch"
    if slipped:
        why += f", displaced by the slip on roller {slipped}"
    if closure in {"share", "speed-ratio"}:
        longest_m = max(sum(belt.span_lengths_m or ()) for belt in press.belts)
        why += (
            f"; elastic creep, which is not part of a start-up, carries that over to the closure '{closure}' in some "
            f"passages of the belts, of {longest_m / float(answer.state.speed_m_s[0]):.3g} s each"
        )
    elif closure:
        why += f"; the closure '{closure}' states another share"
    if np.abs(press.pull @ apart_N).max() > _SAME_STATE * largest_N:
        why += "; its tensioners give way to the loads, where the steady run has them at the travel given"
    return outcome | {"why": why}
