"""A scene solved: the answer, its uncertainty, and what was simulated for it."""

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError
from ropefric.fitting.predict import REGRESSORS, has_interval, outside_range
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import Conditions
from ropefric.glossary import without_unit
from ropefric.plugins import provenance
from ropefric.scenes.kind import Quantity, finite, value_at
from ropefric.scenes.plan import Plan, method_tree, nearly_whole, solve_planned
from ropefric.scenes.scene import Scene, placed
from ropefric.shown import Shown, in_words
from ropefric.systems.effect import assemble
from ropefric.uncertainty.budget import check_level, directions

_STEP = 1e-3
"""Of a standard error, for the derivative along a direction: its square is the error of a central difference."""


class Uncertain(NamedTuple):
    """A number of an answer with its uncertainty."""

    name: str
    value: FloatArray
    std: FloatArray
    interval: FloatArray
    is_main: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solution(Shown):
    """The answer to a scene.

    Attributes
    ----------
    scene : Scene
        What was asked.
    plan : Plan
        What was simulated, and how.
    answer : object
        Of the scene's system.
    quantities : tuple of Uncertain
        The numbers that people read.
    level : float
        Of the intervals.
    extrapolation : tuple of str
        In which respects the friction is used outside what it was tested for.
    failures : tuple of str
        What the machine does not do, however well that is known: a hoist that does not lift.
    undecided : tuple of str
        Which yes or no may be another with the effects that are left out: of those asked for by name none is added.
    own_bounds : dict of str to float
        How far the effects left out may put off a number, in its unit: each number of a list of effects; else those for
        which the relative bound does not hold.
    tree : dict
        What the machine's kind adds to the JSON shape.
    """

    _said = ("system=scene.kind.name", "stands", "plan.simulated", "plan.left_out", "warnings")
    _framed = "_numbers"

    def _numbers(self) -> list[dict[str, Any]]:
        found = []
        for one in self.quantities:
            row = {
                "value": one.value[0],
                "std": one.std[0],
                "low": one.interval[0, 0],
                "high": one.interval[0, 1],
            }
            found.append({"quantity": one.name} | {name: float(number) for name, number in row.items()})
        return found

    def _more_said(self) -> Iterator[tuple[str, str]]:
        for row in self._numbers():
            name, unit = without_unit(row["quantity"])
            yield name.replace("_", " "), in_words(row["value"], unit, row["std"])

    scene: Scene
    plan: Plan
    answer: Any
    quantities: tuple[Uncertain, ...]
    level: float
    extrapolation: tuple[str, ...]
    failures: tuple[str, ...]
    undecided: tuple[str, ...]
    own_bounds: dict[str, float]
    tree: dict[str, Any]

    @property
    def stands(self) -> bool:
        """Return whether the friction is supported, the accuracy kept, and the machine does what it is for."""
        source = self.scene.source
        doubts = self.failures or self.undecided or (source is not None and source.warnings)
        return self.plan.keeps_accuracy and not doubts

    @property
    def beyond_bound(self) -> list[str]:
        """Return the parts of the tree that the bound does not cover, where something is left out."""
        if not self.plan.left_out:
            return []
        return [name for name in self.scene.kind.beyond if value_at(self.tree, name) is not None]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return what speaks against using the answer, or the machine."""
        source, plan = self.scene.source, self.plan
        found = [*self.failures, *(() if source is None else source.warnings)]
        found += [f"not decided without the effects left out: {words}" for words in self.undecided]
        found += [f"extrapolated: {words}" for words in self.extrapolation]
        if not plan.keeps_accuracy:
            bound = "not known" if math.isinf(plan.error_bound) else f"up to {plan.error_bound:.2g}"
            cause = f"leaving out {', '.join(plan.left_out)}"
            if not plan.left_out or plan.method.error > plan.accuracy:
                cause = f"the method ({plan.method.name})"
            found.append(f"the error of {cause} is {bound}, more than the accuracy of {plan.accuracy:g}")
        return tuple(found)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON shape; numbers without a finite value are null."""
        plan, source = self.plan, self.scene.source
        tree = {"system": self.scene.kind.name, **deepcopy(self.tree)}
        for quantity in self.quantities:
            _put(tree, quantity)
        return tree | {
            "level": self.level,
            "extrapolated": bool(self.extrapolation),
            "effects": {
                "simulated": list(plan.simulated),
                "left_out": list(plan.left_out),
                "not_applicable": [one.name for one in plan.decisions if one.fate == "not applicable"],
            },
            "accuracy": plan.accuracy,
            "error_bound": finite(plan.error_bound),
            "beyond_bound": self.beyond_bound,
            "own_bounds": {name: finite(bound) for name, bound in self.own_bounds.items()},
            "method": method_tree(plan.method),
            "friction": None if source is None else source.origin,
            "failures": list(self.failures),
            "undecided": list(self.undecided),
            "warnings": list(self.warnings),
            **({"plugins": used} if (used := provenance("KIND", "LAW")) else {}),
        }


def _put(tree: Any, quantity: Uncertain) -> None:
    """Put a number at its place: "slip.2.utilisation" goes under slip, under "2"."""
    *path, name = quantity.name.split(".")
    for part in path:
        tree = tree[int(part)] if isinstance(tree, list) else tree.setdefault(part, {})
    tree[name] = finite(quantity.value[0])
    if quantity.std[0] == 0.0:
        return
    # The main answer has the contract's bare names; the others carry their own.
    stem, unit = (name[:-2], "_N") if name.endswith("_N") else (name, "")
    prefix = "" if quantity.is_main else f"{stem}_"
    tree[f"{prefix}std{unit}"] = finite(quantity.std[0])
    tree[f"{prefix}interval{unit}"] = [finite(end) for end in quantity.interval[0]]


def solve_scene(scene: Scene, *, level: float = 0.95) -> Solution:
    """Return the answer to a scene."""
    check_level(level)
    kind, problem = scene.kind, scene.problem
    with placed(scene.document):
        plan, answer = solve_planned(scene, problem)
        quantities, error = kind.quantities(answer, problem), plan.error_bound
        failures = [one for one in kind.failures(answer, problem) if not one.counted]
        undecided: tuple[str, ...] = ()
        if plan.left_out and math.isfinite(error):
            undecided = tuple(one.text(0) for one in failures if one.is_open(error)[0])
            undecided += kind.undecided(answer, problem, error)
        return Solution(
            scene=scene,
            plan=plan,
            answer=answer,
            quantities=_uncertain(scene, plan, quantities, level),
            level=level,
            extrapolation=_extrapolation(scene),
            failures=tuple(one.text() for one in failures if one.fails.any()),
            undecided=undecided,
            own_bounds=_own_bounds(scene, plan, answer, quantities),
            tree=kind.tree(answer, problem),
        )


def _own_bounds(scene: Scene, plan: Plan, answer: Any, quantities: tuple[Quantity, ...]) -> dict[str, float]:
    """Return the possible error of each number by effects left out, in its unit.

    For a list of effects it is the difference to the answer with all, plus the bound of the expensive ones.
    """
    if not plan.left_out:
        return {}
    error, kind = plan.error_bound, scene.kind
    found = {one.name: error * abs(float(one.scale[0])) for one in quantities if one.scale is not None}
    if isinstance(scene.effects, tuple):
        with suppress(RopefricError):
            whole, rest = nearly_whole(kind.system, scene.problem, plan, answer)
            share = math.expm1(rest) + plan.method.error
            wanted = {one.name: float(one.value[0]) for one in kind.quantities(whole, scene.problem)}
            for one in quantities:
                value, all_in = float(one.value[0]), wanted.get(one.name, math.nan)
                found[one.name] = (
                    abs(value - all_in) + share * abs(all_in) if value != all_in else share * abs(value)
                )
    return found


def _extrapolation(scene: Scene) -> tuple[str, ...]:
    """Return one sentence for each regressor that leaves the tested range anywhere."""
    source = scene.source
    if source is None or source.tested is None:
        return ()
    contacts = Conditions(**scene.kind.contacts(scene.problem))
    outside = outside_range(source.tested, contacts)
    words = []
    for column, (name, (what, unit, factor)) in enumerate(REGRESSORS.items()):
        if outside[:, column].any():
            found = factor * getattr(contacts, name)[outside[:, column]]
            low, high = (factor * end for end in source.tested[name])
            words.append(
                f"{what} {_span(found.min(), found.max())} {unit} is outside the tested {_span(low, high)} {unit}"
            )
    return tuple(words)


def _span(low: float, high: float) -> str:
    return f"{low:.4g}" if f"{low:.4g}" == f"{high:.4g}" else f"{low:.4g}–{high:.4g}"


def _uncertain(
    scene: Scene, plan: Plan, nominal: tuple[Quantity, ...], level: float
) -> tuple[Uncertain, ...]:
    """Return the answer's numbers with their uncertainty because the friction was fitted, to first order: g C gᵀ.

    The gradient is taken along the principal directions of the covariance, by central differences: two solutions
    a parameter. Forces and coefficients are taken in their logarithm. The degrees of freedom are those that `predict`
    gives the number. Without a fit the numbers are certain;
    a covariance that is not known leaves every number without an error.
    """
    kind, source, problem = scene.kind, scene.source, scene.problem
    if source is None or source.fit is None:
        return tuple(_with_std(one, np.zeros_like(one.value), 0.0) for one in nominal)
    fit, friction = source.fit, source.friction
    unknown = tuple(_with_std(one, np.full_like(one.value, np.nan), np.nan) for one in nominal)
    if not (has_interval(fit) and np.isfinite(fit.covariance).all()):
        return unknown
    columns = directions(fit.covariance)
    columns = columns[:, columns.any(axis=0)]

    def solved(change: FloatArray) -> tuple[Quantity, ...]:
        other = replace(problem, friction=replace(friction, theta=friction.theta + change))
        model = assemble(kind.system, other, plan.simulated)
        return kind.quantities(kind.system.solve(model, plan.method), other)

    try:
        ends = [(solved(step), solved(-step)) for step in _STEP * columns.T]
    except RopefricError:
        return unknown  # a law at the edge of where it has an answer has no slope there
    spread_of, found = _spreads(fit, columns, level), []
    for place, one in enumerate(nominal):
        slopes = [_slope(up[place], down[place]) for up, down in ends]
        std, reach = spread_of(np.array(slopes).reshape(len(ends), one.value.size))
        found.append(_with_std(one, std.reshape(one.value.shape), reach.reshape(one.value.shape)))
    return tuple(found)


def _spreads(
    fit: FitResult, columns: FloatArray, level: float
) -> Callable[[FloatArray], tuple[FloatArray, FloatArray]]:
    """Return what makes standard deviation and reach, in these, of slopes along the directions of a covariance."""
    size = np.maximum(np.abs(columns).max(axis=1, initial=0.0), np.finfo(float).tiny)[:, None]
    common = np.linalg.lstsq(columns / size, fit.common_changes / size, rcond=None)[0]
    # A slope along the directions is that by the parameters, as far as these are uncertain.
    back = np.linalg.pinv(columns / size) / size.T

    def spread(along: FloatArray) -> tuple[FloatArray, FloatArray]:
        variance, known = (along**2).sum(axis=0), ((common.T @ along) ** 2).sum(axis=0)
        reach = fit.scatter.reach(0.5 + 0.5 * level, variance, along.T @ back, known=known)
        return np.sqrt(variance), reach

    return spread


def _slope(up: Quantity, down: Quantity) -> FloatArray:
    """Return the slope between two solutions: 0 of what the friction leaves as it is, zero and infinite as well."""
    with np.errstate(invalid="ignore"):
        apart = _read(up) - _read(down)
    return np.where(up.value == down.value, 0.0, apart) / (2.0 * _STEP)


def _read(quantity: Quantity) -> FloatArray:
    with np.errstate(divide="ignore"):
        return np.log(quantity.value) if quantity.positive else quantity.value


def _with_std(quantity: Quantity, std: FloatArray, reach: npt.ArrayLike) -> Uncertain:
    value, ends = quantity.value, np.stack([quantity.value] * 2, axis=-1)
    if std.any():
        middle, half = _read(quantity), np.asarray(reach) * std
        ends = np.stack([middle - half, middle + half], axis=-1)
        if quantity.positive:
            std, ends = value * std, np.exp(ends)
    return Uncertain(quantity.name, value, std, ends, quantity.is_main)
