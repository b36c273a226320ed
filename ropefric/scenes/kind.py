"""Kinds of scenes: keys, machine, and answer in numbers, words, files and figures."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Annotated, Any, ClassVar, NamedTuple, Self, get_args, get_origin

import numpy as np
from pydantic import BaseModel, Field, PlainValidator, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import core_schema

from ropefric.arrays import BoolArray, FloatArray
from ropefric.files.toml_model import StrictTable, choice, got, quantity, reject, text
from ropefric.friction.laws import ALL_LAWS
from ropefric.quantities import LARGEST, SMALLEST, in_range
from ropefric.section import Section, in_cell
from ropefric.systems.effect import System


def number(value: object) -> float:
    """Return a bare finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < float("inf"):
        fix = "write it without quotes and without unit" if isinstance(value, str) else ""
        reject("RF110", f"expected a number, got {got(value)}", fix=fix)
    if not in_range(value):
        limits = f"{SMALLEST:g} to {LARGEST:g}"
        reject(
            "RF110",
            f"{got(value)} is too large or too small: {limits} are the limits",
            fix="correct the number",
        )
    return float(value)


def number_where(
    holds: Callable[[float], bool], allowed: str, fix: str = "", code: str = "RF110"
) -> Callable[[object], float]:
    """Return a reader of bare numbers for which something holds: those that are `allowed`, in words."""

    def read(value: object) -> float:
        found = number(value)
        if not holds(found):
            reject(code, f"{got(value)} is not {allowed}", fix=fix or f"give a number that is {allowed}")
        return found

    read.__doc__ = allowed  # for the documentation's page of keys
    return read


positive = number_where(lambda one: one > 0.0, "more than 0")
zero_or_more = number_where(lambda one: one >= 0.0, "zero or more")
_accuracy = number_where(
    lambda one: 0.0 < one <= 1.0,
    "above 0 and at most 1",
    "give the relative error you accept, such as 0.01 for 1 %",
    "RF501",
)


def by_name(read: Callable[[object], float], like: str) -> PlainValidator:
    """Return the pydantic annotation of a table with one value for each part of the machine that it names."""

    def values(value: object) -> dict[str, float]:
        if not isinstance(value, dict):
            reject("RF110", f"expected a table of values, got {got(value)}", fix=f"write {{ {like} }}")
        return {str(name): read(one) for name, one in value.items()}

    values.__doc__ = f"a table such as {{ {like} }}"
    return PlainValidator(values)


@dataclass(frozen=True, slots=True)
class Becomes:
    """Beside a key: the field of the machine or its problem that the key's value becomes.

    Attributes
    ----------
    field : str
        Its name there; in an error of the mechanics it leads back to the key.
    factor : float
        Of the value; a diameter becomes half of it.
    many : bool
        Whether a sweep may solve many values of it in one call.
    """

    field: str
    factor: float = 1.0
    many: bool = True


@dataclass(frozen=True, slots=True)
class Key(Becomes):
    """The same for a quantity that is written with its unit, of which it is the pydantic annotation, too.

    Attributes
    ----------
    si_unit, like : str
        The unit it is read in, and an example.
    above : float or None
        What it must be more than; None for any number.
    or_zero : bool
        Whether it may be zero, too.
    """

    si_unit: str = ""
    like: str = ""
    above: float | None = 0.0
    or_zero: bool = False

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """Return the reader of the value."""
        read = quantity(self.si_unit, self.like, above=None if self.or_zero else self.above)

        def checked(value: object) -> float:
            number = read(value)
            if self.or_zero and number < 0.0:
                reject("RF110", f"{got(value)} is not zero or more", fix=f'write it like "{self.like}"')
            return number

        return core_schema.no_info_plain_validator_function(checked)

    @property
    def range(self) -> str:
        """Return the values that it may have, in words."""
        if self.or_zero:
            return "zero or more"
        return "any" if self.above is None else f"more than {self.above:g}"


def key(si_unit: str, like: str, field: str = "", **more: Any) -> Key:
    """Return the annotation of a quantity: by default a positive one."""
    return Key(field, si_unit=si_unit, like=like, **more)


def _fields(schema: type[BaseModel]) -> list[tuple[str, Becomes]]:
    metadata = ((name, one) for name, info in schema.model_fields.items() for one in info.metadata)
    return [(name, one) for name, one in metadata if isinstance(one, Becomes) and one.field]


def types_in(annotation: Any) -> Iterator[type]:
    """Yield the classes in an annotation, such as the table in `dict[str, Table]`."""
    inner = get_args(annotation)
    for one in inner or (annotation,):
        if inner:
            yield from types_in(one)
        elif isinstance(one, type):
            yield one


def tables_in(info: FieldInfo) -> list[type[StrictTable]]:
    """Return the table that a key is, or that there are many of under it; none where it holds a value."""
    return [one for one in types_in(info.annotation) if issubclass(one, StrictTable)]


def becomes(schema: type[BaseModel], prefix: str = "", *, whole: bool = True) -> dict[str, Becomes]:
    """Return what the keys of a schema become, those of its tables included; friction has a reader of its own.

    A key in one of many tables of a kind, such as `[rollers.2]`, is named without them, and is not swept in one call.
    """
    before = prefix if whole else ""
    found = {before + name: replace(one, many=one.many and whole) for name, one in _fields(schema)}
    for name, info in schema.model_fields.items():
        single = whole and get_origin(info.annotation) not in {dict, list}
        for table in tables_in(info) if name != "friction" else ():
            found |= becomes(table, f"{before}{name}.", whole=single)
    return found


def given(table: StrictTable) -> dict[str, Any]:
    """Return the fields that one table's keys become, with their values; not those it leaves out."""
    values = ((getattr(table, name), one) for name, one in _fields(type(table)))
    return {
        one.field: value if one.factor == 1.0 else one.factor * value
        for value, one in values
        if value is not None
    }


def arrays(table: StrictTable) -> dict[str, FloatArray]:
    """Return the fields that the keys of a table and of the tables in it become, each as a problem of one case."""
    found = {name: np.array([value]) for name, value in given(table).items()}
    for name in type(table).model_fields:
        inner = getattr(table, name)
        found |= arrays(inner) if isinstance(inner, StrictTable) and name != "friction" else {}
    return found


def _effects(value: object) -> str | tuple[str, ...]:
    """ "auto", "all", or a list of names"""  # noqa: D210, D400
    if value in ("auto", "all"):
        return str(value)
    if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
        reject(
            "RF110",
            f'expected "auto", "all" or a list of names, got {got(value)}',
            fix='write effects = "auto"',
        )
    if len(set(value)) < len(value):
        reject("RF111", "the list names an effect twice", fix="name each effect once")
    return tuple(value)


def value_at(tree: Any, key: str) -> Any:
    """Return the value at a key of a TOML tree or of the table made from it; None where there is none."""
    for name in key.split("."):
        if isinstance(tree, list):
            tree = tree[int(name)] if name.isdecimal() and int(name) < len(tree) else None
        else:
            tree = tree.get(name) if isinstance(tree, dict) else getattr(tree, name, None)
    return tree


Rule = Callable[[BaseModel], None]
"""Refuses a table whose keys do not go together; keys of its tables are named with them: "wheel.speed"."""


def _gives(table: BaseModel, key: str) -> bool:
    value = value_at(table, key)
    return value is not None and value is not False


def how_to_add(schema: type[BaseModel], key: str) -> str:
    """Return how a key is added, with its example where it is a quantity."""
    owner, _, name = key.rpartition(".")
    for part in owner.split(".") if owner else ():
        (schema,) = tables_in(schema.model_fields[part])
    info = schema.model_fields[name]
    if tables_in(info):
        return f"add [{key}]"
    like = "".join(f' = "{one.like}"' for one in info.metadata if isinstance(one, Key))
    return f"add {name}{like} to [{owner}]" if owner else f"add {name}{like}"


def one_of(*keys: str, fix: str = "") -> Rule:
    """Return the rule that a table gives one of some keys, and no more of them."""

    def check(table: BaseModel) -> None:
        given = [key for key in keys if _gives(table, key)]
        if not given:
            advice = fix or " or ".join(how_to_add(type(table), key) for key in keys)
            reject("RF121", f"none of {', '.join(keys)} is given", fix=advice)
        if len(given) > 1:
            reject("RF111", f"{' and '.join(given)} are both given", fix="keep one of them", key=given[-1])

    return check


def needs(key: str, *others: str) -> Rule:
    """Return the rule that a key is given together with some others only."""

    def check(table: BaseModel) -> None:
        for other in others if _gives(table, key) else ():
            if not _gives(table, other):
                reject("RF121", f"{key} needs {other}", fix=how_to_add(type(table), other), key=key)

    return check


def excludes(key: str, *others: str) -> Rule:
    """Return the rule that a key is given without each of some others."""

    def check(table: BaseModel) -> None:
        for other in others if _gives(table, key) else ():
            if _gives(table, other):
                reject("RF111", f"{key} and {other} are both given", fix="keep one of them", key=other)

    return check


class Table(StrictTable):
    """A TOML table of a scene; its `rules` say which keys go together."""

    rules: ClassVar[tuple[Rule, ...]] = ()

    def _check(self) -> None:
        """Refuse what no rule covers."""

    @model_validator(mode="after")
    def _checked(self) -> Self:
        for rule in type(self).rules:
            rule(self)
        self._check()
        return self


class ReferenceTable(Table):
    """`[friction.reference]`: the condition for regressors that the law does not get.

    Keys
    ----
    wheel_radius : R_w.
    rope_diameter : 2 R_r.
    wrap : φ.
    end_tension : F_B.
    """

    wheel_radius: Annotated[float | None, key("m", "40 mm", "wheel_radius_m")] = None
    rope_diameter: Annotated[float | None, key("m", "9.8 mm", "rope_radius_m", factor=0.5)] = None
    wrap: Annotated[float | None, key("rad", "360 deg", "wrap_angle_rad")] = None
    end_tension: Annotated[float | None, key("N", "60 N", "end_tension_N")] = None


class ScaleTable(Table):
    """`friction.scale_to`.

    Keys
    ----
    mu : Average coefficient of the law over this wrap.
    wrap : The wrap for this average coefficient.
    """

    mu: Annotated[float, PlainValidator(positive), Becomes("mu")]
    wrap: Annotated[float, key("rad", "180 deg", "wrap_angle_rad")]


class FrictionTable(Table):
    """`[friction]`: a number, a law with its parameters, or a stored fit.

    Keys
    ----
    mu : One coefficient, the same everywhere.
    law : Name of a friction law, with its parameters.
    parameters : Values of the law's parameters.
    fit : A stored fit: its path from the scene's folder, or from that of the command.
    """

    mu: Annotated[float | None, PlainValidator(zero_or_more)] = None
    law: Annotated[str | None, PlainValidator(choice(lambda: ALL_LAWS))] = None
    parameters: Annotated[dict[str, float] | None, by_name(number, "a = 0.2, b = -0.5")] = None
    fit: Annotated[str | None, PlainValidator(text)] = None
    scale_to: ScaleTable | None = None
    reference: ReferenceTable = Field(default_factory=ReferenceTable)

    rules = (
        one_of("mu", "law", "fit", fix="add mu = 0.2, or law and parameters, or fit"),
        needs("parameters", "law"),
        excludes("mu", "scale_to"),
    )

    def _check(self) -> None:
        if self.law is not None and self.parameters is None:
            names = ", ".join(f"{name} = …" for name in ALL_LAWS[self.law].parameter_names)
            reject("RF121", f"the law {self.law} has no parameters", fix=f"add parameters = {{ {names} }}")


class SceneTable(Table):
    """The keys at the top of every scene.

    Keys
    ----
    system : The kind of machine.
    accuracy : Relative error of the answer that you accept.
    effects : Simulated effects: those that the accuracy needs, all, or a list of their names.
    tolerances : Limits of error of the scene's numbers, by key, in the number's unit or in per cent; for `--draws`.
    plugins : Files with laws or machines of your own, from the scene's folder.
    """

    system: Annotated[str, PlainValidator(text)]
    accuracy: Annotated[float, PlainValidator(_accuracy)] = 0.01
    effects: Annotated[str | tuple[str, ...], PlainValidator(_effects)] = "auto"
    friction: FrictionTable | None = None
    tolerances: dict[str, Any] = Field(default_factory=dict)
    plugins: tuple[str, ...] = ()


class Quantity(NamedTuple):
    """One number of an answer that people read, and that friction may make uncertain.

    `scale` is what it errs by a share of where that is not the number itself: of a difference one of its terms.
    Of the main one the tree names uncertainty and interval without saying of what.
    """

    name: str
    value: FloatArray
    positive: bool = False
    scale: FloatArray | None = None
    is_main: bool = False


class Failure(NamedTuple):
    """A way in which a machine does not do what it is for, however well that is known: on one side of a limit.

    One that is only `counted`, over many cases, is no failure of a single answer, which states it elsewhere.
    """

    words: str
    measure: str
    value: FloatArray
    fails: BoolArray
    limit: float = 1.0
    counted: bool = False

    def text(self, case: int | None = None) -> str:
        """Return what one case does not do; the first that fails, if it is not said which."""
        return f"{self.words}: {self.measure} {float(self.value[np.argmax(self.fails) if case is None else case]):.3g}"

    def is_open(self, error: FloatArray | float) -> BoolArray:
        """Return where a measure that errs by a share may be on either side of its limit; an infinite one does not."""
        near = np.abs(self.value - self.limit) <= error * np.abs(self.value)
        return np.asarray(near & np.isfinite(self.value))


LARGEST_STRAIN = 0.1
"""Of a belt or rope that stretches in proportion to its tension, as all of them are taken here."""


def strained(what: str, strain: FloatArray) -> Failure:
    """Return that something is strained beyond what T = EA times strain holds for."""
    words = f"{what} is strained by more than 10 %, beyond a stretch in proportion to its tension"
    return Failure(words, "strain", strain, strain > LARGEST_STRAIN, limit=LARGEST_STRAIN)


class Figure(NamedTuple):
    """A figure of a kind: what it shows, None where a scene has nothing to show, and what draws it in plotting."""

    data: Callable[[Any, Any], Any]
    drawn_by: str = "draw_chart"


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of scene: everything the tool knows of one machine beyond its mechanics.

    Attributes
    ----------
    name : str
        The value of `system = "…"`.
    schema : type of SceneTable
        Its TOML keys, each with its `Becomes`.
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
    outcomes : callable
        `outcomes(answer, problem)` returns columns of tables of many cases that no single answer has: numbers
        that friction changes in jumps, so that they have no slope, such as whether anything slipped.
    tree : callable
        `tree(answer, problem)` returns the JSON shape of the answer, without what all scenes share.
    contacts : callable
        `contacts(problem)` returns the conditions at which the friction is used, as a mapping from the regressor's
        name to an array; to find extrapolations.
    answerable : callable
        `answerable(problem)` returns for which of many cases there is an answer, as far as that shows without
        solving them.
    failures : callable
        `failures(answer, problem)` returns the possible failures of the machine.
    kept : callable
        `kept(problem)` returns which effects are never left out, and why: something beside the numbers depends on them.
    in_one_call : callable
        `in_one_call(problem)` returns whether a problem can be solved for many cases at once.
    keys : mapping of str to str
        Keys of the scene behind names that an error of the system gives, beside what the keys become; "roller" is
        for "roller 2" and takes the 2 in its `{}`.
    sections : callable
        `sections(tree)` returns the answer in words and tables, from the whole JSON shape.
    histories : mapping
        `histories[file name](answer)` returns columns to be written as CSV; None where there are none.
    figures : mapping of str to Figure
        By file name without ending.
    beyond : mapping of str to str
        Which parts of the tree the bound of a plan does not cover, in words: what they are is of the effects simulated.
        A number in a table of the tree is named with it: "creep.power_lost_W".
    undecided : callable
        `undecided(answer, problem, error)` returns the questions that an answer with this error leaves open, beside the
        `failures`.
    words : mapping of str to str
        Meaning of the numbers of its answer, with unit, where the glossary has none.

    Examples
    --------
    >>> from ropefric.scenes.kinds import KINDS
    >>> KINDS["hoist"].sweep_fields["wheel.wrap"].field
    'wrap_angle_rad'
    """

    name: str
    schema: type[SceneTable]
    system: System
    own_wheel: Callable[[Any], tuple[float, float]]
    problem: Callable[[Any, Any], Any]
    quantities: Callable[[Any, Any], tuple[Quantity, ...]]
    tree: Callable[[Any, Any], dict[str, Any]]
    contacts: Callable[[Any], Mapping[str, FloatArray]]
    answerable: Callable[[Any], BoolArray]
    outcomes: Callable[[Any, Any], tuple[Quantity, ...]] = lambda answer, problem: ()  # noqa: ARG005  (none known)
    failures: Callable[[Any, Any], tuple[Failure, ...]] = lambda answer, problem: ()  # noqa: ARG005  (none known)
    kept: Callable[[Any], Mapping[str, str]] = lambda problem: {}  # noqa: ARG005  (none)
    in_one_call: Callable[[Any], bool] = lambda problem: True  # noqa: ARG005  (every problem)
    keys: Mapping[str, str] = field(default_factory=dict)
    sections: Callable[[Mapping[str, Any]], tuple[Section, ...]] = lambda tree: ()  # noqa: ARG005  (no more to say)
    histories: Mapping[str, Callable[[Any], Mapping[str, FloatArray] | None]] = field(default_factory=dict)
    figures: Mapping[str, Figure] = field(default_factory=dict)
    beyond: Mapping[str, str] = field(default_factory=dict)
    undecided: Callable[[Any, Any, float], tuple[str, ...]] = lambda answer, problem, error: ()  # noqa: ARG005
    words: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def sweep_fields(self) -> dict[str, Becomes]:
        """Return the keys that can be swept in one call, with what they become."""
        return {key: one for key, one in becomes(self.schema).items() if one.many}

    @cached_property
    def _keys(self) -> dict[str, str]:
        own = {one.field: key for key, one in becomes(self.schema).items()}
        return {"mu": "friction.mu", **own, **self.keys}

    def scene_key(self, name: str) -> str:
        """Return the key of the scene behind a name that an error of the system gives."""
        part, _, which = name.partition(" ")
        if which and part in self.keys:
            return self.keys[part].format(which)
        owner, dot, last = name.rpartition(".")
        return owner + dot + self._keys.get(last, last)


def finite(value: float) -> float | None:
    """Return a number as a float, None (null) where it is not finite."""
    return float(value) if math.isfinite(value) else None


def first(answer: Any, *names: str) -> dict[str, Any]:
    """Return these arrays of an answer in its first case, as JSON; those it does not have are left out."""
    arrays = {name: getattr(answer, name) for name in names}
    return {
        name: finite(values[0]) if values.ndim == 1 else values[0].tolist()
        for name, values in arrays.items()
        if values is not None
    }


def at_contact(problem: Any, end_tension_N: FloatArray) -> dict[str, FloatArray]:
    """Return the conditions on the one wheel of a problem."""
    names = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad")
    return {name: getattr(problem, name) for name in names} | {"end_tension_N": end_tension_N}


Columns = Mapping[str, tuple[str, str] | tuple[str, str, float]]
"""Of a table, by heading: the name of a number, its format, and the factor on it if there is one."""


def cells(one: Mapping[str, Any], columns: Iterable[tuple[Any, ...]]) -> tuple[str, ...]:
    """Return a row of a table: the numbers of these names, each in its format and with its factor."""
    return tuple(in_cell(one.get(name), *form) for name, *form in columns)


def by_rows(title: str, what: str, rows: Mapping[str, Any], columns: Columns, **more: Any) -> Section:
    """Return a part with a table of rows by name, and the lines or notes that come with it."""
    found = tuple((name, *cells(one, columns.values())) for name, one in rows.items())
    return Section(title, headings=(what, *columns), rows=found, **more)
