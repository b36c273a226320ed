"""Units at the edge: text with a unit in, SI floats out.

Inside ropefric every number is SI (and radians) and its name says so. This is the only module that knows
other units, and the only importer of pint, which it loads on first use.
"""

import math
import re
from decimal import Decimal
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, Literal

from ropefric.errors import InputError

if TYPE_CHECKING:
    import pint


SMALLEST, LARGEST = 1e-30, 1e30
"""Between these a number that somebody wrote must lie, in SI, where it is not zero: no rope, machine or clock has
one outside, and products of several still fit into a float."""

SUFFIX_UNITS: dict[str, str] = {
    **{
        unit: unit
        for unit in ("N", "kN", "mN", "kgf", "lbf", "m", "mm", "cm", "um", "in", "rad", "deg", "turn")
    },
    **{
        unit: unit
        for unit in ("s", "ms", "us", "min", "Hz", "kHz", "V", "mV", "kg", "g", "lb", "Pa", "kPa", "MPa")
    },
    "bar": "bar",
    "degC": "degC",
    "inch": "in",
    "turns": "turn",
    "h": "hour",
    "m_s": "m/s",
    "kg_m": "kg/m",
    "g_m": "g/m",
    "N_m": "N/m",
    "N_s": "N/s",
}
"""Unit suffixes of names (`wrap_angle_deg`) and what they mean to pint."""

_USUAL: dict[tuple[str, str], float] = {
    **{(unit, "m"): factor for unit, factor in (("m", 1.0), ("cm", 0.01), ("mm", 1e-3), ("um", 1e-6))},
    **{(unit, "N"): factor for unit, factor in (("N", 1.0), ("kN", 1e3), ("mN", 1e-3))},
    **{
        (unit, "rad"): factor for unit, factor in (("rad", 1.0), ("deg", math.pi / 180.0), ("turn", math.tau))
    },
    **{(unit, "s"): factor for unit, factor in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("min", 60.0))},
    **{(unit, "kg"): factor for unit, factor in (("kg", 1.0), ("g", 1e-3))},
    **{(unit, "kg/m"): factor for unit, factor in (("kg/m", 1.0), ("g/m", 1e-3))},
    **{(unit, "N/m"): factor for unit, factor in (("N/m", 1.0), ("N/mm", 1e3), ("kN/m", 1e3))},
    **{(unit, "Pa"): factor for unit, factor in (("Pa", 1.0), ("MPa", 1e6), ("GPa", 1e9))},
    **{(unit, "W"): factor for unit, factor in (("W", 1.0), ("kW", 1e3))},
    **{(unit, unit): 1.0 for unit in ("V", "Hz", "m/s", "N*m", "N*m^2", "kg*m^2", "kg/m^3", "N*s/m")},
    ("mV", "V"): 1e-3,
    ("rad/s", "rad/s"): 1.0,
    ("rpm", "rad/s"): math.tau / 60.0,
    ("kHz", "Hz"): 1e3,
    ("mm^2", "m^2"): 1e-6,
    ("percent", ""): 0.01,
}
"""Factors that nearly every file needs, so that nearly none has to wait for pint; its own, to the last bit."""

_GUARDED = {"kn": "kN", "n": "N", "KN": "kN", "hz": "Hz", "khz": "kHz", "v": "V", "mpa": "MPa"}
_SI_UNITS = (
    *("m", "N", "s", "V", "Pa", "kg", "m^2", "m^3", "rad", "", "Hz", "m/s", "m/s^2", "kg/m", "N/m"),
    *("N*s", "N*m", "N/s", "N/V", "V/N", "kg/m^2", "kg/m^3", "A", "ohm", "W", "m^4", "N*m^2", "Pa/V"),
)
_SUFFIXES = sorted(SUFFIX_UNITS, key=len, reverse=True)

_MAX_TEXT, _MAX_UNIT = 100, 40
# pint evaluates arithmetic in unit text ("9**9**9" keeps it busy for ever), so only plain products of units with
# small powers reach it. Possessive repeats (++) never give back what they took: linear time on any text.
_FACTOR = r"(?:(?![0-9])[\w%°])++(?:(?:\^|\*\*)?[+-]?[0-9]{1,2})?"
_UNIT = re.compile(rf"(?:1|{_FACTOR})(?:\s*+[*/·]\s*+{_FACTOR}|\s++{_FACTOR})*+")
_LARGE_POWER = re.compile(r"[\d⁰¹²³⁴⁵⁶⁷⁸⁹]{3}")
_NUMBER = re.compile(r"[+-]?(?:[0-9]++(?:\.[0-9]*+)?|\.[0-9]++)(?:[eE][+-]?[0-9]++)?")
_NOT_ZERO = re.compile(r"[1-9]")
_FULL_SCALE = re.compile(r"%\s*+(?:of\s++)?(?:FS|F\.S\.|full scale)")


@cache
def _registry() -> "pint.UnitRegistry[Any]":
    import pint  # noqa: PLC0415  (0.3 s to load, and most library calls never need a unit)

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


def split_unit_suffix(name: str) -> tuple[str, str]:
    """Return a name without its unit suffix, and the unit, empty where there is none.

    Recognises `wrap_angle_deg`, `Force (kN)`, `Force [kN]`, `Time.(s)`.
    """
    text = name.strip()
    if text.endswith((")", "]")):
        body = text[:-1]
        start = max(body.rfind(")"), body.rfind("]")) + 1
        opened = max(body.rfind("("), body.rfind("["))
        if opened >= max(start, 1):  # with something before it, and not closed before
            stem = body[:opened]
            return stem.rstrip(" \t\r\n\v\f._") or stem[:1], body[opened + 1 :].strip()
    for suffix in _SUFFIXES:
        stem = name.removesuffix(f"_{suffix}")
        if stem and stem != name:
            return stem, SUFFIX_UNITS[suffix]
    return name, ""


def unit_factor(unit: str, si_unit: str, *, name: str = "quantity") -> float:
    """Return the factor that turns a number in `unit` into SI."""
    meant = _GUARDED.get(unit)
    if meant is not None and meant != unit:
        note = "'kn' is a knot, not a force." if unit == "kn" else f"'{unit}' is not a unit of [{si_unit}]."
        raise InputError(f"{name}: {note}", code="RF130", fix=f"write '{meant}'")
    asked = ("percent" if unit == "%" else unit, si_unit)
    found = _USUAL[asked] if asked in _USUAL else _factor_by_pint(*asked)
    if isinstance(found, float):
        return found
    message = {
        "dimension": f"'{unit}' is not a unit of {_dimension(si_unit)}",
        "text": f"'{_shortened(unit)}' is not a unit",
        "unknown": f"unknown unit '{unit}'",
    }[found]
    raise InputError(f"{name}: {message}", code="RF130", fix=f"use a unit such as '{_example_unit(si_unit)}'")


@lru_cache(maxsize=4096)  # what is refused is kept too: a file can ask for the same nonsense in every column
def _factor_by_pint(unit: str, si_unit: str) -> float | Literal["dimension", "text", "unknown"]:
    if unit and (len(unit) > _MAX_UNIT or not _UNIT.fullmatch(unit) or _LARGE_POWER.search(unit)):
        return "text"
    import pint  # noqa: PLC0415

    registry = _registry()
    try:
        # Differences, not temperatures: no name in this package is an offset unit.
        magnitude = float(registry.Quantity(1.0, unit or "").to(si_unit or "").magnitude)
    except pint.DimensionalityError:
        return "dimension"
    except Exception as error:  # pint raises its own, tokenize's and assertion errors for unreadable text
        if isinstance(error, KeyboardInterrupt | SystemExit):
            raise
        return "unknown"
    if not in_range(magnitude) or magnitude == 0.0:
        return "unknown"
    # Exact decimal factors survive only if the rounding of pint's own chain is taken off; angles have none.
    return magnitude if "rad" in si_unit else float(f"{magnitude:.15g}")


def in_range(value: float) -> bool:
    """Return whether a number is zero or of a size that can be computed with, see `LARGEST`."""
    return value == 0.0 or SMALLEST <= abs(value) <= LARGEST


def si_unit_of(unit: str) -> str:
    """Return the SI unit that a unit converts to."""
    if unit == "%":
        return ""
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


def parse_quantity(text: object, si_unit: str, *, name: str = "quantity") -> float:
    """Return a quantity written with its unit as an SI float."""
    if isinstance(text, bool) or not isinstance(text, str | int | float):
        raise InputError(
            f"{name}: {_shown(text)} is not a quantity",
            code="RF130",
            fix=f'write "1 {_example_unit(si_unit)}"',
        )
    digits, unit = _split(text, si_unit, name)
    value = float(digits)
    problem, fix = _doubt(digits, value, unit, si_unit)
    if problem:
        raise InputError(f"{name}: {_shown(text)} {problem}", code="RF130", fix=fix)
    # Decimal, because 9.8 * 0.001 is not 0.0098 in binary and people compare what they wrote.
    factor = unit_factor(unit, si_unit, name=name) if unit else 1.0
    result = float(Decimal(digits) * Decimal(repr(factor))) if unit and value else value
    if not in_range(result) or (value and not result):
        bound = f"{LARGEST:g}" if abs(result) > 1.0 else f"{SMALLEST:g}"
        size = "large" if abs(result) > 1.0 else "small"
        limit = f"{bound} {si_unit}".strip()
        raise InputError(
            f"{name}: {_shown(text)} is too {size}: {limit} is the limit",
            code="RF110",
            fix="correct the number",
        )
    return result


def _split(text: str | float, si_unit: str, name: str) -> tuple[str, str]:
    """Return the number of a quantity and its unit, both as written."""
    if isinstance(text, int) and text.bit_length() > 1024:  # more digits than Python likes to print
        raise InputError(f"{name}: the number is not a finite number", code="RF130", fix="correct the number")
    written = str(text).strip()
    if len(written) > _MAX_TEXT:
        raise InputError(
            f"{name}: {_shown(written)} is too long for a quantity",
            code="RF130",
            fix=f'write it like "1.5 {_example_unit(si_unit)}"',
        )
    match = _NUMBER.match(written)
    if match is None:
        raise InputError(
            f"{name}: cannot read {_shown(text)} as a number with a unit",
            code="RF130",
            fix=f'write it like "1.5 {_example_unit(si_unit)}"',
        )
    return match[0], written[match.end() :].strip()


def parse_any_quantity(text: str) -> float:
    """Return a quantity of any mechanical or electrical dimension in SI."""
    unit = _split(text, "", "quantity")[1]
    return parse_quantity(text, si_unit_of(unit) if unit and not unit.startswith(",") else "")


def parse_fraction(text: str) -> float:
    """Return a share written in per cent, with or without "FS" for full scale, as a fraction."""
    unit = _split(text, "", "quantity")[1] or text.strip()
    if unit != "%" and not _FULL_SCALE.fullmatch(unit):
        raise InputError(
            f"quantity: {_shown(text)} has no per-cent sign", code="RF130", fix='write "0.02 %FS"'
        )
    return parse_quantity(text.strip().removesuffix(unit) + "%", "")


def _shown(text: object) -> str:
    shown = repr(text)
    return shown if len(shown) <= _MAX_TEXT else f"{shown[:_MAX_UNIT]}..."


def _shortened(text: str) -> str:
    return text if len(text) <= _MAX_UNIT else f"{text[:_MAX_UNIT]}..."


def _doubt(digits: str, value: float, unit: str, si_unit: str) -> tuple[str, str]:
    """Return what is wrong with a number and its unit as they stand, and the fix; nothing where all is well."""
    example = _example_unit(si_unit)
    if not math.isfinite(value):
        return "is not a finite number", ""
    if value == 0 and _NOT_ZERO.search(digits.lower().partition("e")[0]):
        return "is out of range: too small for a float", ""
    if not unit and si_unit:
        return "has no unit", f'write it with one, for example "{digits} {example}"'
    if unit.startswith(","):
        return "has a decimal comma", "write a decimal point, as TOML does"
    return "", ""


def _dimension(si_unit: str) -> str:
    known = {"m": "length", "N": "force", "rad": "angle", "s": "time", "Hz": "frequency", "V": "voltage"}
    known |= {"kg/m": "mass per length", "kg": "mass", "m/s": "speed", "N/m": "stiffness", "": "a bare ratio"}
    return known.get(si_unit, f"[{si_unit}]")


def _example_unit(si_unit: str) -> str:
    known = {"m": "mm", "rad": "deg", "kg/m": "g/m", "Hz": "Hz", "": "%"}
    return known.get(si_unit, si_unit)
