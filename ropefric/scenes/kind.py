"""What makes a system a kind of scene: its TOML keys, and its answer in words and numbers."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ropefric.arrays import BoolArray, FloatArray
from ropefric.scenes.schema import SceneTable
from ropefric.systems.effect import System
from ropefric.systems.friction import WrapFriction


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Quantity:
    """One number of an answer that people read, and that friction may make uncertain."""

    name: str
    value: FloatArray
    positive: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Failure:
    """A way in which a machine does not do what it is for, however well that is known."""

    words: str
    measure: str
    value: FloatArray
    fails: BoolArray

    def text(self) -> str:
        """Return what the first case that fails does not do."""
        return f"{self.words}: {self.measure} {float(self.value[self.fails][0]):.3g}"


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepField:
    """A key of the scene that takes many values in one call."""

    field: str
    factor: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """A kind of scene.

    Attributes
    ----------
    name : str
        What `system = "…"` says.
    schema : type of SceneTable
        Its TOML keys.
    system : System
        Its effects and mechanics.
    own_wheel : callable
        `own_wheel(table)` returns the wheel radius and the rope radius [m] that a law without reference refers to.
    problem : callable
        `problem(table, friction)` returns the problem, a dataclass with a field `friction`; None where the scene
        gives none.
    quantities : callable
        `quantities(answer, problem)` returns the numbers that people read; none of them is uncertain where no
        friction enters.
    tree : callable
        `tree(answer, problem)` returns the JSON shape of the answer, without what all scenes share.
    contacts : callable
        `contacts(problem)` returns the conditions at which the friction is used, as a mapping from the regressor's
        name to an array; for telling an extrapolation.
    sweep_fields : mapping
        Keys that can be swept in one call.
    failures : callable
        `failures(answer, problem)` returns the ways in which the machine may not do what it is for.
    in_one_call : callable
        `in_one_call(problem)` returns whether a problem can be solved for many cases at once.
    answerable : callable
        `answerable(problem)` returns for which of many cases there is an answer, as far as that shows without
        solving them.
    scene_key : callable
        `scene_key(name)` returns the key of the scene behind a name that an error of the system gives; the name
        itself where there is none.

    Examples
    --------
    >>> from ropefric.scenes.kinds import KINDS
    >>> KINDS["hoist"].sweep_fields["wheel.wrap"].field
    'wrap_angle_rad'
    """

    name: str
    schema: type[SceneTable]
    system: System[Any, Any, Any]
    own_wheel: Callable[[Any], tuple[float, float]]
    problem: Callable[[Any, WrapFriction | None], Any]
    quantities: Callable[[Any, Any], tuple[Quantity, ...]]
    tree: Callable[[Any, Any], dict[str, Any]]
    contacts: Callable[[Any], Mapping[str, FloatArray]]
    sweep_fields: Mapping[str, SweepField]
    answerable: Callable[[Any], BoolArray]
    scene_key: Callable[[str], str]
    failures: Callable[[Any, Any], tuple[Failure, ...]] = lambda answer, problem: ()  # noqa: ARG005  (none known)
    in_one_call: Callable[[Any], bool] = lambda problem: True  # noqa: ARG005  (every problem)
