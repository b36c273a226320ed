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

_AS_THEY_ARE = (
    "N kN mN kgf lbf m mm cm um in rad deg turn s ms us min Hz kHz V mV kg g lb Pa kPa MPa bar degC"
)
SUFFIX_UNITS: dict[str, str] = {unit: unit for unit in _AS_THEY_ARE.split()} | {
    "inch": "in",
    "turns": "turn",
    "h": "hour",
    **{name: name.replace("_", "/") for name in ("m_s", "kg_m", "g_m", "N_m", "N_s")},
}
"""Unit suffixes of names (`wrap_angle_deg`) and what they mean to pint."""

_SPELLINGS = {
    "N": "newton newtons", "kN": "kilonewton kilonewtons", "lbf": "lbf lb-f lb_f", "kgf": "kgf kp kg-f",
    "s": "sec secs second seconds sekunde sekunden sek", "ms": "msec msecs millisecond milliseconds",
    "min": "minute minutes",
    "V": "volt volts", "mV": "millivolt millivolts", "m": "meter meters metre metres", "kg": "kilogram kilograms",
    "mm": "millimeter millimeters millimetre", "in": "inch inches", "deg": "degree degrees", "bar": "bars",
}  # fmt: skip
_SPELT = {word: unit for unit, words in _SPELLINGS.items() for word in words.split()}


def spelled_unit(text: str) -> str:
    """Return the unit that a device meant, lbF or Newtons, as it is written here; any other text as it is."""
    return text if text in SUFFIX_UNITS.values() else _SPELT.get(text.strip(" .").lower(), text)


_USUAL: dict[str, dict[str, float]] = {
    "m": {"cm": 0.01, "mm": 1e-3, "um": 1e-6},
    "N": {"kN": 1e3, "mN": 1e-3},
    "rad": {"deg": math.pi / 180.0, "turn": math.tau},
    "s": {"ms": 1e-3, "us": 1e-6, "min": 60.0},
    "kg": {"g": 1e-3},
    "kg/m": {"g/m": 1e-3},
    "N/m": {"N/mm": 1e3, "kN/m": 1e3},
    "Pa": {"MPa": 1e6, "GPa": 1e9},
    "W": {"kW": 1e3},
    "V": {"mV": 1e-3},
    "rad/s": {"rpm": math.tau / 60.0},
    "Hz": {"kHz": 1e3},
    "m^2": {"mm^2": 1e-6},
    "": {"percent": 0.01},
}
"""Factors that nearly every file needs, so that nearly none has to wait for pint; its own, to the last bit."""

_HAS_ANGLE = {"rad": True, "rad/s": True, "Hz": False, "": False}
"""Whether units of such a quantity have an angle in them: pint takes a radian for 1, and so 25 1/s for 25 rad/s."""

_GUARDED = {"kn": "kN", "n": "N", "KN": "kN", "hz": "Hz", "khz": "kHz", "v": "V", "mpa": "MPa", "rev": "turn"}
# A gon or a gigaradian to pint, a degree to whoever writes German.
_GUARDED |= dict.fromkeys(("grad", "Grad", "GRAD"), "deg' or 'gon")
_SI_UNITS = (
    *("m", "N", "s", "V", "Pa", "kg", "m^2", "m^3", "rad", "", "Hz", "m/s", "m/s^2", "kg/m", "N/m"),
    *("N*s", "N*m", "N/s", "N/V", "V/N", "m/V", "kg/m^2", "kg/m^3", "A", "ohm", "W", "m^4", "N*m^2", "Pa/V"),
    *("rad/s", "1/m", "kg*m^2", "N*s/m"),
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
_UNIT_INSIDE = re.compile(r"([^()\[\]]+)[(\[]([^()\[\]]{1,10})[)\]]([^()\[\]]+)")
_OF_UNIT = re.compile(r"([^\s/,](?:[^/,]*[^\s/,])?)(?:\s*+[/,]\s*+|\s++in\s++)([^\s/,]{1,12})")
"""A quantity by its unit, t/s as DIN 461 writes at an axis, or its unit behind a comma."""
_LONGEST_SYMBOL = 4
"""A name of more letters may be the word for a unit."""
_TORQUE = re.compile(r"\b([mkM]?N)([cm]?m)\b")
"""Nm as engineers write it; to pint it is a unit of yarn."""
_BETWEEN_POINTS = re.compile(r"(.+?)\.{1,2}([^.]{1,12})\.")
"""`Load..N.`, as R writes `Load (N)`."""
_FULL_SCALE = re.compile(r"%\s*+(?:of\s++)?(?:FS|F\.S\.|full scale)")


@cache
def _registry() -> "pint.UnitRegistry[Any]":
    import pint  # noqa: PLC0415  (0.3 s to load, and most library calls never need a unit)

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


def split_unit_suffix(name: str) -> tuple[str, str]:
    """Return a name without its unit suffix, and the unit, empty where there is none.

    Recognises `wrap_angle_deg`, `Force (kN)`, `Force [kN]`, `Time.(s)`, `Load..N.`, `F/N`, `Force, N`, `Kraft in N`
    and `Newtons`.
    """
    text = name.strip()
    if in_brackets := _in_brackets(text):
        return in_brackets
    points = _BETWEEN_POINTS.fullmatch(text)
    if points and spelled_unit(points[2]) in SUFFIX_UNITS.values():
        return points[1], spelled_unit(points[2])
    inside = _UNIT_INSIDE.fullmatch(text)
    if inside and spelled_unit(inside[2]) in SUFFIX_UNITS.values():
        return f"{inside[1].rstrip()} {inside[3].lstrip()}", spelled_unit(inside[2])
    for suffix in _SUFFIXES:
        stem = name.removesuffix(f"_{suffix}")
        if stem and stem != name:
            return stem, SUFFIX_UNITS[suffix]
    of_unit = _OF_UNIT.fullmatch(text)
    if of_unit and (unit := spelled_unit(of_unit[2])) in SUFFIX_UNITS.values():
        is_compound = "/" in text and of_unit[1] in SUFFIX_UNITS.values()  # mm/s
        return (name, "") if is_compound else (of_unit[1], unit)
    return name, _SPELT.get(text.lower(), "") if len(text) > _LONGEST_SYMBOL else ""


def _in_brackets(text: str) -> tuple[str, str] | None:
    """Return name and unit of a text that ends with something in brackets; None if it does not."""
    body = text[:-1]
    closed, opened = max(body.rfind(")"), body.rfind("]")), max(body.rfind("("), body.rfind("["))
    if not text.endswith((")", "]")) or opened < max(closed + 1, 1):  # with a name before it
        return None
    stem = body[:opened]
    return stem.rstrip(" \t\r\n\v\f._") or stem[:1], spelled_unit(body[opened + 1 :].strip())


def unit_factor(unit: str, si_unit: str, *, name: str = "quantity") -> float:
    """Return the factor that turns a number in `unit` into SI."""
    meant = _GUARDED.get(unit, unit)
    if meant != unit:
        note = "'kn' is a knot, not a force." if unit == "kn" else f"'{unit}' is not clear as [{si_unit}]."
        raise _unreadable(name, note, f"write '{meant}'")
    asked = "percent" if unit == "%" else _TORQUE.sub(r"\1*\2", unit)
    found = 1.0 if asked == si_unit else _USUAL.get(si_unit, {}).get(asked) or _factor_by_pint(asked, si_unit)
    if isinstance(found, float):
        return found
    shown = unit if len(unit) <= _MAX_UNIT else f"{unit[:_MAX_UNIT]}..."
    message = {
        "dimension": f"'{unit}' is not a unit of {_DIMENSIONS.get(si_unit, f'[{si_unit}]')}",
        "text": f"'{shown}' is not a unit",
        "unknown": f"unknown unit '{unit}'",
    }[found]
    raise _unreadable(name, message, f"use a unit such as '{example_unit(si_unit)}'")


def is_unit_of(unit: str, si_unit: str) -> bool:
    """Return whether a unit is one of the quantity of an SI unit."""
    try:
        return bool(unit) and unit_factor(unit, si_unit) > 0.0
    except InputError:
        return False


def _unreadable(name: str, what: str, fix: str) -> InputError:
    return InputError(f"{name}: {what}", code="RF130", fix=fix)


@lru_cache(maxsize=4096)  # what is refused is kept too: a file can ask for the same nonsense in every column
def _factor_by_pint(unit: str, si_unit: str) -> float | Literal["dimension", "text", "unknown"]:
    if unit and (len(unit) > _MAX_UNIT or not _UNIT.fullmatch(unit) or _LARGE_POWER.search(unit)):
        return "text"
    import pint  # noqa: PLC0415

    registry = _registry()
    try:
        # Differences, not temperatures: no name in this package is an offset unit.
        one = registry.Quantity(1.0, unit or "")
        magnitude = float(one.to(si_unit or "").magnitude)
        has_angle = "radian" in dict(one.to_root_units().unit_items())
    except pint.DimensionalityError:
        return "dimension"
    except Exception:  # noqa: BLE001  (pint raises its own, tokenize's and assertion errors for unreadable text)
        return "unknown"
    if has_angle != _HAS_ANGLE.get(si_unit, has_angle):
        return "dimension"
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
            if error.fix.startswith("write '"):
                raise
            # Only a unit of another dimension needs another try; one that is not known stays so.
            if "is not a unit of" not in error.problem.message:
                fix = "use a unit such as 'N', 'kN', 's' or 'mm'"
                raise InputError(error.problem.message, code="RF130", fix=fix) from None
        else:
            return si_unit
    fix = "write the number in SI, without a unit"
    raise _unreadable("quantity", f"no SI unit is known for {unit!r}", fix)


def same_unit(one: str, other: str) -> bool | None:
    """Return whether two units mean one thing, a mass its weight; None where one of them is no unit that is known."""
    found = []
    for unit in (one, other):
        try:
            si_unit = si_unit_of(unit)
            factor = unit_factor(unit, si_unit)
        except InputError:
            return None
        found.append(("N", factor * unit_factor("kgf", "N")) if si_unit == "kg" else (si_unit, factor))
    (si_unit, factor), (other_si, other_factor) = found
    return si_unit == other_si and math.isclose(factor, other_factor, rel_tol=1e-6)


def scaled_by(unit: str, sensitivity: str) -> tuple[float, str]:
    """Return the factor from a signal's unit to SI by a sensitivity, 25 N/mV or 40 mV/N, and the unit it gives."""
    value, per = parse_any_quantity(sensitivity), _split(sensitivity, "", "sensitivity")[1]
    if not value or "/" not in per:
        why = "is not per signal" if value else "is zero"
        raise _unreadable("sensitivity", f"{_shown(sensitivity)} {why}", 'write it like "25 N/mV"')
    if not unit:
        raise _unreadable("signal", "it has no unit", 'write unit = "mV"')
    if si_unit_of(per) == "V/N":
        return unit_factor(unit, "V", name="signal") / value, "N"
    si_unit = si_unit_of(f"{unit}*{per}")
    return unit_factor(f"{unit}*{per}", si_unit) * float(_split(sensitivity, "", "")[0]), si_unit


def parse_quantity(text: object, si_unit: str, *, name: str = "quantity") -> float:
    """Return a quantity written with its unit as an SI float."""
    if isinstance(text, bool) or not isinstance(text, str | int | float):
        raise _unreadable(name, f"{_shown(text)} is not a quantity", f'write "1 {example_unit(si_unit)}"')
    digits, unit = _split(text, si_unit, name)
    value = float(digits)
    problem, fix = _doubt(digits, value, unit, si_unit)
    if problem:
        raise _unreadable(name, f"{_shown(text)} {problem}", fix)
    # Decimal, because 9.8 * 0.001 is not 0.0098 in binary and people compare what they wrote.
    factor = unit_factor(unit, si_unit, name=name) if unit else 1.0
    result = float(Decimal(digits) * Decimal(repr(factor))) if unit and value else value
    if not in_range(result) or (value and not result):
        bound, size = (LARGEST, "large") if abs(result) > 1.0 else (SMALLEST, "small")
        limit = f"{bound:g} {si_unit}".strip()
        what = f"{name}: {_shown(text)} is too {size}: {limit} is the limit"
        raise InputError(what, code="RF110", fix="correct the number")
    return result


def _split(text: str | float, si_unit: str, name: str) -> tuple[str, str]:
    """Return the number of a quantity and its unit, both as written."""
    if isinstance(text, int) and text.bit_length() > 1024:  # more digits than Python likes to print
        raise _unreadable(name, "the number is not a finite number", "correct the number")
    written, fix = str(text).strip(), f'write it like "1.5 {example_unit(si_unit)}"'
    if len(written) > _MAX_TEXT:
        raise _unreadable(name, f"{_shown(written)} is too long for a quantity", fix)
    match = _NUMBER.match(written)
    if match is None:
        raise _unreadable(name, f"cannot read {_shown(text)} as a number with a unit", fix)
    return match[0], written[match.end() :].strip()


def parse_any_quantity(text: str) -> float:
    """Return a quantity of any mechanical or electrical dimension in SI."""
    unit = _split(text, "", "quantity")[1]
    return parse_quantity(text, si_unit_of(unit) if unit and not unit.startswith(",") else "")


def parse_fraction(text: str) -> float:
    """Return a share written in per cent, with or without "FS" for full scale, as a fraction."""
    unit = _split(text, "", "quantity")[1] or text.strip()
    if unit != "%" and not _FULL_SCALE.fullmatch(unit):
        raise _unreadable("quantity", f"{_shown(text)} has no per-cent sign", 'write "0.02 %FS"')
    return parse_quantity(text.strip().removesuffix(unit) + "%", "")


def _shown(text: object) -> str:
    shown = repr(text)
    return shown if len(shown) <= _MAX_TEXT else f"{shown[:_MAX_UNIT]}..."


def _doubt(digits: str, value: float, unit: str, si_unit: str) -> tuple[str, str]:
    """Return the error of a number and its unit, and the fix; nothing where both are right."""
    example = example_unit(si_unit)
    if not math.isfinite(value):
        return "is not a finite number", ""
    if value == 0 and _NOT_ZERO.search(digits.lower().partition("e")[0]):
        return "is out of range: too small for a float", ""
    if not unit and si_unit:
        return "has no unit", f'write it with one, for example "{digits} {example}"'
    if unit.startswith(","):
        return "has a decimal comma", "write a decimal point, as TOML does"
    if "," in unit or ".." in unit:
        return "is more than one quantity", f'give one, such as "{digits} {example}", or a list of such texts'
    return "", ""


_DIMENSIONS = {
    "m": "length", "N": "force", "rad": "angle", "s": "time", "Hz": "frequency", "V": "voltage",
    "kg/m": "mass per length", "kg": "mass", "rad/s": "rotation", "m/s": "speed", "N/m": "stiffness", "N m": "torque",
    "": "a bare ratio",
}  # fmt: skip


def example_unit(si_unit: str) -> str:
    """Return a unit that people write such quantities in."""
    known = {"m": "mm", "rad": "deg", "rad/s": "rpm", "kg/m": "g/m", "": "%"}
    return known.get(si_unit, si_unit)
