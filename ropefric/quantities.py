"""Units at the edge: text with a unit in, SI floats out.

Inside ropefric every number is SI (and radians) and its name says so. This is the only module that knows
other units, and the only importer of pint, which it loads on first use.
"""

import math
import re
from decimal import Decimal
from functools import cache
from typing import TYPE_CHECKING, Any

from ropefric.errors import InputError

if TYPE_CHECKING:
    import pint

__all__ = ["SUFFIX_UNITS", "parse_quantity", "split_unit_suffix", "unit_factor"]

SUFFIX_UNITS: dict[str, str] = {
    "N": "N",
    "kN": "kN",
    "mN": "mN",
    "kgf": "kgf",
    "lbf": "lbf",
    "m": "m",
    "mm": "mm",
    "cm": "cm",
    "um": "um",
    "in": "in",
    "inch": "in",
    "rad": "rad",
    "deg": "deg",
    "turn": "turn",
    "turns": "turn",
    "s": "s",
    "ms": "ms",
    "us": "us",
    "min": "min",
    "h": "hour",
    "Hz": "Hz",
    "kHz": "kHz",
    "V": "V",
    "mV": "mV",
    "kg": "kg",
    "g": "g",
    "lb": "lb",
    "Pa": "Pa",
    "kPa": "kPa",
    "MPa": "MPa",
    "bar": "bar",
    "degC": "degC",
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
_ENDLESS = re.compile(r"\d{3}|(\^|\*\*)[\s(]*[-+]?[\d.]+\s*(\^|\*\*)|\d\s*(\^|\*\*)|(\^|\*\*)\s*\(")
_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*$", re.DOTALL)


@cache
def _registry() -> "pint.UnitRegistry[Any]":
    import pint  # noqa: PLC0415  (0.3 s to load, and most library calls never need a unit)

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


def split_unit_suffix(name: str) -> tuple[str, str]:
    """Return a name without its unit suffix, and the unit, empty where there is none.

    Recognises `wrap_angle_deg`, `Force (kN)`, `Force [kN]`, `Time.(s)`.

    Parameters
    ----------
    name : str
        A column header or key.

    Returns
    -------
    tuple of str
        The bare name and a unit that `unit_factor` understands, or "".

    Examples
    --------
    >>> split_unit_suffix("wrap_angle_deg")
    ('wrap_angle', 'deg')
    >>> split_unit_suffix("Force (kN)")
    ('Force', 'kN')
    >>> split_unit_suffix("file")
    ('file', '')
    """
    bracket = re.fullmatch(r"\s*(.+?)[\s._]*[(\[]\s*([^)\]]*?)\s*[)\]]\s*", name)
    if bracket:
        return bracket[1], bracket[2]
    for suffix in sorted(SUFFIX_UNITS, key=len, reverse=True):
        stem = name.removesuffix(f"_{suffix}")
        if stem and stem != name:
            return stem, SUFFIX_UNITS[suffix]
    return name, ""


def unit_factor(unit: str, si_unit: str, *, name: str = "quantity") -> float:
    """Return the factor that turns a number in `unit` into SI.

    Parameters
    ----------
    unit : str
        The unit as people write it: "mm", "kN", "deg", "1/min".
    si_unit : str
        The SI unit wanted: "m", "N", "rad", "s"; "" for a dimensionless number.
    name : str
        What is being converted, for the message.

    Raises
    ------
    InputError
        If the unit is unknown or of another dimension; the message shows a unit that works.

    Examples
    --------
    >>> unit_factor("kN", "N")
    1000.0
    >>> unit_factor("kn", "N", name="full scale")
    Traceback (most recent call last):
    ...
    ropefric.errors.InputError: full scale: 'kn' is a knot, not a force. Fix: write 'kN'
    """
    meant = _GUARDED.get(unit)
    if meant is not None and meant != unit:
        note = "'kn' is a knot, not a force." if unit == "kn" else f"'{unit}' is not a unit of [{si_unit}]."
        raise InputError(f"{name}: {note}", code="RF130", fix=f"write '{meant}'")
    return _factor(unit, si_unit, name)


@cache
def _factor(unit: str, si_unit: str, name: str) -> float:
    usual = _USUAL.get((unit, si_unit))
    return _factor_by_pint(unit, si_unit, name) if usual is None else usual


def _factor_by_pint(unit: str, si_unit: str, name: str) -> float:
    import pint  # noqa: PLC0415

    registry = _registry()
    try:
        # Differences, not temperatures: no name in this package is an offset unit.
        magnitude = float(registry.Quantity(1.0, unit or "").to(si_unit or "").magnitude)
    except pint.DimensionalityError:
        raise InputError(
            f"{name}: '{unit}' is not a unit of {_dimension(si_unit)}",
            code="RF130",
            fix=f"use a unit such as '{_example_unit(si_unit)}'",
        ) from None
    except Exception as error:  # pint raises its own, tokenize's and assertion errors for unreadable text
        if isinstance(error, KeyboardInterrupt | SystemExit):
            raise
        raise InputError(
            f"{name}: unknown unit '{unit}'",
            code="RF130",
            fix=f"use a unit such as '{_example_unit(si_unit)}'",
        ) from None
    # Exact decimal factors survive only if the rounding of pint's own chain is taken off; angles have none.
    return magnitude if "rad" in si_unit else float(f"{magnitude:.15g}")


def parse_quantity(text: object, si_unit: str, *, name: str = "quantity") -> float:
    """Return a quantity written with its unit as an SI float.

    Parameters
    ----------
    text : str or number
        "40 mm", "540 deg", "0.3 %". A bare number is accepted only for a dimensionless quantity.
    si_unit : str
        The SI unit wanted; "" for a dimensionless number.
    name : str
        What is being read, for the message.

    Returns
    -------
    float
        The value in `si_unit`, finite.

    Raises
    ------
    InputError
        For a bare number where a unit is needed, an unknown unit, a unit of another dimension, or text
        that is no quantity; the message shows how to write it.

    Examples
    --------
    >>> parse_quantity("40 mm", "m")
    0.04
    >>> parse_quantity(40, "m", name="radius")
    Traceback (most recent call last):
    ...
    ropefric.errors.InputError: radius: 40 has no unit Fix: write it with one, for example "40 mm"
    """
    if isinstance(text, bool) or not isinstance(text, str | int | float):
        raise InputError(
            f"{name}: {text!r} is not a quantity", code="RF130", fix=f'write "1 {_example_unit(si_unit)}"'
        )
    match = _NUMBER.match(str(text))
    if match is None:
        raise InputError(
            f"{name}: cannot read {text!r} as a number with a unit",
            code="RF130",
            fix=f'write it like "1.5 {_example_unit(si_unit)}"',
        )
    value, unit = float(match[1]), match[2]
    problem, fix = _doubt(match[1], value, unit, si_unit)
    if problem:
        raise InputError(f"{name}: {text!r} {problem}", code="RF130", fix=fix)
    if unit == "%":
        unit = "percent"
    if not unit:
        return value
    factor = unit_factor(unit, si_unit, name=name)
    # Decimal, because 9.8 * 0.001 is not 0.0098 in binary and people compare what they wrote.
    result = float(Decimal(match[1]) * Decimal(repr(factor)))
    if not math.isfinite(result):
        raise InputError(f"{name}: {text!r} is too large for a float", code="RF130")
    return result


def _doubt(digits: str, value: float, unit: str, si_unit: str) -> tuple[str, str]:
    """Return what is wrong with a number and its unit as they stand, and the fix; nothing where all is well."""
    example = _example_unit(si_unit)
    if not math.isfinite(value):
        return "is not a finite number", ""
    if value == 0 and re.search("[1-9]", re.split("[eE]", digits)[0]):
        return "is out of range: too small for a float", ""
    if len(unit) > 40 or _ENDLESS.search(unit):
        # pint computes powers before it asks whether they make sense: "9**9**9**9" would never end.
        return "is no quantity: what follows the number is no unit", f"use '{example}'"
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
