"""A scene solved for draws of what it is not sure of: the parameters of its friction, and what has a tolerance.

The parameters of a fit are drawn together from its covariance, with its degrees of freedom; what `[tolerances]` says
is a limit of error, so any value within it is as likely. A draw depends on the seed and its place alone.
"""

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ropefric.arrays import FloatArray, IntArray
from ropefric.errors import InputError
from ropefric.fitting.predict import EXTRAPOLATED, degrees_of_freedom, has_interval
from ropefric.fitting.result import FitStatus
from ropefric.scenes.kind import finite, value_at
from ropefric.scenes.plan import solve_planned
from ropefric.scenes.points import BLOCK, MOST_CASES, Answers, Points, Progress, solve_points
from ropefric.scenes.scene import Scene, placed, unit_of
from ropefric.scenes.sweep import Axis, parse_axis
from ropefric.uncertainty.budget import check_level, joint_draws, symmetric_root

FEWEST_DRAWS = 10
_OWN_PARAMETERS = "friction.parameters."


class _Friction(NamedTuple):
    """The parameters of a scene's law, and how they scatter: together, and each within its tolerance."""

    names: tuple[str, ...]
    theta: FloatArray
    half: FloatArray
    root: FloatArray = np.zeros((0, 0))
    dof: float = math.inf
    bounds: tuple[FloatArray | float, FloatArray | float] = (-math.inf, math.inf)


class _Draws(Points):
    """The cases of a scene that are drawn; see `points.Points`."""

    option = "--draws"
    what = "draw"
    fix = "check the tolerances and the covariance of the fit"

    def __init__(self, scene: Scene, count: int, seed: int) -> None:
        self.shape, self.seed, self.friction = (count,), seed, _friction(scene)
        law = self.friction.names if self.friction else ()
        own = {"friction.mu", *(_OWN_PARAMETERS + name for name in law)}
        self.axes = tuple(_ends(scene, key) for key in scene.tolerances if not (law and key in own))
        self.keys = tuple(axis.key for axis in self.axes)
        if not law and not self.keys:
            raise InputError(
                "nothing in the scene is uncertain: no tolerances, no fit",
                key="--draws",
                fix='add [tolerances] with, say, wheel.wrap = "5 deg", or the friction of a fit',
            )
        self.columns = (*(axis.label for axis in self.axes), *(f"friction.{name}" for name in law))

    def at(self, places: IntArray) -> list[FloatArray]:
        """Return the draws at places of one block; of more, other ones."""
        block, own, friction = int(places[0]) // BLOCK, places % BLOCK, self.friction
        flat = _flat(self.seed, block, len(self.axes))[own].T
        found = [
            axis.values.mean() + 0.5 * np.ptp(axis.values) * one
            for axis, one in zip(self.axes, flat, strict=True)
        ]
        if friction is not None:
            theta = friction.theta + _flat(self.seed, block, friction.theta.size, 2)[own] * friction.half
            if friction.root.size:
                scattered = _scattered(self.seed, block, *friction.root.shape, friction.dof)[own]
                theta = np.clip(theta + scattered @ friction.root.T, *friction.bounds)
            found.append(theta)
        return found

    def drawn(self) -> dict[str, FloatArray]:
        """Return what was drawn, in the units of the scene."""
        places = np.arange(self.shape[0])
        blocks = [self.at(places[start : start + BLOCK]) for start in range(0, places.size, BLOCK)]
        values = [np.concatenate(parts) for parts in zip(*blocks, strict=True)]
        found = [one / axis.factor for axis, one in zip(self.axes, values, strict=False)]
        found += list(values[-1].T) if self.friction else []
        return dict(zip(self.columns, found, strict=True))


def _ends(scene: Scene, key: str) -> Axis:
    """Return what the value of a key lies between, where the scene is one."""
    value, written = float(value_at(scene.table, key)), value_at(scene.document.data, key)
    unit, number = unit_of(written) if isinstance(written, str) else ("", value)
    factor = value / number if unit and number else 1.0
    low, high = ((value + way * scene.tolerances[key]) / factor for way in (-1.0, 1.0))
    return parse_axis(scene, f"{key}={low!r} {unit},{high!r} {unit}")


@lru_cache(maxsize=4)
def _flat(seed: int, block: int, size: int, stream: int = 0) -> FloatArray:
    return np.random.default_rng([seed, block, stream]).uniform(-1.0, 1.0, (BLOCK, size))


@lru_cache(maxsize=2)
def _scattered(seed: int, block: int, size: int, columns: int, dof: float) -> FloatArray:
    """Return draws of a standard t, and behind them of the normal for infinite degrees of freedom, (n, columns)."""
    rng = np.random.default_rng([seed, block, 1])
    own = joint_draws(np.zeros(size), np.eye(size), dof=dof, n=BLOCK, rng=rng)
    return np.hstack([own, rng.standard_normal((BLOCK, columns - size))])


def _friction(scene: Scene) -> _Friction | None:
    """Return how the parameters of a scene's law scatter; None where they do not.

    As in a prediction: by t of the fit's covariance, but for the part that common errors make, which is normal, and
    moved onto the law's bounds where they cross them.
    """
    source = scene.source
    if source is None:
        return None
    law, theta, fit = source.friction.law, source.friction.theta, source.fit
    own = {"friction.mu": 0} | {_OWN_PARAMETERS + name: i for i, name in enumerate(law.parameter_names)}
    half = np.zeros(theta.size)
    for key in own.keys() & scene.tolerances.keys():
        half[own[key]] = scene.tolerances[key]
    if fit is None:
        return _Friction(law.parameter_names, theta, half) if half.any() else None
    if not (has_interval(fit) and np.isfinite(fit.covariance).all()):
        raise InputError(
            "the covariance of the fit is not known, so nothing can be drawn from it",
            key="friction.fit",
            fix="measure the conditions that would show all parameters, or fit a simpler law",
        )
    if fit.status is FitStatus.UNIDENTIFIABLE:
        # They lie in a curved valley, of which the covariance is the tangent: far along it are no forces.
        raise InputError(
            f"the data do not determine all parameters of {fit.law}, so draws of them are not draws of its forces",
            key="friction.fit",
            fix="solve without draws, which states the interval of the forces, or fit a simpler law",
        )
    common = fit.common_changes
    root = np.hstack([symmetric_root(np.asarray(fit.covariance) - common @ common.T), common])
    bounds = np.minimum(law.lower, theta), np.maximum(law.upper, theta)
    return _Friction(law.parameter_names, theta, half, root, degrees_of_freedom(fit), bounds)


class Drawn(NamedTuple):
    """Statistics of one number over draws: the answer at the values as given, mean, standard deviation and quantiles."""

    value: float
    mean: float
    std: float
    quantiles: tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Draws(Answers):
    """The answers to draws of what a scene is not sure of.

    Attributes
    ----------
    system : str
        Name of the system.
    count, seed : int
        How many draws, and what they begin with: the first thousand are the same whatever the count.
    level : float
        Of the outer quantiles: at 0.95 those of 2.5 % and 97.5 %, beside the median.
    numbers : mapping of str to Drawn
        Of each number of the answer: its value as the scene has it, and mean, standard deviation and quantiles of the
        draws.
    drawn : mapping of str to ndarray
        What was drawn, in the units of the scene.
    columns : mapping of str to ndarray
        The numbers of the draws, NaN where a draw has no answer.
    failed, first_failure, simulated, error_bound, accuracy, failures, left_out, extrapolated_at
        As of a `Sweep`.
    doubts : tuple of str
        What speaks against the friction.
    """

    _said = ("system", "count", "seed", "simulated", "error_bound", "failed", "warnings")
    _framed = "columns"

    system: str
    count: int
    seed: int
    level: float
    numbers: dict[str, Drawn]
    drawn: dict[str, FloatArray]
    doubts: tuple[str, ...] = field(default=())

    @property
    def table(self) -> dict[str, FloatArray]:
        """Return the table, one row a draw: what was drawn, and the numbers."""
        return self.drawn | self.columns

    @property
    def answered(self) -> int:
        """Return how many draws have an answer."""
        return self.count - self.failed

    @property
    def unanswered(self) -> tuple[str, ...]:
        """Return in words how many draws have no answer; empty where all have one."""
        words = f"{self.failed} of {self.count} draws have no answer; the first says: {self.first_failure}"
        return (words,) if self.failed else ()

    @property
    def shares(self) -> dict[str, float]:
        """Return in which share of the draws that have an answer the machine does not do what it is for, and how."""
        return {words: n / self.answered for words, n in self.failures.items()}

    @property
    def stands(self) -> bool:
        """Return whether the accuracy is kept and the friction is supported."""
        return self.keeps_accuracy and not self.doubts

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return what speaks against using the answers, and where the machine does not do what it is for."""
        return (*self.doubts, *self.unanswered, *self._warnings(f"in {{}} of {self.count} draws"))

    def to_dict(self) -> dict[str, Any]:
        """Return the summary as a JSON tree."""
        tail = 50.0 * (1.0 - self.level)
        numbers: dict[str, Any] = {}
        for name, (value, mean, std, quantiles) in self.numbers.items():
            moments = {"value": value, "mean": mean, "std": std}
            numbers[name] = {part: finite(one) for part, one in moments.items()}
            numbers[name] |= {"quantiles": [finite(end) for end in quantiles]}
        failures = {words: {"count": n, "share": self.shares[words]} for words, n in self.failures.items()}
        return {
            "system": self.system,
            "draws": self.count,
            **{name: getattr(self, name) for name in ("seed", "level", "answered", "first_failure")},
            "drawn": list(self.drawn),
            "quantiles_percent": [round(tail, 9), 50.0, round(100.0 - tail, 9)],
            "quantities": numbers,
            "failures": failures,
            "effects": {"simulated": list(self.simulated), "left_out_in": self.left_out},
            "extrapolated_in": self.extrapolated_at,
            "accuracy": self.accuracy,
            "error_bound": finite(self.error_bound),
            "warnings": list(self.warnings),
        }


def draw_scene(
    scene: Scene,
    count: int,
    *,
    seed: int = 0,
    level: float = 0.95,
    progress: Progress | None = None,
    executor: Any = None,
) -> Draws:
    """Return what a scene answers to draws of what it is not sure of, planned once, solved here or by an executor."""
    check_level(level)
    if not FEWEST_DRAWS <= count <= MOST_CASES or seed < 0:
        raise InputError(
            f"{count} draws with seed {seed}",
            key="--draws",
            fix=f"choose {FEWEST_DRAWS} to {MOST_CASES} draws and a seed from 0",
        )
    kind, problem, points = scene.kind, scene.problem, _Draws(scene, count, seed)
    with placed(scene.document):
        answer = solve_planned(scene, problem)[1]
        as_given = (*kind.quantities(answer, problem), *kind.outcomes(answer, problem))
        found = solve_points(scene, points, progress=progress, executor=executor)
    values = {one.name: float(one.value[0]) for one in as_given}
    at = (0.5 - 0.5 * level, 0.5, 0.5 + 0.5 * level)
    numbers = {}
    for name, column in found["columns"].items():
        if name == EXTRAPOLATED:  # counted
            continue
        known = column[~np.isnan(column)]
        ends = (math.nan, math.nan, math.nan)
        mean = std = math.nan
        # Between two that are infinite lies no number, and the square of a very large one is no float.
        with np.errstate(invalid="ignore", over="ignore"):
            if known.size:
                mean, ends = float(known.mean()), tuple(np.quantile(known, at).tolist())
            if known.size > 1:
                std = float(known.std(ddof=1))
            if known.size > 1 and np.ptp(known) == 0.0:  # the sum of many equal numbers is rounded
                mean, std = float(known[0]), 0.0
        numbers[name] = Drawn(values.get(name, math.nan), mean, std, ends)
    asked: dict[str, Any] = {"system": kind.name, "count": count, "seed": seed, "level": level}
    doubts = () if scene.source is None else scene.source.warnings
    return Draws(numbers=numbers, drawn=points.drawn(), doubts=doubts, **asked, **found)
