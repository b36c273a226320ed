"""A press as assembled from its effects, and its tensions, slip and start-up."""

from dataclasses import dataclass, field, replace

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.machine import Press
from ropefric.systems.press.slip import SlipTable, slip_table, steady_contacts
from ropefric.systems.press.statics import Statics, solve_statics
from ropefric.systems.press.steady import Parts, SteadyState, respond
from ropefric.systems.press.transient.ingredients import Ingredients
from ropefric.systems.press.transient.integrators import Settings
from ropefric.systems.press.transient.polynomial import PiecewisePolynomial
from ropefric.systems.press.transient.result import StartUp
from ropefric.systems.press.transient.start_up import start_up
from ropefric.systems.spread import Rule, spread


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StartUpTask:
    """A start-up to be simulated."""

    speed: PiecewisePolynomial
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
        for name, array in spread({name: getattr(self, name) for name in _RULES}, _RULES).items():
            object.__setattr__(self, name, array)
        if self.start_up is not None and self.n > 1:
            raise InputError(
                "a start-up is simulated for one operating point", fix="give one speed and preload"
            )

    @property
    def n(self) -> int:
        """Return how many operating points there are."""
        return self.speed_m_s.size


_RULES: dict[str, Rule] = {
    "speed_m_s": "zero or more",
    "preload_N": "zero or more",
    "load_factor": "zero or more",
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PressModel:
    """A press as assembled from its effects."""

    press: Press
    closure: str
    friction: WrapFriction
    told: frozenset[str]
    speed_m_s: FloatArray
    preload_N: FloatArray | None
    load_factor: FloatArray
    parts: Parts
    ingredients: Ingredients
    start_up: StartUpTask | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PressAnswer:
    """The steady run of a press, and its start-up where one was asked for."""

    model: PressModel
    statics: Statics
    state: SteadyState
    at_rest_N: FloatArray
    slip: SlipTable
    start_up: StartUp | None = None


def solve_press(model: PressModel) -> PressAnswer:
    """Return tensions and slip of a model, and its start-up where it has one."""
    statics = solve_statics(model.press, closure=model.closure)
    state = respond(
        model.parts,
        statics,
        preload_N=model.preload_N,
        speed_m_s=model.speed_m_s,
        load_factor=model.load_factor,
    )
    at_rest = respond(
        Parts(),
        statics,
        preload_N=model.preload_N,
        speed_m_s=np.zeros_like(model.speed_m_s),
        load_factor=model.load_factor,
    )
    contacts = steady_contacts(state)
    return PressAnswer(
        model=model,
        statics=statics,
        state=state,
        at_rest_N=at_rest.effective_tension_N,
        slip=slip_table(contacts, model.friction, told=model.told),
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
        friction=model.friction,
        slip=task.slip,
        loads="constant" if task.loads == "constant" else "with-speed",
        ingredients=model.ingredients,
        integrator=task.integrator,
        settings=task.settings,
    )


def as_operated(model: PressModel) -> Press:
    """Return the machine with the preload and the loads of its operating point."""
    factor = float(model.load_factor[0])
    rollers = []
    for roller in model.press.rollers:
        tensioner = roller.tensioner
        if tensioner is not None and model.preload_N is not None:
            tensioner = replace(tensioner, force_N=float(model.preload_N[0]))
        rollers.append(
            replace(
                roller,
                tensioner=tensioner,
                gravity_torque_N_m=factor * roller.gravity_torque_N_m,
                squeeze_torque_N_m=factor * roller.squeeze_torque_N_m,
            )
        )
    return replace(model.press, rollers=tuple(rollers))
