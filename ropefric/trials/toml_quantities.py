"""Quantities as campaign files write them: text with a unit, fractions of full scale, any unit to SI."""

import re

from ropefric.errors import InputError
from ropefric.quantities import parse_quantity, unit_factor

__all__ = ["read_any_quantity", "read_fraction", "read_quantity", "readable_unit", "si_unit_of"]

# pint evaluates arithmetic in unit text ("9**9**9" keeps it busy for ever), so only plain products of units
# with small powers go through.
_FACTOR = r"(?:[^\W\d_]+|[%°µΩ]|_)+(?:(?:\^|\*\*)?[+-]?\d{1,2})?"
_UNIT = re.compile(rf"(?:1|{_FACTOR})(?:\s*[*/·]\s*{_FACTOR}|\s+{_FACTOR})*")
_MAX_TEXT = 60
_NUMBER = re.compile(r"\s*[+-]?[\d.]+(?:[eE][+-]?\d+)?")
_SI_UNITS = (
    *("m", "N", "s", "V", "Pa", "kg", "m^2", "m^3", "rad", "", "Hz", "m/s", "m/s^2", "kg/m", "N/m"),
    *("N*s", "N*m", "N/s", "N/V", "V/N", "kg/m^2", "kg/m^3", "A", "ohm", "W", "m^4", "N*m^2", "Pa/V"),
)


def readable_unit(unit: str, *, name: str = "quantity") -> str:
    """Return a unit text that is safe to hand to `unit_factor`, unchanged.

    Raises
    ------
    InputError
        RF130 if it is no product of units with powers of at most two digits.

    Examples
    --------
    >>> readable_unit("kg/m^2")
    'kg/m^2'
    """
    if len(unit) > _MAX_TEXT or not _UNIT.fullmatch(unit):
        shown = unit if len(unit) <= _MAX_TEXT else f"{unit[:_MAX_TEXT]}..."
        raise InputError(
            f"{name}: {shown!r} is not a unit", code="RF130", fix="write a unit such as 'mm' or 'N'"
        )
    return unit


def read_quantity(text: str, si_unit: str) -> float:
    """Return a quantity with its unit as an SI float, or refuse it whatever the text.

    Parameters
    ----------
    text : str
        "40 mm", "400 deg".
    si_unit : str
        The SI unit wanted.

    Raises
    ------
    InputError
        Where `ropefric.quantities.parse_quantity` refuses, and for unit text that is arithmetic.

    Examples
    --------
    >>> read_quantity("9.8 mm", "m")
    0.0098
    """
    number = _NUMBER.match(text)
    unit = text[number.end() :].strip() if number else ""
    if len(text) > _MAX_TEXT:
        raise InputError(f"quantity: {text[:_MAX_TEXT]!r}... is too long for a quantity", code="RF130")
    if unit and unit != "%" and not unit.startswith(","):
        readable_unit(unit)
    try:
        return parse_quantity(text, si_unit)
    except ArithmeticError:
        # Decimal gives up on exponents of more than eighteen digits.
        raise InputError(f"quantity: {text!r} is out of range", code="RF130") from None


def read_any_quantity(text: str) -> float:
    """Return a quantity of any mechanical or electrical dimension in SI.

    Parameters
    ----------
    text : str
        "490.9 mm^2", "3 bar", "0.5".

    Raises
    ------
    InputError
        If it is no number with a known unit. Offset units such as degC are not converted.

    Examples
    --------
    >>> read_any_quantity("490.9 mm^2")
    0.0004909
    >>> read_any_quantity("3 bar")
    300000.0
    """
    number = _NUMBER.match(text)
    unit = text[number.end() :].strip() if number else ""
    return read_quantity(text, si_unit_of(unit) if unit and not unit.startswith(",") else "")


def read_fraction(text: str) -> float:
    """Return a share written in per cent, with or without "FS" for full scale, as a fraction.

    Parameters
    ----------
    text : str
        "0.02 %FS", "0.05 %".

    Raises
    ------
    InputError
        If the per-cent sign is missing: 0.02 could mean either.

    Examples
    --------
    >>> read_fraction("0.02 %FS")
    0.0002
    """
    bare = re.sub(r"%\s*(?:of\s+)?(?:FS|F\.S\.|full scale)\s*$", "%", text.strip())
    if not bare.endswith("%"):
        raise InputError(f"quantity: {text!r} has no per-cent sign", code="RF130", fix='write "0.02 %FS"')
    return read_quantity(bare, "")


def si_unit_of(unit: str) -> str:
    """Return the SI unit that a unit converts to.

    Raises
    ------
    InputError
        If nothing is known about it.

    Examples
    --------
    >>> si_unit_of("bar"), si_unit_of("ms"), si_unit_of("%")
    ('Pa', 's', '')
    """
    if unit == "%":
        return ""
    readable_unit(unit)
    for si_unit in _SI_UNITS:
        try:
            unit_factor(unit, si_unit)
        except InputError as error:
            # Only "of another dimension" is worth another try; unknown and mistyped units stay so.
            if error.fix.startswith("write '") or "is not a unit of" not in error.problem.message:
                raise
        else:
            return si_unit
    raise InputError(
        f"quantity: no SI unit is known for {unit!r}",
        code="RF130",
        fix="write the number in SI, without a unit",
    )
