"""Elements of a line, the rope data that they get, and the contact of a rope with one of them."""

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Annotated, ClassVar, NamedTuple, Self, get_type_hints

import numpy as np
from scipy.special import exprel

from ropefric.arrays import FloatArray
from ropefric.errors import RopefricError, SolverError
from ropefric.friction.laws.bending import bending_N
from ropefric.systems.checks import Cases, Positive, ZeroOrMore, refuse
from ropefric.systems.effect import Model
from ropefric.systems.friction import WrapFriction, own_regressors, refuse_no_ratio
from ropefric.systems.hoist.contact import GRAVITY_M_S2, contact_arc_rad

_MAX_STEPS = 200
_SETTLED = 1e-15
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_BEND_M = frozenset({"wrap-dependence", "end-tension", "offset"})
"""Effects of a law that make M not proportional to the wrap."""
# A coefficient that depends on the wrap may be infinite at the slack end: nodes that crowd there see that.
_SHARES, _PARTS = (0.5 * (1.0 + _NODES)) ** 3, 1.5 * (0.5 * (1.0 + _NODES)) ** 2 * _WEIGHTS


class Given(NamedTuple):
    """A key of an element: what it means, the unit it is read in with an example, and which values it may have.

    `above` is what a value must be more than, None for any; `or_zero` lets it be 0 as well.
    """

    key: str
    meaning: str
    si_unit: str = ""
    like: str = ""
    above: float | None = 0.0
    or_zero: bool = False
    at_most: float = math.inf


Mu = Annotated[float | None, Given("mu", "coefficient of this element alone.", or_zero=True)]
Radius = Annotated[
    float | None, Given("radius", "of what the rope lies on; for the side pressure.", "m", "300 mm")
]
Wobble = Annotated[
    float | None, Given("wobble", "k, unintended angle per length of a duct or sheath.", "1/m", "0.01 rad/m")
]
Length = Annotated[float | None, Given("length", "along the rope.", "m", "30 m")]


@dataclass(frozen=True, kw_only=True)
class Element:
    """Something a rope passes, which changes its tension.

    A kind of element is a file in `elements` that declares `ELEMENT`, a frozen dataclass with this as its base: its
    fields are annotated with the keys they are `Given` by.

    Attributes
    ----------
    kind : str
        Its name in scenes.
    over : str
        What a utilisation above 1 means, in words.
    """

    kind: ClassVar[str]
    over: ClassVar[str] = ""

    name: str

    def tension_N(self, passage: "Passage", known_N: FloatArray) -> FloatArray:
        """Return the tension on the side on which it is not known, shape (n,)."""
        raise NotImplementedError

    def numbers(self, passage: "Passage", in_N: FloatArray, out_N: FloatArray) -> dict[str, FloatArray]:  # noqa: ARG002
        """Return more numbers of it by name, from the tensions before and after it: `normal_N_m`, `utilisation`."""
        return {}

    @property
    def effects(self) -> frozenset[str]:
        """Return the effects of which it has the data."""
        return frozenset()

    def missing(self) -> str:
        """Return what the scene has to give beside what it gives; empty where nothing is missing."""
        return ""

    def turned(self) -> Self:
        """Return the element as the rope meets it from the other end."""
        return self

    @property
    def stretching_m(self) -> float:
        """Return the length of rope in it that stretches and is pulled through [m]."""
        return getattr(self, "length_m", None) or 0.0

    @property
    def slides(self) -> bool:
        """Return whether the rope slides over it, so that it needs a coefficient."""
        return hasattr(self, "mu")

    def stretch_N_m(self, passage: "Passage", known_N: FloatArray) -> FloatArray:
        """Return ∫T dx over the rope in it [N m], shape (n,); of a tension that changes evenly along it."""
        return np.asarray(0.5 * self.stretching_m * (known_N + self.tension_N(passage, known_N)))


def given_by(element: type[Element]) -> dict[str, Given]:
    """Return the keys of a kind of element by its fields."""
    hints = get_type_hints(element, include_extras=True)
    said = {one.name: getattr(hints[one.name], "__metadata__", ()) for one in fields(element)}
    return {name: one for name, many in said.items() for one in many if isinstance(one, Given)}


@dataclass(frozen=True, kw_only=True, eq=False)
class LineProblem(Cases):
    """A rope through elements, n cases side by side; its tension is known at the start or at the end."""

    friction: WrapFriction | None
    elements: tuple[Element, ...]
    pulled: bool = True
    both_ends: bool = False
    start_tension_N: ZeroOrMore | None = None
    end_tension_N: ZeroOrMore | None = None
    pull_N: Positive | None = None
    tension_limit_N: Positive | None = None
    anchorage_slip_m: Positive | None = None
    linear_density_kg_m: Positive | None = None
    axial_stiffness_N: Positive | None = None
    rope_radius_m: Positive | None = None
    bending_stiffness_N_m2: Positive | None = None

    @property
    def weight_N_m(self) -> FloatArray:
        """Return the weight per length [N/m], shape (n,); zero where it is not given."""
        return GRAVITY_M_S2 * self.product("linear_density_kg_m")


LineModel = Model[LineProblem]
"""A line with the effects that are simulated."""


class Passage(NamedTuple):
    """How a rope passes an element: the model, from which side its tension is known, and which way it moves."""

    model: LineModel
    is_forward: bool
    is_pulled: bool

    @property
    def rises(self) -> bool:
        """Return whether friction makes the tension grow from the side where it is known."""
        return self.is_forward == self.is_pulled

    @property
    def ways(self) -> tuple[float, float]:
        """Return +1 or −1 for the side from which the tension is known, and for the motion of the rope."""
        return (1.0 if self.is_forward else -1.0), (1.0 if self.is_pulled else -1.0)

    def limp(self) -> Self:
        """Return the same passage of a rope that bends by itself."""
        effects = self.model.effects - {"bending-stiffness"}
        return self._replace(model=replace(self.model, effects=effects))

    def has(self, effect: str) -> bool:
        """Return whether an effect is simulated."""
        return effect in self.model.effects

    @property
    def weight_N_m(self) -> FloatArray:
        """Return the weight of the rope per length [N/m], shape (n,)."""
        return self.model.part("weight", self.model.problem.weight_N_m)

    def coefficient(self, mu: float | None) -> FloatArray:
        """Return the coefficient of a straight part: the element's own, or the law's at its reference."""
        friction = self.model.problem.friction
        if mu is not None or friction is None:
            return np.array(mu or 0.0)
        return friction.exponent(1.0, 0.1, 1.0, 100.0, regressors=frozenset())

    def exponent(self, bend: "Contact", wrap_rad: FloatArray, slack_N: FloatArray) -> FloatArray:
        """Return M = ∫μ dφ over a wrap: of the element's own coefficient, or of the law of the line."""
        problem, regressors = self.model.problem, own_regressors(self.model.effects)
        if bend.mu is not None or problem.friction is None:
            found = np.asarray((bend.mu or 0.0) * wrap_rad)
        else:
            sizes: tuple[float, float | FloatArray] = (1.0, 0.1)
            if bend.radius_m is not None and problem.rope_radius_m is not None:
                sizes = bend.radius_m, problem.rope_radius_m
            else:
                regressors -= {"size"}
            found = problem.friction.exponent(sizes[0], sizes[1], wrap_rad, slack_N, regressors=regressors)
        refuse_no_ratio(found, key="elements")
        return found

    def round_bend(self, known_N: FloatArray, bend: "Contact") -> FloatArray:
        """Return the tension on the other side of what a rope slides round; a rope that pushes feels no friction."""
        pressing = known_N > 0.0
        if not pressing.any():
            return known_N
        safe_N = np.where(pressing, known_N, 1.0)
        tight_of = partial(self._tight_N, bend=bend)
        return np.where(pressing, tight_of(safe_N) if self.rises else _slack_N(tight_of, safe_N), known_N)

    def _tight_N(self, slack_N: FloatArray, bend: "Contact") -> FloatArray:
        stiff_N, pressing_N, contact = self.pressing(slack_N, bend)
        return np.asarray(stiff_N + pressing_N * np.exp(self.exponent(bend, contact, pressing_N)))

    def pressing(self, slack_N: FloatArray, bend: "Contact") -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return E = EI/(2R²) of a stiff rope, what presses on the slack side [N], and the wrap in contact [rad]."""
        problem, radius_m = self.model.problem, bend.radius_m
        stiff_N = np.zeros(problem.n)
        if radius_m is not None and problem.bending_stiffness_N_m2 is not None:
            thin_m = 0.0 if problem.rope_radius_m is None else problem.rope_radius_m
            stiff_N = bending_N(problem.bending_stiffness_N_m2, np.asarray(radius_m + thin_m))
            stiff_N = self.model.part("bending-stiffness", np.broadcast_to(stiff_N, (problem.n,)))
        pressing_N = slack_N - stiff_N
        refuse(
            pressing_N <= 0.0,
            "EI/(2 R^2) = {stiff_N:.6g} N is not below the tension of {slack_N:.6g} N: the rope is too stiff to follow "
            "a bend of {radius_m:.6g} m",
            code="RF510",
            key="bending_stiffness_N_m2",
            fix="raise the tension or the radius of the bend",
            stiff_N=stiff_N,
            slack_N=slack_N,
            radius_m=math.nan if radius_m is None else radius_m,
        )
        contact = np.full(problem.n, bend.wrap_rad)
        if stiff_N.any():
            contact = contact_arc_rad(
                contact,
                stiff_N,
                pressing_N,
                lambda wrap_angle_rad: self.exponent(bend, wrap_angle_rad, pressing_N),
            )
        return stiff_N, pressing_N, contact

    def mean_growth(self, bend: "Contact", contact: FloatArray, pressing_N: FloatArray) -> FloatArray:
        """Return the mean of e^M along the wrap in contact, (e^M − 1)/M where M grows in proportion to it."""
        friction = self.model.problem.friction
        if bend.mu is not None or friction is None or not friction.law.effects & _BEND_M:
            return np.asarray(exprel(self.exponent(bend, contact, pressing_N)))
        shares = np.multiply.outer(_SHARES, contact)  # all places and cases in one call of the law
        return np.asarray(_PARTS @ np.exp(self.exponent(bend, shares, pressing_N)))


class Contact(NamedTuple):
    """A contact of the rope: wrap [rad], radius [m], and own coefficient."""

    wrap_rad: float
    radius_m: float | None = None
    mu: float | None = None


def _slack_N(tight_of: Callable[[FloatArray], FloatArray], tight_N: FloatArray) -> FloatArray:
    """Return the slack side's tension to a tight side's, by secants of g(ln T) = ln tight(T) − ln T_tight.

    As M falls with T by less than ln T rises, ln T − g never falls below the solution: it is taken where the law has no
    answer to a secant's.
    """
    wanted = np.log(tight_N)

    def excess(logs: FloatArray) -> FloatArray:
        return np.asarray(np.log(tight_of(np.exp(logs))) - wanted)

    before, above = wanted, excess(wanted)
    here = safe = before - above
    for _ in range(_MAX_STEPS):
        try:
            now = excess(here)
        except RopefricError:
            here = safe
            now = excess(here)
        slope = np.divide(above - now, before - here, out=np.ones_like(now), where=before != here)
        step = now / np.clip(slope, 1e-3, 2.0)
        before, above, safe, here = here, now, here - now, here - step
        left = np.minimum(np.abs(step) / (1.0 + np.abs(here)), np.abs(now) / (1.0 + np.abs(wanted)))
        if (left <= _SETTLED).all():
            return np.asarray(np.exp(here))
    raise SolverError(
        "the tension on the slack side of a bend does not settle",
        code="RF500",
        key="elements",
        fix="use a law without tension",
    )
