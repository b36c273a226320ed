"""A press as assembled from its effects, and its tensions, slip and start-up."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.interpolate import PPoly

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.checks import Rule, side_by_side
from ropefric.systems.effect import Model
from ropefric.systems.friction import WrapFriction, told_by
from ropefric.systems.press.creep import rim_speed_ratios
from ropefric.systems.press.machine import Press
from ropefric.systems.press.slip import SlipTable, slip_table, steady_contacts
from ropefric.systems.press.statics import Statics, incidence, solve_statics
from ropefric.systems.press.steady import Parts, SteadyState, respond
from ropefric.systems.press.transient.integrators import Settings
from ropefric.systems.press.transient.start_up import StartUp, start_up


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StartUpTask:
    """A start-up to be simulated."""

    speed: PPoly
    time_s: FloatArray
    slip: bool
    loads: str
    integrator: str = "exact"
    settings: Settings = field(default_factory=Settings)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PressProblem:
    """A press at n operating points; scalars are spread."""

    press: Press
    closure: str
    friction: WrapFriction
    speed_m_s: FloatArray
    preload_N: FloatArray | None = None
    load_factor: FloatArray
    start_up: StartUpTask | None = None

    def __post_init__(self) -> None:
        rules: dict[str, Rule] = dict.fromkeys(("speed_m_s", "preload_N", "load_factor"), "zero or more")
        for name, array in side_by_side({name: getattr(self, name) for name in rules}, rules).items():
            object.__setattr__(self, name, array)
        if self.start_up is not None and self.n > 1:
            raise InputError(
                "a start-up is simulated for one operating point", fix="give one speed and preload"
            )

    @property
    def n(self) -> int:
        """Return how many operating points there are."""
        return self.speed_m_s.size


LOADS = {"gravity-load": "gravity_torque_N_m", "squeeze-load": "squeeze_torque_N_m"}
"""The torque of a roller that each effect is about."""


def without_load(press: Press, effect: str) -> Press:
    """Return a press whose rollers do not feel one of the loads."""
    nothing: dict[str, Any] = {LOADS[effect]: 0.0}
    return replace(press, rollers=tuple(replace(roller, **nothing) for roller in press.rollers))


class PressModel(Model[PressProblem]):
    """A press with the effects that are in it; without any: no loads or mass, locked tensioners, one coefficient."""

    @cached_property
    def press(self) -> Press:
        """Return the machine with the loads that are in."""
        press = self.problem.press
        for effect in LOADS.keys() - self.effects:
            press = without_load(press, effect)
        return press

    @property
    def told(self) -> frozenset[str]:
        """Return what the law is told of a contact."""
        return told_by(self.effects)

    @property
    def parts(self) -> Parts:
        """Return what resists and what gives way when the belts run."""
        return Parts(
            mass="belt-inertia" in self.effects,
            springs="tensioner-spring" in self.effects,
            stretch="belt-elasticity" in self.effects,
        )

    @property
    def start_up(self) -> StartUpTask | None:
        """Return the start-up to be simulated, where it is."""
        return self.problem.start_up if "transient" in self.effects else None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PressAnswer:
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
            has_mass = self.model.parts.mass
            ratios = rim_speed_ratios(state.press, state.tension_N if has_mass else state.effective_tension_N)
        return np.asarray(state.speed_m_s[:, np.newaxis] * ratios)

    @property
    def creep_loss_W(self) -> FloatArray:
        """Return the power that creep takes, shape (n,) [W]: what the drivers supply less what the loads take."""
        pulls_N = -self.state.effective_tension_N @ incidence(self.state.press).T
        slower_m_s = self.rim_speed_m_s - self.state.speed_m_s[:, np.newaxis]  # Σ pulls = 0
        return np.asarray((pulls_N * slower_m_s).sum(axis=-1))


def solve_press(model: PressModel) -> PressAnswer:
    """Return tensions and slip of a model, and its start-up where it has one."""
    problem = model.problem
    statics = solve_statics(model.press, closure=problem.closure)
    state, still = (
        respond(
            parts, statics, preload_N=problem.preload_N, speed_m_s=speed_m_s, load_factor=problem.load_factor
        )
        for parts, speed_m_s in ((model.parts, problem.speed_m_s), (Parts(), 0.0 * problem.speed_m_s))
    )
    return PressAnswer(
        model=model,
        statics=statics,
        state=state,
        at_rest_N=still.effective_tension_N,
        slip=slip_table(steady_contacts(state), problem.friction, told=model.told),
        start_up=None if model.start_up is None else _started(model, model.start_up),
    )


def _started(model: PressModel, task: StartUpTask) -> StartUp:
    if not model.parts.stretch:
        raise InputError(
            "a start-up is carried by belts that stretch, but belt-elasticity is left out",
            code="RF502",
            key="effects",
            fix="name belt-elasticity beside transient, or leave transient out",
        )
    return start_up(
        as_operated(model),
        speed=task.speed,
        time_s=task.time_s,
        friction=model.problem.friction,
        slip=task.slip,
        loads="constant" if task.loads == "constant" else "with-speed",
        effects=model.effects,
        integrator=task.integrator,
        settings=task.settings,
    )


def as_operated(model: PressModel) -> Press:
    """Return the machine with the preload and the loads of its operating point."""
    factor, preload_N = float(model.problem.load_factor[0]), model.problem.preload_N
    rollers = []
    for roller in model.press.rollers:
        changes: dict[str, Any] = {name: factor * getattr(roller, name) for name in LOADS.values()}
        if roller.tensioner is not None and preload_N is not None:
            changes["tensioner"] = replace(roller.tensioner, force_N=float(preload_N[0]))
        rollers.append(replace(roller, **changes))
    return replace(model.press, rollers=tuple(rollers))
