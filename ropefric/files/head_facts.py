"""Facts in the lines above a table: `UNIT=kN`, `Sampling rate: 100 Hz`, `Abtastrate;0,1;kHz`."""

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ropefric.errors import InputError
from ropefric.quantities import spelled_unit, split_unit_suffix, unit_factor

_RATES = frozenset((
    "samplingrate", "samplerate", "samplingfrequency", "samplefrequency", "abtastrate", "abtastfrequenz", "messrate",
    "messfrequenz", "scanrate", "acquisitionrate", "loggingrate", "lograte", "recordingrate", "recordrate", "datarate",
    "aufzeichnungsrate",
))  # fmt: skip
_INTERVALS = frozenset((
    "samplinginterval", "sampleinterval", "samplingtime", "samplingtimeinterval", "abtastintervall", "messintervall",
    "logginginterval", "dt",
))  # fmt: skip
_BARE_RATES = frozenset(("speed", "rate", "frequency", "fs", "sps"))
"""Words for the sampling rate, where the time is not given and no unit contradicts."""
UNIT_WORDS = frozenset(("unit", "units", "einheit", "einheiten"))
_PER_SECOND = frozenset(("S/s", "Sa/s", "sps", "SPS", "samples/s", "Samples/s", "1/s", "/s", "Werte/s"))
_FACT = re.compile(r"[#%*;!]*+\s*+([A-Za-zÀ-ÿ][^=:;,\t]{0,60})[=:](?!=)(.+)")
_VALUE = re.compile(r"([+-]?\d++(?:[.,]\d++)?+)([^\d.,].*|)")


class Facts(NamedTuple):
    """The sampling rate that a head states, whether it says so surely, and the unit of its only column."""

    rate_Hz: float | None = None
    unit: str = ""
    is_sure: bool = True


NO_FACTS = Facts()


def is_fact(row: Sequence[str]) -> bool:
    """Return whether a row of cells is one `key=value`."""
    return len(row) == 1 and "=" in row[0] and _FACT.fullmatch(row[0]) is not None


def facts_of(lines: Sequence[str], separator: str) -> Facts:
    """Return what the lines above a table say of sampling rate and unit; the first line of each kind holds."""
    sure_Hz, perhaps_Hz, unit = None, None, ""
    for key, value in _facts(lines, separator):
        stem, of_key = split_unit_suffix(key)
        word, number = "".join(filter(str.isalpha, stem.lower())), _VALUE.fullmatch(value)
        if word in UNIT_WORDS:
            unit = unit or spelled_unit(value)
        elif number and word in _BARE_RATES:
            perhaps_Hz = perhaps_Hz or _in_si(number, of_key or "Hz", "Hz")
        elif number:
            sure_Hz = sure_Hz or _stated_rate_Hz(word, number, of_key)
    return Facts(sure_Hz or perhaps_Hz, unit, sure_Hz is not None or perhaps_Hz is None)


def _stated_rate_Hz(word: str, number: re.Match[str], of_key: str) -> float | None:
    """Return the sampling rate that a word states, or implies by an interval with its unit; None for another word."""
    if word in _RATES:
        return _in_si(number, of_key or "Hz", "Hz")
    if word in _INTERVALS and (of_key or number[2].strip()):
        step_s = _in_si(number, of_key, "s")
        return 1.0 / step_s if step_s else None
    return None


def _facts(lines: Sequence[str], separator: str) -> Iterator[tuple[str, str]]:
    for line in lines:
        cells = [cell.strip().strip('"') for cell in line.split(separator)] if separator != " " else [line]
        filled = [cell for cell in cells if cell]
        found = _FACT.fullmatch(line.strip())
        if found:
            yield found[1].strip(), found[2].strip(' \t;,"')
        elif 2 <= len(filled) <= 3 and filled[0][:1].isalpha():
            yield filled[0].rstrip(" :="), " ".join(filled[1:])


def _in_si(number: re.Match[str], unit: str, si_unit: str) -> float | None:
    """Return a number by the unit behind it, or that of its key; None where it is of another kind or not positive."""
    unit = number[2].strip().strip("[]()") or unit
    try:
        factor = 1.0 if unit in _PER_SECOND else unit_factor(spelled_unit(unit), si_unit)
    except InputError:
        return None
    value = float(number[1].replace(",", ".")) * factor
    return value if value > 0.0 else None
