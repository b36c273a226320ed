"""The keys that every scene file may hold, whatever its system."""

from typing import Annotated, Any, Self

from pydantic import Field, PlainValidator, model_validator

from ropefric.files.toml_model import StrictTable, choice, got, quantity, reject, text
from ropefric.friction.laws import ALL_LAWS
from ropefric.quantities import LARGEST, SMALLEST, in_range


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


def positive(value: object) -> float:
    """Return a bare number above zero."""
    found = number(value)
    if not found > 0.0:
        reject("RF110", f"{got(value)} is not more than 0", fix="give a positive number")
    return found


def optional(si_unit: str, like: str, *, above: float | None = None) -> PlainValidator:
    """Return the pydantic annotation of a quantity with its unit."""
    return PlainValidator(quantity(si_unit, like, above=above))


def _accuracy(value: object) -> float:
    found = number(value)
    if not 0.0 < found <= 1.0:
        reject(
            "RF501",
            f"an accuracy of {got(value)} is not above 0 and at most 1",
            fix="give the relative error you can live with, such as 0.01 for 1 %",
        )
    return found


def _effects(value: object) -> str | tuple[str, ...]:
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


class ReferenceTable(StrictTable):
    """`[friction.reference]`: the condition that stands in for what the law is not told."""

    wheel_radius: Annotated[float | None, optional("m", "40 mm", above=0)] = None
    rope_diameter: Annotated[float | None, optional("m", "9.8 mm", above=0)] = None
    wrap: Annotated[float | None, optional("rad", "360 deg", above=0)] = None
    end_tension: Annotated[float | None, optional("N", "60 N", above=0)] = None


class ScaleTable(StrictTable):
    """`friction.scale_to`."""

    mu: Annotated[float, PlainValidator(positive)]
    wrap: Annotated[float, optional("rad", "180 deg", above=0)]


def _parameters(value: object) -> dict[str, float]:
    if not isinstance(value, dict):
        reject("RF110", f"expected a table of numbers, got {got(value)}", fix="write { a = 0.2, b = -0.5 }")
    return {str(name): number(entry) for name, entry in value.items()}


class FrictionTable(StrictTable):
    """`[friction]`: a number, a law with its parameters, or a stored fit."""

    mu: Annotated[float | None, PlainValidator(positive)] = None
    law: Annotated[str | None, PlainValidator(choice(lambda: ALL_LAWS))] = None
    parameters: Annotated[dict[str, float] | None, PlainValidator(_parameters)] = None
    fit: Annotated[str | None, PlainValidator(text)] = None
    scale_to: ScaleTable | None = None
    reference: ReferenceTable = Field(default_factory=ReferenceTable)

    @model_validator(mode="after")
    def _has_one_source(self) -> Self:
        given = [name for name in ("mu", "law", "fit") if getattr(self, name) is not None]
        if not given:
            reject("RF121", "no friction is given", fix="add mu = 0.2, or law and parameters, or fit")
        if len(given) > 1:
            reject("RF111", f"{' and '.join(given)} are both given", fix="keep one of them", key=given[-1])
        if self.law is not None and self.parameters is None:
            names = ", ".join(f"{name} = …" for name in ALL_LAWS[self.law].parameter_names)
            reject("RF121", f"the law {self.law} has no parameters", fix=f"add parameters = {{ {names} }}")
        if self.law is None and self.parameters is not None:
            reject("RF111", "parameters are given without a law", fix="name the law", key="parameters")
        if self.mu is not None and self.scale_to is not None:
            reject("RF111", "a bare coefficient needs no scale_to", fix="remove scale_to", key="scale_to")
        return self


class SceneTable(StrictTable):
    """What every scene has at its top."""

    system: Annotated[str, PlainValidator(text)]
    accuracy: Annotated[float, PlainValidator(_accuracy)] = 0.01
    effects: Annotated[Any, PlainValidator(_effects)] = "auto"
    friction: FrictionTable | None = None
